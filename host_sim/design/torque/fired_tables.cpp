// SPDX-License-Identifier: MIT
#include "design/torque/fired_tables.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Directions of which less than this is seen count as hidden: what they would be read from is mostly noise.
constexpr double kHiddenBelow = 0.1;
/// By which the torque of a mg of fuel is another one at another speed and load: of all firings, which efficiency and friction move, and
/// of one against another, whose injectors differ alike. Judged, not measured; tried on other engines as far as tests have them.
constexpr double kCommonDoubt = 0.05, kApartDoubt = 0.01;

/// How late phase, energy and load at the start and each firing, over J_mean w^2, make every tooth: rad, [2 N][3 + firings].
MatrixXd lateness_of_parts(const EngineFile &engine, const KnownTorque &torque) {
    const auto [pulse_mean, pulse_moment] = interval_tables(engine, torque.basis);
    const auto rows = pulse_mean.rows(), firings = pulse_mean.cols();
    const double pitch = 2 * M_PI / engine.wheel.positions, inertia = mean_inertia_kgm2(engine);
    MatrixXd mean = MatrixXd::Zero(rows, 3 + firings), moment = mean, late = mean;
    mean.col(2).setConstant(1), moment.col(2).setConstant(0.5);
    mean.rightCols(firings) = pulse_mean, moment.rightCols(firings) = pulse_moment;
    Eigen::RowVectorXd at = Eigen::RowVectorXd::Zero(3 + firings), energy = at;
    at(0) = 1, energy(1) = 1;
    late.row(0) = at;
    for (int k = 1; k < rows; ++k) {
        at -= pitch * inertia / interval_inertia_kgm2(engine, k) * (energy + pitch * moment.row(k));
        energy += pitch * mean.row(k);
        late.row(k) = at;
    }
    for (int k : engine.wheel.missing) late.row(k).setZero(), late.row(k + engine.wheel.positions).setZero();
    return late;
}

/// Directions at right angles, the first of them along `first`, together as many as it has entries.
MatrixXd turned_to(const VectorXd &first) {
    const auto n = first.size();
    MatrixXd out(n, n);
    out.col(0) = first.normalized();
    for (Eigen::Index i = 1; i < n; ++i) {
        VectorXd best = VectorXd::Zero(n);
        for (Eigen::Index j = 0; j < n; ++j) { // the axis that is least among those that are there
            VectorXd axis = VectorXd::Unit(n, j);
            for (int twice = 0; twice < 2; ++twice) axis -= out.leftCols(i) * (out.leftCols(i).transpose() * axis);
            if (axis.norm() > best.norm()) best = axis;
        }
        out.col(i) = best.normalized();
    }
    return out;
}

/// Hidden patterns but the constant one, which is phase: columns over those of `half`.
MatrixXd hidden_directions(const MatrixXd &half, const MatrixXd &seen_by, const VectorXd &share, Eigen::Index hidden,
                           const EngineFile &engine) {
    MatrixXd directions(half.cols(), hidden);
    for (Eigen::Index i = 0; i < hidden; ++i) directions.col(i) = seen_by.col(i) * std::sqrt(2 / (1 - share(i)));
    VectorXd constant = VectorXd::Ones(half.rows());
    for (int k : engine.wheel.missing) constant(k) = 0;
    return directions * turned_to((half * directions).transpose() * constant).rightCols(hidden - 1);
}

} // namespace

FiredTables fired_tables(const EngineFile &engine, const KnownTorque &torque) {
    MatrixXd late = lateness_of_parts(engine, torque);
    const auto scale = late.colwise().norm().eval();
    for (Eigen::Index j = 0; j < late.cols(); ++j) late.col(j) /= scale(j);
    MatrixXd back = linalg::inverse_of_triangle(linalg::upper_triangle(late));
    FiredTables out;
    out.columns = late * back; // on whose right the parts are read: parts = back * (columns' L)
    for (Eigen::Index j = 0; j < late.cols(); ++j) back.row(j) /= scale(j);
    const auto n = engine.wheel.positions;
    const MatrixXd half = (out.columns.topRows(n) + out.columns.bottomRows(n)) / 2, taken = 2 * half.transpose() * half;
    // In ascending order of what is seen.
    const MatrixXd one = MatrixXd::Identity(taken.rows(), taken.rows());
    const linalg::Vibrations ways = linalg::vibrations(one - taken, VectorXd::Ones(taken.rows()));
    out.seen = ways.squared_radps2;
    const Eigen::Index hidden = (out.seen.array() < kHiddenBelow).count();
    out.restore = MatrixXd::Zero(taken.rows(), taken.rows());
    for (Eigen::Index i = hidden; i < taken.rows(); ++i)
        out.restore += 2 / out.seen(i) * ways.shapes.col(i) * ways.shapes.col(i).transpose();
    if (hidden < 2) return out;
    MatrixXd directions = hidden_directions(half, ways.shapes, out.seen, hidden, engine);
    const MatrixXd read = (back * taken).bottomRows(Eigen::Index(torque.basis.size())); // the firings of a pattern over the columns
    directions *= turned_to((read * directions).colwise().sum().transpose());
    const MatrixXd firings = read * directions, gram = firings.transpose() * firings;
    const MatrixXd dual = linalg::solve(gram, firings.transpose()).transpose();
    for (Eigen::Index i = 0; i < directions.cols(); ++i) {
        HiddenPattern hides;
        hides.pattern = directions.col(i), hides.of_firings = dual.col(i);
        hides.from_parts = back.bottomRows(firings.rows()).transpose() * dual.col(i);
        const VectorXd apart = firings.col(i).array() - firings.col(i).mean();
        hides.spread = apart.norm() / std::sqrt(double(apart.size()));
        hides.common = i == 0;
        out.hidden.push_back(hides);
    }
    return out;
}

void put_fired(const FiredTables &fired, sd_kalman_tables_t &t) {
    sd_kalman_word_t *to = t.pool + 2 * t.positions * t.row_words;
    for (int k = 0; k < t.positions; ++k) {
        for (int j = 0; j < t.parts; ++j, ++to) {
            for (int turn : {0, 1}) to->gain[turn] = std::int16_t(std::lround(fired.columns(k + turn * t.positions, j) * 32767));
        }
    }
    const auto put = [&](const Eigen::VectorXd &values) {
        for (double value : values) (to++)->value = float(value);
    };
    for (Eigen::Index j = 0; j < fired.restore.rows(); ++j) put(fired.restore.row(j));
    for (const HiddenPattern &hidden : fired.hidden) {
        put(hidden.pattern), put(hidden.from_parts), put(hidden.of_firings);
        (to++)->value = float(hidden.spread), (to++)->value = float(hidden.of_firings.lpNorm<1>());
        (to++)->value = float(hidden.common ? kCommonDoubt : kApartDoubt);
    }
}

} // namespace sixdeg
