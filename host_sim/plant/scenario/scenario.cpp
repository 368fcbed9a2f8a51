// SPDX-License-Identifier: MIT
#include "plant/scenario/scenario.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr double kLongest = 1e6;

// A field that is one number, or a list beside a list of knots in the same table.
Profile read_profile(TomlFile &file, const std::string &table, const char *knots, const std::string &field,
                     Range range, Range knot_range, double otherwise) {
    const std::string name = table + "." + field, x_name = table + "." + knots;
    if (!file.has(name)) return Profile(otherwise);
    if (file.array_size(name) == 0) return Profile(file.number(name, range));
    const auto x = file.numbers(x_name, knot_range);
    if (x.empty()) file.fail(x_name, "is empty");
    for (std::size_t i = 1; i < x.size(); ++i) {
        if (x[i] <= x[i - 1]) file.fail(x_name, "is not ascending");
    }
    return Profile(x, file.numbers(name, range, x.size()));
}

Profile over(const Profile &profile, double knot_factor) {
    auto x = profile.x();
    for (double &knot : x) knot *= knot_factor;
    return Profile(std::move(x), profile.value());
}

void read_run(TomlFile &file, Scenario &s) {
    s.seed = std::uint64_t(file.integer_or("seed", 0, 1L << 52, 1));
    if (file.has("run.duration_s") == file.has("run.cycles"))
        file.fail("run", "needs exactly one of duration_s and cycles");
    s.duration_s = file.number_or("run.duration_s", {1e-3, kLongest, "s"}, 0);
    s.cycles = file.integer_or("run.cycles", 1, 100'000'000, 0);
    s.start_deg = file.number_or("run.start_deg", {0, 719.999, "deg"}, 0);
    s.step_deg = file.number_or("run.step_deg", {0.05, 1, "deg"}, 0.5);
    const double per_half_turn = 180 / s.step_deg;
    if (std::abs(per_half_turn - std::round(per_half_turn)) > 1e-9) {
        file.fail("run.step_deg",
                  fmt::format("{:g} does not divide 180 deg a whole number of times", s.step_deg));
    }
}

void read_speed(TomlFile &file, Scenario &s) {
    const std::string mode = file.text_or("speed.mode", "dyno");
    if (mode == "dyno")
        s.speed_mode = SpeedMode::dyno;
    else if (mode == "governor")
        s.speed_mode = SpeedMode::governor;
    else if (mode == "free")
        s.speed_mode = SpeedMode::free;
    else if (mode == "prescribed")
        s.speed_mode = SpeedMode::prescribed;
    else
        file.fail("speed.mode", "'" + mode + "' is not \"dyno\", \"governor\", \"free\" or \"prescribed\"");
    if (!file.has("speed.rpm"))
        file.fail("speed.rpm", "is missing; allowed range " + describe(Range{50, 12000, "rpm"}));
    s.speed_radps = read_profile(file, "speed", "time_s", "rpm", {50, 12000, "rpm"}, {0, kLongest, "s"}, 0)
                        .scaled(kRadpsPerRpm);
}

void read_load(TomlFile &file, Scenario &s) {
    s.bmep_pa = read_profile(file, "load", "time_s", "bmep_bar", {0, 40, "bar"}, {0, kLongest, "s"}, 0)
                    .scaled(kPaPerBar);
    s.load_given = file.has("load.torque_nm");
    if (s.load_given) {
        if (s.speed_mode != SpeedMode::free && s.speed_mode != SpeedMode::governor) {
            file.fail("load.torque_nm",
                      "is for speed.mode \"free\" and \"governor\"; the others find the torque themselves");
        }
        s.load_nm =
            read_profile(file, "load", "time_s", "torque_nm", {-1e4, 1e5, "N m"}, {0, kLongest, "s"}, 0);
    }
    if (file.has("load.fuel_cut_s")) s.fuel_cut_s = file.numbers("load.fuel_cut_s", {0, kLongest, "s"});
    if (s.fuel_cut_s.size() % 2 != 0)
        file.fail("load.fuel_cut_s", "is not a list of pairs: from, to, from, to");
    if (!std::is_sorted(s.fuel_cut_s.begin(), s.fuel_cut_s.end()))
        file.fail("load.fuel_cut_s", "is not ascending");
    s.road_rms_nm = file.number_or("load.road_rms_nm", {0, 1000, "N m"}, 0);
    s.road_low_hz = file.number_or("load.road_low_hz", {0.1, 50, "Hz"}, 3);
    s.road_high_hz = file.number_or("load.road_high_hz", {0.1, 50, "Hz"}, 15);
    if (s.road_high_hz <= s.road_low_hz) file.fail("load.road_high_hz", "is not above load.road_low_hz");
}

