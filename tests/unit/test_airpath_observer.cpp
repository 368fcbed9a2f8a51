// SPDX-License-Identifier: MIT
// Document 001's observers, decision and ecu stage on the four-state model: what docs/results/airpath.md says of the matched plant.
#include <Eigen/Core>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <memory>

#include "studies/airpath/matched_delay.hpp"
#include "studies/airpath/matched_false.hpp"
#include "studies/airpath/matched_filter.hpp"
#include "support/airpath_setup.hpp"
extern "C" {
#include "sd_stage_airpath.h"
}

using namespace sixdeg;
using sixdeg::test::setup;
using sixdeg::test::kDesign;

namespace {

constexpr double kUsual = 12, kRare = 18.5;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
sd_airpath_in_f32_t middle() {
    sd_airpath_in_f32_t in{};
    in.speed_rpm = 1500, in.air_gps = 113, in.fuel_gps = 7;
    in.charge_k = 310, in.egr_k = 370, in.exhaust_k = 720;
    in.egr_opening = 0.35f, in.vgt_position = 0.44f;
    in.intake_kpa = 153.4f, in.exhaust_kpa = 174.5f;
    return in;
}

MeanValueInput middle_input() { return {1500 * M_PI / 30, 0.113, 0.007, 0.35, 0.44}; }

} // namespace

TEST(AirPathModel, DesignPlantAndFirmwareObeyTheSameEquations) {
    TomlFile file{std::filesystem::path(kDesign)};
    const auto designed = file.numbers("design.middle_state", {0, 1e3, ""}, 4);
    MeanValueModel plant(setup().system, setup().displaced_m3);
    plant.rest(middle_input());
    const double real[] = {1e-3 * plant.intake_pa(), 1e3 * plant.air_kg(), 1e3 * plant.egr_kg(), 1e3 * plant.exhaust_kg()};
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(designed[i], real[i], 2e-5 * real[i]) << i;
    const sd_airpath_tables_f32_t &t = setup().design.tables;
    sd_airpath_now_f32_t now;
    sd_airpath_in_f32_t in = middle();
    sd_airpath_prepare_f32(&t.model, &in, &now);
    for (const double exhaust_kpa : {120.0, 174.5, 260.0}) {
        sd_airpath_flows_f32_t found;
        sd_airpath_flow_f32(&t.model, &now, 118.0f, float(exhaust_kpa), &found);
        const MeanValueFlows real_flows = plant.flows(middle_input(), 118e3, 1e3 * exhaust_kpa);
        EXPECT_NEAR(found.egr_gps, 1e3 * real_flows.egr_kgps, 1e-4 * 40);
        EXPECT_NEAR(found.turbine_gps, 1e3 * real_flows.turbine_kgps, 1e-3 * 1e3 * real_flows.turbine_kgps);
    }
    sd_airpath_flows_f32_t flows;
    float rate[4];
    const float x[4] = {float(real[0]), float(real[1]), float(real[2]), float(real[3])};
    sd_airpath_flow_f32(&t.model, &now, x[0], now.per_exhaust * x[3], &flows);
    sd_airpath_rate_f32(&in, &now, x, &flows, rate);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(rate[i], 0, i == 0 ? 0.5 : 0.2) << i;
}

TEST(Nuio, IsEquationSevenWithNAndLWritten) {
    using Eigen::Matrix;
    const sd_nuio_table_f32_t &t = setup().design.tables.observer[0];
    Matrix<double, 4, 4> m, a = Matrix<double, 4, 4>::Zero();
    Matrix<double, 4, 2> e, k;
    Matrix<double, 2, 4> c = Matrix<double, 2, 4>::Zero();
    c(0, 0) = c(1, 3) = 1;
    const double share = 0.3, rate = 4.5;
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) m(i, j) = t.m[i][j];
        for (int j = 0; j < 2; ++j) e(i, j) = t.e[i][j], k(i, j) = t.k[i][j] + share * t.more[i][j];
    }
    a(0, 0) = a(1, 1) = a(2, 2) = -rate, a(3, 1) = a(3, 2) = rate;
    EXPECT_LT((m - Matrix<double, 4, 4>::Identity() - e * c).norm(), 1e-6);
    const Matrix<double, 4, 4> n = m * a - k * c;
    const Matrix<double, 4, 2> l = k * (Matrix<double, 2, 2>::Identity() + c * e) - m * a * e;
    sd_nuio_f32_t self{{31, 25, 5, 0.4f}};
    const Eigen::Vector4d z(31, 25, 5, double(0.4f)), drive(560, 110, 20, -130);
    const float y[2] = {151, 5.1f};
    const Eigen::Vector2d outputs(151, double(5.1f));
    sd_nuio_estimate_f32_t at;
    sd_nuio_look_f32(&self, &t, y, &at);
    const Eigen::Vector4d xhat = z - e * outputs, whole = a * xhat + drive;
    const float at_rate[4] = {float(whole(0)), float(whole(1)), float(whole(2)), float(whole(3))};
    sd_nuio_step_f32(&self, &t, &at, at_rate, float(share), 0.01f);
    const Eigen::Vector4d expected = z + 0.01 * (n * z + l * outputs + m * drive);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(self.z[i], expected(i), 2e-4) << i;
}

