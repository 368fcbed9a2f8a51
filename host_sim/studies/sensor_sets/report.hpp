// SPDX-License-Identifier: MIT
// Everything `sixdeg sensors` found, as a page to read and as JSON. Same findings, same bytes.
#pragma once
#include <nlohmann/json.hpp>
#include <string>

#include "studies/sensor_sets/numeric_study.hpp"

namespace sixdeg {

/// One sensor by itself, whole state, in one regime.
struct Alone {
    bool lin, shields_pearson;
    int index; ///< Exact index of the whole state, 0 = not observable.
};

struct Findings {
    const SensorModel &model;
    const SetQuery &query;
    std::vector<std::vector<Alone>> alone; ///< By sensor, then regime.
    Ranking ranking;
    std::vector<RankedSet> front;
    std::vector<std::vector<int>>
        published; ///< Our index of each published set, by regime; empty for other targets.
    const NumericModel *numeric = nullptr; ///< With `study`, or null.
    NumericStudy study{};
};

/// Judges every sensor alone, ranks the sets found by regime and looks the published ones up.
Findings find(const SensorModel &model, const SetQuery &query, const std::vector<IndexedSets> &by_regime);

/// `top`: how many sets to list.
std::string text(const Findings &findings, std::size_t top);
nlohmann::ordered_json json(const Findings &findings);

} // namespace sixdeg
