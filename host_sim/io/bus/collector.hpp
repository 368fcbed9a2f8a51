// SPDX-License-Identifier: MIT
// Truth and estimates as a third party hears them on a bus, put side by side in the tables of `sixdeg run`.
#pragma once
#include <vector>

#include "common/engine_file.hpp"
#include "io/events/ecu_feed.hpp"
#include "io/tables/run_tables.hpp"
extern "C" {
#include "sd_row.h"
}

namespace sixdeg {

class Collector {
  public:
    void said(const sd_event_t &event) { said_.push_back(event); }
    void truth(const sd_truth_t &truth);
    bool ended() const { return ended_; }

    /// Both streams come at their own pace, so they are matched once they are over.
    RunTables tables(const EngineFile &engine) const;
    /// Truth that was sent and did not come, and edges of which nobody spoke; after tables().
    std::size_t truth_lost() const;
    std::size_t unanswered() const { return unanswered_; }

  private:
    std::vector<sd_event_t> said_;
    std::vector<sd_truth_edge_t> edges_;
    std::vector<sd_truth_cycle_t> cycles_;
    sd_truth_end_t sent_{};
    bool ended_ = false;
    mutable std::size_t unanswered_ = 0;
};

} // namespace sixdeg
