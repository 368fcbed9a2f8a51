// SPDX-License-Identifier: MIT
// Numbers of the random streams of one run: each use has its own, so that switching one on changes no other.
#pragma once
#include <cstdint>

namespace sixdeg::stream {

constexpr std::uint32_t kJitter = 1, kDrops = 2, kExtras = 3, kCam = 4, kPattern = 5, kRoad = 6, kUego = 7, kExhaustPressure = 8;
constexpr std::uint32_t kAirPath = 9, kAirPathErrors = 10, kVehicleWheel = 11;
/// Plus the cylinder's index in firing order.
constexpr std::uint32_t kCyclic = 100, kMisfire = 200;
constexpr std::uint32_t kPerturbation = 300, kMisfireSet = 301, kIdentifyStudy = 302, kIdentifyNoise = 303;

} // namespace sixdeg::stream
