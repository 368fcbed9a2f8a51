// SPDX-License-Identifier: MIT
// What the joint filter is off by, which cylinder it blames, and what it states.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "studies/afr/afr_errors.hpp"
#include "studies/afr/afr_parts.hpp"

namespace sixdeg::afr_study {
namespace {

/// Percent of seeds in which, 4 cycles after a 10 % step, another cylinder is blamed.
struct Wrong {
    double alone = 0, with_mean = 0;
};
Wrong wrong_cylinder(const Run &run, AfrSetup setup, const Case &c, bool perturbed, int seeds) {
    Wrong wrong;
    for (int seed = 0; seed < seeds; ++seed) {
        if (perturbed) setup.error = drawn_error(std::uint64_t(seed));
        const AfrBlamed b = run.run(setup, sensor_noise(run.trace, c.noise, 0, std::uint64_t(seed))).blamed[run.at / 120 + 4];
        wrong.alone += b.alone != 0 ? 100.0 / seeds : 0;
        wrong.with_mean += b.with_mean != 0 ? 100.0 / seeds : 0;
    }
    return wrong;
}

void blame_row(const Case &c, int seeds) {
    fmt::print("{:<28}", c.name);
    double mean = 0;
    for (double percent : {10.0, -10.0}) {
        const Run run(c, percent);
        mean = run.mean;
        for (bool perturbed : {false, true}) {
            const Wrong w = wrong_cylinder(run, setup_for(run, c), c, perturbed, seeds);
            fmt::print("{:12.1f}{:6.1f}", w.with_mean, w.alone);
        }
    }
    fmt::print("{:9.2f}\n", mean);
}

std::vector<Errors> after_probes(const Run &run, const AfrSetup &setup, const Case &c, int seeds) {
    const Probe probe(c);
    return errors_of_seeds(run, setup, c, 0, true, seeds, &probe);
}

void accuracy_row(const Case &c, int seeds, AfrMethod method = AfrMethod::joint, double drift = 0) {
    const Run run(c, 20);
    AfrSetup setup = setup_for(run, c);
    setup.method = method;
    if (drift > 0) setup.drift = drift;
    const AfrEstimates clean = run.run(setup);
    double bias = 0;
    for (std::size_t i = 0; i < kLanes; ++i)
        bias = std::max(bias, std::abs(run.error(clean, clean.lambda.size() - 1, i)));
    const auto white = errors_of_seeds(run, setup, c, 0, false, seeds), off = errors_of_seeds(run, setup, c, 0, true, seeds),
               coloured = errors_of_seeds(run, setup, c, 1e-3, false, seeds),
               coloured_off = errors_of_seeds(run, setup, c, 1e-3, true, seeds);
    const auto probed = c.slow_s > 0 ? off : after_probes(run, setup, c, seeds); // the ecu asks nothing in slow mode
    const double bound =
        100 * afr_bound(run.engine, run.point, run.trace, c.noise, std::max(c.scored_from(), 1)) / run.mean;
    const double first = rms(white, &Errors::first);
    fmt::print("{:<28}{:6.2f}{:8.1f}{:6.2f}{:6.2f}{:6.2f}{:6.2f}{:6.2f}{:6.2f}{:7.2f}{:7.2f}{:6.2f}{:6.2f}{:8.2f}{:6.2f}{:7.2f}",
               c.name, run.mean, run.settle(clean), bias, percentile(white, &Errors::rms, 0.5),
               percentile(white, &Errors::rms, 0.95), percentile(off, &Errors::rms, 0.5),
               percentile(coloured, &Errors::rms, 0.5), percentile(coloured_off, &Errors::rms, 0.5),
               percentile(probed, &Errors::rms, 0.5), first, bound,
               first / bound, rms(white, &Errors::stated) / rms(white, &Errors::deviations),
               rms(off, &Errors::stated) / rms(off, &Errors::deviations), rms(probed, &Errors::stated) / rms(probed, &Errors::deviations));
    fmt::print("\n");
}

} // namespace

void accuracy(int seeds, int cases) {
    fmt::print("joint filter with the default parameters, +20 % on cylinder 1, {} seeds, in points: 0.01 of the mean "
               "lambda\n{:<28}{:>6}{:>8}{:>6}{:>6}{:>6}{:>6}{:>6}{:>6}{:>7}{:>7}{:>6}{:>6}{:>8}{:>6}{:>7}\n",
               seeds, "case", "lambda", "settle", "bias", "rms", "95 %", "pert.", "1 ms", "both", "probed", "at N", "bound", "ratio",
               "stated", "pert.", "probed");
    for (const Case &c : first_of(step_cases(), cases)) accuracy_row(c, seeds);
    fmt::print("fixed gains by position, drift 0.03\n");
    accuracy_row({"1500/9 nominal 0.5 %", 1500, 9, 30, 15, 0.005, 4}, seeds, AfrMethod::joint_fixed, 0.03);
    fmt::print("slow mode, from 40 s after the step on, {} seeds\n", std::max(seeds / 5, 1));
    for (const Case &c : first_of({Case{"1500/9 production 0.5 %", 1500, 9, 80, 20, 0.005, 0, 0, 40},
                          Case{"2800/9 nominal 0.5 %", 2800, 9, 30, 15, 0.005, 0, 0, 40},
                          Case{"3500/12 nominal 0.5 %", 3500, 12, 30, 15, 0.005, 0, 0, 40},
                          Case{"4500/14 nominal 0.5 %", 4500, 14, 30, 15, 0.005, 0, 0, 40}}, cases))
        accuracy_row(c, std::max(seeds / 5, 1));
}

void blames(int seeds, int cases) {
    fmt::print("\nwrong cylinder blamed 4 cycles after a step of 10 %, percent of {} seeds: with the mean lambda before; without\n"
               "{:<28}{:>18}{:>18}{:>18}{:>18}{:>9}\n",
               seeds, "case", "rich, nominal", "rich, perturbed", "lean, nominal", "lean, perturbed", "lambda");
    for (const Case &c : first_of(step_cases(), cases)) blame_row(c, seeds);
}

/// A calibration that is right and states the defaults of afr.delay_error_sd and afr.lag_error_sd all the same.
void doubts(int seeds, int cases) {
    fmt::print("\nstated over rms of deviations, nominal, {} seeds: with no doubt of lags and delay; with the default 0.6 ms and 11.5 %\n",
               seeds);
    for (const Case &c : first_of(step_cases(), cases)) {
        const Run run(c, 20);
        AfrSetup setup = setup_for(run, c);
        const auto ratio = [&] {
            const auto all = errors_of_seeds(run, setup, c, 0, false, seeds);
            return rms(all, &Errors::stated) / rms(all, &Errors::deviations);
        };
        fmt::print("{:<28}{:6.2f}", fmt::format("{} ({:.2f})", c.name, run.mean), ratio());
        setup.known = {0, 0.0006f, 0, 0.115f};
        fmt::print("{:6.2f}\n", ratio());
    }
}

} // namespace sixdeg::afr_study
