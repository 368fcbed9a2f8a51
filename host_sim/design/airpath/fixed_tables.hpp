// SPDX-License-Identifier: MIT
// The tables of the air path's diagnosis in q31: each number per unit of the base that the firmware has for it.
#pragma once
#include <string>

extern "C" {
#include "sd_airpath_bank.h"
}

namespace sixdeg {

struct FixedAirPath {
    sd_airpath_tables_q31_t tables{}; ///< present 0 where they do not fit.
    std::string too_large;            ///< Empty, or the number that does not fit, its value and what is allowed.
};

FixedAirPath fixed_air_path(const sd_airpath_tables_f32_t &tables);
/// Readings as the ecu's stage gives them to the bank of q31.
sd_airpath_in_q31_t fixed_readings(const sd_airpath_in_f32_t &in);

} // namespace sixdeg
