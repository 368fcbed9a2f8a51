// SPDX-License-Identifier: MIT
// Volume of a cylinder over its crank angle, for the calibration's own models.
#pragma once
#include <cmath>

#include "common/engine_file.hpp"

namespace sixdeg {

class SliderCrank {
  public:
    explicit SliderCrank(const EngineFile &engine, double compression_factor = 1)
        : area(M_PI / 4 * engine.bore_m * engine.bore_m),
          clearance(area * engine.stroke_m / (engine.compression_ratio * compression_factor - 1)),
          crank_(engine.stroke_m / 2), rod_(engine.rod_m) {}

    /// m3; angle from TDC, rad.
    double volume(double angle) const {
        const double s = crank_ * std::sin(angle);
        return clearance + area * (crank_ * (1 - std::cos(angle)) + rod_ - std::sqrt(rod_ * rod_ - s * s));
    }
    double volume_slope(double angle) const {
        const double s = crank_ * std::sin(angle);
        return area * (s + s * crank_ * std::cos(angle) / std::sqrt(rod_ * rod_ - s * s));
    }

    const double area, clearance; ///< m2, m3.

  private:
    double crank_, rod_;
};

} // namespace sixdeg
