// SPDX-License-Identifier: MIT
// What the filter on tooth times reads wrong because the calibration does not know the engine exactly. Each thing that is
// not known, a standard deviation away, is a torque that the model lacks, the same in every cycle; the filter's own gains
// make of it an error of each firing (steady_reading). These errors are independent of each other: squares add up.
#pragma once
#include "design/torque/kalman_tables.hpp"

namespace sixdeg {

/// One of them, a standard deviation away, over each interval: mean and moment, [2 N][entry of firing_order].
struct ModelDoubt {
    std::string name;
    Eigen::MatrixXd pulse_mean, pulse_moment;     ///< For a mean combustion torque of 1.
    Eigen::MatrixXd motored_mean, motored_moment; ///< Nm for each bar of charge.
    bool common = true;                           ///< The same in all cylinders; else of each by itself.
    double scale = 0;                             ///< Share of each firing's torque that is read too much, beside that.
    bool spread_only = false;                     ///< Grows with a cylinder's difference from the mean of all.
};

/// What is not known: the engine file's tolerance, and the load that the one pulse of the calibration is not made for.
std::vector<ModelDoubt> model_doubts(const EngineFile &engine);

struct GainsAt {
    ToothModel model; ///< At a speed.
    Eigen::MatrixXd gain;
};

/// Standard deviations of a firing less the mean of all, rms over the cylinders; of an engine of one cylinder, of the firing itself.
struct ModelError {
    double mean_share = 0;         ///< Of the mean torque of all cylinders.
    double spread_share = 0;       ///< Of the rms of the cylinders' differences from it.
    double charge_nm_per_bar = 0;  ///< Of the charge,
    double learned_nm_per_bar = 0; ///< and of that what is left when the zeros were learned at another speed.
};

/// What each doubt's motored torque makes the firings read while the pulses' shape stands still, as in fuel cut: [firing][cylinder].
std::vector<Eigen::MatrixXd> zeros_learned(const std::vector<ModelDoubt> &doubts, GainsAt at);

/// What the mean of all cylinders reads in fuel cut, for each bar of charge, Nm: standard deviation from all doubts, and by an exponent of
/// compression that is larger by 1.
struct FuelCutPrior {
    double sd_nm_per_bar = 0, exponent_nm_per_bar = 0;
};
/// At 1500 rpm; it hardly depends on speed.
FuelCutPrior fuel_cut_prior(const EngineFile &engine, const KnownTorque &torque, const KalmanTune &tune);

ModelError model_error(const EngineFile &engine, const KnownTorque &torque, const std::vector<ModelDoubt> &doubts, const GainsAt &here,
                       const std::vector<Eigen::MatrixXd> &zeros);

} // namespace sixdeg
