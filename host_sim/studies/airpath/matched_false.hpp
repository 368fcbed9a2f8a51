// SPDX-License-Identifier: MIT
// False alarms of the diagnosis, counted and by importance sampling.
#pragma once
#include <cstdint>
#include <vector>

#include "studies/airpath/matched_run.hpp"

namespace sixdeg {

struct FalseAlarms {
    int alarms = 0;
    double hours = 0;
};
/// Runs without a fault; each alarm ends its run.
FalseAlarms count_false_alarms(const MatchedSetup &setup, double threshold, double hours, std::uint64_t seed);

/// Alarms an hour at a threshold, and the standard deviation of that figure.
struct AlarmRate {
    double threshold, per_hour, sd;
};
/// Every alarm of a hypothesis lies in one excursion of its sum from 0. From the start of an excursion a copy of plant and bank goes on
/// with noise whose mean is shifted towards the hypothesis, until the sum is back at 0; where it passes a threshold on the way, named and
/// isolated, the likelihood ratio of its noise is what it counts. `hours` of healthy running give the starts.
std::vector<AlarmRate> sample_alarm_rates(const MatchedSetup &setup, const std::vector<double> &thresholds, double hours,
    std::uint64_t seed);

/// The smallest threshold of a table at which alarms are at most so many an hour, between its entries; 0 where none is.
double threshold_for(const std::vector<AlarmRate> &rates, double per_hour);

} // namespace sixdeg
