// SPDX-License-Identifier: MIT
// What `sixdeg replay` shares between recordings and event logs.
#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "loop/replay.hpp"

namespace sixdeg {

struct ReplayOptions {
    std::string file, wheel, edge, engine, tune, number, truth, out, json;
    int column = 0;
    std::vector<std::string> set;
};

/// The part of summary.json that both have: edges to rpm_last.
nlohmann::ordered_json figures_json(const ReplayResult &result);
nlohmann::ordered_json decoder_json(const ReplayResult &result);
void print_counts(const ReplayResult &result);
struct ReplayTables {
    std::string teeth_csv, cycles_csv;
};
/// summary.json and the tables, wherever the options want them.
void write_replay(const ReplayOptions &options, const nlohmann::ordered_json &summary, const ReplayTables &tables);

/// The command for an event log.
void replay_event_log(const ReplayOptions &options);

} // namespace sixdeg
