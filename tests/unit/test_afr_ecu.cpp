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
            std::printf("2500 rpm, sensor %d, q31 %d: error after 4 cycles %.0f %%, after 20 %.0f %% of the step\n", sensor, q31, 100 * fast.error(4),
                        100 * fast.error(20));
            EXPECT_LT(fast.error(20), 0.35);
        }
    }
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