TEST(Cusum, NamesTheHypothesisThatComesTrueAndItsTime) {
    const sd_cusum_tables_f32_t &t = setup().design.tables.cusum;
    const sd_cusum_thresholds_f32_t h{10, 10};
    for (int l = 0; l < 4; ++l) {
        const int residual = l < 2 ? 1 : 0;
        sd_cusum_f32_t c;
        sd_cusum_start_f32(&c);
        sd_cusum_out_f32_t out{};
        float none[2] = {0, 0}, fault[2] = {0, 0};
        fault[residual] = (l % 2 ? -1.0f : 1.0f) * float(setup().design.mean_kpa[std::size_t(residual)]);
        for (int i = 0; i < 50; ++i) sd_cusum_step_f32(&c, &t, &h, none, &out);
        EXPECT_EQ(0, out.named);
        int steps = 0;
        while (out.named == 0 && steps < 500) sd_cusum_step_f32(&c, &t, &h, fault, &out), steps++;
        EXPECT_EQ(l + 1, out.named);
        EXPECT_EQ(std::uint32_t(steps), out.since_steps);
        EXPECT_EQ(1 << t.group[l], out.groups);
        EXPECT_NEAR(steps, 10 / double(t.offset[l]), 1.01) << "kappa of (29) for the mean that it expects";
        for (int i = 0; i < 100000; ++i) sd_cusum_step_f32(&c, &t, &h, fault, &out);
        EXPECT_EQ(l + 1, out.named);
        for (int i = 0; i < 3 * steps + 5; ++i) sd_cusum_step_f32(&c, &t, &h, none, &out);
        EXPECT_EQ(0, out.named) << "a fault that ends is no longer named, however long it was there";
    }
}

TEST(Cusum, RefusesTablesThatAreNone) {
    sd_cusum_tables_f32_t t = setup().design.tables.cusum;
    EXPECT_TRUE(sd_cusum_tables_ok_f32(&t));
    t.weight[1][1] = kNan;
    EXPECT_FALSE(sd_cusum_tables_ok_f32(&t));
    t = setup().design.tables.cusum;
    t.hypotheses = 9;
    EXPECT_FALSE(sd_cusum_tables_ok_f32(&t));
    const sd_cusum_thresholds_f32_t none{0, 10};
    EXPECT_FALSE(sd_cusum_thresholds_ok_f32(&none));
}

TEST(AirPathMatched, AResidualIsBlindToItsOwnFault) {
    for (const MatchedFault &fault : matched_faults()) {
        const auto end = trace_fault(setup(), fault).end_kpa;
        const std::size_t own = fault.actuator == SD_AIRPATH_EGR_FAULT ? 1 : 0;
        EXPECT_LT(std::abs(end[1 - own]), 0.01 * std::abs(end[own])) << fault.name;
    }
}

// Thresholds of one false alarm in 4 h and in 2,000 h: docs/results/airpath.md.
TEST(AirPathMatched, DelaysAreWithinTheirGoals) {
    const double threshold[2] = {kUsual, kRare}, goal[2][4] = {{0.18, 0.07, 0.32, 0.14}, {0.26, 0.11, 0.45, 0.20}};
    for (const std::size_t rare : {0u, 1u}) {
        for (std::size_t i = 0; i < 4; ++i) {
            const MatchedFault &fault = matched_faults()[i];
            const DelayFigures f = measure_delay(setup(), fault, threshold[rare], 100, 1);
            EXPECT_LT(f.mean_s + 2 * f.sd_s, goal[rare][i]) << fault.name;
            EXPECT_LE(f.wrong, 1);
            EXPECT_EQ(0, f.missed);
            EXPECT_GT(f.mean_s, 0.4 * goal[rare][i]) << "too good to be true";
        }
    }
}

