// SPDX-License-Identifier: MIT
#include "cli/contradictions.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "design/torque/known_torque.hpp"
#include "design/torque/model_error.hpp"

namespace sixdeg {
namespace {

constexpr double kSure = 2;         ///< Standard deviations of what the engine file leaves open.
constexpr double kLateFactor = 4;   ///< Over what the filter was made for.
constexpr double kBesideMark = 4;   ///< Over the pattern's rms; of 58 even teeth the largest is some 2.5 of it.
constexpr double kLeastBesideDeg = 0.1;

std::string of_fuel_cut(const EngineFile &engine, const sd_parameters_t &tune, const Evidence &seen) {
    if (seen.cut_firings == 0) return {};
    const auto torque = known_torque(engine, tune);
    if (!torque || !torque->firings) return {};
    const FuelCutPrior prior = fuel_cut_prior(engine, *torque, kalman_tune(engine, tune));
    // What was taken out as compression's exponent is part of what the file has wrong.
    const double per_exponent = prior.exponent_nm_per_bar * seen.cut_bar, read_nm = seen.cut_nm + per_exponent * seen.cut_exponent;
    const double left = kSure * std::hypot(prior.sd_nm_per_bar * seen.cut_bar, per_exponent * seen.exponent_sd);
    if (std::abs(read_nm) <= left) return {};
    return fmt::format("the fuel-cut reading says {:+.1f} Nm a cylinder at {:.2f} bar, where 0 is true and the engine file's tolerances "
                       "leave +-{:.1f}: compression ratio, inertia or wheel of the engine file, or the intake pressure, do not fit",
                       read_nm, seen.cut_bar, left);
}

std::string of_innovations(const Evidence &seen) {
    if (!(seen.late_deg > kLateFactor * seen.expected_deg)) return {};
    return fmt::format("teeth pass {:.3f} deg from where the filter expects them, rms, and {:.3f} would be usual: the wheel's "
                       "tooth pattern is not learned, its edges jitter, or inertia, wheel or combustion of the engine file do not fit",
                       seen.late_deg, seen.expected_deg);
}

std::string of_mark(const Evidence &seen) {
    const double limit = std::max(kBesideMark * seen.pattern_deg, kLeastBesideDeg);
    if (!(seen.pattern_deg > 0 && std::abs(seen.beside_mark_deg) > limit)) return {};
    return fmt::format("a tooth beside the mark stands {:+.2f} deg from its place as learned, other teeth {:.3f} deg rms: the mark "
                       "draws the sensor, or the wheel has another mark than the engine file says",
                       seen.beside_mark_deg, seen.pattern_deg);
}

} // namespace

std::vector<std::string> contradictions(const EngineFile &engine, const sd_parameters_t &tune, const Evidence &seen) {
    std::vector<std::string> all{of_fuel_cut(engine, tune, seen), of_innovations(seen), of_mark(seen)};
    all.erase(std::remove(all.begin(), all.end(), std::string()), all.end());
    return all;
}

void print_contradictions(const std::vector<std::string> &sentences) {
    for (const std::string &sentence : sentences) fmt::print("warning: {}\n", sentence);
}

} // namespace sixdeg
