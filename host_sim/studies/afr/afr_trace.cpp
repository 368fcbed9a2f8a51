// SPDX-License-Identifier: MIT
#include "studies/afr/afr_trace.hpp"

#include <cmath>

#include "plant/scenario/plant.hpp"

namespace sixdeg {

namespace {

/// Slow instruments on the exhaust.
class BenchInstruments {
  public:
    explicit BenchInstruments(int cylinders) : cylinders_(cylinders) {}
    void step(const Plant &plant) {
        const double dt = plant.truth().time_s - last_s_;
        last_s_ = plant.truth().time_s;
        if (seconds_ < 0) { // the first call only starts the clock
            seconds_ = 0;
            return;
        }
        const exhaust::ExhaustModel &e = *plant.exhaust();
        seconds_ += dt, pascal_ += e.pressure_pa() * dt, kelvin_ += e.manifold().temperature_k() * dt;
        lambda_ += (1 - e.manifold().air_fraction()) * dt, kg_ += e.flows().turbine * dt, egr_kg_ += e.flows().egr * dt;
        radians_ += plant.truth().speed_radps * dt;
    }
    ExhaustReading read(const Plant &plant) const {
        const double charges = radians_ / (4 * kPi) * cylinders_;
        return {radians_ / seconds_,
                plant.intake_pressure_pa(),
                lambda_ / seconds_,
                kg_ / charges - plant.commanded_fuel_kg(),
                pascal_ / seconds_,
                kelvin_ / seconds_};
    }

    double egr_share() const { return egr_kg_ / (egr_kg_ + kg_); }

  private:
    int cylinders_;
    double last_s_ = 0, seconds_ = -1, pascal_ = 0, kelvin_ = 0, lambda_ = 0, kg_ = 0, egr_kg_ = 0, radians_ = 0;
};

} // namespace

AfrTrace afr_trace(Scenario scenario) {
    const EngineFile &engine = scenario.engine.shared;
    if (!scenario.uego) scenario.uego.emplace();
    scenario.uego->sample_s = 1;
    scenario.uego->noise_per_rthz = 0;
    Plant plant(scenario, scenario.seed);
    AfrTrace trace;
    trace.cycle_positions = 2 * engine.wheel.positions;
    const double pitch = 2 * kPi / engine.wheel.positions, from = engine.position_0_deg * kRadPerDeg;
    const double start_s = plant.truth().time_s;
    double sum = 0, pressure = 0, count = 0, last_s = start_s;
    BenchInstruments instruments(engine.cylinders());
    long at = long(std::floor((plant.truth().angle_rad - from) / pitch + 1e-9)) + 1;
    trace.first_cycle_position =
        std::size_t((at % trace.cycle_positions + trace.cycle_positions) % trace.cycle_positions);
    plant.watch_steps([&] {
        sum += plant.uego_lambda(), pressure += plant.exhaust()->pressure_pa() / kPaPerBar, ++count;
        if (plant.truth().angle_rad > 2 * kPi * double(scenario.cycles)) instruments.step(plant);
        if (plant.truth().angle_rad < from + double(at) * pitch - 1e-9) return;
        trace.sensor.push_back(sum / count);
        trace.pressure_bar.push_back(pressure / count);
        trace.gas.push_back(1 - plant.exhaust()->manifold().air_fraction());
        trace.mass_kg.push_back(plant.exhaust()->manifold().kg);
        trace.lambda.emplace_back();
        for (int lane = 0; lane < engine.cylinders(); ++lane)
            trace.lambda.back().push_back(plant.exhaust()->lambda_of(lane));
        last_s = plant.truth().time_s;
        sum = pressure = count = 0;
        ++at;
    });
    EncoderEdge edge;
    while (plant.next_edge(edge)) {
    }
    trace.step_s = (last_s - start_s) / double(trace.sensor.size());
    trace.intake_pa = plant.intake_pressure_pa();
    trace.reading = instruments.read(plant);
    trace.egr_share = instruments.egr_share();
    return trace;
}

} // namespace sixdeg
