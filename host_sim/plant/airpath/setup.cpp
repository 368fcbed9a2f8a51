// SPDX-License-Identifier: MIT
#include "plant/airpath/setup.hpp"

#include "common/air_path.hpp"
#include "common/streams.hpp"

namespace sixdeg::airpath {
namespace {

Profile read_command(TomlFile &file, const std::string &name) {
    return read_curve(file, "airpath." + name, {0, 1, ""}, "airpath." + name + "_time_s", {0, 1e6, "s"});
}

Errors read_errors(TomlFile &file, std::uint64_t seed) {
    const double drawn = 0.01 * file.number_or("airpath.error.drawn_percent", {0, 20, "%"}, 0);
    Errors e = draw_errors(drawn, RandomStream(seed, stream::kAirPathErrors));
    const auto read = [&](const char *name, double &value) {
        value *= 1 + 0.01 * file.number_or(std::string("airpath.error.") + name + "_percent", {-50, 50, "%"}, 0);
    };
    read("filling", e.filling), read("egr_area", e.egr_area), read("turbine_area", e.turbine_area);
    read("intake_volume", e.intake_volume), read("exhaust_volume", e.exhaust_volume);
    read("air_flow", e.air_flow), read("intake_pressure", e.intake_pressure), read("exhaust_pressure", e.exhaust_pressure);
    return e;
}

} // namespace

FullData Errors::applied(FullData data) const {
    data.filling *= filling;
    data.egr_area_m2 *= egr_area;
    data.turbine_closed_m2 *= turbine_area, data.turbine_span_m2 *= turbine_area;
    data.intake_m3 *= intake_volume, data.cooler_m3 *= intake_volume;
    data.exhaust_m3 *= exhaust_volume;
    return data;
}

Errors draw_errors(double share, RandomStream random) {
    Errors e;
    for (double *value : {&e.filling, &e.egr_area, &e.turbine_area, &e.intake_volume, &e.exhaust_volume, &e.air_flow, &e.intake_pressure,
                          &e.exhaust_pressure})
        *value = 1 + share * (2 * random.uniform() - 1);
    return e;
}

std::optional<Setup> read_setup(TomlFile &file, std::uint64_t seed) {
    if (!file.has("airpath")) return std::nullopt;
    Setup s;
    s.egr = read_command(file, "egr");
    s.vgt = read_command(file, "vgt");
    s.noise = file.number_or("airpath.noise", {0, 100, ""}, 1);
    s.pressure_lag_s = 1e-3 * file.number_or("airpath.pressure_lag_ms", {0.1, 1000, "ms"}, 5);
    s.flow_lag_s = 1e-3 * file.number_or("airpath.flow_lag_ms", {0.1, 1000, "ms"}, 20);
    s.temperature_lag_s = 1e-3 * file.number_or("airpath.temperature_lag_ms", {0.1, 1e5, "ms"}, 1000);
    s.errors = read_errors(file, seed);
    s.faults = read_faults(file);
    return s;
}

} // namespace sixdeg::airpath
