// SPDX-License-Identifier: MIT
// sixdeg study gas: pressure, flows and mixture of the simulated engine over the last cycles of a scenario, step by step.
#include <deque>
#include <fmt/format.h>
#include <memory>

#include "cli/commands.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "plant/engine/units.hpp"
#include "plant/scenario/plant.hpp"

namespace sixdeg {
namespace {

constexpr double kGramPerKg = 1000, kRpmPerRadps = 1 / kRadpsPerRpm;
constexpr const char *kColumns = "t_s,angle_deg,cylinder_bar,exhaust_gps,manifold_bar,manifold_kg,turbine_gps,turbine_rpm,behind_bar,"
                                 "manifold_burned,tip_burned,sensor_burned\n";

struct Options {
    std::string scenario, folder;
    std::vector<std::string> set;
    int cycles = 2;
};

/// A row of gas.csv, of the cylinder that fires first: what is true at the end of the step that the plant has just made.
std::string row(const Plant &plant) {
    const StepTruth &now = plant.truth();
    const exhaust::ExhaustModel &gas = *plant.exhaust();
    return fmt::format("{:.6f},{:.2f},{:.5f},{:.4f},{:.6f},{:.7f},{:.4f},{:.1f},{:.6f},{:.6f},{:.6f},{:.6f}\n", now.time_s,
                       now.angle_rad * kDegPerRad, plant.model().pressure_pa(0) / kPaPerBar, kGramPerKg * gas.flows().valve[0],
                       gas.pressure_pa() / kPaPerBar, gas.manifold().kg, kGramPerKg * gas.flows().turbine,
                       gas.turbine_radps() * kRpmPerRadps, gas.downstream_pa() / kPaPerBar, 1 - gas.manifold().air_fraction(),
                           1 - gas.at_sensor(), plant.uego_lambda());
}

void run(const Options &options) {
    const Scenario scenario = read_scenario(options.scenario, options.set);
    Plant plant(scenario, scenario.seed);
    if (!plant.exhaust()) throw InputError(options.scenario, "uego", "is needed: without a lambda sensor there is no exhaust to look at");
    const auto most = std::size_t(options.cycles * 720 / scenario.step_deg);
    std::deque<std::string> rows;
    plant.watch_steps([&] {
        rows.push_back(row(plant));
        if (rows.size() > most) rows.pop_front();
    });
    EncoderEdge edge;
    CycleTruth cycle;
    double imep_pa = 0;
    while (plant.next_edge(edge)) {
        while (plant.next_cycle(cycle)) imep_pa = cycle.imep_pa;
    }
    std::string csv = kColumns;
    for (const std::string &line : rows) csv += line;
    OutputFolder out(options.folder);
    out.add("gas.csv", csv);
    out.commit();
    fmt::print("{}: the last {} cycles, IMEP {:.2f} bar, in {}/gas.csv\n", scenario.name, options.cycles, imep_pa / kPaPerBar,
               options.folder);
}

} // namespace

void add_study_gas(Command &study) {
    auto options = std::make_shared<Options>();
    Command command = study.add("gas", "pressure, flows and mixture of the simulated engine alone (docs/reference/files.md)");
    command.option("SCENARIO", options->scenario, "scenario file with [uego]").required();
    command.option("--cycles", options->cycles, "the last so many, default 2").within(1, 1000);
    command.settings(options->set, "key=value, a scenario field");
    command.output_folder(options->folder, "folder for gas.csv").required();
    command.runs([options] { run(*options); });
}

} // namespace sixdeg
