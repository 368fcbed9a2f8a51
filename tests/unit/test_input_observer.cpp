// SPDX-License-Identifier: MIT
// The per-cylinder-input observer on the hybrid engine in closed form, and document 000's benchmark as a whole.
#include <cmath>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <stdexcept>

#include "common/random.hpp"
#include "studies/observers/input_observer.hpp"
#include "studies/observers/observer_bench.hpp"

using namespace sixdeg;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kStep = 1e-4, kNoise = 3.5e-4;
constexpr CrankModel kModel{900, 20};

InputConfig configured() {
    InputConfig config{};
    config.step = plant_step(kModel, kStep);
    config.inputs = 4;
    config.noise = kNoise;
    config.start_speed = 0.3;
    config.start_accel = 50;
    config.start_strength = 0.5;
    config.walk_strength = 1e-5;
    config.alarm_sd = 4;
    config.settle_steps = 1257;
    return config;
}

/// The observer beside the engine; sample by sample.
struct Bench {
    HybridEngine engine;
    HybridState truth = hybrid_periodic_start(engine);
    InputObserver observer{configured()};
    FiringStrength strength;
    RandomStream noise;
    long k = 0;

    explicit Bench(FiringStrength of, unsigned seed = 1) : strength(std::move(of)), noise(seed, 0) { observer.start(truth.speed_mps, 0); }
    double go(double spoil = 0) {
        const double t0 = double(k) * kStep, t1 = double(++k) * kStep, interval = engine.interval_s();
        truth = hybrid_advance(engine, strength, truth, t0, t1);
        std::vector<double> in(4, 0.0);
        for (long f = long(t0 / interval); double(f) * interval < t1; ++f)
            in[std::size_t(f % 4)] += engine.mean_input(t0 - f * interval, t1 - f * interval);
        const long firing = long(t1 / interval - 1e-9);
        return observer.step(truth.speed_mps + kNoise * noise.normal() + spoil, in, int(firing % 4));
    }
};

TEST(InputObserver, LearnsEveryCylindersStrengthInOneCycle) {
    const double truth[4] = {1.2, 0, 0.7, 1};
    Bench b([&](long f) { return truth[f % 4]; });
    for (int i = 0; i < 1257; ++i) b.go();
    for (int n = 0; n < 4; ++n) EXPECT_NEAR(truth[n], b.observer.strength(n), 0.01) << n;
    EXPECT_EQ(SD_VALID, b.observer.health());
}

/// The engine's strengths walk as the observer is told; each is compared where its own pulse ends,
/// before it could have walked on.
TEST(InputObserver, StatesItsErrorHonestly) {
    double accel = 0, strength = 0;
    const int runs = 60, cycles = 12;
    for (int seed = 0; seed < runs; ++seed) {
        RandomStream walk(unsigned(seed), 1);
        std::vector<double> truth(4, 1.0);
        for (int f = 4; f < 4 * cycles + 4; ++f)
            truth.push_back(truth[std::size_t(f - 4)] + walk.normal() * 1e-5 * std::sqrt(0.04 * M_PI / kStep));
        Bench b([&](long f) { return truth[std::size_t(f)]; }, unsigned(seed));
        const int last = 4 * cycles - 1 - seed % 4;
        while (double(b.k + 1) * kStep < last * b.engine.interval_s() + b.engine.pulse_s()) b.go();
        accel += std::pow((b.observer.accel() - b.truth.accel_mps2) / b.observer.accel_sd(), 2) / runs;
        strength += std::pow((b.observer.strength(last % 4) - truth[std::size_t(last)]) / b.observer.strength_sd(last % 4), 2) / runs;
    }
    EXPECT_NEAR(1, std::sqrt(accel), 0.3);
    EXPECT_NEAR(1, std::sqrt(strength), 0.3);
}

TEST(InputObserver, AnAlarmLearnsASuddenMisfireAndItsEnd) {
    Bench b([](long f) { return f == 18 ? 0.0 : 1.0; }); // of the third in firing order
    const auto run_to = [&](double firings) { while (double(b.k) * kStep < firings * b.engine.interval_s()) b.go(); };
    run_to(18);
    EXPECT_EQ(0, b.observer.alarms());
    run_to(18.9);
    EXPECT_GT(b.observer.alarms(), 0);
    EXPECT_NEAR(0, b.observer.strength(2), 0.02);
    run_to(22.9);
    EXPECT_NEAR(1, b.observer.strength(2), 0.02);
    const long alarms = b.observer.alarms();
    run_to(40);
    EXPECT_EQ(alarms, b.observer.alarms());
}

TEST(InputObserver, OneOutlierIsNoAlarm) {
    Bench b([](long) { return 1.0; });
    for (int i = 0; i < 2000; ++i) b.go();
    b.go(5e-3); // 14 deviations
    for (int i = 0; i < 2000; ++i) EXPECT_NEAR(b.truth.accel_mps2, b.go(), 0.5);
    EXPECT_EQ(0, b.observer.alarms());
}

