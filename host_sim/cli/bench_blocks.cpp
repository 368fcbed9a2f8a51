// SPDX-License-Identifier: MIT
// What a block costs on this host, in f32 and in q31: every block on the state of an ecu that has followed an engine for a while.
#include <benchmark/benchmark.h>
#include <cmath>

#include "cli/bench.hpp"
#include "cli/bench_drive.hpp"

namespace sixdeg {
namespace {

constexpr float kFuelMg = 25, kIntakeBar = 1.3f, kSpeedRadps = 157.08f, kAir = 0.3f;
constexpr unsigned kFuelCycle = 120; // positions of the bench's wheel over a cycle

/// Times a call that takes the number of the step. Some cycles come before, over which a block forgets that time jumped.
template <class Call> void time(benchmark::State &state, Call call) {
    std::uint32_t k = 0;
    for (; k < 40 * kFuelCycle; ++k) call(k);
    for (auto _ : state) call(k++);
}

const sd_tooth_t &tooth_of(std::uint32_t k) { return bench_teeth()[k % bench_teeth().size()]; }
float air_of(std::uint32_t k) { return kAir + 0.02f * float(std::sin(0.1047 * (k % kFuelCycle))); }

void add(const char *block, const char *variant, void (*body)(benchmark::State &)) {
    benchmark::RegisterBenchmark((std::string(block) + "|" + variant).c_str(), body);
}

// ---- decoder and torque -----------------------------------------------------------------------------------------

/// The decoder has a clock of its own, so it gets edges that go on for ever, from its first on.
void decoder(benchmark::State &state) {
    const auto page = bench_page();
    const sd_crank_config_t config = sd_calibration_crank(page.get(), &page->parameters);
    sd_crank_t crank;
    sd_crank_init(&crank, &config);
    const auto &teeth = bench_teeth();
    std::uint32_t tick = 0;
    sd_tooth_t tooth;
    time(state, [&](std::uint32_t k) {
        sd_crank_edge(&crank, tick += teeth[k % teeth.size()].period_ticks, &tooth);
        benchmark::DoNotOptimize(tooth);
    });
    if (tooth.edge_class != SD_EDGE_TOOTH && tooth.edge_class != SD_EDGE_COASTED) state.SkipWithError("lost the angle");
}

void fourier_f32(benchmark::State &state) {
    const WarmEcu &warm = warm_ecu();
    sd_fourier_f32_t self = warm.ecu->torque.observer.f32;
    time(state, [&](std::uint32_t k) {
        const sd_tooth_t &t = tooth_of(k);
        benchmark::DoNotOptimize(sd_fourier_step_f32(&self, &warm.page->fourier, t.cycle_position, t.advance, t.period_ticks, 1));
    });
}

void fourier_q31(benchmark::State &state) {
    const WarmEcu &warm = warm_ecu([](sd_parameters_t &p) { p.torque_fixed_point = 1; });
    sd_fourier_q31_t self = warm.ecu->torque.observer.q31;
    time(state, [&](std::uint32_t k) {
        const sd_tooth_t &t = tooth_of(k);
        benchmark::DoNotOptimize(sd_fourier_step_q31(&self, &warm.page->fourier, t.cycle_position, t.advance, t.period_ticks, 1));
    });
}

void filters(benchmark::State &state) {
    const WarmEcu &warm = warm_ecu();
    sd_firings_t self = warm.ecu->firings;
    sd_firings_out_t out;
    time(state, [&](std::uint32_t k) {
        const sd_tooth_t &t = tooth_of(k);
        const sd_firings_tooth_t tooth{t.cycle_position, t.position, t.advance, t.period_ticks, t.health, 1, 1, 0, 0, -1, kIntakeBar,
                                       kSpeedRadps};
        sd_firings_step(&self, &warm.page->kalman, &tooth, &out);
        benchmark::DoNotOptimize(out);
    });
}

// ---- misfires ---------------------------------------------------------------------------------------------------

/// One of document 000's observers, with the verdict of each firing.
template <int Kind> void switched_f32(benchmark::State &state) {
    const WarmEcu &warm = warm_ecu([](sd_parameters_t &p) { p.misfire_method = Kind; });
    sd_wheel_f32_t self = warm.ecu->misfire.wheel.f32;
    const float work = warm.ecu->misfire.work_per_mg * kFuelMg;
    sd_wheel_verdict_f32_t verdict;
    time(state, [&](std::uint32_t k) {
        const sd_tooth_t &t = tooth_of(k);
        const sd_wheel_tooth_t tooth{t.cycle_position, t.advance, t.period_ticks, 1};
        const std::uint32_t firing = sd_wheel_tooth_f32(&self, &warm.page->wheel, &tooth, work);
        if (firing) sd_wheel_judge_f32(&self, &warm.page->wheel, firing - 1, 0, &verdict);
        benchmark::DoNotOptimize(self.observer.accel);
    });
}

template <int Kind> void switched_q31(benchmark::State &state) {
    const WarmEcu &warm = warm_ecu([](sd_parameters_t &p) { p.misfire_method = Kind, p.misfire_arithmetic = 1; });
    sd_wheel_q31_t self = warm.ecu->misfire.wheel.q31;
    const sd_q31_t work = sd_from_float_q31(warm.ecu->misfire.work_per_mg * kFuelMg);
    sd_wheel_verdict_q31_t verdict;
    time(state, [&](std::uint32_t k) {
        const sd_tooth_t &t = tooth_of(k);
        const sd_wheel_tooth_t tooth{t.cycle_position, t.advance, t.period_ticks, 1};
        const std::uint32_t firing = sd_wheel_tooth_q31(&self, &warm.page->wheel, &tooth, work);
        if (firing) sd_wheel_judge_q31(&self, &warm.page->wheel, firing - 1, 0, &verdict);
        benchmark::DoNotOptimize(self.observer.accel);
    });
}

void monitor(benchmark::State &state) {
    const WarmEcu &warm = warm_ecu();
    sd_misfire_t self = warm.ecu->misfire.monitor;
    time(state, [&](std::uint32_t k) {
        const sd_misfire_firing_t firing{std::uint8_t(k % 4), SD_VALID, 0, 0, 110 + 0.3f * float(k % 7), 1, kFuelMg, kSpeedRadps, 3000};
        benchmark::DoNotOptimize(sd_misfire_judge(&self, &firing));
    });
}

// ---- mixture ----------------------------------------------------------------------------------------------------

void chain_of(sd_parameters_t &p) { p.afr_method = float(SD_AFR_FOURIER); }
void oscillators_of(sd_parameters_t &p) { p.afr_method = float(SD_AFR_OSCILLATORS); }
void fixed_chain_of(sd_parameters_t &p) { p.afr_method = float(SD_AFR_FOURIER), p.afr_arithmetic = 1; }
void fixed_oscillators_of(sd_parameters_t &p) { p.afr_method = float(SD_AFR_OSCILLATORS), p.afr_arithmetic = 1; }

#define SD_BENCH_MIXTURE(N, POINT, CHAIN, PSI)                                                                          \
    void exhaust_##N(benchmark::State &state, const BenchTune &tune) {                                                 \
        const WarmEcu &warm = warm_ecu(tune);                                                                          \
        auto self = warm.ecu->mixture.afr.POINT.exhaust;                                                               \
        sd_exhaust_now_##N##_t now;                                                                                    \
        time(state, [&](std::uint32_t k) {                                                                             \
            sd_exhaust_step_##N(&self, warm.page->afr.PSI, k % kFuelCycle, &now);                                      \
            benchmark::DoNotOptimize(now);                                                                             \
        });                                                                                                            \
    }                                                                                                                  \
    void inversion_##N(benchmark::State &state, const BenchTune &tune) {                                               \
        const WarmEcu &warm = warm_ecu(tune);                                                                          \
        auto self = warm.ecu->mixture.afr.CHAIN.uego;                                                                  \
        const auto &sine = warm.page->fourier.sine_q31;                                                                \
        time(state, [&](std::uint32_t k) {                                                                             \
            const auto air = sd_from_float_##N(air_of(k));                                                             \
            benchmark::DoNotOptimize(sd_uego_step_##N(&self, sine, k % kFuelCycle, air));                              \
        });                                                                                                            \
    }                                                                                                                  \
    void observer_##N(benchmark::State &state, const BenchTune &tune) {                                                \
        const WarmEcu &warm = warm_ecu(tune);                                                                          \
        auto exhaust = warm.ecu->mixture.afr.POINT.exhaust;                                                            \
        auto self = warm.ecu->mixture.afr.CHAIN.observer;                                                              \
        std::vector<sd_exhaust_now_##N##_t> now(kFuelCycle);                                                           \
        for (std::uint32_t k = 0; k < kFuelCycle; ++k) sd_exhaust_step_##N(&exhaust, warm.page->afr.PSI, k, &now[k]);  \
        const auto air = sd_from_float_##N(kAir);                                                                      \
        time(state, [&](std::uint32_t k) {                                                                             \
            sd_afr_observer_step_##N(&self, &now[k % kFuelCycle], air);                                                \
            benchmark::DoNotOptimize(self.air);                                                                        \
        });                                                                                                            \
    }
