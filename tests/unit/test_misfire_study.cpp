// SPDX-License-Identifier: MIT
// The made set and its scores: sixdeg study misfire.
#include <gtest/gtest.h>

#include "common/files.hpp"
#include "design/calibration.hpp"
#include "studies/engines/engine_figures.hpp"
#include "studies/misfire/equal_alarms.hpp"
#include "studies/misfire/open_ecus.hpp"
#include "studies/misfire/set_files.hpp"

using namespace sixdeg;

namespace {

TEST(AlarmCurve, LimitLetsNoMoreFalseAlarmsThanAllowed) {
    AlarmCurve curve;
    for (int i = 0; i < 1000; ++i) curve.add(i, true, false);   // healthy: 0 to 999
    for (int i = 0; i < 100; ++i) curve.add(i - 50.5, true, true); // misfires: half of them below every healthy one
    curve.add(-100, false, true);                                // not judged: not found
    curve.sort();
    for (const auto &[share, alarms, found] : {std::tuple(0.0, 0u, 51u), {0.001, 1u, 52u}, {0.0204, 20u, 71u}, {1.0, 1000u, 100u}}) {
        const AlarmCurve::Found at = curve.found_at(share);
        EXPECT_EQ(at.alarms, alarms) << share;
        EXPECT_EQ(at.found, found) << share;
        EXPECT_EQ(at.missed, 101u);
        EXPECT_EQ(at.healthy, 1000u);
    }
}

TEST(MisfireSet, DrawsAreWithinTheirRangesAndOfTheirSeeds) {
    const auto all = draw_engines(EngineKind::rigid, Physics::other, 40, 1), late = draw_engines(EngineKind::rigid, Physics::other, 1, 40);
    EXPECT_EQ(all.back().gamma, late.front().gamma);
    double least = 9, most = 0;
    for (const SetEngine &e : all) {
        EXPECT_TRUE(e.wall_factor >= 0 && e.wall_factor <= 2 && e.pattern_rms_deg >= 0.02 && e.pattern_rms_deg <= 0.2);
        least = std::min(least, e.gamma), most = std::max(most, e.gamma);
    }
    EXPECT_TRUE(least >= 1.30 && least < 1.31 && most > 1.37 && most <= 1.38);
}

TEST(EngineFigures, RmsIntervalAndGoalOfEachPhysics) {
    EngineFigures figures;
    const auto own = draw_engines(EngineKind::rigid, Physics::own, 1, 1).front();
    const auto other = draw_engines(EngineKind::rigid, Physics::other, 1, 1).front();
    for (const double value : {1.0, -1.0, 2.0, -4.0}) figures.add(other, "level", "1500 rpm", " %", {0, 3}, value);
    figures.add(own, "level", "1500 rpm", " %", {0, 3}, 2);
    figures.add(other, "ratio", "1500 rpm", "", {0.67, 1.5}, 0.5);
    ASSERT_EQ(figures.rows().size(), 2u);
    const FigureRms of_own = rms_of(figures.rows()[0], Physics::own), of_other = rms_of(figures.rows()[0], Physics::other);
    EXPECT_EQ(of_own.rms, 2);
    EXPECT_EQ(of_own.low, 2);
    EXPECT_EQ(of_own.high, 2);
    EXPECT_NEAR(of_other.rms, std::sqrt(5.5), 1e-12);
    EXPECT_EQ(of_other.largest, -4);
    EXPECT_EQ(of_other.met, 3);
    EXPECT_EQ(of_other.engines, 4);
    EXPECT_EQ(of_other.low, 1); // all four drawn are 1 or -1, in one draw of 16
    EXPECT_TRUE(of_other.high >= 3.5 && of_other.high < 3.7);
    EXPECT_EQ(rms_of(figures.rows()[1], Physics::other).met, 0);
    EXPECT_NE(figures.table().find("<= 3 % | 2.00 [2.00, 2.00]; +2.00; 1 of 1 | 2.35 ["), std::string::npos);
}

// One run of an engine that the calibration does not know: what each detector is there for, and the run as files.
TEST(MisfireSet, DetectorsFindWhatIsEasyAndTheFilesHoldTheRun) {
    const EngineFile file = nominal_engine(EngineKind::rigid);
    TomlFile tune("tune", "");
    const sd_calibration_t page = calibrate(file, read_tune(tune), "tune");
    const SetEngine engine = draw_engines(EngineKind::rigid, Physics::other, 1, 7).front();
    const SetPoint point{1500, 9, 0, 0.01};
    const SetRun run = run_set(engine, point, 120, page, learn_engine(engine, page));
    ASSERT_FALSE(run.stalled);
    AlarmCurve curve;
    const std::vector<double> delta = speed_delta(run, file), mean = running_mean(run, file);
    ASSERT_EQ(delta.size(), run.firings.size());
    double sum[2] = {}, count[2] = {};
    for (std::size_t i = 80; i + 12 < delta.size(); ++i) {
        curve.add(delta[i], true, run.firings[i].misfire);
        sum[run.firings[i].misfire] += mean[i], ++count[run.firings[i].misfire];
    }
    curve.sort();
    const AlarmCurve::Found at = curve.found_at(0);
    EXPECT_GT(at.missed, 3u);
    EXPECT_GE(at.found + 1, at.missed);
    EXPECT_LT(sum[1] / count[1], sum[0] / count[0] - 1); // of usual distances
    const MisfireFigures monitor = score_of(run.verdicts, run.record, file).result();
    EXPECT_EQ(monitor.detected, monitor.missed);
    EXPECT_EQ(monitor.false_alarms, 0u);

    const std::filesystem::path folder = std::filesystem::temp_directory_path() / "sixdeg_misfire_set";
    SetWriter writer(folder.string());
    writer.add(engine, point, run, file);
    writer.commit();
    const auto lines = [&](const char *name) {
        const std::string text = read_file(folder / name);
        return std::size_t(std::count(text.begin(), text.end(), '\n'));
    };
    EXPECT_EQ(lines("runs.csv"), 2u);
    EXPECT_EQ(lines("edges_0001.csv"), run.record.edges.size() + 1);
    const std::string firings = read_file(folder / "firings_0001.csv");
    std::size_t misfires = 0;
    for (std::size_t place = 0; (place = firings.find(",1\n", place)) != std::string::npos; ++place) ++misfires;
    EXPECT_EQ(misfires, std::size_t(std::count_if(run.firings.begin(), run.firings.end(), [](const SetFiring &f) { return f.misfire; })));
    EXPECT_GT(misfires, 3u);
    std::filesystem::remove_all(folder);
}

} // namespace
