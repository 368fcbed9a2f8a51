// SPDX-License-Identifier: MIT
// The application core behind the in-process port, and the calibration page it starts from.
#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <tuple>

#include "design/calibration.hpp"
#include "common/error.hpp"
#include "support/torque_signal.hpp"
extern "C" {
#include "sd_ecu.h"
#include "sd_inproc.h"
}

using namespace sixdeg;
using namespace sixdeg::test;

namespace {

EngineFile diesel() {
    TomlFile file(std::filesystem::path(SD_ENGINES) / "diesel_22.toml");
    EngineFile engine = read_engine(file);
    engine.tick_hz = 1e7;
    return engine;
}

/// Made once for each tune: it takes a quarter of a second.
const sd_calibration_t &page(const std::string &tune_text = "") {
    static std::map<std::string, sd_calibration_t> made;
    if (made.count(tune_text) == 0) {
        TomlFile tune("tune", tune_text);
        made[tune_text] = calibrate(diesel(), read_tune(tune), "tune");
    }
    return made[tune_text];
}

struct Ecu {
    StoredPage page;
    std::unique_ptr<sd_ecu_t> ecu = std::make_unique<sd_ecu_t>();
    std::unique_ptr<sd_inproc_t> wire = std::make_unique<sd_inproc_t>();
    sd_port_t ecu_side = sd_inproc_ecu_side(wire.get()), host_side = sd_inproc_host_side(wire.get());
    std::vector<sd_event_t> answers;

    explicit Ecu(const sd_calibration_t &calibration) : page(calibration) { EXPECT_EQ(SD_OK, sd_ecu_init(ecu.get(), page.view())); }

    const std::vector<sd_event_t> &send(std::uint16_t kind, std::uint32_t tick, std::uint16_t channel = 0, float value = 0) {
        sd_event_t event{tick, kind, channel, 0, 0};
        std::memcpy(&event.value, &value, sizeof value);
        return send(event);
    }

    const std::vector<sd_event_t> &send(const sd_event_t &event) {
        EXPECT_EQ(1u, host_side.send(host_side.context, &event, 1));
        sd_ecu_run(ecu.get(), page.view(), &ecu_side);
        answers.clear();
        sd_event_t answer;
        while (host_side.receive(host_side.context, &answer, 1) == 1) answers.push_back(answer);
        return answers;
    }
};

float value_of(const sd_event_t &event) {
    float value;
    std::memcpy(&value, &event.value, sizeof value);
    return value;
}

TEST(CalibrationPage, ComesBackAsItWasAndIsRefusedWhenTouched) {
    const sd_calibration_t original = page("[torque]\nharmonics = 7\ngain_energy = 4.0\n");
    auto bytes = page_bytes(original);
    const auto back = read_page({reinterpret_cast<const char *>(bytes.data()), bytes.size()});
    ASSERT_TRUE(back);
    EXPECT_EQ(bytes, page_bytes(*back));
    EXPECT_EQ(7.0f, back->parameters.torque_harmonics);
    std::vector<std::uint32_t> words((bytes.size() + 3) / 4 + 1);
    auto *lying = reinterpret_cast<std::uint8_t *>(words.data());
    std::memcpy(lying, bytes.data(), bytes.size());
    const auto size = std::uint32_t(bytes.size());
    ASSERT_EQ(lying, reinterpret_cast<const std::uint8_t *>(sd_calibration_view(lying, size))) << "read where it lies";
    for (std::size_t i = 0; i < bytes.size(); i += 97) {
        lying[i] ^= 0x10;
        ASSERT_EQ(nullptr, sd_calibration_view(lying, size)) << i;
        lying[i] ^= 0x10;
    }
    for (std::uint32_t less = 0; less < size; less += 13) ASSERT_EQ(nullptr, sd_calibration_view(lying, less));
    std::memmove(lying + 1, lying, bytes.size());
    EXPECT_EQ(nullptr, sd_calibration_view(lying + 1, size)) << "not aligned";
}

TEST(CalibrationPage, OfTheOtherByteOrderIsRefused) {
    const auto bytes = page_bytes(page());
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), 4 * words.size());
    for (std::uint32_t &word : words) word = __builtin_bswap32(word);
    EXPECT_EQ(nullptr, sd_calibration_view(words.data(), std::uint32_t(bytes.size())));
}

