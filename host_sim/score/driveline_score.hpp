// SPDX-License-Identifier: MIT
// What an ecu says of the driveline every 10 ms, against the simulated car. Figures: docs/results/driveline.md.
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

extern "C" {
#include "hal.h"
#include "sd_signals.h"
}

namespace sixdeg {

/// Of a whole run. Percent are of rows; a row is one saying of the driveline's signals.
struct DrivelineFigures {
    std::size_t rows = 0;
    std::size_t changes = 0;         ///< Of the true location.
    double told_percent = 0;         ///< Not invalid.
    double wrong_percent = 0;        ///< Of those told: another location than the true one.
    double torsion_rms_rad = 0;      ///< Error of those told.
    double moving_percent = 0;       ///< Of all: the shaft is said to move.
    double reference_told_percent = 0, reference_wrong_percent = 0; ///< Of document 003's observers.
    double largest_request_nm = 0;   ///< Of the damping, either way.
};

class DrivelineScore {
  public:
    explicit DrivelineScore(double tick_hz) : tick_hz_(tick_hz) {}
    /// The car at a time; times ascend.
    void truth(double time_s, int location, double twist_rad);
    /// An event of the ecu, in order. Truth up to its tick is known by now.
    void said(const sd_event_t &event);
    /// None without a row.
    std::optional<DrivelineFigures> result() const;

  private:
    struct Point {
        double time_s;
        int location;
        double twist_rad;
    };
    void finish_row(std::uint32_t tick);

    double tick_hz_;
    std::deque<Point> points_; ///< That a row to come may be of.
    struct {
        double location, torsion_rad, moving, request_nm, reference;
        bool told, reference_told;
    } row_{};
    std::size_t told_ = 0, wrong_ = 0, moving_ = 0, reference_told_ = 0, reference_wrong_ = 0;
    double squares_ = 0;
    DrivelineFigures figures_;
};

} // namespace sixdeg
