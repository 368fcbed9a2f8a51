// SPDX-License-Identifier: MIT
// sixdeg study observers: document 000's benchmark, its Table 2 beside what its observers and ours do here; and what the same
// observers find of misfires in the ecu.
#include <algorithm>
#include <filesystem>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <optional>

#include "cli/commands.hpp"
#include "cli/misfire_report.hpp"
#include "cli/tune_options.hpp"
#include "common/files.hpp"
#include "common/progress.hpp"
#include "design/calibration.hpp"
#include "design/misfire/wheel_design.hpp"
#include "studies/observers/misfire_detection.hpp"
#include "studies/observers/observer_bench.hpp"

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string part = "table2", json, traces;
    unsigned seed = 1;
    double k1 = 0, k2 = 0, luenberger = 1000, sliding = 40, roo = 0; ///< k1, k2 0: the usual cases.
    bool nonlinear = false;
    int cycles = 6250, rpm = 0, bar = 0;
    std::vector<std::string> set;
};

struct Case {
    std::string name;
    HybridEngine engine, told; ///< told: whose input the observers are given.
    BenchGains gains;
};

HybridEngine engine_of(double k1, double k2) {
    HybridEngine engine;
    engine.k1_per_s2 = k1, engine.k2_per_s = k2;
    return engine;
}

Case case_of(double k1, double k2, double luenberger, double sliding, double roo) {
    const HybridEngine engine = engine_of(k1, k2);
    return {fmt::format("k1 {:g} s^-2, k2 {:g} s^-1", k1, k2), engine, engine, {roo > 0 ? roo : 4 / 0.12 - k2, luenberger, sliding}};
}

/// The nonlinear engine, with observers that are given its own input or that of the linear one.
Case nonlinear(Case c, bool told) {
    c.engine.nonlinear = true;
    c.told.nonlinear = told;
    c.name += told ? ", nonlinear engine, observers told its input" : ", nonlinear engine, observers told the linear one's";
    return c;
}

/// L and rho with which FOLSMO settles before FOSMO, as in the document's Table 2.
constexpr double kOrderK2 = 27, kOrderLuenberger = 2e4, kOrderSliding = 150;

std::vector<Case> cases(const Options &o) {
    if (o.k1 > 0 || o.k2 > 0) {
        const Case one = case_of(o.k1 > 0 ? o.k1 : 900, o.k2 > 0 ? o.k2 : 20, o.luenberger, o.sliding, o.roo);
        if (o.nonlinear) return {nonlinear(one, false), nonlinear(one, true)};
        return {one};
    }
    const Case table_2 = case_of(900, 20, o.luenberger, o.sliding, o.roo);
    if (o.nonlinear) return {nonlinear(table_2, false), nonlinear(table_2, true)};
    return {table_2, case_of(900, kOrderK2, kOrderLuenberger, kOrderSliding, 0), case_of(1e4, 30, 2e4, 40, 0)};
}

void print_document() {
    fmt::print("Document 000, Table 2 (acceleration error, convergence):\n"
               "  ROO     no fault  0.5 ..  5.2 %   misfire -0.9 ..  7.8 %   0.12 s\n"
               "  FOSMO   no fault -1.0 ..  0.3 %   misfire -1.1 ..  0.8 %   0.4 s\n"
               "  FOLSMO  no fault -0.2 ..  0.8 %   misfire -0.6 ..  0.7 %   0.3 s\n");
}

std::string settled_after(double last_s) {
    return last_s > kBenchRunS - 0.2 ? "never" : fmt::format("{:.4f}", last_s);
}

Json print_row(const BenchRow &row) {
    fmt::print("  {:<7} {:<9} {:<16} {:>8.3f} .. {:>7.3f} {:>8.2f} .. {:>7.2f} {:>8} {:>8}\n", row.observer, row.domain,
               row.condition, row.low_percent, row.high_percent, row.early_low_percent, row.early_high_percent,
               settled_after(row.to_two_percent_s), settled_after(row.to_one_percent_s));
    return {{"observer", row.observer}, {"domain", row.domain}, {"condition", row.condition},
            {"band_percent", {row.low_percent, row.high_percent}},
            {"band_from_0.1_s_percent", {row.early_low_percent, row.early_high_percent}},
            {"to_2_percent_s", row.to_two_percent_s}, {"to_1_percent_s", row.to_one_percent_s}};
}

