// SPDX-License-Identifier: MIT
// The observers of document 000 against their differential equations, integrated finely in double by this file.
#include <cmath>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <vector>

#include "design/misfire/switched_design.hpp"
extern "C" {
#include "sd_switched.h"
}

using namespace sixdeg;

namespace {

constexpr double kTickHz = 1e8, kSpeedBase = 20, kAccelBase = 1000, kJerkBase = 1e5;
constexpr CrankModel kModel{900, 20};
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct F32 {
    using State = sd_switched_f32_t;
    using Number = float;
    static constexpr auto init = sd_switched_init_f32;
    static constexpr auto start = sd_switched_start_f32;
    static constexpr auto step = sd_switched_step_f32;
    static constexpr auto read = sd_switched_read_f32;
    static constexpr auto in = sd_from_float_f32;
    static constexpr auto out = sd_to_float_f32;
};
struct Q31 {
    using State = sd_switched_q31_t;
    using Number = sd_q31_t;
    static constexpr auto init = sd_switched_init_q31;
    static constexpr auto start = sd_switched_start_q31;
    static constexpr auto step = sd_switched_step_q31;
    static constexpr auto read = sd_switched_read_q31;
    static constexpr auto in = sd_from_float_q31;
    static constexpr auto out = sd_to_float_q31;
};

enum class Kind { roo, fosmo, folsmo };
constexpr double kRoo = 13.3, kLuenberger = 1000, kRho = 40;

struct Configured {
    std::vector<sd_plant_step_t> steps;
    sd_switched_config_t config{};

    Configured(Kind kind, const std::vector<double> &periods_s, double rho = kRho) {
        for (double t : periods_s)
            steps.push_back(kind == Kind::roo ? roo_step(kModel, kRoo, t, kTickHz)
                                              : folsmo_step(kModel, kind == Kind::folsmo ? kLuenberger : 0, t, kTickHz));
        config.steps = steps.data();
        config.step_count = std::uint8_t(steps.size());
        config.output_gain_per_s = kind == Kind::roo ? float(kRoo) : 0;
        config.sliding_gain_mps3 = kind == Kind::roo ? 0 : float(rho);
        config.speed_base_mps = float(kSpeedBase);
        config.accel_base_mps2 = float(kAccelBase);
        config.jerk_base_mps3 = float(kJerkBase);
        config.settle_steps = 100;
    }
};

template <class V> typename V::State started(const Configured &setup, double y, double speed, double accel) {
    typename V::State s;
    EXPECT_EQ(SD_OK, V::init(&s, &setup.config));
    V::start(&s, V::in(float(y / kSpeedBase)), V::in(float(speed / kSpeedBase)), V::in(float(accel / kAccelBase)));
    return s;
}

template <class V> double step(typename V::State &s, double period_s, double y, double u) {
    const auto ticks = std::uint32_t(std::lround(period_s * kTickHz));
    return double(V::out(V::step(&s, ticks, V::in(float(y / kSpeedBase)), V::in(float(u / kJerkBase))))) * kAccelBase;
}

/// Something smooth to observe: y is any signal, u any input; the observer's equation says what follows.
double signal(double t) { return 2 + std::sin(60 * t) + 0.3 * std::cos(200 * t); }
double input(double t) { return 4000 * (1 + std::sin(150 * t)); }

/// The observer of `kind` in continuous time, rho smoothed away (0): fine Runge-Kutta.
struct Reference {
    Kind kind;
    double x1, x2;

