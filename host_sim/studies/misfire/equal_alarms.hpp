// SPDX-License-Identifier: MIT
// Detectors with unlike scores at equal false alarms: what each finds when its limit is put where it gives so many false alarms.
#pragma once
#include <cstdint>
#include <vector>

namespace sixdeg {

/// Scores of one detector at one condition of running, lower where a misfire is likelier.
class AlarmCurve {
  public:
    /// A firing; `judged` false: it is healthy for the detector at every limit.
    void add(double score, bool judged, bool misfire);
    /// Puts the scores in order; before found_at().
    void sort();
    struct Found {
        std::uint64_t found = 0, missed = 0; ///< Misfires found, of how many there are.
        std::uint64_t alarms = 0, healthy = 0; ///< False alarms, of how many healthy firings.
        Found &operator+=(const Found &other);
    };
    /// With the limit that lets no more than this share of healthy firings be false alarms, and finds most then.
    Found found_at(double false_share) const;

  private:
    std::vector<double> healthy_, missed_; ///< Scores of judged firings.
    std::uint64_t healthy_count_ = 0, missed_count_ = 0;
};

} // namespace sixdeg
