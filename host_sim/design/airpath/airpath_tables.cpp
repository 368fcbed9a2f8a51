// SPDX-License-Identifier: MIT
#include "design/airpath/airpath_tables.hpp"

#include <cmath>
#include <fmt/format.h>

#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr double kAirJpkgk = 287, kExhaustJpkgk = 286; // as the design has them
constexpr double kTurbineFlow = 0.762, kTurbineExponent = 2.89; // Wahlstrom and Eriksson, 2011
constexpr double kRpmMost = 4000, kRpmPerRadps = 30 / M_PI, kPeriodS = 0.01;
constexpr Range kNumber{-1e6, 1e6, ""};

sd_airpath_model_f32_t model_of(const AirPathSystem &s, double displaced_m3) {
    sd_airpath_model_f32_t m{};
    m.kappa = float(s.heat_ratio);
    // J/(kg K) over m3 is Pa/(kg K), a millionth of it kPa/(g K).
    m.air_kpapgk = float(1e-6 * s.heat_ratio * kAirJpkgk / s.intake_m3);
    m.egr_kpapgk = float(1e-6 * s.heat_ratio * kExhaustJpkgk / s.intake_m3);
    m.exhaust_kpapgk = float(1e-6 * kExhaustJpkgk / s.exhaust_m3);
    m.exhaust_jpkgk = float(kExhaustJpkgk);
    m.ambient_kpa = float(1e-3 * s.ambient_pa);
    m.rpm_most = float(kRpmMost);
    for (int i = 0; i < SD_AIRPATH_KNOTS; ++i) {
        const double share = double(i) / (SD_AIRPATH_KNOTS - 1), rpm = share * kRpmMost;
        m.emptying_ps[i] = float(s.volumetric_efficiency.at(rpm / kRpmPerRadps) * displaced_m3 * rpm / 120 / s.intake_m3);
        m.egr_area_mm2[i] = float(1e6 * s.egr_area_m2.at(share));
        m.turbine_area_mm2[i] = float(1e6 * kTurbineFlow * s.turbine_area_m2.at(share));
    }
    for (int i = 0; i < SD_AIRPATH_DROP_KNOTS; ++i)
        m.turbine_drop[i] = float(1 - std::pow(double(i) / (SD_AIRPATH_DROP_KNOTS - 1), kTurbineExponent));
    return m;
}

/// A matrix as rows; `cols` numbers each.
std::vector<double> matrix(TomlFile &file, const std::string &field, std::size_t cols) {
    std::vector<double> all;
    for (int row = 0; row < SD_NUIO_STATES; ++row)
        for (const double x : file.numbers(fmt::format("{}[{}]", field, row), kNumber, cols)) all.push_back(x);
    return all;
}

void fill(const std::vector<double> &from, float *to) {
    for (const double x : from) *to++ = float(x);
}

sd_nuio_table_f32_t observer_of(TomlFile &file, const std::string &at) {
    sd_nuio_table_f32_t o{};
    fill(matrix(file, at + "m", SD_NUIO_STATES), &o.m[0][0]);
    fill(matrix(file, at + "e", SD_NUIO_OUTPUTS), &o.e[0][0]);
    const auto low = matrix(file, at + "k_low", SD_NUIO_OUTPUTS), high = matrix(file, at + "k_high", SD_NUIO_OUTPUTS);
    std::vector<double> more = high;
    for (std::size_t i = 0; i < more.size(); ++i) more[i] -= low[i];
    fill(low, &o.k[0][0]);
    fill(more, &o.more[0][0]);
    fill(file.numbers(at + "gamma", kNumber, SD_NUIO_OUTPUTS), o.gamma);
    return o;
}

} // namespace

void set_covariance(AirPathDesign &design, const double (&s)[2][2]) {
    sd_cusum_tables_f32_t &c = design.tables.cusum;
    c.residuals = SD_AIRPATH_RESIDUALS;
    c.hypotheses = std::uint8_t(4 + 2 * design.others_kpa.size());
    for (int l = 0; l < c.hypotheses; ++l) { // EGR opening and closing, then VGT closing and opening, then the others
        const int group = l / 2, residual = 1 - group;
        const double way = l % 2 ? -1 : 1;
        double mean[2] = {0, 0};
        if (group < 2) mean[residual] = way * design.sign[std::size_t(residual)] * design.mean_kpa[std::size_t(residual)];
        else for (int i = 0; i < 2; ++i) mean[i] = way * design.others_kpa[std::size_t(group - 2)][std::size_t(i)];
        double offset = 0;
        for (int i = 0; i < 2; ++i) {
            const double weight = mean[i] / s[i][i];
            c.weight[l][i] = float(weight);
            offset += weight * mean[i] / 2;
        }
        c.offset[l] = float(offset);
        c.group[l] = std::uint8_t(group);
    }
    std::copy(&s[0][0], &s[0][0] + 4, &design.covariance[0][0]);
}

AirPathDesign read_air_path_design(TomlFile &file, const AirPathSystem &system, double displaced_m3) {
    AirPathDesign d;
    sd_airpath_tables_f32_t &t = d.tables;
    t.present = 1;
    t.period_s = float(kPeriodS);
    const auto ends = file.numbers("design.k", {0.01, 1000, "1/s"}, 2);
    t.emptying_low_ps = float(ends[0]), t.emptying_high_ps = float(ends[1]);
    t.model = model_of(system, displaced_m3);
    if (file.array_size("observer") != 2) file.fail("observer", "has not 2 entries");
    for (std::size_t i = 0; i < 2; ++i) {
        const std::string at = fmt::format("observer[{}].", i);
        const std::string wanted = i == 0 ? "vgt" : "egr";
        if (file.text(at + "sees") != wanted) file.fail(at + "sees", "is not \"" + wanted + "\"");
        t.observer[i] = observer_of(file, at);
    }
    const auto mean = file.numbers("decision.mean_kpa", {1e-3, 1e4, "kPa"}, 2);
    const auto fault = file.numbers("decision.fault_kpa", {1e-3, 1e4, "kPa"}, 2);
    const auto sign = file.numbers("decision.sign", {-1, 1, ""}, 2);
    for (std::size_t i = 0; i < 2; ++i) {
        d.mean_kpa[i] = mean[i], d.fault_kpa[i] = fault[i], d.sign[i] = sign[i] < 0 ? -1 : 1;
        t.fault[i] = float(fault[i]);
    }
    const auto first = file.numbers("decision.covariance[0]", kNumber, 2), second = file.numbers("decision.covariance[1]", kNumber, 2);
    if (!(first[0] * second[1] > first[1] * second[0]) || first[0] <= 0) file.fail("decision.covariance", "is not positive definite");
    for (std::size_t i = 0; i < file.array_size("decision.others_kpa"); ++i) {
        const auto other = file.numbers(fmt::format("decision.others_kpa[{}]", i), kNumber, 2);
        if (i == 2 || (other[0] == 0 && other[1] == 0)) file.fail("decision.others_kpa", "has more than two entries, or one that is 0");
        d.others_kpa.push_back({other[0], other[1]});
    }
    set_covariance(d, {{first[0], first[1]}, {second[0], second[1]}});
    d.source = file.text("decision.source");
    for (const char *table : {"design", "observer[0]", "observer[1]", "decision"}) file.ignore(table); // what only the certificate takes
    if (!sd_airpath_tables_ok_f32(&t)) file.fail("observer", "holds a number that the firmware does not take");
    return d;
}

} // namespace sixdeg
