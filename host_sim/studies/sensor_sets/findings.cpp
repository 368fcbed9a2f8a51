// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/report.hpp"
#include "studies/sensor_sets/structural.hpp"

namespace sixdeg {
namespace {

std::vector<std::vector<Alone>> judge_alone(const SensorModel &model, const SetQuery &query) {
    SetQuery single = query;
    single.least = single.most = 1;
    single.targets.clear();
    for (std::size_t i = 0; i < model.states.size(); ++i) single.targets.push_back(int(i));
    std::vector<std::vector<Alone>> alone(model.sensors.size());
    // A sensor that no set may hold is still worth judging.
    SensorModel free = model;
    free.forbidden.clear();
    for (const auto &regime : model.regimes) {
        const auto indexed = index_sets(free, regime.structure, single);
        for (std::size_t i = 0; i < alone.size(); ++i) {
            const auto system = pattern(model, regime.structure, SensorSet(1) << i);
            alone[i].push_back(
                {observable_lin(system), observable_shields_pearson(system), indexed.sets[i].index});
        }
    }
    return alone;
}

// A published set need not be of the size asked for: it is looked up in a walk of its own sensors only.
int index_of(const SensorModel &model, const Structure &structure, const SetQuery &query, SensorSet set) {
    SensorModel few = model;
    Structure seen = structure;
    few.sensors.clear();
    seen.sensors.clear();
    few.forbidden.clear();
    for (std::size_t i = 0; i < model.sensors.size(); ++i) {
        if (!(set >> i & 1)) continue;
        few.sensors.push_back(model.sensors[i]);
        seen.sensors.push_back(structure.sensors[i]);
    }
    SetQuery whole = query;
    whole.least = whole.most = int(few.sensors.size());
    return index_sets(few, seen, whole).sets.front().index;
}

} // namespace

Findings find(const SensorModel &model, const SetQuery &query, const std::vector<IndexedSets> &by_regime) {
    Findings findings{model, query, judge_alone(model, query), rank_sets(model, by_regime), {}, {}};
    findings.front = pareto_front(findings.ranking);
    // What was published concerns the model's own targets.
    if (query.targets != model.targets) return findings;
    for (const auto &published : model.published) {
        findings.published.emplace_back();
        for (const auto &regime : model.regimes) {
            findings.published.back().push_back(index_of(model, regime.structure, query, published.set));
        }
    }
    return findings;
}

} // namespace sixdeg
