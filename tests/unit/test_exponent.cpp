// SPDX-License-Identifier: MIT
// The motored torque that all cylinders have in common, learned in fuel cut, on an engine by other equations (other_engine.hpp): the
// level of torque when it fires.
#include "design/calibration.hpp"
#include "design/torque/known_torque.hpp"
#include "support/kalman_bench.hpp"
#include "support/other_engine.hpp"
extern "C" {
#include "sd_firings.h"
}

namespace sixdeg {
namespace {

using namespace test;

constexpr double kJitter = 0.01;

const sd_kalman_tables_t &diesel_tables() {
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
        other.fuel = {1, 1, 1, fails ? 0.0 : 1.0};
        other.solve();
        return other;
    }
    /// Position 0 of the diesel's wheel is at 270 deg, the teeth of Edges begin at 0.
    void run(const OtherEngine &engine, int cycles, bool fuel_cut) {
        int failed = 0;
        failed_percent = 0;
        constexpr int kShift = 45;
        Edges edges(engine, kJitter, pattern_deg, 7);
        sd_firings_restart(&block);
        torque_nm = 0, firings = 0;
        std::int64_t last_tick = std::llround((edges.at(0) + 1) * double(tables.tick_hz));
        for (int k = 1, last = 0; k < cycles * kCycle; ++k) {
            const int position = (k - kShift + kCycle) % kCycle;
            if (position % kPositions >= 58) continue;
            const std::int64_t tick = std::llround((edges.at(k) + 1) * double(tables.tick_hz));
            sd_firings_tooth_t tooth{};
            tooth.cycle_position = std::uint16_t(position), tooth.position = std::uint16_t(position % kPositions);
            tooth.advance = std::uint16_t(k - last), tooth.period_ticks = std::uint32_t(tick - last_tick);
            tooth.health = SD_VALID, tooth.phase_known = 1, tooth.intake_known = 1, tooth.fuel_cut = fuel_cut ? 1 : 0;
            tooth.intake_bar = float(engine.intake_bar), tooth.speed_radps = float(engine.rpm * M_PI / 30);
            sd_firings_out_t out{};
            sd_firings_step(&block, &tables, &tooth, &out);
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
    void fuel_cut(double rpm, int cycles = 40) { run(engine(rpm, 1, 0), cycles, true); }
    /// Mean of all firings over the true one, less 1, in percent; the engine at 5 bar.
    double level_percent(double rpm) {
        const OtherEngine fired = engine(rpm, 1.2, 750);
        run(fired, 40, false);
        EXPECT_GT(firings, 50);
        return 100 * (torque_nm / fired.firing_nm() - 1);
    }
    const sd_pattern_t &learned() const { return block.pattern; }

    OtherEngine kind;
    double pattern_deg;
    bool fails = false; ///< The last cylinder in firing order gets no fuel.
    double torque_nm = 0, failed_percent = 0; ///< Means of what was read: of firings, and of those that failed, of a true firing.
    int firings = 0;
};

OtherEngine with_gamma(double gamma) {
    OtherEngine engine;
    engine.gamma = gamma;
    return engine;
}

TEST(Exponent, LevelOfTorqueOnAnEngineByOtherEquations) {
    for (double gamma : {1.30, 1.33, 1.35, 1.37}) {
        OtherBench bench(with_gamma(gamma));
        const double before = bench.level_percent(1500);
        bench.fuel_cut(1500);
        const double after = bench.level_percent(1500), fast = bench.level_percent(4500);
        EXPECT_GT(std::abs(before), 1) << "there is something to learn";
        EXPECT_NEAR(after, 0, 1) << gamma << ", " << before << " before";
        EXPECT_NEAR(fast, 0, 3) << gamma << ", learned at 1500 rpm alone";
    }
}

TEST(Exponent, WithAnEngineFileThatIsWrong) {
    for (double gamma : {1.30, 1.33, 1.37}) {
        OtherEngine kind = with_gamma(gamma);
        kind.j0_kgm2 *= 0.97, kind.compression_ratio *= 1.02, kind.wheel_deg = -0.3;
        OtherBench bench(kind);
        const double before = bench.level_percent(1500);
        bench.fuel_cut(1500), bench.fuel_cut(3000);
        const double after = bench.level_percent(1500), fast = bench.level_percent(4500);
        EXPECT_NEAR(after, 0, 6) << before;
        EXPECT_NEAR(fast, 0, 6);
    }
}

TEST(Exponent, WithTheToothPatternOfARealWheel) {
    for (double gamma : {1.30, 1.33, 1.37}) {
        OtherBench bench(with_gamma(gamma), 0.2);
        bench.fuel_cut(1500);
        const double alone = double(bench.learned().exponent), stated = double(bench.learned().exponent_sd);
        EXPECT_GT(stated, 0.03) << "at one speed, so large a pattern may look like it";
        EXPECT_NEAR(bench.level_percent(1500), 0, 2) << "the speed that was learned at";
        bench.fuel_cut(3000);
        EXPECT_NEAR(double(bench.learned().exponent), alone, 2 * stated);
        EXPECT_LT(double(bench.learned().exponent_sd), 0.003) << "two speeds tell";
        EXPECT_NEAR(bench.level_percent(1500), 0, 1);
        EXPECT_NEAR(bench.level_percent(4500), 0, 2);
    }
}

TEST(Exponent, AFiringThatFailsReadsNothing) {
    for (double gamma : {1.30, 1.33, 1.37}) {
        OtherBench bench(with_gamma(gamma));
        bench.fails = true;
        const double before = bench.level_percent(1500);
        bench.fuel_cut(1500);
        EXPECT_LT(std::abs(bench.level_percent(1500)), 1) << before << " before";
        EXPECT_LT(std::abs(bench.failed_percent), 1) << gamma;
    }
}

TEST(Exponent, IsKeptAndTakenUpAgain) {
    OtherBench first(with_gamma(1.31)), second(with_gamma(1.31));
    first.fuel_cut(1500);
    sd_pattern_sums_t sums;
    sd_firings_keep(&first.block, &first.tables, &sums);
    ASSERT_EQ(sd_firings_resume(&second.block, &second.tables, &sums), SD_OK);
    EXPECT_NEAR(second.learned().exponent, first.learned().exponent, 2e-4);
    EXPECT_NEAR(second.level_percent(4500), first.level_percent(4500), 0.2);
}

} // namespace
} // namespace sixdeg
