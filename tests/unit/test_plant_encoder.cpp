// SPDX-License-Identifier: MIT
// The encoder against crossing times in closed form, and each of its faults against what was asked.
#include <gtest/gtest.h>
#include <set>

#include "plant_fixture.hpp"
#include "plant/sensors/edge_generator.hpp"

using namespace plant_test;

namespace {

const EngineFile &engine() {
    static const EngineFile file = diesel().shared;
    return file;
}

std::vector<EncoderEdge> generate(const EncoderFaults &faults, const Profile &rpm, double duration_s,
                                  double start_deg = 0) {
    EdgeGenerator generator(engine(), faults, rpm, start_deg, duration_s, 1);
    std::vector<EncoderEdge> edges;
    EncoderEdge edge;
    while (generator.next_edge(edge)) edges.push_back(edge);
    return edges;
}

std::vector<EncoderEdge> crank_only(std::vector<EncoderEdge> edges) {
    edges.erase(std::remove_if(edges.begin(), edges.end(),
                               [](const EncoderEdge &e) { return e.kind == EdgeKind::cam; }),
                edges.end());
    return edges;
}

bool ordered(const std::vector<EncoderEdge> &edges) {
    return std::is_sorted(edges.begin(), edges.end(),
                          [](const EncoderEdge &a, const EncoderEdge &b) { return a.time_s < b.time_s; });
}

// From angle 0 the k-th edge stands at 6 (k + 1) deg but for the missing teeth at 258 and 264.
std::vector<double> nominal_angles(int turns) {
    std::vector<double> angles;
    for (int turn = 0; turn < turns; ++turn) {
        for (int k = 1; k <= 60; ++k) {
            if (k != 43 && k != 44) angles.push_back(360.0 * turn + 6 * k);
        }
    }
    return angles;
}

TEST(EdgeGenerator, ConstantSpeedInClosedForm) {
    const auto edges = crank_only(generate({}, Profile(1000.0), 0.6005));
    const auto angles = nominal_angles(10);
    ASSERT_EQ(edges.size(), angles.size());
    for (std::size_t i = 0; i < angles.size(); ++i) {
        EXPECT_NEAR(edges[i].time_s, angles[i] / 6000, 1e-12);
        EXPECT_NEAR(edges[i].angle_deg, std::fmod(angles[i], 720), 1e-9);
    }
    EXPECT_EQ(edges[44 - 2].tooth, 0); // 270 deg
}

TEST(EdgeGenerator, RampInClosedForm) {
    const auto edges = crank_only(generate({}, Profile({0, 1}, {600, 3000}), 1));
    const auto angles = nominal_angles(31);
    ASSERT_GT(edges.size(), 1700u);
    for (std::size_t i = 0; i < edges.size(); ++i) { // 3600 t + 14400 t^2 / 2 = angle
        EXPECT_NEAR(edges[i].time_s, (-3600 + std::sqrt(3600.0 * 3600 + 28800 * angles[i])) / 14400, 1e-12);
    }
}

TEST(EdgeGenerator, ReversalGivesTheOtherFlanks) {
    // Forward to 60.2 deg in 0.1 s, standing for 0.1 s, and back by the same.
    EncoderFaults faults;
    faults.tooth_width = 0.4;
    const Profile rpm({0, 0.1, 0.2, 0.3}, {200.0 + 2.0 / 3, 0, 0, -(200.0 + 2.0 / 3)});
    const auto edges = crank_only(generate(faults, rpm, 0.3));
    std::vector<double> forward, backward;
    for (const EncoderEdge &edge : edges) (edge.backward ? backward : forward).push_back(edge.angle_deg);
    ASSERT_EQ(forward.size(), 10u); // 6 to 60 deg
    ASSERT_EQ(backward.size(), 10u);
    for (std::size_t i = 0; i < 10; ++i) {
        EXPECT_NEAR(forward[i], 6.0 * double(i + 1), 1e-9);
        EXPECT_NEAR(backward[i], 60 - 2.4 - 6.0 * double(i), 1e-9);
    }
    EXPECT_TRUE(ordered(edges));
    EXPECT_LT(edges.back().speed_radps, 0);
}

TEST(EdgeGenerator, CamComesOnceInACycleAndMovesWithThePhaser) {
    EncoderFaults faults;
    faults.cam_retard_deg = Profile({0, 1}, {0, 20});
    std::vector<EncoderEdge> cams;
    for (const EncoderEdge &edge : generate(faults, Profile(1200.0), 1)) {
        if (edge.kind == EdgeKind::cam) cams.push_back(edge);
    }
    ASSERT_EQ(cams.size(), 10u);
    // 7200 t = 420 + 720 k + 20 t
    for (std::size_t k = 0; k < cams.size(); ++k)
        EXPECT_NEAR(cams[k].time_s, (420 + 720.0 * double(k)) / 7180, 1e-10);
}

TEST(Encoder, TickIsTheCaptureRegisterAndWraps) {
    EngineFile fast = engine();
    fast.tick_hz = 2e8; // wraps after 21 s
    EdgeGenerator generator(fast, {}, Profile(600.0), 0, 25, 1);
    EncoderEdge edge;
    bool wrapped = false;
    std::uint32_t last = 0;
    while (generator.next_edge(edge)) {
        EXPECT_EQ(edge.tick, std::uint32_t(std::uint64_t(edge.time_s * 2e8) & 0xffffffffu));
        wrapped = wrapped || edge.tick < last;
        last = edge.tick;
    }
    EXPECT_TRUE(wrapped);
}

TEST(Encoder, PatternHasExactlyTheAskedRmsAndStays) {
    const WheelEdges wheel(engine(), 0, 0.05, 3, RandomStream(3, 5));
    double mean = 0, square = 0;
    for (double p : wheel.pattern_deg(60)) mean += p / 58, square += p * p / 58;
    EXPECT_NEAR(mean, 0, 1e-15);
    EXPECT_NEAR(std::sqrt(square), 0.05, 1e-15);
    EncoderFaults faults;
    faults.pattern_rms_deg = 0.05;
    const auto edges = crank_only(generate(faults, Profile(1000.0), 0.2));
    double moved = 0;
    for (std::size_t i = 0; i < 58; ++i) {
        EXPECT_NEAR(edges[i + 58].time_s - edges[i].time_s, 0.06, 1e-12); // the same in every turn
        moved = std::max(moved, std::abs(edges[i].time_s - nominal_angles(1)[i] / 6000) * 6000);
    }
    EXPECT_GT(moved, 0.05);
}

TEST(Encoder, OffsetDelayAndLagMoveEveryEdge) {
    const auto ideal = generate({}, Profile(1000.0), 0.1);
    EncoderFaults faults;
    faults.delay_s = 7e-6;
    faults.lag_deg = Profile({0, 2000 * kRadpsPerRpm}, {0, 0.6});
    const auto late = generate(faults, Profile(1000.0), 0.1);
    for (std::size_t i = 0; i < late.size(); ++i)
        EXPECT_NEAR(late[i].time_s - ideal[i].time_s, 7e-6 + 0.3 / 6000, 1e-12);
    faults = {};
    faults.offset_deg = 0.3;
    const auto turned = crank_only(generate(faults, Profile(1000.0), 0.1)), straight = crank_only(ideal);
    // The edge at 0 deg has moved to 0.3 and is now the first.
    for (std::size_t i = 0; i + 1 < straight.size(); ++i) {
        EXPECT_NEAR(turned[i + 1].time_s - straight[i].time_s, 0.3 / 6000, 1e-12);
    }
}

TEST(Encoder, JitterHasTheAskedSpread) {
    EncoderFaults faults;
    faults.jitter_deg = 0.02;
    const auto ideal = crank_only(generate({}, Profile(1000.0), 10.0005)),
               jittered = crank_only(generate(faults, Profile(1000.0), 10.0005));
    ASSERT_EQ(ideal.size(), jittered.size());
    double square = 0;
    for (std::size_t i = 0; i < ideal.size(); ++i) {
        square += std::pow((jittered[i].time_s - ideal[i].time_s) * 6000, 2) / double(ideal.size());
    }
    EXPECT_NEAR(std::sqrt(square), 0.02, 4 * 0.02 / std::sqrt(2.0 * 9666)); // four standard deviations
}

TEST(Encoder, DroppedEdgesComeAtTheAskedRateAndLength) {
    EncoderFaults faults;
    faults.drop_rate = 0.01;
    faults.drop_burst = 4;
    const auto ideal = crank_only(generate({}, Profile(1000.0), 60.0005)),
               holed = crank_only(generate(faults, Profile(1000.0), 60.0005));
    // Runs of mean length 4 begin at one edge in 100 of those outside a run: 4/(100 + 3) are lost.
    const double lost = 1 - double(holed.size()) / double(ideal.size());
    EXPECT_NEAR(lost, 4.0 / 103, 0.004);
}

TEST(Encoder, FalseEdgesAreMarkedAndInOrder) {
    EncoderFaults faults;
    faults.extra_rate = 0.02;
    faults.extra_burst = 3;
    const auto edges = generate(faults, Profile(1000.0), 60.0005);
    EXPECT_TRUE(ordered(edges));
    int spurious = 0, true_ones = 0;
    for (const EncoderEdge &edge : edges) {
        spurious += edge.spurious;
        true_ones += !edge.spurious && edge.kind == EdgeKind::crank;
        if (edge.spurious) {
            EXPECT_EQ(edge.tooth, -1);
            EXPECT_NEAR(edge.angle_deg, std::fmod(edge.time_s * 6000, 720), 1e-6);
        }
    }
    EXPECT_EQ(true_ones, 58000);
    EXPECT_NEAR(double(spurious) / true_ones, 0.06, 0.006);
}

TEST(Encoder, OrderHoldsWithEverythingAtOnce) {
    EncoderFaults faults;
    faults.jitter_deg = 0.3;
    faults.cam_jitter_deg = 3;
    faults.extra_rate = faults.drop_rate = 0.05;
    faults.extra_burst = faults.drop_burst = 5;
    faults.lag_deg = Profile({0, 600}, {-2, 3});
    EXPECT_TRUE(ordered(generate(faults, Profile({0, 2, 4}, {200, 6000, 300}), 5)));
}

// Teeth stand at multiples of 6 deg, where a step ends and nothing is interpolated: turn the wheel so that they do not.
constexpr double kOffStep = 0.173;

// The engine at a prescribed ramp gives the edges that the generator has in closed form.
TEST(PlantEncoder, CrossingsInAStepMatchTheClosedForm) {
    const Scenario s = scenario({"speed={mode=\"prescribed\", time_s=[0, 1], rpm=[600, 3000]}", "run={duration_s=1}",
                                 "encoder.offset_deg=" + std::to_string(kOffStep)});
    const auto found = run(s).edges, exact = generate(s.encoder, s.speed_radps.scaled(1 / kRadpsPerRpm), 1);
    ASSERT_EQ(found.size(), exact.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
        ASSERT_EQ(found[i].tooth, exact[i].tooth) << i;
        ASSERT_NEAR(found[i].time_s, exact[i].time_s, 1e-10) << i;
    }
}

// With combustion ripple: the edges of steps ten times finer.
TEST(PlantEncoder, CrossingsInAStepMatchFinerSteps) {
    const std::string offset = "encoder.offset_deg=" + std::to_string(kOffStep);
    const auto coarse = run(scenario({"run.cycles=2", offset})).edges;
    const auto fine = run(scenario({"run.cycles=2", "run.step_deg=0.05", offset})).edges;
    ASSERT_EQ(coarse.size(), fine.size());
    double worst = 0;
    for (std::size_t i = 0; i < fine.size(); ++i) worst = std::max(worst, std::abs(coarse[i].time_s - fine[i].time_s));
    EXPECT_LT(worst, 1e-9);
}

TEST(PlantEncoder, TruthOfAnEdgeIsTheEngineThere) {
    const auto r = run(scenario({"run.cycles=3"}));
    for (const EncoderEdge &edge : r.edges) {
        const auto after = std::lower_bound(r.steps.begin(), r.steps.end(), edge.time_s,
                                            [](const StepTruth &s, double t) { return s.time_s < t; });
        if (after == r.steps.begin() || after == r.steps.end()) continue;
        const StepTruth &before = *(after - 1);
        const auto within = [](double value, double a, double b) {
            return value >= std::min(a, b) - 1e-9 && value <= std::max(a, b) + 1e-9;
        };
        EXPECT_TRUE(
            within(edge.combustion_torque_nm, before.combustion_torque_nm, after->combustion_torque_nm));
        EXPECT_TRUE(within(edge.speed_radps, before.speed_radps, after->speed_radps));
        EXPECT_NEAR(std::remainder(edge.angle_deg * kRadPerDeg - before.angle_rad, 4 * kPi), 0,
                    0.5 * kRadPerDeg + 1e-9);
    }
}

TEST(RandomStream, SameWordsOnEveryPlatform) {
    RandomStream stream(1, 2);
    const double first = stream.uniform();
    EXPECT_EQ(first, RandomStream(1, 2).uniform());
    EXPECT_NE(first, RandomStream(1, 3).uniform());
    EXPECT_NE(first, RandomStream(2, 2).uniform());
    EXPECT_NEAR(RandomStream::inverse_normal(0.975), 1.959963985, 1e-8);
    EXPECT_NEAR(RandomStream::inverse_normal(0.001), -3.090232306, 1e-8);
    EXPECT_NEAR(RandomStream::inverse_normal(0.999), 3.090232306, 1e-8);
}

} // namespace
