// SPDX-License-Identifier: MIT
// Learning of the tooth pattern against a motored torque in closed form.
#include <limits>

#include "support/kalman_bench.hpp"
extern "C" {
#include "sd_pattern.h"
}

namespace sixdeg {
namespace {

using namespace test;

constexpr double kDeg = M_PI / 180;

/// Motored cycles at one speed; `compression` is the true motored torque over the believed one.
void motor(sd_pattern_t &pattern, double rpm, int cycles, double jitter_deg, double pattern_deg, double compression, unsigned seed,
           std::vector<double> &truth) {
    TorqueSignal signal;
    signal.rpm = rpm;
    signal.fuel = {0, 0, 0, 0};
    signal.compression_nm *= compression;
    Edges edges(signal, jitter_deg, pattern_deg, seed);
    truth.clear();
    for (int k = 0; k < 58; ++k) truth.push_back(edges.late_rad(k));
    double mean = 0;
    for (double late : truth) mean += late / 58;
    for (double &late : truth) late -= mean;
    Bench bench(pulse_tables().tables, edges);
    bench.take = [&](const sd_kalman_tooth_t &tooth) { sd_pattern_step(&pattern, &bench.tables, &tooth); };
    bench.run(cycles + 3); // two for the guess, and the first is not whole
    sd_pattern_pause(&pattern);
}

double rms_error_deg(const sd_pattern_t &pattern, const std::vector<double> &truth) {
    double square = 0;
    for (std::size_t k = 0; k < truth.size(); ++k) square += std::pow(double(pattern.late_rad[k]) - truth[k], 2);
    return std::sqrt(square / double(truth.size())) / kDeg;
}

sd_pattern_t fresh() {
    sd_pattern_t pattern;
    sd_pattern_init(&pattern, &pulse_tables().tables);
    return pattern;
}

TEST(Pattern, TwentyMotoredCyclesLeaveLittle) {
    sd_pattern_t pattern = fresh();
    std::vector<double> truth;
    motor(pattern, 3000, 20, 0.01, 0.02, 1, 1, truth);
    EXPECT_NEAR(double(pattern.sums.cycles), 20, 1);
    EXPECT_LT(rms_error_deg(pattern, truth), 0.0025);
    EXPECT_LT(rms_error_deg(pattern, truth), 2 * double(pattern.sd_rad) / kDeg) << "and says so";
    for (int k : {58, 59}) EXPECT_EQ(pattern.late_rad[k], 0);
}

TEST(Pattern, TwoSpeedsTellPatternFromMotoredTorque) {
    sd_pattern_t one = fresh();
    std::vector<double> truth;
    motor(one, 1000, 20, 0.01, 0.02, 1.03, 1, truth);
    EXPECT_EQ(one.pooled, 0);
    const double alone = rms_error_deg(one, truth);
    EXPECT_GT(alone, 0.005) << "3 % of the motored torque, taken for pattern";
    EXPECT_LT(alone, 2 * double(one.sd_rad) / kDeg) << "and the confidence covers it";
    motor(one, 3000, 40, 0.01, 0.02, 1.03, 1, truth);
    EXPECT_EQ(one.pooled, 1);
    EXPECT_LT(rms_error_deg(one, truth), 0.003);
    EXPECT_LT(rms_error_deg(one, truth), 2 * double(one.sd_rad) / kDeg);
}

TEST(Pattern, GoesOnFromWhatWasKept) {
    sd_pattern_t first = fresh(), second = fresh();
    std::vector<double> truth;
    motor(first, 3000, 10, 0.01, 0.02, 1, 1, truth);
    ASSERT_EQ(sd_pattern_resume(&second, &pulse_tables().tables, &first.sums), SD_OK);
    EXPECT_LT(rms_error_deg(second, truth), 0.005);
    EXPECT_GT(second.sd_rad, 0);
    sd_pattern_sums_t bad = first.sums;
    bad.late[3] = std::numeric_limits<float>::quiet_NaN();
    const sd_pattern_t before = second;
    EXPECT_EQ(sd_pattern_resume(&second, &pulse_tables().tables, &bad), SD_ERR_CONFIG);
    EXPECT_EQ(std::memcmp(&before, &second, sizeof before), 0);
}

TEST(Pattern, ZerosAreReadingsOverChargeLessTheirMean) {
    sd_pattern_t pattern = fresh();
    const sd_kalman_tables_t &tables = pulse_tables().tables;
    float zero[SD_KALMAN_FIRINGS_MAX];
    const auto read = [&](std::uint8_t index, float raw_nm, float charge_bar, float speed) {
        sd_firing_t firing{};
        firing.index = index, firing.raw_nm = raw_nm;
        return sd_pattern_take_zero(&pattern, &tables, &firing, charge_bar, speed);
    };
    EXPECT_FALSE(read(0, 6, 2, 200));
    sd_pattern_zeros(&pattern, &tables, zero);
    EXPECT_EQ(zero[0], 0) << "the others were not read yet";
    EXPECT_FALSE(read(1, 2, 2, 200));
    EXPECT_FALSE(read(2, 2, 2, 200));
    EXPECT_TRUE(read(3, 2, 2, 200));
    EXPECT_FALSE(read(0, 1e6f, 0, 200)) << "no charge, no zero";
    EXPECT_FALSE(read(7, 6, 2, 200));
    sd_pattern_zeros(&pattern, &tables, zero);
    for (int i = 0; i < 4; ++i) EXPECT_FLOAT_EQ(zero[i], i == 0 ? 1.5f : -0.5f);
    for (std::uint8_t i = 0; i < 4; ++i) read(i, i == 0 ? 60.f : 0.f, 2, 2000); // at ten times the speed it weighs 1e-4
    sd_pattern_zeros(&pattern, &tables, zero);
    EXPECT_NEAR(zero[0], 1.5, 3e-3);
    // And the filter takes them out by the charge that the cylinder holds.
    TorqueSignal signal;
    Bench with(tables, Edges(signal, 0, 0, 1)), without(tables, Edges(signal, 0, 0, 1));
    with.kalman.zero_nm_per_bar[2] = 7;
    with.tooth.intake_bar = without.tooth.intake_bar = 1.5f;
    with.run(20), without.run(20);
    for (std::size_t i = 0; i < with.firings.size(); ++i) {
        const float zero_nm = with.firings[i].said.index == 2 ? 7 * 1.5f : 0;
        EXPECT_NEAR(with.firings[i].said.torque_nm, without.firings[i].said.torque_nm - zero_nm, 1e-3);
        EXPECT_EQ(with.firings[i].said.raw_nm, without.firings[i].said.raw_nm);
    }
}

TEST(Pattern, LearnsNothingFromBrokenCycles) {
    sd_pattern_t pattern = fresh();
    sd_kalman_tooth_t tooth{};
    std::mt19937 random(3);
    for (int i = 0; i < 30000; ++i) {
        tooth.cycle_position = std::uint16_t(i % 125);
        tooth.advance = 1;
        tooth.period_ticks = 20000 + random() % 50000;
        tooth.trusted = random() % 50 != 0;
        tooth.intake_bar = random() % 40 == 0 ? NAN : 1.f;
        sd_pattern_step(&pattern, &pulse_tables().tables, &tooth);
    }
    EXPECT_EQ(pattern.sums.cycles, 0);
    EXPECT_EQ(pattern.sd_rad, 0);
}

} // namespace
} // namespace sixdeg
