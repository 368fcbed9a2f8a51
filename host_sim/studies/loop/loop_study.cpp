// SPDX-License-Identifier: MIT
#include "studies/loop/loop_study.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <functional>

#include "common/progress.hpp"
#include "studies/loop/loop_case.hpp"
#include "studies/loop/other_exhaust.hpp"

namespace sixdeg {
namespace {

using Texts = std::vector<std::string>;

const char *const kFigure16 = "figure16_1500rpm_9bar.toml", *const kSlow = "slow_3500rpm_12bar.toml";

/// A fuel cut at low load before the trims are allowed, from which torque learns its zero.
const Texts kCut{"load.bmep_bar=[9,9,1,1,9]", "load.time_s=[0,2,2.2,4.2,4.4]", "load.fuel_cut_s=[2.2,4.2]",
                 "control.balance_on_s=[6,1000]", "run.duration_s=16"};

/// Moves of speed and load once the cylinders are balanced, and what they begin from.
struct Move {
    const char *name, *file;
    Texts change;
};
const std::vector<Move> kMoves{
    {"steady, 1000 rpm, 9 bar", "speed_ramp.toml", {"speed.rpm=[1000]", "speed.time_s=[0]"}},
    {"steady, 1500 rpm, 5 bar", "load_ramp.toml", {"load.bmep_bar=[5]", "load.time_s=[0]"}},
    {"1000 to 2500 rpm in 4 s and back", "speed_ramp.toml", {}},
    {"5 to 10 bar in 4 s and back", "load_ramp.toml", {}},
    {"tip in, 5 to 10 bar in 0.2 s, and out", "tip_in.toml", {}}};

Texts join(Texts a, const Texts &b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

void header(const char *title) {
    fmt::print("\n{:<44}{:>8}{:>8}{:>9}{:>9}{:>10}{:>9}\n", title, "before", "to 3 %", "largest", "residual", "wrong way", "gave up");
}

void print(const std::string &name, const BalanceFigures &b) {
    fmt::print("{:<44}{:>8.1f}{:>8.0f}{:>9.1f}{:>9.2f}{:>10.2f}{:>9.0f}\n", name, b.spread_before_percent, b.cycles_to_3_percent,
               b.largest_spread_percent, b.residual_percent, b.wrong_way_percent, b.gave_up_cycles);
}

BalanceFigures figures(const LoopCase &loop) { return run_loop(loop).balance.value(); }

/// Of each figure by itself; a run that never came below 3 % counts as the worst.
BalanceFigures percentile(std::vector<BalanceFigures> runs, double p) {
    const auto of = [&](double BalanceFigures::*figure) {
        std::vector<double> x;
        for (const BalanceFigures &b : runs)
            x.push_back(figure == &BalanceFigures::cycles_to_3_percent && b.*figure < 0 ? 1e9 : b.*figure);
        std::sort(x.begin(), x.end());
        const double value = x[std::size_t(p * double(x.size() - 1) + 0.5)];
        return value == 1e9 ? -1 : value;
    };
    return {of(&BalanceFigures::spread_before_percent), of(&BalanceFigures::cycles_to_3_percent),
            of(&BalanceFigures::largest_spread_percent), of(&BalanceFigures::residual_percent),
            of(&BalanceFigures::wrong_way_percent), of(&BalanceFigures::gave_up_cycles)};
}

void seeds(const char *name, const Texts &scenario, const Texts &tune, bool perturbed, int count,
           const char *file = "") {
    std::vector<BalanceFigures> runs;
    Progress progress("seed", count);
    for (int seed = 1; seed <= count; ++seed, progress.next())
        runs.push_back(figures({scenario, tune, 0, perturbed, std::uint64_t(seed), file}));
    print(fmt::format("{}, median", name), percentile(runs, 0.5));
    print(fmt::format("{}, worst of {}", name, count), percentile(runs, 1));
}

/// What is left of a wrong delay in the end, deg crank: median and worst; and the loop's figures.
void delays(const std::string &name, double error, const Texts &tune, int count) {
    std::vector<BalanceFigures> runs;
    std::vector<double> left;
    Progress progress("seed", count);
    for (int seed = 1; seed <= count; ++seed, progress.next()) {
        const RunResult r = run_loop({{"run.duration_s=28"}, tune, error, false, std::uint64_t(seed)});
        runs.push_back(r.balance.value());
        left.push_back(std::abs(error + r.afr_late_s * 1500 * 6));
    }
    std::sort(left.begin(), left.end());
    print(fmt::format("{}, median (left: {:.0f} deg)", name, left[left.size() / 2]), percentile(runs, 0.5));
    print(fmt::format("{}, worst of {} (left: {:.0f} deg)", name, count, left.back()), percentile(runs, 1));
}

Texts from_torque(const Texts &tune) { return join(tune, {"balance.source=2"}); }

void figure_16(int, const Texts &tune) {
    header("Figure 16 of document 004");
    print("from lambda", figures({{}, tune, 0, false, 1, kFigure16}));
    print("from torque", figures({{}, from_torque(tune), 0, false, 1, kFigure16}));
    for (const char *arithmetic : {"0", "1"}) {
        const Texts chain = join(tune, {"afr.method=3", fmt::format("afr.arithmetic={}", arithmetic), "balance.integral_gain=0.1"});
        print(fmt::format("by the document's chain, {}", *arithmetic == '0' ? "f32" : "q31"), figures({{}, chain, 0, false, 1, kFigure16}));
        print("the same with a pressure sensor", figures({{"exhaust_sensors.pressure_sample_us=500"}, chain, 0, false, 1, kFigure16}));
        print("the same by a PI law", figures({{}, join(chain, {"balance.proportional_gain=0.1"}), 0, false, 1, kFigure16}));
    }
}

void calibrations(int count, const Texts &tune) {
    header("1500 rpm, 9 bar");
    for (bool perturbed : {false, true}) {
        const char *calibration = perturbed ? "perturbed" : "nominal";
        seeds(fmt::format("from lambda, {}", calibration).c_str(), {}, tune, perturbed, count);
        seeds(fmt::format("from torque, {}", calibration).c_str(), {}, from_torque(tune), perturbed, count);
        if (perturbed) seeds("the same after 2 s of fuel cut", kCut, from_torque(tune), perturbed, count);
    }
}

void slow_mode(int count, const Texts &tune) {
    for (const char *noise : {"1.2e-4", "1.83e-4"}) {
        header(fmt::format("3500 rpm, 12 bar, slow mode, noise {}", noise).c_str());
        const Texts changed{fmt::format("uego.noise_per_rthz={}", noise)};
        seeds("from lambda, nominal", changed, tune, false, (count + 1) / 2, kSlow);
        seeds("from lambda, perturbed", changed, tune, true, (count + 1) / 2, kSlow);
    }
}

void wrong_delays(int count, const Texts &tune) {
    for (const auto &[identify, title] : {std::pair{0, "delay wrong, as calibrated"},
                                          {1, "delay wrong, learned from the trims"},
                                          {2, "the same, and by a probe"}}) {
        header(title);
        for (double error : {0, -30, 30, -60, 60, -90, 90, -120, 120, -150, 150, -180, 180})
            delays(fmt::format("{:+.0f} deg", error), error, join(tune, {fmt::format("afr.delay_learning={}", identify)}), (count + 6) / 7);
    }
}

void moves(int, const Texts &tune) {
    header("moves, cylinders balanced before");
    for (bool noisy : {false, true}) {
        for (const Move &move : kMoves) {
            const Texts quiet{"uego.noise_per_rthz=0", "cyclic.cov_percent=0"};
            print(fmt::format("{}{}", move.name, noisy ? "" : ", no noise"),
                  figures({noisy ? move.change : join(move.change, quiet), tune, 0, false, 1, move.file}));
        }
    }
}

struct Part {
    const char *name;
    std::function<void(int, const Texts &)> print;
};
const std::vector<Part> kParts{
    {"figure-16", figure_16}, {"calibrations", calibrations}, {"slow", slow_mode}, {"delays", wrong_delays}, {"moves", moves},
    {"rest", print_at_rest}, {"other", print_other_exhausts}};

} // namespace

std::vector<std::string> loop_study_parts() {
    std::vector<std::string> names;
    for (const Part &part : kParts) names.push_back(part.name);
    return names;
}

void print_loop_study(const std::string &part, int seeds, const std::vector<std::string> &tune) {
    fmt::print("fuel balance; true spread before and its largest, residual, trim the wrong way: percent; to 3 %, gave up: cycles\n");
    Progress progress("part", part.empty() ? double(kParts.size()) : 1);
    for (const Part &p : kParts) {
        if (!part.empty() && part != p.name) continue;
        p.print(seeds, tune);
        progress.next();
    }
}

} // namespace sixdeg
