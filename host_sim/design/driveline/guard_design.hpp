// SPDX-License-Identifier: MIT
// Tables of the guard filter (firmware/driveline/sd_driveline_guard.h) from what is known of a driveline.
#pragma once
#include "common/driveline.hpp"
#include "sd_driveline_guard.h"

namespace sixdeg {

/// How far each part is believed. Walks are standard deviations after one second.
struct GuardBelief {
    double jitter_rad = 2e-3;        ///< Of a tooth: jitter, a pattern that is not learned, ripple that is not told.
    double bias_walk_nm = 1;         ///< Of the error of the engine's torque.
    double torque_noise_nm = 0.02;   ///< White torque at the crank, N m for a mean of one second.
    double road_walk_radps = 0.02;   ///< Of the wheels' speed, beside what the road is known to do.
    double twist_walk_rad = 1e-5;    ///< Of the torsion, beside what its ends do.
    double wheel_jitter_rad = 0;     ///< Of an edge of the wheels; 0: they have no teeth.
    int wheel_positions = 48;
    double doubt_rad = 2e-3;         ///< Mean lateness of some 16 teeth that noise, pattern and ripple stay below.

    /// While the filter settles after a start or a change of gear: nothing is known of torsion and wheels, little of the torque.
    GuardBelief starting() const {
        GuardBelief b = *this;
        b.jitter_rad = jitter_rad / 2;
        b.torque_noise_nm = 100 * torque_noise_nm;
        b.road_walk_radps = 100 * road_walk_radps;
        b.twist_walk_rad = 1e-2;
        return b;
    }
};

/// Of a timer, a crank wheel of `positions`, and a driveline. Gains are those of the steady filter at each octave.
sd_driveline_tables_t guard_tables(const Driveline &driveline, const GuardBelief &belief, int positions, double tick_s,
                                   sd_driveline_guard_by_t guard = SD_GUARD_ANGLE);

} // namespace sixdeg