TEST(AirPathMatched, FalseAlarmsAreAsRareAsTheirThresholdsSay) {
    const auto rates = sample_alarm_rates(setup(), {kUsual, kRare}, 0.3, 1);
    EXPECT_LT(rates[0].per_hour, 0.5);
    EXPECT_GT(rates[0].per_hour, 0.05);
    EXPECT_LT(rates[1].per_hour, 1e-3);
    EXPECT_GT(rates[1].per_hour, 5e-5);
    EXPECT_LE(count_false_alarms(setup(), kUsual, 1, 1).alarms, 2);
    EXPECT_GE(count_false_alarms(setup(), 5, 0.05, 1).alarms, 5) << "a low threshold is passed";
}

TEST(AirPathMatched, BothFaultsAtOnceAreSaidAndNotGuessed) {
    RandomStream random(1, 9);
    MatchedRun run(setup(), 18, 18, random);
    while (!run.decides()) run.step(draw_noise(random));
    run.set_fault({"both", 0.1, -0.1, SD_AIRPATH_UNCLEAR});
    for (int i = 0; i < 100; ++i) run.step(draw_noise(random));
    for (int i = 0; i < 200; ++i) {
        run.step(draw_noise(random));
        EXPECT_EQ(SD_AIRPATH_UNCLEAR, run.out().fault);
    }
}

TEST(AirPathOffsets, AFaultThatWasThereAtTheStartIsLearnedAndSaidToBeSuspect) {
    for (const double egr : {0.0, 0.1}) {
        RandomStream random(1, 10);
        MatchedRun plant(setup(), 18, 18, random);
        plant.set_fault({"", egr, 0, SD_AIRPATH_EGR_FAULT});
        sd_airpath_bank_f32_t bank;
        sd_airpath_start_f32(&bank);
        const sd_airpath_config_f32_t config{200, 400, {18, 18}};
        sd_airpath_out_f32_t out{};
        for (int i = 0; i < 800; ++i) {
            plant.step(draw_noise(random));
            sd_airpath_step_f32(&bank, &setup().design.tables, &config, &plant.readings(), &out);
        }
        EXPECT_EQ(SD_AIRPATH_DECIDES, out.phase);
        EXPECT_EQ(egr > 0 ? SD_DEGRADED : SD_VALID, out.status.health);
        EXPECT_EQ(egr > 0, (out.status.why & SD_WHY_LEARNED) != 0);
        EXPECT_NEAR(out.offset_faults[1], egr > 0 ? 1.4 : 0, 0.3);
    }
}

namespace {

/// The ecu's stage on the matched plant: its inputs as the port would have them.
struct Stage {
    std::unique_ptr<sd_calibration_t> page = std::make_unique<sd_calibration_t>();
    sd_stage_airpath_t stage{};
    sd_inputs_t inputs{};
    sd_stage_airpath_out_t out{};
    RandomStream random{1, 11};
    MatchedRun plant{setup(), 18, 18, random};
    std::uint32_t tick = 0;
    std::int32_t dead = -1;      ///< An input that says nothing.
    std::int32_t stuck = -1;     ///< An input that repeats itself.
    float offset_of_stuck = 0;   ///< Out of range where it is large.
    bool turns = true;
    float stuck_value = 0;

    Stage() {
        page->tick_hz = 1e6f;
        page->cylinders = 6;
        page->airpath = setup().design.tables;
        float *parameter = reinterpret_cast<float *>(&page->parameters);
        for (const sd_signal_info_t &info : sd_parameter_infos) *parameter++ = info.value;
        EXPECT_EQ(SD_OK, sd_stage_airpath_init(&stage, page.get(), &page->parameters));
    }

    void say(sd_input_t input, float value) {
        if (input == dead) return;
        if (input == stuck) value = stuck_value + offset_of_stuck;
        sd_inputs_take(&inputs, std::uint16_t(input), tick, value);
    }
    void step() {
        plant.step(draw_noise(random));
        const sd_airpath_in_f32_t &in = plant.readings();
        if (stuck >= 0 && stuck_value == 0) stuck_value = inputs.reading[stuck].value;
        say(SD_INPUT_AIR_FLOW, in.air_gps), say(SD_INPUT_AIR_INTAKE_PRESSURE, in.intake_kpa / 100);
        say(SD_INPUT_EXHAUST_PRESSURE, in.exhaust_kpa / 100), say(SD_INPUT_EXHAUST_TEMPERATURE, in.exhaust_k);
        say(SD_INPUT_AIR_CHARGE_TEMPERATURE, in.charge_k), say(SD_INPUT_EGR_TEMPERATURE, in.egr_k);
        say(SD_INPUT_EGR_POSITION, in.egr_opening), say(SD_INPUT_VGT_POSITION, in.vgt_position);
        say(SD_INPUT_EGR_COMMAND, in.egr_opening), say(SD_INPUT_VGT_COMMAND, in.vgt_position);
        say(SD_INPUT_FUEL_INJECTED, in.fuel_gps * 1e3f / (in.speed_rpm / 120 * 6));
        tick += 10000;
        sd_inputs_age(&inputs, tick, page->tick_hz);
        const sd_stage_airpath_crank_t crank{in.speed_rpm, std::uint8_t(turns ? SD_VALID : SD_INVALID), 6};
        sd_stage_airpath_step(&stage, page.get(), &inputs, &crank, tick, &out);
    }
    void run(int steps) {
        for (int i = 0; i < steps; ++i) step();
    }
};

} // namespace