TEST(CalibrationPage, IsReadInPlaceWithoutItsUnusedTail) {
    // StoredPage holds no byte beyond the used pool, and the sanitizers watch: the ecu runs from it.
    EXPECT_LT(sd_calibration_bytes(&page()), sizeof(sd_calibration_t));
    Ecu ecu(page());
    EXPECT_EQ(page_bytes(page()).size(), ecu.page.view()->head.bytes);
}

TEST(CalibrationPage, BytesHaveAFixedOrder) {
    const auto bytes = page_bytes(page());
    ASSERT_GT(bytes.size(), 16u);
    EXPECT_EQ('S', bytes[0]);
    EXPECT_EQ(bytes.size(), std::size_t(bytes[4] | bytes[5] << 8));
    float tick_hz;
    std::memcpy(&tick_hz, &bytes[20], 4);
    EXPECT_EQ(1e7f, tick_hz);
    EXPECT_EQ(60, bytes[31]) << "positions";
}

double inertia_kgm2(const sd_calibration_t &c, int k) {
    return double(c.fourier.inertia_base_kgm2) * double(c.fourier.inertia_q31[k]) / 2147483648.0;
}

TEST(Calibration, AnglesLandOnTheRightPositions) {
    // diesel_22.toml: position 0 at 270 deg; firing TDC 0, 180, 360, 540; missing at 258 and 264 deg (document 004).
    const sd_calibration_t c = page();
    const int expected[] = {75, 105, 15, 45};
    for (int i = 0; i < 4; ++i) EXPECT_EQ(expected[i], c.firing_position[i]) << i;
    EXPECT_EQ(25, c.cam_position); // 420 deg
    // J half a pitch before position 15, a TDC: 3 deg before it the arm is almost nothing.
    EXPECT_NEAR(0.25, inertia_kgm2(c, 15), 1e-4);
    const TorqueSignal independent;
    for (int k = 0; k < 60; ++k) {
        EXPECT_NEAR(independent.inertia((270 + 6 * (k - 0.5)) * M_PI / 180), inertia_kgm2(c, k), 1e-7);
    }
}

TEST(Calibration, RefusesGainsThatDoNotConvergeEvenBelowTheRule) {
    TomlFile tune("t.toml", "[torque]\nharmonics = 12\ngain_energy = 1.0\ngain_reference = 2.0\n");
    const sd_parameters_t parameters = read_tune(tune);
    try {
        calibrate(diesel(), parameters, "t.toml");
        FAIL() << "accepted";
    } catch (const InputError &error) {
        EXPECT_NE(std::string(error.what()).find("t.toml: torque.gain_energy"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("allowed below 1"), std::string::npos) << error.what();
    }
}

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
                    if (cycles > 5) { EXPECT_NEAR(120 / (times[std::size_t(k)] - times[std::size_t(k - 120)]), double(value_of(event)), 0.1); }
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

sd_event_t parameter(const char *name, sd_parameter_command_t command, float value = 0) {
    std::uint16_t index = 0;
    while (index < SD_PARAMETER_COUNT && std::string(sd_parameter_infos[index].name) != name) ++index;
    sd_event_t event{0, SD_EVENT_PARAMETER, index, 0, command};
    std::memcpy(&event.value, &value, sizeof value);
    return event;
}

std::pair<std::uint32_t, float> ask(Ecu &ecu, const sd_event_t &request) {
    const auto answers = ecu.send(request);
    EXPECT_EQ(1u, answers.size());
    EXPECT_EQ(request.flags, answers.front().flags & 0xff);
    return {answers.front().flags >> 8, value_of(answers.front())};
}

TEST(Ecu, ParametersAreSetWithinTheirRangeAndRestored) {
    Ecu ecu(page());
    const auto ask = [&](const sd_event_t &request) { return ::ask(ecu, request); };
    using Answer = std::pair<std::uint32_t, float>;
    const char *const name = "torque.harmonics";
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 5), ask(parameter(name, SD_PARAMETER_READ)));
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 8), ask(parameter(name, SD_PARAMETER_SET, 8)));
    EXPECT_EQ(8, ecu.ecu->torque.observer.f32.harmonics) << "the block has it";
    EXPECT_EQ(Answer(SD_PARAMETER_RANGE, 8), ask(parameter(name, SD_PARAMETER_SET, 13)));
    EXPECT_EQ(Answer(SD_PARAMETER_RANGE, 8), ask(parameter(name, SD_PARAMETER_SET, NAN)));
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 5), ask(parameter(name, SD_PARAMETER_READ_REFERENCE)));
    EXPECT_EQ(Answer(SD_PARAMETER_REFUSED, 1), ask(parameter("torque.gain_energy", SD_PARAMETER_SET, 37)))
        << "in range, and beyond what converges";
    EXPECT_EQ(8, ecu.ecu->torque.observer.f32.harmonics) << "a refused value leaves the block as it was";
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 5), ask(parameter(name, SD_PARAMETER_RESTORE)));
    EXPECT_EQ(Answer(SD_PARAMETER_UNKNOWN, 0), ask(parameter("none", SD_PARAMETER_SET, 1)));
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 1), ask(parameter("torque.fixed_point", SD_PARAMETER_SET, 1)));
    EXPECT_EQ(5, ecu.ecu->torque.observer.q31.harmonics);
}

