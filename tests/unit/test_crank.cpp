// SPDX-License-Identifier: MIT
// The crank decoder, claim by claim of sd_crank.h. Fault rates against an oracle: test_crank_faults.cpp.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "support/wheel_trace.hpp"
extern "C" {
#include "sd_crank.h"
}

using namespace sixdeg::test;

namespace {

sd_crank_config_t config_of(const WheelTrace &trace) {
    sd_crank_config_t config{};
    config.positions = std::uint8_t(trace.positions);
    config.missing_count = std::uint8_t(trace.missing.size());
    std::copy(trace.missing.begin(), trace.missing.end(), config.missing);
    config.stall_ticks = std::uint32_t(std::fmin(0.5 * trace.tick_hz, 1 << 24));
    return config;
}

sd_crank_t decoder_for(const WheelTrace &trace) {
    sd_crank_t crank{};
    const sd_crank_config_t config = config_of(trace);
    EXPECT_EQ(SD_OK, sd_crank_init(&crank, &config));
    return crank;
}

TEST(CrankInit, RefusesWhatItDocuments) {
    const WheelTrace wheel;
    const auto refused = [&](auto change) {
        sd_crank_config_t config = config_of(wheel);
        change(config);
        sd_crank_t crank{};
        crank.travel = 77;
        const bool untouched_error = sd_crank_init(&crank, &config) == SD_ERR_CONFIG && crank.travel == 77;
        return untouched_error;
    };
    EXPECT_FALSE(refused([](auto &) {}));
    EXPECT_TRUE(refused([](auto &c) { c.positions = 11; }));
    EXPECT_TRUE(refused([](auto &c) { c.positions = 121; }));
    EXPECT_TRUE(refused([](auto &c) { c.missing_count = 0; }));
    EXPECT_TRUE(refused([](auto &c) { c.missing_count = SD_CRANK_MISSING_MAX + 1; }));
    EXPECT_TRUE(refused([](auto &c) { c.missing[1] = 57; })) << "not ascending";
    EXPECT_TRUE(refused([](auto &c) { c.missing[0] = 57, c.missing[1] = 58; })) << "the last position is there";
    EXPECT_TRUE(refused([](auto &c) { c.missing_count = 4, c.missing[0] = 56, c.missing[1] = 57, c.missing[2] = 58, c.missing[3] = 59; }))
        << "run of 4";
    EXPECT_TRUE(refused([](auto &c) { c.missing_count = 3, c.missing[0] = 56, c.missing[1] = 58, c.missing[2] = 59; })) << "marks too near";
    const auto missing = [](std::vector<uint8_t> positions) {
        return [positions](auto &c) {
            c.missing_count = uint8_t(positions.size());
            std::copy(positions.begin(), positions.end(), c.missing);
        };
    };
    EXPECT_TRUE(refused(missing({54, 55, 58, 59}))) << "two teeth apart";
    EXPECT_TRUE(refused(missing({53, 54, 58, 59}))) << "three teeth apart";
    EXPECT_TRUE(refused(missing({52, 53, 55, 56, 58, 59}))) << "three marks with a tooth each between";
    EXPECT_FALSE(refused(missing({55, 56, 58, 59}))) << "two alike with one tooth between";
    EXPECT_FALSE(refused(missing({1, 2, 20, 21, 23, 24, 58, 59}))) << "two such pairs, one across position 0";
    EXPECT_TRUE(refused([](auto &c) { c.stall_ticks = 255; }));
    EXPECT_TRUE(refused([](auto &c) { c.stall_ticks = (1u << 24) + 1; }));
    EXPECT_TRUE(refused([](auto &c) { c.cam_position = 120; }));
}

struct Shape {
    int positions;
    std::vector<int> missing;
    double mark_ratio;
};

class Wheels : public ::testing::TestWithParam<Shape> {};

/// Sync by the second pass of the mark, then every tooth right and valid.
TEST_P(Wheels, AreDecodedWithoutAFault) {
    WheelTrace wheel;
    wheel.positions = GetParam().positions;
    wheel.missing = GetParam().missing;
    wheel.mark_ratio = GetParam().mark_ratio;
    wheel.ripple = 0.03;
    sd_crank_t crank = decoder_for(wheel);
    std::size_t valid = 0, index = 0;
    int zeros_before_sync = 0;
    for (const OracleEdge &edge : make_trace(wheel, 5000).edges) {
        sd_tooth_t tooth;
        sd_crank_edge(&crank, edge.tick, &tooth);
        ++index;
        if (tooth.health == SD_VALID) {
            ++valid;
            ASSERT_EQ(edge.position, tooth.position) << index;
            ASSERT_EQ(SD_EDGE_TOOTH, tooth.edge_class);
        } else {
            ASSERT_EQ(0u, valid) << "lost again at edge " << index;
            zeros_before_sync += edge.position == 0;
        }
    }
    EXPECT_LE(zeros_before_sync, 1 + int(GetParam().missing.size() > 3) * 4);
    EXPECT_GT(valid, 4500u);
    EXPECT_EQ(0u, crank.counts.sync_losses);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Wheels,
                         ::testing::Values(Shape{60, {58, 59}, 3}, Shape{60, {58, 59}, 1.6}, Shape{60, {58, 59}, 3.3},
                                           Shape{60, {58, 59}, 4.5}, Shape{36, {35}, 2}, Shape{36, {34, 35}, 3},
                                           Shape{24, {23}, 2}, Shape{12, {11}, 2}, Shape{120, {117, 118, 119}, 4},
                                           Shape{36, {16, 17, 19 + 7, 27, 34, 35}, 3}, Shape{36, {16, 17, 19, 20, 34, 35}, 3},
                                           Shape{36, {16, 17, 19, 20, 34, 35}, 2.2}, Shape{60, {1, 2, 20, 21, 23, 24, 58, 59}, 3}));

TEST(Crank, BatchesAndSingleEdgesGiveTheSame) {
    WheelTrace wheel;
    wheel.drop_rate = wheel.add_rate = 0.01;
    const auto edges = make_trace(wheel, 3000).edges;
    std::vector<std::uint32_t> ticks;
    for (const OracleEdge &edge : edges) ticks.push_back(edge.tick);
    sd_crank_t one = decoder_for(wheel), many = one;
    std::vector<sd_tooth_t> singles(ticks.size()), batch(ticks.size());
    for (std::size_t i = 0; i < ticks.size(); ++i) sd_crank_edge(&one, ticks[i], &singles[i]);
    for (std::size_t i = 0; i < ticks.size(); i += 7) {
        sd_crank_edges(&many, &ticks[i], std::uint32_t(std::min<std::size_t>(7, ticks.size() - i)), &batch[i]);
    }
    EXPECT_EQ(0, std::memcmp(&one, &many, sizeof one));
    for (std::size_t i = 0; i < ticks.size(); ++i) ASSERT_EQ(singles[i].position, batch[i].position);
}

TEST(Crank, DoesNotCareWhereTheTimerWraps) {
    WheelTrace wheel;
    wheel.drop_rate = 0.005;
    const auto edges = make_trace(wheel, 2000).edges;
    sd_crank_t near_zero = decoder_for(wheel), near_wrap = near_zero;
    const std::uint32_t shift = 0u - edges[1000].tick;
    for (const OracleEdge &edge : edges) {
        sd_tooth_t a, b;
        sd_crank_edge(&near_zero, edge.tick, &a);
        sd_crank_edge(&near_wrap, edge.tick + shift, &b);
        ASSERT_EQ(a.position, b.position);
        ASSERT_EQ(a.health, b.health);
        ASSERT_EQ(a.period_ticks, b.period_ticks);
    }
    EXPECT_EQ(1u, near_wrap.counts.sync_gains);
}

TEST(Crank, FindsAStallWithAndWithoutAnEdgeAndStartsAgain) {
    WheelTrace wheel;
    sd_crank_t crank = decoder_for(wheel);
    const auto edges = make_trace(wheel, 300).edges;
    sd_tooth_t tooth{};
    for (const OracleEdge &edge : edges) sd_crank_edge(&crank, edge.tick, &tooth);
    ASSERT_EQ(SD_VALID, tooth.health);
    const std::uint32_t last = edges.back().tick;
    EXPECT_FALSE(sd_crank_poll(&crank, last + 500000));
    EXPECT_TRUE(sd_crank_poll(&crank, last + 500001));
    EXPECT_FALSE(sd_crank_poll(&crank, last + 600000)) << "told once";
    EXPECT_EQ(1u, crank.counts.stalls);
    EXPECT_EQ(1u, crank.counts.sync_losses);
    for (const OracleEdge &edge : edges) sd_crank_edge(&crank, last + 2000000 + edge.tick, &tooth);
    EXPECT_EQ(SD_VALID, tooth.health);
    EXPECT_EQ(edges.back().position, tooth.position);
    sd_crank_edge(&crank, last + 30000000, &tooth);
    EXPECT_EQ(SD_INVALID, tooth.health);
    EXPECT_EQ(2u, crank.counts.stalls);
}

/// Feeds a cam edge right after the tooth at `position` of every second revolution.
struct CamRun {
    sd_crank_t crank;
    std::size_t first_known = 0, wrong = 0, known = 0;

