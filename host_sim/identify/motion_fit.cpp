// SPDX-License-Identifier: MIT
#include "identify/motion_fit.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using Eigen::Index, Eigen::MatrixXd, Eigen::VectorXd;

constexpr double kRad = M_PI / 180, kCycle_rad = 4 * M_PI;
constexpr int kIterations = 15, kIterationsWeighed = 5, kWeighings = 3;
constexpr double kConverged = 1e-3;          // of each unknown's unit
constexpr double kHuber = 3;                 // standard deviations
constexpr double kPatternPrior_rad = 1 * kRad; // no tooth stands further off
constexpr double kSpeedBin = 0.1;            // speeds so near count as one, relative
constexpr double kMostUnits = 2;             // of an unknown, in one iteration
constexpr double kDisturbed = 2.5;           // a cycle that is left so much worse than the median was disturbed: a load that stepped
constexpr std::size_t kLeastGroup = 5;       // cycles from which on what repeats can be told from what scatters

/// Columns of a cycle with what its own start can explain taken out, and that start's answer for each of them.
struct FreedCycle {
    VectorXd weight, late; ///< Roots of the weights; lateness, weighted and freed.
    MatrixXd columns;      ///< The same of the shared columns, each in its unit.
    MatrixXd answer;       ///< [3][1 + shared]: what the start takes up of the lateness and of each column.
    double energy_per_scatter; ///< Relative deviation of the start's energy for 1 rad of a tooth's.
};

class Fitter {
  public:
    Fitter(const EngineFile &engine, const GasTorque &gas, const std::vector<WholeCycle> &cycles)
        : engine_(engine), gas_(gas), cycles_(cycles), unknowns_(Index(gas.unknowns().size())) {
        column_of_.assign(std::size_t(engine.wheel.positions), -1);
        shared_ = unknowns_;
        for (int p = 0; p < engine.wheel.positions; ++p)
            if (!std::binary_search(engine.wheel.missing.begin(), engine.wheel.missing.end(), p)) column_of_[std::size_t(p)] = shared_++;
        values_.resize(unknowns_);
        units_ = VectorXd::Constant(shared_, 0.1 * kRad);
        for (Index q = 0; q < unknowns_; ++q) {
            values_(q) = gas.unknowns()[std::size_t(q)].start;
            units_(q) = gas.unknowns()[std::size_t(q)].unit;
        }
        pattern_ = VectorXd::Zero(shared_ - unknowns_);
        disturbed_.assign(cycles.size(), false);
        for (const WholeCycle &cycle : cycles) {
            starts_.push_back(steady_start(cycle));
            weights_.push_back(VectorXd::Ones(Index(cycle.t_s.size())));
            grid_s_.push_back(grid_times(cycle));
        }
    }

    MotionFit run() {
        // A pressure is read at the times of the teeth as the file has them, then once more with pattern and motion as found: read anew
        // each time, wheel and torque would chase one another.
        iterated(kIterations);
        const VectorXd pattern = pattern_by_position();
        for (std::size_t c = 0; c < cycles_.size(); ++c) grid_s_[c] = grid_times(cycles_[c], scales_[c].time_s, pattern);
        bool converged = iterated(kIterations);
        // Weights come last: what is far from its answer yet is no outlier.
        for (int i = 0; i < kWeighings; ++i) {
            weigh();
            converged = iterated(kIterationsWeighed);
        }
        share_ = size_of_unexplained();
        converged = iterated(kIterations);
        MotionFit fit;
        fit.converged = converged;
        spread(fit);
        fit.values = values_;
        fit.grid_s = grid_s_;
        fit.scatter_rad = scatter_;
        return fit;
    }

  private:
    bool iterated(int most) {
        for (int i = 0; i < most; ++i)
            if (iterate()) return true;
        return false;
    }

