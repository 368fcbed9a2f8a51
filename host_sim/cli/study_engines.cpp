// SPDX-License-Identifier: MIT
// sixdeg study engines: torque on engines that nobody has seen.
#include "cli/commands.hpp"
#include "studies/engines/engine_study.hpp"

namespace sixdeg {

void add_study_engines(Command &study) {
    auto o = std::make_shared<EngineStudy>();
    Command command = study.add("engines",
                                "torque on drawn engines of own and of other physics, beside its goals (docs/results/engines.md)");
    command.option("PART", o->part, "one kind of learning alone").one_of(engine_study_parts());
    command.option("--engines", o->engines, "drawn of each physics, default 10").within(1, 1000);
    command.option("--seed", o->seed, "of the first engine; the next ones follow; default 501");
    command.output_folder(o->out, "engines.csv, a row a figure of an engine");
    command.runs([o] { print_engine_study(*o); });
}

} // namespace sixdeg
