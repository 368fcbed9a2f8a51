// SPDX-License-Identifier: MIT
// The wire: what CAN frames and LCM messages carry comes out as it went in; any bytes at all do no harm; lost, doubled,
// late and cut frames are counted, and nothing wrong is called valid. No socket is needed for that.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <memory>
#include <random>

#include "io/events/ecu_feed.hpp"
#include "support/bus_links.hpp"
extern "C" {
#include "sd_ecu.h"
}

using namespace sixdeg;
using namespace sixdeg::test;

namespace {

TEST(CanFrames, CarryEveryEventOfThePlantInOrder) {
    std::vector<sd_event_t> events;
    for (std::uint32_t i = 0; i < 40; ++i)
        events.push_back({0xfffffff0u + i, std::uint16_t(i % 13 == 5 ? SD_EVENT_CAM_EDGE : SD_EVENT_CRANK_EDGE), 0, 0, 0});
    for (std::uint16_t wheel = 0; wheel < 14; ++wheel) events.push_back({25, SD_EVENT_WHEEL_EDGE, wheel, 0, 0});
    for (std::uint16_t input = 0; input < SD_INPUT_COUNT; ++input) events.push_back({30, SD_EVENT_SAMPLE, input, bits(1.25f), 0});
    events.push_back({31, SD_EVENT_TIME, 0, 0, 0});
    events.push_back({32, SD_EVENT_CRANK_EDGE, 0, 0, 0});
    events.push_back({33, SD_EVENT_TIME, 0, 0, 0});
    expect_same(events, through_can(SD_ROLE_PLANT, SD_ROLE_ECU, events));
}

TEST(CanFrames, CarryEveryEventOfTheEcuInOrder) {
    std::vector<sd_event_t> events = row_of(77, SD_RATE_CYCLE);
    for (const sd_rate_t rate : {SD_RATE_FIRING, SD_RATE_EDGE, SD_RATE_TASK}) {
        const auto row = row_of(77, rate);
        events.insert(events.end(), row.begin(), row.end());
    }
    events.push_back({78, SD_EVENT_DONE, 0, 3, 200});
    for (const sd_role_t to : {SD_ROLE_PLANT, SD_ROLE_TOOL}) expect_same(events, through_can(SD_ROLE_ECU, to, events));
    events = {{0, SD_EVENT_PARAMETER, 3, bits(0.25f), SD_PARAMETER_SET | SD_PARAMETER_RANGE << 8}};
    expect_same(events, through_can(SD_ROLE_ECU, SD_ROLE_TOOL, events));
    events.front().flags = SD_PARAMETER_SET;
    expect_same(events, through_can(SD_ROLE_TOOL, SD_ROLE_ECU, events));
}

TEST(CanFrames, TruthReachesAToolAndNoEcu) {
    const auto plant = codec(SD_ROLE_PLANT), ecu = codec(SD_ROLE_ECU), tool = codec(SD_ROLE_TOOL);
    sd_truth_t truth{};
    truth.kind = sd_truth_t::SD_TRUTH_EDGE;
    truth.edge = {0.1, 359.9, 1079.9, 104.7, -33.3, 0x80000001u, 57, 2};
    ASSERT_EQ(1, sd_can_encode_truth(plant.get(), &truth));
    for (const sd_frame_t &frame : frames_of(*plant)) {
        EXPECT_EQ(0, sd_can_decode(ecu.get(), &frame));
        ASSERT_EQ(1, sd_can_decode(tool.get(), &frame));
    }
    EXPECT_TRUE(events_of(ecu->in).empty());
    EXPECT_EQ(-33.3, tool->truth.edge.net_torque_nm);
    EXPECT_EQ(1079.9, tool->truth.edge.crank_deg);
    EXPECT_EQ(57, tool->truth.edge.tooth);
    EXPECT_FALSE(sd_lcm_listens(SD_ROLE_ECU, SD_LCM_TRUTH));
}

TEST(CanFrames, WithoutRoomNothingIsTaken) {
    const auto plant = codec(SD_ROLE_PLANT);
    std::uint32_t taken = 0;
    for (sd_event_t event{0, SD_EVENT_TIME, 0, 0, 0}; sd_can_encode(plant.get(), &event); ++event.tick) ++taken;
    EXPECT_EQ(taken, frames_of(*plant).size());
    EXPECT_GT(taken, 400u);
}

TEST(Order, FindsWhatIsMissingDoubledOrStartedAnew) {
    sd_order_t order{};
    EXPECT_EQ(SD_ARRIVAL_NEXT, sd_order_check(&order, 1, 65535, 1)) << "one may join at any time";
    EXPECT_EQ(SD_ARRIVAL_NEXT, sd_order_check(&order, 1, 0, 1));
    EXPECT_EQ(SD_ARRIVAL_STALE, sd_order_check(&order, 1, 0, 1));
    EXPECT_EQ(SD_ARRIVAL_GAP, sd_order_check(&order, 1, 3, 1));
    EXPECT_EQ(SD_ARRIVAL_STALE, sd_order_check(&order, 1, 1, 1)) << "late";
    EXPECT_EQ(SD_ARRIVAL_NEXT, sd_order_check(&order, 1, 4, 0)) << "the clock only says what comes next";
    EXPECT_EQ(SD_ARRIVAL_NEXT, sd_order_check(&order, 1, 4, 1));
    EXPECT_EQ(SD_ARRIVAL_GAP, sd_order_check(&order, 2, 5, 1)) << "another session";
    int stale = 0;
    while (sd_order_check(&order, 2, 0, 1) == SD_ARRIVAL_STALE) ++stale;
    EXPECT_EQ(8, stale) << "the same session by chance";
}

/// Every event that decoders may hand out, whatever they were fed.
void expect_harmless(const std::vector<sd_event_t> &events) {
    for (const sd_event_t &event : events) {
        if (event.kind != SD_EVENT_SIGNAL) continue;
        float value;
        std::memcpy(&value, &event.value, sizeof value);
        ASSERT_LT(event.channel, SD_SIGNAL_COUNT);
        ASSERT_TRUE(std::isfinite(value));
        ASSERT_LE(event.flags & 0xff, 2u);
    }
}

TEST(Fuzz, AnyCanFrameIsTakenOrCounted) {
    std::mt19937 random(1);
    for (const sd_role_t role : {SD_ROLE_ECU, SD_ROLE_PLANT, SD_ROLE_TOOL}) {
        const auto in = codec(role);
        for (int i = 0; i < 100000; ++i) {
            sd_frame_t frame{};
            frame.id = random() % 2 ? 0xa0 + random() % 0x60 : random();
            frame.length = random() % 4 ? std::uint8_t(std::array{8, 48, 64}[random() % 3]) : std::uint8_t(random() % 65);
            for (std::uint8_t &byte : frame.bytes) byte = random() % 3 ? std::uint8_t(random()) : 0;
            sd_can_decode(in.get(), &frame);
            expect_harmless(events_of(in->in));
        }
        EXPECT_GT(in->counts.foreign, 1000u);
        EXPECT_GT(in->counts.malformed, 1000u);
    }
}

std::vector<std::uint8_t> valid_message(sd_lcm_channel_t channel) {
    std::vector<std::uint8_t> bytes(65536);
    std::vector<sixdeg_event_t> events(20);
    std::vector<sixdeg_edge_t> edges(20);
    std::vector<sixdeg_cycle_t> cycles(2);
    std::vector<sixdeg_firing_t> firings(4);
    std::vector<sixdeg_task_t> tasks(1);
    std::vector<sixdeg_truth_edge_t> truth_edges(20);
    std::vector<sixdeg_truth_cycle_t> truth_cycles(2);
    int size = 0;
    if (channel == SD_LCM_INPUTS) {
        for (std::size_t i = 0; i < events.size(); ++i) events[i].kind = std::int16_t(1 + i % 5);
        const sixdeg_inputs_t m{20, 0, 1, events.data()};
        size = sixdeg_inputs_t_encode(bytes.data(), 0, int(bytes.size()), &m);
    } else if (channel == SD_LCM_OUTPUTS) {
        sixdeg_outputs_t m{};
        m.edges = 20, m.cycles = 2, m.firings = 4, m.tasks = 1, m.done = 1;
        m.edge = edges.data(), m.cycle = cycles.data(), m.firing = firings.data(), m.task = tasks.data();
        size = sixdeg_outputs_t_encode(bytes.data(), 0, int(bytes.size()), &m);
    } else if (channel == SD_LCM_TRUTH) {
        const sixdeg_truth_t m{20, 2, 1, 20, 2, truth_edges.data(), truth_cycles.data()};
        size = sixdeg_truth_t_encode(bytes.data(), 0, int(bytes.size()), &m);
    } else if (channel == SD_LCM_CLAIM) {
        const sixdeg_claim_t m{1, 2};
        size = sixdeg_claim_t_encode(bytes.data(), 0, int(bytes.size()), &m);
    } else {
        const sixdeg_parameter_t m{2, 3, 0.5f, 0};
        size = sixdeg_parameter_t_encode(bytes.data(), 0, int(bytes.size()), &m);
    }
    bytes.resize(std::size_t(size));
    return bytes;
}

TEST(Fuzz, AnyLcmMessageIsTakenOrCounted) {
    std::mt19937 random(2);
    for (int c = 0; c < SD_LCM_CHANNELS; ++c) {
        const auto channel = sd_lcm_channel_t(c);
        const auto in = std::make_unique<sd_lcm_codec_t>();
        const auto valid = valid_message(channel);
        sd_lcm_decode(in.get(), channel, valid.data(), int(valid.size()));
        EXPECT_EQ(0u, in->counts.malformed) << sd_lcm_channel_names[c];
        for (int i = 0; i < 20000; ++i) {
            auto bytes = valid;
            for (unsigned flips = random() % 4; flips > 0; --flips) bytes[random() % bytes.size()] = std::uint8_t(random());
            if (random() % 2) bytes.resize(random() % bytes.size());
            const std::vector<std::uint8_t> exact(bytes); // its end is the end of its memory
            sd_lcm_decode(in.get(), channel, exact.data(), int(exact.size()));
            expect_harmless(events_of(in->in));
            in->truth_read = in->truth_written;
        }
        EXPECT_GT(in->counts.malformed, 5000u) << sd_lcm_channel_names[c];
    }
}

/// A cycle's row in pieces of some channels, one before each of the edge rows that follow the tooth at 1000.
std::vector<sd_event_t> spread_cycle(std::size_t pieces) {
    std::vector<sd_event_t> events;
    const auto cycle = row_of(1000, SD_RATE_CYCLE);
    for (std::size_t i = 0; i < pieces; ++i) {
        for (std::size_t c = i * cycle.size() / pieces; c < (i + 1) * cycle.size() / pieces; ++c) events.push_back(cycle[c]);
        if (i == 1) for (const sd_event_t &event : row_of(1100, SD_RATE_FIRING)) events.push_back(event);
        for (const sd_event_t &event : row_of(std::uint32_t(1000 + 100 * i), SD_RATE_EDGE)) events.push_back(event);
    }
    return events;
}

/// Rows in the order in which they end, as a bus hands them out.
std::vector<sd_event_t> whole_rows(std::size_t pieces) {
    std::vector<sd_event_t> events;
    const auto add = [&events](const std::vector<sd_event_t> &row) { events.insert(events.end(), row.begin(), row.end()); };
    for (std::size_t i = 0; i < pieces; ++i) {
        if (i + 1 == pieces) add(row_of(1000, SD_RATE_CYCLE));
        if (i == 1) add(row_of(1100, SD_RATE_FIRING));
        add(row_of(std::uint32_t(1000 + 100 * i), SD_RATE_EDGE));
    }
    return events;
}

/// Each edge and whether a cycle was complete with it.
std::vector<bool> cycles_at(const std::vector<sd_event_t> &events, std::size_t edges, EcuSaid &said) {
    Answers answers;
    answers.add(events);
    std::vector<bool> ended;
    for (std::size_t i = 0; i < edges; ++i) ended.push_back(answers.take(std::uint32_t(1000 + 100 * i), said));
    EXPECT_EQ(0u, answers.missing());
    return ended;
}

template <class Link> class SpreadRows : public ::testing::Test {};
TYPED_TEST_SUITE(SpreadRows, Links);

TYPED_TEST(SpreadRows, ACycleEndsWhenItsLastPieceCameInOneProcessAndOnABus) {
    for (const std::size_t pieces : {1u, 2u, 5u, 69u}) {
        TypeParam link;
        for (const auto &packet : link.to_plant(spread_cycle(pieces))) link.at_plant(packet);
        const auto heard = events_of(link.plant->in);
        expect_same(whole_rows(pieces), heard);
        EcuSaid in_process, on_bus;
        std::vector<bool> expected(pieces, false);
        expected.back() = true;
        EXPECT_EQ(expected, cycles_at(spread_cycle(pieces), pieces, in_process));
        EXPECT_EQ(expected, cycles_at(heard, pieces, on_bus));
        EXPECT_EQ(1000u, on_bus.cycle_tick()) << "the tooth that ended it";
        EXPECT_EQ(0, std::memcmp(&in_process.signals(), &on_bus.signals(), sizeof(sd_signals_t)));
    }
}

TEST(Rows, ATornOneIsNeverSent) {
    sd_row_t rows[SD_RATE_COUNT] = {};
    auto torn = row_of(10, SD_RATE_CYCLE), next = row_of(10, SD_RATE_CYCLE);
    torn.pop_back();
    int whole = 0;
    for (const auto &events : {torn, next, torn, row_of(20, SD_RATE_CYCLE)}) {
        for (const sd_event_t &event : events) {
            if (const sd_row_t *row = sd_row_take(rows, &event)) {
                ++whole;
                EXPECT_EQ(whole == 1 ? 10u : 20u, row->tick);
                EXPECT_EQ(next.back().channel, event.channel) << "not before its last channel";
            }
        }
    }
    EXPECT_EQ(2, whole);
}

TEST(CanFrames, AWheelThatNoFrameHasRoomForIsCounted) {
    const auto plant = codec(SD_ROLE_PLANT);
    const sd_event_t edge{1, SD_EVENT_WHEEL_EDGE, 14, 0, 0}, time{2, SD_EVENT_TIME, 0, 0, 0};
    EXPECT_EQ(1, sd_can_encode(plant.get(), &edge));
    EXPECT_EQ(1, sd_can_encode(plant.get(), &time));
    EXPECT_EQ(1u, frames_of(*plant).size()) << "the clock alone";
    EXPECT_EQ(1u, plant->counts.unsent);
}

template <class Link> class Inputs : public ::testing::Test {};
TYPED_TEST_SUITE(Inputs, Links);

TYPED_TEST(Inputs, EveryKindReachesTheEcuInOrder) {
    std::vector<sd_event_t> events;
    for (std::uint32_t i = 0; i < 200; ++i) {
        constexpr std::array kinds{SD_EVENT_CRANK_EDGE, SD_EVENT_WHEEL_EDGE, SD_EVENT_CAM_EDGE, SD_EVENT_SAMPLE};
        const auto kind = i % 29 == 28 ? SD_EVENT_TIME : kinds[i % 7 % kinds.size()];
        const auto channel = std::uint16_t(kind == SD_EVENT_WHEEL_EDGE ? i % 5 : kind == SD_EVENT_SAMPLE ? i % SD_INPUT_COUNT : 0);
        events.push_back({i, std::uint16_t(kind), channel, kind == SD_EVENT_SAMPLE ? bits(float(i)) : 0, 0});
    }
    events.push_back({200, SD_EVENT_TIME, 0, 0, 0});
    TypeParam link;
    for (const auto &packet : link.to_ecu(events)) link.at_ecu(packet);
    expect_same(events, events_of(link.ecu->in));
}

TEST(Answers, AnEdgeWithoutAWholeAnswerIsNotTrusted) {
    Answers answers;
    EcuSaid said;
    auto first = row_of(10, SD_RATE_EDGE), second = row_of(20, SD_RATE_EDGE), ended = row_of(30, SD_RATE_CYCLE),
         third = row_of(30, SD_RATE_EDGE);
    second.pop_back(); // torn
    ended.insert(ended.end(), third.begin(), third.end());
    for (const auto &row : {first, second, ended}) answers.add(row);
    EXPECT_FALSE(answers.take(10, said));
    EXPECT_EQ(1, said.health(SD_OWNER_CRANK));
    EXPECT_FALSE(answers.take(20, said));
    EXPECT_EQ(SD_INVALID, said.health(SD_OWNER_CRANK));
    EXPECT_TRUE(answers.take(30, said)) << "and the next one is found all the same";
    EXPECT_EQ(1, said.health(SD_OWNER_CYLINDER));
    EXPECT_FALSE(answers.take(40, said));
    EXPECT_EQ(2u, answers.missing());
}

} // namespace