TEST(AirPathStage, DecidesAfterSettlingAndLearningAndNamesAFault) {
    Stage s;
    s.run(100);
    EXPECT_EQ(SD_INVALID, s.out.status.health);
    s.run(600);
    EXPECT_EQ(SD_AIRPATH_DECIDES, s.out.phase);
    EXPECT_EQ(SD_VALID, s.out.status.health) << s.out.status.why;
    EXPECT_EQ(SD_AIRPATH_NO_FAULT, s.out.fault);
    s.plant.set_fault(matched_faults()[1]);
    s.run(20);
    EXPECT_EQ(SD_AIRPATH_VGT_FAULT, s.out.fault);
    EXPECT_EQ(SD_VALID, s.out.status.health);
    EXPECT_NEAR(s.out.since_s, 0.2, 0.03);
}

TEST(AirPathStage, ASensorThatIsSilentStuckOrOutOfRangeNamesNoFaultAndIsInvalidWithinItsAge) {
    const sd_input_t sensors[] = {SD_INPUT_AIR_FLOW, SD_INPUT_AIR_INTAKE_PRESSURE, SD_INPUT_EXHAUST_PRESSURE, SD_INPUT_EGR_POSITION,
                                  SD_INPUT_VGT_POSITION};
    enum Kind { silent, stuck, far_off };
    for (const sd_input_t sensor : sensors) {
        for (const Kind kind : {silent, stuck, far_off}) {
            if (kind == stuck && (sensor == SD_INPUT_EGR_POSITION || sensor == SD_INPUT_VGT_POSITION)) continue; // a position may rest
            Stage s;
            s.run(700);
            ASSERT_EQ(SD_VALID, s.out.status.health);
            const sd_airpath_offsets_f32_t learned = s.stage.in.f32.bank.offsets;
            (kind == silent ? s.dead : s.stuck) = sensor;
            s.offset_of_stuck = kind == far_off ? 1e5f : 0;
            const int limit = int(std::ceil(sd_input_infos[sensor].age_s / 0.01f)) + 2;
            for (int i = 0; i < limit + 300; ++i) {
                s.step();
                EXPECT_EQ(SD_AIRPATH_NO_FAULT, s.out.fault) << sensor << " " << kind << " " << i;
                if (i > 5) { EXPECT_NE(SD_VALID, s.out.status.health) << sensor << " " << kind << " " << i; }
                if (i >= limit) { EXPECT_EQ(SD_INVALID, s.out.status.health); }
            }
            EXPECT_EQ(0, std::memcmp(learned.per_flow, s.stage.in.f32.bank.offsets.per_flow, sizeof learned.per_flow));
            s.dead = s.stuck = -1;
            s.run(300);
            EXPECT_EQ(SD_VALID, s.out.status.health) << "it goes on with what it learned";
        }
    }
}

TEST(AirPathStage, AnEngineThatStandsStillIsNotJudged) {
    Stage s;
    s.run(700);
    s.turns = false;
    s.step();
    EXPECT_EQ(SD_INVALID, s.out.status.health);
    EXPECT_EQ(SD_AIRPATH_WAITS, s.out.phase);
}

TEST(AirPathTables, RefusesNumbersOutOfRange) {
    sd_airpath_tables_f32_t t = setup().design.tables;
    EXPECT_TRUE(sd_airpath_tables_ok_f32(&t));
    t.observer[1].e[2][1] = kNan;
    EXPECT_FALSE(sd_airpath_tables_ok_f32(&t));
    t = sd_airpath_tables_f32_t{};
    EXPECT_TRUE(sd_airpath_tables_ok_f32(&t)) << "none at all is fine";
    t.present = 1;
    EXPECT_FALSE(sd_airpath_tables_ok_f32(&t));
}
