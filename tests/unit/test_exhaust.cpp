// SPDX-License-Identifier: MIT
// The exhaust side of the plant against closed forms and balances.
#include <gtest/gtest.h>

#include "plant_fixture.hpp"

using namespace plant_test;
using exhaust::ExhaustModel;
using exhaust::Zone;

namespace {

Scenario with_sensor(std::vector<std::string> changes = {}) {
    changes.insert(changes.begin(), {"uego.sample_us=500", "speed.rpm=1500", "load.bmep_bar=9"});
    return scenario(changes);
}

/// The plant at the end of a scenario, its samples and its cycles.
struct SensorRun {
    explicit SensorRun(const Scenario &s, std::uint64_t seed = 1) : plant(s, seed) {
        EncoderEdge edge;
        UegoSample sample;
        CycleTruth cycle;
        while (plant.next_edge(edge))
            while (plant.next_uego(edge.time_s, sample)) samples.push_back(sample);
        while (plant.next_cycle(cycle)) cycles.push_back(cycle);
    }
    Plant plant;
    std::vector<UegoSample> samples;
    std::vector<CycleTruth> cycles;
};

TEST(ExhaustOrifice, ChokedAndUnchokedClosedForm) {
    const double g = exhaust::kGamma;
    const double choked = std::sqrt(g) * std::pow(2 / (g + 1), (g + 1) / (2 * (g - 1)));
    EXPECT_NEAR(exhaust::orifice_psi(0.2), choked, 1e-12);
    EXPECT_NEAR(exhaust::orifice_psi(0.5), choked, 1e-12);
    // Unchoked, from the Mach number at the throat.
    const double ratio = 0.8, mach2 = 2 / (g - 1) * (std::pow(ratio, (1 - g) / g) - 1);
    const double flow = std::sqrt(g * mach2) * std::pow(1 + (g - 1) / 2 * mach2, -(g + 1) / (2 * (g - 1)));
    EXPECT_NEAR(exhaust::orifice_psi(ratio), flow, 1e-12);
    EXPECT_EQ(exhaust::orifice_psi(1), 0);
    EXPECT_NEAR(exhaust::orifice_psi(0.98 - 1e-12), exhaust::orifice_psi(0.98 + 1e-12), 1e-9);
}

// Mass, air and energy: what entered less what left is what is held. The cylinders come from real combustion.
TEST(ExhaustModel, BalancesClose) {
    Scenario s = with_sensor({"run.cycles=30", "cylinders.fuel_percent=[20, 0, -10, 0]"});
    s.engine.exhaust.runner_m3 = {5e-5, 1e-4, 1e-4, 5e-5};
    s.engine.exhaust.egr_area_m2 = 2e-5;
    Plant plant(s, 1);
    EncoderEdge edge;
    ASSERT_TRUE(plant.next_edge(edge));
    const ExhaustModel &e = *plant.exhaust();
    const auto left = [&] {
        const Zone held = e.held();
        const exhaust::Ledger &l = e.ledger();
        return Zone{l.in_kg - l.out_kg - held.kg,
                    l.in_joule - l.out_joule - l.wall_joule - l.piston_joule - held.joule,
                    l.in_air_kg - l.out_air_kg - held.air_kg};
    };
    const Zone before = left();
    const double in_kg = e.ledger().in_kg, in_joule = e.ledger().in_joule, piston = e.ledger().piston_joule;
    while (plant.next_edge(edge)) {
    }
    const Zone after = left();
    const double passed = e.ledger().in_kg - in_kg, energy = e.ledger().in_joule - in_joule;
    EXPECT_GT(passed, 0.08);
    EXPECT_LT(std::abs(e.ledger().piston_joule - piston), energy);
    EXPECT_LT(std::abs(after.kg - before.kg), 1e-10 * passed);
    EXPECT_LT(std::abs(after.air_kg - before.air_kg), 1e-10 * passed);
    EXPECT_LT(std::abs(after.joule - before.joule), 1e-10 * energy);
}

// What goes in must come out at the sensor, and lambda must be what fuel and air say.
TEST(ExhaustModel, SteadyLambdaIsThatOfTheCharges) {
    const SensorRun run(with_sensor({"run.cycles=40", "cylinders.fuel_percent=[20, 0, 0, 0]"}));
    double gas = 0, burned = 0, sensed = 0, samples = 0;
    for (std::size_t i = run.cycles.size() - 16; i < run.cycles.size(); ++i) {
        const CycleTruth &c = run.cycles[i];
        const double expected = (1 + 14.6) * c.fuel_kg / (c.air_kg + c.fuel_kg);
        // Residual gas of the last cycle is burned already.
        EXPECT_GT(c.exhaust_lambda, expected);
        EXPECT_LT(c.exhaust_lambda, 1.08 * expected);
        gas += c.air_kg + c.fuel_kg, burned += c.exhaust_lambda * (c.air_kg + c.fuel_kg);
    }
    for (const UegoSample &s : run.samples)
        if (s.time_s > run.samples.back().time_s - 0.32) sensed += s.lambda, samples += 1; // four cycles
    EXPECT_NEAR(sensed / samples, burned / gas, 0.003);
    double last[5] = {};
    for (const CycleTruth &c : run.cycles) last[c.cylinder] = c.exhaust_lambda;
    EXPECT_NEAR(last[1] / last[2], 1.19, 0.01);
}

TEST(ExhaustModel, FlowsBackAndChokes) {
    Plant plant(with_sensor({"run.cycles=6", "load.bmep_bar=12"}), 1);
    EncoderEdge edge;
    double least = 0, most = 0, pressure = 0;
    while (plant.next_edge(edge)) {
        for (double w : plant.exhaust()->flows().valve) least = std::min(least, w), most = std::max(most, w);
        pressure = std::max(pressure, plant.exhaust()->pressure_pa());
    }
    EXPECT_LT(least, -1e-3);
    EXPECT_GT(most, 0.1);
    EXPECT_GT(pressure, 1.5e5);
}

TEST(ExhaustTransport, CarriesByMassThenMixesThenWaits) {
    exhaust::Transport line;
    line.start(0);
    double first = 0, third = 0;
    for (int i = 1; i <= 2000; ++i) { // 1 kg/s; pipe 0.5 kg, mixing 0.1 kg, dead time 0.2 s
        line.step(i * 1e-3, 1e-3, 1, 1, 0.5, 0.1, 0.2);
        if (first == 0 && line.at_sensor() > 0.005) first = i * 1e-3;
        if (third == 0 && line.at_sensor() > 1 - std::exp(-1)) third = i * 1e-3;
    }
    EXPECT_NEAR(first, 0.7, 0.003);
    EXPECT_NEAR(third, 0.8, 0.003);
    for (int i = 1; i <= 5; ++i) line.step(2 + i * 1e-3, 1e-3, -1, 0, 0.5, 0.1, 0); // no flow back
    EXPECT_GT(line.at_sensor(), 0.99);
}

TEST(Uego, SecondOrderInClosedForm) {
    for (const auto &[tau1, tau2] :
         std::vector<std::pair<double, double>>{{15e-3, 5e-3}, {30e-3, 15e-3}, {80e-3, 20e-3}}) {
        exhaust::Uego sensor({}, tau1, tau2, RandomStream(1, 1));
        std::deque<UegoSample> samples;
        sensor.start(0, 1);
        sensor.step(1e-9, 1e-9, 0, 101300, samples); // steps to lambda 1
        for (int i = 1; i <= 4000; ++i) sensor.step(i * 7e-5, 7e-5, 0, 101300, samples);
        ASSERT_GT(samples.size(), 500u);
        for (const UegoSample &s : samples) {
            const double t = s.time_s,
                         y = 1 - (tau1 * std::exp(-t / tau1) - tau2 * std::exp(-t / tau2)) / (tau1 - tau2);
            ASSERT_NEAR(s.lambda, y, 2e-5) << t;
        }
    }
}

TEST(Uego, NoiseHasItsDensityWhiteOrNot) {
    for (double correlation : {0.0, 1e-3}) {
        UegoSetup setup;
        setup.noise_per_rthz = 2e-4, setup.correlation_s = correlation;
        exhaust::Uego sensor(setup, 30e-3, 15e-3, RandomStream(3, 7));
        std::deque<UegoSample> samples;
        sensor.start(0, 0.5);
        for (int i = 1; i <= 400000; ++i) sensor.step(i * 5e-4, 5e-4, 0.5, 101300, samples);
        // Means over 50 ms have variance S/2 over their length, S the one-sided density.
        double sum = 0, count = 0;
        for (std::size_t i = 0; i + 100 <= samples.size(); i += 100) {
            double mean = 0;
            for (std::size_t j = 0; j < 100; ++j) mean += samples[i + j].lambda / 100 - 0.005;
            sum += mean * mean, ++count;
        }
        const double expected = 2e-4 * 2e-4 / 2 / 50e-3 * (1 - correlation / 50e-3);
        EXPECT_NEAR(sum / count / expected, 1, 0.07) << correlation; // 4000 means: 2.2 % standard deviation
    }
}

TEST(Uego, PressureQuantumAndAgeing) {
    UegoSetup setup;
    setup.pressure_per_bar = 0.05, setup.step = 0.01, setup.ageing = 2;
    exhaust::Uego sensor(setup, 30e-3, 15e-3, RandomStream(1, 1));
    std::deque<UegoSample> samples;
    sensor.start(0, 0.5);
    for (int i = 1; i <= 100000; ++i) sensor.step(i * 1e-4, 1e-4, 0.5, 301300, samples);
    EXPECT_NEAR(sensor.lambda(), 1 - 0.5 * 1.1, 1e-9);
    EXPECT_DOUBLE_EQ(samples.back().lambda, 0.45);
}

// What it reads follows from the mean pressure at its tip.
TEST(Uego, ItsTipIsBehindTheTurbineOrBeforeIt) {
    for (const bool before : {false, true}) {
        Plant plant(with_sensor({"run.cycles=30", "uego.pressure_percent_per_bar=10",
                                 std::string("uego.before_turbine=") + (before ? "true" : "false")}), 1);
        double steps = 0, air = 0, gas = 0, behind_pa = 0, manifold_pa = 0;
        plant.watch_steps([&] {
            if (plant.truth().angle_rad < 20 * 4 * kPi) return;
            const ExhaustModel &e = *plant.exhaust();
            ++steps, air += 1 - plant.uego_lambda(), gas += e.at_sensor();
            behind_pa += e.downstream_pa(), manifold_pa += e.pressure_pa();
        });
        EncoderEdge edge;
        while (plant.next_edge(edge)) {
        }
        EXPECT_GT(manifold_pa, 1.2 * behind_pa);
        EXPECT_NEAR(air / gas, 1 + 0.1 * ((before ? manifold_pa : behind_pa) / steps / 1e5 - 1.013), 2e-3);
    }
}

} // namespace