/// Some other value of a parameter that its block can run with.
float other_value(const sd_signal_info_t &info, float now) {
    if (info.low == 0 && info.high == 1 && (now == 0 || now == 1)) return 1 - now; // a switch
    const bool whole = now == std::floor(now);
    return !whole ? now * 1.0625f : now + 1 <= info.high ? now + 1 : now - 1;
}

auto fields(const sd_misfire_config_t &c) {
    return std::tuple(c.work_per_fuel_jpmg, c.cyclic, c.z_false, c.z_missed, c.definition, c.partial, c.fuel_min_mg, c.torque_min_nm,
                      c.speed_change, c.start_firings, c.hold_firings, c.continuous_firings, c.emission_percent, c.catalyst_percent,
                      c.emission_exceedances, c.catalyst_exceedances);
}
auto fields(const sd_balance_config_t &c) { return std::tuple(c.gain, c.proportional, c.rate, c.limit, c.sd_max, c.hold_cycles); }
auto fields(const sd_afr_config_t &c) {
    return std::tuple(c.method, c.noise_per_rthz, c.drift, c.drift_slow, c.slow_above, c.gain_air, c.gain_cylinder, c.inversion_gain,
                      c.inversion_floor, c.gain_mass, c.turbine_drop, c.turbine_rpm);
}

void expect_same_choices(const sd_ecu_t &a, const sd_ecu_t &b) {
    EXPECT_EQ(a.crank.config.stall_ticks, b.crank.config.stall_ticks);
    if (a.working.torque_fixed_point > 0.5f)
        EXPECT_EQ(0, std::memcmp(&a.torque.observer.q31, &b.torque.observer.q31, sizeof a.torque.observer.q31));
    else
        EXPECT_EQ(0, std::memcmp(&a.torque.observer.f32, &b.torque.observer.f32, sizeof a.torque.observer.f32));
    EXPECT_EQ(fields(a.misfire.monitor.config), fields(b.misfire.monitor.config));
    EXPECT_EQ(fields(a.trims.balance.config), fields(b.trims.balance.config));
    EXPECT_EQ(fields(a.mixture.afr.config), fields(b.mixture.afr.config));
}

