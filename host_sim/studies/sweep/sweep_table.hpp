// SPDX-License-Identifier: MIT
// What a sweep leaves: one table with a row a cell, and a picture over speed and load.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "studies/sweep/grid.hpp"

namespace sixdeg {

/// One cell: its summary.json, or why there is none.
struct SweepCell {
    std::vector<std::string> settings; ///< "field=value", as cells_of() makes them.
    std::string summary;               ///< JSON text; empty when the run failed.
    std::string error;                 ///< One line; empty when it did not.
};

/// sweep.csv: the axes, then every figure of the summaries by its dotted name, then `error`.
std::string sweep_csv(const std::vector<Axis> &axes, const std::vector<SweepCell> &cells);

/// What is wrong with the name of a figure: no cell has it, and one has a name that is near. "" otherwise: short runs lack some figures.
std::string figure_fault(const std::vector<SweepCell> &cells, const std::string &figure);

/// A map of one figure over speed.rpm and load.bmep_bar, as SVG; other axes stand at their first value. Nothing when
/// these are not two of the axes, or no cell has that figure.
std::optional<std::string> sweep_picture(const std::vector<Axis> &axes, const std::vector<SweepCell> &cells,
                                         const std::string &figure);

} // namespace sixdeg
