// SPDX-License-Identifier: MIT
// What the exhaust does to the joint filter: ghosts of a balanced engine, recirculation; and readings of its manifold.
#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "studies/afr/afr_errors.hpp"
#include "studies/afr/afr_parts.hpp"

namespace sixdeg::afr_study {
namespace {

/// Largest deviation from the mean that an engine seems to have beyond its own, points.
double ghost(const Run &run, const AfrError &error) {
    AfrSetup setup;
    setup.mean_lambda = run.mean;
    setup.error = error;
    const AfrEstimates e = run.run(setup);
    const std::size_t end = e.lambda.size() - 1;
    double mean = 0, worst = 0;
    for (std::size_t i = 0; i < kLanes; ++i) mean += run.error(e, end, i) / kLanes;
    for (std::size_t i = 0; i < kLanes; ++i) worst = std::max(worst, std::abs(run.error(e, end, i) - mean));
    return worst;
}

} // namespace

void ghosts() {
    const Case c{"", 1500, 9, 30, 15, 0.005, 4};
    const auto uneven = [](PlantEngine &e) { e.exhaust.runner_m3 = {4e-5, 1.2e-4, 1e-4, 6e-5}; };
    const std::string sensitive = "uego.pressure_percent_per_bar=5", before = "uego.before_turbine=true";
    const Run balanced(c, 0), behind(c, 0, {sensitive}, uneven), runners(c, 0, {}, uneven),
        alike(c, 0, {sensitive, before}), pulsating(c, 0, {sensitive, before}, uneven);
    const auto row = [](const char *name, double points) { fmt::print("{:<44}{:8.3f}\n", name, points); };
    fmt::print("\nghost imbalance of a balanced engine, 1500 rpm 9 bar, points\n");
    row("calibration as it is", ghost(balanced, {}));
    row("delay +30 deg", ghost(balanced, {0, 0, 30, 0}));
    row("flow +10 %", ghost(balanced, {0.1, 0, 0, 0}));
    row("lags +20 %", ghost(balanced, {0, 0.2, 0, 0}));
    row("turbine +20 %", ghost(balanced, {0, 0, 0, 0.2}));
    row("unequal runners", ghost(runners, {}));
    row("5 % a bar behind the turbine, unequal runners", ghost(behind, {}));
    row("5 % a bar before the turbine", ghost(alike, {}));
    row("5 % a bar before the turbine, unequal runners", ghost(pulsating, {}));
    const std::string uneven_pulses = "cylinders.compression_percent=[4, 0, -4, 0]";
    row("compression +4, 0, -4, 0 %", ghost(Run(c, 0, {uneven_pulses}), {}));
    row("  and 5 % a bar before the turbine", ghost(Run(c, 0, {uneven_pulses, sensitive, before}), {}));
    const auto left = [&](const Run &run) { return errors_of(run, c, run.run(setup_for(run, c))).deviations; };
    row("left of +20 % on cylinder 1, rms", left(Run(c, 20)));
    row("  with 5 % a bar behind the turbine", left(Run(c, 20, {sensitive})));
    row("  with 5 % a bar before it", left(Run(c, 20, {sensitive, before})));
}

/// What the calibration is told of recirculation: nothing; that more leaves the manifold than the turbine takes; and that so
/// much of lambda is not this cycle's fuel.
void recirculation(int seeds) {
    struct Row {
        double vanes, valve_mm2; // share of the turbine's area
    };
    fmt::print("\nrecirculation, 1500 rpm 9 bar, intake 1.3 bar, +20 % on cylinder 1, {} seeds, points: rms; noise free; stated "
               "over rms of deviations\n{:<8}{:>8}{:>7}{:>8}{:>14}{:>20}{:>20}{:>20}\n",
               seeds, "vanes", "valve", "share", "lambda", "manifold, bar", "as it is", "told of outflow", "and of lambda");
    for (const Row &row : {Row{1, 0}, Row{1, 200}, Row{1, 400}, Row{0.7, 0}, Row{0.7, 100}, Row{0.7, 200}}) {
        const Case c{"", 1500, 9, 30, 15, 0.005, 4, 1.3};
        Run run(c, 20, {}, [&](PlantEngine &e) {
            e.exhaust.egr_area_m2 = 1e-6 * row.valve_mm2;
            Profile &vanes = e.shared.exhaust->turbine_area_m2;
            std::vector<double> area = vanes.value();
            for (double &a : area) a *= row.vanes;
            vanes = Profile(vanes.x(), area);
        });
        const double share = run.trace.egr_share;
        fmt::print("{:<8}{:4.0f} mm2{:5.0f} %{:8.2f}{:14.2f}", row.vanes, row.valve_mm2, 100 * share, run.mean,
                   run.trace.reading.pressure_pa / 1e5);
        for (int told = 0; told <= (row.valve_mm2 > 0 ? 2 : 0); ++told) {
            AfrSetup setup = setup_for(run, c);
            setup.egr_share = told > 0 ? share : 0;
            if (told > 1) run.point = exhaust_point(run.engine, c.rpm * M_PI / 30, run.trace.intake_pa,
                                                    run.trace.sensor.back() * (1 - share));
            const auto noisy = errors_of_seeds(run, setup, c, 0, false, seeds);
            fmt::print("{:8.2f}{:6.2f}{:6.2f}", percentile(noisy, &Errors::rms, 0.5), errors_of(run, c, run.run(setup)).deviations,
                       rms(noisy, &Errors::stated) / rms(noisy, &Errors::deviations));
        }
        fmt::print("\n");
    }
}

/// What test bench instruments read on the simulated engine, to their accuracy, as entries of its file.
void readings() {
    for (double rpm : {900.0, 1800.0, 2800.0, 4200.0}) {
        for (const auto &[intake_bar, bmep_bar] : {std::pair{1.05, 3.0}, std::pair{1.2, 9.0}, std::pair{1.6, 9.0}}) {
            const ExhaustReading r = Run({"", rpm, bmep_bar, 30, 15, 0, 0, intake_bar}, 0).trace.reading;
            fmt::print("  {{ rpm = {:.0f}, intake_bar = {:.2f}, lambda = {:.2f}, air_mg = {:.0f}, "
                       "pressure_bar = {:.2f}, temperature_k = {:.0f} }},\n",
                       r.speed_radps * 30 / M_PI, r.intake_pa / 1e5, r.lambda, r.air_kg * 1e6, r.pressure_pa / 1e5,
                       5 * std::round(r.kelvin / 5));
        }
    }
}

} // namespace sixdeg::afr_study
