// SPDX-License-Identifier: MIT
// A closed-form torque on a crank of known inertia and the exact times at which its teeth pass. Shares no code with
// the observers: double precision, its own J(alpha), its own quadrature.
#pragma once
#include <cmath>
#include <complex>
#include <vector>

namespace sixdeg::test {

/// Four-cylinder torque: compression and expansion about each firing TDC plus one combustion pulse, 720 deg periodic.
struct TorqueSignal {
    double rpm = 1000;
    std::vector<double> fuel{1.1, 1.0, 1.0, 0.8}; ///< Combustion of each firing against nominal (document 004, 3.3.3).
    double combustion_nm = 1200, compression_nm = 370;
    double j0_kgm2 = 0.25, recip_mass_kg = 0.95, crank_m = 0.046, rod_m = 0.1445;

    virtual double inertia(double alpha) const {
        double j = j0_kgm2;
        for (double phase : {0.0, M_PI, M_PI, 0.0}) {
            const double a = alpha - phase, s = std::sin(a);
            const double arm = crank_m * s + crank_m * crank_m * s * std::cos(a) / std::sqrt(rod_m * rod_m - crank_m * crank_m * s * s);
            j += recip_mass_kg * arm * arm;
        }
        return j;
    }

    /// Torque without its mean.
    double torque(double alpha) const { return raw(alpha) - mean(); }

    virtual ~TorqueSignal() = default;
    virtual double raw(double alpha) const {
        double sum = 0;
        for (int c = 0; c < 4; ++c) {
            const double x = std::remainder(alpha - c * M_PI, 4 * M_PI);
            if (std::fabs(x) < M_PI) sum += compression_nm * std::sin(x) * std::exp(-16 * x * x / (M_PI * M_PI)) * 2;
            if (x > 0 && x < M_PI) {
                const double u = x / 0.16; // peak about 16 deg after TDC
                sum += combustion_nm * fuel[std::size_t(c)] * u * u / 2 * std::exp(1.2 - u) * std::sin(M_PI - x);
            }
        }
        return sum;
    }

    double mean() const {
        if (mean_ < -1e8) {
            double sum = 0;
            for (int i = 0; i < kGrid; ++i) sum += raw(4 * M_PI * (i + 0.5) / kGrid);
            mean_ = sum / kGrid;
        }
        return mean_;
    }

    /// Fourier coefficients a_0, a_1, b_1 ... of torque() up to n harmonics of the cycle.
    std::vector<double> harmonics(int n) const {
        std::vector<double> c(std::size_t(2 * n + 1), 0.0);
        for (int i = 0; i < kGrid; ++i) {
            const double alpha = 4 * M_PI * (i + 0.5) / kGrid, t = torque(alpha);
            c[0] += t / kGrid;
            for (int k = 1; k <= n; ++k) {
                c[std::size_t(2 * k - 1)] += 2 * t * std::cos(k * alpha / 2) / kGrid;
                c[std::size_t(2 * k)] += 2 * t * std::sin(k * alpha / 2) / kGrid;
            }
        }
        return c;
    }

    double peak_to_peak() const {
        double low = 1e9, high = -1e9;
        for (int i = 0; i < kGrid; ++i) {
            const double t = torque(4 * M_PI * i / kGrid);
            low = std::fmin(low, t);
            high = std::fmax(high, t);
        }
        return high - low;
    }

    /// Times of `teeth` positions of a full N-wheel from alpha = 0, seconds; kinetic energy by quadrature of the
    /// torque, time by quadrature of 1/omega, both with Simpson's rule on 1/20 of a pitch.
    std::vector<double> tooth_times(int positions, int teeth) const {
        const double step = 2 * M_PI / positions / 20, mean_speed = rpm * M_PI / 30;
        std::vector<double> times{0.0};
        double energy = 0.5 * inertia(0) * mean_speed * mean_speed, alpha = 0, time = 0;
        const auto slowness = [&](double a, double e) { return std::sqrt(inertia(a) / (2 * e)); };
        for (int k = 0; k < teeth; ++k) {
            for (int s = 0; s < 20; ++s) {
                const double t0 = torque(alpha), t1 = torque(alpha + step / 2), t2 = torque(alpha + step);
                const double middle = energy + step / 24 * (5 * t0 + 8 * t1 - t2); // Simpson's parabola to its middle
                const double end = energy + step / 6 * (t0 + 4 * t1 + t2);
                time += step / 6 * (slowness(alpha, energy) + 4 * slowness(alpha + step / 2, middle) + slowness(alpha + step, end));
                energy = end;
                alpha += step;
            }
            times.push_back(time);
        }
        return times;
    }

    static constexpr int kGrid = 14400;
    mutable double mean_ = -1e9;
};

/// Value of a Fourier series (a_0, a_1, b_1 ...) at alpha.
inline double series_at(const std::vector<double> &c, double alpha) {
    double sum = c[0];
    for (std::size_t k = 1; 2 * k < c.size(); ++k) {
        sum += c[2 * k - 1] * std::cos(double(k) * alpha / 2) + c[2 * k] * std::sin(double(k) * alpha / 2);
    }
    return sum;
}

/// Root mean square over the cycle of the difference of two series of equal length.
inline double rms_difference(const std::vector<double> &a, const std::vector<double> &b) {
    double sum = (a[0] - b[0]) * (a[0] - b[0]);
    for (std::size_t i = 1; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]) / 2;
    return std::sqrt(sum);
}

/// Crank angle, deg, by which `estimate` lags `truth`: where their circular correlation over the cycle peaks.
inline double lag_deg(const std::vector<double> &estimate, const std::vector<double> &truth) {
    const auto correlation = [&](double shift) {
        double sum = 0;
        for (std::size_t k = 1; 2 * k < truth.size(); ++k) {
            const std::complex<double> e(estimate[2 * k - 1], -estimate[2 * k]), t(truth[2 * k - 1], -truth[2 * k]);
            sum += std::real(e * std::conj(t) * std::polar(1.0, double(k) * shift / 2));
        }
        return sum;
    };
    double best = 0;
    for (double d = -90; d <= 90; d += 0.01) {
        if (correlation(d * M_PI / 180) > correlation(best * M_PI / 180)) best = d;
    }
    return best;
}

} // namespace sixdeg::test
