// SPDX-License-Identifier: MIT
#include "design/torque/observer_map.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/linalg.hpp"

namespace sixdeg {

using Eigen::MatrixXd;

ObserverMap::ObserverMap(const EngineFile &engine, const sd_parameters_t &tune)
    : positions_(engine.wheel.positions), pitch_(2 * M_PI / positions_),
      gain_energy_(double(tune.torque_gain_energy_per_rad)), gain_(2 * int(tune.torque_harmonics) + 1),
      missing_(engine.wheel.missing) {
    gain_(0) = double(tune.torque_gain_mean_per_rad2);
    for (int i = 1; i < gain_.size(); ++i) gain_(i) = (i + 1) / 2 * double(tune.torque_gain_reference_per_rad2);
}

bool ObserverMap::measures(int k) const {
    const auto absent = [&](int p) {
        return std::find(missing_.begin(), missing_.end(), (p + positions_) % positions_) != missing_.end();
    };
    return !absent(k) && !absent(k - 1);
}

Eigen::VectorXd ObserverMap::basis(int k) const {
    Eigen::VectorXd f(gain_.size());
    f(0) = 1;
    for (int i = 1; 2 * i < f.size(); ++i) {
        f(2 * i - 1) = std::cos(i * pitch_ * k / 2);
        f(2 * i) = std::sin(i * pitch_ * k / 2);
    }
    return f;
}

void ObserverMap::step(int k, MatrixXd &state, const Eigen::RowVectorXd &energy) const {
    const Eigen::VectorXd f = basis(k);
    const auto n = gain_.size();
    if (measures(k)) {
        const Eigen::RowVectorXd error = state.row(0) - energy;
        state.row(0) -= pitch_ * gain_energy_ * error;
        state.bottomRows(n) -= pitch_ * gain_.cwiseProduct(f) * error;
    }
    state.row(0) += pitch_ * f.transpose() * state.bottomRows(n);
}

MatrixXd ObserverMap::run(MatrixXd state, const MatrixXd &energy) const {
    for (int k = 0; k < 2 * positions_; ++k) step(k, state, energy.row(k));
    return state;
}

MatrixXd ObserverMap::error_map() const {
    const auto n = gain_.size() + 1;
    return run(MatrixXd::Identity(n, n), MatrixXd::Zero(2 * positions_, n));
}

MatrixXd ObserverMap::settled(const MatrixXd &energy) const {
    const auto n = gain_.size() + 1;
    const MatrixXd driven = run(MatrixXd::Zero(n, energy.cols()), energy);
    return linalg::solve(MatrixXd::Identity(n, n) - error_map(), driven).bottomRows(n - 1);
}

MatrixXd ObserverMap::noise_covariance() const {
    // An error of tooth k changes the periods before and after it. No period reaches over the end of a cycle, where
    // teeth are missing, so the errors of one cycle end with it.
    const int cycle = 2 * positions_;
    MatrixXd energy = MatrixXd::Zero(cycle, cycle);
    for (int k = 0; k < cycle; ++k) {
        energy(k, k) = 1 / pitch_;
        if (k > 0) energy(k, k - 1) = -1 / pitch_;
    }
    const auto n = gain_.size() + 1;
    const MatrixXd driven = run(MatrixXd::Zero(n, cycle), energy);
    // The sum of Phi^m Q Phi^m' over all cycles past, by doubling.
    MatrixXd sum = driven * driven.transpose(), map = error_map();
    for (int i = 0; i < 30; ++i) {
        sum += (map * sum * map.transpose()).eval();
        map = (map * map).eval();
    }
    return sum.bottomRightCorner(n - 1, n - 1);
}

} // namespace sixdeg
