// SPDX-License-Identifier: MIT
// teeth.csv, cycles.csv, firings.csv and work.csv of `sixdeg replay`, written row by row. Columns: docs/reference/files.md.
#pragma once
#include <array>
#include <ostream>
#include <vector>

#include "loop/replay.hpp"

namespace sixdeg {

/// Where the tables go.
struct ReplayStreams {
    std::ostream &teeth, &cycles, &firings, &work;
};

/// Of the engine, for the tables.
struct ReplayEngine {
    std::vector<int> firing_order; ///< Physical cylinder numbers.
    double stoichiometric = 0;     ///< Air to fuel, for lambda.
    bool inertia_known = false;    ///< Whether work has a scale.
};

class ReplayTables : public ReplaySink {
  public:
    /// The streams outlive the tables.
    ReplayTables(const ReplayStreams &streams, const ReplayEngine &engine);
    void tooth(std::size_t index, const ToothRow &row) override;
    void cycle(std::size_t index, const CycleRow &row) override;
    void firing(std::size_t index, const FiringRow &row) override;
    void work(std::size_t index, const WorkRow &row) override;
    void load(double nm) override { load_nm_ = nm; }

  private:
    struct Cylinder {
        double mean_nm = 0, mean_sd_nm = 0;
        std::uint8_t health = SD_INVALID;
    };
    ReplayStreams to_;
    ReplayEngine engine_;
    double load_nm_ = 0;
    std::array<Cylinder, 8> cylinders_{}; ///< The last firing of each, by physical number.
};

} // namespace sixdeg
