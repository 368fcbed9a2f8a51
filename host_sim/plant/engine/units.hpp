// SPDX-License-Identifier: MIT
// Conversions at the edges; inside, everything is SI and radians.
#pragma once

namespace sixdeg {

constexpr double kPi = 3.14159265358979323846;
constexpr double kRadPerDeg = kPi / 180, kDegPerRad = 180 / kPi;
constexpr double kRadpsPerRpm = kPi / 30;
constexpr double kPaPerBar = 1e5;

} // namespace sixdeg
