// SPDX-License-Identifier: MIT
// Runs the AFR blocks over some cycles of a gas, for test_afr_cost.py to count what each step executes. Nothing is printed but
// the sizes of their states.
//   afr_delay_probe                                                              sizes
//   afr_delay_probe fourier|oscillator|joint|joint_fixed ENGINE.toml [q31]       a run
#include <cmath>
#include <cstdio>

#include "common/error.hpp"
#include "studies/afr/afr_blocks.hpp"

using namespace sixdeg;

namespace {

constexpr int kCycles = 20;

AfrTrace made_trace() {
    AfrTrace trace;
    trace.cycle_positions = 120, trace.step_s = 120.0 / 1500 / 120;
    for (int k = 0; k < kCycles * trace.cycle_positions; ++k) trace.sensor.push_back(0.5 + 0.01 * std::cos(2 * M_PI * k / 120));
    return trace;
}

void print_sizes() {
    const auto print = [](const char *name, std::size_t bytes) { std::printf("%s %zu\n", name, bytes); };
    print("sd_exhaust_step_f32", sizeof(sd_exhaust_f32_t)), print("sd_exhaust_step_q31", sizeof(sd_exhaust_q31_t));
    print("sd_uego_step_f32", sizeof(sd_uego_f32_t)), print("sd_uego_step_q31", sizeof(sd_uego_q31_t));
    print("sd_afr_observer_step_f32", sizeof(sd_afr_observer_f32_t)), print("sd_afr_observer_step_q31", sizeof(sd_afr_observer_q31_t));
    print("sd_afr_chain_step_f32", sizeof(sd_afr_chain_f32_t)), print("sd_afr_chain_step_q31", sizeof(sd_afr_chain_q31_t));
    print("sd_afr_joint_step", sizeof(sd_afr_joint_t));
}

AfrMethod method_of(const std::string &name) {
    if (name == "fourier") return AfrMethod::fourier;
    if (name == "oscillator") return AfrMethod::oscillator;
    if (name == "joint") return AfrMethod::joint;
    if (name == "joint_fixed") return AfrMethod::joint_fixed;
    throw InputError("afr_delay_probe", name, "is none of fourier, oscillator, joint, joint_fixed");
}

} // namespace

int main(int argc, char **argv) {
    try {
        if (argc == 1) return print_sizes(), 0;
        TomlFile file{std::filesystem::path(argv[2])};
        EngineFile engine = read_engine(file);
        engine.exhaust->readings.clear(); // no need to be exact, and it takes long under valgrind
        AfrSetup setup;
        setup.method = method_of(argv[1]);
        setup.fixed_point = argc > 3;
        const AfrTrace trace = made_trace();
        afr_estimate(engine, exhaust_point(engine, 1500 * M_PI / 30, 1.5e5, 0.5), trace, setup, {});
    } catch (const InputError &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 2;
    }
    return 0;
}
