// SPDX-License-Identifier: MIT
#include "io/recording/row_reader.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <limits>
#include <sstream>
#include <utility>

#include "common/error.hpp"
#include "common/nearest.hpp"

namespace sixdeg {
namespace {

constexpr std::size_t kChunk = std::size_t(1) << 20;
constexpr std::size_t kLayoutLines = 400;
constexpr std::size_t kHeadBytes = 64; // Within which a foreign format says what it is.
constexpr std::size_t kLongestLine = std::size_t(1) << 20; // Longer ones are no text.
// The capture timer counts from 0; a recording of some days keeps the times it has.
constexpr std::int64_t kOriginBeyond = 100000000;
constexpr std::int64_t kCounterRange = std::int64_t(1) << 32; // Of micros() and its like.

/// A binary file must not spill its bytes over the terminal.
std::string printable(std::string_view field) {
    std::string shown;
    for (char c : field.substr(0, 24)) shown += c >= ' ' && c <= '~' ? c : '?';
    return shown;
}

} // namespace

RowReader::RowReader(const std::filesystem::path &path) : name_(path.string()) {
    std::error_code ec;
    if (std::filesystem::is_directory(path, ec)) throw InputError(name_, "", "is a folder, not a file");
    auto in = std::make_unique<std::ifstream>(path, std::ios::binary);
    if (!*in) throw InputError(name_, "", "cannot be read" + nearest_file_hint(name_));
    const auto bytes = std::filesystem::file_size(path, ec); // a pipe has none
    progress_ = std::make_unique<Progress>("reading " + path.filename().string(), ec ? 0 : double(bytes), Progress::share);
    open(std::move(in));
}

RowReader::RowReader(std::string name, std::string text) : name_(std::move(name)) {
    open(std::make_unique<std::istringstream>(std::move(text)));
}

/// What people bring that is no text and has no converter here.
void RowReader::refuse_known_binaries() const {
    if (buffer_.compare(0, 1, "\x7F") == 0 && buffer_.substr(0, kHeadBytes).find("Data save") != std::string::npos)
        fail("", "is a .logicdata; tools/log/convert.py reads what rusEFI and FOME write, of Saleae's own Logic export the table as CSV");
    if (buffer_.find("$enddefinitions") != std::string::npos) fail("", "is a VCD; tools/log/convert.py makes a table of it");
    if (buffer_.compare(0, 4, "PK\x03\x04") == 0)
        fail("", "is an archive: a .sal of Saleae's Logic 2, or a spreadsheet; open it there, and export the table as CSV");
}

/// Byte order marks, UTF-16 as spreadsheets write it (with a mark or without), and lines that end with a carriage return alone.
void RowReader::recognise_coding() {
    const auto zero = [&](std::size_t i) { return buffer_.size() > i && buffer_[i] == 0; };
    if (buffer_.compare(0, 3, "\xEF\xBB\xBF") == 0) at_ = 3;
    const bool marked_little = buffer_.compare(0, 2, "\xFF\xFE") == 0, marked_big = buffer_.compare(0, 2, "\xFE\xFF") == 0;
    const bool little = marked_little || (!zero(0) && zero(1) && !zero(2) && zero(3));
    const bool big = marked_big || (zero(0) && !zero(1) && zero(2) && !zero(3));
    if (little || big) {
        wide_ = little ? Wide::little : Wide::big;
        const std::string bytes = std::exchange(buffer_, {});
        append_wide(std::string_view(bytes).substr(marked_little || marked_big ? 2 : 0));
    }
    bare_returns_ = buffer_.find('\n') == std::string::npos && buffer_.find('\r') != std::string::npos;
    if (bare_returns_) std::replace(buffer_.begin(), buffer_.end(), '\r', '\n');
}

/// Takes the characters of UTF-16 that are ASCII; the others are of no use here.
void RowReader::append_wide(std::string_view bytes) {
    const std::size_t high = wide_ == Wide::little ? 1 : 0;
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2) buffer_ += bytes[i + high] == 0 ? bytes[i + 1 - high] : '?';
}

void RowReader::open(std::unique_ptr<std::istream> in) {
    in_ = std::move(in);
    fill();
    recognise_coding();
    refuse_known_binaries();
    std::vector<std::string_view> lines;
    std::string_view text = std::string_view(buffer_).substr(at_);
    text = text.substr(0, text.find_last_not_of('\0') + 1); // a logger without power leaves the rest of a block empty
    for (std::size_t from = 0; from < text.size() && lines.size() < kLayoutLines;) {
        const auto end = text.find('\n', from);
        if (end == std::string_view::npos && (!ended_ || text.size() - from > kLongestLine)) break;
        lines.push_back(text.substr(from, end - from));
        from = end == std::string_view::npos ? text.size() : end + 1;
    }
    if (lines.size() > 1 && text.find('\0') != std::string_view::npos)
        fail("", "is no text; binary logs are converted first (docs/start/recordings.md)");
    layout_ = layout_of(name_, lines);
    wanted_ = layout_.is_number;
    values_.assign(wanted_.size(), std::numeric_limits<double>::quiet_NaN());
    bad_.resize(wanted_.size());
    std::string_view skipped;
    for (std::size_t i = 0; i < layout_.first_line; ++i) take_line(skipped);
}