    VectorXd pattern_by_position() const {
        VectorXd pattern = VectorXd::Zero(engine_.wheel.positions);
        for (Index p = 0; p < engine_.wheel.positions; ++p)
            if (const Index column = column_of_[std::size_t(p)]; column >= 0) pattern(p) = pattern_(column - unknowns_);
        return pattern;
    }

    FreedCycle freed(std::size_t c) {
        const WholeCycle &cycle = cycles_[c];
        const CycleLateness late = lateness(cycle, gas_.torque(cycle, grid_s_[c], values_), starts_[c]);
        scales_[c] = late;
        const Index teeth = late.late_rad.size();
        FreedCycle out;
        out.weight = weights_[c];
        MatrixXd all(teeth, 1 + shared_);
        all.setZero();
        all.col(0) = late.late_rad;
        all.block(0, 1, teeth, unknowns_) = late.over_unknowns * units_.head(unknowns_).asDiagonal();
        for (Index k = 0; k < teeth; ++k) {
            const Index column = column_of_[std::size_t(cycle.position[std::size_t(k)])];
            all(k, 1 + column) = units_(column);
            all(k, 0) -= pattern_(column - unknowns_);
        }
        all = out.weight.asDiagonal() * all;
        const MatrixXd own = out.weight.asDiagonal() * late.over_start;
        const MatrixXd square = own.transpose() * own;
        out.answer = linalg::solve_symmetric(square, own.transpose() * all);
        out.energy_per_scatter = std::sqrt(linalg::solve_symmetric(square, MatrixXd::Identity(3, 3))(1, 1));
        all -= own * out.answer;
        out.late = all.col(0);
        out.columns = all.rightCols(shared_);
        return out;
    }

    /// Normal equations with what is known beforehand, over the square of the scatter.
    void add_priors(MatrixXd &normal, VectorXd &right) const {
        const double square = scatter_ * scatter_;
        for (Index q = 0; q < unknowns_; ++q) {
            const Unknown &unknown = gas_.unknowns()[std::size_t(q)];
            const double sd = share_ > 0 && q >= unknowns_ - kUnexplained ? share_ : unknown.prior_sd;
            if (sd <= 0) continue;
            const double weight = square * std::pow(units_(q) / sd, 2);
            normal(q, q) += weight;
            right(q) += weight * (unknown.start - values_(q)) / units_(q);
        }
        const Index teeth = shared_ - unknowns_;
        const double each = square * std::pow(units_(shared_ - 1) / kPatternPrior_rad, 2);
        const double mean = 1e6 * std::fmax(each, normal.diagonal().tail(teeth).mean());
        normal.bottomRightCorner(teeth, teeth).array() += mean / double(teeth); // their mean is 0: the rest is the cycle's own phase
        right.tail(teeth).array() -= mean / double(teeth) * pattern_.sum() / units_(shared_ - 1);
        for (Index t = unknowns_; t < shared_; ++t) normal(t, t) += each, right(t) -= each * pattern_(t - unknowns_) / units_(t);
    }

    bool iterate() {
        MatrixXd normal = MatrixXd::Zero(shared_, shared_);
        VectorXd right = VectorXd::Zero(shared_);
        freed_.clear();
        scales_.resize(cycles_.size());
        for (std::size_t c = 0; c < cycles_.size(); ++c) {
            freed_.push_back(freed(c));
            if (disturbed_[c]) continue;
            normal.selfadjointView<Eigen::Lower>().rankUpdate(freed_[c].columns.transpose());
            right += freed_[c].columns.transpose() * freed_[c].late;
        }
        normal = normal.selfadjointView<Eigen::Lower>();
        if (scatter_ == 0) scatter_ = rms_of(VectorXd::Zero(shared_)); // a first idea; the fit lowers it
        add_priors(normal, right);
        full_ = normal;
        right_ = right;
        const VectorXd change = shortened(solved(normal, right));
        scatter_ = rms_of(change);
        for (std::size_t c = 0; c < cycles_.size(); ++c) {
            const Eigen::Vector3d by = freed_[c].answer.col(0) - freed_[c].answer.rightCols(shared_) * change;
            move(starts_[c], by, scales_[c], cycles_[c].speed_radps);
        }
        values_ += (units_.cwiseProduct(change)).head(unknowns_);
        pattern_ += (units_.cwiseProduct(change)).tail(shared_ - unknowns_);
        change_ = change;
        return change.cwiseAbs().maxCoeff() < kConverged;
    }

