// SPDX-License-Identifier: MIT
#include "io/recording/text_layout.hpp"

#include <algorithm>
#include <cmath>

#include "common/error.hpp"
#include "io/recording/header_words.hpp"

namespace sixdeg {
namespace {

constexpr FieldStyle kStyles[] = {{';', '.', false}, {';', ',', false}, {'\t', '.', false}, {'\t', ',', false}, {',', '.', false},
                                  {'|', '.', false}, {' ', '.', false}, {' ', ',', false}};
constexpr double kMostRows = 0.9;

/// The cells of a line; texts stay texts.
std::vector<std::string> cells_of(std::string_view line, const FieldStyle &style) {
    std::vector<std::string> cells;
    std::string joined;
    line = trimmed(line);
    if (!line.empty() && style.separator != ' ' && line.back() == style.separator) line.remove_suffix(1);
    while (!line.empty()) cells.emplace_back(next_cell(line, style, joined));
    return cells;
}

/// A row: it has a number, and every other cell is one, blank, or a short word beside at least as many numbers.
bool is_row(const std::vector<std::string> &cells, char decimal) {
    std::size_t numbers = 0, words = 0;
    for (const std::string &cell : cells) {
        if (number_of(cell, decimal)) ++numbers;
        else if (!is_blank_cell(cell)) ++words;
    }
    return numbers > 0 && words <= numbers / 2;
}

using Table = std::vector<std::vector<std::string>>;

Table table_of(const std::vector<std::string_view> &lines, const FieldStyle &style) {
    Table table;
    for (std::string_view line : lines) table.push_back(is_remark(line) ? std::vector<std::string>{} : cells_of(line, style));
    return table;
}

std::size_t count_rows(const Table &table, char decimal) {
    return std::size_t(std::count_if(table.begin(), table.end(), [&](const auto &cells) { return is_row(cells, decimal); }));
}

/// Commas in two roles: every second column holds digits alone, always as many, some with a leading zero: those are fractions.
bool commas_split_numbers(const Table &table, std::size_t columns) {
    if (columns < 2 || columns % 2) return false;
    bool leading_zero = false;
    std::vector<std::size_t> width(columns, 0);
    for (const auto &cells : table) {
        if (cells.size() != columns) continue;
        for (std::size_t j = 1; j < columns; j += 2) {
            const std::string &cell = cells[j];
            if (cell.empty() || !std::all_of(cell.begin(), cell.end(), [](char c) { return c >= '0' && c <= '9'; })) return false;
            if (width[j] && width[j] != cell.size()) return false;
            width[j] = cell.size();
            leading_zero |= cell.size() > 1 && cell.front() == '0';
        }
        for (std::size_t j = 0; j < columns; j += 2)
            if (cells[j].find('.') != std::string::npos) return false;
    }
    return leading_zero;
}

/// Cells by column over the rows, numbers only.
std::vector<double> column_of(const Table &table, std::size_t first, std::size_t column, char decimal) {
    std::vector<double> values;
    for (std::size_t i = first; i < table.size(); ++i) {
        if (column >= table[i].size()) continue;
        if (const auto value = number_of(table[i][column], decimal)) values.push_back(*value);
    }
    return values;
}

bool is_rising(const std::vector<double> &values) {
    if (values.size() < 2) return false;
    for (std::size_t i = 1; i < values.size(); ++i)
        if (values[i] < values[i - 1]) return false;
    return values.back() > values.front();
}

/// Whole numbers that go up by one from row to row, back to the beginning now and then.
bool is_count(const std::vector<double> &values) {
    if (values.size() < 4) return false;
    std::size_t up = 0;
    for (std::size_t i = 1; i < values.size(); ++i) {
        if (values[i] != std::floor(values[i])) return false;
        up += values[i] == values[i - 1] + 1;
    }
    return double(up) >= kMostRows * double(values.size() - 1);
}

class Finder {
  public:
    Finder(const std::string &name, const std::vector<std::string_view> &lines) : name_(name), lines_(lines) {}

    TextLayout find() {
        choose_style();
        count_columns();
        find_rows();
        read_header();
        judge_columns();
        choose_time();
        return std::move(layout_);
    }

  private:
    char decimal() const { return layout_.style.decimal; }

    void choose_style() {
        std::size_t most = 0, widest = 0;
        for (const FieldStyle &style : kStyles) {
            Table table = table_of(lines_, style);
            const std::size_t rows = count_rows(table, style.decimal);
            std::size_t width = 0;
            for (const auto &cells : table) width = std::max(width, is_row(cells, style.decimal) ? cells.size() : 0);
            // Of two that read as many rows the earlier one, unless the later tells more columns apart.
            if (rows == 0 || rows < most || (rows == most && width <= widest)) continue;
            most = rows, widest = width;
            table_ = std::move(table);
            layout_.style = style;
        }
        if (most == 0) throw_empty();
    }

