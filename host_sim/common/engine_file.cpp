// SPDX-License-Identifier: MIT
#include "common/engine_file.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr int kPositionsMin = 12, kPositionsMax = 120, kRunMax = 3;

void check_cylinders(const TomlFile &file, const EngineFile &engine) {
    std::vector<int> sorted = engine.firing_order;
    std::sort(sorted.begin(), sorted.end());
    for (int i = 0; i < int(sorted.size()); ++i) {
        if (sorted[std::size_t(i)] != i + 1) {
            file.fail("cylinders.firing_order", fmt::format("does not name each of cylinders 1 to {} once", sorted.size()));
        }
    }
    if (engine.firing_tdc_deg.front() != 0) {
        file.fail("cylinders.firing_tdc_deg", "does not begin with 0: crank angle is counted from that firing TDC");
    }
    for (std::size_t i = 1; i < engine.firing_tdc_deg.size(); ++i) {
        if (engine.firing_tdc_deg[i] <= engine.firing_tdc_deg[i - 1]) {
            file.fail("cylinders.firing_tdc_deg", "is not ascending");
        }
    }
    if (engine.rod_m <= engine.stroke_m / 2) file.fail("cylinders.rod_m", "is not longer than half the stroke");
}

/// What a drawing or a data sheet leaves open, where the file says nothing (docs/theory/firing.md has a reason for each).
Tolerance usual_tolerance() {
    Tolerance t;
    t.inertia_percent = 4, t.compression_percent = 1, t.trapped_mass_percent = 1, t.wheel_offset_deg = 0.5;
    return t;
}

Tolerance read_tolerance(TomlFile &file) {
    Tolerance t = usual_tolerance();
    const auto read = [&](const char *name, double &value, double most, const char *unit) {
        value = file.number_or(std::string("tolerance.") + name, {0, most, unit}, value);
    };
    read("inertia_percent", t.inertia_percent, 50, "%");
    read("compression_percent", t.compression_percent, 20, "%");
    read("trapped_mass_percent", t.trapped_mass_percent, 50, "%");
    read("wheel_offset_deg", t.wheel_offset_deg, 10, "deg");
    read("burn_start_deg", t.burn_start_deg, 20, "deg");
    read("burn_duration_percent", t.burn_duration_percent, 50, "%");
    read("wall_loss_percent", t.wall_loss_percent, 200, "%");
    return t;
}

Wheel read_wheel(TomlFile &file) {
    Wheel wheel;
    if (!file.has("wheel.missing")) return parse_wheel(file.text_or("wheel.pattern", "60-2"), file.name() + ": wheel.pattern");
    wheel.positions = int(file.integer("wheel.positions", kPositionsMin, kPositionsMax));
    wheel.missing.clear();
    for (double p : file.numbers("wheel.missing", {0, double(wheel.positions - 1), ""})) wheel.missing.push_back(int(p));
    std::sort(wheel.missing.begin(), wheel.missing.end());
    if (wheel.missing.empty() || wheel.missing.back() != wheel.positions - 1) {
        file.fail("wheel.missing", "does not hold the last position: position 0 is the first tooth after a mark");
    }
    return wheel;
}

void read_combustion(TomlFile &file, EngineFile &engine) {
    engine.exhaust_open_deg = file.number_or("valves.exhaust_open_deg", {60, 200, "deg"}, 135);
    engine.intake_close_deg = file.number_or("valves.intake_close_deg", {500, 640, "deg"}, 580);
    const std::size_t count = file.array_size("combustion.pulse");
    if (count > 2) file.fail("combustion.pulse", fmt::format("has {} entries, not 1 or 2", count));
    if (count == 0) { // typical of spark ignition
        engine.guessed.push_back("combustion.pulse");
        engine.pulses = {{-15, 60, 2, 1}};
        return;
    }
    double total = 0;
    for (std::size_t i = 0; i < count; ++i) {
        const std::string at = fmt::format("combustion.pulse[{}].", i);
        engine.pulses.push_back({file.number(at + "start_deg", {-60, 60, "deg"}),
                                 file.number(at + "duration_deg", {3, 120, "deg"}),
                                 file.number(at + "shape", {0.5, 5, ""}), file.number_or(at + "share", {0, 1, ""}, 1)});
        total += engine.pulses.back().share;
    }
    if (std::abs(total - 1) > 1e-6) file.fail("combustion.pulse", fmt::format("shares add up to {:g}, not 1", total));
}

} // namespace

