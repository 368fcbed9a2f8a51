// SPDX-License-Identifier: MIT
// The per-cylinder-input observer on the hybrid engine in closed form, and document 000's benchmark as a whole.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>

#include "studies/observers/observer_bench.hpp"
#include "design/misfire/switched_design.hpp"
#include "common/random.hpp"
extern "C" {
#include "sd_input_observer.h"
}

using namespace sixdeg;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr double kStep = 1e-4, kNoise = 3.5e-4;
constexpr CrankModel kModel{900, 20};

sd_plant_step_t single_precision(const PlantStep &exact) {
    sd_plant_step_t step{};
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 2; ++j) step.increment[i][j] = float(exact.increment[i][j]);
        step.from_input[i] = float(exact.from_input[i]);
    }
    return step;
}

struct Configured {
    sd_plant_step_t step = single_precision(plant_step(kModel, kStep));
    sd_input_config_t config{};
    Configured() {
        config.step = &step;
        config.cylinders = 4;
        config.noise_mps = float(kNoise);
        config.start_speed_mps = 0.3f;
        config.start_accel_mps2 = 50;
        config.start_strength = 0.5f;
        config.walk_strength = 1e-5f;
        config.alarm_sd = 4;
        config.settle_steps = 1257;
    }
};

/// The observer beside the engine; sample by sample.
struct Bench {
    HybridEngine engine;
    HybridState truth = hybrid_periodic_start(engine);
    sd_input_observer_t observer;
    FiringStrength strength;
    RandomStream noise;
    long k = 0;

    explicit Bench(FiringStrength of, unsigned seed = 1) : strength(std::move(of)), noise(seed, 0) {
        const Configured setup;
        EXPECT_EQ(SD_OK, sd_input_init(&observer, &setup.config));
        sd_input_start(&observer, float(truth.speed_mps), 0, nullptr);
    }
    float go(float spoil = 0) {
        const double t0 = double(k) * kStep, t1 = double(++k) * kStep, interval = engine.interval_s();
        truth = hybrid_advance(engine, strength, truth, t0, t1);
        float in[4] = {};
        for (long f = long(t0 / interval); double(f) * interval < t1; ++f) {
            const double part = std::fmin(t1, f * interval + engine.pulse_s()) - std::fmax(t0, f * interval);
            if (part > 0) in[f % 4] += float(engine.pulse_input_mps3() * part / kStep);
        }
        const long firing = long(t1 / interval - 1e-9);
        return sd_input_step(&observer, float(truth.speed_mps + kNoise * noise.normal()) + spoil, in, std::uint8_t(firing % 4));
    }
    sd_input_estimate_t read() const {
        sd_input_estimate_t e;
        sd_input_read(&observer, &e);
        return e;
    }
};

TEST(InputObserver, LearnsEveryCylindersStrengthInOneCycle) {
    const double truth[4] = {1.2, 0, 0.7, 1};
    Bench b([&](long f) { return truth[f % 4]; });
    for (int i = 0; i < 1257; ++i) b.go();
    const sd_input_estimate_t e = b.read();
    for (int n = 0; n < 4; ++n) EXPECT_NEAR(truth[n], e.strength[n], 0.01) << n;
    EXPECT_EQ(SD_VALID, e.status.health);
}

/// The engine's strengths walk as the observer is told; each is compared where its own pulse ends,
/// before it could have walked on.
TEST(InputObserver, StatesItsErrorHonestly) {
    double accel = 0, strength = 0;
    const int runs = 60, cycles = 12;
    for (int seed = 0; seed < runs; ++seed) {
        RandomStream walk(unsigned(seed), 1);
        std::vector<double> truth(4, 1.0);
        for (int f = 4; f < 4 * cycles + 4; ++f) truth.push_back(truth[std::size_t(f - 4)] + walk.normal() * 1e-5 * std::sqrt(0.04 * M_PI / kStep));
        Bench b([&](long f) { return truth[std::size_t(f)]; }, unsigned(seed));
        const int last = 4 * cycles - 1 - seed % 4;
        while (double(b.k + 1) * kStep < last * b.engine.interval_s() + b.engine.pulse_s()) b.go();
        const sd_input_estimate_t e = b.read();
        accel += std::pow((double(e.accel_mps2) - b.truth.accel_mps2) / double(e.accel_sd_mps2), 2) / runs;
        strength += std::pow((double(e.strength[last % 4]) - truth[std::size_t(last)]) / double(e.strength_sd[last % 4]), 2) / runs;
    }
    EXPECT_NEAR(1, std::sqrt(accel), 0.3);
    EXPECT_NEAR(1, std::sqrt(strength), 0.3);
}

