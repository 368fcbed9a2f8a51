// SPDX-License-Identifier: MIT
// Crank and slider in closed form. Angle theta is measured from the cylinder's TDC, rad.
#pragma once
#include <cmath>

#include "plant/engine/units.hpp"

namespace sixdeg {

/// One cylinder's kinematics, derived in docs/theory/plant.md, section Geometry. Pin offset zero.
struct CrankSlider {
    double bore_m, stroke_m, rod_m, compression_ratio;

    double piston_area_m2() const { return kPi / 4 * bore_m * bore_m; }
    double displacement_m3() const { return piston_area_m2() * stroke_m; }
    double clearance_m3() const { return displacement_m3() / (compression_ratio - 1); }

    /// Distance of the piston below its TDC position, m.
    double travel_m(double theta) const {
        const double r = stroke_m / 2, s = r * std::sin(theta);
        return r * (1 - std::cos(theta)) + rod_m - std::sqrt(rod_m * rod_m - s * s);
    }
    /// d(travel)/d(theta), m/rad.
    double travel_slope_m(double theta) const {
        const double r = stroke_m / 2, s = r * std::sin(theta);
        return s + s * r * std::cos(theta) / std::sqrt(rod_m * rod_m - s * s);
    }
    /// d2(travel)/d(theta)2, m/rad2.
    double travel_curvature_m(double theta) const {
        const double r = stroke_m / 2, s = r * std::sin(theta), c = r * std::cos(theta);
        const double root = std::sqrt(rod_m * rod_m - s * s);
        return c + (c * c - s * s) / root + s * s * c * c / (root * root * root);
    }
    double volume_m3(double theta) const { return clearance_m3() + piston_area_m2() * travel_m(theta); }
    /// dV/d(theta), m3/rad; gas torque is (p - p_crankcase) times this.
    double volume_slope_m3(double theta) const { return piston_area_m2() * travel_slope_m(theta); }
    /// Head, piston crown and uncovered liner, flat head and crown, m2.
    double wall_area_m2(double theta) const { return 2 * piston_area_m2() + kPi * bore_m * travel_m(theta); }
    /// Inertia that a reciprocating mass adds at the crank, kg m2: kinetic energy is J w^2 / 2.
    double reciprocating_inertia_kgm2(double theta, double mass_kg) const {
        const double slope = travel_slope_m(theta);
        return mass_kg * slope * slope;
    }
};

} // namespace sixdeg
