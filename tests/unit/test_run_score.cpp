// SPDX-License-Identifier: MIT
// The figures and the alignment of `sixdeg run`, in closed form.
#include <cmath>
#include <gtest/gtest.h>

#include "plant/engine/units.hpp"
#include "io/tables/run_tables.hpp"
#include "score/torque_score.hpp"

using namespace sixdeg;

namespace {

constexpr int kSteps = 1440, kHarmonics = 5;
constexpr double kAmplitude = 100, kBeyond = 20; // of harmonics 4 and 9

double wave(double deg, double beyond) {
    return kAmplitude * std::cos(2 * deg * kRadPerDeg) + beyond * std::sin(4.5 * deg * kRadPerDeg);
}

/// Cycles of 60-2 teeth whose estimate holds harmonic 4 only and comes `late_deg` after the truth.
std::optional<TorqueFigures> figures(double late_deg, int cycles, int unsettled = -1) {
    TorqueScore score(kHarmonics, kSteps, 3);
    for (int i = 0; i < cycles * kSteps; ++i) {
        StepTruth step;
        step.angle_rad = 4 * kPi * i / kSteps;
        step.net_torque_nm = wave(720.0 * i / kSteps, kBeyond);
        score.steps({step});
    }
    for (int k = 0; k < cycles * 120; ++k) {
        if (k % 60 >= 58) continue;
        score.edge(6.0 * k, wave(6.0 * k, kBeyond), wave(6.0 * k - late_deg, 0), k / 120 != unsettled);
    }
    return score.result();
}

TEST(TorqueScore, ShiftIsPositiveWhenTheEstimateComesLate) {
    EXPECT_NEAR(figures(0.3, 4)->shift_deg, 0.3, 1e-6);
    EXPECT_NEAR(figures(-7.5, 4)->shift_deg, -7.5, 1e-6);
}

TEST(TorqueScore, RmsAgainstTruthAndAgainstItsFirstHarmonics) {
    const TorqueFigures f = *figures(0, 4);
    EXPECT_NEAR(f.truncation_percent, 100 * kBeyond / std::sqrt(2.0) / f.true_pp_nm, 1e-6);
    EXPECT_NEAR(f.rms_projection_percent, 0, 1e-6);
    EXPECT_NEAR(f.rms_true_percent, f.truncation_percent, 0.02 * f.truncation_percent); // teeth, not steps
    // An error of 2 sin(2 x 0.5 deg / 2) of the amplitude.
    EXPECT_NEAR(figures(0.5, 4)->rms_projection_percent,
                100 * kAmplitude * 2 * std::sin(0.5 * kRadPerDeg) / std::sqrt(2.0) / f.true_pp_nm, 0.02);
}

TEST(TorqueScore, OnlySettledCyclesCountAndNoMoreThanAsked) {
    EXPECT_FALSE(figures(0, 1)) << "a cycle is complete when the next one begins";
    EXPECT_EQ(figures(0, 3)->cycles, 2);
    EXPECT_EQ(figures(0, 3, 1)->cycles, 1);
    EXPECT_EQ(figures(0, 9)->cycles, 3);
}

EngineFile diesel() {
    EngineFile engine;
    engine.firing_order = {1, 3, 4, 2};
    engine.firing_tdc_deg = {0, 180, 360, 540};
    engine.position_0_deg = 270;
    return engine;
}

TEST(RunTables, AFiringBelongsToTheFirmwareCycleOfItsFirstTooth) {
    const EngineFile engine = diesel(); // the firmware's cycle k: 270 + 720 k to 990 + 720 k deg
    EXPECT_EQ(firmware_cycle(engine, 0, 0), -1);
    EXPECT_EQ(firmware_cycle(engine, 0, 1), -1);
    EXPECT_EQ(firmware_cycle(engine, 0, 2), 0);
    EXPECT_EQ(firmware_cycle(engine, 1, 1), 0);
    EXPECT_EQ(firmware_cycle(engine, 1, 2), 1);
    EngineFile shifted = engine;
    shifted.position_0_deg = 184; // TDC at 180: its first tooth is position 0, the next cycle's
    EXPECT_EQ(firmware_cycle(shifted, 0, 1), 0);
    shifted.position_0_deg = 180;
    EXPECT_EQ(firmware_cycle(shifted, 0, 1), 0);
    shifted.position_0_deg = 186;
    EXPECT_EQ(firmware_cycle(shifted, 1, 1), 0);
}

TEST(RunTables, AnEdgeEndsTheCycleBeforeIt) {
    const EngineFile engine = diesel();
    EXPECT_EQ(ended_cycle(engine, 270), -1);
    EXPECT_EQ(ended_cycle(engine, 990 - 30), 0);
    EXPECT_EQ(ended_cycle(engine, 990 + 30), 0);
    EXPECT_EQ(ended_cycle(engine, 1710), 1);
}

} // namespace
