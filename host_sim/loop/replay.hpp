// SPDX-License-Identifier: MIT
// Recorded edges through HAL, ecu, decoder and torque observer; what the ecu says, row by row.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "loop/ecu_bench.hpp"

namespace sixdeg {

/// What the ecu said of one crank edge. Values as in hal/signals.toml.
struct ToothRow {
    double t_s;
    sd_signals_t signals;
    std::uint8_t crank_health, torque_health; ///< sd_health_t
};

/// What it said at the end of a cycle.
struct CycleRow {
    double t_s;
    sd_signals_t signals;
    std::uint8_t health; ///< Of the cylinders.
};

struct ReplayResult {
    std::vector<ToothRow> teeth; ///< One a crank edge, in order.
    std::vector<CycleRow> cycles;
    sd_crank_counts_t counts;
    std::vector<double> mark_spacings; ///< Learned width of each mark, in tooth spacings.
    std::optional<std::size_t> first_sync_edge;
    std::size_t revolutions = 0;      ///< Whole revolutions from tooth 0 to tooth 0 in sync.
    std::optional<double> rpm_last;   ///< Mean over the last of them.
};

/// Gathers the rows while edges go through a bench.
class ReplayRows {
  public:
    void reserve(std::size_t edges) { result_.teeth.reserve(edges); }
    /// The bench has just answered a crank edge.
    void edge(double t_s, bool cycle_ended, const EcuBench &bench);
    ReplayResult finish(const EcuBench &bench);

  private:
    ReplayResult result_;
};

/// Feeds crank and cam edges (ascending times, s) and a time event every 10 ms to a fresh ecu through the in-process
/// port. Throws InputError naming `file` when times do not fit the engine's capture timer.
ReplayResult replay(const std::string &file, const std::vector<double> &crank_s, const std::vector<double> &cam_s,
                    const sd_calibration_t &calibration);

std::string teeth_csv(const ReplayResult &result);
std::string cycles_csv(const ReplayResult &result, const std::vector<int> &firing_order);

} // namespace sixdeg
