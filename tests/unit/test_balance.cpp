// SPDX-License-Identifier: MIT
// The fuel balance against closed forms, its limits, and a loop that runs the wrong way.
#include <cmath>
#include <gtest/gtest.h>
#include <vector>

extern "C" {
#include "sd_balance.h"
}

namespace {

constexpr sd_balance_config_t kConfig{4, 0.1f, 0.05f, 0.2f, 0.1f, 4};

struct Loop {
    explicit Loop(sd_balance_config_t config = kConfig) { EXPECT_EQ(sd_balance_init(&b, &config), SD_OK); }
    /// One cycle; `sign` 1: a trim acts as it should.
    void cycle(std::uint8_t health = SD_VALID, bool transient = false, float stated = 0.01f, float sign = 1) {
        float deviation[4], mean = 0;
        for (int i = 0; i < 4; ++i) mean += (offset[i] + sign * b.trim[i]) / 4;
        for (int i = 0; i < 4; ++i) deviation[i] = offset[i] + sign * b.trim[i] - mean;
        const float sd[4] = {stated, stated, stated, stated};
        sd_balance_step(&b, deviation, sd, health, transient);
        worst = 0;
        for (float d : deviation) worst = std::max(worst, std::fabs(d));
    }
    float sum() const { return b.trim[0] + b.trim[1] + b.trim[2] + b.trim[3]; }
    sd_balance_t b;
    float offset[4] = {0.1f, 0, -0.04f, 0};
    float worst = 0;
};

TEST(Balance, DeviationsShrinkByTheGainEachCycle) {
    Loop loop;
    loop.cycle();
    const float first = loop.worst;
    for (int k = 0; k < 20; ++k) loop.cycle();
    EXPECT_NEAR(loop.worst / first, std::pow(0.9, 20), 1e-3);
    EXPECT_NEAR(loop.sum(), 0, 1e-6);
    EXPECT_EQ(sd_balance_status(&loop.b).health, SD_VALID);
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
        sd_balance_step(&l.b, bad, sd, SD_VALID, 0);
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

TEST(Balance, ALoopOfTheWrongSignIsCaught) {
    Loop loop;
    loop.offset[0] = 0.02f, loop.offset[2] = -0.02f;
    float largest = 0;
    int k = 0;
    for (; k < 500 && loop.b.diverged == 0; ++k) {
        loop.cycle(SD_VALID, false, 0.005f, -1);
        for (float t : loop.b.trim) largest = std::max(largest, std::fabs(t));
    }
    EXPECT_LT(k, 500);
    EXPECT_EQ(sd_balance_status(&loop.b).health, SD_INVALID);
    EXPECT_EQ(loop.b.trim[0], 0);
    EXPECT_LE(largest, 0.2f);
    loop.cycle();
    EXPECT_EQ(loop.b.trim[0], 0); // until it is restarted
    sd_balance_restart(&loop.b);
    for (int i = 0; i < 6; ++i) loop.cycle();
    EXPECT_NE(loop.b.trim[0], 0);
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
             [](sd_balance_config_t &c) { c.gain = 0; }, [](sd_balance_config_t &c) { c.rate = NAN; },
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
