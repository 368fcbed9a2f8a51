// SPDX-License-Identifier: MIT
#include "io/recording/revolution.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "io/recording/marks.hpp"
#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using linalg::MatrixXd;
using linalg::VectorXd;

constexpr int kOrderMax = 8;    // Of the revolution: eight cylinders and the first multiple of four.
constexpr int kTerms = 2 + 2 * kOrderMax;
constexpr std::size_t kLeastIntervals = 6;
// An interval shows the harmonic mean of the speed and the series has the plain one, so what lies between is put right in passes.
constexpr int kPasses = 3, kSteps = 12, kPoints = 8;
constexpr double kSlowest = 0.15; // Of the mean speed; a series that goes below is none of a turning crank.
constexpr double kFloor = 0.01;   // Relative: teeth are not cut better, and no model is.
// Where edges scatter so much (deviation of the medians), an interval so far from a spacing is a mark unseen or a tooth too many.
constexpr double kScatter = 0.015, kOdd = 0.4;
constexpr double kFirstSpread = 0.02, kLeastSpread = 1e-9, kAnyMean = 100, kFirstNoise = 1e-3; // Variances to begin with.
// With fewer teeth between marks, those beside a mark count too; otherwise they are left out, because a mark distorts them.
constexpr int kManyTeeth = 16;
constexpr double kPi = 3.14159265358979323846;

/// An interval of the revolution: where it lies, and the mean speed over it, both of the whole revolution.
struct Piece {
    double from, to, speed, sd;
    bool fitted;
};

std::vector<Piece> pieces_of(const Revolution &revolution, const std::vector<int> &missing) {
    const std::size_t slots = revolution.share.size();
    const int positions = int(slots) + std::accumulate(missing.begin(), missing.end(), 0);
    const bool many = slots / revolution.mark.size() >= kManyTeeth;
    std::vector<bool> left_out(slots, false);
    std::vector<int> width(slots, 1);
    for (std::size_t j = 0; j < revolution.mark.size(); ++j) {
        const std::size_t m = revolution.mark[j];
        width[m] += missing[j];
        left_out[m] = true;
        if (many) left_out[(m + 1) % slots] = left_out[(m + slots - 1) % slots] = true;
    }
    std::vector<Piece> pieces;
    double at = 0;
    for (std::size_t i = 0; i < slots; ++i) {
        const double to = at + double(width[i]) / positions;
        pieces.push_back({at, to, (to - at) / revolution.share[i], revolution.sd[i], !left_out[i]});
        at = to;
    }
    return pieces;
}

/// Means of the series' terms over a stretch of the revolution: 1, the trend, and cosine and sine of each order.
VectorXd terms(double from, double to) {
    VectorXd row(kTerms);
    row[0] = 1, row[1] = (from + to) / 2 - 0.5;
    for (int k = 1; k <= kOrderMax; ++k) {
        const double turn = 2 * kPi * k, middle = turn * (from + to) / 2, half = turn * (to - from) / 2;
        const double fade = half > 0 ? std::sin(half) / half : 1;
        row[2 * k] = fade * std::cos(middle);
        row[2 * k + 1] = fade * std::sin(middle);
    }
    return row;
}

/// A stretch as the series sees it.
struct Stretch {
    VectorXd mean;    ///< Of the terms over the stretch.
    MatrixXd within;  ///< The terms at points within it, a row each.

    Stretch(double from, double to) : mean(terms(from, to)), within(kPoints, kTerms) {
        for (int i = 0; i < kPoints; ++i) {
            const double at = from + (to - from) * (i + 0.5) / kPoints;
            within.row(i) = terms(at, at).transpose();
        }
    }
    /// What a clock makes of the speed over the stretch; 0 where the series comes near standstill.
    double harmonic_mean(const VectorXd &series) const {
        const VectorXd speed = within * series;
        return speed.minCoeff() < kSlowest ? 0 : kPoints / speed.cwiseInverse().sum();
    }
};

/// A fitted speed.
struct Course {
    VectorXd series = VectorXd::Zero(kTerms);
    VectorXd spread = VectorXd::Constant(kTerms, kFirstSpread); ///< Variance that each term is thought to have.
    MatrixXd covariance;
    double noise = 0; ///< Variance of an interval, relative.
};

/// One step of expectation and maximisation: the series for these variances, then the variances for this series.
void improve(Course &course, const MatrixXd &square, const MatrixXd &rows, const VectorXd &plain, double least_noise) {
    MatrixXd information = square / course.noise;
    information.diagonal() += course.spread.cwiseInverse();
    course.covariance = linalg::solve_symmetric(information, MatrixXd::Identity(kTerms, kTerms));
    course.series = course.covariance * (rows.transpose() * plain) / course.noise;
    course.spread[1] = std::max(kLeastSpread, course.series[1] * course.series[1] + course.covariance(1, 1));
    for (int k = 2; k < kTerms; k += 2) {
        const double power = course.series.segment(k, 2).squaredNorm() + course.covariance(k, k) + course.covariance(k + 1, k + 1);
        course.spread[k] = course.spread[k + 1] = std::max(kLeastSpread, power / 2);
    }
    const double known = course.covariance.cwiseProduct(square).sum();
    course.noise = std::max(least_noise, ((plain - rows * course.series).squaredNorm() + known) / double(plain.size()));
}

