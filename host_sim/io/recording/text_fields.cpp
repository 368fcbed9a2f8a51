// SPDX-License-Identifier: MIT
#include "io/recording/text_fields.hpp"

#include <charconv>
#include <cmath>
#include <string>

namespace sixdeg {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr double kPowers[] = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// The plain form that nearly every cell has: sign, digits, point, digits; up to 18 digits in all.
struct Plain {
    bool negative = false;
    std::uint64_t digits = 0;
    int count = 0, behind = 0; ///< Digits in all, and behind the point.
};

std::optional<Plain> plain_of(std::string_view field, char decimal) {
    Plain plain;
    const char *at = field.data(), *const end = at + field.size();
    if (at != end && (*at == '-' || *at == '+')) plain.negative = *at++ == '-';
    for (; at != end && is_digit(*at); ++at, ++plain.count) plain.digits = plain.digits * 10 + std::uint64_t(*at - '0');
    if (at != end && *at == decimal) {
        for (++at; at != end && is_digit(*at); ++at, ++plain.count, ++plain.behind)
            plain.digits = plain.digits * 10 + std::uint64_t(*at - '0');
    }
    if (at != end || plain.count == 0 || plain.count > 18) return std::nullopt;
    return plain;
}

/// Anything else that is a number, such as 1.5e-3 or one of twenty digits.
std::optional<double> other_number(std::string_view field, char decimal) {
    std::string text(field.substr(0, 64)); // from_chars knows neither a plus sign nor a decimal comma
    if (decimal != '.') {
        if (text.find('.') != std::string::npos) return std::nullopt;
        for (char &c : text) c = c == decimal ? '.' : c;
    }
    const std::size_t plus = text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0;
    double value = 0;
    const char *const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data() + plus, end, value);
    if (error != std::errc{} || stop != end || field.size() > 64 || !std::isfinite(value)) return std::nullopt;
    return value;
}

/// Levels in words.
std::optional<double> level_word(std::string_view field) {
    static constexpr std::pair<std::string_view, double> words[] = {{"high", 1}, {"low", 0},    {"true", 1},    {"false", 0}, {"on", 1},
                                                                    {"off", 0},  {"rising", 1}, {"falling", 0}, {"rise", 1},  {"fall", 0},
                                                                    {"h", 1},    {"l", 0}};
    for (const auto &[word, value] : words) {
        if (word.size() != field.size()) continue;
        bool same = true;
        for (std::size_t i = 0; i < word.size(); ++i) same &= (field[i] | 0x20) == word[i];
        if (same) return value;
    }
    return std::nullopt;
}

/// 12:30:05.25 as seconds of the day; minutes and seconds alone as well.
std::optional<Decimal> clock_time(std::string_view field, char decimal) {
    std::int64_t before = 0;
    int parts = 0;
    for (auto colon = field.find(':'); colon != std::string_view::npos; colon = field.find(':'), ++parts) {
        const auto part = plain_of(field.substr(0, colon), decimal);
        if (!part || part->behind > 0 || part->count > 4 || part->negative) return std::nullopt;
        before = (before + std::int64_t(part->digits)) * 60;
        field.remove_prefix(colon + 1);
    }
    const auto seconds = plain_of(field, decimal);
    if (parts < 1 || parts > 2 || !seconds || seconds->negative) return std::nullopt;
    const double value = double(seconds->digits) / kPowers[seconds->behind];
    return Decimal{before + std::int64_t(value), value - std::floor(value)};
}

/// Days from 1970 to a date of three numbers: 2024-03-12, 2024/03/12, 12.03.2024.
std::optional<std::int64_t> days_of(std::string_view date) {
    std::int64_t part[3];
    const char separator = date.find('.') != std::string_view::npos ? '.' : date.find('/') != std::string_view::npos ? '/' : '-';
    for (std::int64_t &number : part) {
        const auto end = date.find(separator);
        const auto plain = plain_of(date.substr(0, end), '\0');
        if (!plain || plain->negative || plain->count > 4 || (end == std::string_view::npos) != (&number == part + 2)) return std::nullopt;
        number = std::int64_t(plain->digits);
        date = end == std::string_view::npos ? std::string_view{} : date.substr(end + 1);
    }
    if (separator == '.') std::swap(part[0], part[2]);
    const auto [year, month, day] = part;
    if (year < 1900 || month < 1 || month > 12 || day < 1 || day > 31) return std::nullopt;
    // The year begins in March, so that a leap day is its last.
    const std::int64_t from_march = (month + 9) % 12, whole = year - (month < 3);
    return whole * 365 + whole / 4 - whole / 100 + whole / 400 + (153 * from_march + 2) / 5 + day - 719469;
}

