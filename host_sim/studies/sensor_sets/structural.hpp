// SPDX-License-Identifier: MIT
// Structural observability of the whole state, two ways that must agree: the staircase matrix of Shields and
// Pearson (1976) and the graph criterion of Lin (1974). Both see only which entries of A and C can differ
// from zero.
#pragma once
#include <vector>

#include "studies/sensor_sets/sensor_model.hpp"

namespace sixdeg {

/// Nonzero columns of each row, ascending.
using Pattern = std::vector<std::vector<int>>;

/// dx/dt = A x, y = C x with the sensors' own lag states behind the plant's.
struct LinearPattern {
    Pattern a, c;
};

/// The plant seen by one set of sensors; shared quantities are spelt out.
LinearPattern pattern(const SensorModel &model, const Structure &structure, SensorSet set);

/// Greatest number of nonzero entries no two of which share a row or a column.
int structural_rank(const Pattern &rows, int columns);

bool observable_shields_pearson(const LinearPattern &system);
bool observable_lin(const LinearPattern &system);

} // namespace sixdeg
