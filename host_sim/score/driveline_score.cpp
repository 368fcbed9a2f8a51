// SPDX-License-Identifier: MIT
#include "score/driveline_score.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

extern "C" {
#include "sd_status.h"
}

namespace sixdeg {
namespace {

double percent(std::size_t part, std::size_t of) { return of ? 100.0 * double(part) / double(of) : 0; }

} // namespace

void DrivelineScore::truth(double time_s, int location, double twist_rad) {
    figures_.changes += !points_.empty() && points_.back().location != location;
    points_.push_back({time_s, location, twist_rad});
}

void DrivelineScore::said(const sd_event_t &event) {
    const bool ours = event.channel >= SD_SIGNAL_DRIVELINE_LOCATION && event.channel <= SD_SIGNAL_DRIVELINE_REFERENCE_TORSION;
    if (event.kind != SD_EVENT_SIGNAL || !ours) return;
    float value;
    std::memcpy(&value, &event.value, sizeof value);
    const bool told = (event.flags & 0xff) != SD_INVALID;
    switch (event.channel) {
    case SD_SIGNAL_DRIVELINE_LOCATION: row_.location = double(value), row_.told = told; break;
    case SD_SIGNAL_DRIVELINE_TORSION: row_.torsion_rad = double(value); break;
    case SD_SIGNAL_DRIVELINE_MOVING: row_.moving = double(value); break;
    case SD_SIGNAL_DRIVELINE_DAMPING_REQUEST: row_.request_nm = double(value); break;
    case SD_SIGNAL_DRIVELINE_REFERENCE_LOCATION: row_.reference = double(value), row_.reference_told = told; break;
    case SD_SIGNAL_DRIVELINE_REFERENCE_TORSION: finish_row(event.tick); break; // the last that counts here
    default: break;
    }
}

void DrivelineScore::finish_row(std::uint32_t tick) {
    if (points_.empty()) return;
    const double wrap_s = 4294967296.0 / tick_hz_, at = tick / tick_hz_;
    const double time_s = at + wrap_s * std::round((points_.back().time_s - at) / wrap_s);
    while (points_.size() > 1 && points_[1].time_s <= time_s) points_.pop_front();
    const Point &truth = points_.front();
    ++figures_.rows;
    moving_ += row_.moving > 0.5;
    figures_.largest_request_nm = std::max(figures_.largest_request_nm, std::abs(row_.request_nm));
    if (row_.told) {
        ++told_;
        wrong_ += int(row_.location) != truth.location;
        squares_ += std::pow(row_.torsion_rad - truth.twist_rad, 2);
    }
    if (row_.reference_told) {
        ++reference_told_;
        reference_wrong_ += int(row_.reference) != truth.location;
    }
}

std::optional<DrivelineFigures> DrivelineScore::result() const {
    if (figures_.rows == 0) return std::nullopt;
    DrivelineFigures f = figures_;
    f.told_percent = percent(told_, f.rows);
    f.wrong_percent = percent(wrong_, told_);
    f.torsion_rms_rad = told_ ? std::sqrt(squares_ / double(told_)) : 0;
    f.moving_percent = percent(moving_, f.rows);
    f.reference_told_percent = percent(reference_told_, f.rows);
    f.reference_wrong_percent = percent(reference_wrong_, reference_told_);
    return f;
}

} // namespace sixdeg
