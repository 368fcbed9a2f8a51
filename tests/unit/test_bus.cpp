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

#include "design/calibration.hpp"
#include "io/events/ecu_feed.hpp"
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

/// Degraded, with reasons that take all 16 bits.
constexpr std::uint32_t kStatus = SD_DEGRADED | 0x8104u << 8;

std::vector<sd_event_t> row_of(std::uint32_t tick, sd_rate_t rate) {
    std::vector<sd_event_t> events;
    for (std::uint16_t c = 0; c < SD_SIGNAL_COUNT; ++c) {
        if (sd_signal_infos[c].rate == rate) events.push_back({tick, SD_EVENT_SIGNAL, c, bits(1.5f * float(c) - 3), kStatus});
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

/// The two ends of a bus without the bus: events become packets, and packets events.
struct CanLink {
    using Packet = sd_frame_t;
    std::unique_ptr<sd_can_codec_t> plant = codec(SD_ROLE_PLANT), ecu = codec(SD_ROLE_ECU, 9);

    static std::vector<Packet> pack(sd_can_codec_t &from, const std::vector<sd_event_t> &events) {
        std::vector<Packet> packets;
        for (const sd_event_t &event : events) {
            EXPECT_EQ(1, sd_can_encode(&from, &event));
            for (const sd_frame_t &frame : frames_of(from)) packets.push_back(frame);
        }
        return packets;
    }
    std::vector<Packet> to_ecu(const std::vector<sd_event_t> &events) { return pack(*plant, events); }
    std::vector<Packet> to_plant(const std::vector<sd_event_t> &events) { return pack(*ecu, events); }
    void at_ecu(const Packet &packet) { sd_can_decode(ecu.get(), &packet); }
    void at_plant(const Packet &packet) { sd_can_decode(plant.get(), &packet); }
    void start_plant_anew() { plant->session = 8, plant->sequence = 0; }
    static void cut(Packet &packet, std::uint32_t random) { packet.length = std::uint8_t(random % packet.length); }
};

struct LcmLink {
    struct Packet {
        sd_lcm_channel_t channel;
        std::vector<std::uint8_t> bytes;
    };
    std::unique_ptr<sd_lcm_codec_t> plant = std::make_unique<sd_lcm_codec_t>(), ecu = std::make_unique<sd_lcm_codec_t>();
    std::int32_t sequence = 0, session = 7;
    LcmLink() { plant->role = SD_ROLE_PLANT; }

    std::vector<Packet> to_ecu(const std::vector<sd_event_t> &events) {
        std::vector<sixdeg_event_t> sent;
        for (const sd_event_t &e : events)
            sent.push_back({std::int32_t(e.tick), std::int16_t(e.kind), std::int16_t(e.channel), std::int32_t(e.value), std::int32_t(e.flags)});
        const sixdeg_inputs_t m{std::int32_t(sent.size()), sequence++ & 0xffff, session, sent.data()};
        std::vector<std::uint8_t> bytes(std::size_t(sixdeg_inputs_t_encoded_size(&m)));
        EXPECT_GT(sixdeg_inputs_t_encode(bytes.data(), 0, int(bytes.size()), &m), 0);
        return {{SD_LCM_INPUTS, bytes}};
    }
    std::vector<Packet> to_plant(const std::vector<sd_event_t> &events) {
        for (const sd_event_t &event : events) {
            if (event.kind == SD_EVENT_SIGNAL) sd_lcm_add_signal(ecu.get(), &event);
        }
        sixdeg_outputs_t m{};
        sd_lcm_rows_to_message(&m, &ecu->rows);
        std::vector<std::uint8_t> bytes(std::size_t(sixdeg_outputs_t_encoded_size(&m)));
        EXPECT_GT(sixdeg_outputs_t_encode(bytes.data(), 0, int(bytes.size()), &m), 0);
        sd_lcm_rows_clear(&ecu->rows);
        return {{SD_LCM_OUTPUTS, bytes}};
    }
    void at_ecu(const Packet &packet) { sd_lcm_decode(ecu.get(), packet.channel, packet.bytes.data(), int(packet.bytes.size())); }
    void at_plant(const Packet &packet) { sd_lcm_decode(plant.get(), packet.channel, packet.bytes.data(), int(packet.bytes.size())); }
    void start_plant_anew() { session = 8, sequence = 0; }
    static void cut(Packet &packet, std::uint32_t random) { packet.bytes.resize(random % packet.bytes.size()); }
};

/// 1 % of packets are lost, doubled, overtaken by the next one, or cut.
template <class Link> struct OnePercent {
    std::mt19937 random{3};
    std::array<std::uint32_t, 4> made{};
    std::vector<typename Link::Packet> held;

    std::vector<typename Link::Packet> operator()(const std::vector<typename Link::Packet> &packets) {
        std::vector<typename Link::Packet> out;
        for (const auto &packet : packets) {
            const std::uint32_t dice = random() % 400;
            if (dice < 4) ++made[dice];
            if (dice == 0) continue;
            const auto late = std::move(held);
            held.clear();
            if (dice == 2) held.push_back(packet); else out.push_back(packet);
            if (dice == 1) out.push_back(packet);
            if (dice == 3) Link::cut(out.back(), random());
            out.insert(out.end(), late.begin(), late.end());
        }
        return out;
    }
};

/// An ecu at one end, a wheel of 60-2 teeth at constant speed at the other, and who judges what comes back.
template <class Link> struct Wheel {
    using Packets = std::vector<typename Link::Packet>;
    Link link;
    std::optional<StoredPage> page;
    std::unique_ptr<sd_ecu_t> ecu = std::make_unique<sd_ecu_t>();
    std::vector<sd_event_t> said; ///< By the ecu, not yet sent.
    std::map<std::uint32_t, int> true_tooth;
    std::map<std::uint32_t, std::array<float, 2>> said_of; ///< Torque at the tooth, and of cylinder 1 where a cycle ended.
    Answers answers;
    EcuSaid heard;
    std::uint32_t valid = 0, wrong = 0, cycles_valid = 0, heard_valid = 0, heard_wrong = 0, heard_cycles = 0;
    std::array<float, 2> torque_range{1e9f, -1e9f}; ///< Of cylinder 1 where it was heard to be valid.

    Wheel() {
        TomlFile file(std::filesystem::path(SD_ENGINES) / "diesel_22.toml"), tune("tune", "");
        page.emplace(calibrate(read_engine(file), read_tune(tune), "tune"));
        EXPECT_EQ(SD_OK, sd_ecu_init(ecu.get(), page->view()));
    }

    static std::uint32_t receive(void *self, sd_event_t *events, std::uint32_t room) {
        return sd_queue_take(&static_cast<Wheel *>(self)->link.ecu->in, events, room);
    }
    static std::uint32_t take(void *self, const sd_event_t *events, std::uint32_t count) {
        for (std::uint32_t i = 0; i < count; ++i) static_cast<Wheel *>(self)->judge(events[i]);
        return count;
    }
    void judge(const sd_event_t &event) {
        said.push_back(event);
        float value;
        std::memcpy(&value, &event.value, sizeof value);
        if (event.channel == SD_SIGNAL_TORQUE_MASS) said_of[event.tick][0] = value;
        if (event.channel == SD_SIGNAL_CYCLE_CYLINDER_TORQUE) said_of[event.tick][1] = value;
        if (event.kind != SD_EVENT_SIGNAL || (event.flags & 0xff) != SD_VALID) return;
        cycles_valid += event.channel == SD_SIGNAL_CYCLE_CYLINDER_TORQUE;
        if (event.channel != SD_SIGNAL_CRANK_TOOTH) return;
        ++valid;
        wrong += true_tooth.at(event.tick) != int(value);
    }

    /// At the plant: an edge that is said to be valid has the tooth and the torque that the ecu said of it.
    void judge_heard(std::uint32_t tick) {
        const bool cycle_ended = answers.take(tick, heard);
        const sd_signals_t &s = heard.signals();
        if (heard.health(SD_OWNER_CRANK) != SD_VALID) return;
        ++heard_valid;
        heard_wrong += int(s.crank_tooth) != true_tooth.at(tick) || s.torque_mass_nm != said_of[tick][0];
        if (!cycle_ended || heard.health(SD_OWNER_CYLINDER) != SD_VALID) return;
        ++heard_cycles;
        const float torque = s.cycle_cylinder_torque_nm[0];
        heard_wrong += torque != said_of[heard.cycle_tick()][1];
        torque_range = {std::min(torque, torque_range[0]), std::max(torque, torque_range[1])};
    }

    void turn(int revolutions, const std::function<Packets(const Packets &)> &to_ecu, const std::function<Packets(const Packets &)> &to_plant) {
        const sd_port_t port{this, receive, take};
        std::vector<sd_event_t> events;
        for (int k = 0; k < 60 * revolutions; ++k) {
            const auto tick = std::uint32_t(1000 * k); // 1000 rpm at 1 MHz
            if (k % 60 < 58) {
                true_tooth[tick] = k % 60;
                events.push_back({tick, SD_EVENT_CRANK_EDGE, 0, 0, 0});
            }
            if (k % 120 == 25) events.push_back({tick + 3, SD_EVENT_CAM_EDGE, 0, 0, 0});
            if (k % 10 != 9) continue;
            events.push_back({tick + 500, SD_EVENT_SAMPLE, SD_INPUT_AIR_INTAKE_PRESSURE, bits(1.0f), 0});
            events.push_back({tick + 500, SD_EVENT_TIME, 0, 0, 0});
            for (const auto &packet : to_ecu(link.to_ecu(events))) link.at_ecu(packet);
            sd_ecu_run(ecu.get(), page->view(), &port);
            for (const auto &packet : to_plant(link.to_plant(said))) link.at_plant(packet);
            answers.add(events_of(link.plant->in));
            for (const sd_event_t &event : events) {
                if (event.kind == SD_EVENT_CRANK_EDGE) judge_heard(event.tick);
            }
            events.clear(), said.clear();
        }
    }
};

template <class Link> class Faults : public ::testing::Test {};
using Links = ::testing::Types<CanLink, LcmLink>;
TYPED_TEST_SUITE(Faults, Links);

TYPED_TEST(Faults, OnePercentOfPacketsLostDoubledSwappedOrCutIsCountedAndNeverCalledValid) {
    using Packets = typename Wheel<TypeParam>::Packets;
    const auto pass = [](const Packets &packets) { return packets; };
    Wheel<TypeParam> clean, wheel;
    clean.turn(60, pass, pass);
    ASSERT_GT(clean.heard_cycles, 10u);
    OnePercent<TypeParam> there, back;
    back.random.seed(4);
    wheel.turn(3000, std::ref(there), std::ref(back));
    EXPECT_EQ(0u, wheel.wrong);
    EXPECT_EQ(0u, wheel.heard_wrong);
    EXPECT_GT(wheel.valid, 50000u) << "it finds back between faults";
    EXPECT_GT(wheel.heard_valid, 40000u);
    EXPECT_GT(wheel.heard_cycles, 10u);
    // At constant speed a right value is always the same one, but for what is left of settling.
    EXPECT_GT(wheel.torque_range[0], clean.torque_range[0] - 1);
    EXPECT_LT(wheel.torque_range[1], clean.torque_range[1] + 1);
    const sd_port_counts_t &counts = wheel.link.ecu->counts, &plant = wheel.link.plant->counts;
    EXPECT_EQ(there.made[3], counts.malformed);
    EXPECT_EQ(back.made[3], plant.malformed);
    EXPECT_GT(counts.gaps, 20u);
    EXPECT_GT(counts.stale, 20u) << "doubled teeth; a doubled sample or clock frame is no news";
    EXPECT_GT(wheel.answers.missing(), 20u);
    std::printf("to the ecu: packets %u, lost %u, doubled %u, overtaken %u, cut %u; gaps %u, stale %u, malformed %u\n"
                "to the plant: lost %u, doubled %u, overtaken %u, cut %u; edges without an answer %zu\n"
                "teeth valid at the ecu %u, wrong %u; at the plant %u, wrong %u; cycles %u, torque of cylinder 1 %.2f to %.2f Nm (%.2f to %.2f without faults)\n",
                counts.received, there.made[0], there.made[1], there.made[2], there.made[3], counts.gaps, counts.stale, counts.malformed,
                back.made[0], back.made[1], back.made[2], back.made[3], wheel.answers.missing(), wheel.valid, wheel.wrong, wheel.heard_valid,
                wheel.heard_wrong, wheel.heard_cycles, double(wheel.torque_range[0]), double(wheel.torque_range[1]),
                double(clean.torque_range[0]), double(clean.torque_range[1]));
}

TYPED_TEST(Faults, AfterTheOtherSideStartsAnewCylindersAreValidWithinTenCycles) {
    using Packets = typename Wheel<TypeParam>::Packets;
    Wheel<TypeParam> wheel;
    const auto pass = [](const Packets &packets) { return packets; };
    wheel.turn(40, pass, pass);
    EXPECT_GT(wheel.cycles_valid, 5u);
    const std::uint32_t before = wheel.cycles_valid;
    wheel.link.start_plant_anew(); // its time and its sequence begin again
    wheel.turn(2 * 10 + 1, pass, pass); // what ends the tenth cycle is a tooth of the next one
    EXPECT_EQ(1u, wheel.link.ecu->counts.gaps);
    EXPECT_EQ(1u, wheel.link.ecu->order.starts);
    EXPECT_GT(wheel.cycles_valid, before);
    EXPECT_EQ(0u, wheel.wrong);
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
