// SPDX-License-Identifier: MIT
#include "studies/afr/afr_case.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/random.hpp"

namespace sixdeg::afr_study {
namespace {

constexpr double kStepShare = 0.05; // settled within this share of the step
constexpr int kProbeCycles = 640, kProbeFrom = 40;
constexpr double kProbeTrim = 0.05;

/// The fuel steps of a probe, whose trims it notes.
std::vector<std::string> probe_changes(const Case &c, std::vector<std::array<double, 8>> &trims) {
    const int settles = 3 + int(5 * 1e-3 * (c.tau1_ms + c.tau2_ms) * c.rpm / 120), half = 2 * settles + 2; // sd_afr_delay.h
    std::string steps;
    for (int k = kProbeFrom; k < kProbeCycles; ++k) {
        const double trim = (k - kProbeFrom) / half % 2 == 0 ? kProbeTrim : -kProbeTrim;
        for (int i = 0; i < kLanes; ++i) {
            trims[std::size_t(k)][std::size_t(i)] = i == 0 ? trim : -trim / (kLanes - 1);
            if ((k - kProbeFrom) % half == 0)
                steps += fmt::format("{{at_s={}, cylinder={}, percent={}}},", k * 120 / c.rpm, i + 1,
                                     i == 0 ? 100 * trim : -100 * trim / (kLanes - 1));
        }
    }
    return {fmt::format("run.cycles={}", kProbeCycles), fmt::format("cylinders.fuel_step=[{}]", steps)};
}

} // namespace

std::vector<Case> step_cases() {
    std::vector<Case> all;
    for (const Case &c : {Case{"1000/3 nominal 0.5 %", 1000, 3, 30, 15, 0.005, 4},
                          Case{"1500/9 nominal 0.5 %", 1500, 9, 30, 15, 0.005, 4},
                          Case{"1500/9 nominal 0.2 %", 1500, 9, 30, 15, 0.002, 2},
                          Case{"1500/9 fast 0.5 %", 1500, 9, 15, 5, 0.005, 2},
                          Case{"2500/9 nominal 0.5 %", 2500, 9, 30, 15, 0.005, 8},
                          Case{"2500/9 fast 0.5 %", 2500, 9, 15, 5, 0.005, 4}}) {
        all.push_back(c);
        if (c.bmep_bar > 5) all.push_back(c), all.back().intake_bar = 1.1;
    }
    return all;
}

std::vector<Case> first_of(std::vector<Case> cases, int most) {
    if (int(cases.size()) > most) cases.resize(std::size_t(most));
    return cases;
}

Run::Run(const Case &c, double percent, const std::vector<std::string> &changes,
         const std::function<void(PlantEngine &)> &change_plant) {
    TomlFile file(
        "study",
        fmt::format(
            "engine = \"diesel_22.toml\"\n[run]\ncycles = {}\n[speed]\nmode = \"prescribed\"\nrpm = {}\n"
            "[uego]\n[load]\nbmep_bar = {}\n",
            c.run_cycles(), c.rpm, c.bmep_bar));
    if (percent != 0)
        file.set(fmt::format("cylinders.fuel_step=[{{at_s={}, cylinder=1, percent={}}}]",
                             (kStepCycle + 0.25) * 120 / c.rpm, percent));
    for (const auto &change : changes) file.set(change);
    Scenario s = read_scenario(file, SD_DATA "/engines");
    s.engine.shared.exhaust->uego_tau_s[0] = 1e-3 * c.tau1_ms;
    s.engine.shared.exhaust->uego_tau_s[1] = 1e-3 * c.tau2_ms;
    if (c.intake_bar > 0) s.engine.intake_pressure_pa = Profile({0.0}, {1e5 * c.intake_bar});
    change_plant(s.engine);
    trace = afr_trace(s);
    engine = s.engine.shared;
    point = exhaust_point(engine, c.rpm * M_PI / 30, trace.intake_pa, trace.sensor.back());
    for (double l : trace.lambda.back()) mean += l / kLanes;
    at = std::size_t(kStepCycle) * 120;
    const double before = trace.lambda[at][0];
    step_points = 100 * std::abs(trace.lambda.back()[0] - before) / mean;
    while (percent != 0 && at + 1 < trace.lambda.size() && std::abs(trace.lambda[at][0] - before) < 0.01 * mean) ++at;
}

AfrEstimates Run::run(const AfrSetup &setup, const std::vector<double> &noise) const {
    return afr_estimate(engine, point, trace, setup, noise);
}

double Run::error(const AfrEstimates &e, std::size_t cycle, std::size_t lane) const {
    return 100 * (e.lambda[cycle][lane] - trace.lambda.back()[lane]) / mean;
}

double Run::settle(const AfrEstimates &e) const {
    const double band = kStepShare * step_points;
    double settled = 0;
    for (std::size_t i = 0; i < kLanes; ++i) {
        double end = 0;
        for (std::size_t c = e.lambda.size() - 5; c < e.lambda.size(); ++c) end += error(e, c, i) / 5;
        for (std::size_t c = at / 120; c < e.lambda.size(); ++c)
            if (std::abs(error(e, c, i) - end) > band)
                settled = std::max(settled, double((c + 2) * 120 - at) / 120);
    }
    return settled;
}

double Run::band_cycles(const AfrEstimates &e) const {
    double settled = 0;
    for (std::size_t i = 0; i < kLanes; ++i) {
        for (std::size_t k = at / 120; k < e.lambda.size(); ++k)
            if (std::abs(error(e, k, i)) > 0.2 * step_points) settled = std::max(settled, double((k + 2) * 120 - at) / 120);
    }
    return settled;
}

double Run::largest_left(const AfrEstimates &e) const {
    double left = 0;
    for (std::size_t lane = 0; lane < kLanes; ++lane) left = std::max(left, std::abs(error(e, e.lambda.size() - 1, lane)));
    return left;
}

Probe::Probe(const Case &c) : trims(kProbeCycles), run(c, 0, probe_changes(c, trims)) {}

AfrSetup setup_for(const Run &run, const Case &c) {
    AfrSetup setup;
    setup.noise = c.noise;
    setup.mean_lambda = run.mean;
    if (c.slow_s > 0) setup.drift = 0.001;
    return setup;
}

AfrError drawn_error(std::uint64_t seed) {
    RandomStream random(seed, 9);
    const auto within = [&](double range) { return range * (2 * random.uniform() - 1); };
    AfrError e;
    e.flow = within(0.05), e.tau = within(0.2), e.delay_deg = within(10);
    return e;
}

void perturb(AfrSetup &setup, const Case &c, int seed, const Probe *probe) {
    const double deg_per_s = 6 * c.rpm;
    setup.error = drawn_error(std::uint64_t(seed));
    setup.known = {0, float(10 / std::sqrt(3) / deg_per_s), 0, float(0.2 / std::sqrt(3))};
    if (!probe) return;
    const sd_afr_learned_t told = setup.known;
    setup.known = afr_delay_probe(probe->run.engine, probe->run.point, probe->run.trace, setup,
                            sensor_noise(probe->run.trace, c.noise, 0, std::uint64_t(seed) + 1000), probe->trims);
    setup.error.tau = (1 + setup.error.tau) * (1 + double(setup.known.lag)) - 1;
    setup.error.delay_deg += double(setup.known.late_s) * deg_per_s;
    setup.known.late_sd_s = std::min(setup.known.late_sd_s, told.late_sd_s); // as the ecu does
    setup.known.lag_sd = std::min(setup.known.lag_sd, told.lag_sd);
}

} // namespace sixdeg::afr_study
