// SPDX-License-Identifier: MIT
// A recording of crank (and cam) signals: rows of time and values, read from text. Formats:
// docs/recordings.md.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace sixdeg {

/// What the values of one column are, as told by the values themselves.
enum class ColumnKind {
    edge_times, ///< Column 0 of a file with no other column: each time is one edge.
    constant,   ///< One value throughout: no edges.
    level,      ///< Exactly two values: a logic signal; it changes at the row's time.
    sampled,    ///< More values: a voltage, which crosses a threshold between rows.
};

/// Columns are counted from 0, and column 0 is the time, so the first signal is column 1.
struct Recording {
    std::string path;
    std::vector<std::string> column_names;    ///< One a column; empty texts where the file has no header.
    std::vector<std::vector<double>> columns; ///< Equally long. [0] is the time in seconds, never falling.

    const std::vector<double> &time_s() const { return columns.front(); }
    std::size_t rows() const { return columns.front().size(); }
    bool is_edge_times() const { return columns.size() == 1; }
};

/// Reads a recording. Throws InputError naming file, line and column (and what is allowed) for a file that is
/// empty, a value that is not a finite number, a row longer or shorter than the first, a time that goes back.
Recording read_recording(const std::filesystem::path &path);
/// The same from text already in memory; `name` stands for the file in messages.
Recording parse_recording(const std::string &name, std::string_view text);

/// Throws InputError when the recording has no such column.
ColumnKind column_kind(const Recording &recording, int column);
/// "column 1 (Channel 0)", for messages.
std::string column_label(const Recording &recording, int column);

} // namespace sixdeg
