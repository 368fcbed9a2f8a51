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

void print_ratios(const Collector &collector, Json &json) {
    for (const std::string harmonics : {"5", "12"}) {
        for (const std::string number : {"f32", "q31"}) {
            const double dense = collector.of("torque dense Eigen, per tooth/" + harmonics);
            const double ratio = dense / collector.of("torque " + number + ", per tooth/" + harmonics);
            fmt::print("dense Eigen / {} with {} harmonics: {:.2f}\n", number, harmonics, ratio);
            json["dense_over_" + number + "_" + harmonics] = ratio;
        }
    }
}

void run(const Options &options) {
    const bool plant = options.what == "plant";
    plant ? add_plant_benches() : add_block_benches();
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
    fmt::print("{:<44}{:>14}{}\n", plant ? "plant, 20 s simulated" : "block (/harmonics)", "ns", plant ? "   times real time" : "");
    for (const Row &row : collector.rows) {
        fmt::print("{:<44}{:>14.1f}", row.name, median(row.ns));
        json["ns"][row.name] = median(row.ns);
        if (!row.times_real_time.empty()) {
            fmt::print("{:>18.0f}", median(row.times_real_time));
            json["times_real_time"][row.name] = median(row.times_real_time);
        }
        fmt::print("\n");
    }
    if (!plant) print_ratios(collector, json);
    if (!options.json.empty()) write_file(options.json, json.dump(2) + "\n");
}

} // namespace

void add_bench(Command &app) {
    auto options = std::make_shared<Options>();
    Command command = app.add("bench", "time per block on this host, or the pace of the simulated engine");
    command.option("WHAT", options->what, "blocks (default) or plant").one_of({"blocks", "plant"});
    command.option("--seconds", options->seconds, "of each repetition, at least; default 0.05").within(1e-4, 100.0);
    command.option("--repetitions", options->repetitions, "whose median is printed; default 5").within(1, 1000);
    command.option("--json", options->json, "figures as JSON");
    command.runs([options] { run(*options); });
}

} // namespace sixdeg
