// SPDX-License-Identifier: MIT
// Exact linear algebra: arithmetic modulo a prime just below 2^31 and a row echelon form that grows row by
// row.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sixdeg {

/// Integers modulo P = 2^31 - Below, Below < 32. Values are in [0, P).
template <unsigned Below> struct Modular {
    static constexpr std::uint32_t prime = (1u << 31) - Below;

    /// Any x below 2^63 + 2^32. 2^31 = Below modulo P, so the upper bits fold onto the lower ones.
    static std::uint32_t reduce(std::uint64_t x) {
        constexpr std::uint64_t low = (1u << 31) - 1;
        x = (x & low) + Below * (x >> 31);
        x = (x & low) + Below * (x >> 31);
        const auto y = std::uint32_t(x);
        return y >= prime ? y - prime : y;
    }
    static std::uint32_t multiply(std::uint32_t a, std::uint32_t b) { return reduce(std::uint64_t(a) * b); }
    static std::uint32_t add(std::uint32_t a, std::uint32_t b) { return reduce(std::uint64_t(a) + b); }
};

/// Row space of the rows added so far. The wanted columns stand last: a row whose pivot is among them says
/// something of the wanted states alone, so they are determined exactly when every one of them has a pivot
/// (1-full rank).
template <class Field> class Echelon {
  public:
    Echelon() = default;
    Echelon(int columns, int wanted)
        : n_(std::size_t(columns)), first_wanted_(n_ - std::size_t(wanted)), missing_(wanted), rows_(n_ * n_),
          has_pivot_(n_, 0) {}

    /// `scratch` holds the row and is overwritten.
    void add(std::uint32_t *scratch) {
        for (std::size_t column = 0; column < n_; ++column) {
            if (scratch[column] == 0) continue;
            std::uint32_t *pivot = &rows_[column * n_];
            if (!has_pivot_[column]) {
                for (std::size_t j = column; j < n_; ++j) pivot[j] = scratch[j];
                has_pivot_[column] = 1;
                missing_ -= column >= first_wanted_;
                return;
            }
            // Without division: pivot value times the row, less the row's value times the pivot row.
            const std::uint64_t keep = pivot[column], take = Field::prime - scratch[column];
            for (std::size_t j = column; j < n_; ++j)
                scratch[j] = Field::reduce(keep * scratch[j] + take * pivot[j]);
        }
    }

    bool determines_wanted() const { return missing_ == 0; }

  private:
    std::size_t n_ = 0, first_wanted_ = 0;
    int missing_ = 0;
    std::vector<std::uint32_t> rows_; ///< The row with pivot in column c is row c.
    std::vector<char> has_pivot_;
};

} // namespace sixdeg
