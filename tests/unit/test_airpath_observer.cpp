// SPDX-License-Identifier: MIT
// Document 001's observers, decision and ecu stage on the four-state model: what docs/airpath.md says of the matched plant.
#include <Eigen/Core>
#include <cmath>
#include <cstring>
#include <gtest/gtest.h>
#include <limits>
#include <memory>

#include "design/airpath/fixed_tables.hpp"
#include "studies/airpath/matched_delay.hpp"
#include "studies/airpath/matched_false.hpp"
#include "studies/airpath/matched_filter.hpp"
extern "C" {
#include "sd_stage_airpath.h"
}

using namespace sixdeg;

namespace {

constexpr double kUsual = 12, kRare = 18.5;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const std::string kAirPath = SD_MODELS "/airpath_matched.toml", kDesign = SD_MODELS "/airpath_matched_design.toml";

const MatchedSetup &setup() {
    static const MatchedSetup read = read_matched_setup(kAirPath, kDesign);
    return read;
}

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

// Thresholds of one false alarm in 4 h and in 2,000 h: docs/airpath.md.
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

// ---- fixed point --------------------------------------------------------------------------------------------------

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

// Whatever sensors say within their ranges: no sum overflows (the sanitized build looks), and an estimate at the end of its range is given up.
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
