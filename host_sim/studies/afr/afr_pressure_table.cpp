// SPDX-License-Identifier: MIT
// The document's chain with and without a pressure sensor in the exhaust manifold, and a calibration that is wrong about the
// turbine's area (docs/theory/afr.md).
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "studies/afr/afr_errors.hpp"
#include "studies/afr/afr_parts.hpp"

namespace sixdeg::afr_study {
namespace {

constexpr double kGainMass = 0.1; // the parameter's default

AfrSetup setup(const Run &run, const Case &c, double area, bool sensor, bool fixed_point) {
    AfrSetup s = setup_for(run, c);
    s.method = AfrMethod::fourier, s.fixed_point = fixed_point, s.error.turbine = area, s.gain_mass = sensor ? kGainMass : 0;
    return s;
}

/// Largest difference of two estimates in the end, points.
double apart(const Run &run, const AfrEstimates &a, const AfrEstimates &b) {
    double most = 0;
    for (std::size_t i = 0; i < kLanes; ++i) most = std::max(most, std::abs(a.lambda.back()[i] - b.lambda.back()[i]));
    return 100 * most / run.mean;
}

} // namespace

void pressure() {
    const std::vector<Case> cases{{"1500/9", 1500, 9, 30, 15, 0.005, 10}, {"2500/9", 2500, 9, 30, 15, 0.005, 10},
                                  {"1000/3", 1000, 3, 30, 15, 0.005, 10}};
    fmt::print("\npressure in the manifold, Fourier law, +20 % on cylinder 1, noise free: cycles until every error is in 20 % of the step; "
               "the largest then left, points; what the wrong area makes of it, points\n{:<34}", "turbine area, sensor");
    std::vector<Run> runs;
    for (const Case &c : cases) runs.emplace_back(c, 20), fmt::print("{:>24}", c.name);
    for (bool fixed_point : {false, true}) {
        for (double area : {0.0, -0.2, 0.2}) {
            for (bool sensor : {false, true}) {
                fmt::print("\n{:<34}", fmt::format("{} {:+.0f} %, {}", fixed_point ? "q31" : "f32", 100 * area,
                                                   sensor ? "with" : "without"));
                for (std::size_t i = 0; i < cases.size(); ++i) {
                    const AfrEstimates e = runs[i].run(setup(runs[i], cases[i], area, sensor, fixed_point));
                    const AfrEstimates right = runs[i].run(setup(runs[i], cases[i], 0, sensor, fixed_point));
                    fmt::print("{:8.1f}{:8.2f}{:8.3f}", runs[i].band_cycles(e), runs[i].largest_left(e), apart(runs[i], e, right));
                }
            }
        }
    }
    fmt::print("\n");
}

} // namespace sixdeg::afr_study
