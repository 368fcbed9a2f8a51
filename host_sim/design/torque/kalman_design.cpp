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

constexpr int kCycles = 40; // Errors have died out by then, or the radius would be near 1.

/// How far each firing is off where it is read, by what happened up to kCycles before.
struct Memory {
    std::vector<MatrixXd> edge; ///< [cycles before][cycle position][firing] by a timing error of 1 rad there.
    double load = 0;            ///< By a step of 1 of the constant torque at every tooth: sum of squares, over all firings.
};

/// Rows of `back` say how something depends on the error behind tooth k's prediction; afterwards, on the error before it.
void predict_back(const ToothModel &model, int k, StateMatrix &back) {
    const double d = model.pitch(), turn = d / model.inertia_ratio[std::size_t(k % model.positions)];
    const StateRow mean = model.mean.row(k), moment = model.moment.row(k);
    auto x = back.middleCols(2, model.torques());
    x += (d * back.col(1)).lazyProduct(mean) - (d * turn * back.col(0)).lazyProduct(moment);
    back.col(1) -= turn * back.col(0);
    for (std::size_t i = 0; i < model.modes.size(); ++i) {
        const ToothMode &mode = model.modes[i];
        const StateColumn q = back.col(model.mode_at(i)), v = back.col(model.mode_at(i) + 1);
        const StateRow torque = mean.cwiseProduct(mode.compliance);
        x += (q * (1 - mode.a) + v * mode.b).lazyProduct(torque);
        back.col(model.mode_at(i)) = mode.a * q - mode.b * v;
        back.col(model.mode_at(i) + 1) = mode.b * q + (mode.a - 2 * mode.damping * mode.b) * v;
    }
}

/// Goes back from where the firings are read: so few rows instead of one error forward from each tooth.
Memory memory(const ToothModel &model, const MatrixXd &gain) {
    const int firings = int(model.read_at.size()), cycle = model.cycle();
    Memory out{std::vector<MatrixXd>(kCycles, MatrixXd::Zero(cycle, firings)), 0};
    StateMatrix back = StateMatrix::Zero(firings, model.states());
    const StateRow h = seen(model);
    for (int before = 0; before < kCycles; ++before) {
        for (int k = cycle - 1; k >= 0; --k) {
            if (present(model, k)) {
                const StateColumn shown = -(back * gain.row(k).transpose());
                for (int i = 0; i < firings; ++i) { // of whole cycles
                    if (before < kCycles - 1 || k >= model.read_at[std::size_t(i)]) out.edge[std::size_t(before)](k, i) = shown(i);
                }
                back += shown.lazyProduct(h);
            }
            for (int i = 0; before == 0 && i < firings; ++i) {
                if (model.read_at[std::size_t(i)] == k) back(i, 3 + i) = 1;
            }
            out.load += back.col(2).squaredNorm();
            predict_back(model, k, back);
        }
        if (back.squaredNorm() < 1e-24) break; // it has died out
    }
    return out;
}

double mean_square(const MatrixXd &values) { return values.squaredNorm() / double(values.cols()); }

/// Firings less their mean, by an error of 1 rad at one tooth: [cycle][firing]. Of one cylinder the firing itself.
MatrixXd response(const Memory &memory, int from) {
    MatrixXd read(kCycles, memory.edge[0].cols());
    for (int cycle = 0; cycle < kCycles; ++cycle) read.row(cycle) = memory.edge[std::size_t(cycle)].row(from);
    if (read.cols() > 1) read.colwise() -= read.rowwise().mean().eval();
    return read;
}

void find_deviations(const ToothModel &model, const ToothNoise &noise, int mean_cycles, PeriodicGains &gains) {
    const Memory known = memory(model, gains.gain);
    const int firings = int(model.read_at.size());
    double single = 0, mean = 0, pattern = 0;
    for (int tooth = 0; tooth < model.positions; ++tooth) {
        if (!present(model, tooth)) continue;
        MatrixXd both = MatrixXd::Zero(1, firings);
        for (int from = tooth; from < model.cycle(); from += model.positions) {
            const MatrixXd read = response(known, from);
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
    gains.load_sd = noise.constant_walk * std::sqrt(known.load / firings);
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
    find_deviations(model, noise, mean_cycles, gains);
    return gains;
}

} // namespace sixdeg
