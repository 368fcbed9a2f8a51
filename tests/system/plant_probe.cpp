// SPDX-License-Identifier: MIT
// Prints what the simulated engine does, for tests in Python that check it with tools of their own.
//   plant_probe trace ENGINE.toml RPM FUEL_MG LOAD_NM STEP_DEG   two cycles after three to settle, one line a
//   step plant_probe turn ENGINE.toml CYLINDERS CYCLES                nothing printed; to count instructions
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "common/error.hpp"
#include "plant/engine/engine_model.hpp"

using namespace sixdeg;

namespace {

std::vector<CylinderSpread> nominal(const PlantEngine &engine) {
    return std::vector<CylinderSpread>(std::size_t(engine.shared.cylinders()),
                                       {engine.shared.compression_ratio});
}

void step(EngineModel &model, double fuel_kg) {
    Charge charge;
    charge.fuel_kg = fuel_kg;
    if (!model.step()) {
        std::fputs("plant_probe: the engine stalled\n", stderr);
        std::exit(1);
    }
    for (const Event *e = model.events_begin(); e != model.events_end(); ++e) {
        if (e->kind == EventKind::intake_close) model.set_charge(e->lane, charge);
    }
}

void print_header(int cylinders) {
    std::printf("angle_deg,time_s,speed_radps,gas_nm,net_nm,load_nm,trapped_kg,lost_j,released_j");
    for (int lane = 0; lane < cylinders; ++lane) std::printf(",p%d_pa", lane);
    std::printf("\n");
}

void print_line(const EngineModel &model, int cylinders) {
    const StepTruth &t = model.truth();
    std::printf("%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g,%.17g", t.angle_rad * kDegPerRad, t.time_s,
                t.speed_radps, t.gas_torque_nm, t.net_torque_nm, t.load_torque_nm, model.trapped_kg(0),
                model.heat_lost_j(0), model.heat_released_j(0));
    for (int lane = 0; lane < cylinders; ++lane) std::printf(",%.17g", model.pressure_pa(lane));
    std::printf("\n");
}

int trace(const PlantEngine &engine, double rpm, double fuel_kg, double load_nm, double step_deg) {
    EngineModel model(engine, nominal(engine), step_deg);
    const int steps = model.tables().steps, n = engine.shared.cylinders();
    model.start(-3, 0, 0, rpm * kRadpsPerRpm);
    model.prescribe_speed(rpm * kRadpsPerRpm, 0);
    for (int i = 0; i < 3 * steps; ++i) step(model, fuel_kg);
    model.release_speed();
    model.set_load(load_nm, 0);
    print_header(n);
    print_line(model, n);
    for (int i = 0; i < 2 * steps; ++i) step(model, fuel_kg), print_line(model, n);
    return 0;
}

int turn(PlantEngine engine, int cylinders, int cycles) {
    engine.shared.firing_order.clear();
    engine.shared.firing_tdc_deg.clear();
    for (int i = 0; i < cylinders; ++i) {
        engine.shared.firing_order.push_back(i + 1);
        engine.shared.firing_tdc_deg.push_back(720.0 / cylinders * i);
    }
    EngineModel model(engine, nominal(engine), 0.5);
    model.start(0, 0, 0, 150);
    model.prescribe_speed(150, 0);
    for (int i = 0; i < cycles * model.tables().steps; ++i) step(model, 17e-6);
    return 0;
}

} // namespace

int main(int argc, char **argv) {
    try {
        if (argc == 7 && !std::strcmp(argv[1], "trace")) {
            return trace(read_plant_engine(std::filesystem::path(argv[2])), std::atof(argv[3]),
                         1e-6 * std::atof(argv[4]), std::atof(argv[5]), std::atof(argv[6]));
        }
        if (argc == 5 && !std::strcmp(argv[1], "turn")) {
            return turn(read_plant_engine(std::filesystem::path(argv[2])), std::atoi(argv[3]),
                        std::atoi(argv[4]));
        }
    } catch (const InputError &error) {
        std::fprintf(stderr, "plant_probe: %s\n", error.what());
        return 2;
    }
    std::fputs("plant_probe: usage stands at the top of plant_probe.cpp\n", stderr);
    return 2;
}
