// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/ranking.hpp"

#include <algorithm>
#include <bitset>
#include <tuple>

namespace sixdeg {
namespace {

// Sensor numbers in ascending order compare like words: the set with the lower first difference comes first.
bool lexical(SensorSet a, SensorSet b) {
    const SensorSet difference = a ^ b;
    return difference != 0 && (a & (difference & -difference)) != 0;
}

bool better(const RankedSet &a, const RankedSet &b) {
    const auto key = [](const RankedSet &x) {
        return std::make_tuple(x.worst == 0, x.worst, x.cost, x.size);
    };
    return key(a) != key(b) ? key(a) < key(b) : lexical(a.set, b.set);
}

int worst_of(const std::vector<int> &index) {
    return std::count(index.begin(), index.end(), 0) ? 0 : *std::max_element(index.begin(), index.end());
}

} // namespace

Ranking rank_sets(const SensorModel &model, const std::vector<IndexedSets> &by_regime) {
    Ranking ranking;
    for (const auto &indexed : by_regime) {
        ranking.disagreements += indexed.disagreements;
        ranking.histograms.emplace_back();
        ranking.sets.resize(indexed.sets.size());
        for (std::size_t i = 0; i < indexed.sets.size(); ++i) {
            ++ranking.histograms.back()[indexed.sets[i].index];
            ranking.sets[i].set = indexed.sets[i].set;
            ranking.sets[i].index.push_back(indexed.sets[i].index);
        }
    }
    for (auto &entry : ranking.sets) {
        entry.worst = worst_of(entry.index);
        entry.cost = model.cost(entry.set);
        entry.size = int(std::bitset<32>(entry.set).count());
    }
    std::sort(ranking.sets.begin(), ranking.sets.end(), better);
    return ranking;
}

std::vector<RankedSet> pareto_front(const Ranking &ranking) {
    std::vector<RankedSet> front;
    // In ranked order nobody later has a lower index, so only those already on the front can beat a set.
    for (const auto &entry : ranking.sets) {
        if (entry.worst == 0) break;
        const bool beaten = std::any_of(front.begin(), front.end(), [&](const RankedSet &other) {
            return other.cost <= entry.cost && other.size <= entry.size;
        });
        if (!beaten) front.push_back(entry);
    }
    return front;
}

} // namespace sixdeg
