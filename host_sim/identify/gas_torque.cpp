// SPDX-License-Identifier: MIT
#include "identify/gas_torque.hpp"

#include <cmath>

#include "design/crank/slider_crank.hpp"

namespace sixdeg {
namespace {

constexpr double kRad = M_PI / 180;
constexpr double kMassSd = 0.06; // of the reciprocating mass in an engine file: 10 % either way, evenly

} // namespace

GasTorque::GasTorque(const EngineFile &engine) : engine_(engine) {
    unknowns_ = {{"inertia", 0, 0, 0.1}, {"wheel offset", 0, 0, 1 * kRad}, {"reciprocating mass", 0, kMassSd, kMassSd}};
}

Eigen::VectorXd GasTorque::squared_arms(double offset_rad) const {
    const SliderCrank crank(engine_);
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(kGridPoints);
    for (std::size_t lane = 0; lane < std::size_t(engine_.cylinders()); ++lane)
        for (int i = 0; i < kGridPoints; ++i) {
            const double arm = crank.volume_slope((grid_deg(i) - tdc_deg(lane)) * kRad + offset_rad) / crank.area;
            sum(i) += arm * arm;
        }
    return sum;
}

CycleTorque GasTorque::torque(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const {
    const double inertia = engine_.inertia_kgm2 * std::exp(values(log_inertia)), offset = values(wheel_offset);
    const double share = engine_.reciprocating_mass_kg * (1 + values(ripple_mass)) / inertia, step = 0.1 * kRad;
    Nm nm = gas_nm(cycle, grid_s, values);
    CycleTorque result;
    result.gas_over_j = nm.gas / inertia;
    result.torque_slope = nm.slope / inertia;
    result.torque_slope.col(log_inertia) = -result.gas_over_j;
    const Eigen::VectorXd arms = squared_arms(offset);
    result.ripple = 1 + share * arms.array();
    result.ripple_slope = Eigen::MatrixXd::Zero(kGridPoints, values.size());
    result.ripple_slope.col(log_inertia) = -share * arms;
    result.ripple_slope.col(ripple_mass) = engine_.reciprocating_mass_kg / inertia * arms;
    result.ripple_slope.col(wheel_offset) = share / (2 * step) * (squared_arms(offset + step) - squared_arms(offset - step));
    return result;
}

} // namespace sixdeg
