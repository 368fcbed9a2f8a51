// SPDX-License-Identifier: MIT
// What the first lines of a recording tell of its form: separators, header, units, which column is the time.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "io/recording/text_fields.hpp"

namespace sixdeg {

struct TextLayout {
    FieldStyle style;
    std::size_t first_line = 0;       ///< Index of the first row among the lines given.
    std::vector<std::string> names;   ///< One a column, as in the header; empty texts without one.
    std::vector<bool> is_number;      ///< One a column: nearly all of its cells are numbers.
    int time_column = 0;
    double time_unit_s = 0;           ///< As the header says; 0 where it says nothing.
    bool counts_time = false;         ///< The time column counts rows or ticks, and nothing says how long one takes.
    bool is_interval = false;         ///< The time column holds the time since the row above.
    bool counts_teeth = false;        ///< Another column counts rows or teeth, and is no signal.
    std::vector<bool> is_counter;     ///< One a column.

    bool is_signal(std::size_t column) const { return int(column) != time_column && is_number[column] && !is_counter[column]; }
};

/// Lines that hold nothing: blank, or a comment (#, %, //, ;;).
bool is_remark(std::string_view line);

/// Reads the form off the first lines of a file (some hundred; the last one complete). Throws InputError naming `name` when no line
/// holds numbers.
TextLayout layout_of(const std::string &name, const std::vector<std::string_view> &lines);

/// The number in the next column of a row, or nothing; takes two fields where commas split a number.
std::string_view next_cell(std::string_view &rest, const FieldStyle &style, std::string &joined);

} // namespace sixdeg
