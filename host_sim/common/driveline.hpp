// SPDX-License-Identifier: MIT
// A car's driveline as plant and calibration both know it: an engine, a shaft that winds up, a vehicle.
//
// The shaft is soft about its middle and stiff beyond a torsion of kink_rad either way (A. Balluchi and others, "A hybrid observer
// for the driveline dynamics", document 003, Figures 1 and 2). Torsion and torque are those at the wheels.
#pragma once
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "common/toml_file.hpp"

namespace sixdeg {

/// Where the shaft is: 1 wound up backward and stiff, 2 soft, 3 wound up forward and stiff.
using Location = int;

struct Driveline {
    double engine_inertia_kgm2 = 0.17; ///< Of all that turns with the crank while the clutch holds.
    double engine_viscous_nms = 0.05;  ///< Torque lost for each rad/s of the crank.
    double vehicle_inertia_kgm2 = 130; ///< Mass of the car times the square of the wheels' radius, wheels included.
    double soft_nmprad = 2400;         ///< Stiffness about the middle; 0 is a backlash.
    double stiff_nmprad = 8000;        ///< Stiffness beyond it.
    double damping_nms = 90;           ///< Of the shaft.
    double kink_rad = 0.015;           ///< Torsion at which the shaft becomes stiff.
    double rolling_nm = 0;             ///< Resistance of the road at the wheels, whatever the speed, as long as the car rolls.
    double drag_nms2 = 0;              ///< Of the air: torque over the square of the wheels' speed.
    std::vector<double> ratios{0.125}; ///< Speed of the wheels over that of the crank, a gear each.

    /// Where the torsion is; exactly at a kink it counts as soft.
    Location location(double twist_rad) const { return twist_rad > kink_rad ? 3 : twist_rad < -kink_rad ? 1 : 2; }
    /// Torque of the shaft's spring, N m, by the law of one location, whether or not the torsion lies there.
    double spring_nm(double twist_rad, Location at) const {
        return at == 2 ? soft_nmprad * twist_rad : stiff_nmprad * twist_rad - (at - 2) * (stiff_nmprad - soft_nmprad) * kink_rad;
    }
    double spring_nm(double twist_rad) const { return spring_nm(twist_rad, location(twist_rad)); }
    /// The torsion at which the spring gives a torque; of a backlash that passes none, its middle.
    double twist_rad(double spring_nm) const {
        const double at_kink = soft_nmprad * kink_rad;
        if (std::abs(spring_nm) <= at_kink) return soft_nmprad > 0 ? spring_nm / soft_nmprad : 0;
        const double beyond = (std::abs(spring_nm) - at_kink) / stiff_nmprad + kink_rad;
        return spring_nm > 0 ? beyond : -beyond;
    }
    /// Resistance of the road, N m, at a speed of the wheels; within 0.5 rad/s of standstill it fades, so that a car can stand.
    double road_nm(double wheel_radps) const {
        return rolling_nm * std::clamp(wheel_radps / 0.5, -1.0, 1.0) + drag_nms2 * wheel_radps * std::abs(wheel_radps);
    }
};

/// [driveline] of ENGINE.toml: the car behind the engine, and what is said of its observers. Field by field: docs/reference/files.md.
struct DrivelineFile {
    Driveline car;                 ///< engine_inertia_kgm2 is the crank's mean, and no field.
    double drag_nm = 0;            ///< Torque that friction takes at no speed; what it takes more with speed is car.engine_viscous_nms.
    bool guard_in_torque = false;  ///< What decides on the location: the torsion, or the shaft's torque.
    int wheel_teeth = 0;           ///< On a driven wheel; 0: it has none that are read.
    double wheel_jitter_deg = 0.05;
};

/// None when the file has no such table. Throws InputError.
std::optional<DrivelineFile> read_driveline(TomlFile &file);

} // namespace sixdeg
