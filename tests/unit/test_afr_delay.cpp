// SPDX-License-Identifier: MIT
// Delay and lags found from trims, on an exhaust of this file's own: stirred manifold, delay line and two lags in fine steps.
#include <array>
#include <cmath>
#include <complex>
#include <cstring>
#include <gtest/gtest.h>
#include <vector>

#include "common/random.hpp"
extern "C" {
#include "sd_afr_delay.h"
}

using namespace sixdeg;

namespace {

constexpr int kPositions = 120, kFine = 10;
constexpr double kRpm = 1500, kStep_s = 60 / kRpm / 60, kTau1_s = 0.03, kTau2_s = 0.015, kDelay = 25; // positions
constexpr double kManifold = 1, kLambda = 0.53, kPi = 3.14159265358979;                               // charges; mean
const double kRadps = kRpm * kPi / 30, kDegPerS = kRadps * 180 / kPi;

/// Share of a charge that passes in a position, `since` positions after the valve begins to open.
double flow(double since) {
    since = std::fmod(since + 4 * kPositions, kPositions);
    return since < 40 ? (1 - std::cos(2 * kPi * since / 40)) / 40 : 0;
}

struct Trial {
    double late_deg = 0, lag = 0, noise = 0; ///< What the kernel does not know; rms of lambda a position.
    std::uint64_t seed = 1;
    std::array<double, 4> injector = {0.06, -0.03, -0.08, 0.09};
};

class Bench {
  public:
    explicit Bench(const Trial &trial) : trial_(trial), random_(trial.seed, 3), pipe_(200 * kFine, kLambda) {
        const sd_afr_delay_config_t c{kPositions, 4, float(kTau1_s), float(kTau2_s)};
        EXPECT_EQ(sd_afr_delay_init(&kernel, &c), SD_OK);
    }
    /// One cycle with these trims. True when something was learned; the tables then follow, as the ecu's do.
    bool cycle(const std::array<double, 4> &trim, bool steady = true, double broken = 0) {
        for (int p = 0; p < kPositions; ++p) {
            const double lambda = plant(p, trim) + trial_.noise * random_.normal();
            sd_exhaust_now_f32_t now{};
            now.mass = float(0.1 * kManifold), now.charge = 0.1f;
            const double believed = kDelay + 1.5 + double(kernel.learned.late_s) / kStep_s;
            for (int i = 0; i < 4; ++i) now.share[i] = float(flow(p + 0.5 - 30 * i - believed));
            const bool mark = p % 60 > 56; // missing teeth
            for (int i = 0; i < 4; ++i)
                if (now.share[i] > 0) now.flowing[now.count++] = std::uint8_t(i);
            sd_afr_inflow_t in;
            sd_afr_inflow_of(&now, &in);
            sd_afr_delay_step(&kernel, &in, std::uint32_t(p), mark ? 100.0f : float(broken != 0 ? broken : 1 - lambda));
        }
        std::array<float, 4> told; // of the gas that arrives from now on
        for (std::size_t i = 0; i < 4; ++i) told[i] = float(trim[i]);
        const sd_afr_trims_t t{float(kRadps), told.data(), float(kLambda), std::uint8_t(steady)};
        ++cycles;
        return sd_afr_delay_cycle(&kernel, &t);
    }
    /// A probe of 5 % from begin to end; false: it ended without an answer.
    bool probe(double broken = 0) {
        for (int k = 0; k < 10; ++k) cycle({});
        sd_afr_delay_probe(&kernel, true);
        while (kernel.probed) {
            std::array<double, 4> trim;
            for (std::uint32_t i = 0; i < 4; ++i) trim[i] = 0.05 * double(sd_afr_delay_probe_trim(&kernel, i));
            if (cycle(trim, true, broken)) return true;
        }
        return false;
    }
    double error_deg() const { return double(kernel.learned.late_s) * kDegPerS - trial_.late_deg; }
    double stated_deg() const { return double(kernel.learned.late_sd_s) * kDegPerS; }
    sd_afr_delay_t kernel;
    int cycles = 0;

