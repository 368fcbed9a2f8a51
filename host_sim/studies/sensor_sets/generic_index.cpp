// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/generic_index.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "studies/sensor_sets/modular.hpp"

namespace sixdeg {
namespace {

// The largest two primes below 2^31.
using Mersenne = Modular<1>;
using Neighbour = Modular<19>;

using Row = std::vector<std::uint32_t>;

// One draw: a random number on every link, and from it the rows c A^k of every sensor.
template <class Field> class Draw {
  public:
    Draw(const Structure &structure, std::uint64_t seed) : n_(structure.states.size()), random_(seed) {
        std::vector<Row> shared;
        for (const auto &links : structure.shared) shared.push_back(draw_row(links, shared));
        for (const auto &links : structure.states) a_.push_back(draw_row(links, shared));
        for (const auto &links : structure.sensors) c_.push_back(draw_row(links, shared));
    }

    /// The sensor's row and its derivatives, `count` rows.
    std::vector<Row> derivatives(std::size_t sensor, int count) const {
        std::vector<Row> rows{c_[sensor]};
        while (int(rows.size()) < count) rows.push_back(times_a(rows.back()));
        return rows;
    }

  private:
    // mt19937_64 gives the same numbers everywhere; std::uniform_int_distribution does not.
    std::uint32_t draw() { return std::uint32_t(1 + random_() % (Field::prime - 1)); }

    Row draw_row(const Links &links, const std::vector<Row> &shared) {
        Row row(n_, 0);
        for (const int state : links.states) row[std::size_t(state)] = draw();
        for (const int quantity : links.shared) {
            const std::uint32_t factor = draw();
            const Row &seen = shared[std::size_t(quantity)];
            for (std::size_t j = 0; j < n_; ++j)
                row[j] = Field::add(row[j], Field::multiply(factor, seen[j]));
        }
        return row;
    }

    Row times_a(const Row &row) const {
        Row product(n_, 0);
        for (std::size_t i = 0; i < n_; ++i) {
            if (row[i] == 0) continue;
            for (std::size_t j = 0; j < n_; ++j)
                product[j] = Field::reduce(std::uint64_t(row[i]) * a_[i][j] + product[j]);
        }
        return product;
    }

    std::size_t n_;
    std::mt19937_64 random_;
    std::vector<Row> a_, c_;
};

// Walks the sets as a tree, each node one sensor more than its parent. A node keeps, for every number of
// derivatives that does not suffice yet, the echelon form of its rows; what suffices for the parent suffices
// for the child.
template <class Field> class Walk {
  public:
    Walk(const SensorModel &model, const Structure &structure, const SetQuery &query, std::uint64_t seed)
        : model_(model), query_(query), n_(structure.states.size()), none_(longest_index(model) + 1) {
        const Draw<Field> draw(structure, seed);
        const auto order = targets_last(query.targets);
        for (std::size_t i = 0; i < model.sensors.size(); ++i) {
            auto rows = draw.derivatives(i, none_);
            rows_.emplace_back();
            for (const Row &row : rows) {
                for (const int column : order) rows_.back().push_back(row[std::size_t(column)]);
            }
        }
        const Echelon<Field> empty(int(n_), int(query.targets.size()));
        nodes_.assign(std::size_t(query.most) + 1, std::vector<Echelon<Field>>(std::size_t(none_), empty));
        scratch_.resize(n_);
        shortest_ = index_of_all(empty);
    }

    std::vector<IndexedSet> run() {
        visit(0, 0, 0, none_);
        return std::move(found_);
    }

  private:
    // By Cayley and Hamilton n derivatives say all; a lag delays what a sensor says by one.
    int longest_index(const SensorModel &model) const {
        std::size_t lags = 0;
        for (const auto &sensor : model.sensors) lags = std::max(lags, sensor.lags_s.size());
        return int(n_ + lags);
    }

    std::vector<int> targets_last(const std::vector<int> &targets) const {
        std::vector<int> order;
        for (int i = 0; i < int(n_); ++i) {
            if (!std::count(targets.begin(), targets.end(), i)) order.push_back(i);
        }
        order.insert(order.end(), targets.begin(), targets.end());
        return order;
    }

    // Level rho holds y and its first rho - 1 derivatives. The state of a lag is known from y itself, so the
    // k-th derivative of a lagged signal adds to the plant what the (k - lags)-th of the signal would:
    // docs/theory/sensors.md.
    void add_sensor(Echelon<Field> &echelon, std::size_t sensor, int level) {
        const int usable = level - int(model_.sensors[sensor].lags_s.size());
        for (int k = 0; k < usable && !echelon.determines_wanted(); ++k) {
            std::copy_n(&rows_[sensor][std::size_t(k) * n_], n_, scratch_.begin());
            echelon.add(scratch_.data());
        }
    }

    // No set does better than all sensors together: levels below that are never worth a look.
    int index_of_all(const Echelon<Field> &empty) {
        for (int level = 1; level < none_; ++level) {
            Echelon<Field> echelon = empty;
            for (std::size_t i = 0; i < model_.sensors.size(); ++i) add_sensor(echelon, i, level);
            if (echelon.determines_wanted()) return level;
        }
        return none_;
    }

    bool allowed(SensorSet set) const {
        return std::none_of(model_.forbidden.begin(), model_.forbidden.end(),
                            [&](SensorSet forbidden) { return (set & forbidden) == forbidden; });
    }

    void visit(int size, std::size_t first, SensorSet parent, int parent_index) {
        if (size == query_.most) return;
        for (std::size_t sensor = first; sensor < model_.sensors.size(); ++sensor) {
            const SensorSet set = parent | SensorSet(1) << sensor;
            if (!allowed(set)) continue;
            const bool leaf = size + 1 == query_.most || sensor + 1 == model_.sensors.size();
            const int index = extend(std::size_t(size), sensor, parent_index, leaf);
            if (size + 1 >= query_.least) found_.push_back({set, index == none_ ? 0 : index});
            visit(size + 1, sensor + 1, set, index);
        }
    }

    // Index of the parent's set with one sensor more. A leaf needs no levels below the first that fails.
    int extend(std::size_t size, std::size_t sensor, int parent_index, bool leaf) {
        int index = parent_index;
        for (int level = parent_index - 1; level >= shortest_; --level) {
            Echelon<Field> &echelon = nodes_[size + 1][std::size_t(level)];
            echelon = nodes_[size][std::size_t(level)];
            add_sensor(echelon, sensor, level);
            if (echelon.determines_wanted()) {
                index = level;
            } else if (leaf) {
                break;
            }
        }
        return index;
    }

    const SensorModel &model_;
    const SetQuery &query_;
    std::size_t n_;
    int none_, shortest_ = 1; ///< none_: one more than the longest possible index.
    std::vector<Row> rows_;   ///< By sensor, one derivative after the other, targets in the last columns.
    std::vector<std::vector<Echelon<Field>>> nodes_; ///< By number of sensors, then level.
    Row scratch_;
    std::vector<IndexedSet> found_;
};

int commonest(const std::vector<int> &values) {
    std::map<int, int> votes;
    for (const int value : values) ++votes[value];
    return std::max_element(votes.begin(), votes.end(), [](auto &a, auto &b) { return a.second < b.second; })
        ->first;
}

} // namespace

IndexedSets index_sets(const SensorModel &model, const Structure &structure, const SetQuery &query) {
    std::vector<std::vector<IndexedSet>> draws;
    for (int i = 0; i < query.draws_per_prime; ++i) {
        draws.push_back(Walk<Mersenne>(model, structure, query, query.seed + std::uint64_t(2 * i)).run());
        draws.push_back(
            Walk<Neighbour>(model, structure, query, query.seed + std::uint64_t(2 * i + 1)).run());
    }
    IndexedSets result{draws.front(), 0};
    for (std::size_t i = 0; i < result.sets.size(); ++i) {
        std::vector<int> votes;
        for (const auto &draw : draws) votes.push_back(draw[i].index);
        if (std::adjacent_find(votes.begin(), votes.end(), std::not_equal_to<>()) == votes.end()) continue;
        ++result.disagreements;
        result.sets[i].index = commonest(votes);
    }
    return result;
}

double count_sets(std::size_t sensors, int least, int most) {
    double count = 0, choose = 1;
    for (int size = 1; size <= most; ++size) {
        choose *= double(int(sensors) - size + 1) / size;
        if (size >= least) count += std::round(choose);
    }
    return count;
}

} // namespace sixdeg