/// False where the intervals show no speed of a turning crank.
bool fit_course(const std::vector<Piece> &pieces, Course &course) {
    std::vector<const Piece *> used;
    for (const Piece &piece : pieces)
        if (piece.fitted) used.push_back(&piece);
    if (used.size() < kLeastIntervals) return false;
    MatrixXd rows(Eigen::Index(used.size()), kTerms);
    VectorXd plain(rows.rows()), shown(rows.rows());
    std::vector<Stretch> stretches;
    double least_noise = 0;
    for (Eigen::Index i = 0; i < rows.rows(); ++i) {
        const Piece &piece = *used[std::size_t(i)];
        stretches.emplace_back(piece.from, piece.to);
        rows.row(i) = stretches.back().mean.transpose();
        plain[i] = shown[i] = piece.speed;
        least_noise += std::max(piece.sd * piece.sd, kFloor * kFloor) / double(rows.rows());
    }
    const MatrixXd square = rows.transpose() * rows;
    course.spread[0] = kAnyMean, course.noise = kFirstNoise;
    for (int pass = 0; pass < kPasses; ++pass) {
        for (int step = 0; step < kSteps; ++step) improve(course, square, rows, plain, least_noise);
        for (Eigen::Index i = 0; i < rows.rows(); ++i) {
            const double harmonic = stretches[std::size_t(i)].harmonic_mean(course.series);
            if (!(harmonic > 0)) return false;
            plain[i] = shown[i] + rows.row(i).dot(course.series) - harmonic;
        }
    }
    return true;
}

/// Whether an interval that should be one spacing is none, by more than noise.
bool has_odd_interval(const std::vector<Piece> &pieces, const Course &course) {
    double scatter = 0, oddest = 0;
    for (const Piece &piece : pieces) {
        scatter += piece.sd / double(pieces.size());
        if (piece.fitted) oddest = std::max(oddest, std::abs(Stretch(piece.from, piece.to).harmonic_mean(course.series) / piece.speed - 1));
    }
    return scatter > kScatter && oddest > kOdd;
}

} // namespace

Revolution revolution_of(const std::vector<double> &interval_s, const std::vector<std::size_t> &before,
                         const std::vector<std::size_t> &ends, const std::vector<std::size_t> &mark) {
    Revolution revolution;
    if (ends.empty() || mark.empty()) return revolution;
    const std::size_t slots = ends.front() - before.front();
    std::vector<std::vector<double>> seen(slots);
    for (std::size_t k = 0; k < ends.size(); ++k) {
        double total = 0;
        for (std::size_t i = 0; i < slots; ++i) total += interval_s[before[k] + 1 + i];
        if (total <= 0) continue;
        for (std::size_t i = 0; i < slots; ++i) seen[i].push_back(interval_s[before[k] + 1 + i] / total);
    }
    if (seen.front().empty()) return revolution;
    for (std::vector<double> &shares : seen) {
        const double middle = median(shares), count = double(shares.size());
        if (!(middle > 0)) return {};
        for (double &share : shares) share = std::abs(share - middle);
        revolution.share.push_back(middle);
        revolution.sd.push_back(1.25 * 1.4826 * median(std::move(shares)) / middle / std::sqrt(count));
    }
    revolution.mark = mark;
    return revolution;
}

double least_pair(const Revolution &revolution) {
    const std::size_t slots = revolution.share.size();
    if (slots < 8) return 1;
    double least = 1;
    for (std::size_t i = 0; i < slots; ++i) {
        const auto at = [&](std::size_t ahead) { return revolution.share[(i + ahead) % slots]; };
        least = std::min(least, (at(1) + at(2)) / (2 * std::min(at(0), at(3))));
    }
    return least;
}

std::vector<MeasuredWidth> widths_of(const Revolution &revolution, const std::vector<int> &missing) {
    std::vector<MeasuredWidth> widths;
    if (revolution.share.empty()) return widths;
    const std::vector<Piece> pieces = pieces_of(revolution, missing);
    Course course;
    if (!fit_course(pieces, course)) return widths;
    if (has_odd_interval(pieces, course)) return {revolution.mark.size(), MeasuredWidth{std::nan(""), 0}};
    for (std::size_t j = 0; j < revolution.mark.size(); ++j) {
        const Piece &mark = pieces[revolution.mark[j]];
        const Stretch stretch(mark.from, mark.to);
        const double speed = stretch.harmonic_mean(course.series);
        if (!(speed > 0)) return {};
        const double model = stretch.mean.dot(course.covariance * stretch.mean) / (speed * speed);
        const double spacings = (1 + missing[j]) * speed / mark.speed;
        widths.push_back({spacings, spacings * std::sqrt(model + mark.sd * mark.sd)});
    }
    return widths;
}

} // namespace sixdeg