  private:
    /// Mean of the sensor over a position.
    double plant(int position, const std::array<double, 4> &trim) {
        const double dt = kStep_s / kFine, delay = (kDelay + trial_.late_deg / 6) * kFine;
        double mean = 0;
        for (int f = 0; f < kFine; ++f, ++at_) {
            for (std::size_t i = 0; i < 4; ++i) {
                const double since = position + (f + 0.5) / kFine - 30.0 * double(i), part = flow(since) / kFine;
                if (std::fmod(since + 4 * kPositions, kPositions) < 0.2) lambda_[i] = kLambda * (1 + trial_.injector[i]) * (1 + trim[i]);
                gas_ += part / kManifold * (lambda_[i] - gas_);
            }
            pipe_[at_ % pipe_.size()] = gas_;
            const double arrived = pipe_[(at_ + pipe_.size() - std::size_t(std::lround(delay))) % pipe_.size()];
            lag2_ += dt / (kTau2_s * (1 + trial_.lag)) * (arrived - lag2_);
            lag1_ += dt / (kTau1_s * (1 + trial_.lag)) * (lag2_ - lag1_);
            mean += lag1_ / kFine;
        }
        return mean;
    }
    Trial trial_;
    RandomStream random_;
    std::vector<double> pipe_;
    std::size_t at_ = 4000;
    double gas_ = kLambda, lag2_ = kLambda, lag1_ = kLambda;
    std::array<double, 4> lambda_{kLambda, kLambda, kLambda, kLambda};
};

TEST(AfrDelay, AProbeFindsTheDelayWithinWhatItStates) {
    double square = 0, stated = 0, count = 0;
    for (double late : {-150.0, -90.0, -60.0, -30.0, -10.0, 10.0, 30.0, 60.0, 90.0, 150.0}) {
        for (std::uint64_t seed = 1; seed <= 3; ++seed) {
            Bench b({late, 0, 0.005, seed + std::uint64_t(1000 + late), {0.06, -0.03, -0.08, 0.09}});
            ASSERT_TRUE(b.probe()) << late;
            EXPECT_LT(b.cycles, 250) << late;
            EXPECT_LT(std::abs(b.error_deg()), 25) << late << " " << seed;
            square += std::pow(b.error_deg(), 2), stated += std::pow(b.stated_deg(), 2), ++count;
        }
    }
    EXPECT_LT(std::sqrt(square / count), 10);
    EXPECT_NEAR(std::sqrt(square / stated), 1, 0.5);
}

TEST(AfrDelay, AProbeTellsLongerLagsFromALongerDelay) {
    for (double lag : {-0.2, 0.2}) {
        Bench b({30, lag});
        // The first reading is weighed against what is usual; without noise the second one has only the model against it.
        ASSERT_TRUE(b.probe() && b.probe() && b.probe());
        EXPECT_NEAR(double(b.kernel.learned.lag), lag, 0.05);
        EXPECT_LT(std::abs(b.error_deg()), 6) << lag;
    }
}

/// The balance's trims: they go where the injectors' differences vanish.
TEST(AfrDelay, TrimsOfABalanceTellALargeErrorAndLeaveASmallOne) {
    for (double late : {-120.0, -90.0, 0.0, 90.0, 120.0}) {
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
            const Trial trial{late, 0, 0.005, seed, {0.06, -0.03, -0.08, 0.09}};
            Bench b(trial);
            std::array<double, 4> trim{};
            bool learned = false;
            for (int k = 0; k < 120; ++k) {
                for (std::size_t i = 0; k >= 30 && i < 4; ++i) trim[i] += 0.2 * (1 / (1 + trial.injector[i]) - 1 - trim[i]);
                learned = b.cycle(trim) || learned;
            }
            EXPECT_EQ(learned, std::abs(late) > 1) << late << " " << seed;
            EXPECT_LT(std::abs(b.error_deg()), 45) << late << " " << seed;
            EXPECT_EQ(b.kernel.learned.lag, 0) << "only a probe tells it";
        }
    }
}

/// Cycles until the trims of a balance have taught the delay to 45 deg, which is what they are good for; 200: never.
int cycles_to_learn(Bench &b, const Trial &trial) {
    std::array<double, 4> trim{};
    for (int k = 0; k < 200; ++k) {
        for (std::size_t i = 0; k >= 30 && i < 4; ++i) trim[i] += 0.2 * (1 / (1 + trial.injector[i]) - 1 - trim[i]);
        b.cycle(trim);
        if (std::abs(b.error_deg()) < 45) return k;
    }
    return 200;
}

