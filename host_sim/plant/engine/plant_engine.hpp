// SPDX-License-Identifier: MIT
// The [plant] tables of ENGINE.toml: what the simulated engine has beyond the physics that the firmware
// knows. Field by field: docs/reference/scenario.md, section "[plant] tables of the engine file".
#pragma once
#include <array>
#include <filesystem>
#include <optional>
#include <vector>

#include "common/engine_file.hpp"
#include "common/profile.hpp"
#include "plant/airpath/full_data.hpp"
#include "plant/engine/geometry.hpp"

namespace sixdeg {

/// One heat release pulse of the nominal engine; angles from firing TDC. See WiebePulse.
struct PulseShape {
    double start_rad, duration_rad, shape_m;
    double share; ///< Of the cycle's heat; the shares of all pulses add up to 1.
};

/// What the exhaust side has beyond the shared [exhaust].
struct PlantExhaust {
    std::vector<double> runner_m3; ///< By physical cylinder: gas that mixes between valve and manifold; empty none.
    double wall_wpk, wall_k;       ///< Heat from the manifold's gas.
    double back_pressure_pa, rated_kgps; ///< Behind the turbine: grows with the square of the flow.
    double turbine_inertia_kgm2, turbine_efficiency, turbine_rated_radps, turbine_rated_w;
    double turbine_swallow_drop; ///< Share of its area that it loses at rated speed.
    double egr_area_m2, intake_m3;
};

struct PlantEngine {
    EngineFile shared;
    PlantExhaust exhaust; ///< Means something only with shared.exhaust.

    std::optional<airpath::FullData> air_path; ///< Means something only with shared.air_path.

    Profile intake_pressure_pa; ///< Cylinder pressure when the intake valve closes, over demanded bmep in Pa.
    double exhaust_pressure_pa, crankcase_pressure_pa;
    /// c_v/R of the working gas over temperature in K: a constant and what each power of T adds. Air unless the file gives gamma.
    std::array<double, 3> gas_cv_over_r;
    double charge_temperature_k;    ///< Of the trapped charge when the intake valve closes.
    double exhaust_open_rad;        ///< After firing TDC.
    double intake_close_rad;        ///< After firing TDC, beyond one turn: 540 deg is BDC.
    double exchange_per_rad;        ///< With a valve open: dp/dalpha = exchange_per_rad (p_manifold - p).
    double heating_value_jpkg;      ///< Lower heating value of the fuel.
    double stoichiometric_ratio;    ///< Air to fuel; fuel beyond it does not burn.
    std::vector<PulseShape> pulses; ///< One or two.
    double wall_temperature_k;
    double wall_factor;            ///< On Eichelberg's coefficient; 0 is adiabatic.
    double fmep_pa[3];             ///< Friction mean effective pressure: c0 + c1 n + c2 n^2, n in 1000 rpm.
    double driveline_inertia_kgm2; ///< Rigid with the crank (with the secondary mass if there is one).
    std::optional<DualMassFlywheel> dual_mass; ///< As in shared, or what the scenario makes of it.
    std::optional<CrankTorsion> torsion;       ///< The same.
    int torsion_modes = 1;                     ///< How many of its elastic modes are kept, 1 to 3.

    CrankSlider slider(double compression_ratio) const {
        return {shared.bore_m, shared.stroke_m, shared.rod_m, compression_ratio};
    }
    /// Of all cylinders, m3.
    double displacement_m3() const {
        return shared.cylinders() * slider(shared.compression_ratio).displacement_m3();
    }
    double fmep_at_pa(double speed_radps) const;
    /// Brake torque of a mean effective pressure, N m: p V_d / (4 pi).
    double torque_of_mep_nm(double mep_pa) const { return mep_pa * displacement_m3() / (4 * kPi); }
};

/// Reads shared part and [plant] tables and rejects what neither knows. Throws InputError.
PlantEngine read_plant_engine(const std::filesystem::path &path);
/// The same from text; `name` stands in messages.
PlantEngine read_plant_engine(const std::string &name, const std::string &text);

} // namespace sixdeg
