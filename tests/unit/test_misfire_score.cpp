// SPDX-License-Identifier: MIT
// Verdicts against truth: bounds of rates against published ones, and who is counted how.
#include <cmath>
#include <gtest/gtest.h>

#include "score/misfire_score.hpp"
extern "C" {
#include "sd_misfire.h"
}

using namespace sixdeg;

namespace {

TEST(RateBounds, AreThoseOfClopperAndPearson) {
    // Zero and all hits have closed forms: 1 - 0.025^(1/n).
    for (std::uint64_t n : {10u, 1000u, 20000u}) {
        const double edge = 1 - std::pow(0.025, 1.0 / double(n));
        EXPECT_NEAR(rate_bounds(0, n).high, edge, 1e-6 * edge + 1e-9);
        EXPECT_NEAR(1 - rate_bounds(n, n).low, edge, 1e-6);
        EXPECT_EQ(0, rate_bounds(0, n).low);
        EXPECT_EQ(1, rate_bounds(n, n).high);
    }
    // One of two: solutions of (1 - p)^2 = 0.975 and p^2 = 0.975.
    EXPECT_NEAR(1 - std::sqrt(0.975), rate_bounds(1, 2).low, 1e-9);
    EXPECT_NEAR(std::sqrt(0.975), rate_bounds(1, 2).high, 1e-9);
    // Many trials: the normal approximation.
    EXPECT_NEAR(0.3 - 1.96 * std::sqrt(0.21 / 1e6), rate_bounds(300000, 1000000).low, 2e-6);
    EXPECT_EQ(0, rate_bounds(0, 0).low);
    EXPECT_EQ(1, rate_bounds(0, 0).high);
}

EngineFile engine() {
    EngineFile e;
    e.firing_order = {1, 3, 4, 2};
    e.firing_tdc_deg = {0, 180, 360, 540};
    return e;
}

CycleTruth combustion(std::int64_t cycle, int cylinder, double burned) {
    CycleTruth t;
    t.cycle = cycle;
    t.cylinder = cylinder;
    t.burned_fraction = burned;
    return t;
}

TEST(MisfireScore, CountsEveryCaseOnce) {
    MisfireScore score(engine());
    const auto both = [&](std::int64_t cycle, int cylinder, double burned, int verdict) {
        const double tdc = cylinder == 1 ? 0 : cylinder == 3 ? 180 : cylinder == 4 ? 360 : 540;
        score.said(720 * double(cycle) + tdc + 300, cylinder, verdict, burned);
        score.truth(combustion(cycle, cylinder, burned));
    };
    both(0, 1, 1, SD_HEALTHY);
    both(0, 3, 0, SD_MISFIRE);
    both(0, 4, 1, SD_HEALTHY);
    both(0, 2, 0.7, SD_PARTIAL_BURN);
    both(1, 1, 0, SD_HEALTHY); // overlooked, and the next one accused: the wrong cylinder
    both(1, 3, 1, SD_MISFIRE);
    both(1, 4, 1, SD_PARTIAL_BURN);
    both(1, 2, 1, SD_HEALTHY);
    both(2, 1, 1, SD_MISFIRE); // out of the blue
    both(2, 3, 0, SD_NOT_JUDGED);
    score.truth(combustion(2, 4, 1)); // nothing was said
    const MisfireFigures f = score.result();
    EXPECT_EQ(6u, f.healthy);
    EXPECT_EQ(2u, f.false_alarms);
    EXPECT_EQ(1u, f.wrong_cylinder);
    EXPECT_EQ(2u, f.missed);
    EXPECT_EQ(1u, f.detected);
    EXPECT_EQ(1u, f.partial);
    EXPECT_EQ(1u, f.partial_found);
    EXPECT_EQ(1u, f.healthy_as_partial);
    EXPECT_EQ(2u, f.not_judged);
    EXPECT_EQ(1u, f.not_judged_misfires);
    ASSERT_NE(nullptr, score.verdict(0, 3));
    EXPECT_EQ(SD_MISFIRE, score.verdict(0, 3)->first);
    EXPECT_EQ(nullptr, score.verdict(2, 4));
}

} // namespace
