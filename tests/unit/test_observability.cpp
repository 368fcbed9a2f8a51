// SPDX-License-Identifier: MIT
// Which sensors, without numbers: structural observability two ways, exact index, published answers.
#include <algorithm>
#include <gtest/gtest.h>
#include <random>

#include "studies/sensor_sets/generic_index.hpp"
#include "studies/sensor_sets/modular.hpp"
#include "studies/sensor_sets/structural.hpp"

using namespace sixdeg;

namespace {

SensorModel load(const std::string &name) {
    TomlFile file{std::filesystem::path(SD_MODELS) / name};
    return read_sensor_model(file);
}

std::map<int, int> histogram(const SensorModel &model, std::size_t regime, int least, int most) {
    SetQuery query;
    query.targets = model.targets;
    query.least = least;
    query.most = most;
    const auto indexed = index_sets(model, model.regimes[regime].structure, query);
    EXPECT_EQ(indexed.disagreements, 0);
    std::map<int, int> counts;
    for (const auto &entry : indexed.sets) ++counts[entry.index];
    return counts;
}

// "pim Tim pem" of every triple with this index.
std::vector<std::string> triples(const SensorModel &model, std::size_t regime, int index) {
    SetQuery query;
    query.targets = model.targets;
    query.least = query.most = 3;
    std::vector<std::string> names;
    for (const auto &entry : index_sets(model, model.regimes[regime].structure, query).sets) {
        if (entry.index != index) continue;
        names.emplace_back();
        for (const auto &sensor : model.sensor_names(entry.set))
            names.back() += (names.back().empty() ? "" : " ") + sensor;
    }
    return names;
}

using Histogram = std::map<int, int>;
using Names = std::vector<std::string>;

// The counts below were found by an independent exact computation before this tool was written
// (docs/theory/sensors.md, "Results").
TEST(TurboSi, HistogramsOfTriples) {
    const auto model = load("turbo_si_13.toml");
    EXPECT_EQ(histogram(model, 0, 3, 3), (Histogram{{2, 1}, {3, 6}, {4, 3}, {5, 606}, {6, 49}, {7, 15}}));
    EXPECT_EQ(histogram(model, 1, 3, 3),
              (Histogram{{2, 1}, {3, 6}, {4, 3}, {5, 480}, {6, 19}, {7, 87}, {8, 74}, {9, 10}}));
}

TEST(TurboSi, HistogramsOfOtherSizesUnchoked) {
    const auto model = load("turbo_si_13.toml");
    EXPECT_EQ(histogram(model, 0, 2, 2), (Histogram{{7, 120}, {8, 15}, {13, 1}}));
    EXPECT_EQ(histogram(model, 0, 4, 4), (Histogram{{2, 22}, {3, 133}, {4, 1907}, {5, 293}, {6, 25}}));
    EXPECT_EQ(histogram(model, 0, 5, 5), (Histogram{{2, 213}, {3, 3620}, {4, 2146}, {5, 200}, {6, 9}}));
}

TEST(TurboSi, ShortListsAreTheSameInBothRegimes) {
    const auto model = load("turbo_si_13.toml");
    for (std::size_t regime = 0; regime < 2; ++regime) {
        EXPECT_EQ(triples(model, regime, 2), (Names{"pim Tim pem"}));
        EXPECT_EQ(triples(model, regime, 3), (Names{"pic pim Tim", "Tic pim Tim", "pim Tim Wth",
                                                    "pim pem Tem", "Tim pem Tem", "pem Tem pt"}));
        EXPECT_EQ(triples(model, regime, 4), (Names{"pem pt Tt", "Tem pt Tt", "pt Tt wtc"}));
    }
}

TEST(TurboSi, EverySensorAloneObservesTheWholeStateInBothRegimes) {
    const auto model = load("turbo_si_13.toml");
    ASSERT_EQ(model.sensors.size(), 17u);
    ASSERT_EQ(model.regimes.size(), 2u);
    for (const auto &regime : model.regimes) {
        for (std::size_t i = 0; i < model.sensors.size(); ++i) {
            const auto system = pattern(model, regime.structure, SensorSet(1) << i);
            EXPECT_TRUE(observable_lin(system)) << regime.name << " " << model.sensors[i].name;
            EXPECT_TRUE(observable_shields_pearson(system)) << regime.name << " " << model.sensors[i].name;
        }
    }
}

// Document 002 concludes that 5 of 680 triples reach an index of 3 or less: so they do once flows are shared.
TEST(TurboSiFlows, FiveTriplesReachThree) {
    const auto model = load("turbo_si_13_flows.toml");
    for (std::size_t regime = 0; regime < 2; ++regime) {
        EXPECT_EQ(triples(model, regime, 2), (Names{"pim Tim pem"}));
        EXPECT_EQ(triples(model, regime, 3),
                  (Names{"pic pim Tim", "pim Tim Wth", "pim pem Tem", "Tim pem Tem"}));
        EXPECT_EQ(triples(model, regime, 4), Names{});
    }
}

TEST(TurboSiFlows, HasTheSameLinksAsTheEngine) {
    const auto engine = load("turbo_si_13.toml"), flows = load("turbo_si_13_flows.toml");
    const SensorSet all = (1u << 17) - 1;
    for (std::size_t r = 0; r < 2; ++r) {
        const auto a = pattern(engine, engine.regimes[r].structure, all),
                   b = pattern(flows, flows.regimes[r].structure, all);
        EXPECT_EQ(a.a, b.a);
        EXPECT_EQ(a.c, b.c);
    }
}

// Brockett 1970: angle alone observes the orbit, radius alone misses the angle. The rest follows by hand: vr
// alone sees r and vtheta only in one sum, for ever; with the angle, one derivative of a second sensor fills
// the rest.
TEST(Satellite, KnownAnswers) {
    const auto model = load("satellite_orbit.toml");
    SetQuery query;
    query.targets = model.targets;
    query.most = 4;
    std::map<std::string, int> index;
    for (const auto &entry : index_sets(model, model.regimes[0].structure, query).sets) {
        std::string names;
        for (const auto &sensor : model.sensor_names(entry.set)) names += sensor + " ";
        index[names] = entry.index;
    }
    const std::map<std::string, int> expected{{"r ", 0},
                                              {"vr ", 0},
                                              {"theta ", 4},
                                              {"vtheta ", 0},
                                              {"r vr ", 0},
                                              {"r theta ", 2},
                                              {"r vtheta ", 0},
                                              {"vr theta ", 2},
                                              {"vr vtheta ", 0},
                                              {"theta vtheta ", 3},
                                              {"r vr theta ", 2},
                                              {"r vr vtheta ", 0},
                                              {"r theta vtheta ", 2},
                                              {"vr theta vtheta ", 2},
                                              {"r vr theta vtheta ", 1}};
    EXPECT_EQ(index, expected);
}

TEST(Satellite, StructureAloneTellsWhichSensorSuffices) {
    const auto model = load("satellite_orbit.toml");
    const std::vector<bool> expected{false, false, true, false}; // r, vr (a dilation), theta, vtheta
    for (std::size_t i = 0; i < 4; ++i) {
        const auto system = pattern(model, model.regimes[0].structure, SensorSet(1) << i);
        EXPECT_EQ(observable_lin(system), expected[i]) << model.sensors[i].name;
        EXPECT_EQ(observable_shields_pearson(system), expected[i]) << model.sensors[i].name;
    }
}

// x1 and x2 feed only x3: the observability matrix [x3; x1 + x2 + x3; x1 + x2 + x3] has full structural rank,
// yet no numbers make the pair observable. The trap that Shields and Pearson's theorem avoids.
TEST(Structural, FullStructuralRankOfTheObservabilityMatrixIsNotEnough) {
    const LinearPattern dilation{{{}, {}, {0, 1, 2}}, {{2}}};
    EXPECT_EQ(structural_rank({{2}, {0, 1, 2}, {0, 1, 2}}, 3), 3);
    EXPECT_FALSE(observable_lin(dilation));
    EXPECT_FALSE(observable_shields_pearson(dilation));
}

// --- three ways to one answer, on random structures
// -------------------------------------------------------------

SensorModel random_model(unsigned seed) {
    std::mt19937 random(seed);
    const auto below = [&](std::size_t n) { return random() % n; };
    SensorModel model;
    Structure structure;
    const std::size_t states = 2 + below(6), sensors = 1 + below(3);
    for (std::size_t i = 0; i < states; ++i) {
        model.states.push_back("x" + std::to_string(i));
        model.targets.push_back(int(i));
        structure.states.emplace_back();
        for (std::size_t j = 0; j < states; ++j) {
            if (below(states * 10) < 16) structure.states.back().states.push_back(int(j));
        }
    }
    for (std::size_t i = 0; i < sensors; ++i) {
        model.sensors.push_back({"y" + std::to_string(i), std::vector<double>(below(3), 1.0)});
        structure.sensors.push_back({{int(below(states))}, {}});
    }
    model.regimes.push_back({"full", structure});
    return model;
}

TEST(Structural, LinShieldsPearsonAndExactRankAgreeOnRandomModels) {
    int observable = 0, sets = 0;
    for (unsigned seed = 0; seed < 150; ++seed) {
        const auto model = random_model(seed);
        SetQuery query;
        query.targets = model.targets;
        query.most = int(model.sensors.size());
        for (const auto &entry : index_sets(model, model.regimes[0].structure, query).sets) {
            const auto system = pattern(model, model.regimes[0].structure, entry.set);
            EXPECT_EQ(observable_lin(system), entry.index > 0) << "seed " << seed << " set " << entry.set;
            EXPECT_EQ(observable_shields_pearson(system), entry.index > 0)
                << "seed " << seed << " set " << entry.set;
            observable += entry.index > 0;
            ++sets;
        }
    }
    // The models must put both answers to the test.
    EXPECT_GT(observable, sets / 5);
    EXPECT_LT(observable, sets * 4 / 5);
}

// Definition 3 word for word: all lag states written out, ranks by plain elimination, own numbers, no
// incremental anything.
class WordForWord {
  public:
    WordForWord(const SensorModel &model, const Structure &structure, SensorSet set, unsigned seed)
        : random_(seed) {
        const auto system = pattern(model, structure, set);
        a_ = numbers(system.a, system.a.size());
        c_ = numbers(system.c, system.a.size());
    }