void RowReader::read_only(const std::vector<int> &columns) {
    wanted_.assign(wanted_.size(), false);
    for (int column : columns) wanted_[std::size_t(column)] = true;
}

/// Adds to the buffer what the file has next. False at its end.
bool RowReader::fill() {
    if (ended_) return false;
    buffer_.erase(0, at_);
    at_ = 0;
    const std::size_t had = buffer_.size();
    if (wide_ == Wide::no) {
        buffer_.resize(had + kChunk);
        in_->read(buffer_.data() + had, std::streamsize(kChunk));
        buffer_.resize(had + std::size_t(in_->gcount()));
    } else {
        std::string chunk(kChunk, 0);
        in_->read(chunk.data(), std::streamsize(kChunk));
        chunk.resize(std::size_t(in_->gcount()));
        append_wide(chunk);
    }
    read_ += std::size_t(in_->gcount());
    if (progress_) progress_->at(double(read_));
    if (bare_returns_) std::replace(buffer_.begin() + std::ptrdiff_t(had), buffer_.end(), '\r', '\n');
    ended_ = !*in_;
    return true;
}

bool RowReader::take_line(std::string_view &line) {
    for (;;) {
        const char *const begin = buffer_.data() + at_;
        const std::size_t left = buffer_.size() - at_;
        const void *const end = left ? std::memchr(begin, '\n', left) : nullptr;
        if (end) {
            line = std::string_view(begin, std::size_t(static_cast<const char *>(end) - begin));
            at_ += line.size() + 1;
            ++line_;
            return true;
        }
        if (left > kLongestLine) fail(fmt::format("line {}", line_ + 1), "is longer than a million characters; this is no text");
        if (fill()) continue;
        line = std::string_view(buffer_).substr(at_);
        at_ = buffer_.size();
        cut_off_ = true; // no line end: the recorder may have been stopped within it
        if (left) ++line_;
        return left > 0;
    }
}

bool RowReader::next() {
    std::string_view line;
    while (take_line(line)) {
        line = trimmed(line);
        if (is_remark(line)) continue;
        if (take_row(line)) return true;
    }
    return false;
}

bool RowReader::has_number(std::string_view line) const {
    std::string joined;
    while (!line.empty())
        if (number_of(next_cell(line, layout_.style, joined), layout_.style.decimal)) return true;
    return false;
}

/// False for a line that is no row: a remark among the rows, or the last line where it was cut off.
bool RowReader::take_row(std::string_view line) {
    const std::string_view whole = line;
    const bool open_end = layout_.style.separator != ' ' && line.back() == layout_.style.separator;
    if (open_end) line.remove_suffix(1);
    const std::size_t columns = values_.size(), time_column = std::size_t(layout_.time_column);
    std::size_t column = 0;
    std::optional<Decimal> time;
    std::string bad_time;
    for (; !line.empty(); ++column) {
        const std::string_view cell = next_cell(line, layout_.style, joined_);
        if (column >= columns) continue;
        if (column != time_column) take_cell(column, cell);
        else if (!(time = decimal_of(cell, layout_.style.decimal))) bad_time = printable(cell);
    }
    // A last column may be blank in this row, or have been blank where the columns were counted.
    const bool fits = column == columns || (open_end && (column + 1 == columns || column == columns + 1));
    if (fits && time) return take_time(*time), true;
    if (cut_off_ || (!fits && !time) || !has_number(whole)) return false;
    if (!fits) {
        fail(fmt::format("line {}", line_),
             fmt::format("has {} columns, the rows above have {}; every row must have as many", column, columns));
    }
    fail(fmt::format("line {}, column {}", line_, time_column),
         fmt::format("'{}' is not a finite number such as 0.0125 or 1.25e-2", bad_time));
}

void RowReader::take_cell(std::size_t column, std::string_view cell) {
    if (!wanted_[column]) return;
    double &value = values_[column];
    if (const auto number = number_of(cell, layout_.style.decimal)) {
        value = *number;
        return;
    }
    value = std::numeric_limits<double>::quiet_NaN();
    if (bad_[column].line == 0 && !is_blank_cell(cell)) bad_[column] = {line_, printable(cell)};
}

void RowReader::take_time(const Decimal &time) {
    if (layout_.is_interval) {
        time_ += time.value();
        if (time.value() < 0)
            fail(fmt::format("line {}, column {}", line_, layout_.time_column), "is below 0; an interval between edges is not");
        return;
    }
    if (!has_time_ && (time.value() < 0 || time.whole > kOriginBeyond)) origin_ = time;
    const double before = time_;
    if (has_time_ && last_.whole - time.whole > kCounterRange / 2 && last_.whole < kCounterRange) wrapped_ += kCounterRange;
    time_ = double(time.whole - origin_.whole + wrapped_) + (time.fraction - origin_.fraction);
    if (has_time_ && time_ < before) {
        fail(fmt::format("line {}, column {}", line_, layout_.time_column),
             fmt::format("time {:.9g} is before the {:.9g} of the row above; time must not go back (a second recording in the file?)",
                         time.value(), last_.value()));
    }
    has_time_ = true;
    last_ = time;
}

void RowReader::fail(const std::string &field, const std::string &problem) const { throw InputError(name_, field, problem); }

} // namespace sixdeg