/// Figures 1 and 2: speed and its error with a misfire; 3 and 4: acceleration, healthy and with it.
void write_traces(const Case &c, const Options &o) {
    OutputFolder out(o.traces);
    const auto known = figure_trace(c.engine, c.gains, o.seed, true, true), unknown = figure_trace(c.engine, c.gains, o.seed, true, false);
    std::string one = "t_s,speed_mps,estimate_mps,estimate_not_told_mps\n", two = "t_s,error_mps,error_not_told_mps\n";
    std::string three = "t_s,accel_mps2,estimate_mps2\n", four = "t_s,accel_mps2,estimate_mps2,estimate_not_told_mps2\n";
    for (const FigurePoint &p : figure_trace(c.engine, c.gains, o.seed, false, false))
        three += fmt::format("{:.4f},{:.5f},{:.5f}\n", p.time_s, p.accel_mps2, p.accel_estimate_mps2);
    for (std::size_t i = 0; i < known.size(); ++i) {
        const FigurePoint &k = known[i], &u = unknown[i];
        one += fmt::format("{:.4f},{:.6f},{:.6f},{:.6f}\n", k.time_s, k.speed_mps, k.speed_estimate_mps, u.speed_estimate_mps);
        two += fmt::format("{:.4f},{:.7f},{:.7f}\n", k.time_s, k.speed_estimate_mps - k.speed_mps, u.speed_estimate_mps - u.speed_mps);
        four += fmt::format("{:.4f},{:.5f},{:.5f},{:.5f}\n", k.time_s, k.accel_mps2, k.accel_estimate_mps2, u.accel_estimate_mps2);
    }
    out.add("figure_1.csv", one);
    out.add("figure_2.csv", two);
    out.add("figure_3.csv", three);
    out.add("figure_4.csv", four);
    out.commit();
}

Json run_table_2(const Options &o) {
    Json json;
    print_document();
    for (const Case &c : cases(o)) {
        fmt::print("\n{}: L {:g}, rho {:g}, l {:.3g}; errors in % of the largest acceleration\n", c.name,
                   c.gains.luenberger_per_s2, c.gains.sliding_mps3, c.gains.roo_per_s);
        fmt::print("  {:<7} {:<9} {:<16} {:>19} {:>19} {:>8} {:>8}\n", "", "domain", "condition", "band from 0.6 s",
                   "band from 0.1 s", "to 2 %,s", "to 1 %,s");
        Json &of_case = json[c.name];
        of_case["gains"] = {{"k1", c.engine.k1_per_s2}, {"k2", c.engine.k2_per_s}, {"luenberger", c.gains.luenberger_per_s2},
                            {"sliding", c.gains.sliding_mps3}, {"roo", c.gains.roo_per_s}};
        for (const BenchRow &row : run_observer_bench(c.engine, c.told, c.gains, o.seed)) of_case["rows"].push_back(print_row(row));
        const IsolatedMisfire one = run_isolated_misfire(c.engine, o.seed);
        fmt::print("  ours, one unknown misfire among healthy firings: error up to {:.1f} %, back within 1 % in {:.2f} ms\n",
                   one.peak_percent, 1e3 * one.longest_s);
        of_case["isolated"] = {{"peak_percent", one.peak_percent}, {"longest_s", one.longest_s}};
    }
    if (!o.traces.empty()) write_traces(cases(o).front(), o);
    return json;
}

std::string rate(std::uint64_t hits, std::uint64_t of) {
    const RateBounds bounds = rate_bounds(hits, of);
    return fmt::format("{:8.3f} [{:7.3f},{:8.3f}]", of ? 100.0 * double(hits) / double(of) : 0.0, 100 * bounds.low, 100 * bounds.high);
}

Json print_detection(const DetectionCell &cell, const Detection &d, double bound) {
    Json json{{"rpm", cell.rpm}, {"bmep_bar", cell.bmep_bar}, {"ramp", cell.ramp}, {"stalled", d.run.stalled},
              {"separation_bound", bound}, {"compared", d.compared}, {"differing", d.differing}};
    fmt::print("{} rpm {:g} bar, {}{}; bound: separation {:.1f}\n", cell.rpm, cell.bmep_bar,
               cell.ramp ? "speed up and down by a fifth in 4 s" : "steady",
               d.run.stalled ? ", stalled" : "", bound);
    for (const DetectionRow &row : d.rows) {
        const MisfireFigures &f = row.figures;
        fmt::print("  {:<15} {:>5} {} {:>6} {} {:>5} {:>7.2f}\n", row.method, f.missed, rate(f.detected, f.missed), f.healthy,
                   rate(f.false_alarms, f.healthy), f.wrong_cylinder, f.separation());
        json["methods"][row.method] = misfire_json(f, 0);
    }
    fmt::print("  f32 and q31 differ in {} of {} firings\n", d.differing, d.compared);
    return json;
}

