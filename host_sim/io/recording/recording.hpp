// SPDX-License-Identifier: MIT
// A stretch of a recording of crank (and cam) signals, in memory. Formats: docs/start/recordings.md.
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "io/recording/row_reader.hpp"

namespace sixdeg {

/// What the values of one column are, as told by the values themselves.
enum class ColumnKind {
    edge_times, ///< The time of a file without signals: each row is one edge.
    constant,   ///< One value throughout, or none: no edges.
    level,      ///< Exactly two values: a logic signal; it changes at the row's time.
    sampled,    ///< More values: a voltage, which crosses a threshold between rows.
    unusable,   ///< The time itself, a count of rows, or texts.
};

/// Rows of a file, from its first or from a later one. Columns are counted from 0 as in the file, the time among them.
struct Recording {
    std::string path;
    TextLayout layout;
    std::vector<double> time;                 ///< In the file's unit, never falling; see RowReader::time_origin.
    Decimal origin;                           ///< What that time is counted from.
    std::vector<std::vector<double>> columns; ///< By column of the file; empty where it is unusable. A blank cell holds the value above.
    std::vector<BadCell> bad_cells;
    bool is_whole = true;                     ///< No rows before or after.

    std::size_t rows() const { return time.size(); }
    bool is_edge_times() const;
    int last_column() const { return int(columns.size()) - 1; }
};

/// The whole file. Throws InputError naming file, line and column (and what is allowed) for a file without rows, a time that is no
/// number or goes back, a row longer or shorter than the others.
Recording read_recording(const std::filesystem::path &path);
/// The same from text already in memory; `name` stands for the file in messages.
Recording parse_recording(const std::string &name, std::string text);

/// The next rows, at most so many cells of them. Empty at the end of the file.
Recording read_stretch(RowReader &reader, std::size_t cells);

/// Throws InputError when the recording has no such column.
ColumnKind column_kind(const Recording &recording, int column);
/// "column 1 (Channel 0)", for messages.
std::string column_label(const Recording &recording, int column);

} // namespace sixdeg
