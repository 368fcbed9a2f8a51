// SPDX-License-Identifier: MIT
#include "design/airpath/fixed_tables.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

namespace sixdeg {
namespace {

constexpr int kUnit = 0, kMoved = SD_WIDE_BITS, kGain = SD_WIDE_BITS + SD_AIRPATH_FLOW - SD_AIRPATH_AMOUNT; // of coefficients
constexpr double kAreaMost = 12800;

/// Converts, and keeps the first number that does not fit.
class Scaling {
  public:
    sd_q31_t of(const std::string &name, double x, int bits) {
        const double base = std::ldexp(1.0, bits), share = std::round(x / base * 2147483648.0);
        if (std::abs(x) > base) note(name, x, fmt::format("within +-{:g}", base));
        return sd_q31_t(std::clamp(share, -2147483647.0, 2147483647.0));
    }
    template <std::size_t n> void all(const std::string &name, const float (&from)[n], sd_q31_t (&to)[n], int bits) {
        for (std::size_t i = 0; i < n; ++i) to[i] = of(fmt::format("{}[{}]", name, i), double(from[i]), bits);
    }
    template <std::size_t rows, std::size_t cols>
    void all(const std::string &name, const float (&from)[rows][cols], sd_q31_t (&to)[rows][cols], int bits) {
        for (std::size_t i = 0; i < rows; ++i) all(fmt::format("{}[{}]", name, i), from[i], to[i], bits);
    }
    void note(const std::string &name, double x, const std::string &allowed) {
        if (too_large_.empty()) too_large_ = fmt::format("{} is {:g}, in fixed point allowed {}", name, x, allowed);
    }
    const std::string &too_large() const { return too_large_; }

  private:
    std::string too_large_;
};

sd_airpath_model_q31_t model_of(Scaling &s, const sd_airpath_model_f32_t &f) {
    sd_airpath_model_q31_t q{};
    const int per_kelvin = SD_AIRPATH_PER_GRAM - SD_AIRPATH_KELVIN;
    q.kappa = s.of("kappa", double(f.kappa), SD_AIRPATH_KAPPA);
    q.air_kpapgk = s.of("air, kPa/(g K),", double(f.air_kpapgk), per_kelvin);
    q.egr_kpapgk = s.of("recirculated gas, kPa/(g K),", double(f.egr_kpapgk), per_kelvin);
    q.exhaust_kpapgk = s.of("exhaust gas, kPa/(g K),", double(f.exhaust_kpapgk), per_kelvin);
    q.exhaust_jpkgk = s.of("R of the exhaust gas, J/(kg K),", double(f.exhaust_jpkgk), SD_AIRPATH_GAS);
    q.ambient_kpa = s.of("ambient_kpa", double(f.ambient_kpa), SD_AIRPATH_AMOUNT);
    q.rpm_most = s.of("rpm_most", double(f.rpm_most), SD_AIRPATH_RPM);
    s.all("emptying, 1/s, knot", f.emptying_ps, q.emptying_ps, SD_AIRPATH_EMPTYING);
    s.all("area of the EGR valve, mm2, knot", f.egr_area_mm2, q.egr_area_mm2, SD_AIRPATH_AREA);
    s.all("area of the turbine, mm2, knot", f.turbine_area_mm2, q.turbine_area_mm2, SD_AIRPATH_AREA);
    s.all("turbine_drop", f.turbine_drop, q.turbine_drop, kUnit);
    for (const auto &areas : {f.egr_area_mm2, f.turbine_area_mm2}) {
        const double largest = double(*std::max_element(areas, areas + SD_AIRPATH_KNOTS));
        if (largest > kAreaMost) s.note("area, mm2,", largest, fmt::format("up to {:g}", kAreaMost));
    }
    return q;
}

sd_nuio_table_q31_t observer_of(Scaling &s, const std::string &name, const sd_nuio_table_f32_t &f) {
    sd_nuio_table_q31_t q{};
    s.all(name + ".m", f.m, q.m, kMoved);
    s.all(name + ".e", f.e, q.e, kMoved);
    s.all(name + ".k", f.k, q.k, kGain);
    s.all(name + ".k over the speed", f.more, q.more, kGain);
    s.all(name + ".gamma", f.gamma, q.gamma, kMoved);
    if (!sd_nuio_table_ok_q31(&q)) s.note(name, 0, fmt::format("rows that add up to less than {} (m, e, gamma) and {} (k)", 1 << kMoved,
                                                               1 << kGain));
    return q;
}

sd_cusum_tables_q31_t decision_of(Scaling &s, const sd_cusum_tables_f32_t &f) {
    sd_cusum_tables_q31_t q{};
    s.all("decision's weight", f.weight, q.weight, SD_CUSUM_WEIGHT_BITS);
    s.all("decision's offset", f.offset, q.offset, SD_CUSUM_BITS);
    std::copy(f.group, f.group + SD_CUSUM_HYPOTHESES_MAX, q.group);
    q.hypotheses = f.hypotheses, q.residuals = f.residuals;
    return q;
}

} // namespace

FixedAirPath fixed_air_path(const sd_airpath_tables_f32_t &f) {
    FixedAirPath found;
    if (f.present == 0) return found;
    Scaling s;
    sd_airpath_tables_q31_t q{};
    q.present = 1;
    q.period_s = s.of("period, s,", double(f.period_s), -SD_AIRPATH_PERIOD);
    q.emptying_low_ps = s.of("emptying, 1/s, low,", double(f.emptying_low_ps), SD_AIRPATH_EMPTYING);
    q.emptying_high_ps = s.of("emptying, 1/s, high,", double(f.emptying_high_ps), SD_AIRPATH_EMPTYING);
    s.all("decision.fault_kpa", f.fault, q.fault, SD_AIRPATH_AMOUNT);
    q.model = model_of(s, f.model);
    for (std::size_t i = 0; i < SD_AIRPATH_OBSERVERS; ++i) q.observer[i] = observer_of(s, fmt::format("observer[{}]", i), f.observer[i]);
    q.cusum = decision_of(s, f.cusum);
    if (s.too_large().empty() && !sd_airpath_tables_ok_q31(&q)) s.note("a number", 0, "those that the firmware takes");
    found.too_large = s.too_large();
    if (found.too_large.empty()) found.tables = q;
    return found;
}

sd_airpath_in_q31_t fixed_readings(const sd_airpath_in_f32_t &in) {
    sd_airpath_in_q31_t q{};
    q.speed_rpm = sd_given_q31(in.speed_rpm, SD_AIRPATH_RPM);
    q.air_gps = sd_given_q31(in.air_gps, SD_AIRPATH_FLOW), q.fuel_gps = sd_given_q31(in.fuel_gps, SD_AIRPATH_FLOW);
    q.charge_k = sd_given_q31(in.charge_k, SD_AIRPATH_KELVIN), q.egr_k = sd_given_q31(in.egr_k, SD_AIRPATH_KELVIN);
    q.exhaust_k = sd_given_q31(in.exhaust_k, SD_AIRPATH_KELVIN);
    q.egr_opening = sd_given_q31(in.egr_opening, 0), q.vgt_position = sd_given_q31(in.vgt_position, 0);
    q.intake_kpa = sd_given_q31(in.intake_kpa, SD_AIRPATH_AMOUNT), q.exhaust_kpa = sd_given_q31(in.exhaust_kpa, SD_AIRPATH_AMOUNT);
    return q;
}

} // namespace sixdeg
