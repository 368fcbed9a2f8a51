// SPDX-License-Identifier: MIT
// sixdeg study: questions with a table as their answer.
#include <memory>
#include <string>
#include <vector>

#include "cli/commands.hpp"
#include "studies/afr/afr_study.hpp"
#include "studies/airpath/airpath_study.hpp"
#include "studies/driveline/driveline_study.hpp"
#include "studies/loop/loop_study.hpp"

namespace sixdeg {
namespace {

constexpr int kMostSeeds = 100000;

void add_afr(Command &study) {
    struct Options {
        std::string part;
        int seeds = 0, cases = 1000;
    };
    auto options = std::make_shared<Options>();
    Command command = study.add("afr", "how the mixture's blocks do on the simulated engine (docs/results/afr.md)");
    command.option("PART", options->part, "one table alone").one_of(afr_study_parts());
    command.option("--seeds", options->seeds, "of the sensor's noise; each table has a usual number").within(1, kMostSeeds);
    command.option("--cases", options->cases, "the first so many operating points of a table").within(1, 1000);
    command.runs([options] { print_afr_study(options->part, options->seeds, options->cases); });
}

void add_loop(Command &study) {
    struct Options {
        std::string part;
        int seeds = 20;
        std::vector<std::string> set;
    };
    auto options = std::make_shared<Options>();
    Command command = study.add("loop", "how the fuel balance does in the closed loop (docs/results/afr.md)");
    command.option("PART", options->part, "one table alone").one_of(loop_study_parts());
    command.option("--seeds", options->seeds, "perturbed calibrations, default 20").within(1, kMostSeeds);
    command.settings(options->set, "key=value, a tune parameter");
    command.runs([options] { print_loop_study(options->part, options->seeds, options->set); });
}

void add_driveline(Command &study) {
    struct Options {
        std::string part, folder;
        double seconds = 600;
        unsigned seed = 1;
    };
    auto options = std::make_shared<Options>();
    Command command = study.add("driveline", "how the driveline's observers do on a simulated car (docs/results/driveline.md)");
    command.option("PART", options->part, "one table alone").one_of(driveline_study_parts());
    command.option("--seconds", options->seconds, "of a drive, default 600").within(10.0, 1e5);
    command.option("--seed", options->seed, "of driver and teeth");
    command.output_folder(options->folder, "Figure 6 as CSV");
    command.runs([options] { print_driveline_study(options->part, options->seconds, options->seed, options->folder); });
}

void add_air_path(Command &study) {
    auto options = std::make_shared<AirPathStudy>();
    Command command = study.add("airpath", 
                                "diagnosis of EGR valve and turbine vanes on a plant that obeys its model (docs/results/airpath.md)");
    command.option("PART", options->part, "one table alone").one_of(air_path_study_parts());
    command.option("--runs", options->runs, "for each fault, default 2000").within(10, 1000000);
    command.option("--hours", options->hours, "of healthy running, default 20").within(0.1, 1e5);
    command.option("--air-path", options->air_path, "file with [cylinders] and [airpath], in place of the matched plant's own");
    command.option("--design", options->design, "DESIGN.toml of tools/airpath/design.py, in place of the matched plant's own");
    command.option("--seed", options->seed, "of noise and inputs");
    command.output_folder(options->folder, "of residuals: an hour of healthy ones as CSV");
    command.runs([options] { print_air_path_study(*options); });
}

} // namespace

void add_study(Command &app) {
    Command study = app.add("study", "questions with a table as their answer");
    study.task("Figures", "study driveline figure-6");
    study.needs_command();
    add_afr(study);
    add_loop(study);
    add_driveline(study);
    add_air_path(study);
    add_study_observers(study);
    add_study_engines(study);
    add_study_identify(study);
    add_study_misfire(study);
    add_study_gas(study);
    add_study_trips(study);
}

} // namespace sixdeg
