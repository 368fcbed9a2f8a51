// SPDX-License-Identifier: MIT
// Random numbers that repeat: one independent stream for each use, all from one seed.
#pragma once
#include <cmath>
#include <cstdint>
#include <random>

namespace sixdeg {

/// One stream of random numbers. The raw words and uniforms are the same bits on every platform
/// (std::seed_seq and std::mt19937_64 are fully specified); normals agree as far as the platform's std::log
/// and std::sqrt do. Streams with different `stream` numbers are independent, so adding a use of one changes
/// no other.
class RandomStream {
  public:
    RandomStream(std::uint64_t seed, std::uint32_t stream) {
        std::seed_seq words{std::uint32_t(seed), std::uint32_t(seed >> 32), stream};
        engine_.seed(words);
    }

    /// In [0, 1), 53 bits.
    double uniform() { return double(engine_() >> 11) * 0x1p-53; }
    /// True with probability `p`; p <= 0 is never, p >= 1 always. Always draws exactly one number.
    bool chance(double p) { return uniform() < p; }
    /// Mean 0, standard deviation 1, by inverting the distribution. One number drawn per call.
    double normal() { return inverse_normal((double(engine_() >> 12) + 0.5) * 0x1p-52); }

    /// Quantile of the standard normal distribution, 0 < p < 1, relative error about 1e-9.
    /// Rational approximation of P. J. Acklam (2003) as published; the tails use sqrt(-2 ln p).
    static double inverse_normal(double p) {
        if (p < 0.02425) return tail(std::sqrt(-2 * std::log(p)));
        if (p > 1 - 0.02425) return -tail(std::sqrt(-2 * std::log(1 - p)));
        const double q = p - 0.5, r = q * q;
        const double top =
            (((((-3.969683028665376e+01 * r + 2.209460984245205e+02) * r - 2.759285104469687e+02) * r +
               1.383577518672690e+02) *
                  r -
              3.066479806614716e+01) *
                 r +
             2.506628277459239e+00) *
            q;
        const double bottom =
            ((((-5.447609879822406e+01 * r + 1.615858368580409e+02) * r - 1.556989798598866e+02) * r +
              6.680131188771972e+01) *
                 r -
             1.328068155288572e+01) *
                r +
            1;
        return top / bottom;
    }

  private:
    static double tail(double q) {
        const double top =
            ((((-7.784894002430293e-03 * q - 3.223964580411365e-01) * q - 2.400758277161838e+00) * q -
              2.549732539343734e+00) *
                 q +
             4.374664141464968e+00) *
                q +
            2.938163982698783e+00;
        const double bottom =
            (((7.784695709041462e-03 * q + 3.224671290700398e-01) * q + 2.445134137142996e+00) * q +
             3.754408661907416e+00) *
                q +
            1;
        return top / bottom;
    }
    std::mt19937_64 engine_;
};

} // namespace sixdeg
