// SPDX-License-Identifier: MIT
// Text of numbers in tables: what printf writes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "common/random.hpp"
#include "io/tables/fixed_text.hpp"

namespace {

std::string fixed(double value, int decimals) {
    std::string text;
    sixdeg::append_fixed(text, value, decimals);
    return text;
}

std::string printed(double value, int decimals) {
    char text[400];
    std::snprintf(text, sizeof text, "%.*f", decimals, value);
    return text;
}

TEST(FixedText, IsWhatPrintfWrites) {
    sixdeg::RandomStream random(7, 1);
    for (int i = 0; i < 200000; ++i) {
        const int decimals = i % 10;
        const double value = random.normal() * std::pow(10, 16 * random.uniform() - 6);
        ASSERT_EQ(fixed(value, decimals), printed(value, decimals)) << i;
    }
}

TEST(FixedText, RoundsTiesAndTheirNeighboursRightly) {
    for (int decimals = 0; decimals <= 9; ++decimals) {
        for (int i = -2001; i <= 2001; ++i) {
            const double tie = (i + 0.5) / std::pow(10, decimals);
            for (double value : {tie, std::nextafter(tie, 1e9), std::nextafter(tie, -1e9), double(float(tie)), i / std::pow(10, decimals)})
                ASSERT_EQ(fixed(value, decimals), printed(value, decimals)) << i << ' ' << decimals;
        }
    }
}

TEST(FixedText, KeepsSignsOfZeroAndWritesWhatHasNoDigits) {
    EXPECT_EQ(fixed(0.0, 3), "0.000");
    EXPECT_EQ(fixed(-0.0, 3), "-0.000");
    EXPECT_EQ(fixed(-1e-9, 3), "-0.000");
    EXPECT_EQ(fixed(1e300, 1), printed(1e300, 1));
    EXPECT_EQ(fixed(-std::numeric_limits<double>::infinity(), 2), "-inf");
    EXPECT_EQ(fixed(std::numeric_limits<double>::quiet_NaN(), 2), "nan");
}

} // namespace
