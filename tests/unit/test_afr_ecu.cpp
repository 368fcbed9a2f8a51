// SPDX-License-Identifier: MIT
// Document 004's chain in the ecu: a fuel step on one cylinder as the whole firmware finds it, in f32 and in q31, with a pressure
// sensor in the exhaust manifold and without.
#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>

#include "design/calibration.hpp"
#include "loop/bench_run.hpp"
#include "loop/ecu_bench.hpp"
#include "support/afr_step.hpp"

using namespace sixdeg;

namespace {

/// The estimates as the cycles' rows say them, by physical cylinder.
class Listener : public EcuBench {
  public:
    using EcuBench::EcuBench;
    void send(const sd_event_t &event) override {
        if (exchange(event)) cycles.push_back(std::vector<double>(signals().afr_cylinder_burned, signals().afr_cylinder_burned + 4));
        worst_health = std::max(worst_health, cycles.size() > 20 ? health(SD_OWNER_AFR) : std::uint8_t(SD_VALID));
    }
    std::vector<std::vector<double>> cycles;
    std::uint8_t worst_health = SD_VALID;
};

constexpr int kStepCycle = 30, kCycles = 70;

struct EcuStep {
    EcuStep(double rpm, bool sensor, bool q31, const std::vector<std::string> &more = {}) : scenario(step_scenario(rpm, 9)) {
        scenario.uego->sample_s = 250e-6;
        if (sensor) scenario.exhaust_sensors = ExhaustSensorSetup{250e-6, 0, 0.2e-3, false, false};
        TomlFile tune("t", "");
        tune.set("afr.method=3");
        tune.set(q31 ? "afr.arithmetic=1" : "afr.arithmetic=0");
        for (const std::string &set : more) tune.set(set);
        const sd_calibration_t page = calibrate(scenario.engine.shared, read_tune(tune), "t");
        Listener ecu(page);
        run_scenario(scenario, page, ecu, nullptr);
        cycles = ecu.cycles, worst_health = ecu.worst_health;
        const AfrTrace trace = afr_trace(scenario);
        const auto &order = scenario.engine.shared.firing_order;
        truth.resize(4);
        for (std::size_t lane = 0; lane < 4; ++lane) truth[std::size_t(order[lane] - 1)] = trace.lambda.back()[lane];
        before = trace.lambda[kStepCycle * 120][0];
    }
    /// Largest error of a cylinder in the row of so many cycles after the first exhaust with the step, of the step.
    double error(int cycles_after) const {
        const std::size_t row = cycles.size() - kCycles + kStepCycle + std::size_t(cycles_after) + 1;
        double worst = 0;
        for (std::size_t i = 0; i < 4; ++i) worst = std::max(worst, std::abs(cycles.at(row)[i] - truth[i]));
        return worst / std::abs(truth[0] - before);
    }
    Scenario scenario;
    std::vector<std::vector<double>> cycles;
    std::vector<double> truth;
    double before = 0;
    std::uint8_t worst_health = SD_VALID;
};

/// Within 20 % of a step of 20 % after 4 cycles, and not before it was there to be seen.
TEST(AfrEcu, TheChainFindsAFuelStepInFourCycles) {
    for (bool sensor : {false, true}) {
        for (bool q31 : {false, true}) {
            const EcuStep step(1500, sensor, q31);
            EXPECT_GT(step.error(0), 0.3) << "nothing of it has arrived";
            for (int c = 4; c < 30; ++c) EXPECT_LT(step.error(c), 0.2) << c << " sensor " << sensor << " q31 " << q31;
            EXPECT_EQ(step.worst_health, SD_VALID);
            const EcuStep fast(2500, sensor, q31);
            std::printf("2500 rpm, sensor %d, q31 %d: error after 4 cycles %.0f %%, after 20 %.0f %% of the step\n", sensor, q31,
                        100 * fast.error(4),
                        100 * fast.error(20));
            EXPECT_LT(fast.error(20), 0.35);
        }
    }
}

/// An ecu whose pressure sensor falls silent after 3 s.
class Silent : public Listener {
  public:
    explicit Silent(const sd_calibration_t &page) : Listener(page), tick_hz_(double(page.tick_hz)) {}
    void send(const sd_event_t &event) override {
        const double t_s = event.tick / tick_hz_;
        if (t_s > 3 && event.kind == SD_EVENT_SAMPLE && event.channel == SD_INPUT_EXHAUST_PRESSURE) return;
        Listener::send(event);
        if (t_s > 2 && t_s < 3) before = std::max(before, health(SD_OWNER_AFR));
        if (t_s > 3.2 && t_s < 3.4) within_age = std::max(within_age, health(SD_OWNER_AFR));
        if (t_s > 4) after = std::min(after, health(SD_OWNER_AFR));
    }
    std::uint8_t before = SD_VALID, within_age = SD_VALID, after = SD_INVALID;

