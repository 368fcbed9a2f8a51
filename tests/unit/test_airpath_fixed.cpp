// SPDX-License-Identifier: MIT
// The air path's bank in fixed point beside the one in single precision, on the matched plant and wherever sensors may be.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <string>

#include "design/airpath/fixed_tables.hpp"
#include "support/airpath_setup.hpp"

using namespace sixdeg;
using sixdeg::test::setup;

namespace {

const FixedAirPath &fixed() {
    static const FixedAirPath made = fixed_air_path(setup().design.tables);
    return made;
}

double kpa(sd_q31_t x) { return std::ldexp(double(x), SD_AIRPATH_AMOUNT - 31); }

/// Both banks on the same readings: when each names a fault first, what it names, how far residuals are apart.
struct Pair {
    long named[2] = {-1, -1};
    int fault[2] = {0, 0};
    double apart_kpa = 0;
};

Pair both_on(const MatchedFault &fault, std::uint64_t seed) {
    RandomStream random(seed, 21);
    MatchedRun plant(setup(), 18, 18, random);
    sd_airpath_bank_f32_t f32;
    sd_airpath_bank_q31_t q31;
    sd_airpath_start_f32(&f32);
    sd_airpath_start_q31(&q31);
    const sd_q31_t threshold = sd_given_q31(18, SD_CUSUM_BITS);
    const sd_airpath_config_f32_t config{100, 300, {18, 18}};
    const sd_airpath_config_q31_t fixed_config{100, 300, {threshold, threshold}};
    Pair pair;
    for (long i = 0; i < 1000; ++i) {
        if (i == 800) plant.set_fault(fault);
        plant.step(draw_noise(random));
        const sd_airpath_in_q31_t in = fixed_readings(plant.readings());
        sd_airpath_out_f32_t usual;
        sd_airpath_out_q31_t other;
        sd_airpath_step_f32(&f32, &setup().design.tables, &config, &plant.readings(), &usual);
        sd_airpath_step_q31(&q31, &fixed().tables, &fixed_config, &in, &other);
        EXPECT_EQ(usual.phase, other.phase) << i;
        for (int r = 0; r < 2; ++r)
            pair.apart_kpa = std::max(pair.apart_kpa, std::abs(double(usual.residual_kpa[r]) - kpa(other.residual_kpa[r])));
        if (pair.named[0] < 0 && usual.fault != 0) pair.named[0] = i, pair.fault[0] = usual.fault;
        if (pair.named[1] < 0 && other.fault != 0) pair.named[1] = i, pair.fault[1] = other.fault;
    }
    return pair;
}

} // namespace

TEST(AirPathFixed, DecidesAsSinglePrecisionDoes) {
    ASSERT_EQ("", fixed().too_large);
    double apart = 0;
    for (const MatchedFault &fault : matched_faults()) {
        for (std::uint64_t seed = 1; seed <= 25; ++seed) {
            const Pair pair = both_on(fault, seed);
            EXPECT_EQ(fault.actuator, pair.fault[0]) << fault.name << " " << seed;
            EXPECT_EQ(pair.fault[0], pair.fault[1]) << fault.name << " " << seed;
            EXPECT_LE(std::abs(pair.named[0] - pair.named[1]), 1) << fault.name << " " << seed;
            apart = std::max(apart, pair.apart_kpa);
        }
    }
    EXPECT_LT(apart, 2e-3);
    EXPECT_GT(apart, 0) << "it is another arithmetic";
    RecordProperty("apart_kpa", std::to_string(apart));
}