/// What an earlier start believed, and was sure of, does no more harm than what the calibration believes.
TEST(AfrDelay, AWrongDelayThatWasKeptIsUnlearnedAsQuicklyAsACalibratedOne) {
    for (double late : {-120.0, -90.0, -60.0, 60.0, 90.0, 120.0}) {
        int kept_cycles = 0, fresh_cycles = 0;
        for (std::uint64_t seed = 1; seed <= 4; ++seed) {
            const Trial of_calibration{late, 0, 0.005, seed, {0.06, -0.03, -0.08, 0.09}},
                of_file{0, 0, 0.005, seed, {0.06, -0.03, -0.08, 0.09}};
            Bench fresh(of_calibration), kept(of_file);
            const sd_afr_kept_t file{{float(-late / kDegPerS), float(12 / kDegPerS), 0, 0.2f}, 0.01f, float(kTau1_s), float(kTau2_s)};
            ASSERT_EQ(sd_afr_delay_resume(&kept.kernel, 0.01f, &file), SD_OK);
            fresh_cycles += cycles_to_learn(fresh, of_calibration), kept_cycles += cycles_to_learn(kept, of_file);
        }
        EXPECT_LT(fresh_cycles, 4 * 150) << late;
        EXPECT_LE(kept_cycles, 1.1 * fresh_cycles) << late;
    }
}

TEST(AfrDelay, WhatIsKeptIsOfTheEngineAndNotOfTheCalibration) {
    Bench b({60, 0.15});
    ASSERT_TRUE(b.probe() && b.probe());
    sd_afr_kept_t kept;
    sd_afr_delay_keep(&b.kernel, 0.01f, &kept);
    const sd_afr_delay_config_t other{kPositions, 4, float(1.1 * kTau1_s), float(1.1 * kTau2_s)};
    sd_afr_delay_t next;
    ASSERT_EQ(sd_afr_delay_init(&next, &other), SD_OK);
    ASSERT_EQ(sd_afr_delay_resume(&next, 0.012f, &kept), SD_OK);
    EXPECT_NEAR(next.learned.late_s, b.kernel.learned.late_s - 0.002f, 1e-6);
    EXPECT_NEAR(1.1f * (1 + next.learned.lag), 1 + b.kernel.learned.lag, 1e-5);
    EXPECT_EQ(next.learned.late_sd_s, b.kernel.learned.late_sd_s);
    EXPECT_EQ(next.learned.lag_sd, b.kernel.learned.lag_sd);
    const sd_afr_learned_t before = next.learned;
    for (auto spoil : {+[](sd_afr_kept_t &k) { k.learned.late_s = NAN; }, +[](sd_afr_kept_t &k) { k.dead_s = 0.2f; },
                       +[](sd_afr_kept_t &k) { k.tau1_s = 0.2f; },
                       +[](sd_afr_kept_t &k) { k.learned.lag = -0.9f; }, +[](sd_afr_kept_t &k) { k.learned.lag_sd = NAN; },
                           +[](sd_afr_kept_t &k) { k.tau2_s = 0; }}) {
        sd_afr_kept_t bad = kept;
        spoil(bad);
        EXPECT_EQ(sd_afr_delay_resume(&next, 0.012f, &bad), SD_ERR_CONFIG);
        EXPECT_EQ(std::memcmp(&before, &next.learned, sizeof before), 0) << "untouched";
    }
    // Nothing learned, or nothing kept: the calibration's own word stands.
    ASSERT_EQ(sd_afr_delay_init(&b.kernel, &other), SD_OK);
    sd_afr_delay_keep(&b.kernel, 0.01f, &kept);
    const sd_afr_kept_t none{};
    for (const sd_afr_kept_t *file : std::initializer_list<const sd_afr_kept_t *>{&kept, &none}) {
        ASSERT_EQ(sd_afr_delay_init(&next, &other), SD_OK);
        ASSERT_EQ(sd_afr_delay_resume(&next, 0.02f, file), SD_OK);
        EXPECT_EQ(next.learned.late_s, 0);
        EXPECT_FLOAT_EQ(next.learned.late_sd_s, 0.01f);
    }
}

/// Without trims a delay is another pattern of the cylinders.
TEST(AfrDelay, CylindersThatDifferTeachNothing) {
    Bench b({90, 0, 0.005, 1, {0.06, -0.03, -0.08, 0.09}});
    for (int k = 0; k < 700; ++k) EXPECT_FALSE(b.cycle({}));
    EXPECT_EQ(b.kernel.learned.late_s, 0);
    EXPECT_FLOAT_EQ(b.kernel.learned.late_sd_s, 0.01f);
}

