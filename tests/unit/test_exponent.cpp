// SPDX-License-Identifier: MIT
// The motored torque that all cylinders have in common, learned in fuel cut, on an engine by other equations (other_engine.hpp): the
// level of torque when it fires.
#include "support/other_bench.hpp"

namespace sixdeg {
namespace {

using namespace test;

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
