// SPDX-License-Identifier: MIT
// The score of single firings on errors that are known.
#include <cmath>
#include <gtest/gtest.h>

#include "score/firing_score.hpp"

namespace sixdeg {
namespace {

EngineFile four() {
    EngineFile engine;
    engine.firing_order = {1, 3, 4, 2};
    engine.firing_tdc_deg = {0, 180, 360, 540};
    return engine;
}

/// 40 cycles of 100 Nm; every firing is read 300 deg after its TDC, `offset` Nm high, that of cylinder 4 `error` more.
FiringScore score_of(double offset, double error, bool valid = true) {
    FiringScore score(four());
    const EngineFile engine = four();
    for (int cycle = 0; cycle < 40; ++cycle) {
        for (std::size_t lane = 0; lane < 4; ++lane) {
            CycleTruth truth;
            truth.cycle = cycle, truth.cylinder = engine.firing_order[lane];
            truth.combustion_torque_nm = 100, truth.tdc_speed_radps = 200;
            score.truth(truth);
            const double said = 100 + offset + (truth.cylinder == 4 ? error : 0);
            score.said(720.0 * cycle + engine.firing_tdc_deg[lane] + 300, truth.cylinder, said, 2, said, 1, valid);
        }
    }
    return score;
}

TEST(FiringScore, TakesTheCommonErrorOutAndNamesIt) {
    const auto figures = score_of(5, 0).result();
    ASSERT_TRUE(figures);
    EXPECT_EQ(figures->cycles, 40 - FiringScore::kSettleCycles);
    EXPECT_NEAR(figures->bias_percent, 5, 1e-9);
    EXPECT_NEAR(figures->single_percent, 0, 1e-9);
    EXPECT_NEAR(figures->mean_radps, 200, 1e-9);
}

TEST(FiringScore, OneCylinderOffByFourIsThreeAndMinusOne) {
    const auto figures = score_of(0, 4).result();
    ASSERT_TRUE(figures);
    const double rms = std::sqrt((9 + 3 * 1) / 4.0);
    EXPECT_NEAR(figures->single_percent, rms, 1e-9);
    EXPECT_NEAR(figures->imbalance_percent, rms, 1e-9);
    EXPECT_NEAR(figures->single_max_percent, 3, 1e-9);
    EXPECT_NEAR(figures->single_honesty, rms / 2, 1e-9);
    EXPECT_NEAR(figures->imbalance_honesty, rms / 1, 1e-9);
}

TEST(FiringScore, CountsNothingThatWasNotSaidToBeValid) { EXPECT_FALSE(score_of(0, 4, false).result()); }

} // namespace
} // namespace sixdeg
