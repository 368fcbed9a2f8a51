// SPDX-License-Identifier: MIT
// What the calibration believes of a firing, against the simulated engine, which shares no code with it; and the map from
// coefficients to cylinders.
#include <cmath>
#include <gtest/gtest.h>

#include "design/calibration.hpp"
#include "design/torque/cylinder_map.hpp"
#include "design/torque/known_torque.hpp"
#include "design/torque/observer_map.hpp"
#include "design/perturbation.hpp"
#include "design/torque/pulse.hpp"
#include "plant/scenario/plant.hpp"

using namespace sixdeg;

namespace {

Scenario balanced(double rpm) {
    return read_scenario(std::filesystem::path(SD_ENGINES) / ".." / "scenarios" / "balance_1000rpm_5bar.toml",
                         {"cylinders.fuel_percent=[0,0,0,0]", "run.cycles=6", "speed.rpm=" + std::to_string(rpm)});
}

sd_parameters_t defaults() {
    TomlFile tune("tune", "");
    return read_tune(tune);
}

TEST(CylinderPulse, AgreesWithTheSimulatedEngine) {
    for (double rpm : {1000.0, 3000.0}) {
        const Scenario scenario = balanced(rpm);
        Plant plant(scenario, 1);
        std::vector<StepTruth> steps;
        plant.record_steps(&steps);
        EncoderEdge edge;
        while (plant.next_edge(edge)) {}
        const CylinderPulse pulse = cylinder_pulse(scenario.engine.shared, 0);
        const double intake_bar = plant.intake_pressure_pa() / 1e5;
        double mean = 0, combustion_error = 0, motored_error = 0, combustion_peak = 0, motored_peak = 0;
        std::vector<StepTruth> cycle;
        for (const StepTruth &step : steps) {
            if (step.angle_rad > 16 * M_PI && step.angle_rad <= 20 * M_PI + 1e-9) cycle.push_back(step);
        }
        for (const StepTruth &step : cycle) mean += step.combustion_torque_nm / double(cycle.size());
        for (const StepTruth &step : cycle) {
            double combustion = 0, motored = 0;
            for (int c = 0; c < 4; ++c) {
                const double a = step.angle_rad - M_PI * c;
                combustion += mean * pulse_at(pulse.combustion, a);
                motored += intake_bar * pulse_at(pulse.motored_per_bar, a) + pulse_at(pulse.motored_rest, a);
            }
            const double motored_truth = step.gas_torque_nm - step.combustion_torque_nm;
            combustion_error = std::max(combustion_error, std::abs(combustion - step.combustion_torque_nm));
            motored_error = std::max(motored_error, std::abs(motored - motored_truth));
            combustion_peak = std::max(combustion_peak, step.combustion_torque_nm);
            motored_peak = std::max(motored_peak, std::abs(motored_truth));
        }
        EXPECT_LT(combustion_error, 0.04 * combustion_peak) << rpm;
        EXPECT_LT(motored_error, 0.03 * motored_peak) << rpm;
    }
}

TEST(CylinderPulse, CombustionHasTheMeanOneOverTheHalfTurnAfterTdc) {
    const CylinderPulse pulse = cylinder_pulse(balanced(1000).engine.shared, 0);
    double mean = 0;
    for (int i = 0; i < kPulsePoints / 4; ++i) mean += pulse.combustion[std::size_t(i)] / (kPulsePoints / 4);
    EXPECT_NEAR(1, mean, 1e-9);
    EXPECT_NEAR(pulse.combustion[100], pulse_at(pulse.combustion, 100 * 4 * M_PI / kPulsePoints + 8 * M_PI), 1e-9);
}

TEST(ObserverMap, AHarmonicSettlesInItsOwnCoefficientAlone) {
    const EngineFile engine = balanced(1000).engine.shared;
    const ObserverMap observer(engine, resolve(engine, defaults()));
    const double pitch = 2 * M_PI / observer.positions();
    Eigen::MatrixXd energy(2 * observer.positions(), 1);
    for (int k = 0; k < energy.rows(); ++k) energy(k, 0) = 30 * std::sin(pitch * (k - 0.5)); // torque 30 cos(alpha)
    const Eigen::VectorXd settled = observer.settled(energy);
    for (int j = 0; j < settled.size(); ++j) EXPECT_NEAR(j == 3 ? 30 : 0, settled(j), 0.05) << j;
}

TEST(CylinderMap, NeedsAsManyHarmonicsAsCylinders) {
    const EngineFile engine = balanced(1000).engine.shared;
    sd_parameters_t tune = resolve(engine, defaults());
    EXPECT_EQ(5, tune.torque_harmonics);
    EXPECT_TRUE(cylinder_map(engine, tune));
    tune.torque_harmonics = 3;
    EXPECT_FALSE(cylinder_map(engine, tune));
    EXPECT_EQ(0, calibrate(engine, tune, "tune").cylinder_map.cylinders);
}

TEST(CylinderMap, LeavesLoadOut) {
    const EngineFile engine = balanced(1000).engine.shared;
    const CylinderMap map = *cylinder_map(engine, resolve(engine, defaults()));
    for (int i = 0; i < 4; ++i) {
        EXPECT_NEAR(0, map.map(i, 0), 1e-6);
        EXPECT_GT(map.sd_ratio(i), 0);
    }
}

TEST(KnownTorque, HoldsTheTrappedMassThatIsBelieved) {
    EngineFile engine = balanced(1000).engine.shared;
    const auto nominal = known_torque(engine, defaults());
    engine.trapped_factors = {1.1, 1.1, 1.1, 1.1};
    const auto more = known_torque(engine, defaults());
    EXPECT_GT(std::abs(nominal->motored_per_bar.front()(0.5)), 10);
    EXPECT_NEAR(1.1 * nominal->motored_per_bar.front()(0.5), more->motored_per_bar.front()(0.5), 1e-6);
}

TEST(Perturbation, StaysWithinItsRangesAndRepeats) {
    const EngineFile engine = balanced(1000).engine.shared;
    double largest = 0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed) {
        const Perturbation p = draw_perturbation(engine, seed);
        EXPECT_LE(std::abs(p.inertia_percent), 3);
        EXPECT_LE(std::abs(p.reciprocating_percent), 5);
        EXPECT_LE(std::abs(p.wheel_offset_deg), 0.3);
        for (double percent : p.compression_percent) EXPECT_LE(std::abs(percent), 2);
        largest = std::max(largest, std::abs(p.trapped_mass_percent[0]));
        const EngineFile belief = perturbed(engine, p);
        EXPECT_NEAR(p.inertia_percent, 100 * (belief.inertia_kgm2 / engine.inertia_kgm2 - 1), 1e-9);
    }
    EXPECT_LE(largest, 3);
    EXPECT_GT(largest, 2.5);
    EXPECT_EQ(draw_perturbation(engine, 7).inertia_percent, draw_perturbation(engine, 7).inertia_percent);
    EXPECT_NE(draw_perturbation(engine, 7).inertia_percent, draw_perturbation(engine, 8).inertia_percent);
}

} // namespace
