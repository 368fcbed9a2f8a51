// SPDX-License-Identifier: MIT
// Figures of many engines: collected by row of a table, with intervals.
#pragma once
#include <string>
#include <vector>

#include "studies/misfire/misfire_set.hpp"

namespace sixdeg {

/// What a figure should be. `low` 0: only its size counts.
struct FigureGoal {
    double low = 0, high = 0;
};

/// One figure of all engines at one operating point.
struct FigureRow {
    std::string what, at, unit;
    FigureGoal goal;
    struct Value {
        SetEngine engine;
        double value;
    };
    std::vector<Value> values;
};

/// Rms over engines of one physics, with a 95 % interval by drawing engines again (percentiles of 4000 draws, always the same).
struct FigureRms {
    int engines = 0, met = 0; ///< How many there are; of these, how many meet the goal by themselves.
    double rms = 0, low = 0, high = 0;
    double largest = 0; ///< The value of largest size, with its sign.
};
FigureRms rms_of(const FigureRow &row, Physics physics);

/// Rows in the order in which they were first met.
class EngineFigures {
  public:
    void add(const SetEngine &engine, const std::string &what, const std::string &at, const std::string &unit, FigureGoal goal,
             double value);
    const std::vector<FigureRow> &rows() const { return rows_; }
    /// A table of both physics, in Markdown.
    std::string table() const;
    std::string csv() const;

  private:
    std::vector<FigureRow> rows_;
};

} // namespace sixdeg
