// SPDX-License-Identifier: MIT
#include "loop/evidence.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

extern "C" {
#include "sd_kalman_firing.h"
}

namespace sixdeg {
namespace {

constexpr double kDegPerRad = 180 / M_PI;
/// Cycles of a fuel cut of whose readings the mean is taken: burnt gas is gone by the first, and the filter has followed.
constexpr std::uint32_t kFromCycle = 8, kToCycle = 28;

/// Whether each position of the wheel has a tooth.
std::vector<bool> teeth_of(const sd_calibration_t &page) {
    const sd_crank_config_t wheel = sd_calibration_crank(&page, &page.parameters);
    std::vector<bool> teeth(wheel.positions, true);
    for (int i = 0; i < wheel.missing_count; ++i) teeth[wheel.missing[i]] = false;
    return teeth;
}

void add_pattern(const float *late_rad, const std::vector<bool> &teeth, Evidence &evidence) {
    const std::size_t n = teeth.size();
    double square = 0, count = 0;
    for (std::size_t k = 0; k < n; ++k) {
        if (!teeth[k]) continue;
        const double late_deg = double(late_rad[k]) * kDegPerRad;
        const bool beside = !teeth[(k + 1) % n] || !teeth[(k + n - 1) % n];
        if (!beside) square += late_deg * late_deg, ++count;
        else if (std::abs(late_deg) > std::abs(evidence.beside_mark_deg)) evidence.beside_mark_deg = late_deg;
    }
    evidence.pattern_deg = std::sqrt(square / std::max(count, 1.0));
}

} // namespace

void FuelCutReading::firing(const sd_ecu_t &ecu, std::uint32_t cylinders, double torque_nm, bool valid) {
    const bool known = sd_inputs_fresh(&ecu.inputs, SD_INPUT_FUEL_INJECTED);
    without_fuel_ = known && sd_inputs_value(&ecu.inputs, SD_INPUT_FUEL_INJECTED) <= 0 ? without_fuel_ + 1 : 0;
    if (!valid || without_fuel_ < kFromCycle * cylinders || without_fuel_ >= kToCycle * cylinders) return;
    ++firings_;
    exponent_ += double(ecu.firings.kalman.charge.exponent);
    nm_ += torque_nm, bar_ += double(sd_inputs_value(&ecu.inputs, SD_INPUT_AIR_INTAKE_PRESSURE));
}

void FuelCutReading::add_to(Evidence &evidence) const {
    if (firings_ == 0) return;
    evidence.cut_firings = firings_;
    evidence.cut_nm = nm_ / firings_, evidence.cut_bar = bar_ / firings_, evidence.cut_exponent = exponent_ / firings_;
}

Evidence evidence_of(const sd_ecu_t &ecu, const sd_calibration_t &page) {
    Evidence evidence;
    const sd_kalman_t &kalman = ecu.firings.kalman;
    const sd_kalman_filter_t &filter = kalman.filter[kalman.believed];
    if (ecu.firings.enabled == 0 || sd_kalman_health(&kalman, kalman.believed) != SD_VALID) return evidence;
    const double speed = std::sqrt(2 * double(filter.motion.energy_j) / double(page.kalman.inertia_mean_kgm2));
    const sd_between_t at = sd_kalman_between(&page.kalman, kalman.believed, float(speed));
    const sd_firings_pattern_t pattern = sd_firings_believed(&ecu.firings);
    const double made_for = double(sd_kalman_blend(page.kalman.expected_rad, at));
    evidence.late_deg = made_for * std::sqrt(double(filter.noise_ratio)) * kDegPerRad;
    evidence.expected_deg = std::hypot(made_for, double(pattern.tooth_rad)) * kDegPerRad;
    if (ecu.firings.pattern.exponent != 0) evidence.exponent_sd = double(ecu.firings.pattern.exponent_sd);
    if (pattern.late_rad != nullptr) add_pattern(pattern.late_rad, teeth_of(page), evidence);
    return evidence;
}

} // namespace sixdeg
