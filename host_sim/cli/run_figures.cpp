// SPDX-License-Identifier: MIT
#include "cli/run_figures.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <string>

namespace sixdeg {
namespace {

using Json = nlohmann::ordered_json;

Json torque_json(const std::optional<TorqueFigures> &torque) {
    if (!torque) return Json();
    return {{"cycles_measured", torque->cycles},
            {"true_peak_to_peak_nm", torque->true_pp_nm},
            {"rms_true_percent", torque->rms_true_percent},
            {"rms_projection_percent", torque->rms_projection_percent},
            {"truncation_percent", torque->truncation_percent},
            {"shift_deg", torque->shift_deg}};
}

Json cylinders_json(const std::optional<CylinderFigures> &cylinders) {
    if (!cylinders) return Json();
    return {{"cycles_measured", cylinders->cycles},
            {"true_nm", cylinders->true_nm},
            {"estimate_nm", cylinders->estimate_nm},
            {"sd_nm", cylinders->sd_nm},
            {"mean_error_percent", cylinders->mean_error_percent},
            {"imbalance_percent", cylinders->imbalance_percent},
            {"imbalance_rms_percent", cylinders->imbalance_rms_percent}};
}

Json perturbation_json(const Perturbation &p) {
    const PerturbationRanges ranges;
    return {{"inertia_percent", p.inertia_percent},
            {"reciprocating_percent", p.reciprocating_percent},
            {"compression_percent", p.compression_percent},
            {"trapped_mass_percent", p.trapped_mass_percent},
            {"wheel_offset_deg", p.wheel_offset_deg},
            {"ranges",
             {{"inertia_percent", ranges.inertia_percent},
              {"reciprocating_percent", ranges.reciprocating_percent},
              {"compression_percent", ranges.compression_percent},
              {"trapped_mass_percent", ranges.trapped_mass_percent},
              {"wheel_offset_deg", ranges.wheel_offset_deg}}}};
}

/// One figure of both runs; "-" where a run has none.
template <class Value>
void row(const char *name, const RunResult &nominal, const std::optional<PerturbedRun> &perturbed, Value value) {
    const std::string other = perturbed ? value(perturbed->result) : std::string();
    fmt::print("  {:<32}{:<16}{}\n", name, value(nominal), other);
}

} // namespace

void add_figures(Json &summary, const RunResult &nominal, const std::optional<PerturbedRun> &perturbed) {
    summary["torque"] = torque_json(nominal.torque);
    summary["cylinders"] = cylinders_json(nominal.cylinders);
    summary["perturbed"] = Json();
    if (!perturbed) return;
    summary["perturbed"] = {{"torque", torque_json(perturbed->result.torque)},
                            {"cylinders", cylinders_json(perturbed->result.cylinders)},
                            {"calibration", perturbation_json(perturbed->perturbation)}};
}

void print_accuracy(const RunResult &nominal, const std::optional<PerturbedRun> &perturbed) {
    if (!nominal.torque) {
        fmt::print("torque against truth: none, no settled cycle or the speed is prescribed\n");
        return;
    }
    fmt::print("torque against truth, last {} cycles; true peak to peak {:.1f} Nm, n_h leaves out {:.2f} % of it\n",
               nominal.torque->cycles, nominal.torque->true_pp_nm, nominal.torque->truncation_percent);
    fmt::print("  {:<32}{:<16}{}\n", "calibration", "nominal", perturbed ? "perturbed" : "");
    const auto torque = [&](const char *name, const char *format, double TorqueFigures::*figure) {
        row(name, nominal, perturbed, [&](const RunResult &r) {
            return r.torque ? fmt::format(fmt::runtime(format), (*r.torque).*figure) : "-";
        });
    };
    const auto cylinders = [&](const char *name, const char *format, double CylinderFigures::*figure) {
        row(name, nominal, perturbed, [&](const RunResult &r) {
            return r.cylinders ? fmt::format(fmt::runtime(format), (*r.cylinders).*figure) : "-";
        });
    };
    torque("waveform, rms", "{:.2f} %", &TorqueFigures::rms_true_percent);
    torque("waveform, rms against n_h", "{:.2f} %", &TorqueFigures::rms_projection_percent);
    torque("shift", "{:+.3f} deg", &TorqueFigures::shift_deg);
    cylinders("imbalance, worst cylinder", "{:.2f} %", &CylinderFigures::imbalance_percent);
    cylinders("mean of all cylinders", "{:+.2f} %", &CylinderFigures::mean_error_percent);
}

} // namespace sixdeg
