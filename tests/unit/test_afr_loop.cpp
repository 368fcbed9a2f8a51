// SPDX-License-Identifier: MIT
// The closed loop: plant, firmware, trims, with calibrations whose delay is wrong, and with speed and load that move. Figures
// of many seeds: sixdeg study loop, docs/results/afr.md.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <map>
#include <gtest/gtest.h>
#include <memory>
#include <numeric>
#include <random>

#include "design/calibration.hpp"
#include "studies/loop/loop_case.hpp"

using namespace sixdeg;

namespace {

const int kSeeds = std::getenv("SD_FULL") ? 20 : 4;
const std::vector<std::string> kQuiet{"uego.noise_per_rthz=0", "cyclic.cov_percent=0"};

/// An ecu whose lambda sensor lies from 6 s to 8 s.
class BadSensor : public EcuBench {
  public:
    BadSensor(const sd_calibration_t &calibration, std::function<float()> reading)
        : EcuBench(calibration), tick_hz_(calibration.tick_hz), reading_(std::move(reading)) {}
    void send(const sd_event_t &event) override {
        sd_event_t e = event;
        const double t_s = e.tick / tick_hz_;
        const bool lies = t_s > 6 && t_s < 8;
        if (lies && e.kind == SD_EVENT_SAMPLE && e.channel == SD_INPUT_EXHAUST_LAMBDA) {
            const float reading = reading_();
            std::memcpy(&e.value, &reading, sizeof reading);
        }
        EcuBench::send(e);
        for (float trim : signals().balance_trim) {
            if (!std::isfinite(trim) || std::abs(trim) > 0.25f) bad = true;
        }
        if (t_s > 6.2 && before_.empty()) before_.assign(signals().balance_trim, signals().balance_trim + 4);
        for (std::size_t i = 0; lies && i < before_.size(); ++i)
            moved = std::max(moved, double(std::abs(signals().balance_trim[i] - before_[i])));
    }
    double moved = 0; ///< By a trim while the sensor lied, but for the first two cycles.
    bool bad = false;

