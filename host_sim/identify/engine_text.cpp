// SPDX-License-Identifier: MIT
#include "identify/engine_text.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <toml++/toml.h>
#include <tuple>
#include <vector>

#include "common/error.hpp"

namespace sixdeg {
namespace {

/// Where a value stands in the text, lines and columns from 0, the end not included.
struct Place {
    std::string field;
    std::size_t line, column, end_line, end_column;
    bool is_number;
};

bool holds_numbers(const toml::node &node) {
    if (node.is_number()) return true;
    const auto *array = node.as_array();
    return array && !array->empty() && (holds_numbers((*array)[0]) || array->is_array_of_tables());
}

/// Every value of the file that is no table; an element of an array of tables is "name[0]", an inline one goes with its array.
void collect(const toml::node &node, const std::string &path, std::vector<Place> &places) {
    if (const auto *table = node.as_table(); table && !table->is_inline()) {
        for (const auto &[key, child] : *table) collect(child, path.empty() ? std::string(key.str()) : path + "."
            + std::string(key.str()), places);
        return;
    }
    const auto *array = node.as_array();
    if (array && array->is_array_of_tables() && !array->empty() && !(*array)[0].as_table()->is_inline()) {
        for (std::size_t i = 0; i < array->size(); ++i) collect((*array)[i], fmt::format("{}[{}]", path, i), places);
        return;
    }
    const toml::source_region &at = node.source();
    places.push_back({path, at.begin.line - 1, at.begin.column - 1, at.end.line - 1, at.end.column - 1, holds_numbers(node)});
}

std::vector<std::string> lines_of(const std::string &text) {
    std::vector<std::string> lines(1);
    for (char c : text) {
        if (c == '\n') lines.emplace_back();
        else if (c != '\r') lines.back() += c;
    }
    if (lines.back().empty()) lines.pop_back();
    return lines;
}

/// Byte of a column, which counts characters of UTF-8.
std::size_t byte_of(const std::string &line, std::size_t column) {
    std::size_t at = 0;
    for (; at < line.size() && column > 0; --column)
        for (++at; at < line.size() && (static_cast<unsigned char>(line[at]) & 0xC0) == 0x80;) ++at;
    return at;
}

/// The comment goes behind the value, ahead of one that is there.
void comment_behind(std::string &line, std::size_t value_end, const std::string &comment) {
    const std::size_t hash = line.find('#', value_end);
    std::string kept = hash == std::string::npos ? "" : "; " + line.substr(line.find_first_not_of(" \t", hash + 1) == std::string::npos
                                                                                ? line.size()
                                                                                : line.find_first_not_of(" \t", hash + 1));
    std::string head = line.substr(0, hash);
    while (!head.empty() && (head.back() == ' ' || head.back() == '\t')) head.pop_back();
    line = head + "  # " + comment + kept;
}

void replace(std::vector<std::string> &lines, const Place &place, const NewValue &value) {
    std::string &first = lines[place.line];
    const std::size_t from = byte_of(first, place.column);
    const std::string rest = lines[place.end_line].substr(byte_of(lines[place.end_line], place.end_column));
    first = first.substr(0, from) + value.text + rest;
    for (std::size_t i = place.line + 1; i <= place.end_line; ++i) lines[i] = "\n"; // no line of a file: taken out at the end
    comment_behind(first, from + value.text.size(), value.comment);
}

/// Behind the head of the field's table, or with a new head at the end.
void add(std::vector<std::string> &lines, const std::string &field, const NewValue &value) {
    const std::size_t dot = field.rfind('.');
    const std::string head = "[" + field.substr(0, dot) + "]", line = field.substr(dot + 1) + " = " + value.text + "  # " + value.comment;
    for (std::string &at : lines) {
        if (at.compare(0, head.size(), head) != 0) continue;
        at += "\n" + line;
        return;
    }
    lines.insert(lines.end(), {"", head, line});
}

} // namespace

std::string engine_with(const std::string &name, const std::string &text, const std::map<std::string, NewValue> &values) {
    toml::table table;
    try {
        table = toml::parse(text, name);
    } catch (const toml::parse_error &error) {
        throw InputError(name, fmt::format("line {}", error.source().begin.line), std::string(error.description()));
    }
    std::vector<Place> places;
    collect(table, "", places);
    std::vector<std::string> lines = lines_of(text);
    std::map<std::string, NewValue> missing = values;
    // From the end, so that what stands ahead in the same line keeps its columns.
    std::sort(places.begin(), places.end(), [](const Place &a, const Place &b) {
        return std::tie(a.line, a.column) > std::tie(b.line, b.column);
    });
    for (const Place &place : places) {
        const auto found = values.find(place.field);
        if (found != values.end()) replace(lines, place, found->second);
        else if (place.is_number) comment_behind(lines[place.end_line], byte_of(lines[place.end_line], place.end_column), "taken from "
            + name);
        missing.erase(place.field);
    }
    for (const auto &[field, value] : missing) add(lines, field, value);
    std::string result;
    for (const std::string &line : lines)
        if (line != "\n") result += line + "\n";
    return result;
}

} // namespace sixdeg
