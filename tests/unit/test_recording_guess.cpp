// SPDX-License-Identifier: MIT
// The guess of wheel, edge, column and cam.
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <random>

#include "common/error.hpp"
#include "io/recording/guess.hpp"
#include "io/recording/revolution.hpp"
#include "unit/crank_trace.hpp"
#include "unit/known_recording.hpp"

namespace fs = std::filesystem;
using namespace sixdeg;
using crank_trace::Trace;

namespace {

struct WheelCase {
    int positions, missing;
    double jitter;
};
void PrintTo(const WheelCase &wheel, std::ostream *out) { *out << wheel.positions << '-' << wheel.missing; }
struct Wheels : ::testing::TestWithParam<WheelCase> {};

/// Cranking with a compression ripple of +-40 % for a third of the way, then running.
double cranking_rpm(double revolutions) {
    return revolutions < 6 ? 250 * (1 + 0.4 * std::sin(4 * crank_trace::kPi * revolutions))
                           : 250 + 100 * (revolutions - 6);
}

Trace cranking(const WheelCase &wheel) {
    return {wheel.positions, wheel.missing, 18, cranking_rpm, wheel.jitter};
}

void expect_wheel(const Guess &found, const WheelCase &wheel) {
    EXPECT_EQ(found.wheel.positions, wheel.positions);
    EXPECT_EQ(int(found.wheel.missing.size()), wheel.missing);
    EXPECT_NEAR(found.gap_ratio, wheel.missing + 1, 0.35);
}

TEST_P(Wheels, FromEdgeTimes) {
    std::string rows;
    for (double t_s : crank_trace::edge_times(cranking(GetParam()))) rows += fmt::format("{:.7f}\n", t_s);
    const Guess found = guess(parse_recording("r.csv", rows));
    expect_wheel(found, GetParam());
    EXPECT_TRUE(found.is_edge_times);
    EXPECT_EQ(found.column, 0);
}

TEST_P(Wheels, FromLevelsOfEitherPolarity) {
    // The wide tooth stands in the gap: its other edge splits the gap in two.
    const Trace trace = cranking(GetParam());
    const std::vector<double> clean = crank_trace::edge_times(trace);
    std::vector<double> split;
    for (std::size_t i = 1; i < clean.size(); ++i) split.push_back((clean[i - 1] + clean[i]) / 2);
    const Guess falling = guess(parse_recording("r.csv", crank_trace::level_rows(clean, split)));
    expect_wheel(falling, GetParam());
    EXPECT_EQ(falling.edge, Edge::falling);
    const Guess rising = guess(parse_recording("r.csv", crank_trace::level_rows(split, clean)));
    expect_wheel(rising, GetParam());
    EXPECT_EQ(rising.edge, Edge::rising);
    EXPECT_EQ(rising.time.size(), clean.size());
}

TEST_P(Wheels, FromAReluctanceVoltage) {
    Trace trace = cranking(GetParam());
    trace.jitter = 0;
    const Guess found = guess(parse_recording("r.txt", crank_trace::reluctance_rows(trace, 2e4)));
    expect_wheel(found, GetParam());
    EXPECT_EQ(found.edge, Edge::falling);
}

INSTANTIATE_TEST_SUITE_P(Guess, Wheels,
                         ::testing::Values(WheelCase{60, 2, 0}, WheelCase{60, 2, 0.07},
                                           WheelCase{60, 2, 0.15}, WheelCase{36, 1, 0.03},
                                           WheelCase{36, 2, 0.07}, WheelCase{24, 1, 0.03},
                                           WheelCase{12, 1, 0}, WheelCase{40, 1, 0.05},
                                           WheelCase{50, 3, 0.03}),
                         [](const auto &param) {
                             return fmt::format("w{}_{}_jitter{}", param.param.positions, param.param.missing,
                                                int(std::lround(100 * param.param.jitter)));
                         });

TEST(Guess, SurvivesLostEdges) {
    Trace trace;
    trace.revolutions = 60;
    trace.lost = 0.01;
    const std::vector<double> times = crank_trace::edge_times(trace);
    std::string rows;
    for (double t_s : times) rows += fmt::format("{:.7f}\n", t_s);
    EXPECT_EQ(describe(guess(parse_recording("r.csv", rows))), "60-2, edge times, gap ratio 3.0");
}

TEST(Guess, PrefersTheEdgeWhoseMarkIsOneGap) {
    // Each gap has one falling edge 2.1 teeth after the last tooth: falling intervals of 2.6 and 1.4 teeth.
    const double tooth_s = 60.0 / 900 / 60;
    const std::vector<double> rising = crank_trace::edge_times({});
    std::vector<double> falling;
    for (std::size_t i = 1; i < rising.size(); ++i) {
        const bool is_gap = rising[i] - rising[i - 1] > 2 * tooth_s;
        falling.push_back(rising[i - 1] + (is_gap ? 2.1 : 0.5) * tooth_s);
    }
    const Recording recording = parse_recording("r.csv", crank_trace::level_rows(falling, rising));
    EXPECT_EQ(describe(guess(recording)), "60-2, rising, gap ratio 3.0");
    EXPECT_EQ(guess(recording, with_edge(Edge::falling)).edge, Edge::falling);
}

TEST(Guess, PrefersTheEvenerOfTwoGoodEdges) {
    Trace rough;
    rough.jitter = 0.03;
    const Recording recording = parse_recording(
        "r.csv", crank_trace::level_rows(crank_trace::edge_times(rough), crank_trace::edge_times({}, 0.5)));
    EXPECT_EQ(guess(recording).edge, Edge::rising);
}

TEST(Guess, TakesTheFallingEdgeOfTwoAlike) {
    const Recording recording = parse_recording(
        "r.csv", crank_trace::level_rows(crank_trace::edge_times({}), crank_trace::edge_times({}, 0.5)));
    EXPECT_EQ(guess(recording).edge, Edge::falling);
}

TEST(Guess, NeedsOnlyFiveGoodRevolutionsInARow) {
    Trace good;
    good.revolutions = 8;
    std::vector<double> times = crank_trace::edge_times(good);
    std::mt19937 random(5);
    std::uniform_real_distribution<double> wait(0.0008, 0.0016);
    while (times.size() < 60 * 58) times.push_back(times.back() + wait(random));
    std::string rows;
    for (double t_s : times) rows += fmt::format("{:.7f}\n", t_s);
    EXPECT_EQ(describe(guess(parse_recording("r.csv", rows)).wheel), "60-2");
}

TEST(Guess, WordOfTheCallerStandsWhereMarksShowNothing) {
    std::string rows;
    for (int i = 0; i < 400; ++i) rows += fmt::format("{:.7f}\n", 0.001 * i);
    const Guess found = guess(parse_recording("r.csv", rows), with_wheel("36-1"));
    EXPECT_EQ(describe(found), "36-1, edge times, no gap measured");
    EXPECT_EQ(found.time.size(), 400u);
}

/// Edge times of a wheel with these teeth before each mark and missing teeth in it.
Recording several_marks(const std::vector<std::pair<int, int>> &turn, int revolutions = 12) {
    std::string rows;
    double t_s = 0.5;
    for (int i = 0; i < revolutions; ++i) {
        for (const auto &[teeth, missing] : turn) {
            for (int tooth = 0; tooth < teeth; ++tooth) rows += fmt::format("{:.7f}\n", t_s += 0.001);
            t_s += 0.001 * missing;
        }
    }
    return parse_recording("r.csv", rows);
}

TEST(Guess, NamesWheelsOfSeveralMarks) {
    EXPECT_EQ(wheel_name(guess(several_marks({{20, 1}, {13, 2}}))), "36-2-1");
    EXPECT_EQ(wheel_name(guess(several_marks({{17, 2}, {16, 1}}))), "36-2-1");
    EXPECT_EQ(wheel_name(guess(several_marks({{16, 2}, {8, 2}, {6, 2}}))), "36-2-2-2");
    EXPECT_EQ(wheel_name(guess(several_marks({{17, 2}, {23, 2}}))), "44-2-2");
    EXPECT_EQ(wheel_name(guess(several_marks({{16, 2}, {1, 2}, {13, 2}}))), "36-2-2-2") << "two marks with one tooth between";
    EXPECT_EQ(guess(several_marks({{20, 1}, {13, 2}})).wheel.missing, (std::vector<int>{20, 34, 35}));
}

TEST(Guess, DoesNotGuessHowOftenMarksRepeat) {
    const Recording recording = several_marks({{20, 2}}, 24);
    EXPECT_THROW(guess(recording), InputError);
    EXPECT_EQ(wheel_name(guess(recording, with_wheel("44-2-2"))), "44-2-2");
    EXPECT_EQ(wheel_name(guess(recording, with_wheel("22-2"))), "22-2");
    Constraints engine;
    engine.engine_wheel = Wheel{44, {20, 21, 42, 43}};
    EXPECT_EQ(wheel_name(guess(recording, engine)), "44-2-2");
}

TEST(Guess, TakesAnAddedToothForTheMark) {
    std::string rows;
    for (int i = 0; i < 24 * 12; ++i) {
        rows += fmt::format("{:.7f}\n", 0.001 * i);
        if (i % 24 == 7) rows += fmt::format("{:.7f}\n", 0.001 * i + 0.0005);
    }
    const Guess found = guess(parse_recording("r.csv", rows));
    EXPECT_EQ(wheel_name(found), "24+1");
    EXPECT_EQ(describe(found.wheel), "24-1");
    EXPECT_EQ(found.time.size(), 23u * 12);
}

/// An even wheel of so many teeth and one tooth on another sensor, every `every` of them.
Recording two_sensors(int revolutions, int teeth, int every) {
    std::string text = "time [s],crank,home\n";
    for (int i = 0; i < revolutions * teeth; ++i) {
        const int home = i % every == 3;
        text += fmt::format("{:.6f},0,0\n{:.6f},1,{}\n", 0.001 * i, 0.001 * i + 0.0005, home);
    }
    return parse_recording("r.csv", text);
}

TEST(Guess, TakesTheOneToothOfAnotherSensorForTheMark) {
    for (const int turns : {1, 2}) {
        const Guess found = guess(two_sensors(12, 24, 24 * turns));
        EXPECT_EQ(wheel_name(found), "24+1");
        ASSERT_TRUE(found.home);
        EXPECT_EQ(found.home->on_cam, turns == 2);
        EXPECT_EQ(found.cam.has_value(), turns == 2);
        EXPECT_NEAR(found.rpm, 2500, 1);
        EXPECT_EQ(found.runner_up.empty(), turns == 2) << "a cam would make another speed of it";
        const std::vector<double> steps = intervals(found.time);
        EXPECT_NEAR(*std::max_element(steps.begin(), steps.end()), 0.002, 1e-6);
    }
    EXPECT_THROW(guess(two_sensors(12, 24, 17)), InputError);
    Constraints known;
    known.wheel = parse_wheel_text("12+1", "--wheel");
    EXPECT_EQ(wheel_name(guess(two_sensors(12, 24, 24), known)), "12+1");
}

TEST(Guess, TakesTheUnitOfTimeThatGivesAnEnginesSpeed) {
    for (const double unit_s : {1.0, 1e-3, 1e-6}) {
        std::string rows;
        for (double t_s : crank_trace::edge_times({})) rows += fmt::format("{:.9g}\n", t_s / unit_s);
        const Guess found = guess(parse_recording("r.csv", rows));
        EXPECT_EQ(found.unit_s, unit_s);
        EXPECT_NEAR(found.rpm, 900, 10);
    }
}

/// Edge times on a wheel with one mark that turns with such ripple of two a revolution, and how far from their place they lie.
std::string rippled(int positions, int missing, double ripple, double phase, double revolutions, double jitter = 0) {
    Trace trace;
    trace.positions = positions, trace.missing = missing, trace.revolutions = revolutions, trace.jitter = jitter;
    trace.rpm = [=](double turned) { return 100 * (1 + ripple * std::sin(4 * crank_trace::kPi * turned + phase)); };
    std::string rows;
    for (double t_s : crank_trace::edge_times(trace)) rows += fmt::format("{:.7f}\n", t_s);
    return rows;
}

TEST(Guess, SlowCrankAtTheMarkOfACoarseWheelIsNoMissingTooth) {
    // Where ripple is 40 %, the place of a mark of 12 to 25 positions may take half or twice the time of its neighbours.
    for (const WheelCase &wheel :
         {WheelCase{25, 1, 0}, WheelCase{18, 1, 0}, WheelCase{20, 2, 0}, WheelCase{12, 1, 0}, WheelCase{12, 3, 0}}) {
        for (double phase = 0; phase < 6.2; phase += 0.7) {
            const Constraints free;
            std::string said;
            try {
                said = wheel_name(guess(parse_recording("r.csv", rippled(wheel.positions, wheel.missing, 0.4, phase, 14, 0.01))));
            } catch (const InputError &error) {
                said = error.what();
            }
            const bool repeats = said.find("the marks repeat") != std::string::npos;
            EXPECT_TRUE(repeats || said == fmt::format("{}-{}", wheel.positions, wheel.missing))
                << wheel.positions << " " << phase << " " << said;
        }
    }
}

TEST(Guess, MarkOfEverySecondOrThirdRevolutionIsThatOfEach) {
    // Of three revolutions only one has a mark that stands out; the others lie between odd teeth.
    std::string rows;
    double t_s = 0.5;
    for (int turn = 0; turn < 30; ++turn) {
        for (int tooth = 0; tooth < 23; ++tooth) rows += fmt::format("{:.7f}\n", t_s += tooth == 1 && turn % 3 ? 0.0014 : 0.001);
        t_s += 0.001;
    }
    EXPECT_EQ(wheel_name(guess(parse_recording("r.csv", rows))), "24-1");
}

TEST(Revolution, MeasuresAMarkBesideTheSpeedOfTheWholeRevolution) {
    // 22 teeth of 24 positions; the speed swings by 30 % twice a revolution and is lowest at the mark.
    Revolution revolution;
    const auto time_to = [](double p) { return p / 24 + 0.3 / (4 * crank_trace::kPi) * std::sin(4 * crank_trace::kPi * (p / 24 - 0.94)); };
    const auto slowness = [&](double from, double to) { return time_to(to) - time_to(from); };
    for (int slot = 0; slot < 21; ++slot) revolution.share.push_back(slowness(slot, slot + 1));
    revolution.share.push_back(slowness(21, 24));
    revolution.sd.assign(22, 0.001);
    revolution.mark = {21};
    const std::vector<MeasuredWidth> right = widths_of(revolution, {2});
    ASSERT_EQ(right.size(), 1u);
    EXPECT_NEAR(right[0].spacings, 3, 0.06);
    EXPECT_LT(right[0].sd, 0.1);
    const std::vector<MeasuredWidth> wrong = widths_of(revolution, {1});
    ASSERT_EQ(wrong.size(), 1u);
    EXPECT_GT(std::abs(wrong[0].spacings - 2), 0.5);
    EXPECT_TRUE(widths_of(Revolution{}, {2}).empty());
}

// ---- Cam ----

/// Crank in column 2, cam in column 1, both as levels in every row.
std::string rows_with_cam(int cam_period_revolutions) {
    Trace trace;
    trace.revolutions = 20;
    const crank_trace::Motion motion(trace);
    std::string rows = "t,cam,crank\n";
    for (double p = 8; p < 19.5 * 60; p += 0.25) {
        const bool is_tooth = std::fmod(p, 60) < 58 && std::fmod(p, 1) < 0.5;
        const double cam = std::fmod(p, 60.0 * cam_period_revolutions);
        rows += fmt::format("{:.8f},{},{}\n", motion.time_at(p), cam > 41.1 && cam < 55 ? 1 : 0,
                            is_tooth ? 1 : 0);
    }
    return rows;
}

TEST(Cam, IsTheColumnWithOnePulseACycle) {
    const Guess found = guess(parse_recording("r.csv", rows_with_cam(2)));
    EXPECT_EQ(found.column, 2);
    ASSERT_TRUE(found.cam);
    EXPECT_EQ(found.cam->column, 1);
    EXPECT_EQ(found.cam->edge, Edge::rising);
    // Falling edges lie half a tooth on, so the rise after position 41.1 follows the fall of tooth 40.
    EXPECT_EQ(int(found.cam->place_rev * 58), 40);
    EXPECT_EQ(found.cam->time.size(), 10u);
}

TEST(Cam, IsNotAPulseEveryRevolutionOrEveryThird) {
    EXPECT_FALSE(guess(parse_recording("r.csv", rows_with_cam(1))).cam);
    EXPECT_FALSE(guess(parse_recording("r.csv", rows_with_cam(3))).cam);
}

TEST(Cam, IsNotAPressure) {
    // One smooth hump a cycle in column 1, the crank's levels in column 2.
    Trace trace;
    trace.revolutions = 20;
    const crank_trace::Motion motion(trace);
    std::string rows;
    for (double p = 8; p < 19.5 * 60; p += 0.25) {
        const double from_top_deg = std::remainder(p * 6 - 30, 720);
        const bool is_tooth = std::fmod(p, 60) < 58 && std::fmod(p, 1) < 0.5;
        rows += fmt::format("{:.8f},{:.4f},{}\n", motion.time_at(p),
                            1 + 60 * std::exp(-std::pow(from_top_deg / 30, 2)), is_tooth ? 1 : 0);
    }
    const Guess found = guess(parse_recording("r.csv", rows));
    EXPECT_EQ(found.column, 2);
    EXPECT_FALSE(found.cam);
}

// ---- Real recordings, where they are ----

Guess guess_real(const std::string &name) { return guess(read_recording(fs::path(SD_RECORDINGS) / name)); }

struct Real : ::testing::Test {
    void SetUp() override {
        if (!fs::is_directory(SD_RECORDINGS)) GTEST_SKIP() << "no real recordings beside the project";
    }
};

TEST_F(Real, FourCylinderEventList) {
    const Guess found = guess_real("real_60-2_vw_aba.csv");
    EXPECT_EQ(describe(found), "60-2, falling, gap ratio 3.3");
    EXPECT_EQ(found.column, 1);
    EXPECT_EQ(found.time.size(), 2577u);
    EXPECT_EQ(found.consistent_revolutions, 43);
    ASSERT_TRUE(found.cam);
    EXPECT_EQ(found.cam->column, 2);
    EXPECT_EQ(found.cam->edge, Edge::rising);
}

TEST_F(Real, SampledEncoderBesidePressure) {
    const Guess found = guess_real("real_single_pressure_full_load.txt");
    EXPECT_EQ(describe(found), "60-2, rising, gap ratio 3.5");
    EXPECT_EQ(found.column, 2);
    EXPECT_EQ(found.time.size(), 1450u);
    EXPECT_EQ(found.consistent_revolutions, 23);
    EXPECT_FALSE(found.cam);
}

TEST_F(Real, NoisyEvents) {
    const Guess found = guess_real("real_36-2_noisy.csv");
    EXPECT_EQ(describe(found.wheel), "36-2");
    EXPECT_GE(found.consistent_revolutions, 6);
}

TEST_F(Real, ReluctanceVoltageThatOverflowsItsRecorder) {
    const Guess found = guess_real("real_60-2_vr_analog.csv");
    EXPECT_EQ(describe(found), "60-2, falling, gap ratio 3.2");
    EXPECT_EQ(found.consistent_revolutions, 40);
}

} // namespace
