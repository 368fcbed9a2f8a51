// SPDX-License-Identifier: MIT
// An ecu and a wheel with a bus between them that loses, doubles, swaps and cuts: nothing wrong is called valid.
#include <array>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <optional>
#include <random>

#include "design/calibration.hpp"
#include "io/events/ecu_feed.hpp"
#include "support/bus_links.hpp"
extern "C" {
#include "sd_ecu.h"
}

using namespace sixdeg;
using namespace sixdeg::test;

namespace {

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

    void turn(int revolutions, const std::function<Packets(const Packets &)> &to_ecu,
              const std::function<Packets(const Packets &)> &to_plant) {
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
                "teeth valid at the ecu %u, wrong %u; at the plant %u, wrong %u; cycles %u, "
                "torque of cylinder 1 %.2f to %.2f Nm (%.2f to %.2f without faults)\n",
                counts.received, there.made[0], there.made[1], there.made[2], there.made[3], counts.gaps, counts.stale, counts.malformed,
                back.made[0], back.made[1], back.made[2], back.made[3], wheel.answers.missing(), wheel.valid, wheel.wrong,
                    wheel.heard_valid,
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

} // namespace
