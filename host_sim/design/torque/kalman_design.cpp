// SPDX-License-Identifier: MIT
#include "design/torque/kalman_design.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using Eigen::MatrixXd;
using StateColumn = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostStates, 1>;

bool present(const ToothModel &model, int k) { return model.present[std::size_t(k % model.positions)]; }

/// What a correction leaves of the error: (I - K h) error.
void correct(const Eigen::Ref<const Eigen::RowVectorXd, 0, Eigen::InnerStride<>> &gain, const StateRow &h, StateMatrix &error) {
    const StateRow shown = h.lazyProduct(error);
    error -= gain.transpose().lazyProduct(shown);
}

/// P <- A P A' + Q, P symmetric.
void predict_variance(const ToothModel &model, const ToothNoise &noise, int k, StateMatrix &p) {
    predict_error(model, k, p);
    p.transposeInPlace();
    predict_error(model, k, p);
    p(2, 2) += noise.constant_walk * noise.constant_walk;
    const int first = 3 + int(model.inject_at.size());
    for (int j = first; j < 2 + model.torques(); ++j) p(j, j) += noise.basis_walk * noise.basis_walk;
}

void inject(const ToothModel &model, const ToothNoise &noise, int k, StateMatrix &p) {
    for (std::size_t i = 0; i < model.inject_at.size(); ++i) {
        if (model.inject_at[i] == k) p(3 + int(i), 3 + int(i)) += noise.firing_change * noise.firing_change;
    }
}

/// One cycle of the Riccati recursion on p. at_tooth(k, column, s) sees each correction before it is made: p h' and its variance.
template <class AtTooth> void run_cycle(const ToothModel &model, const ToothNoise &noise, StateMatrix &p, AtTooth at_tooth) {
    const double r = noise.edge_rad * noise.edge_rad;
    const StateRow h = seen(model);
    for (int k = 0; k < model.cycle(); ++k) {
        predict_variance(model, noise, k, p);
        if (present(model, k)) {
            const StateColumn column = p * h.transpose();
            const double s = h * column + r;
            at_tooth(k, column, s);
            p -= column.lazyProduct(column.transpose()) / s;
        }
        p = (0.5 * (p + p.transpose())).eval();
        inject(model, noise, k, p);
    }
}

/// Variance at the start of a cycle, once it repeats from cycle to cycle. A cycle is a stretch as linalg::double_stretch has it; ten
/// doublings of it are a thousand cycles.
StateMatrix settled_variance(const ToothModel &model, const ToothNoise &noise) {
    constexpr int kMostDoublings = 20;
    const StateRow h = seen(model);
    const int n = model.states();
    StateMatrix e = StateMatrix::Zero(n, n), d = e, f = StateMatrix::Identity(n, n);
    int from = 0; // f is predicted with each tooth, and before the first of them for the positions without one
    const auto predict_to = [&](int k) {
        for (; from <= k; ++from) predict_error(model, from, f);
    };
    run_cycle(model, noise, e, [&](int k, const StateColumn &column, double s) {
        predict_to(k);
        const StateRow shown = h.lazyProduct(f);
        d += shown.transpose().lazyProduct(shown) / s;
        f -= column.lazyProduct(shown) / s;
    });
    predict_to(model.cycle() - 1);
    MatrixXd ends = e, tells = d, map = f;
    for (int i = 0; i < kMostDoublings && map.squaredNorm() > 1e-24; ++i) linalg::double_stretch(ends, tells, map);
    return ends;
}

/// How the error of every firing answers one timing error of 1 rad at cycle position `from`: [cycle][firing].
MatrixXd response(const ToothModel &model, const MatrixXd &gain, int from, int cycles) {
    const int firings = int(model.read_at.size());
    MatrixXd read = MatrixXd::Zero(cycles, firings);
    StateMatrix error = -gain.row(from).transpose();
    const StateRow h = seen(model);
    for (int step = 1; step <= (cycles - 1) * model.cycle(); ++step) {
        const int k = (from + step) % model.cycle(), cycle = (from + step) / model.cycle();
        predict_error(model, k, error);
        for (int i = 0; i < firings; ++i) {
            if (model.read_at[std::size_t(i)] == k) read(cycle, i) = error(3 + i);
        }
        if (present(model, k)) correct(gain.row(k), h, error);
        if (k == 0 && error.squaredNorm() < 1e-20 * gain.squaredNorm()) break; // it has died out
    }
    return read.colwise() - read.rowwise().mean();
}

/// Variance of the firings where they are read, with the walk and without timing errors, under given gains.
double load_variance(const ToothModel &model, const ToothNoise &noise, const MatrixXd &gain) {
    constexpr int kCycles = 40;
    const StateRow h = seen(model);
    StateMatrix p = StateMatrix::Zero(model.states(), model.states());
    double sum = 0;
    for (int step = 0; step < kCycles * model.cycle(); ++step) {
        const int k = step % model.cycle();
        predict_variance(model, {0, noise.constant_walk, 0, 0}, k, p);
        for (std::size_t i = 0; i < model.read_at.size(); ++i) {
            if (model.read_at[i] == k && step >= (kCycles - 1) * model.cycle()) sum += p(3 + int(i), 3 + int(i));
        }
        if (!present(model, k)) continue;
        correct(gain.row(k), h, p);
        p.transposeInPlace();
        correct(gain.row(k), h, p);
    }
    return sum / double(model.read_at.size());
}

double mean_square(const MatrixXd &values) { return values.squaredNorm() / double(values.cols()); }

