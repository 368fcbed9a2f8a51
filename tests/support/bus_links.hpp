// SPDX-License-Identifier: MIT
// A bus without a bus: frames of CAN and messages of LCM from one codec to the other.
#pragma once
#include <cstring>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

extern "C" {
#include "sd_can_codec.h"
#include "sd_lcm_codec.h"
}

namespace sixdeg::test {

inline std::unique_ptr<sd_can_codec_t> codec(sd_role_t role, std::uint16_t session = 7) {
    auto made = std::make_unique<sd_can_codec_t>();
    made->role = role;
    made->session = session;
    return made;
}

inline std::vector<sd_frame_t> frames_of(sd_can_codec_t &from) {
    std::vector<sd_frame_t> frames;
    while (from.read != from.written) frames.push_back(from.out[from.read++ % SD_CAN_FRAMES]);
    return frames;
}

inline std::vector<sd_event_t> events_of(sd_queue_t &queue) {
    std::vector<sd_event_t> events(SD_QUEUE_EVENTS);
    events.resize(sd_queue_take(&queue, events.data(), SD_QUEUE_EVENTS));
    return events;
}

inline bool same(const sd_event_t &a, const sd_event_t &b) {
    return a.tick == b.tick && a.kind == b.kind && a.channel == b.channel && a.value == b.value && a.flags == b.flags;
}

inline std::uint32_t bits(float value) {
    std::uint32_t raw;
    std::memcpy(&raw, &value, sizeof raw);
    return raw;
}

/// Degraded, with reasons that take all 16 bits.
constexpr std::uint32_t kStatus = SD_DEGRADED | 0x8104u << 8;

inline std::vector<sd_event_t> row_of(std::uint32_t tick, sd_rate_t rate) {
    std::vector<sd_event_t> events;
    for (std::uint16_t c = 0; c < SD_SIGNAL_COUNT; ++c) {
        if (sd_signal_infos[c].rate == rate) events.push_back({tick, SD_EVENT_SIGNAL, c, bits(1.5f * float(c) - 3), kStatus});
    }
    return events;
}

inline std::vector<sd_event_t> through_can(sd_role_t from, sd_role_t to, const std::vector<sd_event_t> &events) {
    const auto out = codec(from), in = codec(to);
    for (const sd_event_t &event : events) EXPECT_EQ(1, sd_can_encode(out.get(), &event));
    for (const sd_frame_t &frame : frames_of(*out)) sd_can_decode(in.get(), &frame);
    EXPECT_EQ(0u, in->counts.malformed + in->counts.foreign + in->counts.gaps + in->counts.stale);
    return events_of(in->in);
}

inline void expect_same(const std::vector<sd_event_t> &sent, const std::vector<sd_event_t> &got) {
    ASSERT_EQ(sent.size(), got.size());
    for (std::size_t i = 0; i < sent.size(); ++i) EXPECT_TRUE(same(sent[i], got[i])) << i << ": kind " << got[i].kind;
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
            sent.push_back({std::int32_t(e.tick), std::int16_t(e.kind), std::int16_t(e.channel), std::int32_t(e.value),
                            std::int32_t(e.flags)});
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

using Links = ::testing::Types<CanLink, LcmLink>;

} // namespace sixdeg::test
