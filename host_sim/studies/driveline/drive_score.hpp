// SPDX-License-Identifier: MIT
// What an estimate of the driveline's location and torsion was worth over a drive.
#pragma once
#include <vector>

#include "plant/vehicle/vehicle_model.hpp"
extern "C" {
#include "sd_driveline_guard.h"
}

namespace sixdeg {

struct DriveFigures {
    /// True ones while the estimate was told; not found within 100 ms; found where there was none.
    int transitions = 0, missed = 0, extra = 0;
    double delay_mean_s = 0, delay_rms_s = 0, delay_p95_s = 0; ///< p95: of its magnitude.
    double wrong_percent = 0;                   ///< Of the time that counts: settled, and in a gear.
    double twist_rms_rad = 0, shaft_rms_nm = 0; ///< The second at the crank.
    double bias_mean_nm = 0;
    double told_percent = 100; ///< Of the time in which the estimate was not invalid.
    int rejected = 0;
};

/// Truth and estimate as they come. Times ascend.
class DriveScore {
  public:
    void count_from(double from_s) { count_from_s_ = from_s; }
    /// h seconds up to now_s, at whose end the shaft is in `real`.
    void pass(double now_s, double h, Location real);
    void changed(const LocationChange &change);
    /// What is said at a tooth, weight_s after the last one, and how far off it is.
    void said(double now_s, double weight_s, const sd_driveline_out_f32_t &out, double twist_error_rad, double shaft_error_nm);
    DriveFigures figures() const;

  private:
    bool told_ = false;
    Location estimate_ = 0;
    std::vector<LocationChange> real_, found_; ///< While the estimate was told.
    double count_from_s_ = 5;
    double twist_squares_ = 0, shaft_squares_ = 0, bias_sum_ = 0, teeth_s_ = 0, counted_s_ = 0, wrong_s_ = 0, all_s_ = 0, invalid_s_ = 0;
};

} // namespace sixdeg
