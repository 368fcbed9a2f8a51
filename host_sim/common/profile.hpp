// SPDX-License-Identifier: MIT
// A quantity given at knots in time and straight between them.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace sixdeg {

/// Piecewise linear in x (mostly time, s), constant before the first and after the last knot. Immutable and
/// cheap to share: the caller keeps the cursor. At least one knot; x ascending (equal x is a step: the later
/// value holds there).
class Profile {
  public:
    struct Segment {
        double x0, x1, value0, slope; ///< value(x) = value0 + slope (x - x0) for x in [x0, x1).
        double at(double x) const { return value0 + slope * (x - x0); }
    };

    Profile() : Profile(0.0) {}
    explicit Profile(double constant) : Profile({0.0}, {constant}) {}
    Profile(std::vector<double> x, std::vector<double> value) : x_(std::move(x)), value_(std::move(value)) {}

    double at(double x) const { return segment(x).at(x); }
    double smallest() const { return *std::min_element(value_.begin(), value_.end()); }
    double largest() const { return *std::max_element(value_.begin(), value_.end()); }
    const std::vector<double> &x() const { return x_; }
    const std::vector<double> &value() const { return value_; }

    /// The piece that holds at x; its ends are +-1e300 outside the knots.
    Segment segment(double x) const {
        const auto after = std::size_t(std::upper_bound(x_.begin(), x_.end(), x) - x_.begin());
        if (after == 0) return {-1e300, x_.front(), value_.front(), 0};
        if (after == x_.size()) return {x_.back(), 1e300, value_.back(), 0};
        const double x0 = x_[after - 1], x1 = x_[after];
        return {x0, x1, value_[after - 1], (value_[after] - value_[after - 1]) / (x1 - x0)};
    }

    /// The same knots with every value multiplied by `factor`.
    Profile scaled(double factor) const {
        Profile result = *this;
        for (double &v : result.value_) v *= factor;
        return result;
    }

  private:
    std::vector<double> x_, value_;
};

} // namespace sixdeg