SD_BENCH_MIXTURE(f32, point, chain, psi)
SD_BENCH_MIXTURE(q31, point_q31, chain_q31, psi_q31)

/// All of the mixture at a position, whatever the method.
void mixture(benchmark::State &state, const BenchTune &tune) {
    const WarmEcu &warm = warm_ecu(tune);
    sd_afr_t self = warm.ecu->mixture.afr;
    const sd_afr_tables_t tables{&warm.page->afr, warm.page->fourier.sine_q31};
    time(state, [&](std::uint32_t k) {
        sd_afr_step(&self, &tables, k % kFuelCycle, 1 - air_of(k), 0);
        benchmark::DoNotOptimize(self.in);
    });
}

void joint(benchmark::State &state) {
    const WarmEcu &warm = warm_ecu();
    sd_exhaust_f32_t exhaust = warm.ecu->mixture.afr.point.exhaust;
    sd_afr_joint_t self = warm.ecu->mixture.afr.joint;
    std::vector<sd_afr_inflow_t> in(kFuelCycle);
    for (std::uint32_t k = 0; k < kFuelCycle; ++k) {
        sd_exhaust_now_f32_t now;
        sd_exhaust_step_f32(&exhaust, warm.page->afr.psi, k, &now);
        sd_afr_inflow_of(&now, &in[k]);
    }
    time(state, [&](std::uint32_t k) {
        sd_afr_joint_step(&self, &in[k % kFuelCycle], air_of(k), nullptr);
        benchmark::DoNotOptimize(self.lag1);
    });
}

