// SPDX-License-Identifier: MIT
// The torque estimate against the plant's own torque, over the last settled cycles of a run.
//
//     TorqueScore score(harmonics, steps_a_cycle, 20);
//     score.steps(truths);                          // every step of the plant
//     score.edge(crank_deg, true_nm, nm, settled);  // every crank edge
//     score.result();
//
// Memory is bounded by the cycles kept, whatever the length of the run.
#pragma once
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <vector>

#include "plant/engine/engine_model.hpp"

namespace sixdeg {

/// Percent are of the peak to peak of the true torque, averaged over the cycles measured.
struct TorqueFigures {
    int cycles;                    ///< Settled ones that went into it.
    double true_pp_nm;             ///< Peak to peak.
    double rms_true_percent;       ///< Estimate less truth, at the teeth.
    double rms_projection_percent; ///< Estimate less the truth's first n_h harmonics, at the teeth.
    double truncation_percent;     ///< What those harmonics leave out of the truth: the floor of any estimate
                                   ///< with n_h.
    double shift_deg;              ///< Crank angle by which the estimate comes after the truth.
};

class TorqueScore {
  public:
    /// `steps` of the plant a cycle; keeps the last `keep` settled cycles.
    TorqueScore(int harmonics, int steps, std::size_t keep)
        : harmonics_(harmonics), steps_(steps), keep_(keep) {}

    /// The net torque of steps one after the other, all of the plant's, ahead of the edges they hold.
    void steps(const std::vector<StepTruth> &truths);
    /// One crank edge at the true angle `crank_deg`, which never wraps. A cycle counts when every edge in it
    /// is `settled`: placed, and the estimate valid.
    void edge(double crank_deg, double true_nm, double estimate_nm, bool settled);
    /// Nothing when no cycle was settled.
    std::optional<TorqueFigures> result() const;

  private:
    struct Tooth {
        double angle_rad, true_nm, estimate_nm;
    };
    struct Cycle {
        std::vector<Tooth> teeth;
        std::vector<double> steps_nm;
    };
    void close();

    int harmonics_, steps_;
    std::size_t keep_;
    std::map<std::int64_t, std::vector<double>> steps_nm_; ///< Of cycles whose edges are still coming.
    std::int64_t cycle_ = INT64_MIN;
    bool settled_ = false;
    Cycle current_;
    std::deque<Cycle> kept_;
};

} // namespace sixdeg