  private:
    double tick_hz_;
    std::function<float()> reading_;
    std::vector<float> before_;
};

BalanceFigures balanced(const LoopCase &loop) {
    const RunResult r = run_loop(loop);
    EXPECT_TRUE(r.balance);
    return r.balance.value_or(BalanceFigures{});
}

double mean(const std::vector<double> &x) { return std::accumulate(x.begin(), x.end(), 0.0) / double(x.size()); }

/// The median; an unlucky run takes some cycles more for the last percent, which is noise.
TEST(AfrLoop, BalancesFromLambdaWithin28Cycles) {
    for (bool perturbed : {false, true}) {
        std::vector<double> residual, cycles;
        int late = 0;
        for (int seed = 1; seed <= kSeeds; ++seed) {
            const BalanceFigures b = balanced({{}, {}, 0, perturbed, std::uint64_t(seed)});
            EXPECT_GT(b.spread_before_percent, 14);
            EXPECT_EQ(b.gave_up_cycles, -1);
            EXPECT_GE(b.cycles_to_3_percent, 4);
            EXPECT_LE(b.cycles_to_3_percent, 60) << seed;
            late += b.cycles_to_3_percent > 40 ? 1 : 0;
            residual.push_back(b.residual_percent), cycles.push_back(b.cycles_to_3_percent);
        }
        std::sort(cycles.begin(), cycles.end());
        EXPECT_LE(cycles[cycles.size() / 2], 28) << perturbed;
        EXPECT_LE(late, kSeeds / 20) << perturbed; // of 20 seeds one takes 44 cycles, with a perturbed calibration 56: docs/results/afr.md
        EXPECT_LE(mean(residual), 0.9) << perturbed;
    }
}

TEST(AfrLoop, BalancesFromTorqueAlone) {
    const BalanceFigures b = balanced({{}, {"balance.source=2"}});
    EXPECT_GE(b.cycles_to_3_percent, 4);
    EXPECT_LE(b.cycles_to_3_percent, 20);
    EXPECT_LT(b.residual_percent, 0.5);
}

/// What a calibration believes wrongly of single cylinders is learned while nothing burns, at another intake pressure.
TEST(AfrLoop, AFuelCutMendsTorqueOfAWrongCalibration) {
    const auto run = [](const std::string &cut) {
        return balanced({{"load.bmep_bar=[9,9,1,1,9]", "load.time_s=[0,2,2.2,4.2,4.4]", cut, "control.balance_on_s=[6,1000]"},
                         {"balance.source=2"}, 0, true, 2});
    };
    const BalanceFigures without = run("load.fuel_cut_s=[]"), with = run("load.fuel_cut_s=[2.2,4.2]");
    EXPECT_GT(without.residual_percent, 0.8);
    EXPECT_LT(with.residual_percent, 0.5 * without.residual_percent);
    EXPECT_GE(with.cycles_to_3_percent, 4);
    EXPECT_LE(with.cycles_to_3_percent, 20);
}

/// What did not burn reads as a cylinder that is far too lean; no fuel helps it.
TEST(AfrLoop, ACylinderThatMisfiresIsNotTrimmed) {
    for (const char *source : {"balance.source=1", "balance.source=2"}) {
        const Scenario scenario = loop_scenario({"misfires.continuous=[2]", "run.duration_s=6"});
        TomlFile tune("t", "");
        tune.set(source);
        const sd_calibration_t page = calibrate(scenario.engine.shared, read_tune(tune), "t");
        const auto ecu = std::make_unique<EcuBench>(page);
        run_scenario(scenario, page, *ecu, nullptr);
        for (float trim : ecu->signals().balance_trim) EXPECT_LE(std::abs(trim), 0.03f) << source;
    }
}

/// 3500 rpm, where the sensor is too slow: 22 s from the moment the trims are allowed.
TEST(AfrLoop, BalancesInSlowMode) {
    const double cycles_in_22_s = 22 * 3500 / 120.0;
    const BalanceFigures b = balanced({{}, {}, 0, true, 2, "slow_3500rpm_12bar.toml"});
    EXPECT_GE(b.cycles_to_3_percent, 4);
    EXPECT_LE(b.cycles_to_3_percent, cycles_in_22_s);
    EXPECT_LT(b.largest_spread_percent, b.spread_before_percent + 1);
}

TEST(AfrLoop, StableWithSixtyDegreesOfDelayError) {
    for (double error : {-60.0, -30.0, 30.0, 60.0}) {
        const BalanceFigures b = balanced({{}, {}, error});
        EXPECT_GE(b.cycles_to_3_percent, 4) << error;
        EXPECT_LE(b.cycles_to_3_percent, 60) << error;
        EXPECT_EQ(b.gave_up_cycles, -1) << error;
        EXPECT_LT(b.residual_percent, 2.5) << error;
    }
}

/// What the trims themselves tell: before it gives up.
TEST(AfrLoop, LearnsAWrongDelayFromItsTrims) {
    for (double error : {90.0, -90.0}) {
        const RunResult r = run_loop({{}, {}, error});
        ASSERT_TRUE(r.balance);
        EXPECT_GE(r.balance->cycles_to_3_percent, 4) << error;
        EXPECT_LE(r.balance->cycles_to_3_percent, 100) << error;
        EXPECT_EQ(r.balance->gave_up_cycles, -1) << error;
        EXPECT_LT(r.balance->residual_percent, 2) << error;
        EXPECT_NEAR(r.afr_late_s * 1500 * 6, -error, 45);
    }
    EXPECT_EQ(run_loop({}).afr_late_s, 0) << "nothing is to be learned from";
}

/// Figure 16's course without its end: trims rest, and an injector moves by itself. Without a word of it in sd_afr_delay it is learned as
/// a delay of -3.8 ms in most runs.
TEST(AfrLoop, AnInjectorThatMovesAtRestIsNoDelayAndIsFoundQuietly) {
    double square = 0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
        const RunResult r = run_loop({{"run.duration_s=35"}, {}, 0, false, std::uint64_t(seed), "figure16_1500rpm_9bar.toml"});
        ASSERT_TRUE(r.afr);
        EXPECT_EQ(r.afr_late_s, 0) << seed;
        square += r.afr->rms_points * r.afr->rms_points / kSeeds;
    }
    EXPECT_LT(std::sqrt(square), 0.7);
    EXPECT_GT(square, 0);
}

/// A start whose calibration believes the delay wrongly; made once.
const RunResult &first_start(double error) {
    static std::map<double, RunResult> made;
    if (made.count(error) == 0) made[error] = run_loop({{}, {}, error});
    return made[error];
}