void balance(benchmark::State &state) {
    const WarmEcu &warm = warm_ecu();
    sd_balance_t self = warm.ecu->trims.balance;
    float deviation[SD_BALANCE_CYLINDERS_MAX] = {0.02f, -0.01f, 0.01f, -0.02f}, sd[SD_BALANCE_CYLINDERS_MAX] = {0.01f, 0.01f, 0.01f, 0.01f};
    time(state, [&](std::uint32_t k) {
        deviation[k % 4] = -deviation[k % 4];
        const sd_balance_input_t input{deviation, sd, 0.5f, 1, SD_VALID, 0};
        sd_balance_begin(&self, &input);
        while (sd_balance_work(&self)) {
        }
        benchmark::DoNotOptimize(self.trim);
    });
}

} // namespace

void add_block_benches() {
    add("crank decoder", "f32", decoder); // integers in either
    add("Fourier observer", "f32", fourier_f32);
    add("Fourier observer", "q31", fourier_q31);
    add("filters on tooth times", "f32", filters);
    add("FOLSMO", "f32", switched_f32<int(SD_METHOD_FOLSMO)>);
    add("FOLSMO", "q31", switched_q31<int(SD_METHOD_FOLSMO)>);
    add("FOSMO", "f32", switched_f32<int(SD_METHOD_FOSMO)>);
    add("FOSMO", "q31", switched_q31<int(SD_METHOD_FOSMO)>);
    add("ROO", "f32", switched_f32<int(SD_METHOD_ROO)>);
    add("ROO", "q31", switched_q31<int(SD_METHOD_ROO)>);
    add("misfire monitor", "f32", monitor);
    add("A, observer of cylinders", "f32", [](benchmark::State &s) { observer_f32(s, chain_of); });
    add("A, observer of cylinders", "q31", [](benchmark::State &s) { observer_q31(s, fixed_chain_of); });
    add("B and C, manifold and delay", "f32", [](benchmark::State &s) { exhaust_f32(s, chain_of); });
    add("B and C, manifold and delay", "q31", [](benchmark::State &s) { exhaust_q31(s, fixed_chain_of); });
    add("D, sensor inverted, Fourier law", "f32", [](benchmark::State &s) { inversion_f32(s, chain_of); });
    add("D, sensor inverted, Fourier law", "q31", [](benchmark::State &s) { inversion_q31(s, fixed_chain_of); });
    add("D, sensor inverted, oscillators", "f32", [](benchmark::State &s) { inversion_f32(s, oscillators_of); });
    add("D, sensor inverted, oscillators", "q31", [](benchmark::State &s) { inversion_q31(s, fixed_oscillators_of); });
    add("A to D, the chain", "f32", [](benchmark::State &s) { mixture(s, chain_of); });
    add("A to D, the chain", "q31", [](benchmark::State &s) { mixture(s, fixed_chain_of); });
    add("joint filter", "f32", joint);
    add("fuel balance", "f32", balance);
}

} // namespace sixdeg
