// SPDX-License-Identifier: MIT
// sixdeg replay without a cam: which revolution begins the cycle, where the teeth tell.
#include <fmt/format.h>

#include "cli/replay_command.hpp"
#include "loop/phase_finder.hpp"

namespace sixdeg {

ParityFound find_parity(const std::string &file, const Guess &guess, const EngineFile &engine, double stall_s) {
    PhaseFinder finder(engine);
    RecordedEvents events(file, guess, {});
    ReplayPlan plan;
    plan.positions = engine.wheel.positions;
    plan.next = [&](RecordedEvent &event) { return finder.wants_more() && events.next(event); };
    CrankAlone crank(file, engine, stall_s);
    replay(plan, crank, finder);
    const PhaseFinder::Answer answer = finder.answer();
    if (answer.fires_alike) {
        return {std::nullopt, "no cam, and the engine fires at the same angles a revolution later, so that teeth cannot tell which one it "
                              "is; --parity gives it"};
    }
    if (!answer.clear) {
        return {std::nullopt, fmt::format("no cam, and {} cycles do not tell clearly which revolution begins one ({:.1f} standard "
                                          "deviations); --parity gives it",
                                          answer.cycles, answer.sds)};
    }
    return {answer.parity, fmt::format("no cam: the {} revolution in sync begins the cycle, since the crank speeds up behind its firing "
                                       "TDCs ({} cycles, {:.0f} standard deviations); --parity overrules it",
                                       answer.parity == 0 ? "first" : "second", answer.cycles, answer.sds)};
}

} // namespace sixdeg
