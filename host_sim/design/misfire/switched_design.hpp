// SPDX-License-Identifier: MIT
// Exact steps for the observers of document 000, and their tables in both number types: matrix exponentials, computed here so that
// no target needs them.
#pragma once

extern "C" {
#include "sd_switched.h"
}

namespace sixdeg {

/// v1' = v2, v2' = -k2 v2 - k1 v1 + C Q. In the angle domain the prime is d/da and the units are those of a radian.
struct CrankModel {
    double k1_per_s2, k2_per_s;
};

/// x+ = x + D x + g u + h y over one step, u and y means over it.
struct PlantStep {
    double period;       ///< s, or rad in the angle domain.
    double increment[2][2]; ///< D.
    double from_input[2], from_output[2]; ///< g, h.
    double output_gain;  ///< l: acceleration = x2 + l y.
};

/// The plant itself: what the per-cylinder-input observer predicts with.
PlantStep plant_step(const CrankModel &model, double period);
/// FOLSMO; FOSMO with luenberger (L) = 0.
PlantStep folsmo_step(const CrankModel &model, double luenberger_per_s2, double period);
/// ROO with gain l.
PlantStep roo_step(const CrankModel &model, double gain_per_s, double period);

/// Bases of the numbers per unit: of v1, v2 and the input.
struct SwitchedBases {
    double speed, accel, input;
};

/// Number types by their suffix in the firmware.
struct NumberF32 {
    using Number = float;
    using Gain = sd_gain_f32_t;
    using Table = sd_switched_table_f32_t;
    static Gain gain(double x) { return sd_gain_of_f32(float(x)); }
    static void row(sd_row_f32_t &row, const float *values) { row = sd_row_of_f32(values); }
    static bool fits(const sd_row_f32_t &row) { return sd_row_fits_f32(&row); }
    static Number in(double x) { return sd_from_float_f32(float(x)); }
    static double out(Number x) { return double(sd_to_float_f32(x)); }
};
struct NumberQ31 {
    using Number = sd_q31_t;
    using Gain = sd_gain_q31_t;
    using Table = sd_switched_table_q31_t;
    static Gain gain(double x) { return sd_gain_of_q31(float(x)); }
    static void row(sd_row_q31_t &row, const float *values) { row = sd_row_of_q31(values); }
    static bool fits(const sd_row_q31_t &row) { return sd_row_fits_q31(&row); }
    static Number in(double x) { return sd_from_float_q31(float(x)); }
    static double out(Number x) { return double(sd_to_float_q31(x)); }
};

/// The table of a step per unit of `bases`. False where a number does not fit: the bases are too far apart for it.
template <class V> bool switched_table(const PlantStep &step, const SwitchedBases &bases, typename V::Table &table) {
    const double base[2] = {bases.speed, bases.accel};
    bool fits = true;
    for (int i = 0; i < 2; ++i) {
        const float values[4] = {float(step.increment[i][0] * base[0] / base[i]), float(step.increment[i][1] * base[1] / base[i]),
                                 float(step.from_input[i] * bases.input / base[i]), float(step.from_output[i] * base[0] / base[i])};
        V::row(table.row[i], values);
        fits = fits && V::fits(table.row[i]);
    }
    table.output_gain = V::gain(step.output_gain * base[0] / base[1]);
    table.slope = V::gain(step.period * base[1] / base[0]);
    table.reduced = step.output_gain > 0;
    return fits;
}

} // namespace sixdeg
