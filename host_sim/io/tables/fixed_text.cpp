// SPDX-License-Identifier: MIT
#include "io/tables/fixed_text.hpp"

#include <cmath>
#include <cstdint>
#include <fmt/format.h>
#include <iterator>

namespace sixdeg {
namespace {

constexpr double kPowers[] = {1, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};
constexpr double kLargest = 0x1p38; // the product is less than 2^-15 off below this,
constexpr double kNearTie = 1e-4;   // so that it rounds rightly unless so near the middle between two digits

} // namespace

void append_fixed(std::string &text, double value, int decimals) {
    const double scaled = std::abs(value) * kPowers[decimals];
    const double whole = std::floor(scaled), rest = scaled - whole;
    if (!(scaled < kLargest) || std::abs(rest - 0.5) < kNearTie) {
        fmt::format_to(std::back_inserter(text), "{:.{}f}", value, decimals);
        return;
    }
    char digits[24];
    char *const end = digits + sizeof digits, *first = end;
    auto left = std::uint64_t(whole) + (rest > 0.5);
    for (int i = 0; i < decimals; ++i, left /= 10) *--first = char('0' + left % 10);
    if (decimals > 0) *--first = '.';
    do {
        *--first = char('0' + left % 10);
        left /= 10;
    } while (left > 0);
    if (std::signbit(value)) *--first = '-';
    text.append(first, std::size_t(end - first));
}

} // namespace sixdeg
