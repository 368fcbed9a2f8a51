// SPDX-License-Identifier: MIT
// [dual_mass] and [torsion] of ENGINE.toml: what plant and calibration both know. Field by field: docs/reference/files.md.
#pragma once
#include <optional>

#include "common/toml_file.hpp"

namespace sixdeg {

/// The crank carries its primary mass (in crank.inertia_kgm2), the load acts on the secondary.
struct DualMassFlywheel {
    double secondary_inertia_kgm2;
    double stiffness_nmprad;
    double damping_nmsprad;
};

/// Elastic crank: front end, one throw a cylinder in physical order, and the flywheel on equal shaft sections.
struct CrankTorsion {
    double section_stiffness_nmprad;
    double front_inertia_kgm2, throw_inertia_kgm2; ///< Parts of crank.inertia_kgm2; the rest is the flywheel.
    double damping_ratio;                          ///< Of each mode, [0, 1).
    bool wheel_at_front;                           ///< Where the toothed wheel sits: front end or flywheel.
};

/// None when the file has no such table. Throw InputError.
std::optional<DualMassFlywheel> read_dual_mass(TomlFile &file);
std::optional<CrankTorsion> read_torsion(TomlFile &file, double crank_inertia_kgm2, int cylinders);

} // namespace sixdeg
