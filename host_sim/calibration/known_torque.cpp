// SPDX-License-Identifier: MIT
#include "calibration/known_torque.hpp"

#include <cmath>
#include <memory>

#include "calibration/pulse.hpp"

namespace sixdeg {

std::optional<KnownTorque> known_torque(const EngineFile &engine, const sd_parameters_t &parameters) {
    if (engine.pulses.empty()) return std::nullopt;
    const auto pulses = std::make_shared<std::vector<CylinderPulse>>();
    for (std::size_t lane = 0; lane < std::size_t(engine.cylinders()); ++lane) {
        pulses->push_back(cylinder_pulse(engine, lane));
        for (double &torque : pulses->back().motored_per_bar) torque *= engine.trapped_factor(lane);
    }
    const auto tdc = [degrees = engine.firing_tdc_deg](std::size_t lane) { return degrees[lane] * M_PI / 180; };
    const auto each = [pulses, tdc](std::vector<double> CylinderPulse::*table) {
        std::vector<TorqueOverAngle> torques;
        for (std::size_t lane = 0; lane < pulses->size(); ++lane)
            torques.push_back([pulses, tdc, table, lane](double a) { return pulse_at((*pulses)[lane].*table, a - tdc(lane)); });
        return torques;
    };
    KnownTorque known;
    known.motored_per_bar = each(&CylinderPulse::motored_per_bar);
    known.motored = each(&CylinderPulse::motored_rest);
    known.firings = parameters.firing_harmonics == 0;
    known.basis = known.firings ? each(&CylinderPulse::combustion) : fourier_basis(int(parameters.firing_harmonics));
    return known;
}

KalmanTune kalman_tune(const EngineFile &engine, const sd_parameters_t &p) {
    KalmanTune tune;
    tune.edge_deg = double(p.firing_edge_sd_deg);
    tune.load_walk_nm = double(p.firing_load_walk_nm);
    tune.rough_walk_nm = double(p.firing_rough_walk_nm);
    tune.firing_change_nm = double(p.firing_change_nm);
    tune.torque_base_nm = double(p.torque_torque_base_nm);
    tune.reject_deg = double(p.firing_reject_deg);
    tune.shape_sd = double(p.firing_shape_sd);
    tune.settle_cycles = double(p.firing_settle_cycles);
    if (engine.torsion) {
        // A mode near an engine order wants gains of its own within a few percent of speed. And what all cylinders share shows
        // in their differences, by each one's place in the mode: a common torque that settles slowly would spoil them. It may
        // then walk so far that what a failed firing lacks would be taken for load, were the firing not freer too.
        tune.speeds_rpm = {1000, 1200, 1440, 1730, 2070, 2500, 3000, 3600, 4300, 5200, 6200, 7400};
        tune.load_walk_nm *= 10;
        tune.firing_change_nm *= 4;
    }
    if (p.firing_harmonics > 0) tune.speeds_rpm = {1000}; // one table fits the pool; waveform only
    return tune;
}

} // namespace sixdeg
