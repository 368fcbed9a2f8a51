// SPDX-License-Identifier: MIT
#include "cli/firing_report.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "design/torque/known_torque.hpp"
#include "plant/engine/units.hpp"
#include "studies/limits/firing_bound.hpp"

namespace sixdeg {
namespace {

constexpr int kWindowCycles = 25;

} // namespace

std::optional<FiringBounds> firing_bounds(const Scenario &scenario, const sd_parameters_t &tune, const RunResult &result) {
    const EngineFile &engine = scenario.engine.shared;
    auto known = known_torque(engine, tune);
    if (!result.firing || !known || !known->firings) return std::nullopt;
    known->shape.clear(); // it is learned over longer than the window
    KalmanTune truth = kalman_tune(engine, tune);
    truth.edge_deg = scenario.encoder.jitter_deg;
    const double speed = result.firing->mean_radps;
    const ToothModel model = tooth_model(engine, *known, speed);
    const ToothNoise noise = tooth_noise(engine, truth, speed);
    const double left_deg = result.pattern_sd_deg > 0 ? std::min(result.pattern_sd_deg, scenario.encoder.pattern_rms_deg)
                                                      : scenario.encoder.pattern_rms_deg;
    const BoundNoise constant{std::max(noise.edge_rad, 1e-9), left_deg * kRadPerDeg, 0, noise.firing_change};
    BoundNoise walking = constant;
    walking.constant_walk = noise.constant_walk;
    const double percent = 100 * mean_inertia_kgm2(engine) * speed * speed / result.firing->mean_nm;
    const auto both = [&](const BoundNoise &bound, int cycles) { return percent * firing_bound(model, bound, cycles, kWindowCycles); };
    return FiringBounds{both(constant, 1), both(constant, FiringScore::kMeanCycles), both(walking, 1),
                        both(walking, FiringScore::kMeanCycles)};
}

nlohmann::ordered_json firing_json(const RunResult &result, const std::optional<FiringBounds> &bounds) {
    if (!result.firing) return {};
    const FiringFigures &f = *result.firing;
    nlohmann::ordered_json json{{"cycles", f.cycles}, {"mean_nm", f.mean_nm}, {"bias_percent", f.bias_percent},
                                {"single_percent", f.single_percent}, {"single_max_percent", f.single_max_percent},
                                {"imbalance_percent", f.imbalance_percent}, {"imbalance_max_percent", f.imbalance_max_percent},
                                {"single_over_stated", f.single_honesty}, {"imbalance_over_stated", f.imbalance_honesty},
                                {"invalid", f.invalid}, {"pattern_sd_deg", result.pattern_sd_deg},
                                {"exponent", result.exponent}, {"exponent_sd", result.exponent_sd}};
    if (bounds) {
        json["single_bound_percent"] = bounds->single_percent, json["imbalance_bound_percent"] = bounds->imbalance_percent;
        json["single_over_bound"] = f.single_percent / bounds->single_percent;
        json["imbalance_over_bound"] = f.imbalance_percent / bounds->imbalance_percent;
        json["single_walk_bound_percent"] = bounds->single_walk_percent,
            json["imbalance_walk_bound_percent"] = bounds->imbalance_walk_percent;
        json["single_over_walk_bound"] = f.single_percent / bounds->single_walk_percent;
        json["imbalance_over_walk_bound"] = f.imbalance_percent / bounds->imbalance_walk_percent;
    }
    if (result.learned.pattern.twist.variance > 0) {
        json["twist_percent"] = 100 * double(result.learned.pattern.twist.deviation);
        json["twist_sd_percent"] = 100 * double(sd_twist_sd(&result.learned.pattern.twist));
    }
    if (result.waveform) {
        json["waveform_rms_percent"] = result.waveform->rms_true_percent, json["waveform_shift_deg"] = result.waveform->shift_deg;
    }
    return json;
}

void print_firing(const char *heading, const RunResult &result, const std::optional<FiringBounds> &bounds) {
    const auto row = [](const char *name, const std::string &value) { fmt::print("{:<34}{}\n", name, value); };
    if (!result.firing) {
        row(heading, "none: no whole cycle with the filter valid");
        return;
    }
    const FiringFigures &f = *result.firing;
    const auto figure = [&](double rms, double largest, double over_stated, double bound, double walking) {
        const std::string beside = bound > 0
            ? fmt::format(", bound {:.3f} %, ratio {:.2f} (load walking {:.3f} %, {:.2f})", bound, rms / bound,
                                                           walking, rms / walking) : "";
        return fmt::format("{:.3f} % rms, {:.3f} % largest{}; {:.2f} of what is stated", rms, largest, beside, over_stated);
    };
    row(heading, fmt::format("{} cycles, mean {:.2f} Nm, bias {:+.2f} %", f.cycles, f.mean_nm, f.bias_percent));
    row("  one firing", figure(f.single_percent, f.single_max_percent, f.single_honesty, bounds ? bounds->single_percent : 0,
                               bounds ? bounds->single_walk_percent : 0));
    row("  imbalance over 10 cycles", figure(f.imbalance_percent, f.imbalance_max_percent, f.imbalance_honesty,
                                             bounds ? bounds->imbalance_percent : 0,
                                             bounds ? bounds->imbalance_walk_percent : 0));
    if (result.waveform)
        row("  waveform", fmt::format("{:.2f} % rms, shift {:+.3f} deg", result.waveform->rms_true_percent, result.waveform->shift_deg));
    if (result.pattern_sd_deg > 0)
        row("  tooth pattern learned to",
            fmt::format("{:.4f} deg over {:.0f} cycles", result.pattern_sd_deg, double(result.learned.pattern.cycles)));
    if (result.exponent != 0)
        row("  exponent of compression",
            fmt::format("{:+.4f} beyond the calibration's, stated to {:.4f}", result.exponent, result.exponent_sd));
    const sd_twist_sums_t &twist = result.learned.pattern.twist;
    if (twist.variance > 0)
        row("  frequency of the crank's twist",
            fmt::format("{:+.3f} % beyond the tables, stated to {:.3f} %", 100 * double(twist.deviation),
                                                            100 * double(sd_twist_sd(&twist))));
}

} // namespace sixdeg