    [[noreturn]] void throw_empty() const {
        bool header = false;
        for (std::string_view line : lines_) header |= !is_remark(line);
        throw InputError(name_, "", std::string(header ? "holds no rows of numbers" : "is empty") +
                                        "; rows of time in s and, after it, levels or voltages are wanted");
    }

    void count_columns() {
        std::vector<std::size_t> widths;
        for (const auto &cells : table_)
            if (is_row(cells, decimal())) widths.push_back(cells.size());
        std::vector<std::size_t> sorted = widths;
        std::sort(sorted.begin(), sorted.end());
        columns_ = sorted[sorted.size() / 2];
        if (sorted.back() == columns_ + 1 && ends_open()) ++columns_; // the last column is blank in most rows
        if (layout_.style == FieldStyle{',', '.', false} && commas_split_numbers(rows_only(), columns_)) split(columns_);
        else if (layout_.style == FieldStyle{',', '.', false} && columns_ > 2 && columns_ % 2 == 1 && first_is_split()) first_split();
    }

    /// Whether rows end with a separator, behind which a cell may be blank.
    bool ends_open() const {
        const char separator = layout_.style.separator;
        std::size_t open = 0;
        for (std::string_view line : lines_) open += !trimmed(line).empty() && trimmed(line).back() == separator;
        return separator != ' ' && open > 0;
    }

    /// A row of all columns, or of all but a last one that is blank.
    bool is_full(std::size_t i) const {
        return table_[i].size() == columns_ || (table_[i].size() + 1 == columns_ && trimmed(lines_[i]).back() == layout_.style.separator);
    }

    Table rows_only() const {
        Table rows;
        for (const auto &cells : table_)
            if (is_row(cells, decimal())) rows.push_back(cells);
        return rows;
    }

    void split(std::size_t columns) {
        layout_.style.split_fraction = true;
        table_ = table_of(lines_, layout_.style);
        columns_ = columns / 2;
    }

    /// "0,0003333,1": the time has a fraction, the level has none.
    bool first_is_split() const {
        Table firsts;
        for (const auto &cells : rows_only())
            if (cells.size() >= 2) firsts.push_back({cells[0], cells[1]});
        return commas_split_numbers(firsts, 2);
    }

    void first_split() {
        layout_.style.decimal = ',';
        table_ = table_of(lines_, layout_.style);
        columns_ -= 1;
    }

    void find_rows() {
        std::size_t first = 0;
        while (first < table_.size() && !(is_row(table_[first], decimal()) && (table_.size() < 3 || is_full(first)))) ++first;
        if (first == table_.size())
            first = std::size_t(std::find_if(table_.begin(), table_.end(), [&](const auto &c) { return is_row(c, decimal()); }) -
                                table_.begin());
        layout_.first_line = first;
    }

    /// The last line above the rows that names columns, and one of units below it if there is one.
    void read_header() {
        layout_.names.assign(columns_, "");
        std::vector<std::vector<std::string>> header;
        for (std::size_t i = 0; i < layout_.first_line; ++i) {
            if (is_remark(lines_[i])) continue;
            header.push_back(header_cells(lines_[i]));
        }
        if (header.empty()) return;
        units_ = header.back();
        names_ = header.back();
        const bool has_unit_row = header.size() > 1 && header[header.size() - 2].size() == names_.size() && looks_like_units(units_);
        if (has_unit_row) names_ = header[header.size() - 2];
        for (std::size_t j = 0; j < std::min(names_.size(), columns_); ++j) layout_.names[j] = names_[j];
        // Some oscilloscopes number their rows and say in the header how far apart they are.
        for (std::size_t j = 0; j < std::min(names_.size(), units_.size()); ++j)
            if (lower(names_[j]) == "increment") increment_s_ = number_of(units_[j], decimal()).value_or(0);
    }

    /// A header may be set with other separators than the rows.
    std::vector<std::string> header_cells(std::string_view line) const {
        FieldStyle style = layout_.style;
        style.split_fraction = false;
        auto cells = cells_of(line, style);
        for (char other : {'\t', ';', ',', ' '}) {
            if (cells.size() == columns_) break;
            const auto others = cells_of(line, {other, '.', false});
            if (others.size() == columns_) cells = others;
        }
        return cells;
    }

    void judge_columns() {
        std::size_t rows = 0;
        for (std::size_t i = layout_.first_line; i < table_.size(); ++i) rows += is_row(table_[i], decimal());
        for (std::size_t j = 0; j < columns_; ++j) {
            values_.push_back(column_of(table_, layout_.first_line, j, decimal()));
            layout_.is_number.push_back(double(values_[j].size()) >= 0.5 * double(rows));
            layout_.is_counter.push_back(layout_.is_number[j] && is_count(values_[j]));
        }
    }

