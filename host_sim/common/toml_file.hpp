// SPDX-License-Identifier: MIT
// A TOML file read field by field, each with its unit and range; what nobody asked for is an error too.
#pragma once
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <toml++/toml.h>
#include <vector>

namespace sixdeg {

/// Admissible values of a number, ends included, and its unit ("" for none), for the message.
struct Range {
    double low, high;
    const char *unit;
};

/// Fields are named by dotted path ("crank.inertia_kgm2"). Every getter throws InputError with file, field and
/// allowed range. Call finish() last: it rejects every field that no getter asked for.
class TomlFile {
  public:
    explicit TomlFile(const std::filesystem::path &path);
    TomlFile(std::string name, std::string_view text);

    bool has(const std::string &field) const;
    double number(const std::string &field, Range range);
    double number_or(const std::string &field, Range range, double otherwise);
    long integer(const std::string &field, long low, long high);
    long integer_or(const std::string &field, long low, long high, long otherwise);
    std::string text(const std::string &field);
    std::string text_or(const std::string &field, const std::string &otherwise);
    bool boolean_or(const std::string &field, bool otherwise);
    /// An array of numbers, each in `range`; `size` 0 accepts any length.
    std::vector<double> numbers(const std::string &field, Range range, std::size_t size = 0);
    std::vector<std::string> texts(const std::string &field);
    /// Names of the tables in an array of tables or of the keys of a table, in file order.
    std::vector<std::string> keys(const std::string &field);
    std::size_t array_size(const std::string &field);

    /// Sets one field from "key=value" text (value in TOML syntax) before it is read; --set of the commands.
    void set(const std::string &assignment);
    /// Leaves a whole table to another reader: finish() says nothing of the fields below it.
    void ignore(const std::string &table) { ignored_.insert(table + "."); }
    /// Throws when the file holds a field that no getter has asked for, and names the known field that is nearest to it.
    void finish() const;
    [[noreturn]] void fail(const std::string &field, const std::string &problem) const;

    const std::string &name() const { return name_; }
    const std::string &content() const { return content_; }

  private:
    /// Fields of the file that no getter has asked for, tables of other readers left out.
    std::vector<std::string> unasked() const;
    [[noreturn]] void fail_missing(const std::string &field, const std::string &wanted) const;
    toml::node_view<const toml::node> find(const std::string &field);
    std::string name_, content_;
    toml::table table_;
    std::set<std::string> asked_, ignored_;
    mutable std::set<std::string> named_; ///< Every field that a reader knows, there or not: one of them was meant by a misspelt one.
};

/// "[0, 10] kg m2", for messages.
std::string describe(Range range);

} // namespace sixdeg
