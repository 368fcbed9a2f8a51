// SPDX-License-Identifier: MIT
// All sets of a query, in every regime, best first.
#pragma once
#include <map>
#include <vector>

#include "studies/sensor_sets/generic_index.hpp"

namespace sixdeg {

struct RankedSet {
    SensorSet set;
    std::vector<int> index; ///< By regime, 0 = not observable.
    int worst;              ///< Greatest of them; 0 when any is 0.
    double cost;
    int size;
};

struct Ranking {
    std::vector<RankedSet> sets; ///< By worst index (0 last), then cost, size and sensor numbers.
    std::vector<std::map<int, int>> histograms; ///< By regime: index -> number of sets.
    int disagreements = 0;                      ///< Over all regimes.
};

/// `by_regime`: what index_sets() said of each regime for one query.
Ranking rank_sets(const SensorModel &model, const std::vector<IndexedSets> &by_regime);

/// The sets no other set beats: no other is at least as good in index, cost and number and better in one of
/// them. Of sets alike in all three only the first is kept. In order of the ranking.
std::vector<RankedSet> pareto_front(const Ranking &ranking);

} // namespace sixdeg
