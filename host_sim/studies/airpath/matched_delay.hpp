// SPDX-License-Identifier: MIT
// How soon the diagnosis names a fault on the matched plant, and what bounds that.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "studies/airpath/matched_run.hpp"

namespace sixdeg {

struct DelayFigures {
    double mean_s = 0, sd_s = 0, p95_s = 0; ///< sd: of the mean.
    double time_error_s = 0; ///< Mean of the fault's time as estimated at the alarm, minus the true one.
    int named = 0;           ///< Runs that name the right actuator first.
    int wrong = 0;           ///< Runs whose first word is another, or "unclear".
    int early = 0;           ///< Runs left out: an alarm before the fault.
    int missed = 0;          ///< Nothing within 3 s.
};
DelayFigures measure_delay(const MatchedSetup &setup, const MatchedFault &fault, double threshold, int runs, std::uint64_t seed);

/// Without noise: each residual's mean over the steps after a fault, and what it leaves in the end, kPa.
struct FaultTrace {
    std::vector<std::array<double, 2>> residual;
    std::array<double, 2> end_kpa;
};
FaultTrace trace_fault(const MatchedSetup &setup, const MatchedFault &fault);

/// kappa of document 001's (29) and the delay it gives, threshold over kappa; s.
double formula_delay_s(const MatchedSetup &setup, const MatchedFault &fault, double threshold);

/// Bound in G. Lorden's sense, 1971: the least mean delay, the worst past assumed, of any rule with a mean time of `mean_time_s` between
/// false alarms. A CUSUM of all that is known attains it; of a Brownian motion with information I a step its threshold h and the
/// information s that it waits for obey  exp(h) - h - 1 = I mean time,  s = h - 1 + exp(-h)  (A. Shiryaev, 1996). I: of the shift in the
/// end of the innovations of a Kalman filter that knows plant and noise; the bound is the time in which its sum reaches s.
double lorden_delay_s(const MatchedSetup &setup, const MatchedFault &fault, double mean_time_s);

/// Healthy residuals: time_s,residual_1_kpa,residual_2_kpa.
std::string residuals_csv(const MatchedSetup &setup, double seconds, std::uint64_t seed);

} // namespace sixdeg
