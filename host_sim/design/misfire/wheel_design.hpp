// SPDX-License-Identifier: MIT
// Document 000's observers on the toothed wheel: k1, k2, C and the gains from the engine file, into the page. docs/theory/observers.md
// has the derivation.
#pragma once
#include "common/engine_file.hpp"
#include "design/misfire/switched_design.hpp"

extern "C" {
#include "sd_calibration.h"
}

namespace sixdeg {

/// The model of the angle domain: lengths are rad, v1 is w^2/2 less its mean, v2 is dw/dt.
struct WheelModel {
    double pulse_start_deg, pulse_deg; ///< The heat release as a rectangle of the same centre and standard deviation, from TDC.
    double k2_per_rad;   ///< How fast the acceleration that combustion makes dies away.
    double mean_per_rad; ///< How fast the mean of w^2/2 follows.
    double inertia_kgm2; ///< Largest of all that turns with the wheel.

    double k1_per_rad2() const { return k2_per_rad * mean_per_rad; }
    double damping_per_rad() const { return k2_per_rad + mean_per_rad; } ///< The document's k2.
    double luenberger_per_rad2() const; ///< L of FOLSMO: a damping ratio of 1 / sqrt(2).
    double roo_per_rad() const { return k2_per_rad; } ///< l of ROO.
};

/// rho, as a share of the mean of C Q.
constexpr double kFolsmoSliding = 0.02, kFosmoSliding = 1.5;

/// The engine file must tell a heat release.
WheelModel wheel_model(const EngineFile &engine);

/// What an observer shows of a misfire that nobody told it of, best delay of its windows.
struct WheelCapture {
    int delay;    ///< Positions.
    double share; ///< Of the acceleration that the firing should have given.
};
WheelCapture wheel_capture(const EngineFile &engine, const WheelModel &model, sd_wheel_kind_t kind);

/// The page's part; positions 0 where the engine file tells no heat release. `c` has wheel, cylinders and parameters.
sd_wheel_tables_t wheel_tables(const EngineFile &engine, const sd_calibration_t &c);

} // namespace sixdeg
