// SPDX-License-Identifier: MIT
// The working gas of the plant: air as a thermally perfect gas, burned or not.
#pragma once

namespace sixdeg::gas {

constexpr double kR = 287.0; ///< Specific gas constant, J/(kg K).

// c_v/R = b0 + b1 T + b2 T^2, T in K: least squares over 300-3000 K to the NASA polynomials of dry air
// (78 % N2, 21 % O2, 1 % Ar), largest error 1.3 %. docs/theory/plant.md says how it was fitted and checked.
constexpr double kB0 = 2.20374, kB1 = 0.909463e-3, kB2 = -0.162717e-6;

/// c_v/R at temperature T in K, 250 to 3200 K; 1/cv_over_r is gamma - 1.
constexpr double cv_over_r(double t) { return kB0 + t * (kB1 + t * kB2); }
/// Specific internal energy in J/kg, zero at 0 K of the fit: the integral of c_v.
constexpr double internal_energy(double t) { return kR * t * (kB0 + t * (kB1 / 2 + t * kB2 / 3)); }

} // namespace sixdeg::gas
