// SPDX-License-Identifier: MIT
// From a recording to teeth whose place in the cycle is known: the decoder, and the cam, the pressure or the teeth for the phase.
#pragma once
#include <string>

#include "cli/replay_command.hpp"
#include "identify/crank_record.hpp"

namespace sixdeg {

struct RecordedTeeth {
    CrankRecord record;
    std::size_t edges = 0;
    std::vector<std::string> notes; ///< What a user should know, a sentence each.
};

/// `options`: file, columns, sensors, parity; `pressure` among the sensors, `bar` of one unit of it. The engine's wheel must be the
/// recording's. Throws InputError, and NotFollowed where the angle is never known.
RecordedTeeth read_recorded_teeth(const ReplayOptions &options, double bar, const EngineFile &engine);

} // namespace sixdeg
