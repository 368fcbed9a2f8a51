// SPDX-License-Identifier: MIT
// The application core behind the in-process port.
#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <tuple>

#include "common/error.hpp"
#include "support/ecu_on_wire.hpp"
#include "support/torque_signal.hpp"

using namespace sixdeg;
using namespace sixdeg::test;

namespace {

TEST(Ecu, TurnsEdgesIntoTorqueThroughTheStream) {
    // Document 004's imbalance, exact tooth times, missing teeth, a cam edge each cycle: decoder and observer together.
    TorqueSignal signal;
    for (const char *number : {"0", "1"}) {
        Ecu ecu(page(std::string("[torque]\nfixed_point = ") + number + "\ntorque_base = 1500\n"));
        const auto times = signal.tooth_times(60, 120 * 30);
        const auto projection = signal.harmonics(5);
        ecu.send(SD_EVENT_SAMPLE, 0, SD_INPUT_AIR_INTAKE_PRESSURE, 1.15f);
        double worst = 0, largest = 0;
        int compared = 0, cycles = 0, cylinders_valid = 0;
        for (int k = 0; k < 120 * 30; ++k) {
            // The signal begins at a TDC; wheel position of its tooth k: 270 deg is position 0, so 0 deg is 15 or 75.
            const int position = (k + 75) % 120;
            if (position % 60 >= 58) continue;
            const auto tick = std::uint32_t(std::llround(times[std::size_t(k)] * 1e7) + 1000);
            const auto answers = ecu.send(SD_EVENT_CRANK_EDGE, tick);
            if (position == 25) ecu.send(SD_EVENT_CAM_EDGE, tick + 10);
            for (const sd_event_t &event : answers) {
                ASSERT_EQ(SD_EVENT_SIGNAL, event.kind);
                ASSERT_TRUE(std::isfinite(value_of(event)));
                if (event.channel == SD_SIGNAL_CRANK_ANGLE && k > 120 * 20) {
                    EXPECT_NEAR(std::fmod(6.0 * k, 720), double(value_of(event)), 1e-3);
                }
                if (event.channel == SD_SIGNAL_TORQUE_MASS && k > 120 * 20) {
                    ASSERT_EQ(0u, event.flags) << "valid";
                    const double truth = series_at(projection, 2 * M_PI / 60 * k);
                    worst = std::fmax(worst, std::fabs(double(value_of(event)) - truth));
                    largest = std::fmax(largest, std::fabs(truth));
                    ++compared;
                }
                if (event.channel == SD_SIGNAL_CYCLE_SPEED) {
                    ++cycles;
                    cylinders_valid += sd_publish_judged(&ecu.ecu->say, SD_OWNER_CYLINDER).health == SD_VALID;
                    if (cycles > 5) { EXPECT_NEAR(120 / (times[std::size_t(k)] - times[std::size_t(k - 120)]), double(value_of(event)),
                                                  0.1); }
                }
            }
        }
        EXPECT_GT(compared, 1000);
        EXPECT_GT(largest, 200);
        EXPECT_LT(worst, 0.06 * signal.peak_to_peak());
        EXPECT_GT(cycles, 25);
        EXPECT_GT(cylinders_valid, 15) << "phase known and observer settled";
        // Cylinder 1 has 30 % of nominal more fuel than cylinder 4: it must show in this order.
        const float *torque = ecu.ecu->say.signals.cycle_cylinder_torque_nm;
        EXPECT_GT(torque[0], torque[1]);
        EXPECT_GT(torque[2], torque[3]);
        EXPECT_GT(torque[0], torque[3]);
    }
}

TEST(Ecu, CylindersAreInvalidWithoutAPhase) {
    TorqueSignal signal;
    Ecu ecu(page());
    const auto times = signal.tooth_times(60, 120 * 12);
    int cycles = 0;
    for (int k = 0; k < 120 * 12; ++k) {
        if ((k + 75) % 60 >= 58) continue;
        for (const sd_event_t &event : ecu.send(SD_EVENT_CRANK_EDGE, std::uint32_t(std::llround(times[std::size_t(k)] * 1e7)))) {
            if (event.channel != SD_SIGNAL_CYCLE_CYLINDER_TORQUE) continue;
            ++cycles;
            EXPECT_EQ(SD_INVALID, event.flags & 0xff);
            EXPECT_TRUE((event.flags >> 8) & SD_WHY_NO_PHASE);
        }
    }
    EXPECT_GT(cycles, 5);
}

TEST(Ecu, CylindersAreDegradedWithoutIntakePressureAndInvalidWithoutAMap) {
    TorqueSignal signal;
    sd_calibration_t without = page();
    without.cylinder_map.cylinders = 0;
    for (const auto &[calibration, health, why] : {std::tuple{page(), SD_DEGRADED, SD_WHY_NO_INPUT},
                                                   std::tuple{without, SD_INVALID, SD_WHY_UNCALIBRATED}}) {
        Ecu ecu(calibration);
        const auto times = signal.tooth_times(60, 120 * 20);
        for (int k = 0; k < 120 * 20; ++k) {
            const int position = (k + 75) % 120;
            const auto tick = std::uint32_t(std::llround(times[std::size_t(k)] * 1e7));
            if (position % 60 < 58) ecu.send(SD_EVENT_CRANK_EDGE, tick);
            if (position == 25) ecu.send(SD_EVENT_CAM_EDGE, tick + 10);
        }
        EXPECT_EQ(health, sd_publish_judged(&ecu.ecu->say, SD_OWNER_CYLINDER).health);
        EXPECT_EQ(why, sd_publish_judged(&ecu.ecu->say, SD_OWNER_CYLINDER).why);
    }
}

TEST(Ecu, StallMakesEverythingInvalidAndARestartWorks) {
    TorqueSignal signal;
    Ecu ecu(page());
    const auto times = signal.tooth_times(60, 120 * 4);
    const auto turn = [&](std::uint32_t start) {
        for (int k = 0; k < 120 * 4; ++k) {
            if (k % 60 < 58) ecu.send(SD_EVENT_CRANK_EDGE, start + std::uint32_t(std::llround(times[std::size_t(k)] * 1e7)));
        }
    };
    turn(0);
    EXPECT_EQ(SD_VALID, sd_publish_judged(&ecu.ecu->say, SD_OWNER_CRANK).health);
    const auto last = std::uint32_t(std::llround(times.back() * 1e7));
    const auto answers = ecu.send(SD_EVENT_TIME, last + 20000000u);
    ASSERT_FALSE(answers.empty());
    EXPECT_EQ(SD_EVENT_DONE, answers.back().kind);
    for (const sd_event_t &event : answers) {
        if (event.kind != SD_EVENT_SIGNAL || sd_signal_infos[event.channel].owner == SD_OWNER_INPUTS) continue;
        EXPECT_EQ(SD_INVALID, event.flags & 0xff) << event.channel;
        if (event.channel == SD_SIGNAL_CRANK_SPEED) { EXPECT_EQ(0.0f, value_of(event)); }
    }
    turn(last + 30000000u);
    EXPECT_EQ(SD_VALID, sd_publish_judged(&ecu.ecu->say, SD_OWNER_CRANK).health);
}

/// What the clock event at `tick` brings of inputs: 0 of those that are stale, 1 of those never read.
std::array<std::uint32_t, 2> unread(Ecu &ecu, std::uint32_t tick) {
    std::array<std::uint32_t, 2> masks{};
    std::size_t said = 0;
    for (const sd_event_t &event : ecu.send(SD_EVENT_TIME, tick)) {
        if (event.kind != SD_EVENT_SIGNAL) continue;
        EXPECT_EQ(SD_RATE_TASK, sd_signal_infos[event.channel].rate);
        EXPECT_EQ(0u, event.flags) << "valid";
        const bool stale = event.channel < SD_SIGNAL_INPUTS_MISSING;
        const std::uint32_t element = event.channel - (stale ? SD_SIGNAL_INPUTS_STALE : SD_SIGNAL_INPUTS_MISSING);
        masks[stale ? 0 : 1] |= std::uint32_t(value_of(event)) << 16 * element;
        ++said;
    }
    EXPECT_EQ(sd_rate_infos[SD_RATE_TASK].count, said);
    return masks;
}

TEST(Ecu, EveryClockEventTellsWhichInputsAreStaleOrWereNeverRead) {
    using Masks = std::array<std::uint32_t, 2>;
    const std::uint32_t all = (1u << SD_INPUT_COUNT) - 1;
    for (std::uint16_t input = 0; input < SD_INPUT_COUNT; ++input) {
        SCOPED_TRACE(sd_input_infos[input].name);
        const std::uint32_t bit = 1u << input, read = 0xffffff00u; // the timer wraps soon after
        const auto limit = std::uint32_t(sd_input_infos[input].age_s * 1e7f);
        ASSERT_GT(limit, 0u);
        Ecu ecu(page());
        EXPECT_EQ(Masks({0, all}), unread(ecu, read));
        ecu.send(SD_EVENT_SAMPLE, read, input, sd_input_infos[input].usual);
        EXPECT_EQ(Masks({0, all & ~bit}), unread(ecu, read)) << "usual values are within their ranges";
        EXPECT_EQ(Masks({0, all & ~bit}), unread(ecu, read + limit));
        EXPECT_EQ(Masks({bit, all & ~bit}), unread(ecu, read + limit + 100000)) << "10 ms later";
        EXPECT_EQ(Masks({bit, all & ~bit}), unread(ecu, read + 100)) << "the timer has come round";
        ecu.send(SD_EVENT_SAMPLE, read + 200, input, sd_input_infos[input].usual);
        EXPECT_EQ(Masks({0, all & ~bit}), unread(ecu, read + 300)) << "and is back";
    }
}

TEST(Ecu, AnEdgeOfAnotherWheelIsKnownAndMovesNothing) {
    Ecu ecu(page());
    ecu.send(SD_EVENT_CRANK_EDGE, 100);
    const sd_ecu_t before = *ecu.ecu;
    for (std::uint16_t wheel = 0; wheel <= SD_WHEEL_GEARBOX_OUTPUT; ++wheel) EXPECT_TRUE(ecu.send(SD_EVENT_WHEEL_EDGE, 110, wheel).empty());
    EXPECT_EQ(0, std::memcmp(&before, ecu.ecu.get(), sizeof before));
    ecu.send(7, 120);
    EXPECT_EQ(1u, ecu.ecu->unknown_events);
}

TEST(Table, ListsTheChannelsOfEachRateAndWhatOwnersNeed) {
    std::uint32_t listed = 0;
    for (std::uint32_t rate = 0; rate < SD_RATE_COUNT; ++rate) {
        const sd_rate_info_t &info = sd_rate_infos[rate];
        for (std::uint32_t i = 0; i < info.count; ++i, ++listed) {
            EXPECT_EQ(rate, sd_signal_infos[info.channels[i]].rate) << info.channels[i];
            if (i > 0) { EXPECT_LT(info.channels[i - 1], info.channels[i]); }
        }
    }
    EXPECT_EQ(SD_SIGNAL_COUNT, listed);
    EXPECT_EQ(0.01f, sd_rate_infos[SD_RATE_TASK].period_s);
    EXPECT_EQ(1u << SD_INPUT_AIR_INTAKE_PRESSURE, sd_owner_infos[SD_OWNER_CYLINDER].degraded_without);
    EXPECT_EQ(1u << SD_INPUT_AIR_INTAKE_PRESSURE | 1u << SD_INPUT_FUEL_INJECTED | 1u << SD_INPUT_EXHAUST_LAMBDA,
              sd_owner_infos[SD_OWNER_AFR].invalid_without);
}

TEST(Ecu, NothingIsValidBeforeTheFirstTooth) {
    Ecu ecu(page());
    for (unsigned owner = 0; owner < SD_OWNER_COUNT; ++owner) EXPECT_EQ(SD_INVALID,
                                                                        sd_publish_judged(&ecu.ecu->say, sd_owner_t(owner)).health);
}

TEST(Ecu, AfterAGapTheAngleIsSoughtAfresh) {
    TorqueSignal signal;
    Ecu ecu(page());
    const auto times = signal.tooth_times(60, 120 * 8);
    const auto turn = [&](int from, int to) {
        for (int k = from; k < to; ++k) {
            if (k % 60 < 58) ecu.send(SD_EVENT_CRANK_EDGE, std::uint32_t(std::llround(times[std::size_t(k)] * 1e7)));
        }
    };
    turn(0, 300);
    EXPECT_EQ(SD_VALID, sd_publish_judged(&ecu.ecu->say, SD_OWNER_CRANK).health);
    for (const sd_event_t &event : ecu.send(SD_EVENT_GAP, 0)) EXPECT_EQ(SD_INVALID, event.flags & 0xff) << event.channel;
    turn(310, 312);
    EXPECT_EQ(SD_INVALID, sd_publish_judged(&ecu.ecu->say, SD_OWNER_CRANK).health);
    turn(312, 600);
    EXPECT_EQ(SD_VALID, sd_publish_judged(&ecu.ecu->say, SD_OWNER_CRANK).health);
    EXPECT_EQ(57.0f, ecu.ecu->say.signals.crank_tooth) << "the right tooth, not the one ten before";
    EXPECT_EQ(1u, ecu.ecu->crank.counts.sync_losses);
}

TEST(Ecu, IgnoresAndCountsWhatItDoesNotKnow) {
    Ecu ecu(page());
    EXPECT_TRUE(ecu.send(999, 5).empty());
    EXPECT_EQ(1u, ecu.ecu->unknown_events);
}

TEST(Ecu, KeepsTheLatestSampleThatIsInRange) {
    Ecu ecu(page());
    const auto &pressure = ecu.ecu->inputs.reading[SD_INPUT_AIR_INTAKE_PRESSURE];
    EXPECT_EQ(0u, ecu.ecu->inputs.seen);
    EXPECT_TRUE(ecu.send(SD_EVENT_SAMPLE, 7, SD_INPUT_AIR_INTAKE_PRESSURE, 1.25f).empty());
    ecu.send(SD_EVENT_SAMPLE, 8, SD_INPUT_AIR_INTAKE_PRESSURE, NAN);
    ecu.send(SD_EVENT_SAMPLE, 9, SD_INPUT_AIR_INTAKE_PRESSURE, 60);
    ecu.send(SD_EVENT_SAMPLE, 10, SD_INPUT_COUNT, 1);
    EXPECT_EQ(3u, ecu.ecu->inputs.rejected);
    EXPECT_EQ(1.25f, pressure.value);
    EXPECT_EQ(7u, pressure.tick);
    EXPECT_EQ(1u << SD_INPUT_AIR_INTAKE_PRESSURE, ecu.ecu->inputs.seen);
}

TEST(InprocPort, DropsAndCountsWhatDoesNotFit) {
    auto wire = std::make_unique<sd_inproc_t>();
    const sd_port_t host = sd_inproc_host_side(wire.get()), ecu = sd_inproc_ecu_side(wire.get());
    std::vector<sd_event_t> events(SD_INPROC_EVENTS + 3);
    for (std::size_t i = 0; i < events.size(); ++i) events[i].tick = std::uint32_t(i);
    EXPECT_EQ(SD_INPROC_EVENTS, host.send(host.context, events.data(), std::uint32_t(events.size())));
    EXPECT_EQ(3u, wire->dropped);
    sd_event_t back[10];
    EXPECT_EQ(10u, ecu.receive(ecu.context, back, 10));
    EXPECT_EQ(9u, back[9].tick);
    EXPECT_EQ(0u, host.receive(host.context, back, 10));
}

} // namespace