TEST(Ecu, ParametersSetAtRunTimeGiveThePageOfThoseSetAtTheStart) {
    // So none can go into tables and be changed beside them unseen.
    const sd_calibration_t start = page();
    int taken = 0;
    std::vector<std::string> refused;
    for (std::uint32_t owner = 0; owner < SD_OWNER_COUNT; ++owner) {
        SCOPED_TRACE(owner);
        Ecu ecu(start);
        TomlFile tune("tune", "");
        sd_parameters_t parameters = read_tune(tune);
        for (std::size_t i = 0; i < SD_PARAMETER_COUNT; ++i) {
            const sd_signal_info_t &info = sd_parameter_infos[i];
            const float now = reinterpret_cast<const float *>(&start.parameters)[i], value = other_value(info, now);
            if (info.owner != owner) continue;
            const auto expected = info.at_start != 0 ? std::pair(std::uint32_t(SD_PARAMETER_AT_START), now)
                                                     : std::pair(std::uint32_t(SD_PARAMETER_OK), value);
            EXPECT_EQ(expected, ask(ecu, parameter(info.name, SD_PARAMETER_SET, value))) << info.name;
            reinterpret_cast<float *>(&parameters)[i] = info.at_start != 0 ? now : value;
            if (info.at_start != 0) refused.push_back(info.name);
            else ++taken;
        }
        sd_calibration_t fresh = calibrate(diesel(), parameters, "tune");
        if (owner == SD_OWNER_TORQUE) fresh.cylinder_map = start.cylinder_map; // void, as sd_cylinders_fit says at each cycle
        if (owner == SD_OWNER_FIRING) {                                        // switched off, not thrown away
            EXPECT_EQ(0, fresh.kalman.positions);
            parameters.firing_enabled = 1;
            fresh.kalman = calibrate(diesel(), parameters, "tune").kalman;
        }
        sd_calibration_t ruling = start;
        ruling.parameters = ecu.ecu->working;
        EXPECT_EQ(page_bytes(fresh), page_bytes(ruling));
        EXPECT_EQ(0, std::memcmp(&ecu.ecu->reference, &start.parameters, sizeof start.parameters)) << "never touched";
        expect_same_choices(*Ecu(fresh).ecu, *ecu.ecu);
    }
    EXPECT_EQ(SD_PARAMETER_COUNT, unsigned(taken) + refused.size());
    const std::vector<std::string> tables{"firing.harmonics", "firing.edge_sd", "firing.load_walk", "firing.rough_walk", "firing.change", "firing.shape_walk"};
    EXPECT_EQ(tables, refused);
}

TEST(Ecu, TheWholePageIsRestoredAtOnceInWhateverOrderItsValuesDepend) {
    const sd_calibration_t start = page();
    Ecu ecu(start);
    using Answer = std::pair<std::uint32_t, float>;
    EXPECT_EQ(Answer(SD_PARAMETER_REFUSED, 0.8f), ask(ecu, parameter("misfire.partial", SD_PARAMETER_SET, 0.3f))) << "below definition";
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 0.25f), ask(ecu, parameter("misfire.definition", SD_PARAMETER_SET, 0.25f)));
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 0.3f), ask(ecu, parameter("misfire.partial", SD_PARAMETER_SET, 0.3f)));
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 2), ask(ecu, parameter("torque.harmonics", SD_PARAMETER_SET, 2)));
    EXPECT_EQ(SD_PARAMETER_REFUSED, ask(ecu, parameter("misfire.definition", SD_PARAMETER_RESTORE)).first) << "alone it cannot go back";
    const sd_event_t all{0, SD_EVENT_PARAMETER, SD_PARAMETER_ALL, 0, SD_PARAMETER_RESTORE};
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 0), ask(ecu, all));
    EXPECT_EQ(0, std::memcmp(&start.parameters, &ecu.ecu->working, sizeof start.parameters));
    EXPECT_EQ(0.5f, ecu.ecu->misfire.monitor.config.definition);
    EXPECT_EQ(5, ecu.ecu->torque.observer.f32.harmonics);
    const sd_event_t none{0, SD_EVENT_PARAMETER, SD_PARAMETER_ALL, 0, SD_PARAMETER_SET};
    EXPECT_EQ(Answer(SD_PARAMETER_UNKNOWN, 0), ask(ecu, none));
}

TEST(Ecu, NothingIsValidBeforeTheFirstTooth) {
    Ecu ecu(page());
    for (unsigned owner = 0; owner < SD_OWNER_COUNT; ++owner) EXPECT_EQ(SD_INVALID, sd_publish_judged(&ecu.ecu->say, sd_owner_t(owner)).health);
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