    int index(const std::vector<int> &targets) const {
        Matrix all, block = c_;
        for (int rho = 1; rho <= int(a_.size()); ++rho) {
            all.insert(all.end(), block.begin(), block.end());
            if (rank(all) == int(targets.size()) + rank(without(all, targets))) return rho;
            block = times(block, a_);
        }
        return 0;
    }

  private:
    using Matrix = std::vector<std::vector<std::uint64_t>>;
    static constexpr std::uint64_t prime = 1000000007; // a third prime

    Matrix numbers(const Pattern &pattern, std::size_t columns) {
        Matrix matrix;
        for (const auto &row : pattern) {
            matrix.emplace_back(columns, 0);
            for (const int column : row) matrix.back()[std::size_t(column)] = 1 + random_() % (prime - 1);
        }
        return matrix;
    }

    static Matrix times(const Matrix &a, const Matrix &b) {
        Matrix product(a.size(), std::vector<std::uint64_t>(b.size(), 0));
        for (std::size_t i = 0; i < a.size(); ++i) {
            for (std::size_t k = 0; k < b.size(); ++k) {
                for (std::size_t j = 0; j < b.size(); ++j)
                    product[i][j] = (product[i][j] + a[i][k] * b[k][j]) % prime;
            }
        }
        return product;
    }