    CamRun(int cam_position, int at_position, int first_revolution, std::size_t teeth) {
        WheelTrace wheel;
        sd_crank_config_t config = config_of(wheel);
        config.has_cam = 1;
        config.cam_position = std::uint16_t(cam_position);
        EXPECT_EQ(SD_OK, sd_crank_init(&crank, &config));
        const auto edges = make_trace(wheel, teeth).edges;
        int revolution = first_revolution, last = 0;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            revolution ^= edges[i].position < last;
            last = edges[i].position;
            sd_tooth_t tooth;
            sd_crank_edge(&crank, edges[i].tick, &tooth);
            if (edges[i].position == at_position && revolution == cam_position / 60) sd_crank_cam_edge(&crank, edges[i].tick + 100);
            if (!tooth.phase_known) continue;
            if (!known++) first_known = i;
            wrong += tooth.cycle_position != unsigned(edges[i].position + 60 * revolution);
        }
    }
};

TEST(CrankPhase, ComesFromTwoCamEdgesThatAgree) {
    for (const int first : {0, 1}) {
        for (const int cam : {41, 41 + 60, 2, 60, 119, 0}) {
            const CamRun run(cam, std::min(cam % 60, 57), first, 1000);
            EXPECT_EQ(0u, run.wrong) << cam;
            EXPECT_GT(run.known, 600u) << cam;
        }
    }
}

