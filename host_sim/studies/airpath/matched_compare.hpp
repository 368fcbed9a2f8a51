// SPDX-License-Identifier: MIT
// Other residuals than the bank's on the matched plant, decided on by the same CUSUM at the same rate of false alarms.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "studies/airpath/matched_run.hpp"

namespace sixdeg {

struct MethodFigures {
    std::string name;
    double threshold = 0;                ///< At which healthy running gives one alarm in `alarm_s`.
    std::array<double, 4> delay_s{};     ///< Mean, of matched_faults().
    std::array<double, 4> right_percent{};
};

/// The bank; an observer of the intake pressure and one of the mass that EGR leaves alone, fed with measured outputs (scalar output
/// injection); a Kalman filter with both flows' errors as states (augmented EKF).
std::vector<MethodFigures> compare_methods(const MatchedSetup &setup, double healthy_s, double alarm_s, int runs, std::uint64_t seed);

} // namespace sixdeg
