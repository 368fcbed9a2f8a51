// SPDX-License-Identifier: MIT
// The cylinders and the crank against closed forms and balances that the integrator does not use.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/files.hpp"
#include "plant/engine/gas.hpp"
#include "plant/engine/torsion.hpp"
#include "plant_fixture.hpp"

using namespace plant_test;

namespace {

constexpr double kFuel = 17e-6; // kg, about 5 bar

/// Entropy over R of the working gas, but for a constant: ds = c_v dT/T + R dV/V integrated.
double entropy(double t, double v) {
    return gas::kB0 * std::log(t) + gas::kB1 * t + gas::kB2 * t * t / 2 + std::log(v);
}

struct Cylinder { // of lane 0, watched from outside
    const EngineModel &model;
    const CrankSlider slider;
    double volume() const { return slider.volume_m3(model.truth().angle_rad); }
    double temperature() const { return model.pressure_pa(0) * volume() / (model.trapped_kg(0) * gas::kR); }
    double energy() const { return model.trapped_kg(0) * gas::internal_energy(temperature()); }
};

TEST(PlantCylinder, AdiabaticMotoringIsIsentropicInClosedForm) {
    PlantEngine engine = diesel();
    engine.wall_factor = 0;
    EngineModel model(engine, nominal(engine), 0.5);
    model.start(0, 500, 0, 100); // 250 deg
    turn(model, 661, 0);         // 580.5 deg: intake just closed
    const Cylinder cylinder{model, engine.slider(14)};
    const double start = entropy(cylinder.temperature(), cylinder.volume());
    double hottest = 0;
    for (int step = 0; step < 536; ++step) { // to 848.5 deg, before the exhaust valve opens
        turn(model, 1, 0);
        ASSERT_NEAR(entropy(cylinder.temperature(), cylinder.volume()), start, 1e-8) << step;
        hottest = std::max(hottest, cylinder.temperature());
    }
    EXPECT_GT(hottest, 800); // it did compress
}

// The same of a gas with a gamma of its own: p V^gamma stays.
TEST(PlantCylinder, GammaOfTheFileIsThatOfTheGas) {
    const std::string text = read_file(SD_ENGINES "/diesel_22.toml");
    for (const double gamma : {1.30, 1.38}) {
        PlantEngine engine = read_plant_engine("engine", text + fmt::format("[plant.gas]\ngamma = {}\n", gamma));
        engine.wall_factor = 0;
        EngineModel model(engine, nominal(engine), 0.5);
        model.start(0, 500, 0, 100);
        turn(model, 661, 0);
        const Cylinder cylinder{model, engine.slider(14)};
        const auto invariant = [&] { return std::log(model.pressure_pa(0)) + gamma * std::log(cylinder.volume()); };
        const double start = invariant();
        for (int step = 0; step < 536; ++step) {
            turn(model, 1, 0);
            ASSERT_NEAR(invariant(), start, 1e-8) << gamma << ", " << step;
        }
    }
}

// First law between intake closing and exhaust opening, fired, with wall loss: 0.1 % of the heat asked, 1e-6
// held.
TEST(PlantCylinder, EnergyBalanceOfTheClosedCycle) {
    const PlantEngine engine = diesel();
    EngineModel model(engine, nominal(engine), 0.5);
    model.start(0, 0, 0, 100);
    turn(model, 1160, kFuel); // 580 deg
    const Cylinder cylinder{model, engine.slider(14)};
    const double energy = cylinder.energy(), work = model.work_j(0), lost = model.heat_lost_j(0);
    turn(model, 539, kFuel); // 849.5 deg
    const double heat = model.heat_released_j(0);
    const double residue =
        cylinder.energy() - energy + model.work_j(0) - work + model.heat_lost_j(0) - lost - heat;
    EXPECT_GT(heat, 700);
    EXPECT_GT(model.heat_lost_j(0) - lost, 50);
    EXPECT_LT(std::abs(residue), 1e-6 * heat);
}

// J' w^2/2 + J w' from the recorded motion, with J' in closed form, is the net torque the truth channel
// names.
TEST(PlantCrank, EquationOfMotionHolds) {
    const PlantEngine engine = diesel();
    EngineModel model(engine, nominal(engine), 0.5);
    model.start(0, 0, 0, 150);
    turn(model, 1440, kFuel);
    const CrankSlider slider = engine.slider(14);
    double worst = 0, largest = 0;
    for (int step = 0; step < 1440; ++step) {
        const StepTruth before = model.truth();
        turn(model, 1, kFuel);
        const StepTruth now = model.truth();
        turn(model, 1, kFuel);
        const StepTruth after = model.truth();
        double inertia = engine.shared.inertia_kgm2, slope = 0;
        for (double tdc : engine.shared.firing_tdc_deg) {
            const double theta = now.angle_rad - tdc * kRadPerDeg, x1 = slider.travel_slope_m(theta);
            inertia += 0.95 * x1 * x1;
            slope += 2 * 0.95 * x1 * slider.travel_curvature_m(theta);
        }
        const double acceleration = (after.speed_radps - before.speed_radps) / (after.time_s - before.time_s);
        const double torque = slope * now.speed_radps * now.speed_radps / 2 + inertia * acceleration;
        largest = std::max(largest, std::abs(now.net_torque_nm));
        // Combustion begins with a kink; the central difference is one-sided wrong there.
        worst = std::max(worst, std::abs(torque - now.net_torque_nm));
    }
    EXPECT_GT(largest, 200);
    EXPECT_LT(worst, 0.01 * largest);
}

TEST(PlantCrank, KinematicsAreEachOthersDerivatives) {
    const CrankSlider slider = diesel().slider(14);
    const double d = 1e-5;
    for (double theta = 0.1; theta < 6.2; theta += 0.1) {
        EXPECT_NEAR(slider.travel_slope_m(theta),
                    (slider.travel_m(theta + d) - slider.travel_m(theta - d)) / (2 * d), 1e-9);
        EXPECT_NEAR(slider.travel_curvature_m(theta),
                    (slider.travel_slope_m(theta + d) - slider.travel_slope_m(theta - d)) / (2 * d), 1e-8);
    }
    EXPECT_NEAR(slider.travel_m(kPi), 0.092, 1e-15);
    EXPECT_NEAR(slider.volume_m3(kPi) / slider.volume_m3(0), 14, 1e-12);
}

struct End {
    double pressure, energy, time;
};

End end_of(double step_deg, double fuel) {
    PlantEngine engine = diesel();
    EngineModel model(engine, nominal(engine), step_deg);
    model.start(0, 0, 0, 100);
    model.set_load(fuel > 0 ? 50 : -60, 20); // without fuel the brake drives
    turn(model, int(900 / step_deg),
         fuel); // lane 1 is compressed, lane 0 expands: 180 deg into the second cycle
    return {model.pressure_pa(0), model.energy_j(), model.truth().time_s};
}

// Order from the errors at 1 and 0.5 deg against 0.05 deg; valve events and starts of combustion lie on all
// three grids.
void expect_fourth_order(double fuel) {
    const End fine = end_of(0.05, fuel), half = end_of(0.5, fuel), one = end_of(1, fuel);
    const auto order = [](double coarse, double middle, double exact) {
        return std::log2(std::abs(coarse - exact) / std::abs(middle - exact));
    };
    EXPECT_GT(order(one.energy, half.energy, fine.energy), 3.6);
    EXPECT_GT(order(one.time, half.time, fine.time), 3.6);
    EXPECT_LT(std::abs(half.energy / fine.energy - 1), 1e-7);
    EXPECT_LT(std::abs(half.pressure / fine.pressure - 1), 1e-6);
}

TEST(PlantIntegrator, FourthOrderMotored) { expect_fourth_order(0); }
TEST(PlantIntegrator, FourthOrderFired) { expect_fourth_order(kFuel); }

// Nothing damps here but friction and load, whose work is known, so all energies must add up.
TEST(PlantCrank, DualMassFlywheelConservesEnergy) {
    PlantEngine engine = diesel();
    engine.dual_mass = DualMassFlywheel{0.3, 800, 0};
    for (double &f : engine.fmep_pa) f = 0;
    EngineModel model(engine, nominal(engine), 0.5);
    model.start(0, 0, 0, 100);
    model.set_load(60, 0);
    const auto stored = [&] {
        const double w2 = model.secondary_speed_radps(), twist = model.flywheel_twist_rad();
        return model.energy_j() + 0.3 / 2 * w2 * w2 + 800.0 / 2 * twist * twist;
    };
    turn(model, 1440, kFuel);
    const double before = stored();
    double gas = 0, load = 0, twist = 0;
    for (int step = 0; step < 2880; ++step) {
        const double t0 = model.truth().time_s, w0 = model.secondary_speed_radps(),
                     g0 = model.truth().gas_torque_nm;
        turn(model, 1, kFuel);
        gas += (g0 + model.truth().gas_torque_nm) / 2 * model.tables().step_rad;
        load += 60 * (w0 + model.secondary_speed_radps()) / 2 * (model.truth().time_s - t0);
        twist = std::max(twist, std::abs(model.flywheel_twist_rad()));
    }
    EXPECT_GT(twist, 0.02);
    EXPECT_NEAR(stored() - before, gas - load, 1e-3 * gas);
}

TEST(PlantTorsion, FrequenciesOfASymmetricChainInClosedForm) {
    PlantEngine engine = diesel();
    engine.shared.firing_order = {1};
    engine.shared.firing_tdc_deg = {0};
    engine.shared.inertia_kgm2 = 0.25;
    engine.torsion_modes = 2;
    engine.torsion = CrankTorsion{1e6, 0.1, 0.05, 0.02, true}; // leaves a flywheel of 0.1 kg m2
    const auto found = CrankElasticity(engine).frequencies_radps();
    ASSERT_EQ(found.size(), 2u);
    EXPECT_NEAR(found[0], std::sqrt(1e6 / 0.1), 1e-6);
    EXPECT_NEAR(found[1], std::sqrt(1e6 * (1 / 0.1 + 2 / 0.05)), 1e-6);
}

TEST(PlantTorsion, StiffCrankIsTheRigidCrank) {
    Scenario rigid = scenario({"run.cycles=3"}), stiff = rigid;
    stiff.engine.torsion = CrankTorsion{1e12, 0.01, 0.01, 0.02, true};
    stiff.engine.torsion_modes = 3;
    const auto a = run(rigid).edges, b = run(stiff).edges;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i].time_s, b[i].time_s, 1e-9) << i;
}

TEST(PlantTorsion, TwistShowsAtTheFrontAndNotInTheMean) {
    Scenario rigid = scenario({"run.cycles=20"}), elastic = rigid;
    elastic.engine.torsion = CrankTorsion{4e5, 0.02, 0.02, 0.02, true};
    const auto a = run(rigid).edges, b = run(elastic).edges;
    double mean = 0, largest = 0;
    const std::size_t count = std::min(a.size(), b.size());
    for (std::size_t i = 0; i < count; ++i) {
        const double deg = (b[i].time_s - a[i].time_s) * a[i].speed_radps * kDegPerRad;
        mean += deg / double(count);
        largest = std::max(largest, std::abs(deg));
    }
    EXPECT_GT(largest, 0.01);
    EXPECT_LT(largest, 1.0);
    EXPECT_LT(std::abs(mean), 0.1);
}

} // namespace
