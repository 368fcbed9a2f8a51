// SPDX-License-Identifier: MIT
// The event monitor on made sequences of firings, whose best possible detector is known in closed form.
#include <cmath>
#include <cstring>
#include <functional>

#include "support/misfire_stream.hpp"

using namespace sixdeg;
using namespace sixdeg::test;

namespace {

struct Rates { double detected, false_alarms; };

/// `every`: one misfire in so many, 0 none.
Rates rates(Stream &s, int healthy, int every) {
    int alarms = 0, wells = 0, found = 0, missed = 0;
    for (int i = 1; wells < healthy; ++i) {
        const bool bad = i % every == 0;
        const auto v = s.go(bad ? 0 : 1);
        if (v.inhibit) continue;
        (bad ? (v.verdict == SD_MISFIRE ? found : missed) : (v.verdict == SD_MISFIRE ? alarms : wells)) += 1;
    }
    return {double(found) / (found + missed), double(alarms) / (wells + alarms)};
}

TEST(Misfire, SingleOnesAreFoundWithTheirCylinderAndNothingElseIs) {
    Stream s;
    s.healthy(200);
    for (int i = 0; i < 20000; ++i) {
        const bool bad = i % 51 == 50;
        const int firing = int(s.k % kCylinders);
        const auto v = s.go(bad ? 0 : 1);
        ASSERT_EQ(bad ? SD_MISFIRE : SD_HEALTHY, v.verdict) << i << " index " << v.index;
        ASSERT_EQ(firing, v.firing);
        ASSERT_EQ(config().firing_order[firing], v.cylinder);
        ASSERT_EQ(SD_VALID, s.read().status.health);
    }
}

/// Noise alone: both hypotheses are normal with the same deviation, so by Neyman and Pearson the best detector is a
/// limit on the index, and its two error rates obey z_false + z_missed = d' = 1 / sd. The monitor must come near it
/// although it learns deviation and expectation itself.
TEST(Misfire, ReachesTheNeymanPearsonBoundInNoise) {
    for (double sd : {0.16, 0.25, 0.35}) {
        sd_misfire_config_t c = config();
        c.cyclic = 1e-3f;
        Stream s(3, c);
        s.cyclic = 0;
        s.noise_nm = s.stated_nm = sd * Stream::kTorque;
        s.healthy(500);
        const Rates r = rates(s, 40000, 5);
        const double z_false = RandomStream::inverse_normal(1 - std::fmax(r.false_alarms, 1e-5));
        const double z_missed = RandomStream::inverse_normal(std::fmin(r.detected, 1 - 1e-5));
        EXPECT_GT((z_false + z_missed) * sd, 0.92) << "of d' at sd " << sd;
        EXPECT_LT((z_false + z_missed) * sd, 1.06) << "better than the bound is a mistake, sd " << sd;
        // The shortage is shared in proportion.
        EXPECT_NEAR(z_false / z_missed, 3.54 / 2.58, 0.25) << sd;
    }
}

/// Unequal scatter (cyclic variation only on healthy ones): the likelihood ratio's detection rate at the monitor's own
/// rate of false alarms, by quadrature, against the monitor's.
TEST(Misfire, ComesNearTheLikelihoodRatioWithCyclicVariation) {
    const double cyclic = 0.15, noise = 0.15, sd0 = std::hypot(cyclic, noise);
    sd_misfire_config_t c = config();
    c.cyclic = float(cyclic);
    Stream s(5, c);
    s.cyclic = cyclic;
    s.noise_nm = s.stated_nm = noise * Stream::kTorque;
    s.healthy(500);
    const Rates r = rates(s, 60000, 4); // one cylinder, each time: those overlooked must not become its normal
    // log ratio of x under misfire N(0, noise) over healthy N(1, sd0); decide misfire above t.
    const auto ratio = [&](double x) { return -0.5 * std::pow(x / noise, 2) + 0.5 * std::pow((x - 1) / sd0, 2); };
    const auto tail = [&](double t, double mean, double sd) {
        double p = 0;
        for (int i = -8000; i < 8000; ++i) {
            const double z = (i + 0.5) / 1000, x = mean + sd * z;
            if (ratio(x) > t) p += std::exp(-0.5 * z * z) / std::sqrt(2 * M_PI) / 1000;
        }
        return p;
    };
    double low = -50, high = 50;
    for (int i = 0; i < 60; ++i) (tail((low + high) / 2, 1, sd0) > r.false_alarms ? low : high) = (low + high) / 2;
    const double best = tail(low, 0, noise);
    EXPECT_GT(r.detected, best - 0.01);
    EXPECT_LT(r.detected, best + 0.01) << "better than the bound is a mistake";
    EXPECT_LT(r.detected, 1) << "a case without errors compares nothing";
}

TEST(Misfire, MeetsTheWantedRatesWhereTheyCanBeMet) {
    Stream s(7);
    s.cyclic = 0.05;
    s.noise_nm = s.stated_nm = 0.14 * Stream::kTorque; // 0.14 (3.54 + 2.58) = 0.86, with cyclic variation 0.89
    s.healthy(500);
    const Rates r = rates(s, 100000, 10);
    EXPECT_GE(r.detected, 0.995);
    EXPECT_LE(r.false_alarms, 2e-4 * 2) << "twice the wanted rate covers 100,000 firings' luck and the learned deviation";
    EXPECT_EQ(SD_VALID, s.read().status.health);
}

/// Cyclic variation as large as is usual leaves little room at 1 bar. What the learned scatter is off by chance must not use it up, and
/// what is a disturbance must.
TEST(Misfire, ChanceInTheScatterIsNoDisturbance) {
    const auto valid = [](double noise, double common) {
        int good = 0, all = 0;
        for (unsigned seed = 1; seed <= 20; ++seed) {
            Stream s(seed);
            s.cyclic = 0.2, s.noise_nm = s.stated_nm = noise * Stream::kTorque, s.common = common;
            s.healthy(80);
            for (int i = 0; i < 1500; ++i, ++all) s.go(i % 50 == 49 ? 0 : 1), good += s.read().status.health == SD_VALID;
        }
        return double(good) / all;
    };
    EXPECT_GT(valid(0.03, 0), 0.99);
    EXPECT_GT(valid(0.06, 0), 0.97);
    EXPECT_GT(valid(0.08, 0), 0.95);
    EXPECT_LT(valid(0.10, 0), 0.2) << "3.54 of sqrt(0.2^2 + 0.1^2) and 2.58 of 0.1 do not fit below 1";
    EXPECT_LT(valid(0.03, 0.17), 0.1) << "nor does an error of 0.17 that nobody states";
}

TEST(Misfire, ContinuousSingleAndPairsAreSeenForEver) {
    for (int pattern : {0b0001, 0b0101, 0b0011, 0b0111, 0b1111}) { // firing places: 1; 1+4; 1+3; three; all
        Stream s;
        s.healthy(200);
        for (int i = 0; i < 4000; ++i) {
            const bool bad = (pattern >> (s.k % kCylinders)) & 1;
            ASSERT_EQ(bad ? SD_MISFIRE : SD_HEALTHY, s.go(bad ? 0 : 1).verdict) << pattern << " " << i;
        }
        int expected = 0;
        for (int n = 0; n < kCylinders; ++n) {
            if ((pattern >> n) & 1) expected |= 1 << (config().firing_order[n] - 1);
        }
        EXPECT_EQ(expected, s.read().continuous);
        for (int i = 0; i < 8; ++i) s.go();
        EXPECT_EQ(0, s.read().continuous);
    }
}

TEST(Misfire, FromTheVeryFirstFiringToo) {
    Stream s;
    s.healthy(0);
    for (int i = 0; i < 400; ++i) {
        const bool bad = s.k % kCylinders == 2;
        const auto v = s.go(bad ? 0 : 1);
        if (v.inhibit) continue;
        ASSERT_EQ(bad ? SD_MISFIRE : SD_HEALTHY, v.verdict) << i;
    }
}

TEST(Misfire, PartialBurnsAreScoredApart) {
    Stream s;
    s.healthy(200);
    for (int i = 0; i < 2000; ++i) {
        const bool weak = i % 50 == 49;
        ASSERT_EQ(weak ? SD_PARTIAL_BURN : SD_HEALTHY, s.go(weak ? 0.65 : 1).verdict) << i;
    }
    EXPECT_EQ(40u, s.read().partial_burns);
    EXPECT_EQ(0u, s.read().misfires);
}

/// Expectations 30 % off, and cylinders unequal: learned within some cycles, and no misfire meanwhile.
TEST(Misfire, LearnsTheExpectationOfEveryCylinder) {
    for (double efficiency : {0.72, 1.0, 1.35}) {
        Stream s(9);
        s.efficiency = efficiency;
        const double imbalance[] = {1.1, 1.0, 1.0, 0.85};
        double sum = 0;
        for (int i = 0; i < 4000; ++i) {
            const auto v = s.go(imbalance[s.k % 4]);
            ASSERT_NE(SD_MISFIRE, v.verdict) << i << " index " << v.index << " at " << efficiency;
            if (i >= 3000) sum += double(v.index) / 1000;
        }
        EXPECT_NEAR(1, sum, 0.02) << efficiency;
        EXPECT_EQ(SD_MISFIRE, s.go(0).verdict);
    }
}

TEST(Misfire, ARoughRoadWidensTheLimitAndASmoothOneNarrowsItAgain) {
    Stream s(11);
    s.healthy(400);
    const double before = double(s.go().index_sd);
    s.noise_nm = 0.14 * Stream::kTorque; // the estimator goes on stating 1 Nm
    int early = 0, late = 0;
    for (int i = 0; i < 8000; ++i) (i < 200 ? early : late) += s.go().verdict == SD_MISFIRE;
    EXPECT_LE(early, 4);
    EXPECT_LE(late, 8) << "of 7800: 0.1 %";
    EXPECT_NEAR(std::hypot(0.14, 0.05), double(s.go().index_sd), 0.03);
    int found = 0;
    for (int i = 0; i < 400; ++i) {
        s.healthy(9);
        found += s.go(0).verdict == SD_MISFIRE;
    }
    EXPECT_GE(found, 392) << "98 %";
    s.noise_nm = 1;
    s.healthy(2000);
    EXPECT_NEAR(before, double(s.go().index_sd), 0.02);
}

/// Neighbours err alike, or the other way, as where the load moves: what is left after the best prediction from the last
/// firing is common sqrt(1 - rho^2), and the monitor must come near that. Independent errors must cost next to nothing.
TEST(Misfire, TakesOutWhatTheLastFiringTellsOfThisOne) {
    const auto deviation = [](double rho) {
        Stream s(13);
        s.cyclic = 0.02, s.common = 0.18, s.rho = rho;
        s.healthy(2000);
        double sum = 0, squares = 0;
        for (int i = 0; i < 20000; ++i) {
            const double index = double(s.go().index);
            sum += index, squares += index * index;
        }
        return std::sqrt(squares / 20000 - std::pow(sum / 20000, 2));
    };
    EXPECT_NEAR(deviation(0), std::hypot(0.18, 0.027), 0.005);
    for (double rho : {-0.7, 0.7}) EXPECT_NEAR(deviation(rho), std::hypot(0.18 * std::sqrt(1 - 0.49), 0.033), 0.012) << rho;
    Stream s(17);
    s.cyclic = 0.02, s.common = 0.18, s.rho = -0.7;
    s.healthy(2000);
    const Rates r = rates(s, 20000, 5);
    EXPECT_GE(r.detected, 0.995);
    EXPECT_LE(r.false_alarms, 1e-3);
    for (int i = 0; i < 400; ++i) ASSERT_EQ(SD_MISFIRE, s.go(0).verdict) << "all of them, for ever: nothing there is learned";
}

TEST(Misfire, DoesNotJudgeInFuelCutGearShiftStartAndWithoutAnEstimate) {
    Stream s;
    for (int i = 0; i < 16; ++i) EXPECT_TRUE(s.go(0).inhibit & SD_INHIBIT_START);
    EXPECT_EQ(SD_HEALTHY, s.go().verdict);
    s.healthy(200);
    const auto expect = [&](int bit, const std::function<void()> &begin, const std::function<void()> &end) {
        begin();
        for (int i = 0; i < 20; ++i) {
            const auto v = s.go(0);
            EXPECT_EQ(SD_NOT_JUDGED, v.verdict);
            EXPECT_EQ(bit, v.inhibit & bit);
            EXPECT_EQ(SD_INVALID, s.read().status.health);
            if (bit == SD_INHIBIT_SHIFT) s.speed *= 0.93f;
        }
        end();
        for (int i = 0; i < 9; ++i) s.go(); // the hold, where there is one
        EXPECT_EQ(SD_HEALTHY, s.go().verdict) << "judges again after the hold";
    };
    expect(SD_INHIBIT_FUEL_CUT, [&] { s.command_mg = 0; }, [&] { s.command_mg = 10; });
    expect(SD_INHIBIT_FUEL_CUT, [&] { s.command_mg = 1; }, [&] { s.command_mg = 10; });
    expect(SD_INHIBIT_FUEL_CUT, [&] { s.command_mg = kNan; }, [&] { s.command_mg = 10; });
    expect(SD_INHIBIT_SHIFT, [&] { s.speed *= 1.1f; }, [&] {});
    for (std::uint8_t told : {SD_INHIBIT_SHIFT, SD_INHIBIT_LEVEL, SD_INHIBIT_OUTSIDE}) {
        s.inhibit = told;
        for (int i = 0; i < 20; ++i) EXPECT_EQ(told, s.go(0).inhibit & told) << "the caller knows";
        s.inhibit = 0;
        for (int i = 0; i < 8; ++i) EXPECT_EQ(told == SD_INHIBIT_SHIFT ? SD_INHIBIT_HOLD : 0, s.go().inhibit);
        EXPECT_EQ(SD_HEALTHY, s.go().verdict);
    }
    expect(SD_INHIBIT_ESTIMATE, [&] { s.noise_nm = kNan; }, [&] { s.noise_nm = 1; });
    expect(SD_INHIBIT_ESTIMATE, [&] { s.stated_nm = -1; }, [&] { s.stated_nm = 1; });
    EXPECT_EQ(0u, s.read().misfires);
    sd_misfire_start(&s.monitor);
    EXPECT_TRUE(s.go(0).inhibit & SD_INHIBIT_START);
}

} // namespace