    /// While it is not known how large it is the unexplained torque stays 0; then it is a part of the fit, as likely as it is large.
    MatrixXd solved(const MatrixXd &normal, const MatrixXd &right) const {
        if (share_ > 0) return linalg::solve_symmetric(normal, right);
        const Index count = kUnexplained, first = unknowns_ - count;
        MatrixXd held = normal;
        MatrixXd to = right;
        held.middleRows(first, count).setZero();
        held.middleCols(first, count).setZero();
        held.block(first, first, count, count).setIdentity();
        to.middleRows(first, count).setZero();
        return linalg::solve_symmetric(held, to);
    }

    /// No more than a few units at once: far from the answer the equations are not linear.
    VectorXd shortened(const VectorXd &change) const {
        const double most = change.head(unknowns_).cwiseAbs().maxCoeff();
        return most > kMostUnits ? VectorXd(change * (kMostUnits / most)) : change;
    }

    /// How large the unexplained torque is, so that what the fit has left is as likely as can be: the mean square of its coefficients, each
    /// with its variance, until it stays (expectation and maximisation).
    double size_of_unexplained() const {
        const Index count = kUnexplained, first = unknowns_ - count;
        double share = gas_.least_unexplained();
        for (int i = 0; i < 20; ++i) {
            MatrixXd normal = full_;
            for (Index q = first; q < unknowns_; ++q)
                normal(q, q) += scatter_ * scatter_ * units_(q) * units_(q) * (1 / (share * share)
                                                                               - 1 / std::pow(gas_.least_unexplained(), 2));
            MatrixXd wanted = MatrixXd::Zero(shared_, count + 1);
            wanted.col(count) = right_;
            wanted.block(first, 0, count, count).setIdentity();
            const MatrixXd solution = linalg::solve_symmetric(normal, wanted);
            double square = 0;
            for (Index q = 0; q < count; ++q) {
                const double unit = units_(first + q);
                square += unit * unit * (std::pow(solution(first + q, count), 2) + scatter_ * scatter_ * solution(first + q,
                    q)) / double(count);
            }
            share = std::fmax(std::sqrt(square), gas_.least_unexplained());
        }
        return share;
    }

    VectorXd left(std::size_t c, const VectorXd &change) const { return freed_[c].late - freed_[c].columns * change; }

    /// Of what is left, for as many degrees of freedom as there are.
    double rms_of(const VectorXd &change) const {
        double sum = 0, count = -double(shared_);
        for (std::size_t c = 0; c < cycles_.size(); ++c) {
            if (disturbed_[c]) continue;
            sum += left(c, change).squaredNorm();
            count += freed_[c].weight.squaredNorm() - 3;
        }
        return std::sqrt(sum / std::fmax(count, 1));
    }

    /// Teeth that stand out count less, cycles that stand out among those of their speed not at all.
    void weigh() {
        const auto before = groups(true);
        for (const auto &group : before) {
            std::vector<double> rms;
            for (std::size_t c : group) rms.push_back(left(c, change_).norm());
            std::vector<double> sorted = rms;
            std::nth_element(sorted.begin(), sorted.begin() + std::ptrdiff_t(sorted.size() / 2), sorted.end());
            for (std::size_t i = 0; i < group.size(); ++i) {
                const double usual = group.size() >= kLeastGroup ? sorted[sorted.size() / 2]
                    : scatter_ * std::sqrt(double(weights_[group[i]].size()));
                disturbed_[group[i]] = rms[i] > kDisturbed * usual;
            }
        }
        for (std::size_t c = 0; c < cycles_.size(); ++c) {
            const VectorXd rest = left(c, change_).cwiseAbs();
            for (Index k = 0; k < rest.size(); ++k) {
                const double off = rest(k) / freed_[c].weight(k) / scatter_;
                weights_[c](k) = off > kHuber ? std::sqrt(kHuber / off) : 1;
            }
        }
    }

