// SPDX-License-Identifier: MIT
// Document 003: gains, propositions as corrected, and its hybrid observer on Figure 6.
#include <cstring>
#include <gtest/gtest.h>
#include <limits>

#include "design/driveline/hybrid_design.hpp"
#include "linalg/linalg.hpp"
#include "plant/engine/units.hpp"
#include "studies/driveline/figure_six.hpp"

using namespace sixdeg;
using Eigen::Matrix3d;
using Eigen::Vector3d;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

LocationModel three_location_model(Location q) { return location_model(three_location_figure().driveline, 0.125, 0.025, q); }

void expect_gain(const Vector3d &gain, const Vector3d &expected) {
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(gain(i), expected(i), 5e-4 * std::abs(expected(i)));
}

const Vector3d kPush(0, -0.125 / 0.18, 1 / 100.0); // of a torque of the shaft, three locations

} // namespace

TEST(HybridDesign, GainsAreTheKnownOnes) {
    const Vector3d fast(-60, -70, -80), slow(-12, -15, -18);
    expect_gain(observer_gain(three_location_model(3), fast), {-0.3101, 21.675, 8.1323});
    expect_gain(observer_gain(three_location_model(1), fast), {-0.3101, 21.675, 8.1323});
    expect_gain(observer_gain(three_location_model(2), fast), {-0.6670, 21.675, 50.355});
    expect_gain(observer_gain(three_location_model(3), slow), {-1.733e-3, 4.397, 1.795e-2});
    expect_gain(observer_gain(three_location_model(2), slow), {-7.118e-2, 4.397, 0.4251});
}

TEST(HybridDesign, ConstantsOfLocationsKeepTheSpringWhole) {
    const Driveline d = three_location_figure().driveline;
    for (const double x : {-0.06, -0.04, -0.02, -0.01, 0.01}) {
        const Location q = d.location(x + 0.025);
        const LocationModel m = three_location_model(q);
        const double wheels = m.a(2, 0) * x + m.e(2); // acceleration of the wheels, the shaft at rest
        EXPECT_NEAR(wheels, (d.spring_nm(x + 0.025) - d.spring_nm(0.025)) / 100, 1e-12);
    }
    const Vector3d e1 = three_location_model(1).e, e2 = three_location_model(2).e;
    EXPECT_NEAR(e1(2), 2 * 5000 * 0.015 / 100, 1e-12);
    EXPECT_NEAR(e2(2), -5000 * 0.01 / 100, 1e-12);
}

TEST(HybridDesign, Proposition311NeedsFasterPolesThanTheTableAndThoseHideTheChange) {
    const double needed[] = {-327, -330};
    for (const int i : {0, 1}) {
        const LocationModel m = three_location_model(i ? 2 : 3);
        const ResidualSpeed fast = residual_speed(m.a - observer_gain(m, {-360, -420, -480}) * m.c, m.c, 0.05, 1, 0.1);
        EXPECT_NEAR(fast.needed, needed[i], 0.7);
        EXPECT_NEAR(fast.abscissa, -360, 1e-3);
        EXPECT_TRUE(fast.holds());
        EXPECT_GT(fast.condition, 4e4);
        EXPECT_LT(fast.condition, 5.2e4);
        EXPECT_FALSE(residual_speed(m.a - observer_gain(m, {-60, -70, -80}) * m.c, m.c, 0.05, 1, 0.1).holds());
    }
    // With them, no change of Figure 6 moves a residual beyond the proposition's 0.1 rpm.
    FigureSixCase c = three_location_figure();
    c.belief.residual_poles = {-360, -420, -480};
    double largest = 0;
    for (const FigureSixRow &row : run_figure_six(c).rows) {
        if (row.time_s > 1) largest = std::max({largest, std::abs(row.residual_rpm[1]), std::abs(row.residual_rpm[2])});
    }
    EXPECT_LT(largest, 0.02);
    EXPECT_GT(largest, 1e-4);
}

TEST(HybridDesign, Proposition313IsAboutAnInputThatReachesTheResidualLate) {
    const LocationModel two = three_location_model(2), three = three_location_model(3), one = three_location_model(1);
    EXPECT_EQ(hiding_order(three, two, observer_gain(two, {-60, -70, -80})), 3);
    EXPECT_EQ(hiding_order(two, three, observer_gain(three, {-60, -70, -80})), 3);
    EXPECT_EQ(hiding_order(one, three, observer_gain(three, {-60, -70, -80})), std::nullopt);
}

TEST(HybridDesign, Proposition331GivesNoBoundAsProvedAndACommonNormDoes) {
    for (const Location q : {2, 3}) {
        const LocationModel m = three_location_model(q);
        const Matrix3d f = m.a - observer_gain(m, {-12, -15, -18}) * m.c;
        const ErrorBound bound = error_bound(f, 0.08, 0.02, 25 * kPush.norm());
        EXPECT_GT(bound.contraction, 1);
        EXPECT_FALSE(bound.bound.has_value());
        EXPECT_GT(printed_bound(f, 0.08, 0.02, 25 * kPush.norm()), 0);
        // Changes that are far apart do give one.
        EXPECT_TRUE(error_bound(f, 2, 0.02, 25 * kPush.norm()).bound.has_value());
    }
    const Vector3d g1(-0.531, 12.951, 5.637), g2(-0.0919, 2.968, 1.119);
    const LocationModel one = three_location_model(1), two = three_location_model(2);
    const std::vector<Matrix3d> f{one.a - g1 * one.c, two.a - g2 * two.c};
    const std::optional<double> bound = common_bound_rad(f, kPush, 25, 10, 0.08, 0.02);
    ASSERT_TRUE(bound.has_value());
    EXPECT_LT(*bound, 0.0295);
    EXPECT_GT(*bound, 0.02);
    EXPECT_FALSE(common_bound_rad(f, kPush, 25, 11, 0.08, 0.02).has_value()); // neither decays so fast
}

