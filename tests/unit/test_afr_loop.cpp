// SPDX-License-Identifier: MIT
// The closed loop: plant, firmware, trims, with calibrations whose delay is wrong.
#include <gtest/gtest.h>

#include "calibration/calibration.hpp"
#include "run/bench_run.hpp"

using namespace sixdeg;

namespace {

constexpr double kDegPerS = 9000; // at 1500 rpm

RunResult balanced(double delay_error_deg, double source, double seconds = 8) {
    TomlFile file(
        "s.toml",
        "engine = \"diesel_22.toml\"\n[run]\nduration_s = " + std::to_string(seconds) +
            "\n[speed]\nrpm = 1500\n[load]\nbmep_bar = 9\n[cylinders]\nfuel_percent = [6, 9, -3, -8]\n"
            "[cyclic]\ncov_percent = 1\n[uego]\nnoise_per_rthz = 1.83e-4\n[control]\nbalance_on_s = [2, "
            "1000]\n");
    const Scenario scenario = read_scenario(file, SD_ENGINES);
    EngineFile belief = scenario.engine.shared;
    belief.exhaust->dead_time_s += delay_error_deg / kDegPerS;
    TomlFile tune("tune", "");
    tune.set("balance.source=" + std::to_string(source));
    return run_on_bench(scenario, calibrate(belief, read_tune(tune), "tune"), nullptr);
}

TEST(AfrLoop, BalancesFromLambda) {
    const RunResult r = balanced(0, 1);
    ASSERT_TRUE(r.balance && r.afr);
    EXPECT_GT(r.balance->spread_before_percent, 14);
    EXPECT_GE(r.balance->cycles_to_3_percent, 0);
    EXPECT_LE(r.balance->cycles_to_3_percent, 40);
    EXPECT_LT(r.afr->rms_points, 2.5);
    std::printf("cycles %.0f, residual %.2f %%\n", r.balance->cycles_to_3_percent,
                r.balance->residual_percent);
}

TEST(AfrLoop, BalancesFromTorqueAlone) {
    const RunResult r = balanced(0, 2);
    ASSERT_TRUE(r.balance);
    EXPECT_GE(r.balance->cycles_to_3_percent, 0);
    EXPECT_LE(r.balance->cycles_to_3_percent, 60);
    std::printf("cycles %.0f, residual %.2f %%\n", r.balance->cycles_to_3_percent,
                r.balance->residual_percent);
}

TEST(AfrLoop, StableWithSixtyDegreesOfDelayError) {
    for (double error : {-60.0, 60.0}) {
        const RunResult r = balanced(error, 1, 12);
        ASSERT_TRUE(r.balance);
        EXPECT_GE(r.balance->cycles_to_3_percent, 0) << error;
        std::printf("%+.0f deg: cycles %.0f, residual %.2f %%\n", error, r.balance->cycles_to_3_percent,
                    r.balance->residual_percent);
    }
}

TEST(AfrLoop, WithoutASensorNothingIsSaid) {
    TomlFile file(
        "s.toml",
        "engine = \"diesel_22.toml\"\n[run]\ncycles = 20\n[speed]\nrpm = 1500\n[load]\nbmep_bar = 9\n");
    const Scenario scenario = read_scenario(file, SD_ENGINES);
    const RunResult r = run_on_bench(
        scenario, calibrate(scenario.engine.shared, read_tune(*std::make_unique<TomlFile>("t", "")), "t"),
        nullptr);
    EXPECT_FALSE(r.afr || r.balance);
}

} // namespace
