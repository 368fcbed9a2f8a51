// SPDX-License-Identifier: MIT
// The fuel trims against what the plant's injectors and cylinders do. Figures: docs/results/afr.md.
#pragma once
#include <cstddef>
#include <optional>
#include <vector>

namespace sixdeg {

/// One cycle of the firmware; all by physical cylinder.
struct BalanceCycle {
    std::vector<double> lambda;   ///< True burned share.
    std::vector<double> trim;     ///< What the firmware adds to the fuel, over nominal.
    std::vector<double> injector; ///< What the injector gives of what it is told, 1 = all of it.
    bool on;                      ///< The trims were allowed.
    bool gave_up;                 ///< The firmware says that the loop runs the wrong way.
};

/// From the last time the trims were allowed. Spreads are true ones, largest less smallest lambda, of the mean.
struct BalanceFigures {
    double spread_before_percent;  ///< Mean of the 4 cycles before.
    double cycles_to_3_percent;    ///< Until the spread, mean of 4 cycles, is first below 3 %; -1 never.
    double largest_spread_percent; ///< Largest mean of 4 cycles.
    double residual_percent;       ///< Mean over the last cycles of a cylinder's distance from the mean of all.
    double wrong_way_percent;      ///< Largest growth of a trim's distance from where its injector needs it.
    double gave_up_cycles;         ///< Until the firmware gave up; -1 never.
};

class BalanceScore {
  public:
    explicit BalanceScore(std::size_t keep) : keep_(keep) {}

    void cycle(const BalanceCycle &cycle);
    /// None when the trims were never allowed, or for fewer than 4 cycles.
    std::optional<BalanceFigures> result() const;

  private:
    void take_trims(const BalanceCycle &cycle);

    std::size_t keep_;
    std::vector<double> spread_, distance_; ///< Percent, of all cycles: largest less smallest; mean from the mean.
    std::vector<double> least_;             ///< By cylinder: a trim's least distance since on.
    std::size_t since_ = 0;                 ///< Index in spread_ where the trims were allowed last.
    double wrong_way_ = 0, gave_up_ = -1;
    bool on_ = false, ever_ = false;
};

} // namespace sixdeg
