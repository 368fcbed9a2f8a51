// SPDX-License-Identifier: MIT
// Parameters of an ecu at run time.
#include <array>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <tuple>

#include "common/error.hpp"
#include "support/ecu_on_wire.hpp"

using namespace sixdeg;
using namespace sixdeg::test;

namespace {

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
    const std::vector<std::string> tables{"firing.harmonics", "firing.edge_sd", "firing.load_walk", "firing.rough_walk",
                                          "firing.torque_change", "firing.shape_walk",
                                          "work.window"};
    EXPECT_EQ(tables, refused);
}

TEST(Ecu, TheWholePageIsRestoredAtOnceInWhateverOrderItsValuesDepend) {
    const sd_calibration_t start = page();
    Ecu ecu(start);
    using Answer = std::pair<std::uint32_t, float>;
    EXPECT_EQ(Answer(SD_PARAMETER_REFUSED, 0.8f), ask(ecu, parameter("misfire.partial_burn_below", SD_PARAMETER_SET, 0.3f)))
        << "below definition";
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 0.25f), ask(ecu, parameter("misfire.misfire_below", SD_PARAMETER_SET, 0.25f)));
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 0.3f), ask(ecu, parameter("misfire.partial_burn_below", SD_PARAMETER_SET, 0.3f)));
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 2), ask(ecu, parameter("torque.harmonics", SD_PARAMETER_SET, 2)));
    EXPECT_EQ(SD_PARAMETER_REFUSED, ask(ecu, parameter("misfire.misfire_below", SD_PARAMETER_RESTORE)).first) << "alone it cannot go back";
    const sd_event_t all{0, SD_EVENT_PARAMETER, SD_PARAMETER_ALL, 0, SD_PARAMETER_RESTORE};
    EXPECT_EQ(Answer(SD_PARAMETER_OK, 0), ask(ecu, all));
    EXPECT_EQ(0, std::memcmp(&start.parameters, &ecu.ecu->working, sizeof start.parameters));
    EXPECT_EQ(0.5f, ecu.ecu->misfire.monitor.config.definition);
    EXPECT_EQ(5, ecu.ecu->torque.observer.f32.harmonics);
    const sd_event_t none{0, SD_EVENT_PARAMETER, SD_PARAMETER_ALL, 0, SD_PARAMETER_SET};
    EXPECT_EQ(Answer(SD_PARAMETER_UNKNOWN, 0), ask(ecu, none));
}

} // namespace