TEST(CrankPhase, FollowsACamThatIsUpTo45DegOff) {
    for (const int off : {-7, 7}) {
        const CamRun run(41, 41 + off, 0, 1000);
        EXPECT_EQ(0u, run.wrong);
        EXPECT_GT(run.known, 600u);
    }
    EXPECT_EQ(0u, CamRun(20, 45, 0, 1000).known) << "150 deg off is not this cam";
}

TEST(CrankPhase, IsUnknownAgainAfterAContradiction) {
    CamRun run(41, 41, 0, 1000);
    sd_tooth_t tooth;
    ASSERT_GE(run.crank.phase_votes, 2);
    // One stray cam edge a revolution off.
    WheelTrace wheel;
    auto edges = make_trace(wheel, 1200).edges;
    for (std::size_t i = 1000; i < 1200; ++i) {
        sd_crank_edge(&run.crank, edges[i].tick, &tooth);
        if (edges[i].position == 41 && run.crank.revolution == 1) {
            sd_crank_cam_edge(&run.crank, edges[i].tick + 100);
            break;
        }
    }
    sd_crank_edge(&run.crank, edges[1199].tick, &tooth);
    EXPECT_EQ(0, tooth.phase_known);
}

TEST(CrankSpeed, OfAnIdealWheelIsTheSpeed) {
    WheelTrace wheel;
    wheel.tick_hz = 1e8;
    wheel.rpm = 1234;
    for (const double ratio : {3.0, 3.3}) {
        wheel.mark_ratio = ratio;
        sd_crank_t crank = decoder_for(wheel);
        std::size_t valid = 0;
        const auto edges = make_trace(wheel, 2000).edges;
        for (const OracleEdge &edge : edges) {
            sd_tooth_t tooth;
            sd_crank_edge(&crank, edge.tick, &tooth);
            if (tooth.health != SD_VALID || ++valid < 600) continue;
            // In the mark too: its width is learned.
            EXPECT_NEAR(1234, double(sd_crank_speed_radps(&crank, &tooth, 1e8f)) * 30 / M_PI, 1234 * 0.002);
            EXPECT_NEAR(0, double(sd_crank_acceleration_radps2(&crank, &tooth, 1e8f)), 30);
        }
        EXPECT_GT(valid, 1000u);
    }
}

