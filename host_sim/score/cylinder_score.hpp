// SPDX-License-Identifier: MIT
// The torque of each cylinder against the plant's own, over the last cycles of a run.
#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "plant/engine/engine_model.hpp"
extern "C" {
#include "sd_signals.h"
}

namespace sixdeg {

/// Means over the cycles measured, by physical cylinder. Percent are of the mean true torque of all cylinders.
struct CylinderFigures {
    int cycles;
    std::vector<double> true_nm, estimate_nm;
    std::vector<double> sd_nm;  ///< What the firmware says of its estimate.
    double mean_error_percent;  ///< Of the mean of all cylinders.
    double imbalance_percent;   ///< Largest error of a cylinder's difference from that mean.
    double imbalance_rms_percent; ///< The same over all cylinders.
};

class CylinderScore {
  public:
    /// Keeps the last `keep` cycles.
    CylinderScore(int cylinders, std::size_t keep) : cylinders_(std::size_t(cylinders)), keep_(keep) {}
    void truth(const CycleTruth &cycle);
    /// The firmware's cycle ended. Cycles that are invalid do not count.
    void estimate(const sd_signals_t &signals, std::uint8_t health);
    /// Nothing without a cycle of either, or without torque to compare with.
    std::optional<CylinderFigures> result() const;

  private:
    struct Estimate {
        double torque_nm, sd_nm;
    };
    struct Cylinder {
        std::deque<double> truth;
        std::deque<Estimate> estimate;
    };
    std::vector<Cylinder> cylinders_;
    std::size_t keep_;
};

} // namespace sixdeg
