// SPDX-License-Identifier: MIT
// The wideband sensor: second order, sensitive to pressure, noisy, sampled, quantised.
#pragma once
#include <cmath>
#include <deque>

#include "common/random.hpp"

namespace sixdeg {

/// Faults and electronics of one sensor (SCENARIO.toml, [uego]); its two lags are the engine file's.
struct UegoSetup {
    double sample_s = 0.5e-3;
    double noise_per_rthz = 0;   ///< One-sided density of the noise at low frequency, of lambda.
    double correlation_s = 0;    ///< Of the noise; 0 is white up to half the sampling rate.
    double pressure_per_bar = 0; ///< Measured air fraction grows by this share per bar over 1.013 bar.
    bool before_turbine = false; ///< Its tip is at the manifold's pressure; else at that behind the turbine.
    double step = 0;             ///< Quantisation, of lambda; 0 none.
    double ageing = 1;           ///< Factor on both lags.
};

struct UegoSample {
    double time_s, lambda;
};

namespace exhaust {

class Uego {
  public:
    Uego(const UegoSetup &setup, double tau1_s, double tau2_s, RandomStream random)
        : setup_(setup), tau1_(tau1_s * setup.ageing), tau2_(tau2_s * setup.ageing), random_(random) {}

    void start(double time_s, double air_fraction) {
        lag1_ = lag2_ = in_ = 1 - air_fraction;
        next_s_ = time_s;
        drift_ = 0;
    }

    /// The gas at the tip over the step that ends at time_s; samples due within it go to `out`.
    void step(double time_s, double dt_s, double air_fraction, double pressure_pa,
              std::deque<UegoSample> &out) {
        const double seen = 1 - air_fraction * (1 + setup_.pressure_per_bar * (pressure_pa / 1e5 - 1.013));
        const double before = lag2_;
        advance(dt_s, (seen - in_) / dt_s);
        in_ = seen;
        for (; next_s_ <= time_s; next_s_ += setup_.sample_s) {
            const double back = (time_s - next_s_) / dt_s; // straight within the step
            out.push_back({next_s_, quantised(lag2_ + (before - lag2_) * std::fmin(back, 1.0) + noise())});
        }
    }

    double lambda() const { return lag2_; }

  private:
    // Exact for an input that runs straight over the step, through two lags of different time constants.
    void advance(double dt, double slope) {
        const double e1 = std::exp(-dt / tau1_), e2 = std::exp(-dt / tau2_);
        // lag1 = in + slope (t - tau1) + c1 exp(-t/tau1); lag2 follows by the same rule, driven by its three
        // terms.
        const double c1 = lag1_ - in_ + slope * tau1_;
        const double share = tau1_ / (tau1_ - tau2_);
        const double c2 = lag2_ - in_ + slope * (tau1_ + tau2_) - share * c1;
        lag1_ = in_ + slope * (dt - tau1_) + c1 * e1;
        lag2_ = in_ + slope * (dt - tau1_ - tau2_) + share * c1 * e1 + c2 * e2;
    }

    double noise() {
        if (setup_.noise_per_rthz <= 0) return 0;
        const double draw = random_.normal();
        if (setup_.correlation_s <= 0) return draw * setup_.noise_per_rthz / std::sqrt(2 * setup_.sample_s);
        const double keep = std::exp(-setup_.sample_s / setup_.correlation_s);
        const double sd = setup_.noise_per_rthz / std::sqrt(4 * setup_.correlation_s);
        drift_ = keep * drift_ + sd * std::sqrt(1 - keep * keep) * draw;
        return drift_;
    }
    double quantised(double x) const {
        return setup_.step > 0 ? setup_.step * std::round(x / setup_.step) : x;
    }

    UegoSetup setup_;
    double tau1_, tau2_;
    RandomStream random_;
    double in_ = 0, lag1_ = 0, lag2_ = 0, drift_ = 0, next_s_ = 0;
};

} // namespace exhaust
} // namespace sixdeg