std::vector<double> read_percent(TomlFile &file, const std::string &field, std::size_t cylinders,
                                 Range range) {
    std::vector<double> factor(cylinders, 1.0);
    if (!file.has(field)) return factor;
    const auto percent = file.numbers(field, range, cylinders);
    for (std::size_t i = 0; i < cylinders; ++i) factor[i] = 1 + percent[i] / 100;
    return factor;
}

void read_cylinders(TomlFile &file, Scenario &s) {
    const auto n = std::size_t(s.engine.shared.cylinders());
    s.fuel_factor = read_percent(file, "cylinders.fuel_percent", n, {-100, 100, "%"});
    s.trapped_factor = read_percent(file, "cylinders.trapped_mass_percent", n, {-50, 50, "%"});
    s.compression_factor = read_percent(file, "cylinders.compression_percent", n, {-20, 20, "%"});

    for (std::size_t i = 0; i < file.array_size("cylinders.fuel_step"); ++i) {
        const std::string at = fmt::format("cylinders.fuel_step[{}].", i);
        s.fuel_steps.push_back({file.number(at + "at_s", {0, kLongest, "s"}), int(file.integer(at + "cylinder", 1, long(n))),
                                1 + file.number(at + "percent", {-100, 100, "%"}) / 100});
    }
    std::stable_sort(s.fuel_steps.begin(), s.fuel_steps.end(),
                     [](const FuelStep &a, const FuelStep &b) { return a.at_s < b.at_s; });

    const Profile cov =
        read_profile(file, "cyclic", "bmep_bar", "cov_percent", {0, 60, "%"}, {0, 40, "bar"}, 0);
    s.cyclic_cov = over(cov.scaled(0.01), kPaPerBar);
    s.cyclic_start_sd_rad = kRadPerDeg * file.number_or("cyclic.start_sd_deg", {0, 10, "deg"}, 0);
    s.cyclic_duration_cov = 0.01 * file.number_or("cyclic.duration_cov_percent", {0, 30, "%"}, 0);
}

/// What really stands in the engine: the shared fields are what was drawn.
void read_elastic(TomlFile &file, Scenario &s) {
    const double factor = 1 + file.number_or("elastic.stiffness_percent", {-50, 50, "%"}, 0) / 100;
    if (s.engine.dual_mass) s.engine.dual_mass->stiffness_nmprad *= factor;
    if (s.engine.torsion) s.engine.torsion->section_stiffness_nmprad *= factor;
}

void read_misfires(TomlFile &file, Scenario &s) {
    const int n = s.engine.shared.cylinders();
    for (std::size_t i = 0; i < file.array_size("misfires.event"); ++i) {
        const std::string at = fmt::format("misfires.event[{}].", i);
        s.misfires.push_back({file.integer(at + "cycle", 0, 100'000'000),
                              int(file.integer(at + "cylinder", 1, n)),
                              file.number_or(at + "burned_fraction", {0, 1, ""}, 0)});
    }
    std::stable_sort(s.misfires.begin(), s.misfires.end(),
                     [](const MisfireEvent &a, const MisfireEvent &b) { return a.cycle < b.cycle; });
    if (file.has("misfires.one_in"))
        s.misfire_rate = 1 / file.number("misfires.one_in", {1, 1e9, "combustions"});
    if (file.has("misfires.continuous")) {
        for (double c : file.numbers("misfires.continuous", {1, double(n), ""})) {
            if (c != std::floor(c))
                file.fail("misfires.continuous", fmt::format("{:g} is not a cylinder", c));
            s.continuous.push_back(int(c));
        }
    }
    s.misfire_burned_fraction = file.number_or("misfires.burned_fraction", {0, 1, ""}, 0);
}

