// SPDX-License-Identifier: MIT
// Which set is best, and how long it takes to know.
#include <gtest/gtest.h>

#include "studies/sensor_sets/ranking.hpp"

using namespace sixdeg;

namespace {

using Histogram = std::map<int, int>;

SensorModel load(const std::string &name) {
    TomlFile file{std::filesystem::path(SD_MODELS) / name};
    return read_sensor_model(file);
}

TEST(Ranking, ParetoFrontIsTheUnbeatenSets) {
    const auto model = load("turbo_si_13.toml");
    SetQuery query;
    query.targets = model.targets;
    query.least = 1;
    query.most = 3;
    std::vector<IndexedSets> by_regime;
    for (const auto &regime : model.regimes) by_regime.push_back(index_sets(model, regime.structure, query));
    const auto ranking = rank_sets(model, by_regime);
    const auto front = pareto_front(ranking);
    const auto as_good = [](const RankedSet &a, const RankedSet &b) {
        return a.worst <= b.worst && a.cost <= b.cost && a.size <= b.size;
    };
    ASSERT_EQ(ranking.sets.size(), 833u);
    EXPECT_GT(front.size(), 3u);
    for (const auto &entry : ranking.sets) {
        const auto beats =
            std::count_if(front.begin(), front.end(), [&](auto &member) { return as_good(member, entry); });
        EXPECT_GE(beats, 1) << "nothing on the front is as good as set " << entry.set;
    }
    for (const auto &member : front) {
        for (const auto &other : front) EXPECT_TRUE(member.set == other.set || !as_good(other, member));
    }
}

TEST(Ranking, WorstRegimeCountsAndUnobservableComesLast) {
    const auto model = load("turbo_si_13.toml");
    const std::vector<IndexedSets> by_regime{{{{1, 3}, {2, 2}, {4, 0}}, 0}, {{{1, 3}, {2, 9}, {4, 2}}, 1}};
    const auto ranking = rank_sets(model, by_regime);
    ASSERT_EQ(ranking.sets.size(), 3u);
    EXPECT_EQ(ranking.sets[0].set, 1u);
    EXPECT_EQ(ranking.sets[1].worst, 9);
    EXPECT_EQ(ranking.sets[2].worst, 0);
    EXPECT_EQ(ranking.disagreements, 1);
    EXPECT_EQ(ranking.histograms[0], (Histogram{{0, 1}, {2, 1}, {3, 1}}));
}

} // namespace