    void choose_time() {
        int chosen = -1, named = -1, counter = -1;
        for (int j = 0; j < int(columns_); ++j) {
            if (!layout_.is_number[std::size_t(j)]) continue;
            if (named < 0 && is_time_name(layout_.names[std::size_t(j)]) && !is_interval_name(layout_.names[std::size_t(j)])) named = j;
            if (layout_.is_counter[std::size_t(j)] && counter < 0) counter = j;
            else if (chosen < 0 && is_rising(values_[std::size_t(j)])) chosen = j;
        }
        if (named >= 0) chosen = named;
        if (chosen < 0 && named_interval() >= 0) chosen = named_interval(), layout_.is_interval = true;
        if (chosen < 0)
            chosen = counter >= 0 && count_numbers() > 1 && only_counter_is_tooth(counter) ? other_than(counter) : first_number();
        layout_.time_column = chosen;
        layout_.is_counter[std::size_t(chosen)] = false;
        const bool alone = count_numbers() == 1 || (count_numbers() == 2 && counter >= 0 && chosen != counter);
        if (!layout_.is_interval && alone && named < 0 && is_interval_list(values_[std::size_t(chosen)])) layout_.is_interval = true;
        if (!layout_.is_interval && named < 0 && has_two_values(values_[std::size_t(chosen)]))
            throw InputError(name_, "", "has no column of times, levels alone; a time in every row is wanted");
        layout_.counts_teeth = std::find(layout_.is_counter.begin(), layout_.is_counter.end(), true) != layout_.is_counter.end();
        const auto at = std::size_t(chosen);
        if (at < units_.size()) layout_.time_unit_s = time_unit_of(units_[at]);
        if (layout_.time_unit_s == 0 && at < names_.size()) layout_.time_unit_s = time_unit_of(names_[at]);
        if (increment_s_ > 0 && is_count(values_[at])) layout_.time_unit_s = increment_s_;
        layout_.counts_time = layout_.time_unit_s == 0 && (is_count(values_[at]) || is_count_name(layout_.names[at]));
    }

    int named_interval() const {
        for (int j = 0; j < int(columns_); ++j)
            if (layout_.is_number[std::size_t(j)] && is_interval_name(layout_.names[std::size_t(j)])) return j;
        return -1;
    }

    /// One column that goes up and down, all of it above zero: the time from each edge to the next.
    static bool is_interval_list(const std::vector<double> &values) {
        if (values.size() < 8) return false;
        std::size_t down = 0;
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (values[i] < 0) return false;
            down += i > 0 && values[i] < values[i - 1];
        }
        return down > values.size() / 50 + 2;
    }

    static bool has_two_values(const std::vector<double> &values) {
        if (values.size() < 8 || is_rising(values)) return false;
        const auto other = std::find_if(values.begin(), values.end(), [&](double v) { return v != values[0]; });
        return std::all_of(values.begin(), values.end(), [&](double v) { return v == values[0] || v == *other; });
    }

    /// It goes back to its beginning, so it counts the teeth of a revolution; one that never does may be the time.
    bool only_counter_is_tooth(int counter) const { return !is_rising(values_[std::size_t(counter)]); }
    int other_than(int column) const {
        for (int j = 0; j < int(columns_); ++j)
            if (j != column && layout_.is_number[std::size_t(j)]) return j;
        return column;
    }
    int first_number() const {
        const auto first = std::find(layout_.is_number.begin(), layout_.is_number.end(), true);
        return first == layout_.is_number.end() ? 0 : int(first - layout_.is_number.begin());
    }
    int count_numbers() const { return int(std::count(layout_.is_number.begin(), layout_.is_number.end(), true)); }

    const std::string &name_;
    const std::vector<std::string_view> &lines_;
    TextLayout layout_;
    Table table_;
    std::size_t columns_ = 0;
    double increment_s_ = 0;
    std::vector<std::string> names_, units_;
    std::vector<std::vector<double>> values_;
};

} // namespace

bool is_remark(std::string_view line) {
    line = trimmed(line);
    if (line.empty() || line[0] == '#' || line[0] == '%') return true;
    return line.substr(0, 2) == "//" || line.substr(0, 2) == ";;" || line.substr(0, 2) == "\"#";
}

std::string_view next_cell(std::string_view &rest, const FieldStyle &style, std::string &joined) {
    const std::string_view field = next_field(rest, style);
    // "0,0003333,1" with a decimal comma: a comma and digits behind whole digits are its fraction.
    const bool may_split = style.split_fraction || (style.separator == ',' && style.decimal == ',');
    if (!may_split || rest.empty() || field.empty()) return field;
    const auto end = rest.find(',');
    const std::string_view fraction = trimmed(rest.substr(0, end));
    if (!style.split_fraction && fraction.size() < 2) return field;
    if (fraction.empty() || fraction.find_first_not_of("0123456789") != std::string_view::npos) return field;
    joined.assign(field);
    joined += style.decimal;
    joined += fraction;
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
    return joined;
}

TextLayout layout_of(const std::string &name, const std::vector<std::string_view> &lines) { return Finder(name, lines).find(); }

} // namespace sixdeg
