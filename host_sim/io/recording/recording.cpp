// SPDX-License-Identifier: MIT
#include "io/recording/recording.hpp"

#include <charconv>
#include <cmath>
#include <fmt/format.h>

#include "common/error.hpp"
#include "common/files.hpp"

namespace sixdeg {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(kBlanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

/// The separator of a line: the first of ; tab , that it holds, else any run of blanks (' ').
char separator_of(std::string_view line) {
    for (char candidate : {';', '\t', ','}) {
        if (line.find(candidate) != std::string_view::npos) return candidate;
    }
    return ' ';
}

/// Takes the next field off the front of `rest`.
std::string_view next_field(std::string_view &rest, char separator) {
    const auto end = separator == ' ' ? rest.find_first_of(kBlanks) : rest.find(separator);
    const std::string_view field = trimmed(rest.substr(0, end));
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
    if (separator == ' ') rest = trimmed(rest);
    return field;
}

bool parse_number(std::string_view field, double &value) {
    // from_chars knows no plus sign.
    if (field.size() > 1 && field[0] == '+' && field[1] != '-') field.remove_prefix(1);
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    return error == std::errc{} && end == field.data() + field.size() && std::isfinite(value);
}

class Reader {
  public:
    explicit Reader(const std::string &name) { recording_.path = name; }

    void line(std::string_view text) {
        ++line_;
        if (line_ == 1 && text.substr(0, kByteOrderMark.size()) == kByteOrderMark) {
            text.remove_prefix(kByteOrderMark.size());
        }
        text = trimmed(text);
        if (text.empty() || text[0] == '#') return;
        if (!separator_) separator_ = separator_of(text);
        // Some loggers end every line with a separator.
        if (separator_ != ' ' && text.back() == separator_) text.remove_suffix(1);
        if (recording_.columns.empty() && !header_seen_ && is_header(text)) return header(text);
        row(text);
    }

    Recording take() {
        if (recording_.columns.empty()) {
            throw InputError(recording_.path, "",
                             std::string(header_seen_ ? "holds a header and no rows" : "is empty") +
                                 "; rows of time in s and, after it, levels or voltages are wanted");
        }
        recording_.column_names.resize(recording_.columns.size());
        return std::move(recording_);
    }

  private:
    bool is_header(std::string_view text) const {
        double value = 0;
        const std::string_view first = next_field(text, separator_);
        return !first.empty() && !parse_number(first, value) && !is_non_finite(first);
    }

    /// "nan" in the first row is a bad number, not a name.
    static bool is_non_finite(std::string_view field) {
        double value = 0;
        const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
        return error == std::errc{} && end == field.data() + field.size();
    }

    void header(std::string_view text) {
        header_seen_ = true;
        while (!text.empty()) recording_.column_names.emplace_back(next_field(text, separator_));
        // "time level" over rows with commas: the rows decide.
        separator_ = 0;
    }

    void row(std::string_view text) {
        auto &columns = recording_.columns;
        const bool first_row = columns.empty();
        std::size_t column = 0;
        for (; !text.empty(); ++column) {
            const std::string_view field = next_field(text, separator_);
            double value = 0;
            if (!parse_number(field, value)) fail_number(column, field);
            if (first_row) columns.emplace_back();
            if (column < columns.size()) columns[column].push_back(value);
        }
        if (column != columns.size()) {
            fail(fmt::format("line {}", line_),
                 fmt::format("has {} columns, the first row has {}; every row must have as many", column,
                             columns.size()));
        }
        check_time(columns.front());
    }

    void check_time(const std::vector<double> &time_s) const {
        const std::size_t n = time_s.size();
        if (n < 2 || time_s[n - 1] >= time_s[n - 2]) return;
        fail(fmt::format("line {}, column 0", line_),
             fmt::format("time {:.9g} s is before the {:.9g} s of the row above; time must not go back",
                         time_s[n - 1], time_s[n - 2]));
    }

    [[noreturn]] void fail_number(std::size_t column, std::string_view field) const {
        // A binary file must not spill its bytes over the terminal.
        std::string shown;
        for (char c : field.substr(0, 24)) shown += c >= ' ' && c <= '~' ? c : '?';
        fail(fmt::format("line {}, column {}", line_, column),
             fmt::format("'{}' is not a finite number such as 0.0125 or 1.25e-2", shown));
    }

    [[noreturn]] void fail(const std::string &field, const std::string &problem) const {
        throw InputError(recording_.path, field, problem);
    }

    Recording recording_;
    long line_ = 0;
    char separator_ = 0;
    bool header_seen_ = false;
};

} // namespace

Recording parse_recording(const std::string &name, std::string_view text) {
    Reader reader(name);
    while (!text.empty()) {
        const auto end = text.find('\n');
        reader.line(text.substr(0, end));
        text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
    }
    return reader.take();
}

Recording read_recording(const std::filesystem::path &path) {
    return parse_recording(path.string(), read_file(path));
}

std::string column_label(const Recording &recording, int column) {
    const std::string &name = recording.column_names[std::size_t(column)];
    return fmt::format("column {}{}", column, name.empty() ? "" : " (" + name + ")");
}

ColumnKind column_kind(const Recording &recording, int column) {
    const int last = int(recording.columns.size()) - 1;
    if (recording.is_edge_times() && column == 0) return ColumnKind::edge_times;
    if (column < 1 || column > last) {
        throw InputError(
            recording.path, fmt::format("column {}", column),
            last == 0 ? "is not there: the only column, 0, holds the edge times"
                      : fmt::format("is not a signal; column 0 is the time, signals are 1 to {}", last));
    }
    const std::vector<double> &values = recording.columns[std::size_t(column)];
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
