// SPDX-License-Identifier: MIT
// sixdeg study observers: document 000's benchmark, its Table 2 beside what its observers and ours do here.
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "studies/observers/observer_bench.hpp"
#include "cli/commands.hpp"
#include "common/files.hpp"

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;

struct Case {
    const char *name;
    HybridEngine engine;
    BenchGains gains;
};

std::vector<Case> cases() {
    HybridEngine table_2, crank_order;
    crank_order.k1_per_s2 = 1e4;
    crank_order.k2_per_s = 30;
    return {{"k1 900 s^-2, k2 20 s^-1", table_2, {4 / 0.12 - 20, 1000, 40}},
            {"k1 10000 s^-2, k2 30 s^-1", crank_order, {4 / 0.12 - 30, 2e4, 40}}};
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

void run(const std::string &json_file, unsigned seed) {
    Json json;
    print_document();
    for (const Case &c : cases()) {
        fmt::print("\n{}: L {:g}, rho {:g}, l {:.3g}; errors in % of the largest acceleration\n", c.name,
                   c.gains.luenberger_per_s2, c.gains.sliding_mps3, c.gains.roo_per_s);
        fmt::print("  {:<7} {:<9} {:<16} {:>19} {:>19} {:>8} {:>8}\n", "", "domain", "condition", "band from 0.6 s",
                   "band from 0.1 s", "to 2 %,s", "to 1 %,s");
        Json &of_case = json[c.name];
        for (const BenchRow &row : run_observer_bench(c.engine, c.gains, seed)) of_case["rows"].push_back(print_row(row));
        const IsolatedMisfire one = run_isolated_misfire(c.engine, seed);
        fmt::print("  ours, one unknown misfire among healthy firings: error up to {:.1f} %, back within 1 % in {:.2f} ms\n",
                   one.peak_percent, 1e3 * one.longest_s);
        of_case["isolated"] = {{"peak_percent", one.peak_percent}, {"longest_s", one.longest_s}};
    }
    if (!json_file.empty()) write_file(json_file, json.dump(2) + "\n");
}

} // namespace

void add_study_observers(Command &study) {
    auto json_file = std::make_shared<std::string>();
    auto seed = std::make_shared<unsigned>(1);
    Command command = study.add("observers", "document 000's benchmark of misfire observers");
    command.option("--json", *json_file, "figures as JSON");
    command.option("--seed", *seed, "of the noise");
    command.runs([json_file, seed] { run(*json_file, *seed); });
}

} // namespace sixdeg
