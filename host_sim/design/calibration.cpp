// SPDX-License-Identifier: MIT
#include "design/calibration.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "design/afr/chain_map.hpp"
#include "design/airpath/airpath_tables.hpp"
#include "design/airpath/fixed_tables.hpp"
#include "design/misfire/wheel_design.hpp"
#include "design/torque/cylinder_map.hpp"
#include "design/torque/known_torque.hpp"
#include "design/torque/observer_map.hpp"
#include "design/torque/work_windows.hpp"
#include "design/afr/exhaust_tables.hpp"
#include "design/driveline/driveline_page.hpp"
#include "common/error.hpp"
#include "linalg/linalg.hpp"
extern "C" {
#include "sd_ecu.h"
}

namespace sixdeg {
namespace {

constexpr double kRadPerDeg = M_PI / 180;

/// Cycle position of a crank angle, in wheel positions from position 0 of the first revolution.
double cycle_position(const EngineFile &engine, double angle_deg) {
    const double off = std::fmod(angle_deg - engine.position_0_deg + 1440, 720);
    return off / 360 * engine.wheel.positions;
}

std::int32_t to_q31(double x) {
    return std::int32_t(std::clamp(std::round(x * 2147483648.0), -2147483648.0, 2147483647.0));
}

/// 0.001 for 0.001f, so that a limit lies within its own range.
double as_written(float value) { return std::stod(fmt::format("{}", value)); }

void check_starts(const sd_calibration_t &calibration, const EngineFile &engine, const std::string &tune_name) {
    sd_crank_t crank;
    const sd_crank_config_t crank_config = sd_calibration_crank(&calibration, &calibration.parameters);
    if (sd_crank_init(&crank, &crank_config) != SD_OK) {
        throw InputError(engine.name, "wheel",
                         fmt::format("the decoder takes runs of 1 to 3 missing teeth, at most {} of them at least 4 teeth "
                                                           "apart or two alike with 1 between, "
                                                           "and a stall time of 256 to 16777216 ticks", SD_CRANK_MARKS_MAX));
    }
    const auto ecu = std::make_unique<sd_ecu_t>();
    if (sd_ecu_init(ecu.get(), &calibration) != SD_OK) {
        throw InputError(tune_name, "torque", "these parameters cannot start the observer: gain_reference must be below "
                                              "its limit, the wheel even, and a tooth at speed_base at least 16 ticks long");
    }
}

/// J half a pitch before a position, as the Fourier observer takes it.
double observer_inertia_kgm2(const EngineFile &engine, int k) {
    const double alpha = engine.position_0_deg * kRadPerDeg + 2 * M_PI * (k - 0.5) / engine.wheel.positions;
    return double(float(crank_inertia_kgm2(engine, alpha)));
}

sd_fourier_tables_t fourier_tables(const EngineFile &engine) {
    sd_fourier_tables_t tables{};
    const int positions = engine.wheel.positions;
    for (int k = 0; k < positions; ++k) tables.inertia_base_kgm2 =
        std::max(tables.inertia_base_kgm2, float(observer_inertia_kgm2(engine, k)));
    for (int k = 0; k < positions; ++k) {
        tables.inertia_q31[k] = to_q31(double(float(observer_inertia_kgm2(engine, k)) / tables.inertia_base_kgm2));
    }
    for (int k = 0; k < 2 * positions; ++k) tables.sine_q31[k] = to_q31(std::sin(M_PI * k / positions));
    return tables;
}

/// The map as the page holds it; empty where it does not exist.
sd_cylinder_map_t page_map(const EngineFile &engine, const sd_calibration_t &c) {
    sd_cylinder_map_t page{};
    const auto found = cylinder_map(engine, c.parameters);
    if (!found) return page;
    double mean_inertia = 0;
    for (int k = 0; k < c.positions; ++k) mean_inertia += observer_inertia_kgm2(engine, k) / c.positions;
    page.cylinders = c.cylinders;
    page.harmonics = std::uint8_t(c.parameters.torque_harmonics);
    page.gain_energy = c.parameters.torque_gain_energy_per_rad;
    page.gain_mean = c.parameters.torque_gain_mean_per_rad2;
    page.gain_reference = c.parameters.torque_gain_reference_per_rad2;
    for (int i = 0; i < engine.cylinders(); ++i) {
        for (int j = 0; j < found->map.cols(); ++j) page.map[i][j] = float(found->map(i, j));
        page.offset_nm[i] = float(found->offset(i));
        page.nm_per_bar[i] = float(found->per_bar(i));
        page.sd_kgm2[i] = float(found->sd_ratio(i) * mean_inertia);
    }
    return page;
}

/// The filter on tooth times, where the engine file tells enough for it.
void page_filter(const EngineFile &engine, const std::string &tune_name, sd_calibration_t &c) {
    const auto known = known_torque(engine, c.parameters);
    if (!known || c.parameters.firing_enabled < 0.5f) return;
    const KalmanTables made = kalman_tables(engine, *known, kalman_tune(engine, c.parameters));
    double radius = made.radius_between;
    for (const PeriodicGains &gains : made.gains) radius = std::max(radius, gains.radius);
    if (!(radius < 1)) {
        throw InputError(tune_name, "firing.edge_sd, load_walk, change",
                         fmt::format("the filter does not converge: its error changes by {:.4g} a cycle, allowed below 1", radius));
    }
    c.kalman = made.tables;
}

void check_chain(const sd_calibration_t &c, const std::string &tune_name) {
    const double radius = chain_radius(c);
    if (radius < 1) return;
    throw InputError(tune_name, "afr.gain_air, gain_cylinder, inversion_gain, inversion_floor",
                     fmt::format("the chain does not converge: its error changes by {:.4g} a cycle, allowed below 1", radius));
}

/// The air path's diagnosis, where the engine file names a design.
sd_airpath_tables_f32_t air_path_tables(const EngineFile &engine) {
    if (!engine.air_path || engine.air_path->design_name.empty()) return {};
    if (engine.air_path->design_text.empty()) throw InputError(engine.name, "airpath.design",
                                                               "names no file: " + engine.air_path->design_name);
    TomlFile file(engine.air_path->design_name, engine.air_path->design_text);
    const AirPathDesign design = read_air_path_design(file, *engine.air_path, engine.displaced_m3() * engine.cylinders());
    file.finish();
    return design.tables;
}

/// In both arithmetics; that the numbers fit fixed point is asked for only where it is chosen.
void add_air_path(const EngineFile &engine, const std::string &tune_name, sd_calibration_t &c) {
    c.airpath = air_path_tables(engine);
    const FixedAirPath fixed = fixed_air_path(c.airpath);
    c.airpath_q31 = fixed.tables;
    if (!fixed.too_large.empty() && c.parameters.airpath_arithmetic > 0.5f)
        throw InputError(tune_name, "airpath.arithmetic", "1 does not go with the engine file's air path: " + fixed.too_large);
}

} // namespace

sd_parameters_t read_tune(TomlFile &tune, const sd_parameters_t *otherwise) {
    sd_parameters_t parameters;
    float *value = reinterpret_cast<float *>(&parameters);
    const float *other = reinterpret_cast<const float *>(otherwise);
    for (const sd_signal_info_t &info : sd_parameter_infos) {
        const float missing = other ? *other++ : info.value;
        *value++ = float(tune.number_or(info.name, {as_written(info.low), as_written(info.high), info.unit}, as_written(missing)));
    }
    tune.finish();
    const float harmonics = parameters.torque_harmonics;
    if (harmonics != std::floor(harmonics)) tune.fail("torque.harmonics", fmt::format("{:g} is not a whole number in [0, 12]", harmonics));
    return parameters;
}

sd_parameters_t resolve(const EngineFile &engine, sd_parameters_t tune) {
    if (tune.torque_harmonics == 0) tune.torque_harmonics = float(std::max(5, engine.cylinders()));
    const double displacement_m3 = M_PI / 4 * engine.bore_m * engine.bore_m * engine.stroke_m;
    if (tune.torque_torque_base_nm == 0) tune.torque_torque_base_nm = float(std::min(20000.0, 40e5 * displacement_m3));
    return tune;
}

double reciprocating_inertia_kgm2(const EngineFile &engine, std::size_t lane, double alpha) {
    const double r = engine.stroke_m / 2, l = engine.rod_m, a = alpha - engine.firing_tdc_deg[lane] * kRadPerDeg;
    const double arm = r * std::sin(a) * (1 + r * std::cos(a) / std::sqrt(l * l - std::pow(r * std::sin(a), 2)));
    return engine.reciprocating_mass_kg * arm * arm;
}

double crank_inertia_kgm2(const EngineFile &engine, double alpha) {
    double inertia = engine.inertia_kgm2;
    for (std::size_t lane = 0; lane < engine.firing_tdc_deg.size(); ++lane) inertia += reciprocating_inertia_kgm2(engine, lane, alpha);
    return inertia;
}

double observer_radius(const EngineFile &engine, const sd_parameters_t &tune) {
    return linalg::spectral_radius(ObserverMap(engine, tune).error_map());
}

sd_calibration_t calibrate(const EngineFile &engine, const sd_parameters_t &tune, const std::string &tune_name) {
    sd_calibration_t c{};
    const int positions = engine.wheel.positions;
    c.tick_hz = float(engine.tick_hz);
    c.positions = std::uint8_t(positions);
    c.missing_count = std::uint8_t(engine.wheel.missing.size());
    std::copy(engine.wheel.missing.begin(), engine.wheel.missing.end(), c.missing);
    c.has_cam = engine.has_cam;
    c.cam_position = std::uint16_t(int(std::lround(cycle_position(engine, engine.cam_edge_deg))) % (2 * positions));
    c.position_0_deg = float(engine.position_0_deg);
    c.cylinders = std::uint8_t(engine.cylinders());
    for (int i = 0; i < engine.cylinders(); ++i) {
        c.firing_order[i] = std::uint8_t(engine.firing_order[std::size_t(i)]);
        const double start = cycle_position(engine, engine.firing_tdc_deg[std::size_t(i)]);
        c.firing_position[i] = std::uint16_t(int(std::ceil(start - 1e-9)) % (2 * positions));
    }
    c.fourier = fourier_tables(engine);
    c.parameters = resolve(engine, tune);
    c.work = work_windows(engine, double(c.parameters.work_window_deg));
    add_air_path(engine, tune_name, c);
    c.wheel = wheel_tables(engine, c);
    if (c.wheel.positions == 0 && c.parameters.misfire_method > 0.5f)
        throw InputError(tune_name, "misfire.method", "the observers of document 000 need the engine file's combustion.pulse");
    check_starts(c, engine, tune_name);
    const double radius = observer_radius(engine, c.parameters);
    if (!(radius < 1)) {
        throw InputError(tune_name, "torque.gain_energy, gain_mean, gain_reference",
                         fmt::format("the observer does not converge: its error changes by {:.4g} a cycle, allowed below 1", radius));
    }
    c.cylinder_map = page_map(engine, c);
    page_filter(engine, tune_name, c);
    add_driveline(engine, c);
    if (engine.driveline) check_starts(c, engine, tune_name);
    c.afr = afr_grid(engine);
    check_chain(c, tune_name);
    return c;
}

std::string page_source(const std::vector<std::uint8_t> &bytes, const std::string &engine_name) {
    std::string text = fmt::format("/* Generated by `sixdeg calibrate` for {}; read it with sd_calibration_view. */\n"
                                   "#include <stdint.h>\n\nconst uint32_t sd_calibration_page_size = {}u;\n"
                                   "_Alignas(4) const uint8_t sd_calibration_page[{}] = {{", engine_name, bytes.size(), bytes.size());
    for (std::size_t i = 0; i < bytes.size(); ++i) text += fmt::format("{}0x{:02x},", i % 16 ? " " : "\n    ", bytes[i]);
    return text + "\n};\n";
}

} // namespace sixdeg
