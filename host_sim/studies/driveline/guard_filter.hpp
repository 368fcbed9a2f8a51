// SPDX-License-Identifier: MIT
// The guard filter in either arithmetic, told and saying floats.
#pragma once
#include <cstdint>

extern "C" {
#include "sd_driveline_guard.h"
}

namespace sixdeg {

class GuardFilter {
  public:
    /// Throws InputError where the tables are refused.
    GuardFilter(const sd_driveline_tables_t &tables, bool fixed_point);
    void step(const sd_driveline_tooth_f32_t &tooth);
    void wheel(std::uint32_t since_ticks, std::uint16_t advance);
    const sd_driveline_out_f32_t &out() const { return out_; } ///< Of the last tooth.
    int rejected() const { return fixed_point_ ? q31_.rejected : f32_.rejected; }
    /// A fault: the filter believes in another torsion from now on.
    void put_twist(double twist_rad);

  private:
    sd_driveline_tables_t tables_;
    bool fixed_point_;
    sd_driveline_guard_f32_t f32_{};
    sd_driveline_guard_q31_t q31_{};
    sd_driveline_out_f32_t out_{};
};

} // namespace sixdeg
