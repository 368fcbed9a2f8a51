// SPDX-License-Identifier: MIT
#include "run/bench_run.hpp"

#include <cmath>
#include <memory>

#include "common/error.hpp"
#include "common/stop.hpp"
#include "engine/units.hpp"
#include "scenario/plant.hpp"

namespace sixdeg {
namespace {

/// One run while it lasts.
class Run {
  public:
    Run(const Scenario &scenario, const sd_calibration_t &calibration, RunTables *tables, const sd_pattern_sums_t *learned,
        const EventListener &listener)
        : scenario_(scenario), calibration_(calibration), plant_(scenario, scenario.seed), ecu_(calibration),
          tables_(tables),
          score_(int(calibration.parameters.torque_harmonics), plant_.model().tables().steps, kScoredCycles),
          waveform_(kWaveformHarmonics, plant_.model().tables().steps, kScoredCycles),
          cylinder_score_(scenario.engine.shared.cylinders(), kScoredCycles), firing_(scenario.engine.shared),
          misfire_(scenario.engine.shared) {
        plant_.record_steps(&steps_);
        if (listener) ecu_.listen(listener);
        if (learned && !ecu_.resume(*learned))
            throw InputError("learned page", "pattern", "it is of another wheel, or the engine file has no heat release");
    }

    RunResult finish() {
        EncoderEdge edge;
        while (stop_signal() == 0 && plant_.next_edge(edge)) take(edge);
        take_cycles();
        if (plant_.stalled()) ecu_.tell_time_until(rest_ends_s());
        result_.stalled = plant_.stalled();
        result_.misfire = misfire_.result();
        result_.counts = ecu_.crank().counts;
        result_.learned = ecu_.pattern().sums;
        result_.pattern_sd_deg = double(ecu_.pattern().sd_rad) * kDegPerRad;
        if (scenario_.speed_mode == SpeedMode::prescribed) return result_;
        result_.torque = score_.result();
        result_.waveform = waveform_.result();
        result_.cylinders = cylinder_score_.result();
        result_.firing = firing_.result();
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
        ecu_.tell_time_until(edge.time_s);
        result_.simulated_s = edge.time_s;
        if (edge.kind == EdgeKind::cam) {
            ecu_.exchange(SD_EVENT_CAM_EDGE, edge.tick);
            return;
        }
        const bool cycle_ended = ecu_.exchange(SD_EVENT_CRANK_EDGE, edge.tick);
        judge(edge);
        take_firing(edge);
        if (cycle_ended) cylinder_score_.estimate(ecu_.signals(), ecu_.health(SD_OWNER_CYLINDER));
        if (tables_) tables_->tooth(edge, ecu_);
        if (tables_ && cycle_ended)
            tables_->firmware_cycle_ended(ended_cycle(scenario_.engine.shared, unwrapped_deg(edge)), ecu_);
        take_cycles();
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
        for (const StepTruth &step : steps_) score_.step(step), waveform_.step(step);
        steps_.clear();
        if (s.crank_edge_class == SD_EDGE_SPURIOUS) return; // left out, so the estimate did not move
        const bool settled = is_placed(s) && ecu_.health(SD_OWNER_TORQUE) == SD_VALID && !edge.backward;
        score_.edge(unwrapped_deg(edge), edge.net_torque_nm, double(s.torque_mass_nm), settled);
        const bool followed = is_placed(s) && ecu_.health(SD_OWNER_FIRING) == SD_VALID && !edge.backward;
        waveform_.edge(unwrapped_deg(edge), edge.net_torque_nm, double(s.firing_waveform_nm), followed);
    }

    void take_firing(const EncoderEdge &edge) {
        if (ecu_.firings() == firings_) return;
        firings_ = ecu_.firings();
        const sd_signals_t &s = ecu_.signals();
        firing_.said(unwrapped_deg(edge), int(s.firing_cylinder), double(s.firing_torque_nm), double(s.firing_sd_nm),
                     double(s.firing_mean_nm), double(s.firing_mean_sd_nm), ecu_.health(SD_OWNER_FIRING) == SD_VALID);
        misfire_.said(unwrapped_deg(edge), int(s.firing_cylinder), int(s.misfire_verdict), double(s.misfire_index));
        if (tables_)
            tables_->firing_judged(unwrapped_deg(edge), int(s.firing_cylinder), int(s.misfire_verdict), double(s.misfire_index));
    }

    void take_cycles() {
        CycleTruth cycle;
        while (plant_.next_cycle(cycle)) {
            ++result_.true_cycles;
            result_.misfires += cycle.misfire;
            firing_.truth(cycle);
            misfire_.truth(cycle);
            cylinder_score_.truth(cycle);
            if (tables_) tables_->true_cycle(cycle);
        }
    }

    const Scenario &scenario_;
    const sd_calibration_t &calibration_;
    Plant plant_;
    EcuBench ecu_;
    RunTables *tables_;
    TorqueScore score_, waveform_;
    CylinderScore cylinder_score_;
    FiringScore firing_;
    MisfireScore misfire_;
    std::uint32_t firings_ = 0;
    std::vector<StepTruth> steps_;
    RunResult result_;
};

} // namespace

RunResult run_on_bench(const Scenario &scenario, const sd_calibration_t &calibration, RunTables *tables,
                       const sd_pattern_sums_t *learned, const EventListener &listener) {
    return std::make_unique<Run>(scenario, calibration, tables, learned, listener)->finish();
}

} // namespace sixdeg
