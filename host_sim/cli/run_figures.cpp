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

Json afr_json(const RunResult &result) {
    const std::optional<AfrFigures> &afr = result.afr;
    if (!afr) return Json();
    return {{"cycles_measured", afr->cycles},
            {"rms_points", afr->rms_points},
            {"bias_points", afr->bias_points},
            {"stated_points", afr->stated_points},
            {"spread_true_percent", afr->spread_percent},
            {"wrong_cylinder_percent", afr->wrong_cylinder_percent},
            {"learned_late_ms", 1e3 * result.afr_late_s}};
}

Json balance_json(const std::optional<BalanceFigures> &balance) {
    if (!balance) return Json();
    return {{"spread_before_percent", balance->spread_before_percent},
            {"cycles_to_3_percent", balance->cycles_to_3_percent},
            {"largest_spread_percent", balance->largest_spread_percent},
            {"residual_percent", balance->residual_percent},
            {"wrong_way_percent", balance->wrong_way_percent},
            {"gave_up_cycles", balance->gave_up_cycles}};
}

Json work_json(const std::optional<WorkFigures> &work) {
    if (!work) return Json();
    return {{"cycles", work->cycles},
            {"mean_j", work->mean_j},
            {"spread_percent", work->spread_percent},
            {"correlation", work->correlation},
            {"rms_percent", work->rms_percent},
            {"stated_percent", work->stated_percent},
            {"change_rms_percent", work->change_rms_percent}};
}

void print_work(const std::optional<WorkFigures> &work) {
    if (!work) return;
    fmt::print("work of a cycle, less its mean, {} times: true {:.1f} J, which varies by {:.2f} % of it; correlation {:.3f}, {:.2f} % rms, "
               "stated {:.2f} %{}\n", work->cycles, work->mean_j, work->spread_percent, work->correlation, work->rms_percent,
               work->stated_percent,
               work->change_rms_percent > 0 ? fmt::format("; of a firing against the cycle before {:.2f} % of a firing's",
                                                          work->change_rms_percent)
                                            : std::string());
}

Json driveline_json(const std::optional<DrivelineFigures> &driveline) {
    if (!driveline) return Json();
    return {{"rows", driveline->rows},
            {"changes", driveline->changes},
            {"told_percent", driveline->told_percent},
            {"wrong_percent", driveline->wrong_percent},
            {"torsion_rms_rad", driveline->torsion_rms_rad},
            {"moving_percent", driveline->moving_percent},
            {"reference_told_percent", driveline->reference_told_percent},
            {"reference_wrong_percent", driveline->reference_wrong_percent},
            {"largest_request_nm", driveline->largest_request_nm}};
}

Json perturbation_json(const Perturbation &p) {
    const PerturbationRanges ranges;
    return {{"inertia_percent", p.inertia_percent},
            {"reciprocating_percent", p.reciprocating_percent},
            {"compression_percent", p.compression_percent},
            {"trapped_mass_percent", p.trapped_mass_percent},
            {"wheel_offset_deg", p.wheel_offset_deg},
            {"exhaust_flow_percent", p.exhaust_flow_percent},
            {"uego_tau_percent", p.uego_tau_percent},
            {"uego_delay_deg", p.uego_delay_deg},
            {"ranges",
             {{"inertia_percent", ranges.inertia_percent},
              {"reciprocating_percent", ranges.reciprocating_percent},
              {"compression_percent", ranges.compression_percent},
              {"trapped_mass_percent", ranges.trapped_mass_percent},
              {"wheel_offset_deg", ranges.wheel_offset_deg},
              {"exhaust_flow_percent", ranges.exhaust_flow_percent},
              {"uego_tau_percent", ranges.uego_tau_percent},
              {"uego_delay_deg", ranges.uego_delay_deg}}}};
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
    summary["afr"] = afr_json(nominal);
    summary["balance"] = balance_json(nominal.balance);
    summary["work"] = work_json(nominal.work);
    if (nominal.driveline) summary["driveline"] = driveline_json(nominal.driveline);
    summary["perturbed"] = Json();
    if (!perturbed) return;
    summary["perturbed"] = {{"torque", torque_json(perturbed->result.torque)},
                            {"cylinders", cylinders_json(perturbed->result.cylinders)},
                            {"afr", afr_json(perturbed->result)},
                            {"balance", balance_json(perturbed->result.balance)},
                            {"calibration", perturbation_json(perturbed->perturbation)}};
}

void print_mixture(const RunResult &nominal, const std::optional<PerturbedRun> &perturbed) {
    if (!nominal.afr) return;
    fmt::print("mixture of each cylinder, last {} cycles; points are 0.01 of the mean burned share\n", nominal.afr->cycles);
    const auto afr = [&](const char *name, const char *format, double AfrFigures::*figure) {
        row(name, nominal, perturbed, [&](const RunResult &r) {
            return r.afr ? fmt::format(fmt::runtime(format), (*r.afr).*figure) : "-";
        });
    };
    const auto balance = [&](const char *name, const char *format, double BalanceFigures::*figure) {
        if (!nominal.balance) return;
        row(name, nominal, perturbed, [&](const RunResult &r) {
            return r.balance ? fmt::format(fmt::runtime(format), (*r.balance).*figure) : "-";
        });
    };
    afr("estimate, rms", "{:.2f} points", &AfrFigures::rms_points);
    afr("bias, worst cylinder", "{:.2f} points", &AfrFigures::bias_points);
    afr("stated deviation", "{:.2f} points", &AfrFigures::stated_points);
    afr("wrong cylinder", "{:.1f} %", &AfrFigures::wrong_cylinder_percent);
    afr("true spread", "{:.2f} %", &AfrFigures::spread_percent);
    row("delay to the sensor learned", nominal, perturbed,
        [](const RunResult &r) { return fmt::format("{:+.2f} ms", 1e3 * r.afr_late_s); });
    balance("spread before balancing", "{:.2f} %", &BalanceFigures::spread_before_percent);
    balance("cycles to below 3 %, -1 never", "{:.0f}", &BalanceFigures::cycles_to_3_percent);
    balance("largest spread since", "{:.2f} %", &BalanceFigures::largest_spread_percent);
    balance("residual", "{:.2f} %", &BalanceFigures::residual_percent);
    balance("a trim the wrong way", "{:.2f} %", &BalanceFigures::wrong_way_percent);
    balance("cycles to giving up, -1 never", "{:.0f}", &BalanceFigures::gave_up_cycles);
}

void print_driveline(const std::optional<DrivelineFigures> &driveline) {
    if (!driveline) return;
    const DrivelineFigures &d = *driveline;
    fmt::print("driveline every 10 ms: {} true changes of location; told {:.1f} % of the time, wrong location {:.2f} % of that, "
               "torsion {:.2e} rad rms;\n"
               "  moving {:.1f} %; document 003's observers told {:.1f} %, wrong {:.1f} %; largest damping request {:.1f} Nm\n",
               d.changes, d.told_percent, d.wrong_percent, d.torsion_rms_rad, d.moving_percent, d.reference_told_percent,
               d.reference_wrong_percent, d.largest_request_nm);
}

void print_accuracy(const RunResult &nominal, const std::optional<PerturbedRun> &perturbed) {
    print_driveline(nominal.driveline);
    print_mixture(nominal, perturbed);
    print_work(nominal.work);
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
