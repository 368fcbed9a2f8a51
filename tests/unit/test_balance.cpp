// SPDX-License-Identifier: MIT
// The fuel balance against closed forms, its limits, and a loop that runs the wrong way.
#include <algorithm>
#include <cmath>
#include <complex>
#include <gtest/gtest.h>
#include <vector>

#include "common/random.hpp"

extern "C" {
#include "sd_balance.h"
}

namespace {

constexpr sd_balance_config_t kConfig{4, 0.1f, 0, 0.05f, 0.2f, 0.1f, 4};

sd_balance_input_t input(const float *deviation, const float *sd, std::uint8_t health = SD_VALID, bool transient = false,
                         float follow = 0.5f) {
    return {deviation, sd, follow, 1, health, std::uint8_t(transient)};
}

/// A whole cycle; returns its pieces.
int work(sd_balance_t &b, const sd_balance_input_t &in) {
    sd_balance_begin(&b, &in);
    int pieces = 1;
    while (sd_balance_work(&b)) ++pieces;
    return pieces;
}

struct Loop {
    explicit Loop(sd_balance_config_t config = kConfig) { EXPECT_EQ(sd_balance_init(&b, &config), SD_OK); }
    /// One cycle.
    void cycle(std::uint8_t health = SD_VALID, bool transient = false, float stated = 0) {
        float deviation[4], mean = 0;
        for (int i = 0; i < 4; ++i) mean += (offset[i] + b.trim[i]) / 4;
        for (int i = 0; i < 4; ++i) deviation[i] = offset[i] + b.trim[i] - mean;
        const float sd[4] = {stated, stated, stated, stated};
        const sd_balance_input_t in = input(deviation, sd, health, transient);
        work(b, in);
        worst = 0;
        for (float d : deviation) worst = std::max(worst, std::fabs(d));
    }
    float sum() const { return b.trim[0] + b.trim[1] + b.trim[2] + b.trim[3]; }
    sd_balance_t b;
    float offset[4] = {0.1f, 0, -0.04f, 0};
    float worst = 0;
};

/// An estimate that takes up a share of what it has not seen each cycle, knows of the trims, and turns every pattern over the
/// cylinders by its order times half the delay's error.
struct Turned {
    Turned(int cylinders, double delay_deg)
        : n(cylinders), delay_rad(delay_deg * M_PI / 180), random(3, 1) {
        sd_balance_config_t c = kConfig;
        c.cylinders = std::uint8_t(n), c.gain = 0.25f;
        EXPECT_EQ(sd_balance_init(&b, &c), SD_OK);
        estimate.assign(std::size_t(n), 0), told = estimate, offset = estimate;
        for (int i = 0; i < n; ++i) offset[std::size_t(i)] = 0.08 * std::sin(1.1 * i + 0.3);
    }
    std::vector<double> turned(const std::vector<double> &x) const {
        std::vector<double> y(x.size(), 0.0);
        for (int m = 0; m < n; ++m) {
            const int order = 2 * m <= n ? m : m - n;
            std::complex<double> pattern = 0;
            for (int i = 0; i < n; ++i) pattern += x[std::size_t(i)] * std::polar(1.0 / n, -2 * M_PI * m * i / n);
            for (int i = 0; i < n; ++i)
                y[std::size_t(i)] += (pattern * std::polar(1.0, 2 * M_PI * m * i / n + order * delay_rad / 2)).real();
        }
        return y;
    }
    void cycle() {
        constexpr double kFollow = 0.3;
        std::vector<double> gas = offset;
        for (std::size_t i = 0; i < gas.size(); ++i) gas[i] += double(b.trim[i]);
        const std::vector<double> seen = turned(gas);
        float deviation[8], sd[8];
        for (std::size_t i = 0; i < gas.size(); ++i) {
            estimate[i] += double(b.trim[i]) - told[i];
            told[i] = double(b.trim[i]);
            estimate[i] += kFollow * (seen[i] - estimate[i]) + noise * std::sqrt(2 * kFollow) * random.normal();
            deviation[i] = float(estimate[i]), sd[i] = float(noise);
        }
        spread = *std::max_element(gas.begin(), gas.end()) - *std::min_element(gas.begin(), gas.end());
        const sd_balance_input_t in = input(deviation, sd, SD_VALID, false, float(kFollow));
        work(b, in);
    }
    int n;
    double delay_rad, spread = 0;
    static constexpr double noise = 0.02;
    sixdeg::RandomStream random;
    std::vector<double> estimate, told, offset;
    sd_balance_t b;
};

/// The PI law: a change of the deviations moves the trims at once by P, what stays of them by the gain; and across a hold nothing
/// is known of a change.
TEST(Balance, AProportionalPartAnswersToChanges) {
    sd_balance_config_t config = kConfig;
    config.rate = 1, config.limit = 0.5f, config.proportional = 0.4f;
    Loop with(config);
    config.proportional = 0;
    Loop without(config);
    for (Loop *loop : {&with, &without}) {
        for (int k = 0; k < 200; ++k) loop->cycle();
        EXPECT_LT(loop->worst, 1e-4f) << "both settle at the same trims";
        EXPECT_NEAR(loop->b.trim[0], -0.085f, 1e-3f);
        loop->offset[0] += 0.04f; // a deviation of 0.03 in the first, and -0.01 in the others
        const float before = loop->b.trim[0];
        loop->cycle();
        const float gain = 0.1f * (0.5f + 0.5f * (1 - loop->b.noise / loop->b.mean_square));
        EXPECT_NEAR(loop->b.trim[0] - before, -0.03f * (gain + (loop == &with ? 0.4f : 0)), 2e-4f);
    }
    with.cycle(SD_INVALID);
    const float held = with.b.trim[0];
    for (int k = 0; k < 4; ++k) with.cycle();
    with.offset[0] += 0.04f;
    with.cycle();
    EXPECT_GT(with.b.trim[0], held - 0.1f * 0.07f) << "no answer to a change that was not seen";
}

TEST(Balance, DeviationsShrinkByTheGainEachCycle) {
    Loop loop;
    loop.cycle();
    const float first = loop.worst;
    for (int k = 0; k < 20; ++k) loop.cycle();
    EXPECT_NEAR(loop.worst / first, std::pow(0.9, 20), 1e-3);
    EXPECT_NEAR(loop.sum(), 0, 1e-6);
    EXPECT_EQ(sd_balance_status(&loop.b).health, SD_VALID);
}

// The work of a cycle comes in pieces: trims move with the last of them, and a cycle that ends earlier, a restart or a mended
// estimate leave the rest out.
TEST(Balance, MovesTrimsWithTheLastPiece) {
    Loop loop;
    const float deviation[4] = {0.1f, -0.1f, 0, 0}, sd[4] = {};
    const sd_balance_input_t in = input(deviation, sd);
    sd_balance_begin(&loop.b, &in);
    int pieces = 0;
    for (bool more = true; more; ++pieces) {
        EXPECT_EQ(loop.b.trim[0], 0) << pieces;
        more = sd_balance_work(&loop.b);
    }
    EXPECT_EQ(pieces, 3) << "two orders of the watch, then learning";
    EXPECT_LT(loop.b.trim[0], 0);
    const float before = loop.b.trim[0];
    EXPECT_FALSE(sd_balance_work(&loop.b));
    for (int way = 0; way < 2; ++way) {
        sd_balance_begin(&loop.b, &in);
        EXPECT_TRUE(sd_balance_work(&loop.b));
        way == 0 ? sd_balance_resume(&loop.b) : sd_balance_restart(&loop.b);
        EXPECT_FALSE(sd_balance_work(&loop.b));
        EXPECT_EQ(loop.b.trim[0], way == 0 ? before : 0);
        if (way == 0) for (int k = 0; k < 4; ++k) work(loop.b, in);
    }
}

TEST(Balance, HoldsWhileNotTrusted) {
    const auto held = [](auto &&cycle) {
        Loop loop;
        for (int k = 0; k < 20; ++k) loop.cycle();
        const float before = loop.b.trim[0];
        for (int k = 0; k < 10; ++k) cycle(loop);
        for (int k = 0; k < 4; ++k) loop.cycle(); // and for hold_cycles after
        EXPECT_EQ(loop.b.trim[0], before);
        EXPECT_EQ(sd_balance_status(&loop.b).health, SD_VALID);
        loop.cycle();
        EXPECT_NE(loop.b.trim[0], before);
    };
    held([](Loop &l) { l.cycle(SD_DEGRADED); });
    held([](Loop &l) { l.cycle(SD_VALID, true); });
    held([](Loop &l) { l.cycle(SD_VALID, false, 0.2f); });
    held([](Loop &l) { l.cycle(SD_VALID, false, NAN); });
    held([](Loop &l) {
        const float bad[4] = {NAN, 0, 0, 0}, sd[4] = {};
        const sd_balance_input_t in = input(bad, sd);
        work(l.b, in);
    });
    held([](Loop &l) {
        const float huge[4] = {INFINITY, -INFINITY, 1e30f, 0}, sd[4] = {};
        const sd_balance_input_t in = input(huge, sd);
        work(l.b, in);
    });
    held([](Loop &l) {
        const float deviation[4] = {0.1f, -0.1f, 0, 0}, sd[4] = {};
        const sd_balance_input_t in = input(deviation, sd, SD_VALID, false, NAN);
        work(l.b, in);
    });
}

TEST(Balance, LimitsRateAndLeavesALimitAtOnce) {
    Loop loop;
    loop.offset[0] = 0.9f;
    loop.cycle();
    for (float t : loop.b.trim)
        EXPECT_LE(std::fabs(t), 2 * 0.05f * 3 / 4); // rate, and the mean of four taken off
    for (int k = 0; k < 30; ++k) loop.cycle();
    for (float t : loop.b.trim) EXPECT_LE(std::fabs(t), 0.2f);
    EXPECT_EQ(sd_balance_status(&loop.b).health, SD_DEGRADED);
    const float at_limit = loop.b.trim[0];
    loop.offset[0] = -0.4f;
    loop.cycle();
    EXPECT_GT(loop.b.trim[0], at_limit + 0.02f);
}

/// Half of the delay error that makes the fastest pattern unstable, and twice it, whatever the number of cylinders.
TEST(Balance, ADelayThatTheLoopStandsIsNotTakenForAWrongPhase) {
    for (int n : {2, 3, 4, 5, 6, 8}) {
        for (double error : {-0.6, -0.3, 0.0, 0.3, 0.6}) {
            Turned loop(n, error * 360 / n);
            for (int k = 0; k < 400; ++k) {
                loop.cycle();
                ASSERT_EQ(loop.b.diverged, 0) << n << " cylinders, " << error << ", cycle " << k;
            }
            EXPECT_LT(loop.spread, 0.08) << n << " cylinders, " << error;
        }
    }
}

TEST(Balance, AWrongPhaseIsCaughtBeforeMuchHarmIsDone) {
    for (int n : {2, 3, 4, 5, 6, 8}) {
        for (double error : {-2.0, -1.6, 1.6, 2.0}) {
            Turned loop(n, error * 360 / n);
            loop.cycle();
            const double before = loop.spread;
            double largest = 0;
            int k = 0;
            for (; k < 100 && loop.b.diverged == 0; ++k) {
                loop.cycle();
                largest = std::max(largest, loop.spread);
            }
            EXPECT_LT(k, 60) << n << " cylinders, " << error;
            EXPECT_LT(largest, before + 0.2) << n << " cylinders, " << error;
            EXPECT_EQ(sd_balance_status(&loop.b).health, SD_INVALID);
            EXPECT_EQ(sd_balance_status(&loop.b).why, SD_WHY_FAULT);
            for (int i = 0; i < 20; ++i) loop.cycle();
            for (int i = 0; i < n; ++i) EXPECT_EQ(loop.b.trim[i], 0); // back, and there until it is restarted
        }
    }
}

TEST(Balance, TrimsOfALoopThatGaveUpGoBackWithTheRateAndARestartBegins) {
    Loop loop;
    for (int k = 0; k < 40; ++k) loop.cycle();
    const float before = loop.b.trim[0];
    ASSERT_LT(before, -kConfig.rate);
    loop.b.diverged = 1;
    loop.cycle();
    EXPECT_FLOAT_EQ(loop.b.trim[0], before + kConfig.rate);
    for (int k = 0; k < 5; ++k) loop.cycle();
    EXPECT_EQ(loop.b.trim[0], 0);
    sd_balance_restart(&loop.b);
    for (int i = 0; i < 6; ++i) loop.cycle();
    EXPECT_NE(loop.b.trim[0], 0);
}

/// Close to the noise there is less to gain: the gain falls to half of itself where noise explains all.
TEST(Balance, LearnsSlowlyFromWhatNoiseExplains) {
    const auto moved = [](float stated) {
        Loop loop;
        loop.cycle(SD_VALID, false, stated);
        return -loop.b.trim[0] / loop.worst;
    };
    EXPECT_NEAR(moved(0), 0.1, 1e-6);
    EXPECT_NEAR(moved(0.09f), 0.05, 1e-6);
    const float square = (0.085f * 0.085f + 0.055f * 0.055f + 2 * 0.015f * 0.015f) / 4;
    EXPECT_NEAR(moved(0.03f), 0.1 * (0.5 + 0.5 * (1 - 0.03 * 0.03 / square)), 1e-6);
}

TEST(Balance, AStepOfAnInjectorIsNotTakenForDivergence) {
    Loop loop;
    for (int k = 0; k < 100; ++k) loop.cycle();
    loop.offset[1] = 0.15f;
    for (int k = 0; k < 100; ++k) {
        loop.cycle();
        ASSERT_NE(sd_balance_status(&loop.b).health, SD_INVALID) << k;
    }
    EXPECT_LT(loop.worst, 1e-3f);
}

TEST(Balance, RefusesBadConfigurations) {
    sd_balance_t b;
    for (auto change : std::vector<void (*)(sd_balance_config_t &)>{
             [](sd_balance_config_t &c) { c.cylinders = 1; }, [](sd_balance_config_t &c) { c.cylinders = 9; },
             [](sd_balance_config_t &c) { c.gain = 0; }, [](sd_balance_config_t &c) { c.proportional = 1.5f; },
                 [](sd_balance_config_t &c) { c.rate = NAN; },
             [](sd_balance_config_t &c) { c.limit = 0.6f; }, [](sd_balance_config_t &c) { c.sd_max = -1; }}) {
        sd_balance_config_t c = kConfig;
        change(c);
        EXPECT_EQ(sd_balance_init(&b, &c), SD_ERR_CONFIG);
    }
}

TEST(Balance, OtherChoicesOnTheWayKeepTheTrimsWithinTheNewLimit) {
    Loop loop;
    for (int k = 0; k < 60; ++k) loop.cycle();
    const float before = loop.b.trim[2];
    ASSERT_LT(loop.b.trim[0], -0.07f);
    sd_balance_config_t config = kConfig;
    config.gain = 0.5f;
    ASSERT_EQ(sd_balance_configure(&loop.b, &config), SD_OK);
    EXPECT_EQ(loop.b.trim[2], before);
    loop.offset[2] += 0.04f;
    loop.cycle();
    EXPECT_NEAR(loop.b.trim[2] - before, -0.5f * 0.03f, 2e-3f) << "the new gain";
    config.limit = 0.05f;
    ASSERT_EQ(sd_balance_configure(&loop.b, &config), SD_OK);
    EXPECT_EQ(loop.b.trim[0], -0.05f);
    config.limit = 0.6f;
    EXPECT_EQ(sd_balance_configure(&loop.b, &config), SD_ERR_CONFIG);
    EXPECT_EQ(loop.b.config.limit, 0.05f);
}

} // namespace
