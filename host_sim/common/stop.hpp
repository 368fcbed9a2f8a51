// SPDX-License-Identifier: MIT
// SIGINT and SIGTERM as a wish to stop: a long command asks between two events, closes its files and leaves.
#pragma once

namespace sixdeg {

/// Takes both signals from now on. A second one of the same kind ends the program at once.
void stop_on_signals();
/// The signal that came, 0 for none.
int stop_signal();
/// Call it last: where a signal came, ends the program by it, so that a shell sees why.
void end_by_signal();

} // namespace sixdeg