    /// Cycles of about one speed and of one kind, each in the order of time; firing ones first, then by speed.
    std::vector<std::vector<std::size_t>> groups(bool disturbed_too = false) const {
        std::vector<std::size_t> order;
        for (std::size_t c = 0; c < cycles_.size(); ++c)
            if (disturbed_too || !disturbed_[c]) order.push_back(c);
        std::stable_sort(order.begin(), order.end(), [this](std::size_t a, std::size_t b) {
            return std::tie(cycles_[a].motored, cycles_[a].speed_radps) < std::tie(cycles_[b].motored, cycles_[b].speed_radps);
        });
        std::vector<std::vector<std::size_t>> by;
        for (std::size_t c : order) {
            const WholeCycle *slowest = by.empty() ? nullptr : &cycles_[by.back().front()];
            if (!slowest || slowest->motored != cycles_[c].motored || cycles_[c].speed_radps > (1 + kSpeedBin) * slowest->speed_radps)
                by.emplace_back();
            by.back().push_back(c);
        }
        for (auto &group : by) std::sort(group.begin(), group.end());
        return by;
    }

    /// Adds what repeats in a group of cycles to the covariance.
    void add_repeating(const std::vector<std::size_t> &group, const MatrixXd &inverse, MatrixXd &covariance, double &square) const {
        const Index teeth = freed_[group.front()].late.size();
        VectorXd mean = VectorXd::Zero(teeth);
        MatrixXd columns = MatrixXd::Zero(teeth, shared_);
        for (std::size_t c : group) {
            mean += left(c, change_) / double(group.size());
            columns += freed_[c].columns;
        }
        const double excess = mean.squaredNorm() / double(teeth) - scatter_ * scatter_ / double(group.size());
        if (excess <= 0) return;
        square += excess * double(group.size());
        double neighbours = 1; // an error that lasts over several teeth does more than one of single teeth
        for (Index lag = 1; lag <= 12; ++lag) {
            const double together = mean.head(teeth - lag).dot(mean.tail(teeth - lag)) / mean.squaredNorm();
            if (together < 0.05) break;
            neighbours += 2 * together;
        }
        const MatrixXd effect = inverse * columns.transpose();
        covariance += excess * neighbours * effect * effect.transpose();
    }

    void spread(MotionFit &fit) const {
        const MatrixXd inverse = solved(full_, MatrixXd::Identity(shared_, shared_));
        MatrixXd covariance = scatter_ * scatter_ * inverse;
        fit.unexplained_share = share_;
        double square = 0;
        for (const auto &group : groups())
            if (group.size() >= kLeastGroup) add_repeating(group, inverse, covariance, square);
        fit.repeating_rad = std::sqrt(square / double(cycles_.size()));
        const MatrixXd scaled = units_.asDiagonal() * covariance * units_.asDiagonal();
        fit.covariance = scaled.topLeftCorner(unknowns_, unknowns_);
        fit.pattern_rad = pattern_by_position();
        fit.pattern_sd = VectorXd::Zero(engine_.wheel.positions);
        for (Index p = 0; p < engine_.wheel.positions; ++p) {
            const Index column = column_of_[std::size_t(p)];
            if (column < 0) continue;
            fit.pattern_sd(p) = std::sqrt(scaled(column, column));
        }
        for (const auto &group : groups())
            if (group.size() >= kLeastGroup)
                if (DragFound drag = drag_of(group, covariance); !drag.cycles.empty()) fit.drag.push_back(std::move(drag));
        fit.disturbed = std::size_t(std::count(disturbed_.begin(), disturbed_.end(), true));
    }

