// SPDX-License-Identifier: MIT
#include "common/driveline.hpp"

namespace sixdeg {

std::optional<DrivelineFile> read_driveline(TomlFile &file) {
    if (!file.has("driveline")) return std::nullopt;
    DrivelineFile d;
    Driveline &car = d.car;
    car.ratios = file.numbers("driveline.ratios", {0.005, 2, "wheels over crank"});
    if (car.ratios.empty() || car.ratios.size() > 8) file.fail("driveline.ratios", "has not 1 to 8 entries, one a gear");
    car.vehicle_inertia_kgm2 = file.number("driveline.vehicle_inertia_kgm2", {1, 1e5, "kg m2"});
    car.soft_nmprad = file.number("driveline.soft_nmprad", {0, 1e7, "N m/rad"});
    car.stiff_nmprad = file.number("driveline.stiff_nmprad", {10, 1e7, "N m/rad"});
    if (car.soft_nmprad > car.stiff_nmprad) file.fail("driveline.soft_nmprad", "is above driveline.stiff_nmprad");
    car.kink_rad = file.number("driveline.kink_rad", {1e-4, 1, "rad"});
    car.damping_nms = file.number("driveline.damping_nmsprad", {0, 1e5, "N m s/rad"});
    car.rolling_nm = file.number_or("driveline.rolling_nm", {0, 1e5, "N m"}, 0);
    car.drag_nms2 = file.number_or("driveline.drag_nms2", {0, 1e3, "N m s2"}, 0);
    d.drag_nm = file.number_or("driveline.engine_drag_nm", {0, 1000, "N m"}, 0);
    car.engine_viscous_nms = file.number_or("driveline.engine_drag_nms", {0, 10, "N m s"}, 0);
    const std::string guard = file.text_or("driveline.guard", "torsion");
    if (guard != "torsion" && guard != "torque") file.fail("driveline.guard", "'" + guard + "' is not \"torsion\" or \"torque\"");
    d.guard_in_torque = guard == "torque";
    d.wheel_teeth = int(file.integer_or("driveline.wheel_teeth", 0, 200, 0));
    d.wheel_jitter_deg = file.number_or("driveline.wheel_jitter_deg", {0.001, 2, "deg"}, 0.05);
    return d;
}

} // namespace sixdeg
