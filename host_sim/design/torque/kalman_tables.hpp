// SPDX-License-Identifier: MIT
// From torques over crank angle to the tables of the filter on tooth times (sd_kalman.h).
#pragma once
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "design/torque/kalman_design.hpp"
#include "common/engine_file.hpp"
extern "C" {
#include "sd_kalman.h"
}

namespace sixdeg {

/// Nm at a crank angle in rad; 720 deg periodic, 0 = firing TDC of firing_order[0].
using TorqueOverAngle = std::function<double(double)>;

/// What the filter is told of the engine's torque.
struct KnownTorque {
    std::vector<TorqueOverAngle> basis;   ///< One for each coefficient but the constant.
    std::vector<TorqueOverAngle> motored_per_bar; ///< Of each entry of firing_order, Nm per bar of intake pressure.
    std::vector<TorqueOverAngle> motored;         ///< The part that does not scale with it.
    TorqueOverAngle exponent; ///< What a larger exponent of compression adds to all of them, Nm per bar; empty: it is not learned.
    std::vector<TorqueOverAngle> shape; ///< How the pulse of each entry of firing_order bends; empty: it keeps its shape.
    bool firings = true;                  ///< basis[i] is the pulse of firing_order[i].
};

/// What it is made for, SI.
struct KalmanTune {
    double edge_deg = 0.02;       ///< Timing error of an edge, the timer's rounding not included.
    double load_walk_nm = 0.1;    ///< Change of the constant torque from tooth to tooth.
    double firing_torque_change_nm = 10; ///< Change of a firing's torque from one cycle to the next.
    double rough_walk_nm = 3;     ///< load_walk_nm of the second set of gains, for rough roads; 0: no second set.
    double basis_walk_nm = 0.2;   ///< Change of other coefficients from tooth to tooth, and of shape times mean torque.
    std::vector<double> speeds_rpm{1000, 2000, 4000, 6500};
};

struct KalmanTables {
    sd_kalman_tables_t tables;
    std::vector<PeriodicGains> gains; ///< Of each speed of each set.
    double radius_between = 0;        ///< Largest cycle radius a quarter, half and three quarters of the way between two speeds of a set.
};

/// The constant inertia that takes as long over the interval before tooth k. Its difference from J in the middle is a
/// few parts in 1e5, which at 3000 rpm is as much energy as 0.4 Nm give in a firing interval.
double interval_inertia_kgm2(const EngineFile &engine, int k);
/// J_mean of all that turns: what normalised torques are over, times speed squared.
double mean_inertia_kgm2(const EngineFile &engine);
/// Basis and inertia over the wheel's teeth and the crank's modes at a speed, without gains.
ToothModel tooth_model(const EngineFile &engine, const KnownTorque &torque, double speed_radps);
ToothNoise tooth_noise(const EngineFile &engine, const KalmanTune &tune, double speed_radps);

/// Torques over the interval that ends at each cycle position: mean, and moment as sd_kalman.h has it, [2 N][torque].
std::pair<Eigen::MatrixXd, Eigen::MatrixXd> interval_tables(const EngineFile &engine, const std::vector<TorqueOverAngle> &torques);

/// Throws InputError naming the engine file and `wheel` where the tables do not fit in the firmware's pool.
KalmanTables kalman_tables(const EngineFile &engine, const KnownTorque &torque, const KalmanTune &tune);

/// All of them together.
TorqueOverAngle sum_of(const std::vector<TorqueOverAngle> &torques);

} // namespace sixdeg
