// SPDX-License-Identifier: MIT
// A fuel step on the simulated engine, and how far off estimates of it are.
#pragma once
#include <cmath>

#include "studies/afr/afr_blocks.hpp"

namespace sixdeg {

inline Scenario step_scenario(double rpm, double bmep_bar) {
    TomlFile file(
        "s.toml",
        "engine = \"diesel_22.toml\"\n[run]\ncycles = 70\n[speed]\nmode = \"prescribed\"\n[uego]\n[load]\n");
    file.set("speed.rpm=" + std::to_string(rpm));
    file.set("load.bmep_bar=" + std::to_string(bmep_bar));
    file.set("cylinders.fuel_step=[{at_s=" + std::to_string(30.25 * 120 / rpm) +
             ", cylinder=1, percent=20}]");
    return read_scenario(file, SD_ENGINES);
}

/// 1500 rpm, 9 bar, +20 % on cylinder 1, made once.
struct Step {
    Step() : scenario(step_scenario(1500, 9)), trace(afr_trace(scenario)) {
        const auto &last = trace.lambda.back();
        for (double l : last) mean += l / double(last.size());
        while (trace.lambda[at][0] < trace.lambda[30 * 120][0] + 0.02) ++at;
        point = exhaust_point(scenario.engine.shared, 1500 * M_PI / 30, trace.intake_pa, trace.sensor.back());
    }
    AfrEstimates run(const AfrSetup &setup, const std::vector<double> &noise = {}) const {
        return afr_estimate(scenario.engine.shared, point, trace, setup, noise);
    }
    /// Largest error of a cylinder after `cycles` from the step, points of mean lambda.
    double error_points(const AfrEstimates &e, double cycles) const {
        const auto c = std::size_t(std::ceil(double(at) / 120 + cycles)) - 1;
        double worst = 0;
        for (std::size_t i = 0; i < 4; ++i)
            worst = std::max(worst, std::abs(e.lambda[c][i] - trace.lambda.back()[i]));
        return 100 * worst / mean;
    }
    Scenario scenario;
    AfrTrace trace;
    ExhaustPoint point;
    std::size_t at = 0;
    double mean = 0;
};

inline const Step &step() {
    static const Step s;
    return s;
}

} // namespace sixdeg
