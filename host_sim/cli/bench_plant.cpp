// SPDX-License-Identifier: MIT
// How many times faster than real time the simulated engine runs at 1500 rpm.
#include <benchmark/benchmark.h>
#include <string>

#include "cli/bench.hpp"
#include "plant/scenario/plant.hpp"
#include "plant/sensors/edge_generator.hpp"

namespace sixdeg {
namespace {

constexpr double kSimulated = 20; // s a repetition

Scenario scenario(const std::string &engine) {
    TomlFile file("bench", "engine = \"" + engine +
                               "\"\n[run]\nduration_s = 20\n[speed]\nrpm = 1500\n[load]\nbmep_bar = 5\n");
    file.set("cyclic.cov_percent=5");
    file.set("encoder={jitter_deg=0.01, pattern_rms_deg=0.02}");
    return read_scenario(file, SD_DATA "/engines");
}

void report(benchmark::State &state) {
    state.counters["times_real_time"] =
        benchmark::Counter(kSimulated * double(state.iterations()), benchmark::Counter::kIsRate);
}

void engine_with_encoder(benchmark::State &state, const std::string &engine) {
    const Scenario s = scenario(engine);
    for (auto _ : state) {
        Plant plant(s, 1);
        EncoderEdge edge;
        while (plant.next_edge(edge)) benchmark::DoNotOptimize(edge);
    }
    report(state);
}

void light_edges(benchmark::State &state) {
    const Scenario s = scenario("diesel_22.toml");
    for (auto _ : state) {
        EdgeGenerator generator(s.engine.shared, s.encoder, Profile(1500.0), 0, kSimulated, 1);
        EncoderEdge edge;
        while (generator.next_edge(edge)) benchmark::DoNotOptimize(edge);
    }
    report(state);
}

} // namespace

void add_plant_benches() {
    for (const auto &[name, engine] : {std::pair{"one cylinder", "single_generator.toml"},
                                       {"three cylinders, dual mass", "triple_10.toml"},
                                       {"four cylinders", "diesel_22.toml"},
                                       {"six cylinders, uneven", "vee6_uneven.toml"},
                                       {"eight cylinders, torsion", "eight_diesel.toml"}}) {
        benchmark::RegisterBenchmark(name, engine_with_encoder, std::string(engine))->Unit(benchmark::kMillisecond);
    }
    benchmark::RegisterBenchmark("light edges", light_edges)->Unit(benchmark::kMillisecond);
}

} // namespace sixdeg
