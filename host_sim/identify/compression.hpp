// SPDX-License-Identifier: MIT
// The polytropic line of a compression, p V^n = C, between the intake's closing and the ignition.
#pragma once
#include <Eigen/Core>
#include <vector>

#include "identify/crank_motion.hpp"

namespace sixdeg {

/// Exponent of unburned mixture in a cool cylinder, and how far it may be off (Heywood, Internal Combustion Engine Fundamentals, 9.2).
constexpr double kUsualExponent = 1.32, kUsualExponentSd = 0.02;

/// What to add to a recorded pressure (bar over the grid) so that it follows p V^n = C with the usual exponent. `offset_rad`: by which
/// the crank is ahead of the grid's angles.
double compression_level_bar(const EngineFile &engine, const Eigen::VectorXd &recorded, double offset_rad);

/// By how much the crank is ahead of the grid's angles, by the pressure alone.
struct CompressionTdc {
    double offset_rad, sd_rad; ///< NaN where compression is polytropic nowhere within 15 deg.
};

/// Where p V^n = C fits these compressions best. With an absolute pressure, known to within `level_sd_bar`, n is found with it; where
/// that is infinite the level of each cycle is free, and n the usual one. The deviation is of level or exponent, and of what windows of
/// the compression say differently, which heat to the walls, a spark's noise and a sensor that drifts make. `bar`: over the grid, of
/// each cycle.
CompressionTdc compression_tdc(const EngineFile &engine, const std::vector<Eigen::VectorXd> &bar, double level_sd_bar);

/// n of an absolute pressure by least squares of ln p over ln V; NaN where it is not above 0 throughout. `compression_factor`: on the
/// file's compression ratio.
double compression_exponent(const EngineFile &engine, const Eigen::VectorXd &bar, double offset_rad, double compression_factor = 1);

} // namespace sixdeg
