// SPDX-License-Identifier: MIT
#include "run/bench_run.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "common/stop.hpp"
#include "engine/units.hpp"
#include "scenario/plant.hpp"

namespace sixdeg {
namespace {

/// One run while it lasts.
class Run {
  public:
    Run(const Scenario &scenario, const sd_calibration_t &calibration, RunTables *tables, const EventListener &listener)
        : scenario_(scenario), calibration_(calibration), plant_(scenario, scenario.seed), ecu_(calibration),
          tables_(tables),
          score_(int(calibration.parameters.torque_harmonics), plant_.model().tables().steps, kScoredCycles),
          cylinder_score_(scenario.engine.shared.cylinders(), kScoredCycles), afr_score_(kScoredCycles) {
        plant_.record_steps(&steps_);
        if (listener) ecu_.listen(listener);
    }

    RunResult finish() {
        EncoderEdge edge;
        while (stop_signal() == 0 && plant_.next_edge(edge)) take(edge);
        take_cycles();
        if (plant_.stalled()) ecu_.tell_time_until(rest_ends_s());
        result_.stalled = plant_.stalled();
        result_.counts = ecu_.crank().counts;
        if (plant_.exhaust()) result_.afr = afr_score_.estimate(), result_.balance = afr_score_.balance();
        if (scenario_.speed_mode == SpeedMode::prescribed) return result_;
        result_.torque = score_.result();
        result_.cylinders = cylinder_score_.result();
        return result_;
    }

  private:
    /// No edge tells of standing still, so the clock must; a run of cycles has no end of its own then.
    double rest_ends_s() const {
        if (scenario_.duration_s > 0) return scenario_.duration_s;
        return result_.simulated_s + 2 * double(calibration_.parameters.crank_stall_s);
    }

    void take(const EncoderEdge &edge) {
        ecu_.show(SD_INPUT_AIR_INTAKE_PRESSURE, plant_.intake_pressure_pa() / kPaPerBar);
        ecu_.show(SD_INPUT_FUEL_INJECTED, plant_.commanded_fuel_kg() * 1e6);
        if (!scenario_.balance_on_s.empty()) ecu_.show(SD_INPUT_BALANCE_ENABLE, balancing(edge.time_s));
        take_uego(edge.time_s);
        ecu_.tell_time_until(edge.time_s);
        result_.simulated_s = edge.time_s;
        if (edge.kind == EdgeKind::cam) {
            ecu_.exchange(SD_EVENT_CAM_EDGE, edge.tick);
            return;
        }
        const bool cycle_ended = ecu_.exchange(SD_EVENT_CRANK_EDGE, edge.tick);
        judge(edge);
        if (cycle_ended) end_cycle(edge.time_s);
        if (tables_) tables_->tooth(edge, ecu_);
        if (tables_ && cycle_ended)
            tables_->firmware_cycle_ended(ended_cycle(scenario_.engine.shared, unwrapped_deg(edge)), ecu_);
        take_cycles();
    }

    bool balancing(double time_s) const {
        const auto &on = scenario_.balance_on_s;
        return (std::upper_bound(on.begin(), on.end(), time_s) - on.begin()) % 2 == 1;
    }

    /// The wideband reading is air to fuel over stoichiometric.
    void take_uego(double until_s) {
        UegoSample sample;
        const double s = scenario_.engine.stoichiometric_ratio;
        while (plant_.next_uego(until_s, sample)) {
            ecu_.tell_time_until(sample.time_s);
            ecu_.sample(SD_INPUT_EXHAUST_LAMBDA, ((1 + s) / std::max(sample.lambda, 1e-3) - 1) / s, sample.time_s);
        }
    }

    void end_cycle(double time_s) {
        const sd_signals_t &s = ecu_.signals();
        cylinder_score_.estimate(s, ecu_.health(SD_OWNER_CYLINDER));
        const auto &order = scenario_.engine.shared.firing_order;
        if (!scenario_.balance_on_s.empty()) {
            for (int cylinder : order) plant_.set_fuel_trim(cylinder, 1 + double(s.balance_trim[cylinder - 1]));
        }
        if (!plant_.exhaust()) return;
        std::vector<double> truth(order.size()), estimate(order.size());
        for (std::size_t lane = 0; lane < order.size(); ++lane) {
            const auto i = std::size_t(order[lane] - 1);
            truth[i] = plant_.exhaust()->lambda_of(int(lane));
            estimate[i] = double(s.afr_cylinder_burned[i]);
        }
        afr_score_.cycle(truth, estimate, double(s.afr_cylinder_sd[0]), ecu_.health(SD_OWNER_AFR) == SD_VALID, balancing(time_s));
    }

    // The plant is less than a revolution ahead of the edges it has handed out.
    double unwrapped_deg(const EncoderEdge &edge) const {
        const double ahead_deg = plant_.truth().angle_rad * kDegPerRad;
        return edge.angle_deg + 720 * std::round((ahead_deg - edge.angle_deg) / 720);
    }

    void judge(const EncoderEdge &edge) {
        const sd_signals_t &s = ecu_.signals();
        const bool sure = is_placed(s) && ecu_.health(SD_OWNER_CRANK) == SD_VALID;
        ++result_.edges;
        result_.false_edges += edge.spurious;
        if (sure && int(s.crank_tooth) != edge.tooth) ++result_.wrong_teeth;
        const double off_deg = std::remainder(double(s.crank_angle_deg) - edge.angle_deg, 720.0);
        if (sure && int(s.crank_tooth) == edge.tooth && s.crank_phase_known > 0 && std::abs(off_deg) > kWrongRevolutionDeg)
            ++result_.wrong_revolutions;
        for (const StepTruth &step : steps_) score_.step(step);
        steps_.clear();
        if (s.crank_edge_class == SD_EDGE_SPURIOUS) return; // left out, so the estimate did not move
        const bool settled = is_placed(s) && ecu_.health(SD_OWNER_TORQUE) == SD_VALID && !edge.backward;
        score_.edge(unwrapped_deg(edge), edge.net_torque_nm, double(s.torque_mass_nm), settled);
    }

    void take_cycles() {
        CycleTruth cycle;
        while (plant_.next_cycle(cycle)) {
            ++result_.true_cycles;
            result_.misfires += cycle.misfire;
            cylinder_score_.truth(cycle);
            if (tables_) tables_->true_cycle(cycle);
        }
    }

    const Scenario &scenario_;
    const sd_calibration_t &calibration_;
    Plant plant_;
    EcuBench ecu_;
    RunTables *tables_;
    TorqueScore score_;
    CylinderScore cylinder_score_;
    AfrScore afr_score_;
    std::vector<StepTruth> steps_;
    RunResult result_;
};

} // namespace

RunResult run_on_bench(const Scenario &scenario, const sd_calibration_t &calibration, RunTables *tables,
                       const EventListener &listener) {
    return std::make_unique<Run>(scenario, calibration, tables, listener)->finish();
}

} // namespace sixdeg
