// SPDX-License-Identifier: MIT
// Document 001, Figures 4 to 7: its four-state model beside the full air path on a drive that nothing was fitted to.
#pragma once
#include <string>
#include <vector>

#include "plant/airpath/air_path.hpp"
#include "plant/engine/plant_engine.hpp"

namespace sixdeg {

/// One time of the drive: what is true, what was read, and what the model makes of the readings.
struct ModelRow {
    airpath::Truth truth;
    airpath::Readings readings;
    double intake_pa, exhaust_pa, drawn_kgps, leaving_kgps; ///< The model's: pressures, gas into the cylinders and out of them.
};

/// Mean of the absolute error over the mean of the truth, and the largest error over the same, %.
struct ModelError {
    const char *name;
    double mean_percent, largest_percent;
};

/// The drive of 120 s: speed from 1000 to 2000 rpm, load, valve and vanes move; sensors as noisy as ever. The engine has an air path.
std::vector<ModelRow> model_drive(const PlantEngine &engine);
/// Of Figures 5 to 7's quantities.
std::vector<ModelError> model_errors(const std::vector<ModelRow> &rows);
/// figures_4_to_7.csv.
std::string model_csv(const std::vector<ModelRow> &rows);

} // namespace sixdeg
