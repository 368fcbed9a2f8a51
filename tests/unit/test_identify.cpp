// SPDX-License-Identifier: MIT
// What is found of an engine whose recording is made here, by equations written out again: isentropic gas, kinetic energy, fine steps.
#include <cmath>
#include <gtest/gtest.h>
#include <random>

#include "common/error.hpp"
#include "identify/engine_text.hpp"
#include "identify/identify.hpp"
#include "identify/learned_pattern.hpp"

namespace {

using namespace sixdeg;

constexpr double kRad = M_PI / 180;

/// Four even firings, or a single, without combustion; what is true of it, and the file that is wrong about it.
struct MadeEngine {
    double inertia = 0.21, mass = 0.6, gamma = 1.36, intake_bar = 0.9, drag_nm = 3, offset_deg = 1.3, position_0_deg = 100;
    double burn = 1; ///< Heat at TDC: pressure behind it over pressure ahead of it.
    double bore = 0.08, stroke = 0.085, rod = 0.14, ratio = 11;
    std::vector<double> tdc_deg{0, 180, 360, 540}, pattern_deg;

    MadeEngine() {
        for (int p = 0; p < 58; ++p) pattern_deg.push_back(0.1 * std::sin(p * 1.7) + (p == 0 ? 0.5 : 0));
        double mean = 0;
        for (double p : pattern_deg) mean += p / 58;
        for (double &p : pattern_deg) p -= mean;
    }
    double height(double a) const {
        const double r = stroke / 2;
        return r + rod - r * std::cos(a) - std::sqrt(rod * rod - r * r * std::sin(a) * std::sin(a));
    }
    double volume(double a) const { return M_PI / 4 * bore * bore * (stroke / (ratio - 1) + height(a)); }
    double slope(double a) const { return (volume(a + 1e-5) - volume(a - 1e-5)) / 2e-5; }
    /// Bar, over the angle from the own firing TDC.
    double pressure(double deg) const {
        const double a = std::remainder(deg, 720);
        if (burn > 1 && std::abs(a) >= 150) return a > 0 ? 1.05 : intake_bar;
        return std::abs(a) < 150 ? intake_bar * std::pow(volume(150 * kRad) / volume(a * kRad), gamma) * (a > 0 ? burn : 1) : intake_bar;
    }
    /// By tenths of a degree, made once.
    double table(std::vector<double> &values, double deg, double (MadeEngine::*of)(double) const) const {
        if (values.empty())
            for (int i = 0; i < 14400; ++i) values.push_back((this->*of)(i * 0.05));
        return values[std::size_t(std::lround(deg / 0.05)) % 14400];
    }
    mutable std::vector<double> gas_table, inertia_table;
    double gas_nm(double deg) const { return table(gas_table, deg, &MadeEngine::gas_slowly); }
    double inertia_at(double deg) const { return table(inertia_table, deg, &MadeEngine::inertia_slowly); }
    double other_nm = 0; ///< A torque of orders 1/2 and 1.
    double gas_slowly(double deg) const {
        double sum = other_nm * (std::cos(deg * kRad / 2) + std::sin(deg * kRad));
        for (double tdc : tdc_deg) sum += (pressure(deg - tdc) - 1.013) * 1e5 * slope((deg - tdc) * kRad);
        return sum;
    }
    double inertia_slowly(double deg) const {
        double sum = inertia;
        for (double tdc : tdc_deg) sum += mass * std::pow(slope((deg - tdc) * kRad) / (M_PI / 4 * bore * bore), 2);
        return sum;
    }
    EngineFile first_file() const {
        EngineFile file;
        for (std::size_t i = 0; i < tdc_deg.size(); ++i) file.firing_order.push_back(int(i + 1));
        file.firing_tdc_deg = tdc_deg;
        file.bore_m = bore, file.stroke_m = stroke, file.rod_m = rod, file.compression_ratio = ratio;
        file.intake_close_deg = 570, file.exhaust_open_deg = 145;
        file.pulses = {{-10, 50, 2, 1}};
        file.inertia_kgm2 = 1.2 * inertia, file.reciprocating_mass_kg = mass;
        file.position_0_deg = position_0_deg;
        return file;
    }
};

/// Turns the engine by `cycles` at about `rpm`, and adds what is recorded.
void turn(const MadeEngine &engine, double rpm, int cycles, std::mt19937 &random, CrankRecord &record) {
    constexpr double kStepDeg = 0.1;
    std::normal_distribution<double> jitter(0, 0.01 * kRad), noise(0, 0.01);
    const long first_place = record.teeth.empty() ? 0 : (record.teeth.back().place / 120 + 3) * 120;
    double t = record.teeth.empty() ? 0 : record.teeth.back().t_s + 1, energy = engine.inertia_at(0) / 2 * std::pow(rpm * M_PI / 30, 2);
    long k = 0;
    const auto place_deg = [&](long tooth) {
        const auto p = std::size_t(tooth % 60);
        return engine.position_0_deg + engine.offset_deg + 6.0 * double(tooth) + (p < 58 ? engine.pattern_deg[p] : 0);
    };
    for (long i = 0; double(i) * kStepDeg < 720.0 * cycles; ++i) {
        const double deg = double(i) * kStepDeg, middle = deg + kStepDeg / 2;
        const double after = energy + (engine.gas_nm(middle) - engine.drag_nm) * kStepDeg * kRad;
        const double speed = std::sqrt((energy + after) / engine.inertia_at(middle)), step_s = kStepDeg * kRad / speed;
        for (; place_deg(k) < deg + kStepDeg; ++k)
            if (k % 60 < 58 && place_deg(k) >= deg)
                record.teeth.push_back({t + (place_deg(k) - deg) / kStepDeg * step_s + jitter(random) / speed, first_place + k});
        if (i % 3 == 0) record.pressure.push_back({t, 20 + engine.pressure(deg) + noise(random)});
        t += step_s, energy = after;
    }
}

CrankRecord recording(const MadeEngine &engine) {
    CrankRecord record;
    std::mt19937 random(5);
    turn(engine, 1200, 12, random, record);
    turn(engine, 3000, 25, random, record);
    record.intake = {{0, engine.intake_bar}};
    record.fuel = {{0, 0}};
    return record;
}

TEST(Identify, WithPressureEveryNumberIsWithinItsIntervalAndTheIntervalsAreNarrow) {
    const MadeEngine engine;
    const Identified found = identify(engine.first_file(), recording(engine), {}, "made");
    SCOPED_TRACE(testing::Message() << found.scatter_deg << " deg scatter, " << found.unexplained_deg << " deg and "
        << found.unexplained_percent
                                    << " % unexplained");
    EXPECT_GE(found.used, 30u);
    ASSERT_TRUE(found.inertia_kgm2.told()) << found.inertia_kgm2.refused;
    EXPECT_NEAR(found.inertia_kgm2.value, engine.inertia, found.inertia_kgm2.half_width);
    EXPECT_LT(found.inertia_kgm2.half_width, 0.04 * engine.inertia);
    EXPECT_NEAR(found.position_0_deg.value, engine.position_0_deg + engine.offset_deg, found.position_0_deg.half_width);
    EXPECT_LT(found.position_0_deg.half_width, 0.5);
    EXPECT_NEAR(found.exponent.value, engine.gamma, found.exponent.half_width);
    EXPECT_LT(found.exponent.half_width, 0.04);
    for (std::size_t p = 0; p < 58; ++p) EXPECT_NEAR(found.pattern_deg[p].value, engine.pattern_deg[p], 0.02) << p;
    ASSERT_EQ(found.drag.size(), 2u);
    for (const DragAt &drag : found.drag) EXPECT_NEAR(drag.nm.value, engine.drag_nm, drag.nm.half_width) << drag.rpm;
}

TEST(Identify, TeethAloneTellWheelAndTdcAndRefuseTheInertiaByName) {
    const MadeEngine engine;
    CrankRecord record = recording(engine);
    record.pressure.clear();
    const Identified found = identify(engine.first_file(), record, {}, "made");
    EXPECT_EQ(found.inertia_kgm2.refused, "the teeth alone give torque over inertia; give --pressure");
    EXPECT_FALSE(found.exponent.told());
    ASSERT_TRUE(found.position_0_deg.told()) << found.position_0_deg.refused;
    EXPECT_NEAR(found.position_0_deg.value, engine.position_0_deg + engine.offset_deg, found.position_0_deg.half_width);
    for (std::size_t p = 0; p < 58; ++p) EXPECT_NEAR(found.pattern_deg[p].value, engine.pattern_deg[p], 0.02) << p;
    for (const DragAt &drag : found.drag) {
        EXPECT_FALSE(drag.nm.told());
        EXPECT_NEAR(drag.over_inertia.value * engine.inertia, engine.drag_nm, drag.over_inertia.half_width * engine.inertia);
    }
}

TEST(Identify, WithoutAFuelCutAFiringEngineIsRefusedByName) {
    const MadeEngine engine;
    CrankRecord record = recording(engine);
    record.fuel = {{0, 12}};
    record.pressure.clear();
    const Identified found = identify(engine.first_file(), record, {}, "made");
    EXPECT_FALSE(found.position_0_deg.told());
    EXPECT_NE(found.pattern_refused.find("--motored"), std::string::npos) << found.pattern_refused;
    const Identified told = identify(engine.first_file(), record, {{{-1, 1e9}}}, "made");
    EXPECT_TRUE(told.position_0_deg.told());
    record.teeth.resize(200);
    EXPECT_THROW(identify(engine.first_file(), record, {}, "made"), InputError);
}

/// A single that fires, at about one speed.
MadeEngine single() {
    MadeEngine engine;
    engine.tdc_deg = {0}, engine.inertia = 0.08, engine.burn = 1.8, engine.drag_nm = 0;
    for (int deg = 0; deg < 720; ++deg) engine.drag_nm += engine.gas_slowly(deg) / 720; // it runs steadily
    return engine;
}

CrankRecord firing_record(const MadeEngine &engine) {
    CrankRecord record;
    std::mt19937 random(6);
    turn(engine, 2400, 24, random, record);
    record.intake = {{0, engine.intake_bar}};
    return record;
}

void expect_pattern(const Identified &found, const MadeEngine &engine, double most_half_width) {
    ASSERT_EQ(found.pattern_refused, "");
    int held = 0;
    for (std::size_t p = 0; p < 58; ++p) {
        held += std::abs(found.pattern_deg[p].value - engine.pattern_deg[p]) <= found.pattern_deg[p].half_width;
        EXPECT_LT(found.pattern_deg[p].half_width, most_half_width) << p;
    }
    EXPECT_GE(held, 55);
}

TEST(Identify, AFiringSingleTellsItsPatternByTheGasExchangeAlthoughNothingElse) {
    const MadeEngine engine = single();
    CrankRecord record = firing_record(engine);
    record.pressure.clear();
    const Identified found = identify(engine.first_file(), record, {}, "made");
    EXPECT_FALSE(found.position_0_deg.told());
    EXPECT_FALSE(found.inertia_kgm2.told());
    EXPECT_TRUE(found.pattern_by_exchange);
    expect_pattern(found, engine, 0.15);
}

TEST(Identify, AFiringSingleWithPressureTellsEverything) {
    const MadeEngine engine = single();
    const Identified found = identify(engine.first_file(), firing_record(engine), {}, "made");
    SCOPED_TRACE(testing::Message() << found.unexplained_percent << " % unexplained");
    EXPECT_EQ(found.motored, 0u);
    ASSERT_TRUE(found.inertia_kgm2.told()) << found.inertia_kgm2.refused;
    EXPECT_NEAR(found.inertia_kgm2.value, engine.inertia, found.inertia_kgm2.half_width);
    ASSERT_TRUE(found.position_0_deg.told()) << found.position_0_deg.refused;
    EXPECT_NEAR(found.position_0_deg.value, engine.position_0_deg + engine.offset_deg, found.position_0_deg.half_width);
    ASSERT_EQ(found.drag.size(), 1u);
    EXPECT_FALSE(found.drag[0].motored);
    EXPECT_NEAR(found.drag[0].nm.value, engine.drag_nm, found.drag[0].nm.half_width);
    EXPECT_LT(found.drag[0].nm.half_width, 2);
    expect_pattern(found, engine, 0.1);
}

TEST(Identify, WhatTheMotionOfTheCrankLeavesOpenRefusesNothingElse) {
    // Beside the single's own torque another one acts, of orders 1/2 and 1, which no engine file has.
    MadeEngine engine = single();
    engine.other_nm = 12;
    const Identified found = identify(engine.first_file(), firing_record(engine), {}, "made");
    EXPECT_GT(found.unexplained_percent, 3);
    ASSERT_EQ(found.drag.size(), 1u);
    EXPECT_NEAR(found.drag[0].nm.value, engine.drag_nm, found.drag[0].nm.half_width);
    ASSERT_TRUE(found.inertia_kgm2.told()) << found.inertia_kgm2.refused;
    EXPECT_NEAR(found.inertia_kgm2.value, engine.inertia, found.inertia_kgm2.half_width);
}

TEST(Identify, CompressionAloneTellsTdc) {
    MadeEngine engine = single();
    engine.gamma = 1.32;
    const Identified found = identify(engine.first_file(), firing_record(engine), {}, "made");
    ASSERT_TRUE(found.compression_0_deg.told()) << found.compression_0_deg.refused;
    EXPECT_NEAR(found.compression_0_deg.value, engine.position_0_deg + engine.offset_deg, found.compression_0_deg.half_width);
}

TEST(LearnedPattern, TheFirmwareReadsPatternAndDeviationFromIt) {
    Identified found;
    for (int p = 0; p < 60; ++p) found.pattern_deg.push_back({0.1 * std::sin(p), 0.03, p < 58 ? "" : "no tooth"});
    found.pattern_cycles = 30;
    const sd_pattern_sums_t sums = kept_of(found, "made").pattern;
    // The straight line over u that the firmware fits to each tooth (sd_pattern.h): constant, slope, and what they leave.
    const double n = sums.cycles, spread = 1 - sums.u * sums.u / (n * sums.uu);
    double explained = 0;
    for (int p = 0; p < 60; ++p) {
        const double constant = (sums.late[p] / n - sums.u / (n * sums.uu) * sums.late_u[p]) / spread;
        EXPECT_NEAR(constant, p < 58 ? 0.1 * kRad * std::sin(p) : 0, 1e-7);
        explained += constant * sums.late[p] / 58;
    }
    EXPECT_GT(spread, 0.05);
    EXPECT_NEAR(std::sqrt((sums.square - explained) / (n - 2) / (n * spread)), 0.03 / 1.96 * kRad, 2e-6);
    found.pattern_refused = "one speed alone";
    EXPECT_THROW(kept_of(found, "made"), InputError);
}

TEST(EngineText, NewNumbersStandInPlaceAndEveryNumberSaysWhereItIsFrom) {
    const std::string text = "name = \"x\" # a name\n[crank]\ninertia_kgm2 = 0.25  # guessed\nreciprocating_mass_kg = 0.9\n[cylinders]\n"
                             "firing_tdc_deg = [0,\n  180]  # even\n";
    const std::string made = engine_with("old.toml", text, {{"crank.inertia_kgm2", {"0.21", "measured"}}, {"tolerance.wheel_offset_deg",
        {"0.2", "half"}},
                                          {"tolerance.inertia_percent", {"3", "too"}}});
    EXPECT_EQ(made,
        "name = \"x\" # a name\n[crank]\ninertia_kgm2 = 0.21  # measured; guessed\nreciprocating_mass_kg = 0.9  # taken from old.toml\n"
                    "[cylinders]\nfiring_tdc_deg = [0,\n  180]  # taken from old.toml; even\n\n[tolerance]\n"
                    "wheel_offset_deg = 0.2  # half\ninertia_percent = 3  # too\n");
}

} // namespace