/// What is stored at power-off is as good as if it had not been off: before any trim, and once they are allowed.
TEST(AfrLoop, ASecondStartKnowsTheDelay) {
    for (double error : {90.0, -90.0}) {
        const RunResult &first = first_start(error);
        const LoopCase cold{{"run.duration_s=1.9"}, {}, error, false, 2, {}, nullptr},
            warm{{"run.duration_s=1.9"}, {}, error, false, 2, {}, &first.learned};
        const RunResult before = run_loop(cold), after = run_loop(warm);
        ASSERT_TRUE(before.afr && after.afr);
        EXPECT_GT(before.afr->rms_points, 4) << error;
        EXPECT_LT(after.afr->rms_points, 0.5 * before.afr->rms_points) << error;
        EXPECT_EQ(after.afr_late_s, first.afr_late_s) << error;
        const RunResult second = run_loop({{}, {}, error, false, 1, {}, &first.learned});
        ASSERT_TRUE(first.balance && second.balance);
        EXPECT_GE(second.balance->cycles_to_3_percent, 4) << error;
        EXPECT_LE(second.balance->cycles_to_3_percent, 0.7 * first.balance->cycles_to_3_percent) << error;
    }
}

/// A delay that was stored and is wrong: it was learned from an injector that moved, or the sensor has been changed since.
TEST(AfrLoop, AWrongDelayThatWasKeptIsMendedLikeAWrongCalibration) {
    for (double error : {90.0, -90.0}) {
        sd_kept_t wrong = first_start(error).learned;
        if (error > 0) wrong.mixture.dead_s -= float(error / (6 * 1500)); // now it says the same of an engine that is as calibrated
        const RunResult r = run_loop({{}, {}, 0, false, 2, {}, &wrong});
        ASSERT_TRUE(r.balance);
        EXPECT_GE(r.balance->cycles_to_3_percent, 4) << error;
        EXPECT_LE(r.balance->cycles_to_3_percent, 100) << error;
        EXPECT_EQ(r.balance->gave_up_cycles, -1) << error;
        EXPECT_NEAR(r.afr_late_s * 1500 * 6, 0, 45) << error;
    }
}

/// A loop that gave up asks the sensor, and balances then.
TEST(AfrLoop, AProbeMendsALoopThatGaveUp) {
    for (double error : {180.0, -180.0}) {
        const RunResult r = run_loop({{"run.duration_s=26"}, {"afr.delay_learning=2"}, error});
        ASSERT_TRUE(r.balance);
        EXPECT_GE(r.balance->gave_up_cycles, 4) << error;
        EXPECT_GE(r.balance->cycles_to_3_percent, 4) << error;
        EXPECT_LT(r.balance->residual_percent, 2) << error;
        EXPECT_NEAR(r.afr_late_s * 1500 * 6, -error, 25);
    }
}

/// Document 004's chain in place of the filter: noisier, so with less gain.
TEST(AfrLoop, BalancesFromTheDocumentsChain) {
    const auto chain = [](const char *method,
                          double error) { return balanced({{}, {method, "balance.integral_gain=0.1", "afr.delay_learning=0"}, error}); };
    for (const BalanceFigures &b : {chain("afr.method=2", 0), chain("afr.method=3", 0), chain("afr.method=3", 30)}) {
        EXPECT_GE(b.cycles_to_3_percent, 4);
        EXPECT_LE(b.cycles_to_3_percent, 60);
        EXPECT_LT(b.residual_percent, 2);
        EXPECT_EQ(b.gave_up_cycles, -1);
    }
    // At 120 deg it is on the edge: some seeds settle, others give up after 180 cycles (docs/results/afr.md).
    EXPECT_GE(chain("afr.method=3", 135).gave_up_cycles, 4);
    // Where the sensor is too slow it says so, and nothing is learned from it.
    const BalanceFigures slow = balanced({{"run.duration_s=6", "control.balance_on_s=[2,1000]"}, {"afr.method=3"}, 0, false, 1,
                                          "slow_3500rpm_12bar.toml"});
    EXPECT_NEAR(slow.largest_spread_percent, slow.spread_before_percent, 0.5);
    EXPECT_EQ(slow.wrong_way_percent, 0);
}

/// At 90 deg the alternating pattern is neither corrected nor driven; beyond, it is driven apart, and the watch stops that.
TEST(AfrLoop, GivesUpBeforeAWrongPhaseDoesHarm) {
    for (double error : {90.0, -90.0, 120.0, -120.0, 150.0, -150.0, 180.0}) {
        const BalanceFigures b = balanced({{}, {"afr.delay_learning=0"}, error});
        EXPECT_LT(b.largest_spread_percent, 2 * b.spread_before_percent) << error;
        if (std::abs(error) > 100) {
            EXPECT_GE(b.gave_up_cycles, 4) << error;
            EXPECT_LE(b.gave_up_cycles, 40) << error;
        }
    }
}

