// SPDX-License-Identifier: MIT
#include "io/recording/recording.hpp"

#include <cmath>
#include <fmt/format.h>
#include <limits>

#include "common/error.hpp"

namespace sixdeg {
namespace {

constexpr std::size_t kEverything = std::numeric_limits<std::size_t>::max();

Recording whole(RowReader reader) { return read_stretch(reader, kEverything); }

} // namespace

bool Recording::is_edge_times() const {
    for (std::size_t j = 0; j < columns.size(); ++j)
        if (layout.is_signal(j)) return false;
    return true;
}

Recording read_stretch(RowReader &reader, std::size_t cells) {
    Recording stretch;
    stretch.path = reader.name();
    stretch.layout = reader.layout();
    stretch.columns.resize(stretch.layout.names.size());
    stretch.is_whole = cells == kEverything;
    std::vector<std::size_t> signals;
    for (std::size_t j = 0; j < stretch.columns.size(); ++j)
        if (stretch.layout.is_signal(j)) signals.push_back(j);
    const std::size_t most = cells == kEverything ? kEverything : cells / (signals.size() + 1);
    while (stretch.rows() < most && reader.next()) {
        stretch.time.push_back(reader.time());
        for (std::size_t j : signals) {
            const double value = reader.values()[j];
            auto &column = stretch.columns[j];
            column.push_back(std::isnan(value) ? column.empty() ? 0 : column.back() : value);
        }
    }
    stretch.origin = reader.time_origin();
    stretch.bad_cells = reader.bad_cells();
    for (std::size_t j : signals)
        if (stretch.bad_cells[j].line) std::vector<double>().swap(stretch.columns[j]);
    if (stretch.rows() > 0 || !stretch.is_whole) return stretch;
    throw InputError(stretch.path, "", "is empty; rows of time in s and, after it, levels or voltages are wanted");
}

Recording parse_recording(const std::string &name, std::string text) { return whole(RowReader(name, std::move(text))); }

Recording read_recording(const std::filesystem::path &path) { return whole(RowReader(path)); }

std::string column_label(const Recording &recording, int column) {
    const std::string &name = recording.layout.names[std::size_t(column)];
    return fmt::format("column {}{}", column, name.empty() ? "" : " (" + name + ")");
}

ColumnKind column_kind(const Recording &recording, int column) {
    const int last = recording.last_column(), time = recording.layout.time_column;
    if (recording.is_edge_times() && column == time) return ColumnKind::edge_times;
    if (column < 0 || column > last || column == time) {
        throw InputError(recording.path, fmt::format("column {}", column),
                         recording.is_edge_times()
                             ? fmt::format("is not a signal: column {} holds the edge times, and there is no other", time)
                             : fmt::format("is not a signal; columns are 0 to {}, and column {} is the time", last, time));
    }
    const BadCell &bad = recording.bad_cells[std::size_t(column)];
    if (bad.line)
        throw InputError(recording.path, fmt::format("line {}, column {}", bad.line, column),
                         fmt::format("'{}' is not a finite number such as 0.0125 or 1.25e-2", bad.text));
    const std::vector<double> &values = recording.columns[std::size_t(column)];
    if (values.empty()) return ColumnKind::unusable;
    const double first = values.front();
    double second = first;
    for (double value : values) {
        if (value == first || value == second) continue;
        if (second != first) return ColumnKind::sampled;
        second = value;
    }
    return second == first ? ColumnKind::constant : ColumnKind::level;
}

} // namespace sixdeg
