// SPDX-License-Identifier: MIT
#include "studies/airpath/matched_delay.hpp"

#include <Eigen/Core>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/progress.hpp"
#include "studies/airpath/matched_filter.hpp"

namespace sixdeg {
namespace {

constexpr double kNever = 9999;
constexpr int kMostSteps = 300, kTraceSteps = 300, kBefore = 100;

} // namespace

DelayFigures measure_delay(const MatchedSetup &setup, const MatchedFault &fault, double threshold, int runs, std::uint64_t seed) {
    RandomStream random(seed, 4);
    DelayFigures f;
    std::vector<double> delay;
    double squares = 0;
    Progress progress("run", runs);
    for (int r = 0; r < runs; ++r, progress.next()) {
        MatchedRun run(setup, threshold, threshold, random);
        const int before = kBefore + int(100 * random.uniform());
        bool early = false;
        while (!run.decides()) run.step(draw_noise(random));
        for (int i = 0; i < before && !early; ++i) {
            run.step(draw_noise(random));
            early = run.out().fault != SD_AIRPATH_NO_FAULT;
        }
        if (early) {
            f.early++;
            continue;
        }
        run.set_fault(fault);
        int steps = 0;
        do run.step(draw_noise(random));
        while (++steps < kMostSteps && run.out().fault == SD_AIRPATH_NO_FAULT);
        if (run.out().fault == SD_AIRPATH_NO_FAULT) f.missed++;
        else if (run.out().fault != fault.actuator) f.wrong++;
        else {
            f.named++;
            delay.push_back(steps * kMatchedPeriodS);
            f.time_error_s += (steps * kMatchedPeriodS - kMatchedPeriodS * run.out().decision.since_steps);
        }
    }
    if (delay.empty()) return f;
    f.time_error_s /= double(delay.size());
    for (const double d : delay) f.mean_s += d / double(delay.size());
    for (const double d : delay) squares += (d - f.mean_s) * (d - f.mean_s);
    f.sd_s = std::sqrt(squares) / double(delay.size());
    std::sort(delay.begin(), delay.end());
    f.p95_s = delay[std::size_t(0.95 * double(delay.size() - 1))];
    return f;
}

FaultTrace trace_fault(const MatchedSetup &setup, const MatchedFault &fault) {
    RandomStream first(1, 5), second(1, 5);
    MatchedRun healthy(setup, kNever, kNever, first), faulty(setup, kNever, kNever, second);
    FaultTrace trace;
    for (int i = 0; i < kBefore; ++i) healthy.step({0, 0, 0}), faulty.step({0, 0, 0});
    faulty.set_fault(fault);
    for (int i = 0; i < kTraceSteps; ++i) {
        healthy.step({0, 0, 0});
        faulty.step({0, 0, 0});
        trace.residual.push_back({double(faulty.bank().residual[0] - healthy.bank().residual[0]),
                                  double(faulty.bank().residual[1] - healthy.bank().residual[1])});
    }
    trace.end_kpa = trace.residual.back();
    return trace;
}

double formula_delay_s(const MatchedSetup &setup, const MatchedFault &fault, double threshold) {
    const auto end = trace_fault(setup, fault).end_kpa;
    const sd_cusum_tables_f32_t &c = setup.design.tables.cusum;
    const std::size_t l = fault.actuator == SD_AIRPATH_EGR_FAULT ? 0 : 2;
    const double growth = double(c.weight[l][0]) * end[0] + double(c.weight[l][1]) * end[1] - double(c.offset[l]);
    return threshold / growth * kMatchedPeriodS;
}

double lorden_delay_s(const MatchedSetup &setup, const MatchedFault &fault, double mean_time_s) {
    RandomStream first(1, 5), second(1, 5);
    MatchedRun healthy(setup, kNever, kNever, first), faulty(setup, kNever, kNever, second);
    MatchedFilter known(setup), told(setup);
    std::vector<double> information;
    for (int i = 0; i < 4 * kBefore; ++i) {
        healthy.step({0, 0, 0}), faulty.step({0, 0, 0});
        known.step(healthy.readings()), told.step(faulty.readings());
    }
    faulty.set_fault(fault);
    for (int i = 1; i <= kMostSteps; ++i) {
        healthy.step({0, 0, 0}), faulty.step({0, 0, 0});
        const Eigen::Vector2d shift = told.step(faulty.readings()) - known.step(healthy.readings());
        information.push_back(shift.dot(told.innovation_covariance().inverse() * shift) / 2);
    }
    double threshold = 1, left = 0;
    for (int i = 0; i < 50; ++i) threshold = std::log(information.back() * mean_time_s / kMatchedPeriodS + threshold + 1);
    left = threshold - 1 + std::exp(-threshold);
    for (std::size_t i = 0; i < information.size(); ++i) {
        if (information[i] >= left) return (double(i) + left / information[i]) * kMatchedPeriodS;
        left -= information[i];
    }
    return -1;
}

std::string residuals_csv(const MatchedSetup &setup, double seconds, std::uint64_t seed) {
    RandomStream random(seed, 6);
    MatchedRun run(setup, kNever, kNever, random);
    while (!run.decides()) run.step(draw_noise(random));
    std::string text = "time_s,residual_1_kpa,residual_2_kpa\n";
    for (long i = 0; i < long(seconds / kMatchedPeriodS); ++i) {
        run.step(draw_noise(random));
        text += fmt::format("{:.2f},{:.5f},{:.5f}\n", double(i) * kMatchedPeriodS, run.bank().residual[0], run.bank().residual[1]);
    }
    return text;
}

} // namespace sixdeg
