// SPDX-License-Identifier: MIT
// The AFR blocks on a trace of the plant, away from the rest of the firmware: many seeds in little time.
// Definitions: docs/results/afr.md.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "design/afr/exhaust_tables.hpp"
#include "studies/afr/afr_trace.hpp"
extern "C" {
#include "sd_afr_delay.h"
}

namespace sixdeg {

/// How far the calibration is off, for perturbed figures.
struct AfrError {
    double flow = 0;      ///< Of the charge and so of the valves' flow, share.
    double tau = 0;       ///< Of the sensor's lags, share.
    double delay_deg = 0; ///< Crank.
    double turbine = 0;   ///< Of its area, share.
};

/// joint_fixed: with gains by position instead of its own covariance.
enum class AfrMethod { joint, joint_fixed, fourier, oscillator, true_gas };

struct AfrSetup {
    AfrMethod method = AfrMethod::joint;
    double drift = 0.006, jump = 0.2; ///< Of the joint filter, of the mean lambda.
    double noise = 0.005;             ///< rms of lambda a position, what the filter is told.
    double usual_sd = 0.02;           ///< How cylinders differ beside the one to blame, of the mean lambda.
    double usual_mean_sd = 0.01;      ///< How far the mean of all may move in some ten cycles by itself, of the mean lambda.
    double mean_lambda = 1;
    double gain_air = 0.1, gain_cylinder = 4;           ///< A
    int harmonics = 2;                                  ///< D
    double inversion_gain = 0.03, inversion_floor = 0.1; ///< D by the Fourier law
    double oscillator_drift = 0.005;                    ///< D as oscillators, beside `noise`
    double egr_share = 0; ///< Of the manifold's outflow, what B is told, [0, 1).
    AfrError error;
    sd_afr_learned_t known{}; ///< How well delay and lags are known; goes into what is stated.
    double gain_mass = 0;     ///< L1; above 0 the pressure in the manifold is measured.
    bool fixed_point = false; ///< The chain in q31.
};

/// The lane that being off alone explains best, from the differences alone and with the mean lambda of the cycles before.
struct AfrBlamed {
    int alone, with_mean;
};

struct AfrEstimates {
    std::vector<std::array<double, 8>> lambda; ///< By lane, at the end of each cycle.
    std::vector<double> sd;                    ///< Stated, of lane 0's deviation from the mean; not by block A alone.
    std::vector<AfrBlamed> blamed;             ///< Joint filter only.
};

/// Runs one method over the trace; `noise` is added to its samples (same length, or empty for none).
AfrEstimates afr_estimate(const EngineFile &engine, const ExhaustPoint &point, const AfrTrace &trace,
                          const AfrSetup &setup, const std::vector<double> &noise);

/// What the delay kernel learns from a probe: the trace's fuel was changed by these trims, by lane, from the start of each cycle
/// of 120 positions on (as a share); one that is not 0 begins it.
sd_afr_learned_t afr_delay_probe(const EngineFile &engine, const ExhaustPoint &point, const AfrTrace &trace, const AfrSetup &setup,
                           const std::vector<double> &noise, const std::vector<std::array<double, 8>> &trims);

/// White (correlation_s 0) or first-order noise with the density of white noise of `rms` a position.
std::vector<double> sensor_noise(const AfrTrace &trace, double rms, double correlation_s, std::uint64_t seed);

/// Least standard deviation (Cramer-Rao), of lambda, of a cylinder's deviation from the mean after `cycles`,
/// white noise; unknown: all cylinders and the filter's other states at the start.
double afr_bound(const EngineFile &engine, const ExhaustPoint &point, const AfrTrace &trace, double noise_rms,
                 int cycles);

} // namespace sixdeg