void read_encoder(TomlFile &file, Scenario &s) {
    EncoderFaults &e = s.encoder;
    e.offset_deg = file.number_or("encoder.offset_deg", {-30, 30, "deg"}, 0);
    e.pattern_rms_deg = file.number_or("encoder.pattern_rms_deg", {0, 0.5, "deg"}, 0);
    e.tooth_width = file.number_or("encoder.tooth_width", {0.1, 0.9, "of the pitch"}, 0.5);
    e.jitter_deg = file.number_or("encoder.jitter_deg", {0, 0.5, "deg"}, 0);
    e.delay_s = 1e-6 * file.number_or("encoder.delay_us", {0, 1000, "us"}, 0);
    const Profile lag = read_profile(file, "encoder", "rpm", "lag_deg", {-5, 5, "deg"}, {0, 12000, "rpm"}, 0);
    e.lag_deg = over(lag, kRadpsPerRpm);
    e.drop_rate = file.number_or("encoder.drop_rate", {0, 1, ""}, 0);
    e.drop_burst = file.number_or("encoder.drop_burst", {1, 500, "edges"}, 1);
    e.extra_rate = file.number_or("encoder.extra_rate", {0, 1, ""}, 0);
    e.extra_burst = file.number_or("encoder.extra_burst", {1, 500, "edges"}, 1);
    e.cam_retard_deg =
        read_profile(file, "encoder.cam", "time_s", "retard_deg", {-60, 60, "deg"}, {0, kLongest, "s"}, 0);
    e.cam_jitter_deg = file.number_or("encoder.cam.jitter_deg", {0, 5, "deg"}, 0);
    e.cam_drop_rate = file.number_or("encoder.cam.drop_rate", {0, 1, ""}, 0);
}

void read_vehicle(TomlFile &file, Scenario &s) {
    if (!file.has("vehicle")) return;
    if (!s.engine.shared.driveline) file.fail("vehicle", "needs an engine file with [driveline]");
    if (s.speed_mode == SpeedMode::prescribed) file.fail("vehicle", "is not for speed.mode \"prescribed\", where torques act on nothing");
    const DrivelineFile &d = *s.engine.shared.driveline;
    VehicleSetup v;
    v.car = d.car;
    const double stiffness = 1 + file.number_or("vehicle.stiffness_percent", {-50, 50, "%"}, 0) / 100;
    v.car.soft_nmprad *= stiffness;
    v.car.stiff_nmprad *= stiffness;
    v.car.damping_nms *= 1 + file.number_or("vehicle.damping_percent", {-90, 200, "%"}, 0) / 100;
    v.car.kink_rad *= 1 + file.number_or("vehicle.kink_percent", {-50, 50, "%"}, 0) / 100;
    const long gears = long(d.car.ratios.size());
    v.gear = std::size_t(file.integer_or("vehicle.gear", 1, gears, 1) - 1);
    for (std::size_t i = 0; i < file.array_size("vehicle.shift"); ++i) {
        const std::string at = fmt::format("vehicle.shift[{}].", i);
        v.shifts.push_back({file.number(at + "at_s", {0, kLongest, "s"}), std::size_t(file.integer(at + "gear", 1, gears) - 1)});
    }
    std::stable_sort(v.shifts.begin(), v.shifts.end(), [](const GearShift &a, const GearShift &b) { return a.at_s < b.at_s; });
    if (file.has("vehicle.clutch_open_s")) v.open_s = file.numbers("vehicle.clutch_open_s", {0, kLongest, "s"});
    if (v.open_s.size() % 2 != 0) file.fail("vehicle.clutch_open_s", "is not a list of pairs: from, to, from, to");
    v.slope_nm = read_profile(file, "vehicle", "time_s", "slope_nm", {-1e4, 1e4, "N m"}, {0, kLongest, "s"}, 0);
    v.tell_gear = file.boolean_or("vehicle.tell_gear", true);
    v.wheel_teeth = d.wheel_teeth;
    v.wheel_jitter_rad = kRadPerDeg * file.number_or("vehicle.wheel_jitter_deg", {0, 2, "deg"}, 0);
    s.vehicle = v;
}

