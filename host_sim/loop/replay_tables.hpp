// SPDX-License-Identifier: MIT
// teeth.csv, cycles.csv and firings.csv of `sixdeg replay`, written row by row. Columns: docs/files.md.
#pragma once
#include <array>
#include <ostream>
#include <vector>

#include "loop/cycle_work.hpp"
#include "loop/replay.hpp"

namespace sixdeg {

class ReplayTables : public ReplaySink {
  public:
    /// The streams outlive the tables. `firing_order`: physical cylinder numbers; `stoichiometric`: air to fuel, for lambda.
    ReplayTables(std::ostream &teeth, std::ostream &cycles, std::ostream &firings, std::vector<int> firing_order, double stoichiometric,
                 const CycleWork &work);
    void tooth(std::size_t index, const ToothRow &row) override;
    void cycle(std::size_t index, const CycleRow &row) override;
    void firing(std::size_t index, const FiringRow &row) override;
    void load(double nm) override { load_nm_ = nm; }

  private:
    struct Cylinder {
        double mean_nm = 0, mean_sd_nm = 0;
        std::uint8_t health = SD_INVALID;
    };
    std::ostream &teeth_, &cycles_, &firings_;
    std::vector<int> firing_order_;
    double stoichiometric_, load_nm_ = 0;
    CycleWork work_;
    std::array<Cylinder, 8> cylinders_{}; ///< The last firing of each, by physical number.
};

} // namespace sixdeg
