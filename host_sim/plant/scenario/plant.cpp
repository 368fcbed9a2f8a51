// SPDX-License-Identifier: MIT
#include "plant/scenario/plant.hpp"

#include <algorithm>
#include <cmath>

#include "common/error.hpp"
#include "common/streams.hpp"

namespace sixdeg {
namespace {

constexpr int kPreRollCycles = 2;
constexpr double kStartAirFraction = 0.5; // of the exhaust, gone by the end of it
constexpr double kGovernorLimitPa = 40 * kPaPerBar;

std::vector<CylinderSpread> spread_of(const Scenario &scenario) {
    std::vector<CylinderSpread> spread;
    for (int cylinder : scenario.engine.shared.firing_order) {
        spread.push_back({scenario.engine.shared.compression_ratio *
                          scenario.compression_factor[std::size_t(cylinder - 1)]});
    }
    return spread;
}

FuelMap make_fuel_map(const Scenario &s) {
    const double low = s.speed_radps.smallest(), high = s.speed_radps.largest();
    double top = s.bmep_pa.largest();
    if (s.speed_mode == SpeedMode::governor) top = FuelMap::largest_bmep_pa(s.engine, high, kGovernorLimitPa);
    FuelMap map(s.engine, low, high, top);
    if (!map.reaches_top() && s.speed_mode != SpeedMode::governor) {
        throw InputError(
            s.file, "load.bmep_bar",
            "demands more than the trapped air can burn; lower it or raise plant.air.intake_pressure_bar");
    }
    return map;
}

SpeedControl make_control(SpeedMode mode) {
    return mode == SpeedMode::governor ? SpeedControl(0.25, 0.04) : SpeedControl(0.4, 0.06);
}

// Position in [0, 1] of `angle` within a step, and the cubic through both ends' times and slopes there.
double crossing_time(double angle_deg, double from_deg, double to_deg, double t0, double t1, double speed0,
                     double speed1) {
    const double x = (angle_deg - from_deg) / (to_deg - from_deg), h = (to_deg - from_deg) * kRadPerDeg,
                 y = 1 - x;
    const double rise0 = h / speed0, rise1 = h / speed1;
    return t0 * y * y * (1 + 2 * x) + t1 * x * x * (1 + 2 * y) + x * y * (rise0 * y - rise1 * x);
}

} // namespace

Plant::Plant(const Scenario &scenario, std::uint64_t seed)
    : scenario_(scenario), model_(scenario.engine, spread_of(scenario), scenario.step_deg),
      fuel_map_(make_fuel_map(scenario)),
      load_nm_(scenario.load_given ? scenario.load_nm
                                   : scenario.bmep_pa.scaled(scenario.engine.torque_of_mep_nm(1))),
      plan_(scenario_, seed), control_(make_control(scenario.speed_mode)),
      road_(scenario.road_rms_nm, scenario.road_low_hz, scenario.road_high_hz,
            RandomStream(seed, stream::kRoad)),
      torsion_(scenario.engine),
      wheel_(scenario.engine.shared, scenario.encoder.offset_deg, scenario.encoder.pattern_rms_deg,
             scenario.encoder.tooth_width * 360 / scenario.engine.shared.wheel.positions,
             RandomStream(seed, stream::kPattern)),
      pickup_(scenario.encoder, scenario.engine.shared.tick_hz, seed) {
    fuel_trim_.fill(1);
    if (scenario.uego) {
        const ExhaustSystem &shared = *scenario.engine.shared.exhaust;
        exhaust_.emplace(scenario.engine);
        uego_.emplace(*scenario.uego, shared.uego_tau_s[0], shared.uego_tau_s[1], RandomStream(seed, stream::kUego));
        if (scenario.exhaust_sensors)
            exhaust_pressure_.emplace(*scenario.exhaust_sensors, RandomStream(seed, stream::kExhaustPressure));
    }
    if (scenario.vehicle) car_.emplace(*scenario.vehicle, RandomStream(seed, stream::kVehicleWheel));
    if (scenario.air_path) {
        const EngineFile &shared = scenario.engine.shared;
        air_path_.emplace(*scenario.engine.air_path, scenario.engine.displacement_m3(), shared.compression_ratio, *scenario.air_path, seed);
    }
    steps_to_tdc_ = int(std::lround((4 * kPi - scenario.engine.intake_close_rad) / model_.tables().step_rad));
    pre_roll();
}

void Plant::pre_roll() {
    const int step = int(std::lround(scenario_.start_deg / scenario_.step_deg)) % model_.tables().steps;
    const double speed = scenario_.speed_radps.at(0);
    demand_pa_ = scenario_.bmep_pa.at(0);
    mean_speed_ = speed;
    if (air_path_) air_path_->start(air_drive(fuel_map_.fuel_kg(speed, demand_pa_)));
    fill_intake();
    model_.start(-kPreRollCycles, step, 0, speed);
    model_.prescribe_speed(speed, 0);
    if (exhaust_) exhaust_->start(kStartAirFraction);
    for (int i = 0; i < kPreRollCycles * model_.tables().steps; ++i) {
        const double before = model_.truth().time_s;
        model_.step();
        handle_events();
        if (exhaust_) step_exhaust(model_.truth().time_s - before);
    }
    model_.set_time(0);
    if (uego_) uego_->start(0, exhaust_->at_sensor());
    if (exhaust_pressure_) exhaust_pressure_->start(0, exhaust_->pressure_pa());
    if (scenario_.speed_mode != SpeedMode::prescribed) model_.release_speed();
    cycles_.clear();
    running_ = true;
    brake_nm_ = scenario_.engine.torque_of_mep_nm(demand_pa_);
    next_control_rad_ = model_.truth().angle_rad + SpeedControl::kCycleRad;
    if (scenario_.cycles > 0)
        end_angle_rad_ = model_.truth().angle_rad + double(scenario_.cycles) * SpeedControl::kCycleRad;
    if (car_) car_->start(speed, brake_nm_);
    refresh_speed_and_load();
    if (car_) model_.set_load(car_->crank_load_nm(), 0);
    sensor_ = sensor();
    wheel_.seek(sensor_.angle_deg);
    next_cam_deg_ = scenario_.engine.shared.cam_edge_deg;
    earliest_cam_deg_ = scenario_.engine.shared.has_cam ? scenario_.encoder.cam_retard_deg.smallest() : 1e300;
    while (next_cam_deg_ + scenario_.encoder.cam_retard_deg.at(0) <= sensor_.angle_deg) next_cam_deg_ += 720;
}

// Without an air path the manifold's pressure is at once that of the demand, for whoever breathes.
void Plant::fill_intake() {
    for (int lane = 0; lane < scenario_.engine.shared.cylinders(); ++lane) {
        const int cylinder = scenario_.engine.shared.firing_order[std::size_t(lane)];
        model_.set_intake_pressure(lane, intake_pressure_pa() * scenario_.trapped_factor[std::size_t(cylinder - 1)]);
    }
}

bool Plant::next_edge(EncoderEdge &edge) {
    while (pickup_.empty() || !pickup_.take(sensor_.time_s, sensor_.speed_radps, edge)) {
        if (ended_) {
            if (!pickup_.take_rest(edge)) return false;
            break;
        }
        advance();
    }
    return scenario_.duration_s <= 0 || edge.time_s < scenario_.duration_s;
}

bool Plant::next_cycle(CycleTruth &cycle) {
    if (cycles_.empty()) return false;
    cycle = cycles_.front();
    cycles_.pop_front();
    return true;
}

void Plant::set_fuel_trim(int cylinder, double factor) {
    fuel_trim_[std::size_t(cylinder - 1)] = std::clamp(factor, 0.0, 2.0);
}

bool Plant::at_end() const {
    // The last edge before duration_s may still wait for the step behind it.
    return (scenario_.duration_s > 0 && model_.truth().time_s >= scenario_.duration_s) ||
           model_.truth().angle_rad >= end_angle_rad_ - 1e-6;
}

void Plant::advance() {
    if (stop_) return advance_stop();
    if (model_.truth().time_s >= refresh_at_s_) refresh_speed_and_load();
    if (!model_.step()) {
        stop_.emplace(scenario_.engine, spread_of(scenario_), model_);
        return;
    }
    const StepTruth &before = model_.truth_before(), &now = model_.truth();
    if (model_.events_begin() != model_.events_end()) handle_events();
    if (exhaust_) step_exhaust(now.time_s - before.time_s);
    if (car_) step_car();
    if (air_path_) air_path_->advance(now.time_s, air_drive(commanded_fuel_kg_));
    if (torsion_.enabled()) torsion_.step(model_, now.time_s - before.time_s);
    const SensorPoint from = sensor_;
    sensor_ = sensor();
    if (wheel_.forward().angle_deg <= sensor_.angle_deg || next_cam_deg_ + earliest_cam_deg_ <= sensor_.angle_deg)
        find_edges(before, from);
    if (step_sink_) step_sink_->push_back(now);
    if (watcher_) watcher_();
    if (now.angle_rad > next_control_rad_ - 1e-6) control();
    ended_ = at_end();
}

// The wheel is taken as rigid with the crank here.
void Plant::advance_stop() {
    const SensorPoint from = sensor_;
    ended_ = !stop_->step() || (scenario_.duration_s > 0 && stop_->time_s() >= scenario_.duration_s);
    sensor_ = {stop_->angle_rad() * kDegPerRad, stop_->time_s(), stop_->speed_radps()};
    if (sensor_.angle_deg == from.angle_deg) return;
    if ((sensor_.angle_deg < from.angle_deg) != backward_) {
        backward_ = !backward_;
        wheel_.seek(from.angle_deg);
    }
    backward_ ? find_backward_edges(model_.truth(), from) : find_edges(model_.truth(), from);
}

// What the engine feels of the car until the next step, and of a rough road, which shakes the crank's end of it.
void Plant::step_car() {
    const StepTruth &before = model_.truth_before(), &now = model_.truth();
    std::optional<double> brake;
    if (scenario_.speed_mode == SpeedMode::dyno) brake = brake_nm_;
    else if (scenario_.load_given || scenario_.speed_mode == SpeedMode::governor) brake = load_nm_.at(now.time_s);
    car_->step(before.time_s, before.speed_radps, now.time_s, now.speed_radps, brake);
    const Profile::Segment road = road_.segment(now.time_s);
    model_.set_load(car_->crank_load_nm() + road.at(now.time_s), car_->load_slope_nmps() + road.slope);
}

bool Plant::next_wheel_edge(double time_s, double &edge_s) {
    if (!car_ || car_->wheel_edges().empty() || car_->wheel_edges().front().time_s >= time_s) return false;
    edge_s = car_->wheel_edges().front().time_s;
    car_->wheel_edges().pop_front();
    return true;
}

/// The mean speed, not the crank's own: a mean-value model has no use for what happens within a firing.
airpath::EngineDrive Plant::air_drive(double fuel_kg) const {
    return {mean_speed_, fuel_kg * scenario_.engine.shared.cylinders() * mean_speed_ / (4 * kPi)};
}

void Plant::step_exhaust(double dt_s) {
    exhaust_->step(model_, dt_s, mean_speed_, intake_pressure_pa());
    const double tip_pa = scenario_.uego->before_turbine ? exhaust_->pressure_pa() : exhaust_->downstream_pa();
    if (!running_) return;
    const double now_s = model_.truth().time_s;
    uego_->step(now_s, dt_s, exhaust_->at_sensor(), tip_pa, uego_samples_);
    if (exhaust_pressure_) exhaust_pressure_->step(now_s, dt_s, exhaust_->pressure_pa(), pressure_samples_);
}

bool Plant::next_exhaust_pressure(double time_s, PressureSample &sample) {
    if (pressure_samples_.empty() || pressure_samples_.front().time_s >= time_s) return false;
    sample = pressure_samples_.front();
    pressure_samples_.pop_front();
    return true;
}

bool Plant::next_uego(double time_s, UegoSample &sample) {
    if (uego_samples_.empty() || uego_samples_.front().time_s >= time_s) return false;
    sample = uego_samples_.front();
    uego_samples_.pop_front();
    return true;
}

void Plant::handle_events() {
    for (const Event *event = model_.events_begin(); event != model_.events_end(); ++event) {
        if (event->kind == EventKind::intake_close) set_charge(*event);
        if (event->kind == EventKind::exchange && running_ && model_.finished(event->lane).cycle >= 0) {
            cycles_.push_back(model_.finished(event->lane));
            if (exhaust_) cycles_.back().exhaust_lambda = exhaust_->lambda_of(event->lane);
        }
    }
}

bool Plant::fuel_is_cut(double time_s) const {
    const auto &cut = scenario_.fuel_cut_s;
    const auto after = std::upper_bound(cut.begin(), cut.end(), time_s) - cut.begin();
    return after % 2 == 1;
}

void Plant::set_charge(const Event &event) {
    const StepTruth &truth = model_.truth();
    const int cylinder = scenario_.engine.shared.firing_order[std::size_t(event.lane)];
    commanded_fuel_kg_ = fuel_is_cut(truth.time_s) ? 0 : fuel_map_.fuel_kg(mean_speed_, demand_pa_);
    const std::int64_t tdc_step = model_.cycle() * model_.tables().steps + event.step + steps_to_tdc_;
    const std::int64_t cycle = std::int64_t(std::floor(double(tdc_step) / model_.tables().steps));
    const Charge charge = plan_.draw(event.lane, cycle, truth.time_s,
                                     commanded_fuel_kg_ * fuel_trim_[std::size_t(cylinder - 1)], demand_pa_);
    model_.set_charge(event.lane, charge);
    if (exhaust_) exhaust_->charge(event.lane, model_.trapped_kg(event.lane), charge.fuel_kg);
}

// Torque and speed profiles as straight pieces in time, held by the model until one of them bends.
void Plant::refresh_speed_and_load() {
    const double now = model_.truth().time_s;
    const Profile::Segment road = road_.segment(now);
    refresh_at_s_ = road.x1;
    double torque = road.at(now), slope = road.slope;
    if (scenario_.speed_mode == SpeedMode::prescribed) {
        const Profile::Segment speed = scenario_.speed_radps.segment(now);
        model_.prescribe_speed(speed.at(now), speed.slope);
        refresh_at_s_ = std::min(refresh_at_s_, speed.x1);
    } else if (scenario_.speed_mode == SpeedMode::dyno) {
        torque += brake_nm_;
    } else {
        const Profile::Segment load = load_nm_.segment(now);
        torque += load.at(now);
        slope += load.slope;
        refresh_at_s_ = std::min(refresh_at_s_, load.x1);
    }
    if (!car_) model_.set_load(torque, slope);
}

// Once a cycle: mean speed, demand, and whichever of brake and fuel holds the speed.
void Plant::control() {
    const double now = model_.truth().time_s, lasted = now - control_time_,
                 mean = SpeedControl::kCycleRad / lasted;
    const PlantEngine &engine = scenario_.engine;
    const double middle = scenario_.speed_radps.at(now - lasted / 2),
                 next = scenario_.speed_radps.at(now + lasted / 2);
    const double inertia = model_.tables().inertia[0] + (car_ ? car_->inertia_at_crank_kgm2() : 0) +
                           engine.driveline_inertia_kgm2 * (engine.dual_mass ? 1 : 0) +
                           (engine.dual_mass ? engine.dual_mass->secondary_inertia_kgm2 : 0);
    // With a car behind it, its speed is held and not that of a crank that swings against it.
    const double held = car_ ? car_->crank_radps_of_wheels() : mean, wanted_radps = car_ ? scenario_.speed_radps.at(now) : middle;
    const double error_j = inertia / 2 * (held * held - wanted_radps * wanted_radps);
    const double ramp_nm = inertia / 2 * (next * next - middle * middle) / SpeedControl::kCycleRad;
    mean_speed_ = mean;
    model_.set_mean_speed(mean);
    demand_pa_ = scenario_.bmep_pa.at(now);
    if (scenario_.speed_mode == SpeedMode::dyno) {
        double given = demand_pa_;
        if (fuel_is_cut(now)) given = fuel_map_.motored_imep_pa(mean, demand_pa_) - engine.fmep_at_pa(mean);
        brake_nm_ = engine.torque_of_mep_nm(given) + control_.update(error_j) - ramp_nm;
        refresh_at_s_ = now;
    } else if (scenario_.speed_mode == SpeedMode::governor) {
        const double load = load_nm_.at(now) / engine.torque_of_mep_nm(1);
        const double wanted = load + (ramp_nm - control_.update(error_j)) / engine.torque_of_mep_nm(1);
        demand_pa_ = std::clamp(wanted, 0.0, kGovernorLimitPa);
    }
    fill_intake();
    control_time_ = now;
    next_control_rad_ += SpeedControl::kCycleRad;
}

Plant::SensorPoint Plant::sensor() const {
    const StepTruth &truth = model_.truth();
    return {truth.angle_rad * kDegPerRad + torsion_.wheel_twist_rad() * kDegPerRad, truth.time_s,
            truth.speed_radps + torsion_.wheel_twist_radps()};
}

void Plant::find_edges(const StepTruth &before, const SensorPoint &from) {
    while (wheel_.forward().angle_deg <= sensor_.angle_deg) {
        pass(wheel_.forward().angle_deg, before, from, EdgeKind::crank, wheel_.forward().tooth);
        wheel_.pass_forward();
    }
    if (!scenario_.engine.shared.has_cam) return;
    const double cam = next_cam_deg_ + scenario_.encoder.cam_retard_deg.at(sensor_.time_s);
    if (cam <= sensor_.angle_deg) {
        pass(std::max(cam, from.angle_deg), before, from, EdgeKind::cam, -1);
        next_cam_deg_ += 720;
    }
}

void Plant::find_backward_edges(const StepTruth &before, const SensorPoint &from) {
    while (wheel_.backward().angle_deg >= sensor_.angle_deg) {
        pass(wheel_.backward().angle_deg, before, from, EdgeKind::crank, wheel_.backward().tooth);
        wheel_.pass_backward();
    }
}

void Plant::pass(double angle_deg, const StepTruth &before, const SensorPoint &from, EdgeKind kind,
                 int tooth) {
    const StepTruth &after = model_.truth();
    const double x = (angle_deg - from.angle_deg) / (sensor_.angle_deg - from.angle_deg);
    const auto mix = [x](double a, double b) { return a + x * (b - a); };
    EncoderEdge edge;
    edge.time_s = stop_ ? mix(from.time_s, sensor_.time_s)
                        : crossing_time(angle_deg, from.angle_deg, sensor_.angle_deg, from.time_s,
                                        sensor_.time_s, from.speed_radps, sensor_.speed_radps);
    edge.backward = backward_;
    edge.kind = kind;
    edge.tooth = tooth;
    edge.angle_deg = angle_deg - 720 * std::floor(angle_deg / 720);
    edge.speed_radps = stop_ ? sensor_.speed_radps : mix(before.speed_radps, after.speed_radps);
    if (stop_) return pickup_.pass(edge); // no torque truth at standstill
    edge.combustion_torque_nm = mix(before.combustion_torque_nm, after.combustion_torque_nm);
    edge.gas_torque_nm = mix(before.gas_torque_nm, after.gas_torque_nm);
    edge.net_torque_nm = mix(before.net_torque_nm, after.net_torque_nm);
    pickup_.pass(edge);
}

} // namespace sixdeg
