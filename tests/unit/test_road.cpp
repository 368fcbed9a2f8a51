// SPDX-License-Identifier: MIT
// Which of two filters to believe: made pairs of estimates, and both filters on teeth of a crank whose load moves.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/kalman_bench.hpp"
extern "C" {
#include "sd_road.h"
}

using namespace sixdeg;
using namespace sixdeg::test;

namespace {

constexpr float kNoiseNm = 3, kTorqueNm = 60;

/// Estimates of four firings in turn: the rough filter's noise is its own, the smooth one errs by `error` beside.
struct Pair {
    sd_road_t road{};
    std::mt19937 random{1};
    std::normal_distribution<double> normal;
    int k = 0;
    bool go(double error, double truth = kTorqueNm) {
        sd_firing_t smooth{}, rough{};
        smooth.index = rough.index = std::uint8_t(k++ % 4);
        smooth.torque_nm = float(truth + error);
        rough.torque_nm = float(truth + kNoiseNm * normal(random));
        rough.mean_nm = kTorqueNm, rough.noise_nm = kNoiseNm;
        return sd_road_step(&road, &smooth, &rough);
    }
};

TEST(Road, ASmoothOneIsNeverRough) {
    Pair pair;
    for (int i = 0; i < 100000; ++i) ASSERT_FALSE(pair.go(1.5)) << i << ": what never changes is the pulse's shape";
}

TEST(Road, ARoughOneIsNoticedWithinFourCyclesAndForgottenWithinTwenty) {
    Pair pair;
    const auto until = [&](bool rough, double size) {
        int n = 0;
        while (n < 1000 && pair.go(size * pair.normal(pair.random)) != rough) ++n;
        return n;
    };
    for (int i = 0; i < 400; ++i) pair.go(0);
    EXPECT_LE(until(true, 60), 16) << "firings";
    for (int i = 0; i < 4000; ++i) ASSERT_TRUE(pair.go(60 * pair.normal(pair.random))) << "it does not flicker";
    EXPECT_LE(until(false, 0), 80);
}

TEST(Road, MisfiresAreNoRoad) {
    // Where a firing fails, the filters disagree for it, for its neighbours, and when it burns again: as far as can count.
    for (int one_in : {40, 20}) {
        Pair pair;
        for (int i = 0; i < 40000; ++i) {
            const int since = i % one_in;
            ASSERT_FALSE(pair.go(since == 0 ? 1000 : since == 4 ? -500 : 0)) << one_in << " " << i;
        }
    }
}

TEST(Road, NoNumberAndNoFiringChangeNothing) {
    Pair pair;
    for (int i = 0; i < 50; ++i) pair.go(0);
    const sd_road_t before = pair.road;
    sd_firing_t a{}, b{};
    a.torque_nm = 60, b = a, b.noise_nm = 3, b.mean_nm = 60;
    const auto same = [&](sd_firing_t x, sd_firing_t y) {
        sd_road_step(&pair.road, &x, &y);
        return pair.road.evidence == before.evidence && pair.road.seen == before.seen &&
               pair.road.difference_nm[0] == before.difference_nm[0];
    };
    const auto with = [](sd_firing_t f, float sd_firing_t::*field, float value) { return f.*field = value, f; };
    for (float bad : {NAN, INFINITY, -INFINITY}) {
        EXPECT_TRUE(same(with(a, &sd_firing_t::torque_nm, bad), b));
        EXPECT_TRUE(same(a, with(b, &sd_firing_t::torque_nm, bad)));
        EXPECT_TRUE(same(a, with(b, &sd_firing_t::noise_nm, bad)));
        EXPECT_TRUE(same(a, with(b, &sd_firing_t::mean_nm, bad)));
    }
    sd_firing_t far = a, other = b;
    far.index = other.index = SD_KALMAN_FIRINGS_MAX;
    EXPECT_TRUE(same(far, other));
    other.index = 1;
    EXPECT_TRUE(same(a, other)) << "estimates of different firings";
}

/// Two sets of gains on the same teeth, with jitter: the second set is the one that lets the load move.
TEST(Road, TheSecondSetOfGainsIsNoisierAndSaysSo) {
    TorqueSignal signal;
    signal.rpm = 1000;
    double spread[2], stated[2], noise[2];
    for (std::uint8_t set : {0, 1}) {
        Bench bench(pulse_tables().tables, Edges(signal, 0.02, 0, 5), set);
        bench.run(80);
        double sum = 0, squares = 0;
        int n = 0;
        for (const Firing &firing : bench.firings) {
            if (firing.said.index != 0 || firing.cycle < 20) continue;
            sum += double(firing.said.torque_nm), squares += std::pow(double(firing.said.torque_nm), 2), ++n;
            stated[set] = double(firing.said.sd_nm);
            noise[set] = double(firing.said.noise_nm);
        }
        spread[set] = std::sqrt(squares / n - std::pow(sum / n, 2));
    }
    EXPECT_GT(spread[1], 2 * spread[0]);
    EXPECT_GT(noise[1], 2 * noise[0]);
    EXPECT_LT(noise[1], stated[1]);
    EXPECT_GT(stated[1], spread[1]) << "it states the load's walk beside, which is not there";
}

} // namespace
