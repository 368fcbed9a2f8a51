// SPDX-License-Identifier: MIT
// A model with numbers: the Jacobians at one operating point, and what a filter has to know of noise.
#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "studies/sensor_sets/sensor_model.hpp"

namespace sixdeg {

/// dx/dt = A x, y = C x around one steady point; rows of C are all sensors of the model, SI units.
struct LinearPoint {
    std::string name, regime;
    Eigen::MatrixXd a, c;
    std::vector<double> state; ///< The steady state itself; empty when the file gives only Jacobians.
};

/// The file's table "numeric".
struct NumericModel {
    std::vector<LinearPoint> points;
    Eigen::VectorXd scale;         ///< Size of each state, to make numbers of order one.
    Eigen::VectorXd process_noise; ///< Random walk of each state, SI unit per sqrt(s).
    double step_s = 0.01;          ///< Sampling of the sensors.
};

/// Reads "numeric"; no points when the file has none. Call after read_sensor_model() and before finish().
NumericModel read_numeric_model(TomlFile &file, const SensorModel &model);

/// Jacobians of the plant with the lag states of one set's sensors behind; rows of C in the order of the
/// sensors.
struct Augmented {
    Eigen::MatrixXd a, c;
    Eigen::VectorXd scale; ///< Of the states; a lag state has its signal's.
};
Augmented augment(const SensorModel &model, const LinearPoint &point, const Eigen::VectorXd &scale,
                  SensorSet set);

} // namespace sixdeg
