// SPDX-License-Identifier: MIT
// Windows, rates and lamps of the event monitor, and what it takes for a configuration.
#include <cmath>
#include <cstring>
#include <functional>

#include "support/misfire_stream.hpp"

using namespace sixdeg;
using namespace sixdeg::test;

namespace {

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