    static Matrix without(Matrix matrix, const std::vector<int> &columns) {
        for (auto &row : matrix) {
            for (const int column : columns) row[std::size_t(column)] = 0;
        }
        return matrix;
    }

    static int rank(Matrix m) {
        std::size_t rank = 0;
        for (std::size_t column = 0; column < m[0].size() && rank < m.size(); ++column) {
            const auto pivot = std::find_if(m.begin() + std::ptrdiff_t(rank), m.end(),
                                            [&](auto &row) { return row[column]; });
            if (pivot == m.end()) continue;
            std::swap(*pivot, m[rank]);
            for (std::size_t i = rank + 1; i < m.size(); ++i) {
                const auto keep = m[rank][column], take = prime - m[i][column];
                for (std::size_t j = 0; j < m[i].size(); ++j)
                    m[i][j] = (keep * m[i][j] + take * m[rank][j]) % prime;
            }
            ++rank;
        }
        return int(rank);
    }

    std::mt19937_64 random_;
    Matrix a_, c_;
};

TEST(ExactIndex, IsDefinition3WithLagStatesWrittenOut) {
    const auto model = load("turbo_si_13.toml");
    SetQuery query;
    query.targets = model.targets;
    query.least = 1;
    query.most = 4;
    for (const auto &regime : model.regimes) {
        const auto indexed = index_sets(model, regime.structure, query);
        for (std::size_t i = 0; i < indexed.sets.size(); i += 23) {
            WordForWord plain(model, regime.structure, indexed.sets[i].set, unsigned(i));
            EXPECT_EQ(indexed.sets[i].index, plain.index(query.targets))
                << regime.name << " set " << indexed.sets[i].set;
        }
    }
}

TEST(ExactIndex, IsDefinition3ForPartOfTheStateOfRandomModels) {
    for (unsigned seed = 0; seed < 60; ++seed) {
        const auto model = random_model(seed);
        SetQuery query;
        query.targets = {int(model.states.size()) - 1, 0};
        query.most = int(model.sensors.size());
        for (const auto &entry : index_sets(model, model.regimes[0].structure, query).sets) {
            WordForWord plain(model, model.regimes[0].structure, entry.set, seed);
            EXPECT_EQ(entry.index, plain.index(query.targets)) << "seed " << seed << " set " << entry.set;
        }
    }
}

TEST(ExactIndex, ForbiddenCombinationsAndTheirSupersetsAreLeftOut) {
    auto model = load("satellite_orbit.toml");
    model.forbidden = {0b0011};
    SetQuery query;
    query.targets = model.targets;
    query.most = 4;
    const auto sets = index_sets(model, model.regimes[0].structure, query).sets;
    EXPECT_EQ(sets.size(), 11u); // of 15
    for (const auto &entry : sets) EXPECT_NE(entry.set & 0b0011, 0b0011u);
}

TEST(ExactIndex, CountsSets) {
    EXPECT_EQ(count_sets(17, 3, 3), 680);
    EXPECT_EQ(count_sets(17, 1, 5), 9401);
    EXPECT_EQ(count_sets(17, 1, 17), 131071);
}

template <class Field> void check_field() {
    const std::uint64_t p = Field::prime;
    for (std::uint64_t d = 2; d * d <= p; ++d) ASSERT_NE(p % d, 0u) << p << " is not prime";
    for (const std::uint64_t x :
         {std::uint64_t(0), p - 1, p, p + 1, 2 * p, (p - 1) * (p - 1), 2 * (p - 1) * (p - 1),
          (std::uint64_t(1) << 63) - 1, std::uint64_t(1) << 63}) {
        EXPECT_EQ(Field::reduce(x), x % p) << x;
    }
}

TEST(Modular, ReducesExactlyAtTheEdges) {
    check_field<Modular<1>>();
    check_field<Modular<19>>();
}

} // namespace
