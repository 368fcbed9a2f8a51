// SPDX-License-Identifier: MIT
// An engine by ordinary equations: ideal gas whose gamma is a constant, Wiebe's heat release in one piece, valves without resistance, no
// heat to the walls, a rigid crank. It shares no code with the calibration and none with the simulated engine, and agrees with neither.
#pragma once
#include "support/torque_signal.hpp"

namespace sixdeg::test {

struct OtherEngine : TorqueSignal {
    double gamma = 1.35, intake_bar = 1, exhaust_bar = 1.1;
    double heat_j = 0; ///< Of each firing, times its `fuel`.
    double bore_m = 0.087, compression_ratio = 14;
    double wheel_deg = 0; ///< By which the wheel's teeth pass later in crank angle than the engine file says.
    double closes_deg = -140, opens_deg = 130, start_deg = -2, duration_deg = 55, shape = 1;

    /// Call it when everything else is set.
    void solve() {
        fired_ = table(heat_j);
        motored_ = table(0);
        mean_ = -1e9;
    }
    double inertia(double alpha) const override { return TorqueSignal::inertia(alpha + wheel_deg * kDeg); }
    double raw(double alpha) const override {
        double sum = 0;
        for (std::size_t c = 0; c < 4; ++c) {
            const double x = alpha + wheel_deg * kDeg - double(c) * M_PI, share = fuel[c];
            sum += share * at(fired_, x) + (1 - share) * at(motored_, x);
        }
        return sum;
    }
    /// What heat adds, mean over the 180 deg after TDC, of a firing with fuel 1.
    double firing_nm() const {
        double sum = 0;
        for (int i = 0; i < kPoints / 4; ++i) sum += (fired_[std::size_t(i)] - motored_[std::size_t(i)]) / (kPoints / 4);
        return sum;
    }

  private:
    static constexpr int kPoints = 7200; ///< Of a cycle.
    static constexpr double kStep = 4 * M_PI / kPoints, kDeg = M_PI / 180;

    double area() const { return M_PI / 4 * bore_m * bore_m; }
    double volume(double a) const {
        const double s = crank_m * std::sin(a);
        return area() * (2 * crank_m / (compression_ratio - 1) + crank_m + rod_m - crank_m * std::cos(a)
                         - std::sqrt(rod_m * rod_m - s * s));
    }
    double burnt(double a) const {
        const double y = (a / kDeg - start_deg) / duration_deg;
        return y > 0 ? 1 - std::exp(-6.9 * std::pow(y, shape + 1)) : 0;
    }
    /// p V^gamma grows by heat alone: exact but for the middle rule over a step.
    std::vector<double> table(double heat) const {
        std::vector<double> torque(kPoints);
        double p = intake_bar * 1e5;
        for (int i = int(closes_deg * kDeg / kStep); i < int(closes_deg * kDeg / kStep) + kPoints; ++i) {
            const double a = i * kStep, deg = a / kDeg, next = a + kStep;
            torque[std::size_t((i + kPoints) % kPoints)] = (p - 1.013e5) * (volume(next) - volume(a - kStep)) / (2 * kStep);
            if (deg < opens_deg) {
                const double middle = volume(a + kStep / 2);
                p = (p * std::pow(volume(a), gamma) + (gamma - 1) * heat * (burnt(next) - burnt(a)) * std::pow(middle, gamma - 1)) /
                    std::pow(volume(next), gamma);
            } else {
                p += 6 * kStep * ((deg < 375 ? exhaust_bar : intake_bar) * 1e5 - p);
            }
        }
        return torque;
    }
    static double at(const std::vector<double> &table, double angle) {
        const double x = std::remainder(angle, 4 * M_PI) / kStep, floor = std::floor(x);
        const auto k = (int(floor) + kPoints) % kPoints;
        return table[std::size_t(k)] + (x - floor) * (table[std::size_t((k + 1) % kPoints)] - table[std::size_t(k)]);
    }

    std::vector<double> fired_, motored_;
};

} // namespace sixdeg::test
