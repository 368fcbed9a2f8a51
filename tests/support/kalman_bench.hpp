// SPDX-License-Identifier: MIT
// The filter on tooth times on a bench: a torque in closed form (torque_signal.hpp), its tooth times by quadrature in double
// precision, edges with errors of their own.
#pragma once
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <random>

#include "design/torque/kalman_tables.hpp"
#include "support/torque_signal.hpp"

namespace sixdeg::test {

constexpr int kPositions = 60, kCycle = 120;

inline EngineFile engine_file() {
    EngineFile engine;
    engine.name = "test";
    engine.firing_order = {1, 3, 4, 2};
    engine.firing_tdc_deg = {0, 180, 360, 540};
    engine.stroke_m = 0.092, engine.rod_m = 0.1445;
    engine.inertia_kgm2 = 0.25, engine.reciprocating_mass_kg = 0.95;
    engine.wheel = {kPositions, {58, 59}};
    engine.tick_hz = 1e8; // as good as ideal; tests of noise bring their own
    return engine;
}

/// As a page's parameters have it by default.
inline const sd_kalman_choice_t kChoice{1500, float(1.5 * M_PI / 180), 3 * 2 * 58};

/// Torque of one firing of a signal whose others do not burn, and how much of it is the mean over its half turn.
inline double pulse_of(std::size_t lane, double alpha) {
    TorqueSignal one;
    one.fuel = {0, 0, 0, 0};
    one.compression_nm = 0;
    one.fuel[lane] = 1;
    return one.raw(alpha);
}

inline double pulse_mean() {
    double sum = 0;
    for (int i = 0; i < 3600; ++i) sum += pulse_of(0, M_PI * (i + 0.5) / 3600) / 3600;
    return sum;
}

inline KnownTorque known_torque() {
    KnownTorque known;
    const double mean = pulse_mean();
    for (std::size_t lane = 0; lane < 4; ++lane) known.basis.push_back([=](double a) { return pulse_of(lane, a) / mean; });
    TorqueSignal motored;
    motored.fuel = {0, 0, 0, 0};
    const auto none = [](double) { return 0.0; };
    known.motored_per_bar = {[=](double a) { return motored.raw(a); }, none, none, none};
    known.motored = {none, none, none, none};
    return known;
}

/// The edges of a signal that repeats, each with an error of its own and one of its tooth's.
class Edges {
  public:
    Edges(const TorqueSignal &signal, double jitter_deg, double pattern_deg, unsigned seed)
        : times_(signal.tooth_times(kPositions, kCycle)), random_(seed) {
        const double s_per_deg = times_.back() / 720;
        jitter_s_ = jitter_deg * s_per_deg;
        std::normal_distribution<double> normal(0, pattern_deg * M_PI / 180);
        for (double &late : pattern_rad_) late = normal(random_);
    }
    double at(int k) {
        const double ideal = times_.back() * (k / kCycle) + times_[std::size_t(k % kCycle)];
        const std::size_t at = std::size_t(k % kCycle), before = at > 0 ? at - 1 : at, after = at + 1;
        const double s_per_rad = (times_[after] - times_[before]) / double(after - before) * kPositions / (2 * M_PI);
        return ideal + late_rad(k) * s_per_rad + jitter_s_ * normal_(random_);
    }
    double late_rad(int k) const { return pattern_rad_[k % kPositions]; }

  private:
    std::vector<double> times_;
    std::mt19937_64 random_;
    std::normal_distribution<double> normal_;
    double jitter_s_, pattern_rad_[kPositions];
};

struct Firing {
    int cycle;
    sd_firing_t said;
};

/// Filter and edges together.
struct Bench {
    /// Firings are those of filter `which`.
    Bench(const sd_kalman_tables_t &with, Edges from, unsigned which = 0) : tables(with), edges(std::move(from)), which_(which) {
        EXPECT_EQ(sd_kalman_init(&kalman, &tables, &kChoice, std::uint8_t(which + 1)), SD_OK);
        tooth.trusted = 1, tooth.intake_bar = 1;
    }
    /// Teeth up to the end of a number of cycles from the start.
    void run(int cycles) {
        for (; k < cycles * kCycle; ++k) {
            if (k % kPositions >= 58) continue;
            if (before_tooth) before_tooth();
            const double early_s = earlier_s ? earlier_s(k) : 0;
            const std::int64_t tick = std::llround((edges.at(k) - early_s + 1) * double(tables.tick_hz));
            tooth.cycle_position = std::uint16_t(k % kCycle);
            tooth.advance = std::uint16_t(k - last_k);
            tooth.period_ticks = std::uint32_t(tick - last_tick);
            sd_firing_t firing[SD_KALMAN_SETS_MAX];
            if (take) take(tooth);
            else if ((sd_kalman_step(&kalman, &tables, &tooth, firing) >> which_ & 1) != 0) firings.push_back({k / kCycle, firing[which_]});
            last_k = k, last_tick = tick;
            if (on_tooth) on_tooth();
        }
    }
    const sd_kalman_tables_t &tables;
    Edges edges;
    const sd_motion_t &motion() const { return kalman.filter[0].motion; }
    sd_kalman_t kalman;
    sd_kalman_tooth_t tooth{};
    std::function<double(int)> earlier_s; ///< By which the edge at a position comes early.
    std::function<void()> before_tooth, on_tooth;
    std::function<void(const sd_kalman_tooth_t &)> take; ///< Instead of the filter.
    std::vector<Firing> firings;
    int k = 1, last_k = 0;
    std::int64_t last_tick = 0;

  private:
    unsigned which_;
};

inline const KalmanTables &pulse_tables() {
    static const KalmanTables tables = kalman_tables(engine_file(), known_torque(), {});
    return tables;
}

} // namespace sixdeg::test
