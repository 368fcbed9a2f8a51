// SPDX-License-Identifier: MIT
#include "identify/crank_motion.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg {
namespace {

constexpr double kStep = kGridDeg * M_PI / 180, kCycle = 4 * M_PI;

/// Integral from the grid's beginning, by the trapezoidal rule, of each column.
template <typename Matrix> Matrix running_integral(const Matrix &values) {
    Matrix sum(values.rows(), values.cols());
    for (Eigen::Index column = 0; column < values.cols(); ++column) {
        sum(0, column) = 0;
        for (Eigen::Index i = 1; i < values.rows(); ++i)
            sum(i, column) = sum(i - 1, column) + kStep / 2 * (values(i - 1, column) + values(i, column));
    }
    return sum;
}

/// Row between two points of the grid.
struct GridPlace {
    Eigen::Index at;
    double share;
    explicit GridPlace(double deg) {
        const double x = (deg + 360) / kGridDeg;
        at = std::min<Eigen::Index>(Eigen::Index(x), kGridPoints - 2);
        share = x - double(at);
    }
    template <typename Matrix> auto of(const Matrix &m) const { return (1 - share) * m.row(at) + share * m.row(at + 1); }
};

/// By how many s each of the grid's points comes later for a unit of t0, e0, d and of each unknown.
Eigen::MatrixXd lateness_of_grid(const CycleTorque &torque, double start_energy, const Eigen::VectorXd &energy,
    const Eigen::VectorXd &slowness,
                                 double speed_radps) {
    const Eigen::Index unknowns = torque.torque_slope.cols();
    Eigen::MatrixXd more_energy(kGridPoints, unknowns + 3), by_ripple = Eigen::MatrixXd::Zero(kGridPoints, unknowns + 3);
    more_energy.col(0).setZero();
    more_energy.col(1).setConstant(start_energy);
    more_energy.col(2) = Eigen::VectorXd::LinSpaced(kGridPoints, 0, -start_energy);
    more_energy.rightCols(unknowns) = running_integral(torque.torque_slope);
    by_ripple.rightCols(unknowns) = torque.ripple_slope.array().colwise() * (slowness.array() / (2 * torque.ripple.array()));
    const Eigen::ArrayXd by_energy = -slowness.array() / (2 * energy.array());
    Eigen::MatrixXd late = running_integral(Eigen::MatrixXd((more_energy.array().colwise() * by_energy).matrix() + by_ripple));
    late.col(0).setConstant(1 / speed_radps);
    return late;
}

} // namespace

CycleStart steady_start(const WholeCycle &cycle) {
    const double speed = cycle.speed_radps;
    return {cycle.t_s.front() - (cycle.deg.front() + 360) * M_PI / 180 / speed, speed * speed / 2, 0};
}

Eigen::VectorXd grid_times(const WholeCycle &cycle, const Eigen::VectorXd &predicted_s, const Eigen::VectorXd &pattern_rad) {
    const auto deg = [&](std::size_t k) { return cycle.deg[k] + pattern_rad(cycle.position[k]) * 180 / M_PI; };
    const auto late = [&](std::size_t k) { return cycle.t_s[k] - GridPlace(deg(k)).of(predicted_s)(0); };
    Eigen::VectorXd times = predicted_s;
    double from = late(0), to = late(1);
    std::size_t k = 0; // on beyond the first and the last
    for (int i = 0; i < kGridPoints; ++i) {
        while (k + 2 < cycle.t_s.size() && deg(k + 1) < grid_deg(i)) ++k, from = to, to = late(k + 1);
        const double share = std::clamp((grid_deg(i) - deg(k)) / (deg(k + 1) - deg(k)), 0.0, 1.0);
        times(i) += from + (to - from) * share;
    }
    return times;
}

Eigen::VectorXd grid_times(const WholeCycle &cycle) {
    const CycleStart steady = steady_start(cycle);
    const Eigen::VectorXd even = Eigen::VectorXd::LinSpaced(kGridPoints, steady.t_s, steady.t_s + kCycle / cycle.speed_radps);
    return grid_times(cycle, even, Eigen::VectorXd::Zero(1 + *std::max_element(cycle.position.begin(), cycle.position.end())));
}

CycleLateness lateness(const WholeCycle &cycle, const CycleTorque &torque, const CycleStart &start) {
    const Eigen::Index unknowns = torque.torque_slope.cols();
    CycleLateness result;
    result.mean_energy = start.energy;
    const Eigen::VectorXd turned = Eigen::VectorXd::LinSpaced(kGridPoints, 0, kCycle);
    const Eigen::VectorXd energy = (running_integral(torque.gas_over_j) - start.drag_radps2 * turned).array() + start.energy;
    const Eigen::VectorXd slowness = (torque.ripple.array() / (2 * energy.array().max(1e-3 * start.energy))).sqrt();
    result.time_s = running_integral(slowness).array() + start.t_s;
    const Eigen::MatrixXd late = lateness_of_grid(torque, start.energy, energy, slowness, cycle.speed_radps);

    const auto teeth = Eigen::Index(cycle.t_s.size());
    result.late_rad.resize(teeth);
    result.over_start.resize(teeth, 3);
    result.over_unknowns.resize(teeth, unknowns);
    for (Eigen::Index k = 0; k < teeth; ++k) {
        const GridPlace place(cycle.deg[std::size_t(k)]);
        const double speed = 1 / place.of(slowness)(0);
        result.late_rad(k) = (cycle.t_s[std::size_t(k)] - place.of(result.time_s)(0)) * speed;
        const Eigen::RowVectorXd row = place.of(late) * speed;
        result.over_start.row(k) = row.head(3);
        result.over_unknowns.row(k) = row.tail(unknowns);
    }
    return result;
}

double drag_unit(const CycleLateness &scales) { return scales.mean_energy / kCycle; }

void move(CycleStart &start, const Eigen::Vector3d &by, const CycleLateness &scales, double speed_radps) {
    start.t_s += by(0) / speed_radps;
    start.energy += by(1) * scales.mean_energy;
    start.drag_radps2 += by(2) * drag_unit(scales);
}

} // namespace sixdeg
