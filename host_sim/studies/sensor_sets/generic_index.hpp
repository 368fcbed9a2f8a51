// SPDX-License-Identifier: MIT
// Observability index of a subset of the states (document 002, Definition 3) for every set of sensors, exact:
// the links get random numbers modulo a prime, so that a rank is wrong with a chance near 1e-9 and never by
// rounding.
#pragma once
#include <cstdint>
#include <vector>

#include "studies/sensor_sets/sensor_model.hpp"

namespace sixdeg {

struct SetQuery {
    std::vector<int> targets; ///< States to determine; at least one.
    int least = 1, most = 1;  ///< Numbers of sensors in a set.
    int draws_per_prime = 2;  ///< Independent draws for each of the two primes.
    std::uint64_t seed = 1;
};

struct IndexedSet {
    SensorSet set;
    int index; ///< 0 = the targets are not observable from this set.
};

struct IndexedSets {
    std::vector<IndexedSet> sets; ///< Every allowed set, in lexical order of the sensors' numbers.
    int disagreements = 0;        ///< Sets on which the draws differed; the answer is then the commonest.
};

IndexedSets index_sets(const SensorModel &model, const Structure &structure, const SetQuery &query);

/// How many sets index_sets() would visit, forbidden ones counted too.
double count_sets(std::size_t sensors, int least, int most);

} // namespace sixdeg
