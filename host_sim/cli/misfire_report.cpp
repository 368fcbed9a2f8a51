// SPDX-License-Identifier: MIT
#include "cli/misfire_report.hpp"

#include <cmath>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;

Json rate_json(std::uint64_t hits, std::uint64_t trials) {
    const RateBounds bounds = rate_bounds(hits, trials);
    return {{"hits", hits},
            {"of", trials},
            {"percent", trials ? Json(100.0 * double(hits) / double(trials)) : Json()},
            {"bounds_95_percent", {100 * bounds.low, 100 * bounds.high}}};
}

void print_rate(const char *name, std::uint64_t hits, std::uint64_t trials) {
    if (trials == 0) return;
    const RateBounds bounds = rate_bounds(hits, trials);
    fmt::print("  {:<32}{} of {}: {:.3f} % (95 %: {:.3f} to {:.3f})\n", name, hits, trials, 100.0 * double(hits) / double(trials),
               100 * bounds.low, 100 * bounds.high);
}

} // namespace

double separation_bound(const Scenario &scenario, const std::optional<FiringBounds> &bounds) {
    if (!bounds) return 0;
    const double noise = bounds->single_percent / 100;
    return 2 / (noise + std::hypot(noise, scenario.cyclic_cov.at(scenario.bmep_pa.at(0))));
}

std::string method_of(const sd_parameters_t &tune) {
    static const char *const names[] = {"monitor", "FOLSMO", "FOSMO", "ROO"};
    const int method = int(tune.misfire_method);
    return method == 0 ? names[0] : fmt::format("{}, {}", names[method], tune.misfire_arithmetic > 0.5f ? "q31" : "f32");
}

Json beside_json(const MisfireFigures &f) {
    return {{"detected", rate_json(f.detected, f.missed)}, {"false_alarms", rate_json(f.false_alarms, f.healthy)},
            {"wrong_cylinder", f.wrong_cylinder}, {"not_judged", f.not_judged}};
}

void print_beside(const char *heading, const MisfireFigures &f) {
    fmt::print("{:<34}{} firings not judged\n", heading, f.not_judged);
    print_rate("misfires detected", f.detected, f.missed);
    print_rate("false alarms", f.false_alarms, f.healthy);
}

Json misfire_json(const MisfireFigures &f, double separation_bound) {
    return {{"detected", rate_json(f.detected, f.missed)},
            {"false_alarms", rate_json(f.false_alarms, f.healthy)},
            {"wrong_cylinder", f.wrong_cylinder},
            {"partial_found", rate_json(f.partial_found, f.partial)},
            {"partial_as_misfire", f.partial_as_misfire},
            {"healthy_as_partial", rate_json(f.healthy_as_partial, f.healthy)},
            {"separation", f.separation()},
            {"separation_bound", separation_bound > 0 ? Json(separation_bound) : Json()},
            {"index_healthy", f.healthy ? Json(f.index_sum / double(f.healthy)) : Json()},
            {"index_healthy_sd", f.healthy_sd()},
            {"index_missed_sd", f.missed_sd()},
            {"not_judged", f.not_judged},
            {"not_judged_misfires", f.not_judged_misfires}};
}

void print_misfire(const char *heading, const MisfireFigures &f, double separation_bound) {
    if (f.healthy + f.missed == 0) {
        fmt::print("{:<34}judged no firing\n", heading);
        return;
    }
    fmt::print("{:<34}{} firings not judged\n", heading, f.not_judged);
    print_rate("misfires detected", f.detected, f.missed);
    print_rate("false alarms", f.false_alarms, f.healthy);
    print_rate("partial burns found", f.partial_found, f.partial);
    print_rate("healthy called partial", f.healthy_as_partial, f.healthy);
    if (f.missed == 0) return;
    fmt::print("  {:<32}{:.2f} deviations", "separation", f.separation());
    if (separation_bound > 0) fmt::print(", bound {:.2f}, ratio {:.2f}", separation_bound, f.separation() / separation_bound);
    fmt::print("\n");
}

} // namespace sixdeg
