// SPDX-License-Identifier: MIT
// The estimate of each cylinder's mixture against the plant's own. Figures: docs/results/afr.md.
#pragma once
#include <cstddef>
#include <deque>
#include <optional>
#include <vector>

namespace sixdeg {

/// Points: 0.01 of the mean lambda (burned share). Over the last settled cycles of a run.
struct AfrFigures {
    int cycles;                    ///< Of valid estimates that went into it.
    double rms_points;             ///< Of the estimate's error, all cylinders.
    double bias_points;            ///< Largest mean error of a cylinder.
    double stated_points;          ///< Mean standard deviation that the filter stated.
    double spread_percent;         ///< True: largest less smallest cylinder, of the mean.
    double wrong_cylinder_percent; ///< Of cycles, where the estimate's farthest cylinder is not the true one;
                                   ///< 0 when balanced.
    std::vector<double> bias_by_cylinder; ///< Mean error of each cylinder, points.
};

/// Of values of all cylinders: largest less smallest, and the mean distance from their mean, percent of that mean.
double spread_percent(const std::vector<double> &x);
double distance_percent(const std::vector<double> &x);

class AfrScore {
  public:
    explicit AfrScore(std::size_t keep) : keep_(keep) {}

    /// One cycle of the firmware; lambda by physical cylinder.
    void cycle(const std::vector<double> &truth, const std::vector<double> &estimate, double stated_sd);
    std::optional<AfrFigures> estimate() const;

  private:
    struct Cycle {
        std::vector<double> truth, estimate;
        double stated_sd;
    };
    std::size_t keep_;
    std::deque<Cycle> kept_;
};

} // namespace sixdeg
