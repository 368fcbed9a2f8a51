// SPDX-License-Identifier: MIT
// Plant and firmware together. The firmware gets edges and time through a port and nothing else; truth goes past it
// to whoever scores.
#pragma once
#include <cstdint>
#include <optional>

#include "loop/ecu_bench.hpp"
#include "score/afr_score.hpp"
#include "score/balance_score.hpp"
#include "score/cylinder_score.hpp"
#include "score/driveline_score.hpp"
#include "score/firing_score.hpp"
#include "score/misfire_score.hpp"
#include "io/tables/run_tables.hpp"
#include "score/torque_score.hpp"
#include "score/work_score.hpp"
#include "plant/scenario/scenario.hpp"

namespace sixdeg {

constexpr double kWrongRevolutionDeg = 180; ///< Off by more, a right tooth is in the wrong revolution.
constexpr std::size_t kScoredCycles = 20; ///< The last settled ones go into the figures.
constexpr int kWaveformHarmonics = 24;    ///< What the filter's waveform is compared on, for its shift.

struct RunResult {
    double simulated_s = 0;            ///< To the last edge.
    std::size_t edges = 0;             ///< Of the crank, as the firmware got them.
    std::size_t false_edges = 0;       ///< Of those, standing for no tooth.
    std::size_t wrong_teeth = 0;       ///< Placed and said to be valid, but not the tooth that passed.
    std::size_t wrong_revolutions = 0; ///< The right tooth, phase said to be known, and 360 deg off.
    std::size_t true_cycles = 0;       ///< Of single cylinders, complete.
    std::size_t misfires = 0;          ///< Of those.
    bool stalled = false;
    std::size_t sync_losses = 0;         ///< Times the angle was lost.
    std::size_t unanswered = 0;          ///< Crank edges of which the ecu said nothing; over a bus only.
    std::optional<TorqueFigures> torque; ///< None when the speed is prescribed: torques act on nothing then.
    std::optional<CylinderFigures> cylinders; ///< The same.
    std::optional<TorqueFigures> waveform; ///< As torque, of the filter on tooth times, on kWaveformHarmonics.
    std::optional<FiringFigures> firing;
    std::optional<WorkFigures> work;
    MisfireFigures misfire; ///< Of the method that judges.
    MisfireFigures monitor; ///< Of the monitor beside it; the same where it is the method.
    sd_kept_t learned{};                  ///< At the end of the run.
    double pattern_sd_deg = 0;            ///< Of its tooth pattern; 0: nothing learned.
    double exponent = 0, exponent_sd = 0; ///< By which compression's exponent is larger than the calibration's, as learned with it; both 0:
                                          ///< not learned.
    std::optional<AfrFigures> afr;            ///< With a wideband sensor only.
    std::optional<BalanceFigures> balance;    ///< Where fuel trims were allowed.
    std::optional<DrivelineFigures> driveline; ///< With a car in the scenario, and a driveline in the page, only.
    Evidence evidence;                        ///< Of how well the calibration fits; over a bus none.
    double afr_late_s = 0;                    ///< What was learned of the delay to the lambda sensor (signal afr.late).
};

/// Whoever gets the plant's truth as it happens; the ecu does not.
class TruthSink {
  public:
    virtual ~TruthSink() = default;
    /// `crank_deg` is the true crank angle, never wrapping.
    virtual void edge(const EncoderEdge &edge, double crank_deg) = 0;
    virtual void cycle(const CycleTruth &cycle) = 0;
};

/// Runs the scenario to its end with the ecu behind `ecu`, which has the page `calibration`. The rest as below.
RunResult run_scenario(const Scenario &scenario, const sd_calibration_t &calibration, EcuFeed &ecu, RunTables *tables,
                       TruthSink *truth = nullptr);

/// Runs the scenario to its end. `calibration` comes from calibrate() and need not be of the scenario's
/// engine. `tables` (nullptr: nothing is kept per tooth) takes the rows, `listener` (may be empty) every event in and
/// out. `learned` (nullptr: none) is what was kept from before. A signal that wants the program to stop ends the run
/// early. `restart_s`: when the ecu begins anew. Throws InputError.
RunResult run_on_bench(const Scenario &scenario, const sd_calibration_t &calibration, RunTables *tables,
                       const sd_kept_t *learned = nullptr, const EventListener &listener = {},
                           std::optional<double> restart_s = std::nullopt);

} // namespace sixdeg
