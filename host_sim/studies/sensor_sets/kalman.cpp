// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/kalman.hpp"

#include <cmath>
#include <limits>

#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Transition matrix and noise of one step: a short series, then doubling. Van Loan's exponential of one block
// matrix would hold exp(-A t) too, which overflows for an engine's stiff states.
void discretise(const MatrixXd &a, const MatrixXd &noise_rate, double step_s, MatrixXd &phi, MatrixXd &q) {
    const double norm = a.cwiseAbs().rowwise().sum().maxCoeff() * step_s;
    const int doublings = std::max(0, int(std::ceil(std::log2(norm / 0.01))));
    const double h = std::ldexp(step_s, -doublings);
    const Index n = a.rows();
    phi = MatrixXd::Identity(n, n);
    q = MatrixXd::Zero(n, n);
    MatrixXd power = phi, noise = noise_rate;
    for (int k = 1; k <= 6; ++k) {
        q += noise * (h / k);
        noise = (a * noise + noise * a.transpose()) * (h / k);
        power = power * a * (h / k);
        phi += power;
    }
    for (int i = 0; i < doublings; ++i) {
        q += phi * q * phi.transpose();
        phi = phi * phi;
    }
}

// Structure-preserving doubling: each round goes twice as many steps of the Riccati recursion. Sixty million
// steps tell what is steady from what is not, and are too few for a drifting variance to spoil the others by
// rounding.
constexpr int most_rounds = 26;
constexpr double steady_growth = 1e-9;

void solve_riccati(SteadyFilter &filter) {
    MatrixXd a = filter.phi.transpose(), g = filter.c.transpose() * linalg::solve_symmetric(filter.r, filter.c);
    MatrixXd &p = filter.predicted;
    p = filter.q;
    for (int round = 0; round < most_rounds; ++round) {
        const VectorXd before = p.diagonal();
        linalg::double_stretch(g, p, a);
        filter.growth = (p.diagonal() - before).cwiseAbs().cwiseQuotient(p.diagonal());
        if (filter.growth.maxCoeff() < steady_growth / 1000) break;
    }
}

// The sensors' own lags have no noise of their own.
MatrixXd noise_rate(const NumericModel &numeric, const Augmented &system) {
    MatrixXd rate = MatrixXd::Zero(system.a.rows(), system.a.rows());
    for (Index i = 0; i < numeric.process_noise.size(); ++i) {
        rate(i, i) = std::pow(numeric.process_noise[i] / system.scale[i], 2);
    }
    return rate;
}

} // namespace

SteadyFilter steady_filter(const SensorModel &model, const NumericModel &numeric, const LinearPoint &point,
                           SensorSet set) {
    const Augmented system = augment(model, point, numeric.scale, set);
    SteadyFilter filter;
    const MatrixXd a = system.scale.cwiseInverse().asDiagonal() * system.a * system.scale.asDiagonal();
    discretise(a, noise_rate(numeric, system), numeric.step_s, filter.phi, filter.q);
    // Outputs in units of their noise make R the identity.
    filter.c = system.c * system.scale.asDiagonal();
    filter.r = MatrixXd::Identity(filter.c.rows(), filter.c.rows());
    Index row = 0;
    for (std::size_t i = 0; i < model.sensors.size(); ++i) {
        if (set >> i & 1) filter.c.row(row++) /= model.sensors[i].noise;
    }
    solve_riccati(filter);
    const MatrixXd innovation = filter.c * filter.predicted * filter.c.transpose() + filter.r;
    const MatrixXd cp = filter.c * filter.predicted;
    filter.updated = filter.predicted - cp.transpose() * linalg::solve_symmetric(innovation, cp);
    return filter;
}

std::vector<double> steady_sigma(const SensorModel &model, const NumericModel &numeric,
                                 const LinearPoint &point, SensorSet set, const std::vector<int> &targets) {
    const SteadyFilter filter = steady_filter(model, numeric, point, set);
    std::vector<double> sigma;
    for (const int state : targets) {
        const bool steady = filter.growth[state] < steady_growth;
        const double variance =
            steady ? std::max(0.0, filter.updated(state, state)) : std::numeric_limits<double>::infinity();
        sigma.push_back(std::sqrt(variance) * numeric.scale[state]);
    }
    return sigma;
}

} // namespace sixdeg
