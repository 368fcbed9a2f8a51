// SPDX-License-Identifier: MIT
#include "design/crank/crank_modes.hpp"

#include <cmath>

#include "design/calibration.hpp"
#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Chain {
    std::vector<double> inertia, stiffness; ///< Of the links, and between each and the next.
    std::size_t wheel, flywheel;            ///< Links that carry the teeth, and that the load turns.
    std::vector<std::size_t> throws;        ///< Link of each entry of firing_order.
};

double mean_crank_inertia(const EngineFile &engine) {
    double sum = 0;
    for (int i = 0; i < 720; ++i) sum += crank_inertia_kgm2(engine, M_PI / 180 * i) / 720;
    return sum;
}

Chain chain_of(const EngineFile &engine) {
    Chain chain;
    chain.throws.assign(std::size_t(engine.cylinders()), 0);
    if (engine.torsion) {
        const CrankTorsion &t = *engine.torsion;
        const auto n = std::size_t(engine.cylinders());
        chain.inertia.assign(n + 2, t.throw_inertia_kgm2);
        chain.inertia.front() = t.front_inertia_kgm2;
        chain.inertia.back() = engine.inertia_kgm2 - t.front_inertia_kgm2 - double(n) * t.throw_inertia_kgm2;
        chain.stiffness.assign(n + 1, t.section_stiffness_nmprad);
        for (std::size_t lane = 0; lane < n; ++lane) chain.throws[lane] = std::size_t(engine.firing_order[lane]);
    } else {
        chain.inertia = {mean_crank_inertia(engine)};
    }
    chain.flywheel = chain.inertia.size() - 1;
    chain.wheel = engine.torsion && engine.torsion->wheel_at_front ? 0 : chain.flywheel;
    if (engine.dual_mass) {
        chain.inertia.push_back(engine.dual_mass->secondary_inertia_kgm2);
        chain.stiffness.push_back(engine.dual_mass->stiffness_nmprad);
    }
    return chain;
}

} // namespace

std::vector<CrankMode> crank_modes(const EngineFile &engine, std::size_t most) {
    constexpr double kStill = 1e-6; // a wheel that moves less than this share of the chain stands in a node
    const Chain chain = chain_of(engine);
    const auto n = Eigen::Index(chain.inertia.size());
    MatrixXd stiffness = MatrixXd::Zero(n, n);
    for (Eigen::Index i = 0; i + 1 < n; ++i) {
        const double k = chain.stiffness[std::size_t(i)];
        stiffness(i, i) += k, stiffness(i + 1, i + 1) += k, stiffness(i, i + 1) -= k, stiffness(i + 1, i) -= k;
    }
    const VectorXd inertia = Eigen::Map<const VectorXd>(chain.inertia.data(), n);
    const linalg::Vibrations free = linalg::vibrations(stiffness, inertia);
    std::vector<CrankMode> modes;
    for (Eigen::Index i = 1; i < n && modes.size() < most; ++i) { // the first one is the rigid crank
        const VectorXd shape = free.shapes.col(i); // mass-normalised
        const double wheel = shape(Eigen::Index(chain.wheel)), frequency = std::sqrt(free.squared_radps2(i));
        if (std::abs(wheel) < kStill * shape.norm()) continue;
        const double hold = wheel / (frequency * frequency), flywheel = shape(Eigen::Index(chain.flywheel));
        CrankMode mode{frequency, engine.torsion ? engine.torsion->damping_ratio : 0, hold * flywheel, {}, 0, 0};
        for (std::size_t link : chain.throws) mode.cylinder_radpnm.push_back(hold * shape(Eigen::Index(link)));
        if (engine.dual_mass) {
            const double apart = flywheel - shape(n - 1), damper = engine.dual_mass->damping_nmsprad * apart;
            mode.damping += damper * apart / (2 * frequency);
            mode.spring_nmprad = engine.dual_mass->stiffness_nmprad * apart / wheel;
            mode.damper_nmprad = damper * frequency / wheel;
        }
        modes.push_back(mode);
    }
    return modes;
}

double turning_inertia_kgm2(const EngineFile &engine, double alpha) {
    return crank_inertia_kgm2(engine, alpha) + (engine.dual_mass ? engine.dual_mass->secondary_inertia_kgm2 : 0);
}

} // namespace sixdeg
