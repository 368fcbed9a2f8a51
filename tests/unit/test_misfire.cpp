// SPDX-License-Identifier: MIT
// The event monitor on made sequences of firings, whose best possible detector is known in closed form.
#include <cmath>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <limits>

#include "common/random.hpp"
extern "C" {
#include "sd_misfire.h"
}

using namespace sixdeg;

namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr int kCylinders = 4;

sd_misfire_config_t config() {
    sd_misfire_config_t c{};
    c.cylinders = kCylinders;
    const std::uint8_t order[] = {1, 3, 4, 2};
    std::copy(order, order + 4, c.firing_order);
    c.work_per_fuel_jpmg = 18;
    c.cyclic = 0.2f;
    c.z_false = 3.54f;
    c.z_missed = 2.58f;
    c.definition = 0.5f;
    c.partial = 0.8f;
    c.fuel_min_mg = 2;
    c.torque_min_nm = 2;
    c.speed_change = 0.05f;
    c.start_firings = 16;
    c.hold_firings = 8;
    c.continuous_firings = 8;
    c.emission_percent = 2;
    c.catalyst_percent = 5;
    c.emission_exceedances = 4;
    c.catalyst_exceedances = 3;
    return c;
}

/// A stream of firings: what burns, of 10 mg, with combustion and estimate each scattering as told.
struct Stream {
    sd_misfire_t monitor;
    RandomStream random;
    double cyclic = 0.05, noise_nm = 1, stated_nm = 1, efficiency = 1;
    float speed = 200;
    float command_mg = 10; ///< What the monitor is told.
    std::uint8_t inhibit = 0;
    double common = 0, rho = 0; ///< Error that neighbours share: deviation over the torque, and how much of it goes on.
    double error = 0;
    long k = 0;
    static constexpr double kTorque = 10 * 18 / M_PI;

    explicit Stream(unsigned seed = 1, const sd_misfire_config_t &c = config()) : random(seed, 0) {
        EXPECT_EQ(SD_OK, sd_misfire_init(&monitor, &c));
    }
    sd_misfire_verdict_t go(double burned = 1) {
        const double mean = kTorque * efficiency * burned;
        if (common > 0) error = rho * error + common * std::sqrt(1 - rho * rho) * random.normal();
        const double torque = mean * (1 + cyclic * random.normal()) + noise_nm * random.normal() + error * kTorque;
        sd_misfire_firing_t f{std::uint8_t(k++ % kCylinders), SD_VALID, 0, inhibit, float(torque), float(stated_nm), command_mg, speed, 0};
        return sd_misfire_judge(&monitor, &f);
    }
    void healthy(int n) { while (n-- > 0) go(); }
    sd_misfire_report_t read() const {
        sd_misfire_report_t r;
        sd_misfire_read(&monitor, &r);
        return r;
    }
};

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

TEST(Misfire, WindowsCountRevolutionsAndRatesByCylinder) {
    Stream s;
    s.healthy(16); // the start
    for (int i = 0; i < 2000; ++i) s.go(i % 100 == 1 ? 0 : 1); // 1000 revolutions, 20 misfires of the second firing
    const auto r = s.read();
    EXPECT_FLOAT_EQ(4, r.percent_1000[2]) << "20 of cylinder 3's 500";
    EXPECT_FLOAT_EQ(4, r.percent_200[2]);
    EXPECT_EQ(0, r.percent_1000[0] + r.percent_1000[1] + r.percent_1000[3]);
    EXPECT_EQ(20u, r.misfires);
    EXPECT_EQ(SD_LAMP_OFF, r.lamp) << "1 % of all firings, allowed 2";
}

TEST(Misfire, EmissionLampComesAtOnceInTheFirstThousandRevolutionsAndAfterFourLater) {
    const auto window = [](Stream &s, int misfires) {
        for (int i = 0; i < 2000; ++i) s.go(i % 40 == 1 && i / 40 < misfires ? 0 : 1);
    };
    Stream first;
    first.healthy(16);
    window(first, 45); // 2.25 %
    EXPECT_EQ(SD_LAMP_ON, first.read().lamp);
    EXPECT_EQ(1 << 2, first.read().suspects);
    Stream later;
    later.healthy(16);
    window(later, 35); // 1.75 %
    EXPECT_EQ(SD_LAMP_OFF, later.read().lamp);
    for (int k = 1; k <= 4; ++k) {
        EXPECT_NE(SD_LAMP_ON, later.read().lamp);
        window(later, 45);
        window(later, 0);
        EXPECT_EQ(k, later.read().emission_exceeded);
    }
    EXPECT_EQ(SD_LAMP_ON, later.read().lamp);
}

TEST(Misfire, CatalystLampBlinksAfterThreeWindows) {
    Stream s;
    s.healthy(16);
    for (int k = 1; k <= 3; ++k) {
        for (int i = 0; i < 400; ++i) s.go(i % 16 == 1 ? 0 : 1); // 6.25 %
        EXPECT_EQ(k < 3 ? SD_LAMP_PENDING : SD_LAMP_BLINKS, s.read().lamp);
        EXPECT_EQ(k, s.read().catalyst_exceeded);
    }
}

