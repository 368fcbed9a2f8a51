// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/structural.hpp"

#include <set>

namespace sixdeg {
namespace {

std::vector<int> spelt_out(const Links &links, const Pattern &shared) {
    std::set<int> states(links.states.begin(), links.states.end());
    for (const int quantity : links.shared) {
        const auto &row = shared[std::size_t(quantity)];
        states.insert(row.begin(), row.end());
    }
    return {states.begin(), states.end()};
}

// Matching by augmenting paths: a row without a column takes one, its owner looks for another.
class Matching {
  public:
    Matching(const Pattern &rows, int columns)
        : rows_(rows), owner_(std::size_t(columns), -1), seen_(owner_) {}

    int size() {
        int matched = 0;
        for (std::size_t row = 0; row < rows_.size(); ++row) matched += augment(int(row), int(row));
        return matched;
    }

  private:
    bool augment(int row, int round) {
        for (const int column : rows_[std::size_t(row)]) {
            const auto at = std::size_t(column);
            if (seen_[at] == round) continue;
            seen_[at] = round;
            if (owner_[at] < 0 || augment(owner_[at], round)) {
                owner_[at] = row;
                return true;
            }
        }
        return false;
    }

    const Pattern &rows_;
    std::vector<int> owner_, seen_;
};

void append_shifted(Pattern &to, const Pattern &rows, int shift) {
    for (const auto &row : rows) {
        to.emplace_back();
        for (const int column : row) to.back().push_back(column + shift);
    }
}

} // namespace

LinearPattern pattern(const SensorModel &model, const Structure &structure, SensorSet set) {
    Pattern shared;
    for (const auto &links : structure.shared) shared.push_back(spelt_out(links, shared));
    LinearPattern system;
    for (const auto &links : structure.states) system.a.push_back(spelt_out(links, shared));
    for (std::size_t i = 0; i < model.sensors.size(); ++i) {
        if (!(set >> i & 1)) continue;
        auto seen = spelt_out(structure.sensors[i], shared);
        for (std::size_t lag = 0; lag < model.sensors[i].lags_s.size(); ++lag) {
            const int own = int(system.a.size());
            seen.push_back(own);
            system.a.push_back(seen);
            seen = {own};
        }
        system.c.push_back(seen);
    }
    return system;
}

int structural_rank(const Pattern &rows, int columns) { return Matching(rows, columns).size(); }

// Document 002, Theorem 1: block rows [.. I -A ..], then C below every block column; full column rank n^2.
bool observable_shields_pearson(const LinearPattern &system) {
    const int n = int(system.a.size());
    Pattern staircase;
    for (int block = 0; block + 1 < n; ++block) {
        append_shifted(staircase, system.a, (block + 1) * n);
        for (int i = 0; i < n; ++i) staircase[std::size_t(block * n + i)].push_back(block * n + i);
    }
    for (int block = 0; block < n; ++block) append_shifted(staircase, system.c, block * n);
    return structural_rank(staircase, n * n) == n * n;
}

// Every state reaches a sensor, and [A; C] has full structural rank (no dilation).
bool observable_lin(const LinearPattern &system) {
    std::vector<bool> reached(system.a.size(), false);
    std::vector<int> open;
    const auto reach = [&](const std::vector<int> &row) {
        for (const int state : row) {
            if (reached[std::size_t(state)]) continue;
            reached[std::size_t(state)] = true;
            open.push_back(state);
        }
    };
    for (const auto &row : system.c) reach(row);
    std::size_t count = 0;
    for (; !open.empty(); ++count) {
        const auto state = std::size_t(open.back());
        open.pop_back();
        reach(system.a[state]);
    }
    if (count != system.a.size()) return false;
    Pattern stacked = system.a;
    append_shifted(stacked, system.c, 0);
    return structural_rank(stacked, int(system.a.size())) == int(system.a.size());
}

} // namespace sixdeg
