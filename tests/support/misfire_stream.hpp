// SPDX-License-Identifier: MIT
// A made stream of firings for the event monitor.
#pragma once
#include <cmath>
#include <gtest/gtest.h>
#include <limits>

#include "common/random.hpp"
extern "C" {
#include "sd_misfire.h"
}

namespace sixdeg::test {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr int kCylinders = 4;

inline sd_misfire_config_t config() {
    sd_misfire_config_t c{};
    c.cylinders = kCylinders;
    const std::uint8_t order[] = {1, 3, 4, 2};
    std::copy(order, order + 4, c.firing_order);
    c.work_per_fuel_jpmg = 18;
    c.cyclic = 0.2f;
    c.z_false = 3.54f;
    c.z_missed = 2.58f;
    c.definition = 0.5f;
    c.partial = 0.8f;
    c.fuel_min_mg = 2;
    c.torque_min_nm = 2;
    c.speed_change = 0.05f;
    c.start_firings = 16;
    c.hold_firings = 8;
    c.continuous_firings = 8;
    c.emission_percent = 2;
    c.catalyst_percent = 5;
    c.emission_exceedances = 4;
    c.catalyst_exceedances = 3;
    return c;
}

/// A stream of firings: what burns, of 10 mg, with combustion and estimate each scattering as told.
struct Stream {
    sd_misfire_t monitor;
    RandomStream random;
    double cyclic = 0.05, noise_nm = 1, stated_nm = 1, efficiency = 1;
    float speed = 200;
    float command_mg = 10; ///< What the monitor is told.
    std::uint8_t inhibit = 0;
    double common = 0, rho = 0; ///< Error that neighbours share: deviation over the torque, and how much of it goes on.
    double error = 0;
    long k = 0;
    static constexpr double kTorque = 10 * 18 / M_PI;

    explicit Stream(unsigned seed = 1, const sd_misfire_config_t &c = config()) : random(seed, 0) {
        EXPECT_EQ(SD_OK, sd_misfire_init(&monitor, &c));
    }
    sd_misfire_verdict_t go(double burned = 1) {
        const double mean = kTorque * efficiency * burned;
        if (common > 0) error = rho * error + common * std::sqrt(1 - rho * rho) * random.normal();
        const double torque = mean * (1 + cyclic * random.normal()) + noise_nm * random.normal() + error * kTorque;
        sd_misfire_firing_t f{std::uint8_t(k++ % kCylinders), SD_VALID, 0, inhibit, float(torque), float(stated_nm), command_mg, speed, 0};
        return sd_misfire_judge(&monitor, &f);
    }
    void healthy(int n) { while (n-- > 0) go(); }
    sd_misfire_report_t read() const {
        sd_misfire_report_t r;
        sd_misfire_read(&monitor, &r);
        return r;
    }
};

} // namespace sixdeg::test
