// SPDX-License-Identifier: MIT
// The calibration's own model of the exhaust: what each position of the wheel lets through, and how fast the manifold
// empties. Knows the engine file and nothing of the plant.
#pragma once
#include <array>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "common/engine_file.hpp"
extern "C" {
#include "sd_afr.h"
}

namespace sixdeg {

/// One operating point of the AFR blocks (firmware/afr).
struct ExhaustPoint {
    std::vector<double> share; ///< Of a cylinder's gas, by wheel position from firing TDC on, over a cycle; the rest stays.
    double charge_kg = 0;      ///< Of one cylinder and cycle, fuel included.
    double rate_hz = 0;        ///< Turbine area sqrt(R T)/manifold volume.
    double z0_kg = 0;          ///< In the manifold at ambient pressure.
    double mean_kg = 0;        ///< In the manifold, mean over the cycle.
    double transport_kg = 0;   ///< Gas between turbine and sensor.
    double air_kg = 0;         ///< Of the charge, with what stayed from the last.
    ExhaustReading reading{};  ///< What a test bench would read here.
};

/// The model, trimmed to the readings of the engine file. engine.exhaust is set; the engine must outlive it.
class TrimmedExhaust {
  public:
    explicit TrimmedExhaust(const EngineFile &engine);
    /// Periodic flow at a constant speed, with fuel for `lambda` of document 004 in the exhaust.
    ExhaustPoint point(double speed_radps, double intake_pa, double lambda) const;

    struct Turn;

  private:
    const EngineFile &engine_;
    std::shared_ptr<const Turn> turn_;
    Eigen::Matrix<double, 4, 3> plane_ = Eigen::Matrix<double, 4, 3>::Zero();
};

/// One point of it.
ExhaustPoint exhaust_point(const EngineFile &engine, double speed_radps, double intake_pa, double lambda);

/// The grid for the calibration page; not present without engine.exhaust.
sd_afr_grid_t afr_grid(const EngineFile &engine);

/// psi(1 + k/32), k = 0 to 32, of sd_exhaust.h.
std::array<double, 33> exhaust_psi();

} // namespace sixdeg
