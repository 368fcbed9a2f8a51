// SPDX-License-Identifier: MIT
// A pressure sensor in the exhaust manifold: one lag, noisy, sampled.
#pragma once
#include <cmath>
#include <deque>

#include "common/random.hpp"

namespace sixdeg {

/// SCENARIO.toml, [exhaust_sensors].
struct ExhaustSensorSetup {
    double sample_s = 0.5e-3;  ///< Of the pressure.
    double noise_pa = 0;       ///< rms of a sample.
    double lag_s = 0.2e-3;
    bool temperature = false;  ///< The gas in the manifold's is read as well,
    bool turbine_speed = false; ///< and the turbocharger's speed.
};

struct PressureSample {
    double time_s, pascal;
};

namespace exhaust {

class PressureSensor {
  public:
    PressureSensor(const ExhaustSensorSetup &setup, RandomStream random) : setup_(setup), random_(random) {}

    void start(double time_s, double pascal) { seen_ = pascal, next_s_ = time_s; }

    /// The pressure over the step that ends at time_s; samples due within it go to `out`.
    void step(double time_s, double dt_s, double pascal, std::deque<PressureSample> &out) {
        seen_ += (pascal - seen_) * (1 - std::exp(-dt_s / setup_.lag_s));
        for (; next_s_ <= time_s; next_s_ += setup_.sample_s)
            out.push_back({next_s_, seen_ + (setup_.noise_pa > 0 ? setup_.noise_pa * random_.normal() : 0)});
    }

  private:
    ExhaustSensorSetup setup_;
    RandomStream random_;
    double seen_ = 0, next_s_ = 0;
};

} // namespace exhaust
} // namespace sixdeg
