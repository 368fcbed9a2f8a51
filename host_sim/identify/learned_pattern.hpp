// SPDX-License-Identifier: MIT
// The tooth pattern that was found, as the firmware keeps what it learned in fuel cut: `run` and `replay` begin with it.
#pragma once
#include "identify/identify.hpp"
extern "C" {
#include "sd_learned.h"
}

namespace sixdeg {

/// Sums of sd_pattern.h that say this pattern and its deviation, rms over the teeth; the rest as in an ecu that has learned nothing. The
/// firmware goes on from them: they weigh as much as the cycles that the pattern is from. Throws InputError naming `from` where no
/// pattern was found, or one of a tooth is missing.
sd_kept_t kept_of(const Identified &found, const std::string &from);

} // namespace sixdeg
