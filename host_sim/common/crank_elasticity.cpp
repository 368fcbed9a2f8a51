// SPDX-License-Identifier: MIT
#include "common/crank_elasticity.hpp"

#include <fmt/format.h>

namespace sixdeg {

std::optional<DualMassFlywheel> read_dual_mass(TomlFile &file) {
    if (!file.has("dual_mass")) return std::nullopt;
    return DualMassFlywheel{file.number("dual_mass.secondary_inertia_kgm2", {1e-3, 10, "kg m2"}),
                            file.number("dual_mass.stiffness_nmprad", {10, 1e5, "N m/rad"}),
                            file.number("dual_mass.damping_nmsprad", {0, 1000, "N m s/rad"})};
}

std::optional<CrankTorsion> read_torsion(TomlFile &file, double crank_inertia_kgm2, int cylinders) {
    if (!file.has("torsion")) return std::nullopt;
    CrankTorsion t{};
    t.section_stiffness_nmprad = file.number("torsion.section_stiffness_nmprad", {1e4, 1e8, "N m/rad"});
    t.front_inertia_kgm2 = file.number("torsion.front_inertia_kgm2", {1e-5, 5, "kg m2"});
    t.throw_inertia_kgm2 = file.number("torsion.throw_inertia_kgm2", {1e-5, 5, "kg m2"});
    t.damping_ratio = file.number_or("torsion.damping_ratio", {0, 0.5, ""}, 0.02);
    const std::string at = file.text_or("torsion.wheel_at", "front");
    if (at != "front" && at != "flywheel") file.fail("torsion.wheel_at", "'" + at + "' is not \"front\" or \"flywheel\"");
    t.wheel_at_front = at == "front";
    const double parts = t.front_inertia_kgm2 + cylinders * t.throw_inertia_kgm2;
    if (parts >= crank_inertia_kgm2) {
        file.fail("torsion.throw_inertia_kgm2",
                  fmt::format("with the front end makes {:g} kg m2 and leaves nothing of crank.inertia_kgm2 to the flywheel", parts));
    }
    return t;
}

} // namespace sixdeg
