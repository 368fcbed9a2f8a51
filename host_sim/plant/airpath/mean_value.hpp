// SPDX-License-Identifier: MIT
// The four-state mean-value model of B. Boulkroune and others, "Actuator fault diagnosis with application to a diesel engine testbed", 2015
// (document 001), as a plant: what its observers believe is true of it. The structure is M. Nyberg and T. Stutte's, 2004; the two flows are
// those of J. Wahlstrom and L. Eriksson, 2011. It shares no code with the firmware.
//
//   p'  = kappa (R_air T_charge W_air + R_exhaust T_egr W_egr) / V_intake - kappa k p,     k = efficiency V_displaced N / (120 V_intake)
//   ma' = W_air - k ma,  me' = W_egr - k me,  mx' = k (ma + me) + W_fuel - W_egr - W_t
#pragma once
#include <array>

#include "common/air_path.hpp"

namespace sixdeg {

struct MeanValueInput {
    double speed_radps = 0, air_kgps = 0, fuel_kgps = 0;
    double egr_opening = 0, vgt_position = 0; ///< True ones, cut to [0, 1].
};

struct MeanValueFlows {
    double egr_kgps, turbine_kgps;
};

class MeanValueModel {
  public:
    MeanValueModel(const AirPathSystem &system, double displaced_m3) : system_(system), displaced_m3_(displaced_m3) {}

    /// Measured ones from now on, in place of the usual ones of the engine file.
    void set_temperatures(double charge_k, double egr_k, double exhaust_k) {
        system_.charge_k = charge_k, system_.egr_k = egr_k, system_.exhaust_k = exhaust_k;
    }
    /// Rests at this input: the turbine takes what comes in.
    void rest(const MeanValueInput &input);
    /// dt_s, up to 2 ms, by Runge-Kutta of fourth order; the input is held.
    void step(const MeanValueInput &input, double dt_s);

    double intake_pa() const { return x_[0]; }
    double exhaust_pa() const { return exhaust_pa(x_[3]); }
    double air_kg() const { return x_[1]; }
    double egr_kg() const { return x_[2]; }
    double exhaust_kg() const { return x_[3]; }
    double emptying_ps(double speed_radps) const;
    MeanValueFlows flows(const MeanValueInput &input, double intake_pa, double exhaust_pa) const;

  private:
    using State = std::array<double, 4>;
    double exhaust_pa(double kg) const;
    State rate(const MeanValueInput &input, const State &x) const;

    AirPathSystem system_;
    double displaced_m3_;
    State x_{};
};

} // namespace sixdeg
