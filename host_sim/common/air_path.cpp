// SPDX-License-Identifier: MIT
#include "common/air_path.hpp"

#include <cmath>
#include <filesystem>
#include <string>

#include "common/files.hpp"

namespace sixdeg {

Profile read_curve(TomlFile &file, const std::string &field, Range range, const std::string &knots, Range knot_range) {
    if (file.has(field) && file.array_size(field) == 0) return Profile(file.number(field, range));
    const auto x = file.numbers(knots, knot_range);
    if (x.empty()) file.fail(knots, "is empty");
    for (std::size_t i = 1; i < x.size(); ++i)
        if (x[i] <= x[i - 1]) file.fail(knots, "is not ascending");
    return Profile(x, file.numbers(field, range, x.size()));
}

std::optional<AirPathSystem> read_air_path(TomlFile &file) {
    if (!file.has("airpath")) return std::nullopt;
    AirPathSystem a;
    a.intake_m3 = 1e-3 * file.number("airpath.intake_l", {0.5, 200, "L"});
    a.exhaust_m3 = 1e-3 * file.number("airpath.exhaust_l", {0.2, 200, "L"});
    const Profile efficiency =
        read_curve(file, "airpath.volumetric_efficiency", {0.3, 1.5, ""}, "airpath.efficiency_rpm", {100, 12000, "rpm"});
    auto speed = efficiency.x();
    for (double &s : speed) s *= M_PI / 30;
    a.volumetric_efficiency = Profile(std::move(speed), efficiency.value());
    const Range area{0, 1e5, "mm2"}, position{0, 1, ""};
    a.egr_area_m2 = read_curve(file, "airpath.egr_area_mm2", area, "airpath.egr_opening", position).scaled(1e-6);
    a.turbine_area_m2 = read_curve(file, "airpath.turbine_area_mm2", area, "airpath.turbine_position", position).scaled(1e-6);
    a.heat_ratio = file.number_or("airpath.heat_ratio", {1, 1.5, ""}, 1);
    a.ambient_pa = 1e5 * file.number_or("airpath.ambient_bar", {0.4, 1.2, "bar"}, 1.0111);
    a.charge_k = file.number_or("airpath.charge_k", {200, 500, "K"}, 310);
    a.egr_k = file.number_or("airpath.egr_k", {200, 1000, "K"}, 370);
    a.exhaust_k = file.number_or("airpath.exhaust_k", {300, 1400, "K"}, 720);
    const std::string design = file.text_or("airpath.design", "");
    if (design.empty()) return a;
    const auto path = std::filesystem::path(file.name()).parent_path() / design;
    a.design_name = path.string();
    if (std::filesystem::exists(path)) a.design_text = read_file(path); // an engine file in a log has none beside it
    return a;
}

} // namespace sixdeg
