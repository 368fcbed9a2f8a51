// SPDX-License-Identifier: MIT
// The rows of a text recording, one at a time: memory does not grow with the file.
#pragma once
#include <filesystem>
#include <istream>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/progress.hpp"
#include "io/recording/text_layout.hpp"

namespace sixdeg {

/// A cell that is neither a number nor blank, the first of its column.
struct BadCell {
    long line = 0; ///< From 1; 0: there is none.
    std::string text;
};

/// Reads forward only. Errors are InputErrors that name file, line and column.
class RowReader {
  public:
    /// Throws InputError where the file cannot be read or holds no row of numbers.
    explicit RowReader(const std::filesystem::path &path);
    /// The same of a text; `name` stands for the file in messages.
    RowReader(std::string name, std::string text);

    const std::string &name() const { return name_; }
    const TextLayout &layout() const { return layout_; }
    /// Of the columns only these are read from now on, the time apart; all that hold numbers otherwise.
    void read_only(const std::vector<int> &columns);

    /// Takes the next row. False at the end.
    bool next();
    /// Time of the row in the file's own unit, since time_origin().
    double time() const { return time_; }
    /// By column of the file; NaN where the cell is blank, no number, or not read.
    const std::vector<double> &values() const { return values_; }
    long line() const { return line_; }
    /// Where the file's times are counted from: 0, or the first row's time where that is negative or large.
    const Decimal &time_origin() const { return origin_; }
    /// One a column.
    const std::vector<BadCell> &bad_cells() const { return bad_; }

  private:
    void open(std::unique_ptr<std::istream> in);
    void recognise_coding();
    void append_wide(std::string_view bytes);
    void refuse_known_binaries() const;
    bool fill();
    bool take_line(std::string_view &line);
    bool take_row(std::string_view line);
    void take_time(const Decimal &time);
    void take_cell(std::size_t column, std::string_view cell);
    bool has_number(std::string_view line) const;
    [[noreturn]] void fail(const std::string &field, const std::string &problem) const;

    std::string name_;
    std::unique_ptr<std::istream> in_;
    std::unique_ptr<Progress> progress_; ///< Through a file.
    std::size_t read_ = 0;               ///< Bytes of the file so far.
    std::string buffer_;
    std::size_t at_ = 0; ///< Of the next line in the buffer.
    bool ended_ = false, cut_off_ = false;
    enum class Wide { no, little, big } wide_ = Wide::no; ///< UTF-16.
    bool bare_returns_ = false;                           ///< Lines end with a carriage return and no line feed.
    TextLayout layout_;
    std::vector<bool> wanted_;
    std::vector<double> values_;
    std::vector<BadCell> bad_;
    std::string joined_;
    long line_ = 0;
    bool has_time_ = false;
    Decimal origin_, last_;
    std::int64_t wrapped_ = 0; ///< Added to times, each time a 32-bit counter began anew.
    double time_ = 0;
};

} // namespace sixdeg
