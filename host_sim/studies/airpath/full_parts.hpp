// SPDX-License-Identifier: MIT
// The parts of `sixdeg study airpath` that run the full air path.
#pragma once
#include <string>

namespace sixdeg {

/// The observers on the full air path: delays, false alarms, transients, other faults. `design` empty: the engine file's own.
void print_full(const std::string &design, int runs, unsigned seed);
/// The four-state model beside it; `folder`, where not empty, takes figures_4_to_7.csv.
void print_model_error(const std::string &folder);
/// The [airpath] curves that fit it.
void print_fit();

} // namespace sixdeg
