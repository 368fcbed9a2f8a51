// SPDX-License-Identifier: MIT
#include "loop/bench_run.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "common/error.hpp"
#include "common/progress.hpp"
#include "common/stop.hpp"
#include "loop/air_path_feed.hpp"
#include "plant/engine/units.hpp"
#include "plant/scenario/plant.hpp"

namespace sixdeg {
namespace {

/// One run while it lasts. Events go to the ecu at once; what it says of an edge comes when the next time event
/// has been answered, and waits for nobody's truth to reach it.
class Run {
  public:
    Run(const Scenario &scenario, const sd_calibration_t &calibration, EcuFeed &ecu, RunTables *tables, TruthSink *truth)
        : scenario_(scenario), calibration_(calibration), plant_(scenario, scenario.seed), ecu_(ecu), tables_(tables),
          truth_(truth),
          score_(int(calibration.parameters.torque_harmonics), plant_.model().tables().steps, kScoredCycles),
          waveform_(kWaveformHarmonics, plant_.model().tables().steps, kScoredCycles),
          cylinder_score_(scenario.engine.shared.cylinders(), kScoredCycles), firing_(scenario.engine.shared),
              work_(scenario.engine.shared),
          misfire_(scenario.engine.shared), monitor_(scenario.engine.shared), afr_score_(kScoredCycles), balance_score_(kScoredCycles),
          driveline_score_(double(calibration.tick_hz)),
          progress_("simulating", scenario.duration_s > 0 ? scenario.duration_s : double(scenario.cycles), Progress::share) {
        if (plant_.car()) plant_.watch_steps([this] { note_car(); });
        plant_.record_steps(&steps_);
        ecu_.record_answers(&heard_);
    }

    RunResult finish() {
        EncoderEdge edge;
        while (stop_signal() == 0 && plant_.next_edge(edge)) take(edge);
        take_cycles();
        ecu_.finish(plant_.stalled() ? rest_ends_s() : result_.simulated_s);
        judge_answered();
        answers_.take_rest(said_);
        ecu_.record_answers(nullptr);
        result_.stalled = plant_.stalled();
        result_.misfire = misfire_.result();
        result_.monitor = monitor_.result();
        result_.sync_losses = said_.sync_losses();
        result_.unanswered = answers_.missing();
        result_.afr_late_s = double(said_.signals().afr_late_s);
        if (plant_.car()) result_.driveline = driveline_score_.result();
        if (plant_.exhaust()) result_.afr = afr_score_.estimate(), result_.balance = balance_score_.result();
        if (scenario_.speed_mode == SpeedMode::prescribed) return result_;
        result_.torque = score_.result();
        result_.waveform = waveform_.result();
        result_.cylinders = cylinder_score_.result();
        result_.firing = firing_.result();
        result_.work = work_.result();
        return result_;
    }

  private:
    struct Sent { // a crank edge whose answer is to come
        EncoderEdge edge;
        double crank_deg;
    };

    /// No edge tells of standing still, so the clock must; a run of cycles has no end of its own then.
    double rest_ends_s() const {
        if (scenario_.duration_s > 0) return scenario_.duration_s;
        return result_.simulated_s + 2 * double(calibration_.parameters.crank_stall_time_s);
    }

    void take(const EncoderEdge &edge) {
        if (!scenario_.air_path) ecu_.show(SD_INPUT_AIR_INTAKE_PRESSURE, plant_.intake_pressure_pa() / kPaPerBar);
        show_exhaust();
        ecu_.show(SD_INPUT_FUEL_INJECTED, plant_.commanded_fuel_kg() * 1e6);
        if (!scenario_.balance_on_s.empty()) ecu_.show(SD_INPUT_BALANCE_ENABLE, balancing(edge.time_s));
        if (plant_.car()) ecu_.show(SD_INPUT_DRIVELINE_GEAR, plant_.car()->gear());
        take_samples(edge.time_s);
        take_wheel_edges(edge.time_s);
        take_air_path(edge.time_s);
        ecu_.tell_time_until(edge.time_s);
        if (ecu_.clock_events() != judged_) judge_answered();
        judged_ = ecu_.clock_events();
        result_.simulated_s = edge.time_s;
        progress_.at(scenario_.duration_s > 0 ? edge.time_s : double(result_.true_cycles / scenario_.engine.shared.firing_order.size()));
        const bool crank = edge.kind == EdgeKind::crank;
        ecu_.send({edge.tick, std::uint16_t(crank ? SD_EVENT_CRANK_EDGE : SD_EVENT_CAM_EDGE), 0, 0, 0});
        score_.steps(steps_), waveform_.steps(steps_);
        steps_.clear();
        if (!crank) return;
        sent_.push_back({edge, unwrapped_deg(edge)});
        if (truth_) truth_->edge(edge, sent_.back().crank_deg);
        take_cycles();
    }

    bool balancing(double time_s) const {
        const auto &on = scenario_.balance_on_s;
        return (std::upper_bound(on.begin(), on.end(), time_s) - on.begin()) % 2 == 1;
    }

