// SPDX-License-Identifier: MIT
// The tables of print_afr_study, each printed to standard output; `cases`: the first so many operating points.
#pragma once

namespace sixdeg::afr_study {

void accuracy(int seeds, int cases); ///< The joint filter with its default parameters, nominal and perturbed, slow mode too.
void blames(int seeds, int cases);   ///< Which cylinder is off.
void doubts(int seeds, int cases);   ///< What is stated with the default doubt of lags and delay.
void recirculation(int seeds); ///< With exhaust gas led back, known and unknown.
void ghosts();                 ///< What a balanced engine seems to be off by.
void chain(int seeds);         ///< The chain of document 004 (docs/theory/afr.md), block by block.
void pressure();               ///< The chain with a pressure sensor, and with a wrong turbine area.
void readings();               ///< What a test bench's slow instruments read: exhaust.reading of the engine file.

} // namespace sixdeg::afr_study
