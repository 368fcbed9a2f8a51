// SPDX-License-Identifier: MIT
// The whole block of firings, with the diesel's calibration, on the teeth of an engine by other equations (other_engine.hpp).
#pragma once
#include "design/calibration.hpp"
#include "design/torque/known_torque.hpp"
#include "support/kalman_bench.hpp"
#include "support/other_engine.hpp"
extern "C" {
#include "sd_firings.h"
}

namespace sixdeg::test {

constexpr double kJitter = 0.01; ///< Of an edge, deg.

inline const sd_kalman_tables_t &diesel_tables() {
    static const KalmanTables made = [] {
        TomlFile file(std::filesystem::path(SD_ENGINES) / "diesel_22.toml");
        EngineFile engine = read_engine(file);
        engine.tick_hz = 1e8;
        TomlFile tune("tune", "");
        const sd_parameters_t parameters = read_tune(tune);
        return kalman_tables(engine, *known_torque(engine, parameters), kalman_tune(engine, parameters));
    }();
    return made.tables;
}

/// The whole block on the teeth of another engine. It is started anew for each engine; what it learned stays.
struct OtherBench {
    sd_firings_t block{};
    const sd_kalman_tables_t &tables = diesel_tables();

    explicit OtherBench(const OtherEngine &of, double pattern = 0.02) : kind(of), pattern_deg(pattern) {
        const sd_firings_config_t config{1500, 1.5f, 3, float(pattern_deg), 58, 1};
        EXPECT_EQ(sd_firings_init(&block, &config, &tables), SD_OK);
    }
    OtherEngine engine(double rpm, double intake_bar, double heat_j) const {
        OtherEngine other = kind;
        other.rpm = rpm, other.intake_bar = intake_bar, other.heat_j = heat_j;
        other.fuel = fuel;
        if (fails) other.fuel[3] = 0;
        other.solve();
        return other;
    }
    /// Position 0 of the diesel's wheel is at 270 deg, the teeth of Edges begin at 0.
    void run(const OtherEngine &engine, int cycles, bool fuel_cut) {
        int failed = 0;
        failed_percent = 0;
        constexpr int kShift = 45;
        Edges edges(engine, kJitter, pattern_deg, seed);
        for (int k = 0; k < kPositions; ++k) late_rad[(k - kShift + kPositions) % kPositions] = edges.late_rad(k);
        sd_firings_restart(&block);
        torque_nm = 0, firings = 0;
        std::int64_t last_tick = std::llround((edges.at(0) + 1) * double(tables.tick_hz)), task_tick = last_tick;
        for (int k = 1, last = 0; k < cycles * kCycle; ++k) {
            const int position = (k - kShift + kCycle) % kCycle;
            if (position % kPositions >= 58) continue;
            const std::int64_t tick = std::llround((edges.at(k) + 1) * double(tables.tick_hz));
            sd_firings_tooth_t tooth{};
            tooth.cycle_position = std::uint16_t(position), tooth.position = std::uint16_t(position % kPositions);
            tooth.advance = std::uint16_t(k - last), tooth.period_ticks = std::uint32_t(tick - last_tick);
            tooth.health = SD_VALID, tooth.phase_known = 1, tooth.intake_known = 1, tooth.fuel_cut = fuel_cut ? 1 : 0;
            tooth.fuel_mg = float(fuel_mg);
            tooth.intake_bar = float(engine.intake_bar), tooth.speed_radps = float(engine.rpm * M_PI / 30);
            for (; tick >= task_tick; task_tick += std::int64_t(tables.tick_hz / 100)) clock();
            sd_firings_out_t out{};
            sd_firings_step(&block, &tables, &tooth, &out);
            if (out.complete && k > cycles * kCycle / 2 && on_firing) on_firing(out);
            if (out.complete && k > cycles * kCycle / 2) {
                const bool burnt = engine.fuel[out.firing.index] > 0;
                (burnt ? torque_nm : failed_percent) += double(out.firing.torque_nm);
                ++(burnt ? firings : failed);
            }
            last = k, last_tick = tick;
        }
        torque_nm /= std::max(firings, 1);
        if (failed > 0) failed_percent *= 100 / engine.firing_nm() / failed;
    }
    /// Every 10 ms.
    void clock() {
        if (task == Task::kFirst || task == Task::kLast) {
            if (task == Task::kLast) sd_firings_task_work(&block, &tables);
            sd_firings_task_end(&block);
        }
        sd_firings_task_begin(&block);
        if (task != Task::kLast) sd_firings_task_work(&block, &tables);
        if (task == Task::kAtOnce) sd_firings_task_end(&block);
    }
    void fuel_cut(double rpm, int cycles = 40) { run(engine(rpm, 1, 0), cycles, true); }
    /// Mean of all firings over the true one, less 1, in percent; the engine at 5 bar.
    double level_percent(double rpm) {
        const OtherEngine fired = engine(rpm, 1.2, 750);
        run(fired, 40, false);
        EXPECT_GT(firings, 50);
        return 100 * (torque_nm / fired.firing_nm() - 1);
    }
    const sd_pattern_t &learned() const { return block.pattern; }

