// SPDX-License-Identifier: MIT
// Figure 6 of document 003: 10 N m less engine torque at 2 s, torsion, estimate, residuals and locations.
#pragma once
#include <string>
#include <vector>

#include "design/driveline/hybrid_design.hpp"
#include "plant/vehicle/vehicle_model.hpp"

namespace sixdeg {

struct FigureSixCase {
    Driveline driveline;
    HybridBelief belief;
    Location begins_in = 3;   ///< What the observer is told at the start; the car begins in 3.
    double duration_s = 4;
    double jitter_deg = -1;   ///< Below 0: the speed is known without noise at every step; else it is that of the last tooth of 60-2.
};
/// The canonical parameters, and those that visit location 1 too: threshold 0.05 rpm, and a location may be left at once.
FigureSixCase canonical_figure();
FigureSixCase three_location_figure();

struct FigureSixRow {
    double time_s, twist_rad, estimate_rad, residual_rpm[3];
    double generator_rad[3]; ///< Torsion as each residual generator has it.
    Location real, found;
};
struct FigureSix {
    std::vector<LocationChange> real, found;
    std::vector<FigureSixRow> rows;
    double largest_error_rad = 0; ///< Of the torsion, continuous observer.
    double wrong_percent = 0;     ///< Of the time from 2 s on.
};
FigureSix run_figure_six(const FigureSixCase &figure);

/// Of each true change, how late it was found, s; below 0: never, before the next one. And how many were found that were not there.
struct Delays {
    std::vector<double> late_s;
    int missed = 0, false_ones = 0;
};
Delays delays(const FigureSix &figure);

/// time_s, torsion, its estimate, the residuals, both locations.
std::string figure_six_csv(const FigureSix &figure);

} // namespace sixdeg