void read_balance(TomlFile &file, Scenario &s) {
    if (file.has("control.balance_on_s")) s.balance_on_s = file.numbers("control.balance_on_s", {0, kLongest, "s"});
    if (s.balance_on_s.size() % 2 != 0) file.fail("control.balance_on_s", "is not a list of pairs: from, to, from, to");
    if (!std::is_sorted(s.balance_on_s.begin(), s.balance_on_s.end())) file.fail("control.balance_on_s", "is not ascending");
}

void read_uego(TomlFile &file, Scenario &s) {
    if (!file.has("uego")) return;
    if (!s.engine.shared.exhaust) file.fail("uego", "needs an engine file with [exhaust] and [uego]");
    UegoSetup u;
    u.sample_s = 1e-6 * file.number_or("uego.sample_us", {50, 1e5, "us"}, 500);
    u.noise_per_rthz = file.number_or("uego.noise_per_rthz", {0, 0.1, "1/sqrt(Hz)"}, 0);
    u.correlation_s = 1e-3 * file.number_or("uego.noise_correlation_ms", {0, 1000, "ms"}, 0);
    u.pressure_per_bar = 0.01 * file.number_or("uego.pressure_percent_per_bar", {0, 10, "%/bar"}, 0);
    u.before_turbine = file.boolean_or("uego.before_turbine", false);
    u.step = file.number_or("uego.quantum", {0, 0.1, ""}, 0);
    u.ageing = file.number_or("uego.ageing", {0.5, 5, ""}, 1);
    s.uego = u;
}

void read_exhaust_sensors(TomlFile &file, Scenario &s) {
    if (!file.has("exhaust_sensors")) return;
    if (!s.uego) file.fail("exhaust_sensors", "needs [uego], with which the exhaust side runs");
    ExhaustSensorSetup e;
    e.sample_s = 1e-6 * file.number_or("exhaust_sensors.pressure_sample_us", {50, 1e5, "us"}, 500);
    e.noise_pa = kPaPerBar * file.number_or("exhaust_sensors.pressure_noise_bar", {0, 1, "bar"}, 0);
    e.lag_s = 1e-3 * file.number_or("exhaust_sensors.pressure_lag_ms", {0.01, 100, "ms"}, 0.2);
    e.temperature = file.boolean_or("exhaust_sensors.temperature", false);
    e.turbine_speed = file.boolean_or("exhaust_sensors.turbine_speed", false);
    s.exhaust_sensors = e;
}

void read_air_path_setup(TomlFile &file, Scenario &s) {
    if (!file.has("airpath")) return;
    if (!s.engine.air_path || !s.engine.shared.air_path)
        file.fail("airpath", "needs an engine file with [airpath] and [plant.airpath]");
    if (s.uego) file.fail("airpath", "does not go with [uego]: each has an exhaust manifold of its own");
    s.air_path = airpath::read_setup(file, s.seed);
}

} // namespace

Scenario read_scenario(TomlFile &file, const std::filesystem::path &folder) {
    Scenario s;
    s.name = file.text_or("name", "");
    s.file = file.name();
    s.engine_path = folder / file.text("engine");
    s.engine = read_plant_engine(s.engine_path);
    read_run(file, s);
    read_speed(file, s);
    read_load(file, s);
    read_elastic(file, s);
    read_cylinders(file, s);
    read_misfires(file, s);
    read_vehicle(file, s);
    read_encoder(file, s);
    read_uego(file, s);
    read_exhaust_sensors(file, s);
    read_air_path_setup(file, s);
    read_balance(file, s);
    file.finish();
    return s;
}

Scenario read_scenario(const std::filesystem::path &path, const std::vector<std::string> &overrides) {
    TomlFile file(path);
    for (const auto &assignment : overrides) file.set(assignment);
    return read_scenario(file, path.parent_path());
}

} // namespace sixdeg
