// SPDX-License-Identifier: MIT
// The rule that bounds the gains of the Fourier torque observer, against the eigenvalues of its map over a cycle.
#include <cmath>
#include <gtest/gtest.h>

#include "linalg/linalg.hpp"
#include "support/fourier_bench.hpp"

using namespace sixdeg::test;

namespace {

/// The observer's linear map over one cycle of error (phi, c) in J and Nm, written from equation (4) and form B.
Eigen::MatrixXd cycle_map(const Gains &g, double reference, bool with_gap) {
    const int n = 2 * g.harmonics + 2;
    Eigen::MatrixXd map = Eigen::MatrixXd::Identity(n, n);
    for (int k = 1; k <= kCycle; ++k) {
        Eigen::VectorXd f(n - 1), l(n - 1);
        f(0) = 1;
        l(0) = double(g.mean);
        for (int i = 1; i <= g.harmonics; ++i) {
            f(2 * i - 1) = std::cos(i * kPitch * k / 2);
            f(2 * i) = std::sin(i * kPitch * k / 2);
            l(2 * i - 1) = l(2 * i) = i * reference;
        }
        Eigen::MatrixXd correct = Eigen::MatrixXd::Identity(n, n), predict = correct;
        correct(0, 0) = 1 - kPitch * double(g.energy);
        correct.block(1, 0, n - 1, 1) = -kPitch * l.cwiseProduct(f);
        predict.block(0, 1, 1, n - 1) = kPitch * f.transpose();
        // An interval that spans the gap says nothing: no correction at 58, 59 and at 0, which ends it.
        const bool blind = with_gap && (missing(k) || k % kN == 0);
        map = blind ? Eigen::MatrixXd(predict * map) : Eigen::MatrixXd(predict * correct * map);
    }
    return map;
}

double spectral_radius(const Gains &g, double reference, bool with_gap) {
    return sixdeg::linalg::spectral_radius(cycle_map(g, reference, with_gap));
}

TEST(GainRule, IsTheEdgeOfStabilityOfTheCycleMap) {
    for (int n = 1; n <= SD_FOURIER_HARMONICS_MAX; ++n) {
        const Gains gains{n, 4.0f, 0.8f, 0};
        const Bench bench(gains);
        const double limit = double(sd_fourier_gain_limit(&bench.config));
        EXPECT_LT(spectral_radius(gains, 0.98 * limit, false), 1.0) << n;
        EXPECT_GT(spectral_radius(gains, 1.02 * limit, false), 1.0) << n;
    }
}

TEST(GainRule, IsNotEnoughWhenTheEnergyGainIsSmallAndHarmonicsMany) { // so `sixdeg calibrate` certifies by the radius
    const Gains gains{12, 1.0f, 0.3f, 0};
    const Bench bench(gains);
    EXPECT_GT(spectral_radius(gains, 0.5 * double(sd_fourier_gain_limit(&bench.config)), false), 1.0);
}

TEST(GainRule, GainSetsInUseConvergeWithTheGapToo) {
    for (const Gains &gains : {kSmooth, kFast, kFine}) {
        EXPECT_LT(spectral_radius(gains, double(gains.reference), true), 0.95) << gains.harmonics;
    }
}

/// The shipped kernel is that map: its response over a cycle to a change of each state, column by column.
TEST(CycleMap, OfTheKernelIsTheMapOfTheEquations) {
    for (const Gains &gains : {kSmooth, kFast, kFine}) {
        Bench bench(gains);
        for (std::int32_t &j : bench.tables.inertia_q31) j = INT32_MAX;
        bench.tables.inertia_base_kgm2 = 0.25f;
        sd_fourier_f32_t nominal;
        ASSERT_EQ(SD_OK, sd_fourier_init_f32(&nominal, &bench.config, &bench.tables));
        const Eigen::MatrixXd expected = cycle_map(gains, double(gains.reference), true);
        const unsigned period = unsigned(std::llround(kPitch / 150.0 * kTickHz));
        sd_fourier_step_f32(&nominal, &bench.tables, 0, 1, period, 1);
        const int n = 2 * gains.harmonics + 2;
        const double bases = double(nominal.energy_base_j / nominal.torque_base_nm);
        const float energy = nominal.energy;
        for (int column = 0; column < n; ++column) {
            sd_fourier_f32_t s[2] = {nominal, nominal};
            for (int side = 0; side < 2; ++side) {
                s[side].energy = energy;
                for (float &c : s[side].coefficient) c = 0;
                (column ? s[side].coefficient[column - 1] : s[side].energy) += side ? 1e-3f : -1e-3f;
                for (int k = 1, last = 0; k <= kCycle; ++k) {
                    if (missing(k)) continue;
                    sd_fourier_step_f32(&s[side], &bench.tables, unsigned(k % kCycle), unsigned(k - last), period, 1);
                    last = k;
                }
            }
            for (int row = 0; row < n; ++row) {
                const double change = row ? double(s[1].coefficient[row - 1] - s[0].coefficient[row - 1])
                    : double(s[1].energy - s[0].energy);
                const double per_unit = (row == 0 && column) ? 1 / bases : (row && column == 0) ? bases : 1;
                EXPECT_NEAR(change / 2e-3, expected(row, column) * per_unit, 1e-3 * std::fmax(1, per_unit)) << row << "," << column;
            }
        }
    }
}

} // namespace
