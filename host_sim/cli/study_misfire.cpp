// SPDX-License-Identifier: MIT
// sixdeg study misfire: detectors of misfires on a made set of edge times.
#include "cli/commands.hpp"
#include "studies/misfire/misfire_study.hpp"

namespace sixdeg {

void add_study_misfire(Command &study) {
    auto o = std::make_shared<MisfireStudy>();
    Command command = study.add("misfire",
                                "six detectors of misfires on a made set of edge times, at equal false alarms "
                                "(docs/results/misfire-study.md)");
    command.option("PART", o->part, "one kind of engine alone").one_of(misfire_study_parts());
    command.option("--engines", o->engines, "drawn for each kind and physics, default 10").within(1, 1000);
    command.option("--cycles", o->cycles, "of each run, default 600").within(40, 1000000);
    command.option("--seed", o->seed, "of the first engine; the next ones follow");
    command.option("--rpm", o->rpm, "points of this speed alone").within(1, 20000);
    command.option("--bar", o->bar, "points of this load alone").within(0.1, 40.0);
    command.output_folder(o->out, "cells.csv and curves.csv, for tools/report/misfire_picture.py");
    command.option("--write", o->write, "folder for the set itself, edge times and truth, so that other detectors can be scored");
    command.settings(o->set, "key=value, a tune parameter");
    command.runs([o] { print_misfire_study(*o); });
}

} // namespace sixdeg
