// SPDX-License-Identifier: MIT
#include "common/toml_file.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "common/error.hpp"
#include "common/files.hpp"
#include "common/nearest.hpp"

namespace sixdeg {
namespace {

toml::table parse(const std::string &name, std::string_view text) {
    try {
        return toml::parse(text, name);
    } catch (const toml::parse_error &error) {
        throw InputError(name, fmt::format("line {}", error.source().begin.line), std::string(error.description()));
    }
}

// Dotted path of every leaf; an element of an array of tables is "name[0]".
void collect_leaves(const toml::node &node, const std::string &path, std::vector<std::string> &leaves) {
    if (const auto *table = node.as_table()) {
        for (const auto &[key, child] : *table) {
            collect_leaves(child, path.empty() ? std::string(key.str()) : path + "." + std::string(key.str()), leaves);
        }
    } else if (const auto *array = node.as_array(); array && !array->empty() && array->is_array_of_tables()) {
        for (std::size_t i = 0; i < array->size(); ++i) {
            collect_leaves((*array)[i], fmt::format("{}[{}]", path, i), leaves);
        }
    } else {
        leaves.push_back(path);
    }
}

} // namespace

std::string describe(Range range) {
    return fmt::format("[{:g}, {:g}]{}{}", range.low, range.high, *range.unit ? " " : "", range.unit);
}

TomlFile::TomlFile(const std::filesystem::path &path) : TomlFile(path.string(), read_file(path)) {}

TomlFile::TomlFile(std::string name, std::string_view text)
    : name_(std::move(name)), content_(text), table_(parse(name_, content_)) {}

void TomlFile::fail(const std::string &field, const std::string &problem) const {
    throw InputError(name_, field, problem);
}

toml::node_view<const toml::node> TomlFile::find(const std::string &field) {
    asked_.insert(field);
    named_.insert(field);
    return std::as_const(table_).at_path(field);
}

bool TomlFile::has(const std::string &field) const {
    named_.insert(field);
    return bool(std::as_const(table_).at_path(field));
}

double TomlFile::number(const std::string &field, Range range) {
    const auto node = find(field);
    if (!node) fail_missing(field, "allowed range " + describe(range));
    const auto value = node.value<double>();
    if (!node.is_number() || !value) fail(field, "is not a number; allowed range " + describe(range));
    // Written so that NaN fails too.
    if (!(*value >= range.low && *value <= range.high)) {
        fail(field, fmt::format("{:g} is outside {}", *value, describe(range)));
    }
    return *value;
}

double TomlFile::number_or(const std::string &field, Range range, double otherwise) {
    return has(field) ? number(field, range) : otherwise;
}

long TomlFile::integer(const std::string &field, long low, long high) {
    const double value = number(field, {double(low), double(high), ""});
    if (value != std::floor(value)) fail(field, fmt::format("{:g} is not a whole number in [{}, {}]", value, low, high));
    return long(value);
}

long TomlFile::integer_or(const std::string &field, long low, long high, long otherwise) {
    return has(field) ? integer(field, low, high) : otherwise;
}

std::string TomlFile::text(const std::string &field) {
    const auto value = find(field).value<std::string>();
    if (!has(field)) fail_missing(field, "a text in quotes");
    if (!value) fail(field, "is not a text in quotes");
    return *value;
}

std::string TomlFile::text_or(const std::string &field, const std::string &otherwise) {
    return has(field) ? text(field) : otherwise;
}

bool TomlFile::boolean_or(const std::string &field, bool otherwise) {
    if (!has(field)) return otherwise;
    const auto node = find(field);
    if (!node.is_boolean()) fail(field, "is not true or false");
    return *node.value<bool>();
}

std::vector<double> TomlFile::numbers(const std::string &field, Range range, std::size_t size) {
    const auto node = find(field);
    const auto *array = node.as_array();
    const std::string wanted = size ? fmt::format("{} numbers", size) : std::string("numbers");
    if (!array) fail(field, fmt::format("is not a list of {} in {}", wanted, describe(range)));
    if (size && array->size() != size) fail(field, fmt::format("has {} entries, not {}", array->size(), size));
    std::vector<double> values;
    for (const auto &entry : *array) {
        const auto value = entry.value<double>();
        if (!entry.is_number() || !value || !(*value >= range.low && *value <= range.high)) {
            fail(field, fmt::format("entry {} is not a number in {}", values.size(), describe(range)));
        }
        values.push_back(*value);
    }
    return values;
}

std::vector<std::string> TomlFile::texts(const std::string &field) {
    const auto node = find(field);
    const auto *array = node.as_array();
    if (!array) fail(field, "is not a list of texts in quotes");
    std::vector<std::string> values;
    for (const auto &entry : *array) {
        const auto value = entry.value<std::string>();
        if (!value) fail(field, fmt::format("entry {} is not a text in quotes", values.size()));
        values.push_back(*value);
    }
    return values;
}

std::vector<std::string> TomlFile::keys(const std::string &field) {
    std::vector<std::string> names;
    const auto node = std::as_const(table_).at_path(field);
    const auto *table = node.as_table();
    if (!table) fail(field, "is not a table");
    // The parser sorts keys; what was written first comes first here.
    std::vector<std::pair<toml::source_position, std::string>> found;
    for (const auto &[key, child] : *table) found.emplace_back(key.source().begin, std::string(key.str()));
    std::sort(found.begin(), found.end());
    for (auto &entry : found) names.push_back(std::move(entry.second));
    return names;
}

std::size_t TomlFile::array_size(const std::string &field) {
    const auto node = std::as_const(table_).at_path(field);
    const auto *array = node.as_array();
    return array ? array->size() : 0;
}

void TomlFile::set(const std::string &assignment) {
    const auto equals = assignment.find('=');
    if (equals == std::string::npos || equals == 0) throw InputError("--set", assignment, "is not key=value");
    const std::string field = assignment.substr(0, equals);
    toml::table parsed;
    try {
        parsed = toml::parse("value = " + assignment.substr(equals + 1));
    } catch (const toml::parse_error &) {
        throw InputError("--set", field, "'" + assignment.substr(equals + 1) + "' is not a number, true/false, list or \"text\"");
    }
    toml::table *table = &table_;
    std::size_t from = 0;
    for (auto dot = field.find('.'); dot != std::string::npos; from = dot + 1, dot = field.find('.', from)) {
        const auto inserted = table->insert(field.substr(from, dot - from), toml::table{});
        table = inserted.first->second.as_table();
        if (!table) throw InputError("--set", field, "names a field below one that is not a table");
    }
    table->insert_or_assign(field.substr(from), std::move(*parsed.get("value")));
}

std::vector<std::string> TomlFile::unasked() const {
    std::vector<std::string> leaves;
    collect_leaves(table_, "", leaves);
    const auto is_accounted_for = [&](const std::string &leaf) {
        const auto left_to_others = [&](const std::string &table) { return leaf.rfind(table, 0) == 0; };
        return asked_.count(leaf) || std::any_of(ignored_.begin(), ignored_.end(), left_to_others);
    };
    leaves.erase(std::remove_if(leaves.begin(), leaves.end(), is_accounted_for), leaves.end());
    return leaves;
}

void TomlFile::fail_missing(const std::string &field, const std::string &wanted) const {
    fail(field, "is missing; " + wanted + nearest_hint(field, unasked()));
}

void TomlFile::finish() const {
    for (const auto &leaf : unasked()) fail(leaf, "is not a known field" + nearest_hint(leaf, {named_.begin(), named_.end()}));
}

} // namespace sixdeg
