// SPDX-License-Identifier: MIT
// sixdeg study: questions with a table as their answer.
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "studies/afr/afr_study.hpp"
#include "studies/loop/loop_study.hpp"

namespace sixdeg {
namespace {

constexpr int kMostSeeds = 100000;

void add_afr(CLI::App &study) {
    struct Options {
        std::string part;
        int seeds = 0;
    };
    auto options = std::make_shared<Options>();
    CLI::App *command = study.add_subcommand("afr", "how the mixture's blocks do on the simulated engine (docs/afr.md)");
    command->add_option("PART", options->part, "one table alone")->check(CLI::IsMember(afr_study_parts()));
    command->add_option("--seeds", options->seeds, "of the sensor's noise; each table has a usual number")->check(CLI::Range(1, kMostSeeds));
    command->callback([options] { print_afr_study(options->part, options->seeds); });
}

void add_loop(CLI::App &study) {
    struct Options {
        std::string part;
        int seeds = 20;
        std::vector<std::string> set;
    };
    auto options = std::make_shared<Options>();
    CLI::App *command = study.add_subcommand("loop", "how the fuel balance does in the closed loop (docs/afr.md)");
    command->add_option("PART", options->part, "one table alone")->check(CLI::IsMember(loop_study_parts()));
    command->add_option("--seeds", options->seeds, "perturbed calibrations, default 20")->check(CLI::Range(1, kMostSeeds));
    command->add_option("--set", options->set, "key=value, a tune parameter")->allow_extra_args(false);
    command->callback([options] { print_loop_study(options->part, options->seeds, options->set); });
}

} // namespace

void add_study(CLI::App &app) {
    CLI::App *study = app.add_subcommand("study", "questions with a table as their answer");
    study->require_subcommand(1);
    add_afr(*study);
    add_loop(*study);
    add_study_observers(*study);
    add_study_trips(*study);
}

} // namespace sixdeg