void find_deviations(const ToothModel &model, int mean_cycles, PeriodicGains &gains) {
    constexpr int kCycles = 40; // Errors have died out by then, or the radius would be near 1.
    const int cycle = model.cycle();
    double single = 0, mean = 0, pattern = 0;
    for (int tooth = 0; tooth < model.positions; ++tooth) {
        if (!present(model, tooth)) continue;
        MatrixXd both = MatrixXd::Zero(1, int(model.read_at.size()));
        for (int from = tooth; from < cycle; from += model.positions) {
            const MatrixXd read = response(model, gains.gain, from, kCycles);
            single += mean_square(read);
            both += read.colwise().sum();
            MatrixXd window = MatrixXd::Zero(1, read.cols());
            for (int n = 0; n < kCycles + mean_cycles; ++n) {
                if (n < kCycles) window += read.row(n);
                if (n >= mean_cycles) window -= read.row(n - mean_cycles);
                mean += mean_square(window) / (mean_cycles * mean_cycles);
            }
        }
        pattern += mean_square(both);
    }
    gains.single_sd = std::sqrt(single), gains.mean_sd = std::sqrt(mean), gains.pattern_sd = std::sqrt(pattern);
}

} // namespace

ToothMode tooth_mode(double turn_rad, double damping, const Eigen::RowVectorXd &compliance) {
    const double root = std::sqrt(1 - damping * damping), decay = std::exp(-damping * turn_rad);
    const double b = decay * std::sin(root * turn_rad) / root;
    return {decay * std::cos(root * turn_rad) + damping * b, b, damping, compliance};
}

double ToothModel::pitch() const { return 2 * M_PI / positions; }

void predict_error(const ToothModel &model, int k, StateMatrix &error) {
    const double d = model.pitch(), j = model.inertia_ratio[std::size_t(k % model.positions)];
    const auto x = error.middleRows(2, model.torques());
    const StateRow mean = model.mean.row(k), moment = model.moment.row(k); // in one piece
    const StateRow lift = mean.lazyProduct(x), early = moment.lazyProduct(x);
    error.row(0) -= d / j * (error.row(1) + d * early);
    error.row(1) += d * lift;
    for (std::size_t i = 0; i < model.modes.size(); ++i) {
        const ToothMode &mode = model.modes[i];
        auto q = error.row(model.mode_at(i)), v = error.row(model.mode_at(i) + 1);
        const StateRow torque = mean.cwiseProduct(mode.compliance), held = torque.lazyProduct(x), away = q - held;
        q = held + mode.a * away + mode.b * v;
        v = mode.a * v - mode.b * (away + 2 * mode.damping * v);
    }
}

StateRow seen(const ToothModel &model) {
    StateRow h = StateRow::Zero(model.states());
    h(0) = 1;
    for (std::size_t i = 0; i < model.modes.size(); ++i) h(model.mode_at(i)) = -1;
    return h;
}

double cycle_radius(const ToothModel &model, const MatrixXd &gain) {
    StateMatrix map = StateMatrix::Identity(model.states(), model.states());
    const StateRow h = seen(model);
    for (int k = 0; k < model.cycle(); ++k) {
        predict_error(model, k, map);
        if (present(model, k)) correct(gain.row(k), h, map);
    }
    return linalg::spectral_radius(map);
}

MatrixXd steady_reading(const ToothModel &model, const MatrixXd &gain, const MatrixXd &mean, const MatrixXd &moment) {
    const double d = model.pitch();
    const StateRow h = seen(model);
    const auto firings = int(model.read_at.size()), others = model.torques() - 1 - firings;
    MatrixXd read = MatrixXd::Zero(firings + others, mean.cols());
    const auto cycle = [&](StateMatrix &error, bool driven) { // true less estimated
        for (int k = 0; k < model.cycle(); ++k) {
            predict_error(model, k, error);
            if (driven) {
                error.row(0) -= d * d / model.inertia_ratio[std::size_t(k % model.positions)] * moment.row(k);
                error.row(1) += d * mean.row(k);
                for (std::size_t i = 0; i < model.modes.size(); ++i) {
                    const ToothMode &mode = model.modes[i];
                    const StateRow held = mean.row(k).cwiseProduct(mode.compliance.segment(1, mean.cols()));
                    error.row(model.mode_at(i)) += (1 - mode.a) * held;
                    error.row(model.mode_at(i) + 1) += mode.b * held;
                }
            }
            for (std::size_t i = 0; driven && i < model.read_at.size(); ++i) {
                if (model.read_at[i] == k) read.row(int(i)) = -error.row(3 + int(i));
            }
            if (present(model, k)) error -= (gain.row(k).transpose() * (h * error)).eval();
        }
    };
    StateMatrix map = StateMatrix::Identity(model.states(), model.states());
    cycle(map, false);
    StateMatrix error = StateMatrix::Zero(model.states(), mean.cols());
    cycle(error, true);
    error = linalg::solve(MatrixXd(StateMatrix::Identity(model.states(), model.states()) - map), error);
    cycle(error, true);
    read.bottomRows(others) = -error.middleRows(3 + firings, others);
    return read;
}

PeriodicGains design_gains(const ToothModel &model, const ToothNoise &noise, int mean_cycles) {
    PeriodicGains gains;
    gains.gain = MatrixXd::Zero(model.cycle(), model.states());
    StateMatrix p = settled_variance(model, noise);
    double teeth = 0, innovation = 0;
    const double r = noise.edge_rad * noise.edge_rad;
    run_cycle(model, noise, p, [&](int k, const StateColumn &column, double s) {
        gains.gain.row(k) = column.transpose() / s;
        innovation += s / r, ++teeth;
    });
    gains.innovation = std::sqrt(innovation / teeth);
    gains.radius = cycle_radius(model, gains.gain);
    if (model.read_at.empty()) return gains;
    find_deviations(model, mean_cycles, gains);
    gains.load_sd = std::sqrt(load_variance(model, noise, gains.gain));
    return gains;
}

} // namespace sixdeg
