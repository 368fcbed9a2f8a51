// SPDX-License-Identifier: MIT
// The estimate of each cylinder's mixture, and the fuel balance, against the plant's own. Figures:
// docs/afr.md.
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
};

/// From the last time the trims were allowed.
struct BalanceFigures {
    double spread_before_percent; ///< True, mean of the 4 cycles before.
    double cycles_to_3_percent;   ///< Until the true spread, mean of 4 cycles, is first below 3 %; -1 never.
    double residual_percent; ///< Mean over the last cycles of a cylinder's distance from the mean of all.
};

class AfrScore {
  public:
    explicit AfrScore(std::size_t keep) : keep_(keep) {}

    /// One cycle of the firmware; lambda by physical cylinder.
    void cycle(const std::vector<double> &truth, const std::vector<double> &estimate, double stated_sd,
               bool valid, bool balancing);
    std::optional<AfrFigures> estimate() const;
    std::optional<BalanceFigures> balance() const;

  private:
    struct Cycle {
        std::vector<double> truth, estimate;
        double stated_sd;
    };
    std::size_t keep_;
    std::deque<Cycle> kept_;
    std::vector<double> spread_,
        distance_;          ///< True, percent, of all cycles: largest less smallest; mean from the mean.
    std::size_t since_ = 0; ///< Index in spread_ where the trims were allowed last.
    bool balancing_ = false, ever_ = false;
};

} // namespace sixdeg
