// SPDX-License-Identifier: MIT
// One line of text into fields, and a field into a number. Every reader of recordings goes through these.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

namespace sixdeg {

/// How the fields of a line are told apart, and what stands before the fraction of a number.
struct FieldStyle {
    char separator = ','; ///< ';', tab, ',', '|', or ' ' for any run of blanks.
    char decimal = '.';   ///< '.' or ','.
    bool split_fraction = false; ///< Commas do both: a number is two fields, "0,25" with separator ','.
    bool operator==(const FieldStyle &other) const {
        return separator == other.separator && decimal == other.decimal && split_fraction == other.split_fraction;
    }
};

/// Without blanks, quotes and carriage return at either end.
std::string_view trimmed(std::string_view text);

/// Takes the next field off the front of `rest`; quotes are taken off it.
std::string_view next_field(std::string_view &rest, const FieldStyle &style);

/// How many fields a line has; a separator at its very end opens no field.
int count_fields(std::string_view line, const FieldStyle &style);

/// A decimal number as written: (-1)^negative mantissa / 10^digits. Times are compared before they are rounded, because a
/// time since 1970 with microseconds does not fit a double.
struct Decimal {
    std::int64_t whole = 0; ///< The part before the point.
    double fraction = 0;    ///< The rest, of the same sign, below 1.
    double value() const { return double(whole) + fraction; }
};

/// Nothing where the field is no finite number. Hours, minutes and seconds as in 12:30:05.25 count as seconds; with a date before them,
/// as in 2024-03-12T12:30:05.25Z, as seconds since 1970.
std::optional<double> number_of(std::string_view field, char decimal);
std::optional<Decimal> decimal_of(std::string_view field, char decimal);

/// A cell that stands for "no value": empty, X, Z, -, NaN and their like.
bool is_blank_cell(std::string_view field);

} // namespace sixdeg