/// The numbers that the engine file gives.
void print_model(const EngineFile &engine) {
    const WheelModel m = wheel_model(engine);
    fmt::print("{}: pulse from {:.1f} deg, {:.1f} deg long; k2 {:.3f}, mean {:.4f} per rad; k1 {:.4f}, L {:.3f} per rad2; J {:.4f} kg m2\n",
               engine.name, m.pulse_start_deg, m.pulse_deg, m.k2_per_rad, m.mean_per_rad, m.k1_per_rad2(), m.luenberger_per_rad2(),
                   m.inertia_kgm2);
    constexpr const char *kNames[] = {"FOLSMO", "FOSMO", "ROO"};
    for (int kind = 0; kind < SD_WHEEL_KINDS; ++kind) {
        const WheelCapture c = wheel_capture(engine, m, sd_wheel_kind_t(kind));
        fmt::print("  {:<7} delay {:.0f} deg, shows {:.3f} of a misfire\n", kNames[kind], c.delay * 360.0 / engine.wheel.positions,
                   c.share);
    }
}

Json run_detections(const Options &o) {
    Json json = Json::array();
    print_model(detection_scenario({1500, 1, false}, 1, o.seed).engine.shared);
    TomlFile tune = open_tune("", o.set);
    const sd_parameters_t parameters = read_tune(tune);
    fmt::print("  {:<15} {:>5} {:>27} {:>6} {:>27} {:>5} {:>7}\n", "", "missed", "detected, % [95 %]", "healthy",
               "false alarms, % [95 %]", "wrong", "sep.");
    std::vector<DetectionCell> cells = detection_cells();
    const auto wanted = [&](const DetectionCell &cell) {
        return (o.rpm == 0 || cell.rpm == o.rpm) && (o.bar == 0 || cell.bmep_bar == o.bar);
    };
    cells.erase(std::stable_partition(cells.begin(), cells.end(), wanted), cells.end());
    Progress progress("cell", double(cells.size()));
    for (const DetectionCell &cell : cells) {
        const Scenario scenario = detection_scenario(cell, o.cycles, o.seed);
        const Detection d = run_detection(scenario, o.set);
        json.push_back(print_detection(cell, d, separation_bound(scenario, firing_bounds(scenario, parameters, d.run))));
        progress.next();
        std::fflush(stdout);
    }
    return json;
}

void run(const Options &o) {
    const Json json = o.part == "detection" ? run_detections(o) : run_table_2(o);
    if (!o.json.empty()) write_file(o.json, json.dump(2) + "\n");
}

} // namespace

void add_study_observers(Command &study) {
    auto o = std::make_shared<Options>();
    Command command = study.add("observers",
                                "document 000's observers: its benchmark, and misfires found in the ecu (docs/theory/observers.md)");
    command.option("PART", o->part, "table2: the benchmark; detection: misfires nobody told of, on the simulated engine")
        .one_of({"table2", "detection"});
    command.option("--json", o->json, "figures as JSON");
    command.option("--seed", o->seed, "of the noise");
    command.option("--k1", o->k1, "1/s2, of table2: one case alone, with the gains below; usual 900").within(1.0, 1e6);
    command.option("--k2", o->k2, "1/s, the same; usual 20").within(0.1, 1e3);
    command.option("--luenberger", o->luenberger, "L, 1/s2").within(0.0, 1e6);
    command.option("--sliding", o->sliding, "rho, m/s3").within(0.0, 9e4);
    command.option("--roo", o->roo, "l of ROO, 1/s; usual: what settles in 0.12 s").within(0.1, 1e4);
    command.flag("--nonlinear", o->nonlinear, "the document's equation (1) in place of (2)");
    command.output_folder(o->traces, "traces for the document's Figures 1 to 4, of the first case");
    command.option("--cycles", o->cycles, "of detection, a cell; default 6250, for 500 misfires").within(50, 1000000);
    command.option("--rpm", o->rpm, "of detection: cells of this speed alone").within(1, 20000);
    command.option("--bar", o->bar, "of detection: cells of this load alone").within(1, 40);
    command.settings(o->set, "key=value, a tune parameter, of detection");
    command.runs([o] { run(*o); });
}

} // namespace sixdeg