    /// The next cycle begins where this one ends.
    bool goes_on(std::size_t c, std::size_t next) const {
        if (next != c + 1) return false;
        const WholeCycle &a = cycles_[c], &b = cycles_[next];
        const double turned = (b.t_s.front() - a.t_s.back()) * (a.speed_radps + b.speed_radps) / 2;
        return turned < 2 * (720 - a.deg.back() + a.deg.front()) * kRad;
    }

    /// By the balance of energy from the beginning of each cycle to that of the next: what gas torque gave and energy does not show.
    /// What of the unexplained torque has no mean does not count in it, as it would in how the speed bends within a cycle. The mean of
    /// a model's error nobody sees: it is taken to be as large as each harmonic.
    DragFound drag_of(const std::vector<std::size_t> &group, const MatrixXd &covariance) const {
        DragFound found{0, cycles_[group.front()].motored, {}, 0, 0, {}};
        VectorXd slope = VectorXd::Zero(shared_);
        double noise = 0, count = 0, square_of_gas = 0;
        for (std::size_t i = 0; i + 1 < group.size(); ++i) {
            const std::size_t c = group[i], next = group[i + 1];
            if (!goes_on(c, next)) continue;
            const CycleTorque torque = gas_.torque(cycles_[c], grid_s_[c], values_);
            found.rpm += cycles_[c].speed_radps * 30 / M_PI;
            found.cycles.push_back({starts_[c].t_s, starts_[next].t_s});
            found.over_inertia += torque.gas_over_j.mean() - (starts_[next].energy - starts_[c].energy) / kCycle_rad;
            square_of_gas += torque.gas_over_j.squaredNorm() / kGridPoints;
            slope.head(unknowns_) += units_.head(unknowns_).cwiseProduct(torque.torque_slope.colwise().mean().transpose());
            slope += (energy_answer(next) - energy_answer(c)) / kCycle_rad;
            // The beginnings between two cycles of a row do not count, its first and its last do.
            if (i == 0 || !goes_on(group[i - 1], c)) noise += std::pow(energy_noise(c), 2);
            if (i + 2 == group.size() || !goes_on(next, group[i + 2])) noise += std::pow(energy_noise(next), 2);
            count += 1;
        }
        found.rpm /= count;
        found.over_inertia /= count;
        slope /= count;
        const double unexplained = gas_.is_model() ? share_ * share_ * square_of_gas / count : 0;
        found.over_inertia_sd = std::sqrt(slope.dot(covariance * slope) + noise / std::pow(kCycle_rad * count, 2) + unexplained);
        found.slope = slope.head(unknowns_).cwiseQuotient(units_.head(unknowns_));
        return found;
    }

    /// How the start's energy answers the shared columns, rad2/s2.
    VectorXd energy_answer(std::size_t c) const { return freed_[c].answer.row(1).tail(shared_).transpose() * scales_[c].mean_energy; }
    double energy_noise(std::size_t c) const { return scatter_ * freed_[c].energy_per_scatter * scales_[c].mean_energy; }

    const EngineFile &engine_;
    const GasTorque &gas_;
    const std::vector<WholeCycle> &cycles_;
    Index unknowns_, shared_ = 0;
    std::vector<Index> column_of_; ///< Of each position of the wheel; -1 without a tooth.
    VectorXd values_, units_, pattern_, change_;
    std::vector<CycleStart> starts_;
    std::vector<bool> disturbed_; ///< Cycles that are left out.
    std::vector<VectorXd> weights_, grid_s_;
    std::vector<FreedCycle> freed_;
    std::vector<CycleLateness> scales_;
    VectorXd right_;
    MatrixXd full_;
    double scatter_ = 0; ///< rad
    double share_ = 0;   ///< Of the unexplained torque; 0 while it is held at 0.
};

} // namespace

MotionFit fit_motion(const EngineFile &engine, const GasTorque &gas, const std::vector<WholeCycle> &cycles) {
    return Fitter(engine, gas, cycles).run();
}

} // namespace sixdeg
