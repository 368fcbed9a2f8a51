// SPDX-License-Identifier: MIT
#include "studies/trips/misfire_trips.hpp"

#include "common/progress.hpp"
#include "common/random.hpp"

namespace sixdeg {
namespace {

constexpr float kFuelMg = 10, kSpeedRadps = 200;

void drive(const sd_misfire_config_t &config, const TripPlan &plan, RandomStream &random, TripFigures &sum) {
    sd_misfire_t monitor;
    sd_misfire_init(&monitor, &config);
    sd_misfire_firing_t firing{};
    firing.fuel_mg = kFuelMg, firing.speed_radps = kSpeedRadps;
    const double expected_nm = double(kFuelMg) * double(config.work_per_fuel_jpmg) / M_PI;
    firing.torque_sd_nm = float(plan.stated_sd * expected_nm);
    for (std::uint64_t i = 0; i < plan.revolutions * config.cylinders / 2; ++i) {
        firing.index = std::uint8_t(i % config.cylinders);
        firing.torque_nm = float((1 + plan.healthy_sd * random.normal()) * expected_nm);
        sd_misfire_judge(&monitor, &firing);
    }
    sd_misfire_report_t report;
    sd_misfire_read(&monitor, &report);
    sum.firings += report.firings, sum.false_alarms += report.misfires;
    sum.windows_200 += report.catalyst_exceeded, sum.windows_1000 += report.emission_exceeded;
    sum.pending += report.lamp == SD_LAMP_PENDING, sum.lamp += report.lamp > SD_LAMP_PENDING;
}

} // namespace

TripFigures run_trips(const sd_misfire_config_t &config, const TripPlan &plan) {
    RandomStream random(plan.seed, 1);
    TripFigures sum;
    Progress progress("trip", double(plan.trips));
    for (std::uint64_t trip = 0; trip < plan.trips; ++trip, progress.next()) drive(config, plan, random, sum);
    return sum;
}

} // namespace sixdeg