Wheel parse_wheel(const std::string &text, const std::string &from) {
    int positions = 0, missing = 0;
    char rest = 0;
    if (std::sscanf(text.c_str(), "%d-%d%c", &positions, &missing, &rest) != 2 || positions < kPositionsMin ||
        positions > kPositionsMax || missing < 1 || missing > kRunMax) {
        throw InputError(from, "", fmt::format("'{}' is not a wheel like 60-2: {} to {} positions, 1 to {} missing", text,
                                               kPositionsMin, kPositionsMax, kRunMax));
    }
    Wheel wheel{positions, {}};
    for (int i = missing; i > 0; --i) wheel.missing.push_back(positions - i);
    return wheel;
}

std::vector<int> missing_runs(const Wheel &wheel) {
    std::vector<int> runs;
    for (std::size_t i = 0; i < wheel.missing.size(); ++i) {
        if (i > 0 && wheel.missing[i] == wheel.missing[i - 1] + 1) ++runs.back();
        else runs.push_back(1);
    }
    return runs;
}

std::string describe(const Wheel &wheel) {
    std::vector<int> runs = missing_runs(wheel);
    std::sort(runs.rbegin(), runs.rend());
    return fmt::format("{}-{}", wheel.positions, fmt::join(runs, "-"));
}

EngineFile read_engine(TomlFile &file) {
    EngineFile engine;
    engine.name = file.text("name");
    if (file.has("guessed")) engine.guessed = file.texts("guessed");

    for (double c : file.numbers("cylinders.firing_order", {1, 8, ""})) engine.firing_order.push_back(int(c));
    if (engine.firing_order.empty() || engine.firing_order.size() > 8) file.fail("cylinders.firing_order", "has not 1 to 8 entries");
    engine.firing_tdc_deg = file.numbers("cylinders.firing_tdc_deg", {0, 719.999, "deg"}, engine.firing_order.size());
    engine.bore_m = file.number("cylinders.bore_m", {0.02, 0.5, "m"});
    engine.stroke_m = file.number("cylinders.stroke_m", {0.02, 0.5, "m"});
    engine.rod_m = file.number("cylinders.rod_m", {0.02, 1, "m"});
    engine.compression_ratio = file.number("cylinders.compression_ratio", {5, 25, ""});
    check_cylinders(file, engine);

    read_combustion(file, engine);
    engine.inertia_kgm2 = file.number("crank.inertia_kgm2", {1e-4, 10, "kg m2"});
    engine.reciprocating_mass_kg = file.number_or("crank.reciprocating_mass_kg", {0, 10, "kg"}, 0);

    engine.dual_mass = read_dual_mass(file);
    engine.torsion = read_torsion(file, engine.inertia_kgm2, int(engine.firing_order.size()));

    engine.driveline = read_driveline(file);
    if (engine.driveline && engine.dual_mass)
        file.fail("driveline", "cannot stand beside [dual_mass]: the observers take the crank for what turns before the shaft");

    engine.wheel = read_wheel(file);
    engine.position_0_deg = file.number("wheel.position_0_deg", {0, 359.999, "deg"});
    const std::string edge = file.text_or("wheel.edge", "falling");
    if (edge != "falling" && edge != "rising") file.fail("wheel.edge", "'" + edge + "' is not \"falling\" or \"rising\"");
    engine.falling_edge = edge == "falling";

    engine.has_cam = file.has("cam.edge_deg");
    if (engine.has_cam) engine.cam_edge_deg = file.number("cam.edge_deg", {0, 719.999, "deg"});
    engine.tick_hz = file.number_or("timer.tick_hz", {1e5, 2e8, "Hz"}, 1e6);
    engine.tolerance = read_tolerance(file);
    engine.exhaust = read_exhaust_system(file);
    engine.air_path = read_air_path(file);
    file.ignore("plant");
    return engine;
}

} // namespace sixdeg
