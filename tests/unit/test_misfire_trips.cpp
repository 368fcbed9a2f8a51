// SPDX-License-Identifier: MIT
// Many trips of a healthy engine, against what independent firings must give.
#include <gtest/gtest.h>

#include <cmath>

#include "score/misfire_score.hpp"
#include "studies/trips/misfire_trips.hpp"

using namespace sixdeg;

namespace {

sd_misfire_config_t config() {
    sd_misfire_config_t c{};
    c.cylinders = 4;
    for (int i = 0; i < 4; ++i) c.firing_order[i] = std::uint8_t(i + 1);
    c.work_per_fuel_jpmg = 18, c.cyclic = 0.2f, c.z_false = 3.54f, c.z_missed = 2.58f, c.definition = 0.5f, c.partial = 0.8f;
    c.fuel_min_mg = 1, c.torque_min_nm = 2, c.speed_change = 0.15f, c.start_firings = 16, c.hold_firings = 8, c.continuous_firings = 8;
    c.emission_percent = 2, c.catalyst_percent = 5, c.emission_exceedances = 4, c.catalyst_exceedances = 3;
    return c;
}

TEST(MisfireTrips, AGoodEngineGetsNoLampAndFalseAlarmsAreThoseOfANormalTail) {
    const TripFigures f = run_trips(config(), {0.125, 0.12, 100, 10000, 1});
    EXPECT_EQ(f.firings, 100u * (20000 - 16));
    EXPECT_EQ(f.pending + f.lamp + f.windows_200 + f.windows_1000, 0u);
    // The limit is the definition, 4 deviations off: 3.2e-5.
    const RateBounds rate = rate_bounds(f.false_alarms, f.firings);
    EXPECT_LT(rate.low, 6e-5);
    EXPECT_GT(rate.high, 2e-5);
}

TEST(MisfireTrips, ALimitThatCannotBeHeldShows) {
    sd_misfire_config_t c = config();
    c.emission_percent = 0.01f; // more than 0.2 of 2000
    const TripFigures f = run_trips(c, {0.125, 0.12, 100, 10000, 1});
    EXPECT_GT(f.lamp, 0u);
    EXPECT_GE(f.windows_1000, f.lamp);
    EXPECT_LE(f.windows_1000, f.false_alarms);
}

} // namespace