TEST(AfrDelay, ASensorThatDoesNotAnswerTeachesNothing) {
    for (double broken : {0.47, double(NAN), 1e30}) {
        Bench b({30});
        EXPECT_FALSE(b.probe(broken)) << broken;
        EXPECT_EQ(b.kernel.learned.late_s, 0);
        EXPECT_LT(b.cycles, 650) << "it ends by itself";
        EXPECT_EQ(sd_afr_delay_probe_trim(&b.kernel, 0), 0);
        EXPECT_TRUE(b.probe()) << "and needs no restart";
    }
}

TEST(AfrDelay, WhatIsNotSteadyOrNotFiniteDoesNotCount) {
    Bench b({60});
    sd_afr_delay_probe(&b.kernel, true);
    float told[4] = {0.05f, NAN, 0, 0};
    for (int k = 0; k < 100; ++k) {
        const double sign = k / 12 % 2 ? -1 : 1;
        EXPECT_FALSE(b.cycle({0.05 * sign, -0.05 * sign / 3, -0.05 * sign / 3, -0.05 * sign / 3}, false));
        const sd_afr_trims_t bad{k % 2 ? NAN : float(kRadps), told, 0.5f, 1};
        EXPECT_FALSE(sd_afr_delay_cycle(&b.kernel, &bad));
    }
    EXPECT_EQ(b.kernel.learned.late_s, 0);
    sd_afr_delay_restart(&b.kernel);
    EXPECT_EQ(sd_afr_delay_probe_trim(&b.kernel, 0), 0) << "the angle is lost: the trim is taken back";
    EXPECT_TRUE(b.probe());
    EXPECT_LT(std::abs(b.error_deg()), 8);
}

/// Both lags as complex numbers, their errors drawn by a finite difference.
TEST(AfrDelay, DoubtIsHowFarTheHalfOrderMoves) {
    const auto answer = [](double lag, double late_s) {
        const std::complex<double> jw(0, kRadps / 2);
        return std::exp(-jw * late_s) / ((1.0 + jw * kTau1_s * (1 + lag)) * (1.0 + jw * kTau2_s * (1 + lag)));
    };
    const double small = 1e-4, by_lag = std::abs(answer(small, 0) / answer(0, 0) - 1.0) / small,
                 by_delay = std::abs(answer(0, small) / answer(0, 0) - 1.0) / small;
    for (const sd_afr_learned_t &known : {sd_afr_learned_t{0, 0, 0, 0.1f}, {0, 0.001f, 0, 0}, {0.01f, 0.002f, 0.1f, 0.2f}})
        EXPECT_NEAR(double(sd_afr_delay_doubt(&known, float(kRadps), float(kTau1_s), float(kTau2_s))),
                    std::pow(by_lag * double(known.lag_sd), 2) + std::pow(by_delay * double(known.late_sd_s), 2), 1e-3);
}

TEST(AfrDelay, ProbesLeaveTheMeanAlone) {
    Bench b({});
    sd_afr_delay_probe(&b.kernel, true);
    for (int k = 0; k < 40; ++k) {
        double sum = 0;
        for (std::uint32_t i = 0; i < 4; ++i) sum += double(sd_afr_delay_probe_trim(&b.kernel, i));
        EXPECT_NEAR(sum, 0, 1e-6);
        EXPECT_EQ(std::abs(sd_afr_delay_probe_trim(&b.kernel, 0)), 1);
        b.cycle({});
    }
    sd_afr_delay_probe(&b.kernel, false);
    EXPECT_EQ(sd_afr_delay_probe_trim(&b.kernel, 0), 0);
}

TEST(AfrDelay, RefusesWhatIsOutOfRange) {
    const sd_afr_delay_config_t good{kPositions, 4, 0.03f, 0.015f};
    sd_afr_delay_t d;
    ASSERT_EQ(sd_afr_delay_init(&d, &good), SD_OK);
    for (int field = 0; field < 4; ++field) {
        sd_afr_delay_config_t bad = good;
        if (field == 0) bad.cycle_positions = 12;
        if (field == 1) bad.cylinders = 1;
        if (field == 2) bad.tau1_s = NAN;
        if (field == 3) bad.tau2_s = 2;
        EXPECT_EQ(sd_afr_delay_init(&d, &bad), SD_ERR_CONFIG) << field;
    }
    EXPECT_FLOAT_EQ(d.learned.late_sd_s, 0.01f) << "untouched";
}

} // namespace
