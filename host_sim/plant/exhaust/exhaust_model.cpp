// SPDX-License-Identifier: MIT
#include "plant/exhaust/exhaust_model.hpp"

#include <algorithm>

namespace sixdeg::exhaust {
namespace {

constexpr double kLongestPartS = 35e-6; // the valve's straight part near equal pressures is this stiff
constexpr double kFlowMeanS = 2e-3;     // the gas column behind the turbine does not follow faster
constexpr double kStartK = 700, kRunnerPa = 1.3e5, kRunnerK = 800;

/// Gas that moves at `kgps` out of a zone, and what it carries.
void move(Zone &to, double kgps, double temperature_k, double air_fraction) {
    to.kg += kgps;
    to.joule += kgps * kCp * temperature_k;
    to.air_kg += kgps * air_fraction;
}

} // namespace

ExhaustModel::ExhaustModel(const PlantEngine &engine)
    : setup_(*engine.shared.exhaust), plant_(engine.exhaust), stoichiometric_(engine.stoichiometric_ratio),
      open_rad_(engine.exhaust_open_rad), charge_k_(engine.charge_temperature_k),
      n_(engine.shared.cylinders()) {
    for (int lane = 0; lane < n_; ++lane) {
        const auto l = std::size_t(lane);
        tdc_rad_.push_back(engine.shared.firing_tdc_deg[l] * kRadPerDeg);
        const auto cylinder = std::size_t(engine.shared.firing_order[l] - 1);
        runner_kg_[l] =
            plant_.runner_m3.empty() ? 0 : kRunnerPa * plant_.runner_m3[cylinder] / (kR * kRunnerK);
    }
}

void ExhaustModel::start(double air_fraction) {
    state_ = State{};
    ledger_ = Ledger{};
    time_s_ = 0;
    Zone &m = state_.manifold;
    m.kg = kRunnerPa * setup_.manifold_m3 / (kR * kStartK);
    m.joule = m.kg * kCv * kStartK;
    m.air_kg = m.kg * air_fraction;
    for (int lane = 0; lane < n_; ++lane) {
        const auto l = std::size_t(lane);
        state_.runner_air_kg[l] = runner_kg_[l] * air_fraction;
        charge_[l] = Charge{};
        lambda_[l] = 1 - air_fraction;
    }
    state_.turbine_radps = plant_.turbine_rated_radps / 2;
    transport_.start(air_fraction);
    intake_air_ = 1;
    flow_mean_ = aspirated_kgps_ = 0;
}

void ExhaustModel::charge(int lane, double trapped_kg, double fuel_kg) {
    Charge &c = charge_[std::size_t(lane)];
    const double rest = std::min(c.rest_kg, trapped_kg), share = c.rest_kg > 0 ? rest / c.rest_kg : 0;
    c.kg = trapped_kg + fuel_kg;
    c.air_kg = (trapped_kg - rest) * intake_air_ + c.rest_air_kg * share - stoichiometric_ * fuel_kg;
}

void ExhaustModel::open(int lane, double pressure_pa, double volume_m3) {
    Charge &c = charge_[std::size_t(lane)];
    if (c.kg <= 0) return; // not yet charged since start
    Zone &gas = state_.cylinder[std::size_t(lane)];
    gas = {c.kg, pressure_pa * volume_m3 / (kGamma - 1), c.air_kg};
    lambda_[std::size_t(lane)] = 1 - gas.air_fraction();
    ledger_.in_kg += gas.kg, ledger_.in_joule += gas.joule, ledger_.in_air_kg += gas.air_kg;
    c.open = true;
}

void ExhaustModel::close(int lane) {
    Charge &c = charge_[std::size_t(lane)];
    Zone &gas = state_.cylinder[std::size_t(lane)];
    ledger_.out_kg += gas.kg, ledger_.out_joule += gas.joule, ledger_.out_air_kg += gas.air_kg;
    c.rest_kg = gas.kg, c.rest_air_kg = gas.air_kg;
    gas = Zone{};
    c.open = false;
}

/// Largest area times sin^2 over the opening.
double ExhaustModel::valve_area_m2(double after_tdc_rad) const {
    const double x = (after_tdc_rad - open_rad_) / (setup_.valve_close_rad - open_rad_);
    return x <= 0 || x >= 1 ? 0 : setup_.valve_area_m2 * std::pow(std::sin(kPi * x), 2);
}

void ExhaustModel::step(const EngineModel &model, double dt_s, double mean_speed_radps, double intake_pa) {
    const StepTables &tables = model.tables();
    const int now = model.step_in_cycle(), before = now == 0 ? tables.steps - 1 : now - 1;
    for (int lane = 0; lane < n_; ++lane) {
        Passage &p = passage_[std::size_t(lane)];
        for (int end = 0; end < 2; ++end) {
            const int at = end == 0 ? before : now;
            double after = at * tables.step_rad - tdc_rad_[std::size_t(lane)];
            if (after < 0) after += 4 * kPi;
            p.volume[end] = tables.volume_m3(2 * at, lane);
            p.area[end] = valve_area_m2(after);
        }
        if (charge_[std::size_t(lane)].open && p.area[0] <= 0 && p.area[1] <= 0) close(lane);
    }
    turbine_area_m2_ = setup_.turbine_area_m2.at(mean_speed_radps);
    intake_pa_ = intake_pa;
    const int parts = int(std::ceil(dt_s / kLongestPartS));
    for (int i = 0; i < parts; ++i) substep((i + 0.5) / parts, dt_s / parts, dt_s);
    // An opened cylinder joins at the end of the step: its valve is still shut there.
    for (const Event *e = model.events_begin(); e != model.events_end(); ++e) {
        if (e->kind == EventKind::exhaust_open)
            open(e->lane, model.pressure_pa(e->lane), passage_[std::size_t(e->lane)].volume[1]);
    }
    const double cycle_s = 4 * kPi / mean_speed_radps;
    double trapped = 0;
    for (const Charge &c : charge_) trapped += c.kg;
    aspirated_kgps_ = trapped / cycle_s;
    const double intake_kg = intake_pa * plant_.intake_m3 / (kR * charge_k_), drawn = aspirated_kgps_ * dt_s;
    const double recirculated = flows_.egr * dt_s;
    intake_air_ += (recirculated * (state_.manifold.air_fraction() - 1) + drawn * (1 - intake_air_)) /
                   (intake_kg + drawn);
    time_s_ += dt_s;
    const double down_pa = downstream_pa(), gas_kg_per_m3 = down_pa / (kR * state_.manifold.temperature_k());
    transport_.step(time_s_, dt_s, flows_.turbine, state_.manifold.air_fraction(),
                    gas_kg_per_m3 * setup_.pipe_m3, gas_kg_per_m3 * setup_.mixing_m3, setup_.dead_time_s);
    flow_mean_ += (flows_.turbine - flow_mean_) * std::min(1.0, dt_s / kFlowMeanS);
}

// Explicit midpoint rule; the ledger takes the same rates, so balances close to rounding.
void ExhaustModel::substep(double x, double dt, double step_s) {
    State middle = state_;
    Ledger unused;
    add(middle, dt / 2, rates(x, step_s, state_, flows_, unused));
    Ledger rate;
    const State slope = rates(x, step_s, middle, flows_, rate);
    add(state_, dt, slope);
    ledger_.out_kg += dt * rate.out_kg, ledger_.out_joule += dt * rate.out_joule;
    ledger_.out_air_kg += dt * rate.out_air_kg;
    ledger_.wall_joule += dt * rate.wall_joule, ledger_.piston_joule += dt * rate.piston_joule;
}

void ExhaustModel::add(State &to, double h, const State &rate) {
    const auto zone = [h](Zone &z, const Zone &r) {
        z.kg += h * r.kg, z.joule += h * r.joule, z.air_kg += h * r.air_kg;
    };
    for (std::size_t l = 0; l < std::size_t(kMaxCylinders); ++l) {
        zone(to.cylinder[l], rate.cylinder[l]);
        to.runner_air_kg[l] += h * rate.runner_air_kg[l];
    }
    zone(to.manifold, rate.manifold);
    to.turbine_radps += h * rate.turbine_radps;
}

// A runner holds a fixed mass: what enters at one end pushes out of the other, whichever way it goes.
void ExhaustModel::valve_flow(int lane, double x, double step_s, const State &at, State &rate,
                              Flows &flows) const {
    const auto l = std::size_t(lane);
    const Passage &p = passage_[l];
    const Zone &gas = at.cylinder[l], &manifold = at.manifold;
    const double volume = p.volume[0] + x * (p.volume[1] - p.volume[0]),
                 area = p.area[0] + x * (p.area[1] - p.area[0]);
    const double pressure = (kGamma - 1) * gas.joule / volume,
                 behind = (kGamma - 1) * manifold.joule / setup_.manifold_m3;
    rate.cylinder[l].joule -= pressure * (p.volume[1] - p.volume[0]) / step_s;
    const bool forward = pressure >= behind;
    const Zone &from = forward ? gas : manifold;
    const double flow =
        orifice_kgps(area, std::max(pressure, behind), from.temperature_k(), std::min(pressure, behind)) *
        (forward ? 1 : -1);
    const double air_in = from.air_fraction(),
                 air_out = runner_kg_[l] > 0 ? at.runner_air_kg[l] / runner_kg_[l] : air_in;
    move(rate.cylinder[l], -flow, from.temperature_k(), forward ? air_in : air_out);
    move(rate.manifold, flow, from.temperature_k(), forward ? air_out : air_in);
    rate.runner_air_kg[l] = std::abs(flow) * (air_in - air_out);
    flows.valve[l] = flow;
}

ExhaustModel::State ExhaustModel::rates(double x, double step_s, const State &at, Flows &flows,
                                        Ledger &ledger) const {
    State rate;
    flows = Flows{};
    for (int lane = 0; lane < n_; ++lane) {
        if (!charge_[std::size_t(lane)].open) continue;
        valve_flow(lane, x, step_s, at, rate, flows);
        const Passage &p = passage_[std::size_t(lane)];
        const double volume = p.volume[0] + x * (p.volume[1] - p.volume[0]);
        ledger.piston_joule += (kGamma - 1) * at.cylinder[std::size_t(lane)].joule / volume *
                               (p.volume[1] - p.volume[0]) / step_s;
    }
    const Zone &m = at.manifold;
    const double pressure = (kGamma - 1) * m.joule / setup_.manifold_m3, t = m.temperature_k(),
                 down = downstream_pa();
    const double swallow =
        1 - plant_.turbine_swallow_drop * std::pow(at.turbine_radps / plant_.turbine_rated_radps, 2);
    if (pressure > down) flows.turbine = orifice_kgps(turbine_area_m2_ * swallow, pressure, t, down);
    if (pressure > intake_pa_) flows.egr = orifice_kgps(plant_.egr_area_m2, pressure, t, intake_pa_);
    move(rate.manifold, -flows.turbine - flows.egr, t, m.air_fraction());
    ledger.wall_joule = plant_.wall_wpk * (t - plant_.wall_k);
    rate.manifold.joule -= ledger.wall_joule;
    const double out = flows.turbine + flows.egr;
    ledger.out_kg = out, ledger.out_joule = out * kCp * t, ledger.out_air_kg = out * m.air_fraction();
    const double expansion = pressure > down ? 1 - std::pow(down / pressure, (kGamma - 1) / kGamma) : 0;
    const double power = plant_.turbine_efficiency * flows.turbine * kCp * t * expansion;
    const double load = plant_.turbine_rated_w * std::pow(at.turbine_radps / plant_.turbine_rated_radps, 3);
    rate.turbine_radps = (power - load) / (plant_.turbine_inertia_kgm2 * std::max(at.turbine_radps, 100.0));
    return rate;
}

Zone ExhaustModel::held() const {
    Zone sum = state_.manifold;
    for (std::size_t l = 0; l < std::size_t(n_); ++l) {
        sum.kg += state_.cylinder[l].kg, sum.joule += state_.cylinder[l].joule;
        sum.air_kg += state_.cylinder[l].air_kg + state_.runner_air_kg[l];
    }
    return sum;
}

} // namespace sixdeg::exhaust