TEST(InputObserver, AnAlarmLearnsASuddenMisfireAndItsEnd) {
    Bench b([](long f) { return f == 18 ? 0.0 : 1.0; }); // of the third in firing order
    const auto run_to = [&](double firings) { while (double(b.k) * kStep < firings * b.engine.interval_s()) b.go(); };
    run_to(18);
    EXPECT_EQ(0u, b.observer.alarms);
    run_to(18.9);
    EXPECT_GT(b.observer.alarms, 0u);
    EXPECT_NEAR(0, b.read().strength[2], 0.02);
    run_to(22.9);
    EXPECT_NEAR(1, b.read().strength[2], 0.02);
    const auto alarms = b.observer.alarms;
    run_to(40);
    EXPECT_EQ(alarms, b.observer.alarms);
}

TEST(InputObserver, OneOutlierIsNoAlarm) {
    Bench b([](long) { return 1.0; });
    for (int i = 0; i < 2000; ++i) b.go();
    b.go(5e-3f); // 14 deviations
    for (int i = 0; i < 2000; ++i) EXPECT_NEAR(b.truth.accel_mps2, b.go(), 0.5);
    EXPECT_EQ(0u, b.observer.alarms);
}

TEST(InputObserver, NaNSamplesAreLeftOutAndTooManyEndInvalidUntilTheNextGoodOne) {
    Bench b([](long) { return 1.0; });
    for (int i = 0; i < 2000; ++i) b.go();
    for (int i = 0; i < 12; ++i) EXPECT_NEAR(b.truth.accel_mps2, b.go(kNan), 10);
    EXPECT_EQ(SD_DEGRADED, b.read().status.health);
    EXPECT_EQ(12, b.read().status.rejected);
    EXPECT_NEAR(1, b.read().strength[0], 0.01);
    EXPECT_EQ(0, b.go(kNan));
    EXPECT_EQ(SD_INVALID, b.read().status.health);
    for (int i = 0; i < 3000; ++i) b.go();
    EXPECT_EQ(SD_VALID, b.read().status.health);
    EXPECT_NEAR(b.truth.accel_mps2, b.go(), 1);
}

TEST(InputObserver, SurvivesEveryFloat) {
    Bench b([](long) { return 1.0; });
    std::uint32_t x = 1;
    for (int k = 0; k < 100000; ++k) {
        float in[5];
        for (float &f : in) {
            x = x * 1664525u + 1013904223u;
            std::memcpy(&f, &x, sizeof f);
            if (k % 7) f = std::fmod(f, 100.0f);
        }
        ASSERT_TRUE(std::isfinite(sd_input_step(&b.observer, in[4], in, std::uint8_t(x >> 29))));
        const sd_input_estimate_t e = b.read();
        for (float v : {e.speed_mps, e.accel_mps2, e.accel_sd_mps2, e.strength[0], e.strength_sd[3]}) ASSERT_TRUE(std::isfinite(v));
    }
}

TEST(InputObserver, InitRefusesWhatIsOutOfRange) {
    const auto refused = [](float sd_input_config_t::*field, float value) {
        Configured setup;
        setup.config.*field = value;
        sd_input_observer_t s{};
        s.steps = 77;
        return sd_input_init(&s, &setup.config) == SD_ERR_CONFIG && s.steps == 77;
    };
    static constexpr float sd_input_config_t::*fields[] = {&sd_input_config_t::noise_mps, &sd_input_config_t::start_speed_mps, &sd_input_config_t::start_accel_mps2,
                       &sd_input_config_t::start_strength, &sd_input_config_t::alarm_sd};
    for (const auto field : fields) {
        for (float bad : {kNan, 0.0f, -1.0f, std::numeric_limits<float>::infinity()}) EXPECT_TRUE(refused(field, bad));
    }
    EXPECT_TRUE(refused(&sd_input_config_t::walk_strength, kNan));
    Configured setup;
    setup.step.increment[1][0] = kNan;
    sd_input_observer_t s;
    EXPECT_EQ(SD_ERR_CONFIG, sd_input_init(&s, &setup.config));
}

const BenchRow &find(const std::vector<BenchRow> &rows, const std::string &observer, const std::string &domain, const std::string &condition) {
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
                const BenchRow &healthy = find(rows, observer, "time", "no fault"), &unknown = find(rows, observer, "time", "misfire unknown");
                EXPECT_LT(healthy.high_percent, 0.8) << observer;
                EXPECT_GT(healthy.low_percent, -0.8) << observer;
                EXPECT_GT(healthy.to_two_percent_s, 0.1) << observer;
                EXPECT_GT(unknown.high_percent, 30) << observer << " cannot know";
            }
        }
    }
}

} // namespace
