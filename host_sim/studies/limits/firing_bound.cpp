// SPDX-License-Identifier: MIT
#include "studies/limits/firing_bound.hpp"

#include <cmath>

#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kDiffuse = 1e-2;  // weight of the start: a hundred times any sensible value
constexpr double kExact = 1e9;     // weight of what is known to be zero
constexpr int kCompressEvery = 15; // positions between two QR steps; the constant torque walks there

/// Square-root information R: R'R is the inverse of the posterior variance of
/// [phi, eps, constant, firings (n), q and v of each mode, sums (n), tooth errors (present)].
class Information {
  public:
    Information(const ToothModel &model, const BoundNoise &noise)
        : model_(model), noise_(noise), firings_(int(model.read_at.size())), tooth_of_(std::size_t(model.positions), -1) {
        sums_ = model.states();
        size_ = sums_ + firings_;
        for (int k = 0; noise.pattern_rad > 0 && k < model.positions; ++k) {
            if (model.present[std::size_t(k)]) tooth_of_[std::size_t(k)] = size_++;
        }
        VectorXd weight = VectorXd::Constant(size_, noise.pattern_rad > 0 ? 1 / noise.pattern_rad : 0);
        weight.head(sums_).setConstant(kDiffuse);
        weight.segment(sums_, firings_).setConstant(kExact);
        root_ = weight.asDiagonal();
    }

    /// From the tooth before to cycle position k: columns of the new state, given those of the old one.
    void predict(int k) {
        const double d = model_.pitch(), turn = d / model_.inertia_ratio[std::size_t(k % model_.positions)];
        for (int j = 0; j < 1 + firings_; ++j) {
            const double mean = d * model_.mean(k, j), moment = d * model_.moment(k, j);
            root_.col(2 + j) += root_.col(0) * (turn * (moment - mean)) - root_.col(1) * mean;
        }
        root_.col(1) += root_.col(0) * turn;
        for (std::size_t i = 0; i < model_.modes.size(); ++i) predict_mode(model_.modes[i], model_.mode_at(i), k);
    }

    void measure(int k) {
        root_.conservativeResize(root_.rows() + 1, Eigen::NoChange);
        root_.bottomRows(1).setZero();
        root_.bottomLeftCorner(1, sums_) = seen(model_) / noise_.edge_rad;
        const int tooth = tooth_of_[std::size_t(k % model_.positions)];
        if (tooth >= 0) root_(root_.rows() - 1, tooth) = 1 / noise_.edge_rad;
    }

    /// sum_i += firing i.
    void add_firing(int i) { root_.col(3 + i) -= root_.col(sums_ + i); }

    /// State `at` changes by an unknown step of this standard deviation; the step itself is marginalised out.
    void walk(int at, double deviation) {
        if (deviation == 0) return;
        MatrixXd wide = MatrixXd::Zero(root_.rows() + 1, size_ + 1);
        wide(0, 0) = 1;
        wide.bottomRightCorner(root_.rows(), size_) = root_;
        wide.col(0).tail(root_.rows()) = -deviation * root_.col(at);
        root_ = linalg::upper_triangle(wide).bottomRightCorner(size_, size_);
    }

    void compress() { root_ = linalg::upper_triangle(root_); }

    MatrixXd sums_variance() const {
        const MatrixXd inverse = linalg::inverse_of_triangle(root_.topRows(size_));
        return (inverse * inverse.transpose()).block(sums_, sums_, firings_, firings_);
    }

  private:
    /// (q - F, v) before is exp(-x A) of it after, which is the adjugate of exp(x A) over its determinant.
    void predict_mode(const ToothMode &mode, int at, int k) {
        const VectorXd q = root_.col(at), v = root_.col(at + 1);
        const double z = 2 * mode.damping, determinant = mode.a * (mode.a - z * mode.b) + mode.b * mode.b;
        root_.col(at) = (q * (mode.a - z * mode.b) + v * mode.b) / determinant;
        root_.col(at + 1) = (v * mode.a - q * mode.b) / determinant;
        const VectorXd held = q - root_.col(at);
        for (int j = 0; j < 1 + firings_; ++j) root_.col(2 + j) += held * (mode.compliance(j) * model_.mean(k, j));
    }

    const ToothModel &model_;
    const BoundNoise &noise_;
    int firings_, sums_, size_;
    std::vector<int> tooth_of_; // column of each tooth's own error
    MatrixXd root_;
};

} // namespace

double firing_bound(const ToothModel &model, const BoundNoise &noise, int mean_cycles, int window_cycles) {
    Information information(model, noise);
    const int firings = int(model.read_at.size());
    for (int cycle = 0; cycle < window_cycles; ++cycle) {
        for (int k = 0; k < model.cycle(); ++k) {
            information.predict(k);
            for (int i = 0; i < firings; ++i) {
                if (model.read_at[std::size_t(i)] == k && cycle >= window_cycles - mean_cycles) information.add_firing(i);
            }
            if (model.present[std::size_t(k % model.positions)]) information.measure(k);
            for (int i = 0; i < firings; ++i) {
                if (model.inject_at[std::size_t(i)] == k) information.walk(3 + i, noise.firing_change);
            }
            if (k % kCompressEvery == kCompressEvery - 1) information.walk(2, noise.constant_walk * std::sqrt(double(kCompressEvery)));
        }
    }
    information.compress();
    const MatrixXd less_mean = MatrixXd::Identity(firings, firings) - MatrixXd::Constant(firings, firings, 1.0 / firings);
    const MatrixXd variance = less_mean * information.sums_variance() * less_mean.transpose();
    return std::sqrt(variance.trace() / firings) / mean_cycles;
}

} // namespace sixdeg