    /// Done and said with the clock; or said with the next one, and done before or after the teeth until then.
    enum class Task { kAtOnce, kFirst, kLast } task = Task::kAtOnce;
    OtherEngine kind;
    double pattern_deg;
    std::vector<double> fuel{1, 1, 1, 1}; ///< Of each firing.
    unsigned seed = 7;                    ///< Of pattern and jitter.
    double fuel_mg = -1;                  ///< Commanded; below 0: not known.
    std::function<void(const sd_firings_out_t &)> on_firing; ///< Of the second half of a run.
    double late_rad[kPositions] = {};     ///< The wheel's pattern, from its position 0 on; its teeth alone.
    bool fails = false; ///< The last cylinder in firing order gets no fuel.
    double torque_nm = 0, failed_percent = 0; ///< Means of what was read: of firings, and of those that failed, of a true firing.
    int firings = 0;
};

/// An operating point.
struct Point {
    double rpm, intake_bar, heat_j;
};

struct Imbalance {
    double mean_percent = 0, single_percent = 0, over_stated = 0, single_over_stated = 0;
};

/// Of the mean of all firings, their mean taken out; rms.
inline Imbalance imbalance(OtherBench &bench, const Point &at, int cycles) {
    const OtherEngine engine = bench.engine(at.rpm, at.intake_bar, at.heat_j);
    std::vector<std::array<sd_firing_t, 4>> read(1);
    bench.on_firing = [&](const sd_firings_out_t &out) {
        if (out.firing.index == 0) read.emplace_back();
        read.back()[out.firing.index] = out.firing;
    };
    bench.run(engine, cycles, false);
    bench.on_firing = {};
    Imbalance out;
    double count = 0, truth = 0;
    for (double fuel : engine.fuel) truth += fuel / 4;
    for (std::size_t i = 1; i + 1 < read.size(); ++i) {
        double mean = 0, single = 0;
        for (const sd_firing_t &f : read[i]) mean += double(f.mean_nm) / 4, single += double(f.torque_nm) / 4;
        for (std::size_t j = 0; j < 4; ++j) {
            const double true_nm = (engine.fuel[j] - truth) * engine.firing_nm();
            const double off = double(read[i][j].mean_nm) - mean - true_nm, one = double(read[i][j].torque_nm) - single - true_nm;
            out.mean_percent += off * off, out.single_percent += one * one, ++count;
            out.over_stated += std::pow(off / double(read[i][j].mean_sd_nm), 2);
            out.single_over_stated += std::pow(one / double(read[i][j].sd_nm), 2);
        }
    }
    const double full = truth * engine.firing_nm() / 100;
    return {std::sqrt(out.mean_percent / count) / full, std::sqrt(out.single_percent / count) / full, std::sqrt(out.over_stated / count),
            std::sqrt(out.single_over_stated / count)};
}

} // namespace sixdeg::test
