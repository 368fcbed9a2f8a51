// SPDX-License-Identifier: MIT
// The adaptive Fourier torque observer: every claim of sd_fourier.h on both number types, against a torque in closed
// form whose tooth times the test integrates itself, and against pole placement, the observer document 004 compares with.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <random>

#include "support/fourier_bench.hpp"
extern "C" {
#include "sd_punctual.h"
}

using namespace sixdeg::test;

namespace {

struct Run {
    int cycles_to_tenth_of_start = 0; ///< Until the error stays below a tenth of the error at the start.
    int cycles_to_tenth_of_peak = 0;  ///< Until it stays below a tenth of the signal's peak to peak.
    double rms_of_peak = 0;           ///< Settled error against the projection on n_h harmonics / peak to peak.
    double lag = 0;                   ///< deg, of the settled estimate behind the true torque.
};

/// Runs the observer over `cycles`; `timer_hz` quantises the tooth times.
template <class V> Run run(const TorqueSignal &signal, const Gains &gains, double timer_hz, int cycles = 40) {
    const Bench setup(gains, signal);
    typename V::State s;
    EXPECT_EQ(SD_OK, V::init(&s, &setup.config, &setup.tables));
    const auto times = signal.tooth_times(kN, kCycle * cycles);
    const auto ticks = [&](int k) { return std::llround(std::round(times[std::size_t(k)] * timer_hz) * (kTickHz / timer_hz)); };
    const auto projection = signal.harmonics(gains.harmonics);
    const double peak = signal.peak_to_peak();
    const double start = rms_difference(std::vector<double>(projection.size(), 0.0), projection);
    Run result;
    std::vector<double> mean(projection.size(), 0.0);
    double settled = 0;
    int last = 0, samples = 0;
    for (int cycle = 0; cycle < cycles; ++cycle) {
        double sum = 0;
        int teeth = 0;
        for (int k = cycle * kCycle + 1; k <= (cycle + 1) * kCycle; ++k) {
            if (missing(k)) continue;
            const float torque = V::step(&s, &setup.tables, unsigned(k % kCycle), unsigned(k - last), unsigned(ticks(k) - ticks(last)), 1);
            last = k;
            ++teeth;
            sum += std::pow(torque - series_at(projection, kPitch * k), 2);
            if (cycle < cycles - 10) continue;
            sd_fourier_estimate_t estimate;
            V::read(&s, &estimate);
            for (std::size_t i = 0; i < mean.size(); ++i) mean[i] += double(estimate.coefficient_nm[i]);
            settled += std::pow(torque - series_at(projection, kPitch * k), 2);
            ++samples;
        }
        const double rms = std::sqrt(sum / teeth);
        if (rms > 0.1 * start) result.cycles_to_tenth_of_start = cycle + 1;
        if (rms > 0.1 * peak) result.cycles_to_tenth_of_peak = cycle + 1;
    }
    for (double &m : mean) m /= samples;
    result.rms_of_peak = std::sqrt(settled / samples) / peak;
    result.lag = lag_deg(mean, signal.harmonics(gains.harmonics));
    return result;
}

template <class V> struct Fourier : ::testing::Test {};
using Variants = ::testing::Types<F32, Q31>;
TYPED_TEST_SUITE(Fourier, Variants);

TEST(TorqueSignal, IsAsHardAsTheDesignStudys) {
    // torque-misfire study: what n_h harmonics leave out, in percent of peak to peak: 13.8, 5.7, 2.3.
    TorqueSignal signal;
    const auto floor_of = [&](int n) {
        const auto c = signal.harmonics(n);
        double sum = 0;
        for (int i = 0; i < 7200; ++i) sum += std::pow(series_at(c, i * M_PI / 1800) - signal.torque(i * M_PI / 1800), 2);
        return std::sqrt(sum / 7200) / signal.peak_to_peak();
    };
    EXPECT_GT(floor_of(5), 0.12);
    EXPECT_GT(floor_of(8), 0.045);
    EXPECT_GT(floor_of(12), 0.02);
}

TYPED_TEST(Fourier, HasNoPhaseShiftFrom1000To4500Rpm) {
    for (double rpm : {1000.0, 1500.0, 3000.0, 4500.0}) {
        TorqueSignal signal;
        signal.rpm = rpm;
        for (const Gains &gains : {kSmooth, kFast}) {
            const Run r = run<TypeParam>(signal, gains, kTickHz);
            this->RecordProperty(std::to_string(int(rpm)) + "_rpm_lag_deg", std::to_string(r.lag));
            EXPECT_LT(std::fabs(r.lag), 0.5) << rpm << " rpm";
        }
    }
}

TYPED_TEST(Fourier, SettlesFastOrSmoothOverTheSpeedRange) {
    for (double rpm : {1000.0, 1500.0, 3000.0, 4500.0}) {
        TorqueSignal signal;
        signal.rpm = rpm;
        const Run fast = run<TypeParam>(signal, kFast, kTickHz);
        EXPECT_LE(fast.cycles_to_tenth_of_start, 4) << rpm;
        EXPECT_LT(fast.rms_of_peak, 0.025) << rpm;
        const Run smooth = run<TypeParam>(signal, kSmooth, kTickHz);
        EXPECT_LE(smooth.cycles_to_tenth_of_start, 16) << rpm;
        EXPECT_LT(smooth.rms_of_peak, 0.015) << rpm;
    }
}

TYPED_TEST(Fourier, TenMicrosecondTimerAt1000RpmStillSettlesInFourCycles) {
    const Run r = run<TypeParam>(TorqueSignal{}, kSmooth, 1e5);
    EXPECT_LE(r.cycles_to_tenth_of_peak, 4);
    EXPECT_LT(r.rms_of_peak, 0.015);
}

TEST(Punctual, AnUnevenWheelGivesThePeriodsOfAnEvenOne) {
    // Capture rounds a period by less than 1; what is rounded off, 0.5 at most, goes into the next tooth: differences of differences, 2.
    constexpr double kSpeed = 314, kTicks = 1e6, kMostTicks = 3;
    std::mt19937 random(3);
    std::normal_distribution<double> pattern_deg(0, 0.2);
    std::vector<float> late(kN);
    for (float &rad : late) rad = float(pattern_deg(random) * M_PI / 180);
    const auto tick = [&](int k, double late_rad) { return std::uint32_t((k * kPitch + late_rad + 1) / kSpeed * kTicks); };
    sd_punctual_t self{};
    int last = 0;
    std::int64_t moved = 0;
    for (int k = 1; k < 100 * kN; ++k) {
        if (missing(k)) continue;
        const std::uint32_t period = tick(k, double(late[std::size_t(k % kN)])) - tick(last, double(late[std::size_t(last % kN)]));
        const std::uint32_t even =
            sd_punctual_period(&self, period, std::uint32_t(k - last), late[std::size_t(k % kN)], float(kN / (2 * M_PI)));
        if (last > 0) { // the first period knows one of its ends
            EXPECT_NEAR(even, (k - last) * kPitch / kSpeed * kTicks, kMostTicks) << k;
            moved += even;
        }
        last = k;
    }
    EXPECT_NEAR(double(moved), (last - 1) * kPitch / kSpeed * kTicks, kMostTicks); // whatever is rounded comes back at the next tooth
}

// 0.3 of a tick in each of 29 teeth, the other way in the next: rounded tooth by tooth that would be nothing.
TEST(Punctual, LessThanATickIsCorrectedOverSomeTeeth) {
    sd_punctual_t self{};
    double first = 0, second = 0;
    for (int k = 1; k < 40 * kN; ++k) {
        const bool early = k % kN < kN / 2;
        sd_punctual_period(&self, 1000, 1, (early ? 0.3f : -0.3f) * float(kPitch) / 1000, float(kN / (2 * M_PI)));
        if (k >= kN) (early ? first : second) += self.late_ticks / (39.0 * kN / 2);
    }
    EXPECT_NEAR(first, 0.3, 0.05);
    EXPECT_NEAR(second, -0.3, 0.05);
}

TEST(Punctual, WhatIsNoTurningStaysAsItIs) {
    sd_punctual_t self{};
    for (float late : {NAN, 0.06f, -INFINITY}) EXPECT_EQ(sd_punctual_period(&self, 1000, 1, late, 9.5f), 1000u);
    EXPECT_EQ(sd_punctual_period(&self, UINT32_MAX, 1, 0.01f, 9.5f), UINT32_MAX);
    EXPECT_EQ(sd_punctual_period(&self, 0, 1, 0.01f, 9.5f), 0u); // there is none
    EXPECT_EQ(self.late_ticks, 0);
    EXPECT_EQ(sd_punctual_period(&self, 1000, 0, 0.01f, 9.5f), 1000u); // no tooth of any wheel
    self.late_ticks = -100;
    EXPECT_EQ(sd_punctual_period(&self, 3, 1, 0.01f, 9.5f), 3u); // would stand before the last one: the times begin anew
    EXPECT_EQ(self.late_ticks, 0);
    self.left_ticks = 0.4f;
    EXPECT_EQ(sd_punctual_period(&self, 1, 1, 0.04f, 9.5f), 1u); // never a period of 0, whatever is rounded
}

/// phi' = T - 2 p e, T' = -p^2 e, e = phi - E, in continuous angle between teeth: what document 004 calls pole
/// placement. p = 6 / rad settles within a firing interval, the quickest that a 10 us timer allows.
TEST(PolePlacement, LagsByEighteenDegreesWhereTheFourierObserverDoesNot) {
    const TorqueSignal signal;
    const double p = 6;
    const auto times = signal.tooth_times(kN, kCycle * 10);
    double phi = 0, torque = 0;
    std::vector<double> c(2 * 16 + 1, 0.0);
    for (int k = 1; k <= kCycle * 10; ++k) {
        const double middle = kPitch * (k - 0.5), speed = kPitch / (times[std::size_t(k)] - times[std::size_t(k - 1)]);
        const double energy = 0.5 * signal.inertia(middle) * speed * speed;
        if (k == 1) phi = energy;
        for (int s = 0; s < 50; ++s) {
            const double e = phi - energy;
            phi += kPitch / 50 * (torque - 2 * p * e);
            torque -= kPitch / 50 * p * p * e;
        }
        if (k <= kCycle * 9) continue;
        for (int i = 1; i <= 16; ++i) {
            c[std::size_t(2 * i - 1)] += torque * std::cos(i * kPitch * k / 2) / kN;
            c[std::size_t(2 * i)] += torque * std::sin(i * kPitch * k / 2) / kN;
        }
    }
    const double lag = lag_deg(c, signal.harmonics(16));
    RecordProperty("lag_deg", std::to_string(lag));
    EXPECT_GT(lag, 15);
    EXPECT_LT(lag, 23);
}

TYPED_TEST(Fourier, InitRefusesGainsBeyondTheRule) {
    Bench setup(kSmooth);
    const float limit = sd_fourier_gain_limit(&setup.config);
    typename TypeParam::State s;
    setup.config.gain_reference = 0.98f * limit;
    EXPECT_EQ(SD_OK, TypeParam::init(&s, &setup.config, &setup.tables));
    setup.config.gain_reference = 1.02f * limit;
    EXPECT_EQ(SD_ERR_CONFIG, TypeParam::init(&s, &setup.config, &setup.tables));
}

TYPED_TEST(Fourier, InitRefusesEveryFieldThatIsNotFinite) {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    for (float sd_fourier_config_t::*field :
         {&sd_fourier_config_t::gain_energy, &sd_fourier_config_t::gain_mean, &sd_fourier_config_t::gain_reference,
          &sd_fourier_config_t::reject_energy, &sd_fourier_config_t::tick_hz, &sd_fourier_config_t::speed_base_radps,
          &sd_fourier_config_t::torque_base_nm}) {
        for (float bad : {nan, 0.0f, -1.0f, std::numeric_limits<float>::infinity()}) {
            Bench setup(kSmooth);
            setup.config.*field = bad;
            typename TypeParam::State s;
            s.steps = 77;
            EXPECT_EQ(SD_ERR_CONFIG, TypeParam::init(&s, &setup.config, &setup.tables));
            EXPECT_EQ(77, s.steps) << "state touched";
        }
    }
    Bench setup(kSmooth);
    typename TypeParam::State s;
    setup.tables.inertia_q31[7] = 0;
    EXPECT_EQ(SD_ERR_CONFIG, TypeParam::init(&s, &setup.config, &setup.tables));
    setup = Bench(kSmooth);
    setup.tables.sine_q31[30] = INT32_MIN / 2;
    EXPECT_EQ(SD_ERR_CONFIG, TypeParam::init(&s, &setup.config, &setup.tables)) << "not on a circle";
    setup = Bench(kSmooth);
    for (float bad : {nan, 0.0f, 10.1f}) {
        setup.tables.inertia_base_kgm2 = bad;
        EXPECT_EQ(SD_ERR_CONFIG, TypeParam::init(&s, &setup.config, &setup.tables));
    }
}

TYPED_TEST(Fourier, ReportsConvergenceAndRejectsAnOutlierWithoutMovingTheEstimate) {
    TorqueSignal signal;
    Bench setup(kSmooth, signal);
    setup.config.reject_energy = 0.2f;
    typename TypeParam::State s;
    ASSERT_EQ(SD_OK, TypeParam::init(&s, &setup.config, &setup.tables));
    sd_fourier_estimate_t e;
    TypeParam::read(&s, &e);
    EXPECT_EQ(SD_INVALID, e.status.health);
    const auto times = signal.tooth_times(kN, kCycle * 10);
    int last = 0;
    for (int k = 1; k <= kCycle * 10; ++k) {
        if (missing(k)) continue;
        TypeParam::step(&s, &setup.tables, unsigned(k % kCycle), unsigned(k - last),
                        unsigned(std::llround((times[std::size_t(k)] - times[std::size_t(last)]) * kTickHz)), 1);
        last = k;
        TypeParam::read(&s, &e);
        EXPECT_EQ(k < 464 + 16 ? SD_DEGRADED : SD_VALID, e.status.health) << k;
    }
    const float before = TypeParam::torque_at(&s, &setup.tables, 33);
    const unsigned period = unsigned(std::llround((times[1100] - times[1099]) * kTickHz));
    TypeParam::step(&s, &setup.tables, 1, 1, period * 2, 1);
    TypeParam::read(&s, &e);
    EXPECT_EQ(SD_DEGRADED, e.status.health);
    EXPECT_EQ(SD_WHY_REJECTED, e.status.why);
    EXPECT_GT(e.status.test_ratio, 1.0f);
    EXPECT_EQ(1, e.status.rejected);
    EXPECT_EQ(before, TypeParam::torque_at(&s, &setup.tables, 33));
}

TYPED_TEST(Fourier, SurvivesEveryTickCountAndPosition) {
    Bench setup(kSmooth);
    typename TypeParam::State s;
    ASSERT_EQ(SD_OK, TypeParam::init(&s, &setup.config, &setup.tables));
    std::uint32_t x = 1;
    for (int k = 0; k < 200000; ++k) {
        x = x * 1664525u + 1013904223u;
        const std::uint32_t period = (x >> 30) == 0 ? 0 : (x >> (x & 31u));
        const float torque = TypeParam::step(&s, &setup.tables, (x >> 8) % 130, (x >> 4) % 9, period, std::uint8_t(x >> 31));
        ASSERT_TRUE(std::isfinite(torque)) << k;
        ASSERT_LE(std::fabs(torque), 1500.0f) << k;
    }
    sd_fourier_estimate_t e;
    TypeParam::read(&s, &e);
    for (float c : e.coefficient_nm) EXPECT_TRUE(std::isfinite(c));
    EXPECT_EQ(0.0f, TypeParam::torque_at(&s, &setup.tables, kCycle));
}

TYPED_TEST(Fourier, ShiftByARevolutionMovesTheWaveformByARevolution) {
    TorqueSignal signal;
    const Bench setup(kFine, signal);
    typename TypeParam::State s;
    ASSERT_EQ(SD_OK, TypeParam::init(&s, &setup.config, &setup.tables));
    const auto times = signal.tooth_times(kN, kCycle * 6);
    for (int k = 1; k <= kCycle * 6; ++k) {
        TypeParam::step(&s, &setup.tables, unsigned(k % kCycle), 1,
                        unsigned(std::llround((times[std::size_t(k)] - times[std::size_t(k - 1)]) * kTickHz)), 1);
    }
    float before[kCycle], largest_change = 0;
    for (unsigned k = 0; k < kCycle; ++k) before[k] = TypeParam::torque_at(&s, &setup.tables, k);
    TypeParam::shift(&s);
    for (unsigned k = 0; k < kCycle; ++k) {
        EXPECT_NEAR(before[k], TypeParam::torque_at(&s, &setup.tables, (k + kN) % kCycle), 1e-3);
        largest_change = std::fmax(largest_change, std::fabs(before[k] - TypeParam::torque_at(&s, &setup.tables, k)));
    }
    EXPECT_GT(largest_change, 10) << "cylinders 1 and 4 differ by 30 %, so a shift must show";
}

TEST(FourierDuality, Q31TracksF32OverARoughTrace) {
    const Bench setup(kFine);
    sd_fourier_f32_t a;
    sd_fourier_q31_t b;
    ASSERT_EQ(SD_OK, sd_fourier_init_f32(&a, &setup.config, &setup.tables));
    ASSERT_EQ(SD_OK, sd_fourier_init_q31(&b, &setup.config, &setup.tables));
    double worst = 0, largest = 0;
    std::uint32_t x = 7;
    for (int k = 1; k < 40000; ++k) {
        x = x * 1664525u + 1013904223u;
        const double rpm = 2500 + 1500 * std::sin(k * 1e-3) + 25 * std::sin(k * kPitch * 2) + 2 * (double(x >> 8) / (1 << 24) - 0.5);
        const unsigned period = unsigned(std::llround(kPitch / (rpm * M_PI / 30) * kTickHz));
        const float ta = sd_fourier_step_f32(&a, &setup.tables, unsigned(k % kCycle), 1, period, 1);
        const float tb = sd_fourier_step_q31(&b, &setup.tables, unsigned(k % kCycle), 1, period, 1);
        worst = std::fmax(worst, std::fabs(double(ta - tb)));
        largest = std::fmax(largest, std::fabs(double(ta)));
    }
    RecordProperty("worst_nm", std::to_string(worst));
    EXPECT_LT(worst, 0.001 * 1500) << "0.1 % of full scale, Nm";
    EXPECT_GT(largest, 500) << "a trace that moves nothing proves nothing";
    EXPECT_LT(largest, 1450) << "and one at the end of the range restarts both";
}

} // namespace