  private:
    double tick_hz_;
};

/// A sensor that was there and says nothing any more: the model goes on alone, and the status says so.
TEST(AfrEcu, APressureSensorThatFallsSilentIsSaid) {
    Scenario scenario = step_scenario(1500, 9);
    scenario.exhaust_sensors = ExhaustSensorSetup{};
    for (const char *gain : {"afr.gain_mass=0.1", "afr.gain_mass=0"}) {
        TomlFile tune("t", "");
        tune.set("afr.method=3");
        tune.set(gain);
        const sd_calibration_t page = calibrate(scenario.engine.shared, read_tune(tune), "t");
        Silent ecu(page);
        run_scenario(scenario, page, ecu, nullptr);
        EXPECT_EQ(ecu.before, SD_VALID);
        EXPECT_EQ(ecu.within_age, SD_VALID);
        EXPECT_EQ(ecu.after, gain[14] == '0' && gain[15] == 0 ? SD_VALID : SD_DEGRADED) << gain;
        for (double burned : ecu.cycles.back()) EXPECT_NEAR(burned, ecu.cycles.at(ecu.cycles.size() - 30)[0], 0.2);
    }
}

sd_parameters_t default_tune() {
    TomlFile tune("t", "");
    return read_tune(tune);
}

/// An ecu that hears nothing of the EGR valve.
class Deaf : public EcuBench {
  public:
    using EcuBench::EcuBench;
    void send(const sd_event_t &event) override {
        if (event.kind != SD_EVENT_SAMPLE || event.channel != SD_INPUT_EGR_POSITION) EcuBench::send(event);
    }
};

/// Some 20 % of what leaves the manifold goes back into the intake.
TEST(AfrEcu, RecirculatedGasIsNoMixtureOfTheCylinders) {
    TomlFile file("s", "engine = \"diesel_22.toml\"\n[run]\ncycles = 70\n[speed]\nmode = \"prescribed\"\nrpm = 1500\n"
                       "[uego]\n[load]\nbmep_bar = 9\n"
                       "[cylinders]\nfuel_percent = [15, -5, -5, -5]\n");
    Scenario scenario = read_scenario(file, SD_ENGINES);
    scenario.engine.intake_pressure_pa = Profile(1.3e5);
    scenario.engine.exhaust.egr_area_m2 = 2e-4;
    const double share = afr_trace(scenario).egr_share;
    EXPECT_NEAR(share, 0.2, 0.03);
    const sd_calibration_t page = calibrate(scenario.engine.shared, default_tune(), "t");
    EcuBench told(page);
    Deaf deaf(page);
    const auto with = run_scenario(scenario, page, told, nullptr).afr, without = run_scenario(scenario, page, deaf, nullptr).afr;
    ASSERT_TRUE(with && without);
    std::printf("20 %% recirculated: error of a cylinder's mixture %.2f points, %.2f where the ecu knows the valve; "
                "share %.3f, found %.3f\n",
                without->rms_points, with->rms_points, share, double(told.ecu().mixture.egr_share));
    EXPECT_GT(without->rms_points, 1);
    EXPECT_LT(with->rms_points, 0.5 * without->rms_points);
    EXPECT_NEAR(double(told.ecu().mixture.egr_share), share, 0.03);
    EXPECT_EQ(deaf.ecu().mixture.egr_share, 0);
}

TEST(AfrEcu, TheRecirculatedShareIsABalanceOfMasses) {
    const Scenario scenario = step_scenario(1500, 9);
    const sd_calibration_t page = calibrate(scenario.engine.shared, default_tune(), "t");
    const auto ecu = std::make_unique<sd_ecu_t>();
    ASSERT_EQ(sd_ecu_init(ecu.get(), &page), SD_OK);
    sd_stage_mixture_t &mixture = ecu->mixture;
    const double fuel_mg = 30, all_mg = 1e6 * double(page.afr.air_kg_per_bar) * 1.3 + fuel_mg, fresh_mg = 0.75 * all_mg, s = 14.6,
        radps = 157;
    sd_afr_conditions_t at{float(radps), 1.3f, float(fuel_mg), 0, 0, 0, 0};
    const auto share = [&](double air_mg, double opening) {
        const sd_mixture_egr_t egr{&at, float(s), float(air_mg * 1e-3 * 4 * radps / (4 * M_PI)), float(opening)};
        float found = 0;
        for (int k = 0; k < 100; ++k) found = sd_stage_mixture_recirculated(&mixture, &page, &egr);
        return double(found);
    };
    EXPECT_NEAR(share(fresh_mg - fuel_mg, 0.5), 0.25, 1e-3) << "by the air meter";
    EXPECT_EQ(share(fresh_mg - fuel_mg, 0.01), 0) << "the valve is shut";
    EXPECT_EQ(share(0, 1), 0) << "neither air nor mixture is known";
    mixture.afr.cycles = 20, mixture.afr.mean_lambda = float((1 + s) * fuel_mg / fresh_mg);
    EXPECT_NEAR(share(0, 1), 0.25, 1e-3) << "by what the exhaust has left";
    EXPECT_NEAR(share(2 * all_mg, 1), 0, 1e-4) << "more air than the cylinders take";
    at.intake_bar = NAN;
    EXPECT_EQ(share(0, 1), 0);
}

/// The operating point where it is known: temperature, vanes and the turbine's speed against what the grid takes for granted.
TEST(AfrPoint, FollowsWhatIsMeasuredOfTheExhaust) {
    const Scenario scenario = step_scenario(1500, 9);
    TomlFile tune("t", "");
    const sd_calibration_t page = calibrate(scenario.engine.shared, read_tune(tune), "t");
    sd_afr_point_config_t c{120, 4, {}, 0, 0.3f, 100000};
    for (int i = 0; i < 4; ++i) c.firing_position[i] = page.firing_position[i];
    const auto f32_at = [&](const sd_afr_conditions_t &at) {
        sd_afr_point_f32_t p;
        EXPECT_EQ(sd_afr_point_init_f32(&p, &c, &page.afr), SD_OK);
        EXPECT_TRUE(sd_afr_point_begin_f32(&p, &at, 0.5f));
        while (sd_afr_point_work_f32(&p, &page.afr, 0) == SD_AFR_MORE) {}
        return p;
    };
    const auto q31_at = [&](const sd_afr_conditions_t &at) {
        sd_afr_point_q31_t p;
        EXPECT_EQ(sd_afr_point_init_q31(&p, &c, &page.afr), SD_OK);
        EXPECT_TRUE(sd_afr_point_begin_q31(&p, &at, sd_scaled_of(0.5f)));
        while (sd_afr_point_work_q31(&p, &page.afr, 0) == SD_AFR_MORE) {}
        return p;
    };
    const sd_afr_conditions_t usual{157, 1.5f, 20, 0, 0, 0, 0};
    const sd_afr_point_f32_t before = f32_at(usual);
    for (const auto &[at, rate, mass] : {std::tuple{sd_afr_conditions_t{157, 1.5f, 20, 0, 0.8f, 0, 0}, 0.8, 1.0},
                                         {sd_afr_conditions_t{157, 1.5f, 20, 0, 0, 200000, 0}, 1 - 0.3 * 3, 1.0},
                                         {sd_afr_conditions_t{157, 1.5f, 20, 0, 0, 100000, 0}, 1.0, 1.0},
                                         {sd_afr_conditions_t{157, 1.5f, 20, 0, 0, 0, 0.2f}, 1.25, 1.0}, {usual, 1.0, 1.0}}) {
        const sd_afr_point_f32_t f32 = f32_at(at);
        const sd_afr_point_q31_t q31 = q31_at(at);
        EXPECT_NEAR(double(f32.rate_hz / before.rate_hz), rate, 1e-5);
        EXPECT_NEAR(double(f32.z0_kg / before.z0_kg), mass, 1e-5);
        EXPECT_NEAR(double(sd_scaled_to_float(q31.rate_hz) / before.rate_hz), rate, 1e-5);
        for (std::size_t k = 0; k < SD_EXHAUST_OPEN; ++k)
            ASSERT_NEAR(double(sd_to_float_q31(q31.exhaust.share[q31.exhaust.present][k + 1])),
                        double(f32.exhaust.share[f32.exhaust.present][k + 1]), 1e-5);
    }
    const sd_afr_point_f32_t hot = f32_at({157, 1.5f, 20, 1600, 0, 0, 0}), cold = f32_at({157, 1.5f, 20, 400, 0, 0, 0});
    EXPECT_NEAR(double(hot.rate_hz / cold.rate_hz), 2, 1e-4) << "the square root of the temperatures";
    EXPECT_NEAR(double(hot.z0_kg / cold.z0_kg), 0.25, 1e-5);
    EXPECT_NEAR(double(sd_scaled_to_float(q31_at({157, 1.5f, 20, 1600, 0, 0, 0}).z0_kg) / cold.z0_kg), 0.25, 1e-5);
    sd_afr_point_f32_t p;
    EXPECT_EQ(sd_afr_point_init_f32(&p, &c, &page.afr), SD_OK);
    const sd_afr_conditions_t stopped{0, 1.5f, 20, 0, 0, 0, 0}, nothing{NAN, 1, 1, 0, 0, 0, 0};
    EXPECT_FALSE(sd_afr_point_begin_f32(&p, &stopped, 0.5f));
    EXPECT_FALSE(sd_afr_point_begin_f32(&p, &nothing, 0.5f));
    EXPECT_EQ(sd_afr_point_work_f32(&p, &page.afr, 0), SD_AFR_DONE);
}

TEST(AfrEcu, FixedPointSaysWhatFloatSays) {
    const EcuStep f32(1500, true, false), q31(1500, true, true);
    ASSERT_EQ(f32.cycles.size(), q31.cycles.size());
    double most = 0;
    for (std::size_t c = 12; c < f32.cycles.size(); ++c)
        for (std::size_t i = 0; i < 4; ++i) most = std::max(most, std::abs(f32.cycles[c][i] - q31.cycles[c][i]));
    EXPECT_GT(most, 0) << "two arithmetics";
    EXPECT_LT(most, 1e-3);
}

} // namespace