TEST(CrankSpeed, AccelerationFollowsARamp) {
    WheelTrace wheel;
    wheel.tick_hz = 1e7;
    wheel.rpm_per_s = 1000;
    wheel.rpm = 1500;
    sd_crank_t crank = decoder_for(wheel);
    double sum = 0;
    int count = 0;
    for (const OracleEdge &edge : make_trace(wheel, 1500).edges) {
        sd_tooth_t tooth;
        sd_crank_edge(&crank, edge.tick, &tooth);
        if (tooth.health != SD_VALID) continue;
        sum += double(sd_crank_acceleration_radps2(&crank, &tooth, 1e7f));
        ++count;
    }
    // The leading clock averages some twenty teeth, and the ramp changes over them: measured 7 % high.
    EXPECT_NEAR(1000 * M_PI / 30, sum / count, 0.1 * 1000 * M_PI / 30);
}

/// The trace jumps by one tooth unseen: as if the wheel had slipped on the crank. Nothing before the next mark can show it.
TEST(Crank, DoesNotTrustTheAngleAfterTheNextMarkShowsASlipAndCorrectsIt) {
    for (const int jump : {1, 2}) {
        WheelTrace wheel;
        sd_crank_t crank = decoder_for(wheel);
        const auto edges = make_trace(wheel, 1500).edges;
        const std::size_t at = 600; // 20 teeth before a mark or so
        std::size_t marks_since = 0, last_wrong_valid = 0;
        sd_tooth_t tooth{};
        for (std::size_t i = 0; i < edges.size(); ++i) {
            if (i > at && i <= at + std::size_t(jump)) continue; // teeth that vanish, and their time with them
            const std::uint32_t gone = i > at ? edges[at + std::size_t(jump)].tick - edges[at].tick : 0;
            sd_crank_edge(&crank, edges[i].tick - gone, &tooth);
            if (i > at) marks_since += edges[i].position == 0;
            if (tooth.health == SD_VALID && tooth.position != edges[i].position) {
                last_wrong_valid = i;
                EXPECT_LE(marks_since, 1u) << "jump " << jump << ": trusted after a mark had shown it, edge " << i;
            }
        }
        EXPECT_GT(last_wrong_valid, at) << "nothing can show the jump before the mark";
        EXPECT_EQ(0u, crank.counts.sync_losses);
        EXPECT_EQ(1u, crank.counts.slips);
        EXPECT_EQ(edges.back().position, tooth.position);
        EXPECT_EQ(SD_VALID, tooth.health);
    }
}

TEST(Crank, SurvivesAnyTicks) {
    WheelTrace wheel;
    sd_crank_config_t config = config_of(wheel);
    config.has_cam = 1;
    std::uint32_t x = 1, tick = 0;
    sd_crank_t crank{};
    ASSERT_EQ(SD_OK, sd_crank_init(&crank, &config));
    for (int i = 0; i < 500000; ++i) {
        x = x * 1664525u + 1013904223u;
        tick += (i % 5000 < 2500) ? 1000 + (x >> 26) : x >> (x & 31u);
        sd_tooth_t tooth;
        sd_crank_edge(&crank, tick, &tooth);
        if ((x >> 24) == 3) sd_crank_cam_edge(&crank, tick + (x & 255u));
        if ((x >> 24) == 5) sd_crank_poll(&crank, tick + (x & 0xfffffu));
        ASSERT_LT(tooth.position, 60);
        ASSERT_LT(tooth.cycle_position, 120);
        ASSERT_TRUE(std::isfinite(sd_crank_speed_radps(&crank, &tooth, 1e6f)));
        ASSERT_TRUE(std::isfinite(sd_crank_acceleration_radps2(&crank, &tooth, 1e6f)));
    }
    EXPECT_GT(crank.counts.stalls, 100u);
}

} // namespace
