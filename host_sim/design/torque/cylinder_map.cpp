// SPDX-License-Identifier: MIT
#include "design/torque/cylinder_map.hpp"

#include <cmath>

#include "design/torque/observer_map.hpp"
#include "design/torque/pulse.hpp"
#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// A torque over the cycle, at the pulse's points from crank angle position_0_deg on.
using Wave = VectorXd;

void add(Wave &wave, const std::vector<double> &pulse, double from_tdc_deg, double factor) {
    for (int i = 0; i < wave.size(); ++i) {
        wave(i) += factor * pulse_at(pulse, 4 * M_PI * i / double(wave.size()) + from_tdc_deg * M_PI / 180);
    }
}

/// What each unknown adds to the torque: one firing of each cylinder, a bar of intake pressure; last, what is known.
std::vector<Wave> waves(const EngineFile &engine) {
    const int n = engine.cylinders();
    std::vector<Wave> all(std::size_t(n) + 2, Wave::Zero(kPulsePoints));
    std::vector<CylinderPulse> pulses;
    for (int i = 0; i < n; ++i) {
        const auto lane = std::size_t(i);
        const std::size_t like = like_cylinder(engine, lane);
        pulses.push_back(like < lane ? pulses[like] : cylinder_pulse(engine, lane));
        const CylinderPulse &pulse = pulses.back();
        const double from_tdc_deg = engine.position_0_deg - engine.firing_tdc_deg[lane];
        add(all[lane], pulse.combustion, from_tdc_deg, 1);
        add(all[std::size_t(n)], pulse.motored_per_bar, from_tdc_deg, engine.trapped_factor(lane));
        add(all[std::size_t(n) + 1], pulse.motored_rest, from_tdc_deg, 1);
    }
    return all;
}

/// Kinetic energy that a torque makes, less its mean torque: averaged over the interval that ends at each position,
/// which is what a tooth period sees.
VectorXd energies(const Wave &wave, int positions) {
    const int cycle = 2 * positions;
    const double h = 4 * M_PI / double(wave.size()), mean = wave.mean();
    VectorXd energy(wave.size() + 1);
    energy(0) = 0;
    for (int i = 0; i < wave.size(); ++i)
        energy(i + 1) = energy(i) + h * ((wave(i) + wave((i + 1) % wave.size())) / 2 - mean);
    VectorXd seen(cycle);
    const double points = double(wave.size()) / cycle;
    constexpr int kFine = 12; // even parts of an interval
    for (int k = 0; k < cycle; ++k) {
        double sum = 0;
        for (int fine = 0; fine < kFine; ++fine) {
            const double at = points * (k - (fine + 0.5) / kFine), whole = std::floor(at);
            const auto i = (std::int64_t(whole) + wave.size()) % wave.size();
            sum += energy(i) + (at - whole) * (energy(i + 1) - energy(i));
        }
        seen(k) = sum / kFine;
    }
    return seen;
}

} // namespace

std::optional<CylinderMap> cylinder_map(const EngineFile &engine, const sd_parameters_t &tune) {
    const int n = engine.cylinders();
    if (int(tune.torque_harmonics) < n || engine.pulses.empty()) return std::nullopt; // nobody knows its pulse
    const ObserverMap observer(engine, tune);
    const auto torques = waves(engine);
    MatrixXd energy(2 * observer.positions(), n + 2);
    for (int i = 0; i < n + 2; ++i) energy.col(i) = energies(torques[std::size_t(i)], observer.positions());
    const MatrixXd settled = observer.settled(energy);

    // Unknown: each cylinder, and the load, a constant torque that shows in a_0 alone. Intake pressure is measured: over
    // the cycle, compression looks too much like combustion to be told from it.
    MatrixXd response = MatrixXd::Zero(observer.coefficients(), n + 1);
    response.leftCols(n) = settled.leftCols(n);
    response(0, n) = 1;
    const MatrixXd covariance = observer.noise_covariance();
    const MatrixXd weighted = linalg::solve_symmetric(covariance, response);
    const MatrixXd inverse = linalg::solve_symmetric(response.transpose() * weighted, weighted.transpose());
    CylinderMap result;
    result.map = inverse.topRows(n);
    result.offset = -result.map * settled.col(n + 1);
    result.per_bar = -result.map * settled.col(n);
    result.sd_ratio = (result.map * covariance * result.map.transpose()).diagonal().cwiseSqrt();
    return result;
}

} // namespace sixdeg
