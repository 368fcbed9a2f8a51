// SPDX-License-Identifier: MIT
#include "run/afr_trace.hpp"

#include <cmath>

#include "scenario/plant.hpp"

namespace sixdeg {

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
    double sum = 0, count = 0, last_s = start_s;
    long at = long(std::floor((plant.truth().angle_rad - from) / pitch + 1e-9)) + 1;
    trace.first_cycle_position =
        std::size_t((at % trace.cycle_positions + trace.cycle_positions) % trace.cycle_positions);
    plant.watch_steps([&] {
        sum += plant.uego_lambda(), ++count;
        if (plant.truth().angle_rad < from + double(at) * pitch - 1e-9) return;
        trace.sensor.push_back(sum / count);
        trace.gas.push_back(1 - plant.exhaust()->manifold().air_fraction());
        trace.mass_kg.push_back(plant.exhaust()->manifold().kg);
        trace.lambda.emplace_back();
        for (int lane = 0; lane < engine.cylinders(); ++lane)
            trace.lambda.back().push_back(plant.exhaust()->lambda_of(lane));
        last_s = plant.truth().time_s;
        sum = count = 0;
        ++at;
    });
    EncoderEdge edge;
    while (plant.next_edge(edge)) {
    }
    trace.step_s = (last_s - start_s) / double(trace.sensor.size());
    trace.intake_pa = plant.intake_pressure_pa();
    return trace;
}

} // namespace sixdeg
