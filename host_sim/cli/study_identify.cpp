// SPDX-License-Identifier: MIT
// sixdeg study identify: engines drawn by seed, and what `sixdeg identify` finds of them.
#include "cli/commands.hpp"
#include "studies/identify/identify_study.hpp"

namespace sixdeg {

void add_study_identify(Command &study) {
    auto o = std::make_shared<IdentifyStudy>();
    Command command = study.add("identify",
        "engines drawn by seed, found again from their teeth: do the intervals hold (docs/results/identify.md)");
    command.option("--engines", o->engines, "how many, default 200").within(1, 100000);
    command.option("--seed", o->seed, "of the first engine; the next ones follow");
    command.flag("--each", o->each, "a line for each engine beside the table");
    command.runs([o] { print_identify_study(*o); });
}

} // namespace sixdeg
