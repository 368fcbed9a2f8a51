// SPDX-License-Identifier: MIT
#include "plant/airpath/full_data.hpp"

#include <cmath>
#include <string>

namespace sixdeg::airpath {
namespace {

constexpr double kRadpsPerRpm = M_PI / 30;

void read_coolers(TomlFile &file, const std::string &at, FullData &d) {
    d.cooler_m3 = 1e-3 * file.number_or(at + "cooler_l", {0.5, 100, "L"}, 7);
    d.cooler_k = file.number_or(at + "cooler_temperature_k", {250, 400, "K"}, 303);
    d.cooler_effectiveness = file.number_or(at + "cooler_effectiveness", {0, 1, ""}, 0.9);
    d.cooler_drop_pa = 1e5 * file.number_or(at + "cooler_drop_bar", {1e-3, 1, "bar"}, 0.02);
    d.egr_area_m2 = 1e-6 * file.number_or(at + "egr_area_mm2", {0, 1e4, "mm2"}, 560);
    d.egr_pulsation = file.number_or(at + "egr_pulsation", {0.01, 0.5, ""}, 0.15);
    d.egr_cooler_k = file.number_or(at + "egr_cooler_temperature_k", {250, 450, "K"}, 355);
    d.egr_cooler_effectiveness = file.number_or(at + "egr_cooler_effectiveness", {0, 1, ""}, 0.95);
    d.egr_cooler_s = file.number_or(at + "egr_cooler_lag_s", {0.01, 30, "s"}, 1.5);
}

void read_turbo(TomlFile &file, const std::string &at, FullData &d) {
    d.compressor_m = 1e-3 * file.number_or(at + "compressor_mm", {20, 300, "mm"}, 78);
    d.compressor_flow = file.number_or(at + "compressor_flow", {0.01, 1, ""}, 0.135);
    d.compressor_head = file.number_or(at + "compressor_head", {0.5, 2, ""}, 1.35);
    d.compressor_efficiency = file.number_or(at + "compressor_efficiency", {0.2, 0.9, ""}, 0.7);
    d.turbine_efficiency = file.number_or(at + "turbine_efficiency", {0.2, 0.9, ""}, 0.58);
    d.turbine_closed_m2 = 1e-6 * file.number_or(at + "turbine_closed_mm2", {10, 1e4, "mm2"}, 160);
    d.turbine_span_m2 = 1e-6 * file.number_or(at + "turbine_span_mm2", {10, 1e4, "mm2"}, 900);
    d.turbine_swallow_drop = file.number_or(at + "turbine_swallow_drop", {0, 0.5, ""}, 0.08);
    d.turbo_rated_radps = kRadpsPerRpm * file.number_or(at + "turbo_rated_rpm", {1e4, 4e5, "rpm"}, 1.1e5);
    d.turbo_inertia_kgm2 = file.number_or(at + "turbo_inertia_kgm2", {1e-6, 1, "kg m2"}, 1e-4);
    d.back_pressure_pa = 1e5 * file.number_or(at + "back_pressure_bar", {0, 1, "bar"}, 0.03);
}

ActuatorData read_actuator(TomlFile &file, const std::string &at, double frequency_hz, double rate) {
    return {2 * M_PI * file.number_or(at + ".frequency_hz", {0.1, 200, "Hz"}, frequency_hz),
            file.number_or(at + ".damping", {0.2, 3, ""}, 0.9), file.number_or(at + ".rate_per_s", {0.1, 1000, "1/s"}, rate)};
}

} // namespace

std::optional<FullData> read_full_data(TomlFile &file) {
    if (!file.has("plant.airpath")) return std::nullopt;
    const std::string at = "plant.airpath.";
    FullData d{};
    d.ambient_pa = 1e5 * file.number_or(at + "ambient_bar", {0.4, 1.2, "bar"}, 1.0111);
    d.ambient_k = file.number_or(at + "ambient_k", {220, 330, "K"}, 298);
    d.intake_m3 = 1e-3 * file.number_or(at + "intake_l", {0.5, 100, "L"}, 11);
    d.exhaust_m3 = 1e-3 * file.number_or(at + "exhaust_l", {0.2, 100, "L"}, 6);
    read_coolers(file, at, d);
    read_turbo(file, at, d);
    d.filling = file.number_or(at + "filling", {0.3, 1.5, ""}, 0.92);
    d.filling_rpm = file.number_or(at + "filling_rpm", {100, 12000, "rpm"}, 1450);
    d.filling_bend = file.number_or(at + "filling_bend", {0, 0.5, ""}, 0.04);
    d.heat_share = file.number_or(at + "heat_share", {0.1, 0.7, ""}, 0.36);
    d.wall_wpk = file.number_or(at + "wall_wpk", {0, 200, "W/K"}, 12);
    d.wall_jpk = file.number_or(at + "wall_jpk", {10, 1e6, "J/K"}, 6000);
    d.wall_loss_wpk = file.number_or(at + "wall_loss_wpk", {0, 200, "W/K"}, 8);
    d.burn_efficiency = file.number_or(at + "burn_efficiency", {0.1, 0.7, ""}, 0.43);
    d.egr = read_actuator(file, "plant.airpath.egr", 8, 12);
    d.vgt = read_actuator(file, "plant.airpath.vgt", 6, 6);
    return d;
}

} // namespace sixdeg::airpath
