// SPDX-License-Identifier: MIT
// The wire: what CAN frames and LCM messages carry comes out as it went in; any bytes at all do no harm; lost, doubled,
// late and cut frames are counted, and nothing wrong is called valid. No socket is needed for that.
#include <cmath>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <random>

#include "calibration/calibration.hpp"
#include "replay/ecu_feed.hpp"
extern "C" {
#include "sd_can_codec.h"
#include "sd_ecu.h"
#include "sd_lcm_codec.h"
}

using namespace sixdeg;

namespace {

std::unique_ptr<sd_can_codec_t> codec(sd_role_t role, std::uint16_t session = 7) {
    auto made = std::make_unique<sd_can_codec_t>();
    made->role = role;
    made->session = session;
    return made;
}

std::vector<sd_frame_t> frames_of(sd_can_codec_t &from) {
    std::vector<sd_frame_t> frames;
    while (from.read != from.written) frames.push_back(from.out[from.read++ % SD_CAN_FRAMES]);
    return frames;
}

std::vector<sd_event_t> events_of(sd_queue_t &queue) {
    std::vector<sd_event_t> events(SD_QUEUE_EVENTS);
    events.resize(sd_queue_take(&queue, events.data(), SD_QUEUE_EVENTS));
    return events;
}

bool same(const sd_event_t &a, const sd_event_t &b) {
    return a.tick == b.tick && a.kind == b.kind && a.channel == b.channel && a.value == b.value && a.flags == b.flags;
}

std::uint32_t bits(float value) {
    std::uint32_t raw;
    std::memcpy(&raw, &value, sizeof raw);
    return raw;
}

std::vector<sd_event_t> row_of(std::uint32_t tick, sd_rate_t rate) {
    std::vector<sd_event_t> events;
    for (std::uint16_t c = 0; c < SD_SIGNAL_COUNT; ++c) {
        if (sd_signal_infos[c].rate == rate) events.push_back({tick, SD_EVENT_SIGNAL, c, bits(1.5f * float(c) - 3), 1u | 4u << 8});
    }
    return events;
}

std::vector<sd_event_t> through_can(sd_role_t from, sd_role_t to, const std::vector<sd_event_t> &events) {
    const auto out = codec(from), in = codec(to);
    for (const sd_event_t &event : events) EXPECT_EQ(1, sd_can_encode(out.get(), &event));
    for (const sd_frame_t &frame : frames_of(*out)) sd_can_decode(in.get(), &frame);
    EXPECT_EQ(0u, in->counts.malformed + in->counts.foreign + in->counts.gaps + in->counts.stale);
    return events_of(in->in);
}

void expect_same(const std::vector<sd_event_t> &sent, const std::vector<sd_event_t> &got) {
    ASSERT_EQ(sent.size(), got.size());
    for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_TRUE(same(sent[i], got[i])) << i << ": kind " << got[i].kind;
}

TEST(CanFrames, CarryEveryEventOfThePlantInOrder) {
    std::vector<sd_event_t> events;
    for (std::uint32_t i = 0; i < 40; ++i)
        events.push_back({0xfffffff0u + i, std::uint16_t(i % 13 == 5 ? SD_EVENT_CAM_EDGE : SD_EVENT_CRANK_EDGE), 0, 0, 0});
    for (std::uint16_t input = 0; input < SD_INPUT_COUNT; ++input) events.push_back({30, SD_EVENT_SAMPLE, input, bits(1.25f), 0});
    events.push_back({31, SD_EVENT_TIME, 0, 0, 0});
    events.push_back({32, SD_EVENT_CRANK_EDGE, 0, 0, 0});
    events.push_back({33, SD_EVENT_TIME, 0, 0, 0});
    expect_same(events, through_can(SD_ROLE_PLANT, SD_ROLE_ECU, events));
}

TEST(CanFrames, CarryEveryEventOfTheEcuInOrder) {
    std::vector<sd_event_t> events = row_of(77, SD_RATE_CYCLE);
    const auto edge = row_of(77, SD_RATE_EDGE);
    events.insert(events.end(), edge.begin(), edge.end());
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
    std::vector<sixdeg_truth_edge_t> truth_edges(20);
    std::vector<sixdeg_truth_cycle_t> truth_cycles(2);
    int size = 0;
    if (channel == SD_LCM_INPUTS) {
        const sixdeg_inputs_t m{20, 0, 1, events.data()};
        size = sixdeg_inputs_t_encode(bytes.data(), 0, int(bytes.size()), &m);
    } else if (channel == SD_LCM_OUTPUTS) {
        const sixdeg_outputs_t m{20, 2, 1, 0, 1, 0, 0, edges.data(), cycles.data()};
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

/// An ecu behind a pair of codecs whose frames `fault` may change, and a wheel of 60-2 teeth at constant speed.
struct Wheel {
    std::unique_ptr<sd_can_codec_t> plant = codec(SD_ROLE_PLANT), ecu_side = codec(SD_ROLE_ECU);
    std::unique_ptr<sd_ecu_t> ecu = std::make_unique<sd_ecu_t>();
    std::map<std::uint32_t, int> true_tooth;
    std::uint32_t valid = 0, wrong = 0, cycles_valid = 0;

    Wheel() {
        TomlFile file(std::filesystem::path(SD_ENGINES) / "diesel_22.toml"), tune("tune", "");
        const sd_calibration_t page = calibrate(read_engine(file), read_tune(tune), "tune");
        EXPECT_EQ(SD_OK, sd_ecu_init(ecu.get(), &page));
    }

    static std::uint32_t receive(void *self, sd_event_t *events, std::uint32_t room) {
        return sd_queue_take(&static_cast<Wheel *>(self)->ecu_side->in, events, room);
    }
    static std::uint32_t take(void *self, const sd_event_t *events, std::uint32_t count) {
        for (std::uint32_t i = 0; i < count; ++i) static_cast<Wheel *>(self)->judge(events[i]);
        return count;
    }
    void judge(const sd_event_t &event) {
        float value;
        std::memcpy(&value, &event.value, sizeof value);
        if (event.kind != SD_EVENT_SIGNAL || (event.flags & 0xff) != SD_VALID) return;
        cycles_valid += event.channel == SD_SIGNAL_CYCLE_CYLINDER_TORQUE;
        if (event.channel != SD_SIGNAL_CRANK_TOOTH) return;
        ++valid;
        wrong += true_tooth.at(event.tick) != int(value);
    }

    void turn(int revolutions, const std::function<std::vector<sd_frame_t>(std::vector<sd_frame_t>)> &fault) {
        const sd_port_t port{this, receive, take};
        const auto send = [&](const sd_event_t &event) { ASSERT_EQ(1, sd_can_encode(plant.get(), &event)); };
        for (int k = 0; k < 60 * revolutions; ++k) {
            const auto tick = std::uint32_t(1000 * k); // 1000 rpm at 1 MHz
            if (k % 60 < 58) {
                true_tooth[tick] = k % 60;
                send({tick, SD_EVENT_CRANK_EDGE, 0, 0, 0});
            }
            if (k % 120 == 25) send({tick + 3, SD_EVENT_CAM_EDGE, 0, 0, 0});
            if (k % 10 != 9) continue;
            send({tick + 500, SD_EVENT_SAMPLE, SD_INPUT_AIR_INTAKE_PRESSURE, bits(1.0f), 0});
            send({tick + 500, SD_EVENT_TIME, 0, 0, 0});
            for (const sd_frame_t &frame : fault(frames_of(*plant))) sd_can_decode(ecu_side.get(), &frame);
            sd_ecu_run(ecu.get(), &port);
        }
    }
};

TEST(Faults, OnePercentOfFramesLostDoubledSwappedOrCutIsCountedAndNeverCalledValid) {
    std::mt19937 random(3);
    std::array<std::uint32_t, 4> made{};
    Wheel wheel;
    wheel.turn(3000, [&](std::vector<sd_frame_t> frames) {
        std::vector<sd_frame_t> out;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            const std::uint32_t dice = random() % 400; // 1 % in all
            if (dice < 4) ++made[dice];
            if (dice == 0) continue;
            out.push_back(frames[i]);
            if (dice == 1) out.push_back(frames[i]);
            if (dice == 2 && out.size() > 1) std::swap(out[out.size() - 1], out[out.size() - 2]);
            if (dice == 3) out.back().length = std::uint8_t(random() % out.back().length);
        }
        return out;
    });
    EXPECT_EQ(0u, wheel.wrong);
    EXPECT_GT(wheel.valid, 50000u) << "it finds back between faults";
    EXPECT_GT(wheel.cycles_valid, 10u);
    const sd_port_counts_t &counts = wheel.ecu_side->counts;
    EXPECT_EQ(made[3], counts.malformed);
    EXPECT_GT(counts.gaps, 20u);
    EXPECT_GT(counts.stale, 20u) << "doubled teeth; a doubled sample or clock frame is no news";
    std::printf("frames %u, lost %u, doubled %u, swapped %u, cut %u; teeth valid %u, wrong %u; gaps %u, stale %u, malformed %u\n",
                counts.received, made[0], made[1], made[2], made[3], wheel.valid, wheel.wrong, counts.gaps, counts.stale, counts.malformed);
}

TEST(Faults, AfterTheOtherSideStartsAnewCylindersAreValidWithinTenCycles) {
    Wheel wheel;
    const auto pass = [](std::vector<sd_frame_t> frames) { return frames; };
    wheel.turn(40, pass);
    EXPECT_GT(wheel.cycles_valid, 5u);
    const std::uint32_t before = wheel.cycles_valid;
    wheel.plant->session = 8; // a new plant: its time and its sequence begin again
    wheel.plant->sequence = 0;
    wheel.turn(2 * 11, pass);
    EXPECT_EQ(1u, wheel.ecu_side->counts.gaps);
    EXPECT_GT(wheel.cycles_valid, before);
    EXPECT_EQ(0u, wheel.wrong);
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