    std::pair<double, double> slope(double a, double b, double t) const {
        const double k1 = kModel.k1_per_s2, k2 = kModel.k2_per_s;
        if (kind == Kind::roo) return {0, -(k2 + kRoo) * b - (k1 + kRoo * (k2 + kRoo)) * signal(t) + input(t)};
        const double pull = kind == Kind::folsmo ? kLuenberger * (signal(t) - a) : 0;
        return {b, -k2 * b - k1 * a + input(t) + pull};
    }
    void advance(double from, double to) {
        const int n = 20;
        const double h = (to - from) / n;
        for (int i = 0; i < n; ++i) {
            const double t = from + i * h;
            const auto a = slope(x1, x2, t), b = slope(x1 + h / 2 * a.first, x2 + h / 2 * a.second, t + h / 2),
                       c = slope(x1 + h / 2 * b.first, x2 + h / 2 * b.second, t + h / 2),
                       d = slope(x1 + h * c.first, x2 + h * c.second, t + h);
            x1 += h / 6 * (a.first + 2 * b.first + 2 * c.first + d.first);
            x2 += h / 6 * (a.second + 2 * b.second + 2 * c.second + d.second);
        }
    }
    double accel(double t) const { return kind == Kind::roo ? x2 + kRoo * signal(t) : x2; }
};

double mean_input(double from, double to) { return 4000 * (1 + (std::cos(150 * from) - std::cos(150 * to)) / (150 * (to - from))); }

/// Largest difference from the equation over a second, m/s^2, with step lengths `period(k)`.
template <class V> double worst_error(Kind kind, const std::vector<double> &table, const std::function<double(int)> &period) {
    const Configured setup(kind, table, 0);
    auto s = started<V>(setup, signal(0), 2.5, 10);
    Reference reference{kind, 2.5, kind == Kind::roo ? 10 - kRoo * signal(0) : 10};
    double t = 0, worst = 0;
    for (int k = 0; t < 1; ++k) {
        const double dt = std::round(period(k) * kTickHz) / kTickHz, next = t + dt;
        const double got = step<V>(s, dt, signal(next), mean_input(t, next));
        reference.advance(t, next);
        t = next;
        worst = std::fmax(worst, std::fabs(got - reference.accel(t)));
    }
    return worst;
}

template <class V> struct Switched : ::testing::Test {};
using Variants = ::testing::Types<F32, Q31>;
TYPED_TEST_SUITE(Switched, Variants);

TYPED_TEST(Switched, StepsAreExactInTime) { // accelerations reach 100 m/s^2
    for (Kind kind : {Kind::roo, Kind::fosmo, Kind::folsmo})
        EXPECT_LT(worst_error<TypeParam>(kind, {1e-4}, [](int) { return 1e-4; }), 0.02) << int(kind);
}

TYPED_TEST(Switched, StepsFollowTheToothWithATableOfPeriods) {
    const std::vector<double> table{0.8e-3, 1e-3, 1.25e-3, 1.6e-3, 2.2e-3, 3e-3};
    for (Kind kind : {Kind::roo, Kind::fosmo, Kind::folsmo})
        EXPECT_LT(worst_error<TypeParam>(kind, table, [](int k) { return (k % 58 == 57 ? 2.7e-3 : 0.9e-3) * (1 + 0.1 * std::sin(k * 0.11)); }), 1.5)
            << int(kind);
}

/// The true plant under a constant input, from rest; an observer that starts wrong must arrive.
TYPED_TEST(Switched, ConvergesToThePlantFromAWrongStart) {
    for (Kind kind : {Kind::roo, Kind::fosmo, Kind::folsmo}) {
        const Configured setup(kind, {1e-4});
        auto s = started<TypeParam>(setup, 0, 0.3, 20);
        const double w = std::sqrt(900 - 100.0);
        double error_at_start = 0, error = 0;
        for (int k = 1; k <= 10000; ++k) {
            const double t = k * 1e-4, decay = std::exp(-10 * t);
            const double v1 = 4 * (1 - decay * (std::cos(w * t) + 10 / w * std::sin(w * t))), v2 = 3600 / w * decay * std::sin(w * t);
            error = std::fabs(step<TypeParam>(s, 1e-4, v1, 3600) - v2);
            if (k == 1) error_at_start = error;
        }
        EXPECT_GT(error_at_start, 15);
        EXPECT_LT(error, 0.3) << int(kind); // FOSMO and FOLSMO chatter by rho and the sampling time
        sd_switched_estimate_t e;
        TypeParam::read(&s, &e);
        EXPECT_EQ(SD_VALID, e.status.health);
        EXPECT_NEAR(4, e.speed_mps, 0.01);
        EXPECT_LT(std::fabs(e.status.innovation), 0.01f);
    }
}

/// Averaged over its chatter, rho sgn(e1) is the input nobody told of: with rho above it, e1 stays small.
TYPED_TEST(Switched, SlidingTermTakesUpAnUnknownConstantInput) {
    for (const auto &[rho, arrives] : {std::pair{600.0, true}, std::pair{200.0, false}}) {
        const Configured setup(Kind::fosmo, {1e-4}, rho);
        auto s = started<TypeParam>(setup, 3600.0 / 900, 3600.0 / 900, 0);
        for (int k = 0; k < 20000; ++k) step<TypeParam>(s, 1e-4, 3600.0 / 900, 3600 - 400);
        sd_switched_estimate_t e;
        TypeParam::read(&s, &e);
        EXPECT_EQ(arrives, std::fabs(e.status.innovation) < 0.02f) << rho << ": " << e.status.innovation;
    }
}

TYPED_TEST(Switched, BadSamplesAreReplacedCountedAndEndInvalid) {
    const Configured setup(Kind::folsmo, {1e-4});
    auto s = started<TypeParam>(setup, 1, 1, 0);
    sd_switched_estimate_t e;
    for (int k = 0; k < 200; ++k) step<TypeParam>(s, 1e-4, 1, 900);
    TypeParam::read(&s, &e);
    EXPECT_EQ(SD_VALID, e.status.health);
    for (int k = 1; k <= 12; ++k) {
        EXPECT_TRUE(std::isfinite(step<TypeParam>(s, 1e-4, -1000, 900)));
        TypeParam::read(&s, &e);
        EXPECT_EQ(SD_DEGRADED, e.status.health);
        EXPECT_EQ(k, e.status.rejected);
        EXPECT_NEAR(1, e.speed_mps, 0.05);
    }
    EXPECT_EQ(0, step<TypeParam>(s, 1e-4, -1000, 900));
    TypeParam::read(&s, &e);
    EXPECT_EQ(SD_INVALID, e.status.health);
    for (int k = 0; k < 200; ++k) step<TypeParam>(s, 1e-4, 1, 900);
    TypeParam::read(&s, &e);
    EXPECT_EQ(SD_VALID, e.status.health) << "recovers by itself";
}

TYPED_TEST(Switched, APeriodOutsideItsTableStopsIt) {
    const Configured setup(Kind::folsmo, {1e-3, 2e-3});
    for (double period : {0.9e-3, 2.1e-3, 0.0}) {
        auto s = started<TypeParam>(setup, 1, 1, 0);
        step<TypeParam>(s, 1.5e-3, 1, 900);
        sd_switched_estimate_t e;
        TypeParam::read(&s, &e);
        EXPECT_EQ(SD_DEGRADED, e.status.health);
        EXPECT_EQ(0, step<TypeParam>(s, period, 1, 900));
        TypeParam::read(&s, &e);
        EXPECT_EQ(SD_INVALID, e.status.health);
    }
}

TYPED_TEST(Switched, InitRefusesWhatIsOutOfRange) {
    const auto refused = [](const std::function<void(Configured &)> &spoil) {
        Configured setup(Kind::folsmo, {1e-3, 2e-3});
        spoil(setup);
        typename TypeParam::State s{};
        s.steps = 77;
        const bool result = TypeParam::init(&s, &setup.config) == SD_ERR_CONFIG && s.steps == 77;
        return result;
    };
    EXPECT_FALSE(refused([](Configured &) {}));
    for (float bad : {kNan, 0.0f, -1.0f, std::numeric_limits<float>::infinity()}) {
        EXPECT_TRUE(refused([&](Configured &s) { s.config.speed_base_mps = bad; }));
        EXPECT_TRUE(refused([&](Configured &s) { s.config.accel_base_mps2 = bad; }));
        EXPECT_TRUE(refused([&](Configured &s) { s.config.jerk_base_mps3 = bad; }));
    }
    for (float bad : {kNan, -1.0f, std::numeric_limits<float>::infinity()}) {
        EXPECT_TRUE(refused([&](Configured &s) { s.config.sliding_gain_mps3 = bad; }));
        EXPECT_TRUE(refused([&](Configured &s) { s.config.output_gain_per_s = bad; }));
    }
    for (int at = 0; at < 2; ++at) {
        EXPECT_TRUE(refused([&](Configured &s) { s.steps[1].increment[at][1 - at] = kNan; }));
        EXPECT_TRUE(refused([&](Configured &s) { s.steps[0].from_input[at] = kNan; }));
        EXPECT_TRUE(refused([&](Configured &s) { s.steps[0].from_output[at] = 1e8f; }));
    }
    EXPECT_TRUE(refused([](Configured &s) { s.steps[1].period_ticks = s.steps[0].period_ticks; }));
    EXPECT_TRUE(refused([](Configured &s) { s.config.step_count = 0; }));
    EXPECT_TRUE(refused([](Configured &s) { s.config.step_count = SD_PLANT_STEPS_MAX + 1; }));
}

TEST(SwitchedF32, SurvivesEveryFloat) {
    for (Kind kind : {Kind::roo, Kind::folsmo}) {
        const Configured setup(kind, {1e-3, 2e-3});
        sd_switched_f32_t s;
        ASSERT_EQ(SD_OK, sd_switched_init_f32(&s, &setup.config));
        std::uint32_t x = 1;
        for (int k = 0; k < 200000; ++k) {
            float in[2];
            for (float &f : in) {
                x = x * 1664525u + 1013904223u;
                std::memcpy(&f, &x, sizeof f);
                if (x & 64u) f = float(x >> 8) / float(1u << 23) - 1;
            }
            ASSERT_LT(std::fabs(sd_switched_step_f32(&s, 100000 + (x >> 15), in[0], in[1])), 1.0f);
        }
    }
}

TEST(SwitchedDuality, Q31TracksF32OverARoughTrace) {
    for (Kind kind : {Kind::roo, Kind::fosmo, Kind::folsmo}) {
        const Configured setup(kind, {1e-4}, 0); // sgn of a rounding difference is a difference of 2 rho: see sixdeg study observers
        auto a = started<F32>(setup, 0, 0, 0);
        auto b = started<Q31>(setup, 0, 0, 0);
        double worst = 0, largest = 0, y = 0;
        std::uint32_t x = 7;
        for (int k = 0; k < 100000; ++k) {
            x = x * 1664525u + 1013904223u;
            y += 2e-3 * (double(x >> 8) / (1 << 23) - 1) - 1e-4 * y;
            const double u = (k / 300 % 4) ? 0 : 1.5e4, fa = step<F32>(a, 1e-4, y, u), fb = step<Q31>(b, 1e-4, y, u);
            worst = std::fmax(worst, std::fabs(fa - fb));
            largest = std::fmax(largest, std::fabs(fa));
        }
        EXPECT_LT(worst, 1e-4 * kAccelBase) << int(kind);
        EXPECT_GT(largest, 0.05 * kAccelBase) << int(kind);
    }
}

} // namespace
