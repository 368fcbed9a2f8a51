// SPDX-License-Identifier: MIT
// The truth that a run left in its folder, beside what a replay of its log says.
#pragma once
#include <filesystem>

#include "common/engine_file.hpp"
#include "loop/replay_log.hpp"
#include "io/tables/run_tables.hpp"

namespace sixdeg {

/// The tables of the run that left teeth.csv and cycles.csv in `folder`, with the firmware's side from the replay of its log:
/// the same to the byte where the replay says what was recorded. Throws InputError naming file and row: not the tables of
/// `sixdeg run`, a cell that is no number, or another number of crank edges than the log has.
RunTables beside_truth(const std::filesystem::path &folder, const EngineFile &engine, const LogReplay &replayed);

} // namespace sixdeg
