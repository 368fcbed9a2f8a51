// SPDX-License-Identifier: MIT
// Plant and firmware in one process. The firmware gets edges and time through the in-process port and nothing
// else; truth goes past it to whoever scores.
#pragma once
#include <cstdint>
#include <optional>

#include "run/afr_score.hpp"
#include "run/cylinder_score.hpp"
#include "run/run_tables.hpp"
#include "run/torque_score.hpp"
#include "scenario/scenario.hpp"

namespace sixdeg {

constexpr double kWrongRevolutionDeg = 180; ///< Off by more, a right tooth is in the wrong revolution.
constexpr std::size_t kScoredCycles = 20; ///< The last settled ones go into the figures.

struct RunResult {
    double simulated_s = 0;            ///< To the last edge.
    std::size_t edges = 0;             ///< Of the crank, as the firmware got them.
    std::size_t false_edges = 0;       ///< Of those, standing for no tooth.
    std::size_t wrong_teeth = 0;       ///< Placed and said to be valid, but not the tooth that passed.
    std::size_t wrong_revolutions = 0; ///< The right tooth, phase said to be known, and 360 deg off.
    std::size_t true_cycles = 0;       ///< Of single cylinders, complete.
    std::size_t misfires = 0;          ///< Of those.
    bool stalled = false;
    sd_crank_counts_t counts{};          ///< The decoder's own.
    std::optional<TorqueFigures> torque; ///< None when the speed is prescribed: torques act on nothing then.
    std::optional<CylinderFigures> cylinders; ///< The same.
    std::optional<AfrFigures> afr;            ///< With a wideband sensor only.
    std::optional<BalanceFigures> balance;    ///< Where fuel trims were allowed.
};

/// Runs the scenario to its end. `calibration` comes from calibrate() and need not be of the scenario's
/// engine. `tables` (nullptr: nothing is kept per tooth) takes the rows, `listener` (may be empty) every event in and
/// out. A signal that wants the program to stop ends the run early. Throws InputError.
RunResult run_on_bench(const Scenario &scenario, const sd_calibration_t &calibration, RunTables *tables,
                       const EventListener &listener = {});

} // namespace sixdeg
