// SPDX-License-Identifier: MIT
// Prints how the fuel balance does on the simulated engine: the closed-loop figures of docs/afr.md, by its definitions.
// Nothing is asserted. loop_bench [SEEDS [KEY=VALUE...]]: 20 perturbed calibrations by default; parameters over their defaults.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>

#include "run/loop_case.hpp"

using namespace sixdeg;

namespace {

using Texts = std::vector<std::string>;

const Texts kFigure16{"cylinders.fuel_percent=[6, -3, 0, -4]", "cylinders.fuel_step=[{at_s=19, cylinder=2, percent=13}]",
                      "run.duration_s=45", "control.balance_on_s=[0, 7.5, 36, 1000]"};
const Texts kFast{"speed.rpm=3500", "load.bmep_bar=12", "run.duration_s=40", "control.balance_on_s=[8, 1000]", "uego.noise_per_rthz=1.2e-4"};

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

void seeds(const char *name, const Texts &scenario, const Texts &tune, bool perturbed, int count) {
    std::vector<BalanceFigures> runs;
    for (int seed = 1; seed <= count; ++seed) runs.push_back(figures({scenario, tune, 0, perturbed, std::uint64_t(seed)}));
    print(fmt::format("{}, median", name), percentile(runs, 0.5));
    print(fmt::format("{}, worst of {}", name, count), percentile(runs, 1));
}

} // namespace

int main(int argc, char **argv) {
    const int count = argc > 1 ? std::max(1, std::atoi(argv[1])) : 20;
    const Texts lambda(argv + std::min(argc, 2), argv + argc), torque = join(lambda, {"balance.source=2"});
    fmt::print("fuel balance; true spread before and its largest, residual, trim the wrong way: percent; to 3 %, gave up: cycles\n");
    const char *only=getenv("ONLY"); const auto want=[&](char c){return !only||strchr(only,c);};
    if(want('f')){header("Figure 16 of document 004");
    print("from lambda", figures({kFigure16, lambda, 0, false, 1}));
    print("from torque", figures({kFigure16, torque, 0, false, 1}));
    }if(want('n')){header("1500 rpm, 9 bar");
    for (bool perturbed : {false, true}) {
        const char *calibration = perturbed ? "perturbed" : "nominal";
        seeds(fmt::format("from lambda, {}", calibration).c_str(), {}, lambda, perturbed, count);
        seeds(fmt::format("from torque, {}", calibration).c_str(), {}, torque, perturbed, count);
    }
    }if(want('s')){header("3500 rpm, 12 bar, slow mode");
    seeds("from lambda, nominal", kFast, lambda, false, std::max(1, count / 4));
    seeds("from lambda, perturbed", kFast, lambda, true, std::max(1, count / 4));
    }if(want('d')){header("delay of the calibration wrong");
    for (double error : {0, -30, 30, -60, 60, -90, 90, -120, 120, -150, 150, 180})
        print(fmt::format("{:+.0f} deg", error), figures({{"run.duration_s=20"}, lambda, error, false, 1}));
    }if(want('r')){header("ramps, cylinders balanced before");
    const Texts early{"control.balance_on_s=[1, 1000]", "run.duration_s=30"};
    print("none", figures({early, lambda, 0, false, 1}));
    print("1000 to 2500 rpm in 4 s and back", figures({join(early, {"speed.rpm=[1000,1000,2500,2500,1000]", "speed.time_s=[0,10,14,20,24]"}), lambda, 0, false, 1}));
    print("5 to 10 bar in 4 s and back", figures({join(early, {"load.bmep_bar=[5,5,10,10,5]", "load.time_s=[0,10,14,20,24]"}), lambda, 0, false, 1}));
    print("tip in and out, 5 to 10 bar in 0.2 s", figures({join(early, {"load.bmep_bar=[5,5,10,10,5]", "load.time_s=[0,10,10.2,20,20.2]"}), lambda, 0, false, 1}));
    }return 0;
}
