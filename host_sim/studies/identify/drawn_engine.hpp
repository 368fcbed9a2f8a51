// SPDX-License-Identifier: MIT
// Engines drawn by seed for `sixdeg study identify`: a simulated engine whose physics are other than the calibration's, a first engine
// file that is wrong about it, a run with fuel cuts at two speeds, and what is true.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "identify/crank_record.hpp"
#include "plant/scenario/scenario.hpp"

namespace sixdeg {

struct DrawnEngine {
    std::string what;     ///< "4 cylinders, J 0.21", for people.
    Scenario scenario;    ///< Engine, spread of its cylinders, wheel, run.
    EngineFile first;     ///< The file that the user writes: geometry right, the rest a guess.
    double pressure_gain; ///< Of the pressure sensor, about 1.
    double pressure_zero_bar, pressure_noise_bar, intake_gain;
};

struct DragTrue {
    double rpm, nm;
};

/// What is true of the engine, in the terms of Identified.
struct EngineTruth {
    double inertia_kgm2, position_0_deg, exponent;
    std::vector<double> pattern_deg;
    std::vector<std::pair<double, double>> load_nm; ///< Time, s, and load plus friction there; a point every few degrees.
};

struct DrawnRun {
    CrankRecord record; ///< With pressure, intake and fuel.
    EngineTruth truth;
};

DrawnEngine draw_engine(std::uint64_t seed);
DrawnRun run_engine(const DrawnEngine &engine);

} // namespace sixdeg
