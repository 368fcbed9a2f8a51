// SPDX-License-Identifier: MIT
// ENGINE.toml: the physics that plant, gain design and firmware calibration share. Field by field: docs/reference/files.md.
#pragma once
#include <string>
#include <vector>

#include "common/air_path.hpp"
#include "common/crank_elasticity.hpp"
#include "common/driveline.hpp"
#include "common/exhaust_system.hpp"
#include "common/toml_file.hpp"

namespace sixdeg {

/// A toothed wheel: position 0 is the first tooth after the mark, the last position is missing.
struct Wheel {
    int positions = 60;               ///< Tooth positions a revolution, missing ones included, 12 to 120.
    std::vector<int> missing{58, 59}; ///< Missing positions, ascending; runs of 1 to 3.

    int teeth() const { return positions - int(missing.size()); }
};

/// "60-2" -> {60, {58, 59}}; one run of 1 to 3 missing teeth before position 0. Throws InputError naming `from`.
Wheel parse_wheel(const std::string &text, const std::string &from);
/// "60-2" for a wheel with one mark, "36-2-1" for one with more: positions, and the missing teeth of each mark, most first.
std::string describe(const Wheel &wheel);
/// Missing teeth of each mark, in the order of the wheel.
std::vector<int> missing_runs(const Wheel &wheel);

/// One Wiebe pulse of heat release: x = 1 - exp(-ln(1000) ((a - start)/duration)^(shape + 1)).
struct HeatPulse {
    double start_deg;    ///< From firing TDC.
    double duration_deg; ///< Until 99.9 % of it is burned.
    double shape;
    double share; ///< Of the cycle's heat; the shares of all pulses add up to 1.
};

/// How far the file may be off: the largest error of a value, any within being as likely. What `sixdeg calibrate` makes of it:
/// design/torque/model_error.hpp. A file that says nothing has its reader's usual values; 0 says that a value is exact.
struct Tolerance {
    double inertia_percent = 0, compression_percent = 0, trapped_mass_percent = 0; ///< The last two of each cylinder by itself.
    double wheel_offset_deg = 0;
    double burn_start_deg = 0.5, burn_duration_percent = 3; ///< Of combustion.pulse.
    double wall_loss_percent = 100;                         ///< Beyond Hohenberg's.
};

struct EngineFile {
    std::string name;
    std::vector<std::string> guessed; ///< Fields whose value nobody measured; every report repeats them.

    std::vector<int> firing_order;       ///< Physical cylinder numbers, 1-based, in firing order.
    std::vector<double> firing_tdc_deg;  ///< Firing TDC of each entry of firing_order, [0, 720), ascending.
    double bore_m = 0, stroke_m = 0, rod_m = 0, compression_ratio = 0;

    double exhaust_open_deg = 0; ///< After firing TDC.
    double intake_close_deg = 0; ///< After firing TDC, beyond one turn: 540 deg is BDC.
    std::vector<HeatPulse> pulses; ///< One or two, of the nominal engine at its usual load.

    double inertia_kgm2 = 0;          ///< Constant part J0 of the crank train's inertia.
    double reciprocating_mass_kg = 0; ///< Per cylinder, 0 for a constant inertia.

    std::optional<DualMassFlywheel> dual_mass;
    std::optional<CrankTorsion> torsion;
    std::optional<DrivelineFile> driveline;

    Wheel wheel;
    double position_0_deg = 0; ///< Crank angle of position 0's edge, [0, 360), 0 = firing TDC of firing_order[0].
    bool falling_edge = true;  ///< The wheel's edge that carries the tooth angle.

    bool has_cam = false;
    double cam_edge_deg = 0; ///< Crank angle of the one cam edge in a cycle, [0, 720).

    double tick_hz = 1e6; ///< Capture timer.

    Tolerance tolerance;

    std::optional<ExhaustSystem> exhaust; ///< From the exhaust valves to the wideband sensor.
    std::optional<AirPathSystem> air_path; ///< Of a diesel with exhaust gas recirculation and a variable turbine.

    /// How single cylinders are believed to differ, by entry of firing_order; empty: not at all. No field of the file:
    /// perturbed calibrations set them.
    std::vector<double> compression_factors, trapped_factors;

    int cylinders() const { return int(firing_order.size()); }
    double displaced_m3() const { return 0.78539816339744831 * bore_m * bore_m * stroke_m; } ///< Of one cylinder.
    double compression_factor(std::size_t lane) const {
        return compression_factors.empty() ? 1 : compression_factors[lane];
    }
    double trapped_factor(std::size_t lane) const { return trapped_factors.empty() ? 1 : trapped_factors[lane]; }
};

/// Reads the shared part and leaves the table "plant" to the plant's own reader. Call file.finish() afterwards.
EngineFile read_engine(TomlFile &file);

} // namespace sixdeg