TEST(AirPathFixed, FlowsAndRatesAreThoseOfSinglePrecisionWhereverSensorsMayBe) {
    RandomStream random(1, 22);
    const auto within = [&](double low, double high) { return float(low + (high - low) * random.uniform()); };
    for (int i = 0; i < 20000; ++i) {
        sd_airpath_in_f32_t in{within(300, 4000), within(5, 300), within(0.5, 20), within(250, 400), within(250, 600), within(400, 1200),
                               within(-0.1, 1.1), within(-0.1, 1.1), within(80, 350), within(90, 450)};
        const sd_airpath_in_q31_t q = fixed_readings(in);
        sd_airpath_now_f32_t now;
        sd_airpath_now_q31_t now_q;
        sd_airpath_flows_f32_t flows;
        sd_airpath_flows_q31_t flows_q;
        sd_airpath_prepare_f32(&setup().design.tables.model, &in, &now);
        sd_airpath_prepare_q31(&fixed().tables.model, &q, &now_q);
        sd_airpath_flow_f32(&setup().design.tables.model, &now, in.intake_kpa, in.exhaust_kpa, &flows);
        sd_airpath_flow_q31(&fixed().tables.model, &now_q, q.intake_kpa, q.exhaust_kpa, &flows_q);
        EXPECT_NEAR(flows.egr_gps, std::ldexp(double(flows_q.egr_gps), SD_AIRPATH_FLOW - 31), 1e-2) << i;
        // Near the pressure behind the turbine the root makes 1e-4 of the 1e-8 that a ratio is off by.
        const double turbine_bound = in.exhaust_kpa > 105 ? 1e-2 : 0.03;
        EXPECT_NEAR(flows.turbine_gps, std::ldexp(double(flows_q.turbine_gps), SD_AIRPATH_FLOW - 31), turbine_bound) << i;
        float x[4], rate[4];
        sd_q31_t x_q[4], rate_q[4];
        sd_airpath_rest_f32(&in, &now, x);
        sd_airpath_rest_q31(&q, &now_q, x_q);
        sd_airpath_rate_f32(&in, &now, x, &flows, rate);
        sd_airpath_rate_q31(&q, &now_q, x_q, &flows_q, rate_q);
        for (int j = 0; j < 4; ++j)
            EXPECT_NEAR(rate[j], std::ldexp(double(rate_q[j]), SD_AIRPATH_FLOW - 31), 1e-5 * std::abs(double(rate[j])) + 0.06) << j;
    }
}

// Whatever sensors say within their ranges: no sum overflows (the sanitized build looks), and an estimate at the end of its range is given
// up.
TEST(AirPathFixed, ExtremesSaturateAndAreBegunAnew) {
    RandomStream random(1, 23);
    sd_airpath_bank_q31_t bank;
    sd_airpath_start_q31(&bank);
    const sd_q31_t threshold = sd_given_q31(1e4f, SD_CUSUM_BITS);
    const sd_airpath_config_q31_t config{0, 3, {threshold, threshold}};
    int given_up = 0;
    for (int i = 0; i < 20000; ++i) {
        const auto end = [&](float low, float high) { return random.uniform() < 0.5 ? low : high; };
        const sd_airpath_in_f32_t in{end(301, 20000), end(0, 2000), end(0, 2000), end(200, 500), end(200, 1000), end(200, 1600),
                                     end(-0.1f, 1.1f), end(-0.1f, 1.1f), end(5, 600), end(5, 1000)};
        const sd_airpath_in_q31_t q = fixed_readings(in);
        sd_airpath_out_q31_t out;
        sd_airpath_step_q31(&bank, &fixed().tables, &config, &q, &out);
        if (out.phase == SD_AIRPATH_WAITS) {
            given_up++;
            EXPECT_EQ(SD_INVALID, out.status.health);
            EXPECT_EQ(SD_AIRPATH_NO_FAULT, out.fault);
        } else {
            for (const sd_q31_t r : out.residual_kpa) EXPECT_LT(std::abs(kpa(r)), 1024);
        }
    }
    EXPECT_GT(given_up, 0);
}

TEST(AirPathFixed, RefusesNumbersThatDoNotFitAndNamesThem) {
    sd_airpath_tables_f32_t t = setup().design.tables;
    t.model.emptying_ps[16] = 70;
    EXPECT_NE(std::string::npos, fixed_air_path(t).too_large.find("emptying, 1/s, knot[16] is 70"));
    EXPECT_EQ(0u, fixed_air_path(t).tables.present);
    t = setup().design.tables;
    t.observer[1].k[0][1] = 3000;
    EXPECT_NE(std::string::npos, fixed_air_path(t).too_large.find("observer[1].k[0][1]"));
    sd_airpath_tables_q31_t q = fixed().tables;
    EXPECT_TRUE(sd_airpath_tables_ok_q31(&q));
    q.observer[0].m[0][0] = q.observer[0].m[0][1] = INT32_MAX;
    EXPECT_FALSE(sd_airpath_tables_ok_q31(&q)) << "a sum of them could overflow";
}