TEST(Hybrid, Figure6EveryChangeIsFoundWithin20ms) {
    const FigureSix figure = run_figure_six(canonical_figure());
    const Delays found = delays(figure);
    ASSERT_EQ(found.late_s.size(), 4u);
    EXPECT_EQ(found.missed, 0);
    EXPECT_EQ(found.false_ones, 0);
    const double known[] = {0.0096, 0.0068, 0.0068, 0.0135};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(found.late_s[i], known[i], 1.1e-3);
    EXPECT_LT(figure.largest_error_rad, 5e-4);
}

TEST(Hybrid, ThreeLocationsAreFoundLate) {
    const Delays found = delays(run_figure_six(three_location_figure()));
    ASSERT_EQ(found.late_s.size(), 5u);
    const double known[] = {0.010, 0.071, 0.014, 0.072, 0.014};
    for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(found.late_s[i], known[i], 1.2e-3);
}

TEST(Hybrid, Locations1And3HaveOneResidualAndTwoTorsions) {
    for (FigureSixCase c : {canonical_figure(), three_location_figure()}) {
        c.duration_s = 1.9;
        const FigureSixRow last = run_figure_six(c).rows.back();
        const Driveline &d = c.driveline;
        EXPECT_NEAR(last.residual_rpm[0], last.residual_rpm[2], 1e-4);
        EXPECT_NEAR(last.generator_rad[0] - last.generator_rad[2], -2 * (d.stiff_nmprad - d.soft_nmprad) * d.kink_rad / d.stiff_nmprad,
                    1e-5);
    }
}

TEST(Hybrid, OnJitteredTeethItIsNoUse) {
    for (const double scale : {1.0, 0.5, 0.25}) {
        for (const float threshold : {0.02f, 0.2f, 2.0f, 20.0f}) {
            FigureSixCase c = canonical_figure();
            c.jitter_deg = 0.02;
            c.belief.residual_poles *= scale;
            c.belief.threshold_rpm = threshold;
            c.duration_s = 10;
            const FigureSix figure = run_figure_six(c);
            const Delays found = delays(figure);
            EXPECT_TRUE(found.missed >= 2 || found.false_ones >= 4) << scale << " " << threshold;
        }
    }
}

TEST(Hybrid, ABadInputHoldsEverything) {
    const sd_driveline_bank_t bank = hybrid_tables(Driveline(), 0.125, HybridBelief());
    sd_driveline_hybrid_t observer, before;
    ASSERT_EQ(sd_driveline_hybrid_init(&observer, &bank, 3), SD_OK);
    sd_driveline_hybrid_out_t out;
    for (int i = 0; i < 600; ++i) sd_driveline_hybrid_step(&observer, &bank, 0, 0, 0, &out);
    EXPECT_EQ(out.status.health, SD_VALID);
    std::memcpy(&before, &observer, sizeof before);
    sd_driveline_hybrid_step(&observer, &bank, kNan, 0, 0, &out);
    sd_driveline_hybrid_step(&observer, &bank, 0, 0, -2e6f, &out);
    EXPECT_EQ(out.status.health, SD_DEGRADED);
    EXPECT_EQ(out.status.why, SD_WHY_REJECTED);
    EXPECT_EQ(out.status.rejected, 2);
    observer.rejected = 0;
    EXPECT_EQ(std::memcmp(&before, &observer, sizeof before), 0);
}

TEST(Hybrid, InitRefusesWhatIsOutOfRange) {
    const sd_driveline_bank_t good = hybrid_tables(Driveline(), 0.125, HybridBelief());
    sd_driveline_hybrid_t observer;
    for (float sd_driveline_bank_t::*field : {&sd_driveline_bank_t::period_s, &sd_driveline_bank_t::threshold_rpm,
                                              &sd_driveline_bank_t::rpm_per_radps,
                                              &sd_driveline_bank_t::middle_rad, &sd_driveline_bank_t::hold_s, &sd_driveline_bank_t::calm_s,
                                              &sd_driveline_bank_t::settle_s}) {
        sd_driveline_bank_t bad = good;
        bad.*field = kNan;
        EXPECT_EQ(sd_driveline_hybrid_init(&observer, &bad, 3), SD_ERR_CONFIG);
    }
    EXPECT_EQ(sd_driveline_hybrid_init(&observer, &good, 0), SD_ERR_CONFIG);
    EXPECT_EQ(sd_driveline_hybrid_init(&observer, &good, 4), SD_ERR_CONFIG);
    EXPECT_EQ(sd_driveline_hybrid_init(&observer, &good, 1), SD_OK);
}
