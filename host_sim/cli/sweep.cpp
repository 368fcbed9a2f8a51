// SPDX-License-Identifier: MIT
// sixdeg sweep: a grid over scenario fields, each cell a `sixdeg run` in a process of its own.
#include <filesystem>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <thread>

#include "cli/commands.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "common/progress.hpp"
#include "common/stop.hpp"
#include "plant/scenario/scenario.hpp"
#include "studies/sweep/grid.hpp"
#include "studies/sweep/processes.hpp"
#include "studies/sweep/sweep_table.hpp"

namespace sixdeg {
namespace {

namespace fs = std::filesystem;

struct Options {
    std::string scenario, tune, number, learned, out, figure = "cylinders.imbalance_percent";
    std::vector<std::string> over, set;
    bool nominal = false;
    unsigned jobs = std::max(1u, std::thread::hardware_concurrency());
};

/// What stays the same in every cell, as arguments of `sixdeg run`.
std::vector<std::string> common_arguments(const Options &options) {
    std::vector<std::string> arguments{options.scenario};
    if (!options.tune.empty()) arguments.insert(arguments.end(), {"--tune", options.tune});
    if (!options.number.empty()) arguments.insert(arguments.end(), {"--number", options.number});
    if (!options.learned.empty()) arguments.insert(arguments.end(), {"--learned", options.learned});
    if (options.nominal) arguments.push_back("--nominal");
    for (const std::string &set : options.set) arguments.insert(arguments.end(), {"--set", set});
    return arguments;
}

/// All that a result depends on: a cell done before is taken over only when none of it has changed.
std::string fingerprint(const Options &options, const std::vector<std::string> &arguments) {
    const fs::path path(options.scenario);
    TomlFile file(path);
    std::string all = sha256(read_file("/proc/self/exe")) + sha256(file.content());
    const fs::path engine(file.text("engine"));
    if (fs::exists(path.parent_path() / engine)) all += sha256(read_file(path.parent_path() / engine));
    if (!options.tune.empty()) all += sha256(read_file(options.tune));
    if (!options.learned.empty()) all += sha256(read_file(options.learned));
    for (const std::string &argument : arguments) all += argument + "\n";
    return all;
}

std::string first_line(const std::string &text) { return text.substr(0, text.find('\n')); }

class Sweep {
  public:
    explicit Sweep(const Options &options) : options_(options), common_(common_arguments(options)) {
        for (const std::string &over : options.over) axes_.push_back(parse_axis(over));
        const std::string base = fingerprint(options, common_);
        for (const auto &settings : cells_of(axes_)) {
            std::string key = base;
            for (const std::string &setting : settings) key += setting + "\n";
            files_.push_back(fs::path(options.out) / "cells" / (sha256(key).substr(0, 24) + ".json"));
            cells_.push_back({settings, "", ""});
        }
    }

    /// Number of cells without a result.
    std::size_t run() {
        std::vector<std::size_t> open;
        std::vector<std::vector<std::string>> commands;
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            if (fs::exists(files_[i])) continue;
            open.push_back(i);
            commands.push_back(command(i));
        }
        if (open.size() < cells_.size()) fmt::print("{} of {} cells were done before\n", cells_.size() - open.size(), cells_.size());
        fs::create_directories(fs::path(options_.out) / "cells");
        Progress progress("cell", double(open.size()));
        run_all(commands, options_.jobs, [&](const Ended &ended) {
            take(open[ended.index], ended);
            progress.next();
            return true;
        });
        return report();
    }

  private:
    std::vector<std::string> command(std::size_t cell) const {
        std::vector<std::string> arguments{"/proc/self/exe", "run"};
        arguments.insert(arguments.end(), common_.begin(), common_.end());
        for (const std::string &setting : cells_[cell].settings) arguments.insert(arguments.end(), {"--set", setting});
        arguments.insert(arguments.end(), {"--json", part(cell).string()});
        return arguments;
    }

    fs::path part(std::size_t cell) const { return files_[cell].string() + ".part"; }

    // A run that was told to stop leaves a summary of the part it did: that is no result.
    void take(std::size_t cell, const Ended &ended) {
        if (ended.status == 0)
            fs::rename(part(cell), files_[cell]);
        else
            cells_[cell].error = ended.errors.empty() ? fmt::format("ended with status {}", ended.status) : first_line(ended.errors);
        fs::remove(part(cell));
    }

    std::size_t report() {
        std::size_t without = 0;
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            if (fs::exists(files_[i])) cells_[i].summary = read_file(files_[i]);
            if (!cells_[i].summary.empty()) continue;
            ++without;
            if (cells_[i].error.empty()) cells_[i].error = "not run";
        }
        OutputFolder out(options_.out);
        out.add("sweep.csv", sweep_csv(axes_, cells_));
        const auto picture = sweep_picture(axes_, cells_, options_.figure);
        if (picture) out.add("map.svg", *picture);
        out.commit();
        fmt::print("{} cells, {} without a result; {}\n", cells_.size(), without,
                   picture ? "sweep.csv and map.svg written" : "sweep.csv written");
        // The usual figure is not in every summary, and nobody asked for it.
        const std::string fault = options_.figure == Options().figure ? "" : figure_fault(cells_, options_.figure);
        if (!fault.empty()) throw InputError("--figure", options_.figure, fault);
        for (const SweepCell &cell : cells_) {
            if (!cell.error.empty()) fmt::print(stderr, "{}: {}\n", fmt::join(cell.settings, " "), cell.error);
        }
        return without;
    }

    const Options &options_;
    std::vector<std::string> common_;
    std::vector<Axis> axes_;
    std::vector<SweepCell> cells_;
    std::vector<fs::path> files_;
};

void sweep(const Options &options) {
    stop_on_signals();
    const std::size_t without = Sweep(options).run();
    end_by_signal();
    if (without > 0) throw InputError(options.scenario, "", fmt::format("{} cells of the sweep have no result", without));
}

} // namespace

void add_sweep(Command &app) {
    auto options = std::make_shared<Options>();
    Command command = app.add("sweep", "a grid over scenario fields, many runs side by side");
    command.task("A simulated engine", "sweep host_sim/data/scenarios/balance_1000rpm_5bar.toml --over load.bmep_bar=2,5 --out DIR");
    command.option("SCENARIO", options->scenario, "scenario file (docs/reference/scenario.md)").required();
    command.option("--over", options->over,
                   "field=value,value,... an axis of the grid; give it once for each axis").required().one_at_a_time();
    command.output_folder(options->out, "folder for sweep.csv, map.svg and the cells").required();
    command.option("--figure", options->figure, "what map.svg shows over speed.rpm and load.bmep_bar").shows_default();
    command.option("--jobs", options->jobs, "runs at a time").within(1, 256).shows_default();
    command.option("--tune", options->tune, "tune file");
    command.settings(options->set, "key=value, as in run, alike in every cell");
    command.number(options->number);
    command.option("--learned", options->learned, "as in run, alike in every cell");
    command.flag("--nominal", options->nominal, "skip the runs whose calibration is wrong on purpose");
    command.runs([options] { sweep(*options); });
}

} // namespace sixdeg
