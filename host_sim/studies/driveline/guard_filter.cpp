// SPDX-License-Identifier: MIT
#include "studies/driveline/guard_filter.hpp"

#include "common/error.hpp"

namespace sixdeg {

GuardFilter::GuardFilter(const sd_driveline_tables_t &tables, bool fixed_point) : tables_(tables), fixed_point_(fixed_point) {
    const sd_result_t result = fixed_point ? sd_driveline_guard_init_q31(&q31_, &tables_) : sd_driveline_guard_init_f32(&f32_, &tables_);
    if (result != SD_OK) throw InputError("driveline", "tables", "are out of the guard filter's range");
}

void GuardFilter::step(const sd_driveline_tooth_f32_t &tooth) {
    if (!fixed_point_) {
        sd_driveline_guard_step_f32(&f32_, &tables_, &tooth, &out_);
        return;
    }
    const sd_driveline_tooth_q31_t given{tooth.period_ticks, tooth.advance, tooth.health, tooth.gear,
                                         sd_given_q31(tooth.torque_nm, SD_DRIVELINE_TORQUE_BITS),
                                         sd_given_q31(tooth.place_rad, SD_DRIVELINE_PHASE_BITS),
                                         sd_given_q31(tooth.lead_rad, SD_DRIVELINE_PHASE_BITS)};
    sd_driveline_out_q31_t out;
    sd_driveline_guard_step_q31(&q31_, &tables_, &given, &out);
    out_ = {sd_said_q31(out.twist_rad, SD_DRIVELINE_TWIST_BITS), sd_said_q31(out.shaft_nm, SD_DRIVELINE_TORQUE_BITS),
            sd_said_q31(out.winding_radps, SD_DRIVELINE_WHEEL_BITS), sd_said_q31(out.wheel_radps, SD_DRIVELINE_WHEEL_BITS),
            sd_said_q31(out.bias_nm, SD_DRIVELINE_TORQUE_BITS), out.location, out.changed, out.moving, out.status};
}

void GuardFilter::wheel(std::uint32_t since_ticks, std::uint16_t advance) {
    if (fixed_point_) sd_driveline_guard_wheel_q31(&q31_, &tables_, since_ticks, advance);
    else sd_driveline_guard_wheel_f32(&f32_, &tables_, since_ticks, advance);
}

void GuardFilter::put_twist(double twist_rad) {
    f32_.x[SD_DRIVELINE_TWIST] = float(twist_rad);
    q31_.x[SD_DRIVELINE_TWIST] = sd_given_q31(float(twist_rad), SD_DRIVELINE_TWIST_BITS);
}

} // namespace sixdeg