/// The time of day, with a date before it or without; a time zone behind it is passed over.
std::optional<Decimal> date_and_time(std::string_view field, char decimal) {
    const auto gap = field.find_first_of("T ");
    if (gap == std::string_view::npos) return clock_time(field, decimal);
    const auto days = days_of(field.substr(0, gap));
    std::string_view clock = trimmed(field.substr(gap + 1));
    clock = clock.substr(0, clock.find_first_of("Z+-"));
    const auto time = clock_time(trimmed(clock), decimal);
    if (!days || !time) return std::nullopt;
    return Decimal{*days * 86400 + time->whole, time->fraction};
}

} // namespace

std::string_view trimmed(std::string_view text) {
    const auto first = text.find_first_not_of(kBlanks);
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

std::string_view next_field(std::string_view &rest, const FieldStyle &style) {
    const bool blanks = style.separator == ' ';
    if (blanks) rest = trimmed(rest);
    std::size_t from = 0;
    // A separator within quotes belongs to the field.
    const auto quote = rest.find_first_not_of(kBlanks);
    if (quote != std::string_view::npos && rest[quote] == '"') {
        const auto close = rest.find('"', quote + 1);
        if (close != std::string_view::npos) from = close;
    }
    const auto end = blanks ? rest.find_first_of(kBlanks, from) : rest.find(style.separator, from);
    std::string_view field = trimmed(rest.substr(0, end));
    rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
    if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = trimmed(field.substr(1, field.size() - 2));
    return field;
}

int count_fields(std::string_view line, const FieldStyle &style) {
    int count = 0;
    line = trimmed(line);
    if (!line.empty() && style.separator != ' ' && line.back() == style.separator) line.remove_suffix(1);
    while (!line.empty()) {
        const std::string_view before = line;
        next_field(line, style);
        ++count;
        if (line.empty() && before.back() == style.separator && style.separator != ' ') ++count;
        if (style.separator == ' ') line = trimmed(line);
    }
    return style.split_fraction ? count / 2 : count;
}

std::optional<double> number_of(std::string_view field, char decimal) {
    if (const auto plain = plain_of(field, decimal)) {
        const double value = double(plain->digits) / kPowers[plain->behind];
        if (plain->digits < (std::uint64_t(1) << 53)) return plain->negative ? -value : value; // exact operands, rounded once
    }
    if (field.find(':') != std::string_view::npos) {
        const auto time = date_and_time(field, decimal);
        return time ? std::optional(time->value()) : std::nullopt;
    }
    const auto other = other_number(field, decimal);
    return other ? other : level_word(field);
}

std::optional<Decimal> decimal_of(std::string_view field, char decimal) {
    if (const auto plain = plain_of(field, decimal)) {
        const std::uint64_t scale = std::uint64_t(kPowers[plain->behind]), rest = plain->digits % scale;
        const std::int64_t whole = std::int64_t(plain->digits / scale);
        const double fraction = double(rest) / double(scale);
        return plain->negative ? Decimal{-whole, -fraction} : Decimal{whole, fraction};
    }
    if (field.find(':') != std::string_view::npos) return date_and_time(field, decimal);
    const auto value = other_number(field, decimal);
    if (!value || std::abs(*value) > 9e18) return std::nullopt;
    const double whole = std::trunc(*value);
    return Decimal{std::int64_t(whole), *value - whole};
}

bool is_blank_cell(std::string_view field) {
    if (field.empty()) return true;
    if (field.size() > 4) return false;
    std::string lower;
    for (char c : field) lower += c >= 'A' && c <= 'Z' ? char(c + 'a' - 'A') : c;
    for (const char *blank : {"x", "z", "u", "-", "--", "nan", "null", "none", "n/a", "na", "?", "inf", "-inf", "\xE2\x88\x9E"}) {
        if (lower == blank) return true;
    }
    return false;
}

} // namespace sixdeg
