// SPDX-License-Identifier: MIT
// How far estimates of cylinders' lambda are off, and how far they say they are.
#pragma once
#include <vector>

#include "studies/afr/afr_case.hpp"

namespace sixdeg::afr_study {

/// Points: 0.01 of the mean lambda.
struct Errors {
    double rms = 0;        ///< Over cylinders and cycles once settled.
    double first = 0;      ///< Over cylinders, first reading so many cycles after the step.
    double deviations = 0; ///< Of deviations from the mean, once settled, rms,
    double stated = 0;     ///< and what was stated of them.
};

Errors errors_of(const Run &run, const Case &c, const AfrEstimates &e);
/// One entry a seed of the sensor's noise (and, `perturbed`, of what the calibration is off by).
std::vector<Errors> errors_of_seeds(const Run &run, AfrSetup setup, const Case &c, double correlation_s, bool perturbed,
                                    int seeds, const Probe *probe = nullptr);
/// Of one figure over the seeds; p in [0, 1].
double percentile(const std::vector<Errors> &all, double Errors::*what, double p);
double rms(const std::vector<Errors> &all, double Errors::*what);

} // namespace sixdeg::afr_study
