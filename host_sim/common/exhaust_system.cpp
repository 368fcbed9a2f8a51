// SPDX-License-Identifier: MIT
#include "common/exhaust_system.hpp"

#include <cmath>
#include <fmt/format.h>

namespace sixdeg {
namespace {

constexpr double kRadPerDeg = M_PI / 180, kRadpsPerRpm = M_PI / 30;

Profile read_turbine_area(TomlFile &file) {
    auto area = file.numbers("exhaust.turbine_area_mm2", {10, 1e4, "mm2"});
    if (area.empty()) file.fail("exhaust.turbine_area_mm2", "is empty");
    std::vector<double> speed{0.0};
    if (file.has("exhaust.turbine_rpm") || area.size() > 1)
        speed = file.numbers("exhaust.turbine_rpm", {0, 12000, "rpm"}, area.size());
    for (std::size_t i = 1; i < speed.size(); ++i)
        if (speed[i] <= speed[i - 1]) file.fail("exhaust.turbine_rpm", "is not ascending");
    for (double &a : area) a *= 1e-6;
    for (double &s : speed) s *= kRadpsPerRpm;
    return Profile(speed, area);
}

std::vector<ExhaustReading> read_readings(TomlFile &file) {
    std::vector<ExhaustReading> readings;
    for (std::size_t i = 0; i < file.array_size("exhaust.reading"); ++i) {
        const std::string at = fmt::format("exhaust.reading[{}].", i);
        readings.push_back({kRadpsPerRpm * file.number(at + "rpm", {100, 12000, "rpm"}),
                            1e5 * file.number(at + "intake_bar", {0.2, 10, "bar"}),
                            file.number(at + "lambda", {0.05, 1.5, ""}),
                            1e-6 * file.number(at + "air_mg", {1, 1e5, "mg"}),
                            1e5 * file.number(at + "pressure_bar", {0.5, 10, "bar"}),
                            file.number(at + "temperature_k", {250, 1500, "K"})});
    }
    if (readings.size() > 0 && readings.size() < 4) file.fail("exhaust.reading", "has less than 4 entries");
    return readings;
}

} // namespace

std::optional<ExhaustSystem> read_exhaust_system(TomlFile &file) {
    if (!file.has("exhaust")) return std::nullopt;
    ExhaustSystem e;
    e.valve_close_rad = kRadPerDeg * file.number_or("exhaust.valve_close_deg", {330, 420, "deg"}, 375);
    e.valve_area_m2 = 1e-6 * file.number("exhaust.valve_area_mm2", {20, 1e4, "mm2"});
    e.manifold_m3 = 1e-3 * file.number("exhaust.manifold_l", {0.1, 50, "L"});
    e.turbine_area_m2 = read_turbine_area(file);
    e.pipe_m3 = 1e-3 * file.number_or("exhaust.pipe_l", {0, 20, "L"}, 0.6);
    e.mixing_m3 = 1e-3 * file.number_or("exhaust.mixing_l", {0, 5, "L"}, 0.08);
    e.dead_time_s = 1e-3 * file.number_or("exhaust.dead_time_ms", {0, 100, "ms"}, 5);
    e.readings = read_readings(file);
    const auto tau = file.numbers("uego.tau_ms", {1, 500, "ms"}, 2);
    if (!(tau[0] > tau[1])) file.fail("uego.tau_ms", "is not two lags, the longer one first");
    for (std::size_t i = 0; i < 2; ++i) e.uego_tau_s[i] = 1e-3 * tau[i];
    return e;
}

} // namespace sixdeg
