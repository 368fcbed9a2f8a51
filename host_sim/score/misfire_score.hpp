// SPDX-License-Identifier: MIT
// The misfire monitor's verdicts against the plant's own combustions.
//
//     MisfireScore score(engine);
//     score.said(crank_deg, cylinder, verdict);  // each firing the firmware judged
//     score.truth(cycle);                        // each combustion, in order of completion
//     score.result();
#pragma once
#include <cstdint>
#include <map>
#include <utility>

#include "common/engine_file.hpp"
#include "plant/engine/engine_model.hpp"

namespace sixdeg {

/// Limits that hold the true rate with 95 % confidence (Clopper and Pearson), for `hits` of `trials`.
struct RateBounds {
    double low, high;
};
RateBounds rate_bounds(std::uint64_t hits, std::uint64_t trials);

/// Firings that were judged and whose truth is known. Burned fraction below 0.5 is a misfire, below 0.9 a partial burn.
struct MisfireFigures {
    std::uint64_t healthy = 0, false_alarms = 0; ///< Healthy ones; of them called misfires.
    std::uint64_t missed = 0, detected = 0;      ///< Misfires; of them called so, of that cylinder.
    std::uint64_t wrong_cylinder = 0;            ///< Of the false alarms: a neighbour in firing order had the misfire, unnoticed.
    std::uint64_t partial = 0, partial_found = 0, partial_as_misfire = 0;
    std::uint64_t healthy_as_partial = 0;
    std::uint64_t not_judged = 0, not_judged_misfires = 0;
    double index_sum = 0, index_square_sum = 0;  ///< Of healthy firings.
    double missed_sum = 0, missed_square_sum = 0; ///< Of misfires.

    /// Distance of the two means over the mean of their deviations: what a limit can use. 0 without both.
    double separation() const;
    double healthy_sd() const, missed_sd() const; ///< Of the index; 0 without any.
};

class MisfireScore {
  public:
    explicit MisfireScore(const EngineFile &engine) : engine_(engine) {}

    /// A verdict (sd_verdict_t) heard at the true angle `crank_deg`, which never wraps; less than 720 deg after the TDC.
    void said(double crank_deg, int cylinder, int verdict, double index);
    void truth(const CycleTruth &cycle);
    /// Cycle of the firing of `cylinder` that a verdict heard at `crank_deg` is about.
    static std::int64_t cycle_of(const EngineFile &engine, double crank_deg, int cylinder);
    /// The verdict on a combustion; nullptr when there was none.
    const std::pair<int, double> *verdict(std::int64_t cycle, int cylinder) const;
    MisfireFigures result() const;

  private:
    std::int64_t firing_number(std::int64_t cycle, int cylinder) const;
    std::size_t lane(int cylinder) const { return lane_of(engine_, cylinder); }
    static std::size_t lane_of(const EngineFile &engine, int cylinder);
    EngineFile engine_;
    std::map<std::int64_t, std::pair<int, double>> said_; ///< By firing number: verdict, index.
    std::map<std::int64_t, double> burned_;               ///< By firing number.
};

} // namespace sixdeg
