// SPDX-License-Identifier: MIT
// Work of a cycle against the plant's own: indicated work of the last firing of every cylinder, each over the 720 deg about its TDC. The
// ecu knows no load, so both are taken less their means over the run; percent are of the mean true work.
#pragma once
#include <cstdint>
#include <map>
#include <optional>

#include "common/engine_file.hpp"
#include "plant/engine/engine_model.hpp"

namespace sixdeg {

struct WorkFigures {
    int cycles = 0;                 ///< Values scored, one a firing.
    double mean_j = 0;              ///< True indicated work of a cycle.
    double spread_percent = 0;      ///< Standard deviation of the true work.
    double correlation = 0;         ///< Of what is said with it; 0 where either does not vary.
    double rms_percent = 0;         ///< Of the difference.
    double stated_percent = 0;      ///< Rms of the standard deviations said.
    double change_rms_percent = 0;  ///< Of a firing against the same cylinder's a cycle before, of a firing's mean true work. 0: never
                                    ///< said.
};

class WorkScore {
  public:
    explicit WorkScore(const EngineFile &engine) : engine_(engine) {}

    /// What was said behind a firing, index into firing_order, at the true angle `crank_deg`, which never wraps. Not where it is invalid.
    void said(double crank_deg, std::size_t lane, double work_j, double sd_j, std::optional<double> change_j);
    void truth(const CycleTruth &cycle);
    /// The first 15 cycles are left out. Nothing with fewer than 10 values.
    std::optional<WorkFigures> result() const;

  private:
    struct Said {
        double work_j, sd_j;
        std::optional<double> change_j;
    };
    using Key = std::pair<std::int64_t, std::size_t>; // cycle of the plant, index into firing_order
    std::optional<double> true_work(Key last) const;
    EngineFile engine_;
    std::map<Key, Said> said_;
    std::map<Key, double> truth_;
};

} // namespace sixdeg
