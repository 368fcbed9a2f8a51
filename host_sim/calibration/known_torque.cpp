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
    const auto sum = [pulses, tdc](std::vector<double> CylinderPulse::*table) {
        return [pulses, tdc, table](double a) {
            double torque = 0;
            for (std::size_t lane = 0; lane < pulses->size(); ++lane) torque += pulse_at((*pulses)[lane].*table, a - tdc(lane));
            return torque;
        };
    };
    KnownTorque known;
    known.motored_per_bar = sum(&CylinderPulse::motored_per_bar);
    known.motored = sum(&CylinderPulse::motored_rest);
    known.firings = parameters.firing_harmonics == 0;
    if (!known.firings) {
        known.basis = fourier_basis(int(parameters.firing_harmonics));
        return known;
    }
    for (std::size_t lane = 0; lane < pulses->size(); ++lane)
        known.basis.push_back([pulses, tdc, lane](double a) { return pulse_at((*pulses)[lane].combustion, a - tdc(lane)); });
    return known;
}

KalmanTune kalman_tune(const sd_parameters_t &p) {
    KalmanTune tune;
    tune.edge_deg = double(p.firing_edge_sd_deg);
    tune.load_walk_nm = double(p.firing_load_walk_nm);
    tune.rough_walk_nm = double(p.firing_rough_walk_nm);
    tune.firing_change_nm = double(p.firing_change_nm);
    tune.torque_base_nm = double(p.torque_torque_base_nm);
    tune.reject_deg = double(p.firing_reject_deg);
    tune.shape_sd = double(p.firing_shape_sd);
    tune.settle_cycles = double(p.firing_settle_cycles);
    if (p.firing_harmonics > 0) tune.speeds_rpm = {1000}; // one table fits the pool; waveform only
    return tune;
}

} // namespace sixdeg
