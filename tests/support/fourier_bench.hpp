// SPDX-License-Identifier: MIT
// The Fourier torque observer in both number types with tables for a signal in closed form.
#pragma once
#include <algorithm>
#include <cmath>

#include "support/torque_signal.hpp"
extern "C" {
#include "sd_fourier.h"
}

namespace sixdeg::test {

constexpr int kN = 60, kCycle = 2 * kN;
constexpr double kPitch = 2 * M_PI / kN, kTickHz = 1e8;

struct F32 {
    using State = sd_fourier_f32_t;
    static constexpr auto init = sd_fourier_init_f32;
    static constexpr auto step = sd_fourier_step_f32;
    static constexpr auto read = sd_fourier_read_f32;
    static constexpr auto shift = sd_fourier_shift_revolution_f32;
    static constexpr auto torque_at = sd_fourier_torque_at_f32;
};
struct Q31 {
    using State = sd_fourier_q31_t;
    static constexpr auto init = sd_fourier_init_q31;
    static constexpr auto step = sd_fourier_step_q31;
    static constexpr auto read = sd_fourier_read_q31;
    static constexpr auto shift = sd_fourier_shift_revolution_q31;
    static constexpr auto torque_at = sd_fourier_torque_at_q31;
};

struct Gains { int harmonics; float energy, mean, reference; };
constexpr Gains kSmooth{5, 1.0f, 0.3f, 0.05f}, kFast{5, 2.0f, 0.3f, 0.1f}, kFine{8, 2.0f, 0.1f, 0.1f};

/// Owns the tables a configuration points to.
struct Bench {
    sd_fourier_tables_t tables{};
    sd_fourier_config_t config{};

    explicit Bench(const Gains &gains, const TorqueSignal &signal = {}) {
        for (int k = 0; k < kN; ++k) tables.inertia_base_kgm2 = std::max(tables.inertia_base_kgm2, float(inertia_at(signal, k)));
        for (int k = 0; k < kN; ++k) tables.inertia_q31[k] = q31(inertia_at(signal, k) / double(tables.inertia_base_kgm2));
        for (int k = 0; k < kCycle; ++k) tables.sine_q31[k] = q31(std::sin(M_PI * k / kN));
        config.positions = kN;
        config.harmonics = std::uint8_t(gains.harmonics);
        config.gain_energy = gains.energy;
        config.gain_mean = gains.mean;
        config.gain_reference = gains.reference;
        config.reject_energy = 1.0f;
        config.settle_steps = 464;
        config.tick_hz = float(kTickHz);
        config.speed_base_radps = 800.0f;
        config.torque_base_nm = 1500.0f;
    }
    static double inertia_at(const TorqueSignal &signal, int k) { return signal.inertia(kPitch * (k - 0.5)); }
    static std::int32_t q31(double x) { return std::int32_t(std::clamp(x * 2147483648.0, -2147483648.0, 2147483647.0)); }
};

inline bool missing(int k) { return k % kN >= 58; }

} // namespace sixdeg::test
