// SPDX-License-Identifier: MIT
// sixdeg bench: time, and nothing but time. Ratios travel between machines, nanoseconds do not; instruction counts on targets are
// in docs.
#include <algorithm>
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "cli/bench.hpp"
#include "cli/commands.hpp"
#include "common/error.hpp"
#include "common/files.hpp"

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string what = "blocks", json;
    double seconds = 0.05;
    int repetitions = 5;
};

/// One line of the table: all repetitions of a benchmark.
struct Row {
    std::string name;
    std::vector<double> ns, times_real_time;
};

double median(std::vector<double> x) {
    std::sort(x.begin(), x.end());
    return x[x.size() / 2];
}

/// Keeps every repetition, by name in the order of the runs. Throws nothing: a benchmark that failed leaves its reason.
class Collector : public benchmark::BenchmarkReporter {
  public:
    bool ReportContext(const Context &) override { return true; }
    void ReportRuns(const std::vector<Run> &runs) override {
        for (const Run &run : runs) {
            if (run.error_occurred) failed = run.run_name.function_name + ": " + run.error_message;
            if (run.error_occurred || run.run_type != Run::RT_Iteration) continue;
            const std::string name = run.run_name.function_name + (run.run_name.args.empty() ? "" : "/" + run.run_name.args);
            if (rows.empty() || rows.back().name != name) rows.push_back({name, {}, {}});
            rows.back().ns.push_back(run.GetAdjustedRealTime() * 1e9 / benchmark::GetTimeUnitMultiplier(run.time_unit));
            const auto pace = run.counters.find("times_real_time");
            if (pace != run.counters.end()) rows.back().times_real_time.push_back(pace->second);
        }
    }
    double of(const std::string &name) const {
        for (const Row &row : rows) {
            if (row.name == name) return median(row.ns);
        }
        return 0;
    }
    std::vector<Row> rows;
    std::string failed;
};

/// Blocks that document 004's Table 2 has, with its microseconds on the authors' target.
const std::pair<const char *, const char *> kTable2[] = {{"A, observer of cylinders", "2.70"},
                                                         {"B and C, manifold and delay", "6.70 + < 0.05"},
                                                         {"D, sensor inverted, Fourier law", "6.35"},
                                                         {"D, sensor inverted, oscillators", "6.35"},
                                                         {"A to D, the chain", "15.80"}};

std::string table2_of(const std::string &block) {
    for (const auto &[name, figure] : kTable2) {
        if (block == name) return figure;
    }
    return "";
}

std::string cell(double figure) { return figure > 0 ? fmt::format("{:.4f}", figure) : ""; }
std::string ratio(double figure) { return figure > 0 ? fmt::format("{:.2f}", figure) : ""; }

/// One line a block: f32, q31, dense Eigen, and what dense takes times as long as ours.
void print_blocks(const Collector &collector, Json &json) {
    const char *const line = "{:<34}{:>14}{:>10}{:>10}{:>10}{:>12}{:>12}\n";
    fmt::print(fmt::runtime(line), "block, us a call", "Table 2", "f32", "q31", "dense", "dense/f32", "dense/q31");
    std::vector<std::string> blocks;
    for (const Row &row : collector.rows) {
        const std::string block = row.name.substr(0, row.name.find('|'));
        if (std::find(blocks.begin(), blocks.end(), block) == blocks.end()) blocks.push_back(block);
    }
    for (const std::string &block : blocks) {
        const double f32 = collector.of(block + "|f32") / 1e3, q31 = collector.of(block + "|q31") / 1e3,
                     dense = collector.of(block + "|dense") / 1e3, over_f32 = dense / f32, over_q31 = q31 > 0 ? dense / q31 : 0;
        fmt::print(fmt::runtime(line), block, table2_of(block), cell(f32), cell(q31), cell(dense), ratio(over_f32), ratio(over_q31));
        Json &entry = json["blocks"][block];
        entry["f32_us"] = f32;
        if (q31 > 0) entry["q31_us"] = q31;
        if (dense > 0) entry["dense_us"] = dense, entry["dense_over_f32"] = over_f32;
        if (over_q31 > 0) entry["dense_over_q31"] = over_q31;
        if (!table2_of(block).empty()) entry["table2_us"] = table2_of(block);
    }
}

void print_teeth(int repetitions, Json &json) {
    fmt::print("{:<34}{:>14}{:>10}{:>10}\n", "whole tooth, us", "", "average", "worst");
    for (const bool fixed_point : {false, true}) {
        const ToothTime time = time_of_tooth(fixed_point, repetitions);
        const std::string name = fixed_point ? "q31" : "f32";
        fmt::print("{:<34}{:>14}{:>10.3f}{:>10.3f}\n", "FOLSMO and chain in " + name, "", time.average_us, time.worst_us);
        json["tooth"][name] = {{"average_us", time.average_us}, {"worst_us", time.worst_us}};
    }
}

void print_plants(const Collector &collector, Json &json) {
    fmt::print("{:<44}{:>14}{:>18}\n", "plant, 20 s simulated", "ns", "times real time");
    for (const Row &row : collector.rows) {
        fmt::print("{:<44}{:>14.1f}{:>18.0f}\n", row.name, median(row.ns), median(row.times_real_time));
        json["ns"][row.name] = median(row.ns);
        json["times_real_time"][row.name] = median(row.times_real_time);
    }
}

void run(const Options &options) {
    const bool plant = options.what == "plant";
    if (plant) {
        add_plant_benches();
    } else {
        add_block_benches();
        add_dense_benches();
    }
    std::string seconds = fmt::format("--benchmark_min_time={}", options.seconds),
                repetitions = fmt::format("--benchmark_repetitions={}", options.repetitions);
    char name[] = "sixdeg";
    char *flags[] = {name, seconds.data(), repetitions.data(), nullptr};
    int arguments = 3;
    benchmark::Initialize(&arguments, flags);
    Collector collector;
    benchmark::RunSpecifiedBenchmarks(&collector);
    if (!collector.failed.empty()) throw std::runtime_error(collector.failed);

    Json json;
    if (plant) {
        print_plants(collector, json);
    } else {
        print_blocks(collector, json);
        print_teeth(options.repetitions, json);
    }
    if (!options.json.empty()) write_file(options.json, json.dump(2) + "\n");
}

} // namespace

void add_bench(Command &app) {
    auto options = std::make_shared<Options>();
    Command command = app.add("bench", "time per block on this host, or the pace of the simulated engine");
    command.task("Figures", "bench blocks");
    command.option("WHAT", options->what, "blocks (default) or plant").one_of({"blocks", "plant"});
    command.option("--seconds", options->seconds, "of each repetition, at least; default 0.05").within(1e-4, 100.0);
    command.option("--repetitions", options->repetitions, "whose median is printed; default 5").within(1, 1000);
    command.option("--json", options->json, "figures as JSON");
    command.runs([options] { run(*options); });
}

} // namespace sixdeg
