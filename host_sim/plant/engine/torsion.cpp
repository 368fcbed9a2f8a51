// SPDX-License-Identifier: MIT
#include "plant/engine/torsion.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/linalg.hpp"

namespace sixdeg {

CrankElasticity::CrankElasticity(const PlantEngine &engine) : engine_(engine) {
    if (!engine.torsion) return;
    const CrankTorsion &t = *engine.torsion;
    const int n = engine.shared.cylinders(), nodes = n + 2;
    Eigen::VectorXd inertia = Eigen::VectorXd::Constant(nodes, t.throw_inertia_kgm2);
    inertia[0] = t.front_inertia_kgm2;
    inertia[nodes - 1] = engine.shared.inertia_kgm2 - t.front_inertia_kgm2 - n * t.throw_inertia_kgm2;
    if (!engine.dual_mass) inertia[nodes - 1] += engine.driveline_inertia_kgm2;
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(nodes, nodes);
    for (int i = 0; i + 1 < nodes; ++i) {
        stiffness.block<2, 2>(i, i) +=
            t.section_stiffness_nmprad * (Eigen::Matrix2d() << 1, -1, -1, 1).finished();
    }
    // Eigenvectors come mass-normalised and ascending; the first is the rigid crank.
    const linalg::Vibrations free = linalg::vibrations(stiffness, inertia);
    for (int m = 1; m <= std::min(engine.torsion_modes, nodes - 1); ++m) {
        const Eigen::VectorXd shape = free.shapes.col(m);
        Mode mode{std::sqrt(free.squared_radps2[m]),
                  shape[t.wheel_at_front ? 0 : nodes - 1],
                  shape[nodes - 1],
                  {}};
        for (int cylinder : engine.shared.firing_order) mode.throw_shape.push_back(shape[cylinder]);
        modes_.push_back(mode);
    }
}

double CrankElasticity::force_of(const Mode &mode, const EngineModel &model) const {
    const auto n = mode.throw_shape.size();
    const double square = model.truth().speed_radps * model.truth().speed_radps;
    const double *slopes = &half_inertia_slope_[std::size_t(model.step_in_cycle()) * n];
    double force = -mode.flywheel_shape * model.truth().load_torque_nm;
    for (std::size_t lane = 0; lane < n; ++lane) {
        force += mode.throw_shape[lane] * (model.gas_torque_nm(int(lane)) - slopes[lane] * square);
    }
    return force;
}

// q'' + 2 z w q' + w^2 q = f over a time with constant f: the free vibration about f/w^2.
void CrankElasticity::propagate(Mode &mode, double force, double duration_s) const {
    const double w = mode.frequency_radps, z = engine_.torsion->damping_ratio;
    const double damped = w * std::sqrt(1 - z * z), rest = force / (w * w);
    const double decay = std::exp(-z * w * duration_s), c = std::cos(damped * duration_s),
                 s = std::sin(damped * duration_s);
    const double away = mode.angle - rest, sine = (mode.rate + z * w * away) / damped;
    mode.angle = rest + decay * (away * c + sine * s);
    mode.rate = decay * (mode.rate * c - (z * w * sine + damped * away) * s);
}

void CrankElasticity::step(const EngineModel &model, double duration_s) {
    const StepTables &tables = model.tables();
    if (half_inertia_slope_.empty()) {
        const CrankSlider slider = engine_.slider(engine_.shared.compression_ratio);
        for (int step = 0; step < tables.steps; ++step) {
            for (double tdc : tables.tdc_rad) {
                const double theta = step * tables.step_rad - tdc;
                half_inertia_slope_.push_back(engine_.shared.reciprocating_mass_kg *
                                              slider.travel_slope_m(theta) *
                                              slider.travel_curvature_m(theta));
            }
        }
    }
    twist_ = twist_rate_ = 0;
    for (Mode &mode : modes_) {
        const double force = force_of(mode, model);
        propagate(mode, (mode.force + force) / 2, duration_s);
        mode.force = force;
        twist_ += mode.wheel_shape * mode.angle;
        twist_rate_ += mode.wheel_shape * mode.rate;
    }
}

std::vector<double> CrankElasticity::frequencies_radps() const {
    std::vector<double> frequencies;
    for (const Mode &mode : modes_) frequencies.push_back(mode.frequency_radps);
    return frequencies;
}

} // namespace sixdeg