    void show_exhaust() {
        // Without an air path of its own the valve is an opening of one size, or none.
        const bool recirculates = plant_.exhaust() && scenario_.engine.exhaust.egr_area_m2 > 0;
        if (recirculates && !scenario_.air_path) ecu_.show(SD_INPUT_EGR_POSITION, 1);
        if (!scenario_.exhaust_sensors) return;
        const exhaust::ExhaustModel &e = *plant_.exhaust();
        if (scenario_.exhaust_sensors->temperature) ecu_.show(SD_INPUT_EXHAUST_TEMPERATURE, e.manifold().temperature_k());
        if (scenario_.exhaust_sensors->turbine_speed) ecu_.show(SD_INPUT_EXHAUST_TURBINE_SPEED, e.turbine_radps() / kRadpsPerRpm);
    }

    /// Of the sensors that are read often, in order of time.
    void take_samples(double until_s) {
        UegoSample sample;
        while (plant_.next_uego(until_s, sample)) {
            take_pressures(sample.time_s);
            take_uego(sample);
        }
        take_pressures(until_s);
    }

    void take_pressures(double until_s) {
        PressureSample sample;
        while (plant_.next_exhaust_pressure(until_s, sample)) {
            ecu_.tell_time_until(sample.time_s);
            ecu_.sample(SD_INPUT_EXHAUST_PRESSURE, sample.pascal / kPaPerBar, sample.time_s);
        }
    }

    /// The time of a time event between them is told first.
    void take_wheel_edges(double until_s) {
        double edge_s;
        while (plant_.next_wheel_edge(until_s, edge_s)) {
            ecu_.tell_time_until(edge_s);
            ecu_.send({ecu_.tick_at(edge_s), SD_EVENT_WHEEL_EDGE, SD_WHEEL_FRONT_LEFT, 0, 0});
        }
    }

    void take_air_path(double until_s) {
        airpath::Readings readings;
        airpath::Truth truth;
        while (plant_.next_air_path(until_s, readings, truth)) {
            ecu_.tell_time_until(readings.time_s);
            send_readings(ecu_, readings);
            if (tables_) tables_->air_path().row(readings, truth);
        }
    }

    /// The wideband reading is air to fuel over stoichiometric.
    void take_uego(const UegoSample &sample) {
        const double s = scenario_.engine.stoichiometric_ratio;
        ecu_.tell_time_until(sample.time_s);
        ecu_.sample(SD_INPUT_EXHAUST_LAMBDA, ((1 + s) / std::max(sample.lambda, 1e-3) - 1) / s, sample.time_s);
    }

    void end_cycle(double time_s) {
        const sd_signals_t &s = said_.signals();
        cylinder_score_.estimate(s, said_.health(SD_OWNER_CYLINDER));
        const auto &order = scenario_.engine.shared.firing_order;
        if (!scenario_.balance_on_s.empty()) {
            for (int cylinder : order) plant_.set_fuel_trim(cylinder, 1 + double(s.balance_trim[cylinder - 1]));
        }
        if (plant_.exhaust()) score_mixture(time_s);
    }

    void score_mixture(double time_s) {
        const sd_signals_t &s = said_.signals();
        const auto &order = scenario_.engine.shared.firing_order;
        BalanceCycle b{std::vector<double>(order.size()), {}, {}, balancing(time_s), said_.health(SD_OWNER_BALANCE) == SD_INVALID};
        std::vector<double> estimate;
        for (std::size_t lane = 0; lane < order.size(); ++lane) {
            b.lambda[std::size_t(order[lane] - 1)] = plant_.exhaust()->lambda_of(int(lane));
            b.trim.push_back(double(s.balance_trim[lane]));
            b.injector.push_back(plant_.injector_factor(int(lane) + 1));
            estimate.push_back(double(s.afr_cylinder_burned[lane]));
        }
        balance_score_.cycle(b);
        if (said_.health(SD_OWNER_AFR) == SD_VALID) afr_score_.cycle(b.lambda, estimate, double(s.afr_cylinder_sd[0]));
    }

    void note_car() {
        const VehicleModel &car = plant_.car()->model();
        driveline_score_.truth(car.state().time_s, car.location(), car.state().twist_rad);
    }

    /// Whatever has no answer by now will get none.
    void judge_answered() {
        if (plant_.car()) {
            for (const sd_event_t &event : heard_) driveline_score_.said(event);
        }
        answers_.add(heard_);
        if (tables_ && scenario_.air_path)
            for (const sd_event_t &event : heard_) tables_->air_path().said(event);
        heard_.clear();
        for (const Sent &sent : sent_) judge(sent);
        sent_.clear();
    }

    // The plant is less than a revolution ahead of the edges it has handed out.
    double unwrapped_deg(const EncoderEdge &edge) const {
        const double ahead_deg = plant_.truth().angle_rad * kDegPerRad;
        return edge.angle_deg + 720 * std::round((ahead_deg - edge.angle_deg) / 720);
    }

