// SPDX-License-Identifier: MIT
#include "design/torque/known_torque.hpp"

#include <cmath>
#include <memory>

#include "design/crank/crank_modes.hpp"
#include "design/torque/pulse.hpp"

namespace sixdeg {

std::vector<TorqueOverAngle> fourier_basis(int harmonics) {
    std::vector<TorqueOverAngle> basis;
    for (int h = 1; h <= harmonics; ++h) {
        basis.push_back([h](double a) { return std::cos(h * a / 2); });
        basis.push_back([h](double a) { return std::sin(h * a / 2); });
    }
    return basis;
}

std::optional<KnownTorque> known_torque(const EngineFile &engine, const sd_parameters_t &parameters) {
    if (engine.pulses.empty()) return std::nullopt;
    struct Tables : CylinderPulse {
        std::vector<double> bend, exponent;
    };
    const bool learns = parameters.firing_harmonics == 0 && parameters.firing_shape_walk_nm > 0 && !engine.torsion;
    const auto pulses = std::make_shared<std::vector<Tables>>();
    std::vector<Tables> own; // with a charge as large as the others'
    for (std::size_t lane = 0; lane < std::size_t(engine.cylinders()); ++lane) {
        const std::size_t like = like_cylinder(engine, lane);
        Tables tables = like < lane ? own[like] : Tables{cylinder_pulse(engine, lane), {}, {}};
        if (learns && like == lane) tables.bend = pulse_bend(engine, lane, tables);
        if (like == lane) tables.exponent = motored_over_exponent(engine, lane);
        own.push_back(tables);
        for (auto *table : {&tables.motored_per_bar, &tables.exponent})
            for (double &torque : *table) torque *= engine.trapped_factor(lane);
        pulses->push_back(std::move(tables));
    }
    const auto tdc = [degrees = engine.firing_tdc_deg](std::size_t lane) { return degrees[lane] * M_PI / 180; };
    const auto each = [pulses, tdc](std::vector<double> Tables::*table) {
        std::vector<TorqueOverAngle> torques;
        for (std::size_t lane = 0; lane < pulses->size(); ++lane)
            torques.push_back([pulses, tdc, table, lane](double a) { return pulse_at((*pulses)[lane].*table, a - tdc(lane)); });
        return torques;
    };
    KnownTorque known;
    known.motored_per_bar = each(&CylinderPulse::motored_per_bar);
    known.motored = each(&CylinderPulse::motored_rest);
    // A crank with modes learns their frequency from the same teeth, and would need the twist that this torque holds.
    if (crank_modes(engine, SD_KALMAN_MODES_MAX).empty()) known.exponent = sum_of(each(&Tables::exponent));
    known.firings = parameters.firing_harmonics == 0;
    if (learns) known.shape = each(&Tables::bend);
    known.basis = known.firings ? each(&CylinderPulse::combustion) : fourier_basis(int(parameters.firing_harmonics));
    return known;
}

KalmanTune kalman_tune(const EngineFile &engine, const sd_parameters_t &p) {
    KalmanTune tune;
    tune.edge_deg = double(p.firing_edge_sd_deg);
    tune.load_walk_nm = double(p.firing_load_walk_nm);
    tune.rough_walk_nm = double(p.firing_rough_walk_nm);
    tune.firing_torque_change_nm = double(p.firing_torque_change_nm);
    if (p.firing_harmonics == 0) tune.basis_walk_nm = double(p.firing_shape_walk_nm);
    if (engine.torsion) {
        // A mode near an engine order wants gains of its own within a few percent of speed. And what all cylinders share shows
        // in their differences, by each one's place in the mode: a common torque that settles slowly would spoil them. It may
        // then walk so far that what a failed firing lacks would be taken for load, were the firing not freer too.
        tune.speeds_rpm = {1000, 1200, 1440, 1730, 2070, 2500, 3000, 3600, 4300, 5200, 6200, 7400};
        tune.load_walk_nm *= 10;
        tune.firing_torque_change_nm *= 4;
    }
    if (p.firing_harmonics > 0) tune.speeds_rpm = {1000}; // one table fits the pool; waveform only
    return tune;
}

} // namespace sixdeg
