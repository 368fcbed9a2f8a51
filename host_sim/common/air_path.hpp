// SPDX-License-Identifier: MIT
// [airpath] of ENGINE.toml: what plant and design both know of a diesel's air path with exhaust gas recirculation (EGR) and a
// variable turbine (VGT). Field by field: docs/reference/files.md. The laws that areas and efficiency belong to: docs/theory/airpath.md.
#pragma once
#include <optional>
#include <string>

#include "common/profile.hpp"
#include "common/toml_file.hpp"

namespace sixdeg {

struct AirPathSystem {
    double intake_m3 = 0;  ///< Charge-air cooler, pipe and intake manifold as one volume.
    double exhaust_m3 = 0; ///< Exhaust manifold up to valve and turbine.
    Profile volumetric_efficiency; ///< Over engine speed in rad/s; of the intake manifold's gas.
    Profile egr_area_m2;           ///< Effective, over the valve's opening, 0 closed to 1 open.
    Profile turbine_area_m2;       ///< Effective, over the vanes' position, 0 closed to 1 open.
    double heat_ratio = 1;         ///< kappa of the intake pressure's balance: 1 isothermal.
    double ambient_pa = 1.0111e5; ///< Behind the turbine.
    std::string design_name; ///< Of the observers' design file (tools/airpath/design.py); empty: none, and no diagnosis.
    std::string design_text; ///< What it holds; empty where it is not there.
    double charge_k = 310, egr_k = 370, exhaust_k = 720; ///< Usual temperatures: behind both coolers, in the exhaust manifold.
};

/// None when the file has no [airpath]. Throws InputError.
std::optional<AirPathSystem> read_air_path(TomlFile &file);

/// A field that is one number or a list beside `knots` in the same file, ascending. Throws InputError.
Profile read_curve(TomlFile &file, const std::string &field, Range range, const std::string &knots, Range knot_range);

} // namespace sixdeg
