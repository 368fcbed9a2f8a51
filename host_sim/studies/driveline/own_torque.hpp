// SPDX-License-Identifier: MIT
// The guard filter in the ecu, which knows the engine's torque by its own filter on tooth times alone, beside filters that are told the
// true torque, all on the same teeth of the same simulated engine and car.
#pragma once
#include <cstdint>

#include "plant/scenario/scenario.hpp"
#include "studies/driveline/drive_score.hpp"

namespace sixdeg {

/// Second gear, 2.0 l four, cyclic variation 3 %, jitter 0.02 deg, and a driver drawn from `seed`: tip-ins to 60 N m and overrun without
/// fuel every 0.6 to 3 s, so that the speed stays between some 1300 and 3200 rpm.
Scenario own_torque_drive(double seconds, std::uint64_t seed);

struct OwnTorqueFigures {
    DriveFigures own;        ///< The ecu's.
    DriveFigures same;       ///< Told the truth, with the ecu's tables.
    DriveFigures believing;  ///< Told the truth, and with tables that believe it.
};
/// The ecu's page believes what the drive's engine file says; `drive` may say otherwise.
OwnTorqueFigures run_own_torque(const Scenario &drive, const EngineFile &believed);

} // namespace sixdeg