TEST(Misfire, SurvivesEveryFloat) {
    Stream s;
    std::uint32_t x = 1;
    for (int k = 0; k < 300000; ++k) {
        float in[4];
        for (float &f : in) {
            x = x * 1664525u + 1013904223u;
            std::memcpy(&f, &x, sizeof f);
            if (k % 5) f = std::fmod(f, 300.0f);
        }
        const sd_misfire_firing_t f{std::uint8_t(x >> 28), std::uint8_t(x >> 30), 0, 0, in[0], in[1], in[2], in[3], in[0]};
        const auto v = sd_misfire_judge(&s.monitor, &f);
        for (float value : {v.index, v.index_sd, v.limit, s.monitor.scatter, s.monitor.factor[0], s.read().status.test_ratio})
            ASSERT_TRUE(std::isfinite(value)) << k;
        ASSERT_LE(v.cylinder, kCylinders);
    }
}

TEST(Misfire, InitRefusesWhatIsOutOfRange) {
    const auto refused = [](const std::function<void(sd_misfire_config_t &)> &spoil) {
        sd_misfire_config_t c = config();
        spoil(c);
        sd_misfire_t s{};
        s.misfires = 77;
        return sd_misfire_init(&s, &c) == SD_ERR_CONFIG && s.misfires == 77;
    };
    EXPECT_FALSE(refused([](auto &) {}));
    for (float sd_misfire_config_t::*field :
         {&sd_misfire_config_t::work_per_fuel_jpmg, &sd_misfire_config_t::cyclic, &sd_misfire_config_t::z_false,
          &sd_misfire_config_t::z_missed, &sd_misfire_config_t::definition, &sd_misfire_config_t::partial,
          &sd_misfire_config_t::fuel_min_mg, &sd_misfire_config_t::torque_min_nm, &sd_misfire_config_t::speed_change,
          &sd_misfire_config_t::emission_percent, &sd_misfire_config_t::catalyst_percent}) {
        for (float bad : {kNan, -1.0f, std::numeric_limits<float>::infinity()}) EXPECT_TRUE(refused([&](auto &c) { c.*field = bad; }));
    }
    EXPECT_TRUE(refused([](auto &c) { c.cylinders = 0; }));
    EXPECT_TRUE(refused([](auto &c) { c.cylinders = 9; }));
    EXPECT_TRUE(refused([](auto &c) { c.firing_order[1] = 1; }));
    EXPECT_TRUE(refused([](auto &c) { c.continuous_firings = 1; }));
    EXPECT_TRUE(refused([](auto &c) { c.emission_exceedances = 0; }));
}

TEST(Misfire, StateIsSmallAndTheSameEverywhere) { EXPECT_LT(sizeof(sd_misfire_t), 400u); }

TEST(Misfire, OtherChoicesOnTheWayKeepCountsAndForgetOnlyWhatTheyWereRelativeTo) {
    Stream s;
    s.efficiency = 1.2;
    s.healthy(400);
    for (int i = 0; i < 4; ++i) s.go(i == 2 ? 0 : 1);
    const sd_misfire_t before = s.monitor;
    ASSERT_EQ(1u, before.misfires);
    EXPECT_NEAR(1.2, double(before.factor[0]), 0.03);
    sd_misfire_config_t c = config();
    c.partial = 0.7f;
    ASSERT_EQ(SD_OK, sd_misfire_configure(&s.monitor, &c));
    EXPECT_EQ(before.factor[0], s.monitor.factor[0]);
    EXPECT_EQ(before.since_start, s.monitor.since_start) << "judged without a break";
    EXPECT_EQ(SD_PARTIAL_BURN, s.go(0.65).verdict);
    EXPECT_EQ(SD_HEALTHY, s.go(0.78).verdict);
    c.work_per_fuel_jpmg = 21.6f; // what they really give
    ASSERT_EQ(SD_OK, sd_misfire_configure(&s.monitor, &c));
    EXPECT_EQ(1.0f, s.monitor.factor[0]);
    EXPECT_EQ(1u, s.monitor.misfires);
    EXPECT_EQ(SD_INHIBIT_START, s.go().inhibit);
    EXPECT_EQ(SD_WHY_CONVERGING, s.read().status.why);
    s.healthy(100);
    EXPECT_NEAR(1.0, double(s.monitor.factor[0]), 0.03);
    const sd_misfire_t now = s.monitor;
    c.cyclic = kNan;
    EXPECT_EQ(SD_ERR_CONFIG, sd_misfire_configure(&s.monitor, &c));
    c = config();
    std::swap(c.firing_order[0], c.firing_order[1]);
    EXPECT_EQ(SD_ERR_CONFIG, sd_misfire_configure(&s.monitor, &c)) << "another engine";
    EXPECT_EQ(0, std::memcmp(&now, &s.monitor, sizeof now));
}

} // namespace