TEST(InputObserver, NaNSamplesAreLeftOutAndTooManyEndInvalidUntilTheNextGoodOne) {
    Bench b([](long) { return 1.0; });
    for (int i = 0; i < 2000; ++i) b.go();
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(b.truth.accel_mps2, b.go(kNan), 10);
    EXPECT_EQ(SD_DEGRADED, b.observer.health());
    EXPECT_EQ(12, b.observer.rejected());
    EXPECT_NEAR(1, b.observer.strength(0), 0.01);
    EXPECT_EQ(0, b.go(kNan));
    EXPECT_EQ(SD_INVALID, b.observer.health());
    for (int i = 0; i < 3000; ++i) b.go();
    EXPECT_EQ(SD_VALID, b.observer.health());
    EXPECT_NEAR(b.truth.accel_mps2, b.go(), 1);
}

TEST(InputObserver, SurvivesEveryFloat) {
    Bench b([](long) { return 1.0; });
    std::uint32_t x = 1;
    for (int k = 0; k < 100000; ++k) {
        std::vector<double> in(5);
        for (double &value : in) {
            x = x * 1664525u + 1013904223u;
            float f;
            std::memcpy(&f, &x, sizeof f);
            value = k % 7 ? std::fmod(double(f), 100.0) : double(f);
        }
        const double y = in.back();
        in.pop_back();
        ASSERT_TRUE(std::isfinite(b.observer.step(y, in, int(x >> 29))));
        if (!b.observer.running()) continue;
        for (double v : {b.observer.speed(), b.observer.accel(), b.observer.accel_sd(), b.observer.strength(0), b.observer.strength_sd(3)})
            ASSERT_TRUE(std::isfinite(v));
    }
}

TEST(InputObserver, RefusesWhatIsOutOfRange) {
    const auto refused = [](double InputConfig::*field, double value) {
        InputConfig config = configured();
        config.*field = value;
        try {
            InputObserver observer(config);
        } catch (const std::invalid_argument &) {
            return true;
        }
        return false;
    };
    EXPECT_FALSE(refused(&InputConfig::noise, kNoise));
    for (const auto field : {&InputConfig::noise, &InputConfig::start_speed, &InputConfig::start_accel, &InputConfig::start_strength,
                             &InputConfig::alarm_sd}) {
        for (double bad : {kNan, 0.0, -1.0, std::numeric_limits<double>::infinity()}) EXPECT_TRUE(refused(field, bad));
    }
    EXPECT_TRUE(refused(&InputConfig::walk_strength, kNan));
    InputConfig config = configured();
    config.step.increment[1][0] = kNan;
    EXPECT_THROW(InputObserver{config}, std::invalid_argument);
}

const BenchRow &find(const std::vector<BenchRow> &rows, const std::string &observer, const std::string &domain,
                     const std::string &condition) {
    for (const BenchRow &row : rows) {
        if (row.observer == observer && row.domain == domain && row.condition == condition) return row;
    }
    throw std::logic_error("no such row");
}

/// The goal: within 0.2 % and converged to 1 % within 0.10 s in all rows at once; and the rows of the document.
TEST(ObserverBench, OursMeetsTheGoalInEveryRowAndTheDocumentsDoNot) {
    HybridEngine table_2, crank_order;
    crank_order.k1_per_s2 = 1e4;
    crank_order.k2_per_s = 30;
    for (unsigned seed : {1u, 2u, 3u}) {
        for (const auto &[engine, gains] : {std::pair{table_2, BenchGains{4 / 0.12 - 20, 1000, 40}},
                                            std::pair{crank_order, BenchGains{4 / 0.12 - 30, 2e4, 40}}}) {
            const auto rows = run_observer_bench(engine, gains, seed);
            for (const char *condition : {"no fault", "misfire known", "misfire unknown", "offsets unknown"}) {
                const BenchRow &row = find(rows, "ours", "time", condition);
                EXPECT_GT(row.early_low_percent, -0.2) << condition;
                EXPECT_LT(row.early_high_percent, 0.2) << condition;
                EXPECT_LE(row.to_one_percent_s, 0.10) << condition;
            }
            for (const char *observer : {"ROO", "FOSMO", "FOLSMO"}) {
                const BenchRow &healthy = find(rows, observer, "time", "no fault"),
                    &unknown = find(rows, observer, "time", "misfire unknown");
                EXPECT_LT(healthy.high_percent, 0.8) << observer;
                EXPECT_GT(healthy.low_percent, -0.8) << observer;
                EXPECT_GT(healthy.to_two_percent_s, 0.1) << observer;
                EXPECT_GT(unknown.high_percent, 30) << observer << " cannot know";
            }
        }
    }
}

} // namespace