    void judge(const Sent &sent) {
        const EncoderEdge &edge = sent.edge;
        const bool cycle_ended = answers_.take(edge.tick, said_);
        const sd_signals_t &s = said_.signals();
        const bool sure = is_placed(s) && said_.health(SD_OWNER_CRANK) == SD_VALID;
        ++result_.edges;
        result_.false_edges += edge.spurious;
        if (sure && int(s.crank_tooth) != edge.tooth) ++result_.wrong_teeth;
        const double off_deg = std::remainder(double(s.crank_angle_deg) - edge.angle_deg, 720.0);
        if (sure && int(s.crank_tooth) == edge.tooth && s.crank_phase_known > 0 && std::abs(off_deg) > kWrongRevolutionDeg)
            ++result_.wrong_revolutions;
        take_firing(sent.crank_deg);
        take_work(sent.crank_deg);
        if (cycle_ended) end_cycle(edge.time_s);
        if (tables_) tables_->edge(edge, sent.crank_deg, said_, cycle_ended);
        if (s.crank_edge_class == SD_EDGE_SPURIOUS) return; // left out, so the estimate did not move
        const bool settled = is_placed(s) && said_.health(SD_OWNER_TORQUE) == SD_VALID && !edge.backward;
        score_.edge(sent.crank_deg, edge.net_torque_nm, double(s.torque_mass_nm), settled);
        const bool followed = is_placed(s) && said_.health(SD_OWNER_FIRING) == SD_VALID && !edge.backward;
        waveform_.edge(sent.crank_deg, edge.net_torque_nm, double(s.firing_waveform_nm), followed);
    }

    void take_work(double crank_deg) {
        if (std::exchange(works_, said_.works()) == said_.works() || said_.health(SD_OWNER_WORK) == SD_INVALID) return;
        const sd_signals_t &s = said_.signals();
        const auto change = s.work_cylinder > 0.5f ? std::optional(double(s.work_change_j)) : std::nullopt;
        work_.said(crank_deg, std::size_t(s.work_firing), double(s.work_cycle_j), double(s.work_sd_j), change);
    }

    void take_firing(double crank_deg) {
        if (said_.firings() == firings_) return;
        firings_ = said_.firings();
        const sd_signals_t &s = said_.signals();
        firing_.said(crank_deg, int(s.firing_cylinder), double(s.firing_torque_nm), double(s.firing_sd_nm),
                     double(s.firing_mean_nm), double(s.firing_mean_sd_nm), said_.health(SD_OWNER_FIRING) == SD_VALID);
        misfire_.said(crank_deg, int(s.firing_cylinder), int(s.misfire_verdict), double(s.misfire_index));
        monitor_.said(crank_deg, int(s.firing_cylinder), int(s.misfire_monitor), double(s.misfire_index));
    }

    void take_cycles() {
        CycleTruth cycle;
        while (plant_.next_cycle(cycle)) {
            ++result_.true_cycles;
            result_.misfires += cycle.misfire;
            firing_.truth(cycle);
            work_.truth(cycle);
            misfire_.truth(cycle);
            monitor_.truth(cycle);
            cylinder_score_.truth(cycle);
            if (tables_) tables_->true_cycle(cycle);
            if (truth_) truth_->cycle(cycle);
        }
    }

    const Scenario &scenario_;
    const sd_calibration_t &calibration_;
    Plant plant_;
    EcuFeed &ecu_;
    RunTables *tables_;
    TruthSink *truth_;
    TorqueScore score_, waveform_;
    CylinderScore cylinder_score_;
    FiringScore firing_;
    WorkScore work_;
    MisfireScore misfire_, monitor_;
    AfrScore afr_score_;
    BalanceScore balance_score_;
    DrivelineScore driveline_score_;
    std::size_t firings_ = 0, works_ = 0;
    std::vector<Sent> sent_;
    std::vector<sd_event_t> heard_;
    Answers answers_;
    EcuSaid said_;
    std::size_t judged_ = 0;
    std::vector<StepTruth> steps_;
    RunResult result_;
    Progress progress_;
};

} // namespace

RunResult run_scenario(const Scenario &scenario, const sd_calibration_t &calibration, EcuFeed &ecu, RunTables *tables,
                       TruthSink *truth) {
    return std::make_unique<Run>(scenario, calibration, ecu, tables, truth)->finish();
}

RunResult run_on_bench(const Scenario &scenario, const sd_calibration_t &calibration, RunTables *tables,
                       const sd_kept_t *learned, const EventListener &listener, std::optional<double> restart_s) {
    const auto bench = std::make_unique<EcuBench>(calibration);
    if (restart_s) bench->restart_at(*restart_s);
    if (listener) bench->listen(listener);
    if (learned && !bench->resume(*learned))
        throw InputError("learned page", "",
                         "it is of another wheel or another lambda sensor, or the engine file has neither heat release nor exhaust");
    RunResult result = run_scenario(scenario, calibration, *bench, tables);
    result.learned = bench->learned();
    result.evidence = bench->evidence();
    result.pattern_sd_deg = double(bench->pattern().sd_rad) * kDegPerRad;
    if (bench->pattern().exponent != 0) {
        result.exponent = double(bench->pattern().exponent), result.exponent_sd = double(bench->pattern().exponent_sd);
    }
    return result;
}

} // namespace sixdeg
