// SPDX-License-Identifier: MIT
// airpath.csv of `sixdeg run`: what is true in the air path, what the ecu reads of it, and what it says, every 10 ms. Columns:
// docs/theory/airpath.md.
#pragma once
#include <string>
#include <vector>

#include "plant/airpath/air_path.hpp"

extern "C" {
#include "hal.h"
#include "sd_signals.h"
}

namespace sixdeg {

class AirPathTable {
  public:
    AirPathTable();

    /// Begins a row.
    void row(const airpath::Readings &readings, const airpath::Truth &truth);
    /// Something the ecu has said since the row began; kept if it is of the owner "airpath".
    void said(const sd_event_t &event);
    bool empty() const { return rows_.empty(); }
    /// With a column for each signal of the owner "airpath"; empty until the ecu has said it once.
    std::string csv() const;

  private:
    struct Row {
        airpath::Readings readings;
        airpath::Truth truth;
        std::vector<float> said; ///< By entry of signals_; NaN while not said.
    };
    std::vector<std::uint16_t> signals_; ///< Channels.
    std::vector<Row> rows_;
};

} // namespace sixdeg