TEST(AfrLoop, FaultsOfInjectorsAreNotTakenForAWrongPhase) {
    const std::vector<std::string> steps{"cylinders.fuel_step=[{at_s=5, cylinder=2, percent=-6}, {at_s=8, cylinder=3, percent=14}]"};
    for (const char *source : {"balance.source=1", "balance.source=2"}) {
        const BalanceFigures b = balanced({steps, {source}});
        EXPECT_EQ(b.gave_up_cycles, -1) << source;
        EXPECT_LT(b.residual_percent, 2) << source;
    }
}

/// No noise, so that what moves a trim is the move of speed or load.
TEST(AfrLoop, MovesOfSpeedAndLoadMoveNoTrimTheWrongWay) {
    for (const char *file : {"speed_ramp.toml", "load_ramp.toml", "tip_in.toml"}) {
        const BalanceFigures b = balanced({kQuiet, {}, 0, false, 1, file});
        EXPECT_LT(b.wrong_way_percent, 0.5) << file;
        EXPECT_LT(b.residual_percent, 0.1) << file;
    }
}

/// Stated deviations above what is allowed: nothing is learned from lambda, whatever it says.
TEST(AfrLoop, HoldsWhileTheEstimateSaysThatItIsUncertain) {
    const BalanceFigures b = balanced({{"run.duration_s=5"}, {"balance.sd_max=0.005"}});
    EXPECT_NEAR(b.largest_spread_percent, b.spread_before_percent, 0.1);
    EXPECT_EQ(b.wrong_way_percent, 0);
}

/// What becomes of the trims where the lambda sensor sends `reading` for two seconds.
void fails(const sd_calibration_t &page, const char *what, double moved, double residual_percent, std::function<float()> reading) {
    const Scenario scenario = loop_scenario({});
    const auto ecu = std::make_unique<BadSensor>(page, std::move(reading));
    const RunResult r = run_scenario(scenario, page, *ecu, nullptr);
    EXPECT_FALSE(ecu->bad) << what;
    EXPECT_LE(ecu->moved, moved) << what;
    ASSERT_TRUE(r.balance) << what;
    EXPECT_LT(r.balance->residual_percent, residual_percent) << what;
    EXPECT_EQ(r.balance->gave_up_cycles, -1) << what;
}

TEST(AfrLoop, ASensorThatFailsMovesNoTrimAndNeedsNoRestart) {
    std::mt19937 random(1);
    TomlFile tune("tune", "");
    sd_calibration_t page = calibrate(loop_scenario({}).engine.shared, read_tune(tune), "tune");
    fails(page, "not a number", 0.005, 1.5, [] { return NAN; });
    fails(page, "out of range", 0.005, 1.5, [] { return -1e30f; });
    fails(page, "stuck", 0.005, 1.5, [] { return 2.0f; });
    fails(page, "any number", 0.005, 1.5, [&] { return std::uniform_real_distribution<float>(0.3f, 9)(random); });
    page.parameters.afr_method = SD_AFR_FOURIER, page.parameters.balance_integral_gain = 0.1f;
    fails(page, "chain, not a number", 0.005, 2, [] { return NAN; });
    fails(page, "chain, stuck", 0.02, 2, [] { return 2.0f; });
}

TEST(AfrLoop, TheFilterTakesWhatItIsToldOfATrim) {
    sd_afr_joint_t filter;
    const sd_afr_joint_config_t config{4, 120, 0.03f, 0.015f, 2e-4f, 0.01f, 0.1f, 8};
    ASSERT_EQ(sd_afr_joint_init(&filter, &config), SD_OK);
    sd_afr_joint_move(&filter, 1, 0.1f); // not running: nothing to move
    const sd_afr_inflow_t nothing{};
    sd_afr_joint_step(&filter, &nothing, 0.5f, nullptr);
    for (float bad : {NAN, INFINITY, 1.5f, -1.5f}) sd_afr_joint_move(&filter, 1, bad);
    sd_afr_joint_move(&filter, 4, 0.1f);
    for (std::uint32_t i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(sd_afr_joint_lambda(&filter, i), 0.5f);
    sd_afr_joint_move(&filter, 1, 0.1f);
    EXPECT_FLOAT_EQ(sd_afr_joint_lambda(&filter, 1), 0.6f);
    EXPECT_FLOAT_EQ(sd_afr_joint_lambda(&filter, 0), 0.5f);
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
