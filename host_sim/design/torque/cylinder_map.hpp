// SPDX-License-Identifier: MIT
// From the torque observer's coefficients to the combustion torque of each cylinder, through the known pulse
// shape.
#pragma once
#include <Eigen/Core>
#include <optional>

#include "common/engine_file.hpp"
extern "C" {
#include "sd_signals.h"
}

namespace sixdeg {

/// torque = map (coefficients) + offset + per_bar (intake pressure), by entry of firing_order;
/// docs/theory/torque.md, "Torque of each cylinder".
struct CylinderMap {
    Eigen::MatrixXd map;     ///< [cylinder][a_0, a_1, b_1, a_2 ...].
    Eigen::VectorXd offset;  ///< N m.
    Eigen::VectorXd per_bar; ///< N m for each bar of intake pressure.
    Eigen::VectorXd
        sd_ratio; ///< Standard deviation, per unit of J omega^2 (N m) and of the tooth times' error (rad).
};

/// Nothing when the harmonics are fewer than the cylinders, whose mean cannot be told then, or the pulse is not known.
std::optional<CylinderMap> cylinder_map(const EngineFile &engine, const sd_parameters_t &tune);

} // namespace sixdeg
