// SPDX-License-Identifier: MIT
#include "identify/gas_torque.hpp"

#include <cmath>

#include "design/crank/slider_crank.hpp"

namespace sixdeg {
namespace {

constexpr double kRad = M_PI / 180;
constexpr double kOffsetSd = 6 * kRad; // of the wheel in a first engine file: 10 deg either way, evenly
constexpr double kMassSd = 0.06; // of the reciprocating mass in an engine file: 10 % either way, evenly

} // namespace

GasTorque::GasTorque(const EngineFile &engine, double least_unexplained) : engine_(engine), least_unexplained_(least_unexplained) {
    unknowns_ = {{"inertia", 0, 0, 0.1}, {"wheel offset", 0, kOffsetSd, 1 * kRad}, {"reciprocating mass", 0, kMassSd, kMassSd}};
}

void GasTorque::add_unexplained() {
    for (int i = 0; i < kUnexplained; ++i) unknowns_.push_back({"unexplained torque", 0, least_unexplained_, least_unexplained_});
    waves_.resize(kGridPoints, kUnexplained);
    for (int order = 1; order <= kUnexplainedOrders; ++order)
        for (int i = 0; i < kGridPoints; ++i) {
            waves_(i, 2 * order - 2) = std::cos(order * grid_deg(i) * kRad / 2);
            waves_(i, 2 * order - 1) = std::sin(order * grid_deg(i) * kRad / 2);
        }
}

const GasTorque::Arms &GasTorque::arms(double offset_rad) const {
    if (arms_.arm.size() > 0 && arms_.offset_rad == offset_rad) return arms_;
    const SliderCrank crank(engine_);
    const double step = 0.1 * kRad;
    arms_ = {offset_rad, Eigen::MatrixXd(kGridPoints, engine_.cylinders()), Eigen::MatrixXd(kGridPoints, engine_.cylinders())};
    for (Eigen::Index lane = 0; lane < engine_.cylinders(); ++lane)
        for (int i = 0; i < kGridPoints; ++i) {
            const double angle = (grid_deg(i) - tdc_deg(std::size_t(lane))) * kRad + offset_rad;
            arms_.arm(i, lane) = crank.volume_slope(angle) / crank.area;
            arms_.bend(i, lane) = (crank.volume_slope(angle + step) - crank.volume_slope(angle - step)) / (2 * step * crank.area);
        }
    return arms_;
}

CycleTorque GasTorque::torque(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const {
    const double inertia = engine_.inertia_kgm2 * std::exp(values(log_inertia)), offset = values(wheel_offset);
    const double share = engine_.reciprocating_mass_kg * (1 + values(ripple_mass)) / inertia;
    Nm nm = gas_nm(cycle, grid_s, values);
    const double rms = std::sqrt(nm.gas.squaredNorm() / kGridPoints);
    nm.slope.rightCols(kUnexplained) = rms * waves_;
    nm.gas += nm.slope.rightCols(kUnexplained) * values.tail(kUnexplained);
    CycleTorque result;
    result.gas_over_j = nm.gas / inertia;
    result.torque_slope = nm.slope / inertia;
    result.torque_slope.col(log_inertia) = -result.gas_over_j;
    const Eigen::MatrixXd &arm = arms(offset).arm, &bend = arms(offset).bend;
    const Eigen::VectorXd squares = arm.rowwise().squaredNorm();
    result.ripple = 1 + share * squares.array();
    result.ripple_slope = Eigen::MatrixXd::Zero(kGridPoints, values.size());
    result.ripple_slope.col(log_inertia) = -share * squares;
    result.ripple_slope.col(ripple_mass) = engine_.reciprocating_mass_kg / inertia * squares;
    result.ripple_slope.col(wheel_offset) = 2 * share * arm.cwiseProduct(bend).rowwise().sum();
    return result;
}

} // namespace sixdeg
