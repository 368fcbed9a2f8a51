// SPDX-License-Identifier: MIT
// Numbers in integers against floating point: conversions to the bit, arithmetic to their 31 bits.
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <random>

extern "C" {
#include "sd_num.h"
}

namespace {

double value(sd_scaled_t a) { return std::ldexp(double(a.mantissa), a.exponent - 31); }

/// Floats of all sizes, of both signs, and those at which something changes.
std::vector<float> floats() {
    std::mt19937 random(7);
    std::vector<float> x{0.0f, 1.0f, -1.0f, 0.5f, -0.5f, 1.5f, 0x1.fffffep-1f, -0x1.fffffep-1f, 0x1.fffffep30f, 1e-30f, -1e-30f, 3e5f};
    for (int i = 0; i < 20000; ++i)
        x.push_back(std::ldexp(float(std::int32_t(random())) * 0x1p-31f, int(random() % 60) - 40));
    return x;
}

TEST(Scaled, HoldsEveryFloatAndGivesItBack) {
    for (float x : floats()) {
        const sd_scaled_t a = sd_scaled_of(x);
        EXPECT_EQ(value(a), double(x));
        EXPECT_EQ(sd_scaled_to_float(a), x);
    }
    EXPECT_EQ(sd_scaled_of(NAN).mantissa, 0);
    EXPECT_EQ(sd_scaled_of(INFINITY).mantissa, 0);
    EXPECT_EQ(sd_scaled_of(1e-42f).mantissa, 0) << "what is next to zero";
    EXPECT_EQ(sd_scaled_to_float({1 << 30, -200}), 0);
    EXPECT_EQ(sd_scaled_to_float({-(1 << 30), 200}), -std::numeric_limits<float>::max());
    EXPECT_EQ(sd_scaled_to_float({INT32_MAX, 128}), std::numeric_limits<float>::max()) << "rounds to no infinity below 2^128";
    EXPECT_EQ(sd_scaled_to_float({1 << 30, 128}), std::ldexp(1.0f, 127));
}

/// The conversions of q31 by integers and by the floating-point unit give the same bits.
TEST(Scaled, ConversionsOfQ31AreThoseOfFloatingPoint) {
    for (float x : floats()) {
        const double q = std::trunc(std::ldexp(double(x), 31));
        const auto saturated = std::int32_t(std::min(std::max(q, -2147483648.0), 2147483647.0));
        EXPECT_EQ(sd_q31_by_integers(x), saturated) << x;
        if (std::abs(x) < 1e6f) { EXPECT_EQ(sd_from_float_q31(x), saturated) << x; }
    }
    std::mt19937 random(8);
    for (int i = 0; i < 20000; ++i) {
        const auto x = std::int32_t(random()) >> (random() % 31);
        EXPECT_EQ(sd_float_q31(x), float(x) * 0x1p-31f) << x;
        EXPECT_EQ(sd_float_q31(x), sd_to_float_q31(x)) << x;
        EXPECT_EQ(sd_float_int(x), float(x)) << x;
    }
}

TEST(Scaled, OrdersFloatsByTheirBits) {
    const auto all = floats();
    for (std::size_t i = 1; i < all.size(); ++i) {
        const float a = all[i - 1], b = all[i];
        EXPECT_EQ(sd_bits_order(a) < sd_bits_order(b), a < b);
        EXPECT_EQ(sd_bits_within(a, b, 1e3f), a >= b && a <= 1e3f);
        EXPECT_EQ(sd_bits_above_to(a, b, 1e3f), a > b && a <= 1e3f);
        EXPECT_EQ(sd_bits_between(a, b, 1e3f), a > b && a < 1e3f);
    }
    EXPECT_FALSE(sd_bits_within(NAN, -1, 1));
    EXPECT_FALSE(sd_bits_above_to(-NAN, -1, 1));
    EXPECT_FALSE(sd_bits_between(NAN, -INFINITY, INFINITY));
    EXPECT_TRUE(sd_bits_within(-0.0f, 0, 0));
    EXPECT_FALSE(sd_bits_within(INFINITY, 0, 1e30f));
}

TEST(Scaled, ArithmeticHolds30Bits) {
    const auto all = floats();
    const double bits = std::ldexp(1.0, -29);
    for (std::size_t i = 1; i < all.size(); ++i) {
        const double x = double(all[i - 1]), y = double(all[i]);
        const sd_scaled_t a = sd_scaled_of(all[i - 1]), b = sd_scaled_of(all[i]);
        EXPECT_NEAR(value(sd_scaled_mul(a, b)), x * y, bits * std::abs(x * y));
        EXPECT_NEAR(value(sd_scaled_add(a, b)), x + y, bits * std::max(std::abs(x), std::abs(y)));
        EXPECT_NEAR(value(sd_scaled_sub(a, b)), x - y, bits * std::max(std::abs(x), std::abs(y)));
        if (y != 0) { EXPECT_NEAR(value(sd_scaled_div(a, b)), x / y, bits * std::abs(x / y)); }
        EXPECT_NEAR(value(sd_scaled_root(a)), x > 0 ? std::sqrt(x) : 0, x > 0 ? bits * std::sqrt(x) : 0);
        EXPECT_EQ(sd_scaled_less(a, b), x < y);
        if (std::abs(x) < 2147483647.0) { EXPECT_EQ(sd_scaled_floor(a), x > 0 ? std::uint32_t(std::floor(x)) : 0u); }
    }
    EXPECT_EQ(sd_scaled_div(sd_scaled_int(1), SD_SCALED_ZERO).mantissa, 0);
    EXPECT_EQ(value(sd_scaled_add(sd_scaled_int(3), sd_scaled_int(-3))), 0);
    EXPECT_EQ(sd_scaled_floor(sd_scaled_of(3e9f)), 2147483647u);
    EXPECT_EQ(sd_scaled_to_q31(sd_scaled_of(-4)), INT32_MIN);
    EXPECT_EQ(value(sd_scaled_make(INT64_MIN, 0)), -0x1p63);
}

/// A gain's product with 64 bits to shift, and by the high word alone.
TEST(Scaled, AGainBelowOneNeedsNoWideShift) {
    std::mt19937 random(9);
    for (int i = 0; i < 20000; ++i) {
        const auto m = std::int32_t(random()), x = std::int32_t(random());
        const auto e = std::int8_t(int(random() % 41) - 20);
        EXPECT_EQ(sd_gain_q31({m, e}, x), sd_sat_q31((std::int64_t(m) * x) >> (31 - e)));
    }
    const sd_gain_q31_t large = sd_gain_of_q31(1e9f), small = sd_gain_of_q31(-1e-8f), eighth = sd_gain_of_q31(0.125f);
    EXPECT_EQ(large.mantissa, INT32_MAX);
    EXPECT_EQ(large.exponent, 20);
    EXPECT_EQ(small.exponent, -20);
    EXPECT_NEAR(std::ldexp(small.mantissa, -51), -1e-8, 1e-15);
    EXPECT_EQ(std::ldexp(double(eighth.mantissa), eighth.exponent - 31), 0.125);
}

} // namespace
