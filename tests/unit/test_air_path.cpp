// SPDX-License-Identifier: MIT
// The simulated air path: balances, what actuators, sensors and faults do, and that a crank drives it as a table of speeds would.
#include <gtest/gtest.h>

#include "unit/plant_fixture.hpp"

namespace {

using namespace sixdeg;
using namespace sixdeg::airpath;

constexpr EngineDrive kUsual{1500 * kRadpsPerRpm, 4.5e-3};

const PlantEngine &engine() {
    static const PlantEngine read = read_plant_engine(std::filesystem::path(SD_ENGINES) / "cat_3126b.toml");
    return read;
}

FullModel model(double egr = 0.35, double vgt = 0.44, double fuel_kgps = kUsual.fuel_kgps) {
    FullModel m(*engine().air_path, engine().displacement_m3(), engine().shared.compression_ratio);
    m.start({kUsual.speed_radps, fuel_kgps, egr, vgt, 0});
    return m;
}

airpath::Setup usual(std::vector<Fault> faults = {}) {
    airpath::Setup s;
    s.egr = Profile(0.35), s.vgt = Profile(0.44);
    s.faults = std::move(faults);
    return s;
}

Fault fault(int place, FaultKind kind, double from_s, double size = 0) {
    Fault f;
    f.place = place, f.kind = kind, f.from_s = from_s, f.size = size;
    return f;
}

struct Course {
    std::vector<Readings> read;
    std::vector<Truth> truth;
};

Course course(const airpath::Setup &setup, double seconds, std::uint64_t seed = 1) {
    AirPath air(*engine().air_path, engine().displacement_m3(), engine().shared.compression_ratio, setup, seed);
    air.start(kUsual);
    air.advance(seconds, kUsual);
    Course c;
    Readings r;
    Truth t;
    while (air.next(1e300, r, &t)) c.read.push_back(r), c.truth.push_back(t);
    return c;
}

TEST(AirPath, WhatFlowsInFlowsOutAtRestAndTheShaftsPowersAreEqual) {
    for (double egr : {0.0, 0.2, 0.5})
        for (double vgt : {0.25, 0.44, 0.7}) {
            SCOPED_TRACE(testing::Message() << "egr " << egr << " vgt " << vgt);
            FullModel m = model(egr, vgt);
            const Flows &f = m.flows();
            EXPECT_NEAR(f.compressor_kgps, f.charge_kgps, 2e-5);
            EXPECT_NEAR(f.charge_kgps + f.egr_kgps, f.cylinder_kgps, 2e-5);
            EXPECT_NEAR(f.cylinder_kgps + kUsual.fuel_kgps, f.egr_kgps + f.turbine_kgps, 2e-5);
            EXPECT_EQ(egr == 0, f.egr_kgps == 0);
            const double turbo = m.state().turbo_radps;
            m.step({kUsual.speed_radps, kUsual.fuel_kgps, egr, vgt, 0}, 1e-3);
            EXPECT_NEAR(turbo, m.state().turbo_radps, 1e-6 * turbo);
        }
}

TEST(AirPath, EveryManifoldKeepsItsMassThroughALoadStep) {
    FullModel m = model();
    const Drive drive{kUsual.speed_radps, 1.3 * kUsual.fuel_kgps, 0.2, 0.3, 0};
    const State before = m.state();
    double intake = 0, exhaust = 0, boost = 0;
    for (int i = 0; i < 3000; ++i) {
        const Flows f0 = m.flows();
        const double gas = m.state().leaving_kgps;
        m.step(drive, 1e-3);
        const Flows &f = m.flows();
        boost += 0.5e-3 * (f0.compressor_kgps - f0.charge_kgps + f.compressor_kgps - f.charge_kgps);
        intake += 0.5e-3 * (f0.charge_kgps + f0.egr_kgps - f0.cylinder_kgps + f.charge_kgps + f.egr_kgps - f.cylinder_kgps);
        exhaust += 0.5e-3 * (gas + m.state().leaving_kgps - f0.egr_kgps - f0.turbine_kgps - f.egr_kgps - f.turbine_kgps);
    }
    const State &s = m.state();
    EXPECT_NEAR(s.boost_kg - before.boost_kg, boost, 2e-5);
    EXPECT_NEAR(s.air_kg + s.egr_kg - before.air_kg - before.egr_kg, intake, 2e-5);
    EXPECT_NEAR(s.exhaust_kg - before.exhaust_kg, exhaust, 2e-5);
    EXPECT_GT(std::abs(intake), 1e-3) << "it did move";
}

TEST(AirPath, ValveAndVanesDoWhatTheyDoOnAnEngine) {
    const FullModel usual = model(), valve = model(0.45), vanes = model(0.35, 0.34), fuel = model(0.35, 0.44, 1.2 * kUsual.fuel_kgps);
    EXPECT_GT(valve.flows().egr_kgps, 1.1 * usual.flows().egr_kgps);
    EXPECT_LT(valve.flows().compressor_kgps, usual.flows().compressor_kgps);
    EXPECT_LT(valve.flows().exhaust_pa, usual.flows().exhaust_pa);
    EXPECT_GT(vanes.flows().exhaust_pa, 1.05 * usual.flows().exhaust_pa);
    EXPECT_GT(vanes.state().turbo_radps, usual.state().turbo_radps);
    EXPECT_GT(fuel.flows().exhaust_k, usual.flows().exhaust_k);
    EXPECT_GT(fuel.flows().intake_pa, usual.flows().intake_pa);
}

TEST(AirPath, AnOffsetMovesTheValveAndTheReadingAgreesAgainWithTheCommand) {
    const Course c = course(usual({fault(kEgrActuator, FaultKind::step, 1, 0.1)}), 2);
    EXPECT_NEAR(0.35, c.truth[99].egr, 1e-9);
    EXPECT_NEAR(0.45, c.truth[150].egr, 1e-3);
    EXPECT_LT(*c.read[101].value[kEgrPosition], 0.31) << "seen for a moment";
    EXPECT_NEAR(0.35, *c.read[150].value[kEgrPosition], 0.01);
    EXPECT_EQ(0.35, *c.read[150].value[kEgrCommand]);
    EXPECT_NEAR(0.44, c.truth[150].vgt, 1e-9) << "the vanes stay";
}

TEST(AirPath, StuckAndSlowActuatorsAreReadAsTheyAre) {
    airpath::Setup s = usual({fault(kEgrActuator, FaultKind::stuck, 0.5), fault(kVgtActuator, FaultKind::slow, 0.5, 0.05)});
    s.egr = Profile({0.99, 1.0}, {0.35, 0.5}), s.vgt = Profile({0.99, 1.0}, {0.44, 0.6});
    const Course c = course(s, 2);
    EXPECT_NEAR(0.35, c.truth[200].egr, 1e-9);
    EXPECT_NEAR(0.35, *c.read[200].value[kEgrPosition], 0.01);
    EXPECT_EQ(0.5, *c.read[200].value[kEgrCommand]);
    EXPECT_LT(c.truth[120].vgt, 0.52) << "a sound one is there after 0.15 s";
    EXPECT_NEAR(c.truth[120].vgt, *c.read[120].value[kVgtPosition], 0.01);
    airpath::Setup sound = s;
    sound.faults.clear();
    EXPECT_NEAR(0.6, course(sound, 2).truth[130].vgt, 0.005);
}

TEST(AirPath, OffsetsComeAtOnceGrowOrComeAndGo) {
    Fault ramp = fault(kVgtActuator, FaultKind::ramp, 1, 0.2), loose = fault(kVgtActuator, FaultKind::intermittent, 1, 0.2);
    ramp.ramp_s = 2, loose.period_s = 0.5;
    ramp.to_s = loose.to_s = 5;
    EXPECT_EQ(0, ramp.offset(0.9));
    EXPECT_NEAR(0.1, ramp.offset(2), 1e-12);
    EXPECT_NEAR(0.2, ramp.offset(4), 1e-12);
    EXPECT_EQ(0, ramp.offset(5));
    EXPECT_EQ(0.2, loose.offset(1.2));
    EXPECT_EQ(0, loose.offset(1.3));
    EXPECT_EQ(0.2, loose.offset(1.6));
}

TEST(AirPath, ASensorIsSilentStuckBiasedOrFarOffAndNoOtherChanges) {
    const Course sound = course(usual(), 2);
    const Course c = course(usual({fault(kFirstSensor + kAirFlow, FaultKind::silent, 1), fault(kFirstSensor + kIntakePressure,
        FaultKind::stuck, 1),
                                   fault(kFirstSensor + kExhaustPressure, FaultKind::step, 1, 5000),
                                   fault(kFirstSensor + kChargeTemperature, FaultKind::out_of_range, 1)}),
                            2);
    EXPECT_TRUE(c.read[99].value[kAirFlow]);
    for (std::size_t i = 100; i <= 200; ++i) {
        EXPECT_FALSE(c.read[i].value[kAirFlow]);
        EXPECT_EQ(*c.read[99].value[kIntakePressure], *c.read[i].value[kIntakePressure]);
        EXPECT_NEAR(*sound.read[i].value[kExhaustPressure] + 5000, *c.read[i].value[kExhaustPressure], 2e-5);
        EXPECT_GT(*c.read[i].value[kChargeTemperature], 1e4);
        EXPECT_EQ(*sound.read[i].value[kEgrTemperature], *c.read[i].value[kEgrTemperature]);
        EXPECT_EQ(sound.truth[i].flows.intake_pa, c.truth[i].flows.intake_pa);
    }
}

TEST(AirPath, NoiseHasTheSizeSaidAndAnotherSeedOtherNoise) {
    const Course c = course(usual(), 20), again = course(usual(), 20), other = course(usual(), 20, 2);
    const auto sd = [&](int channel) {
        double sum = 0, squares = 0;
        for (const Readings &r : c.read) sum += *r.value[std::size_t(channel)], squares += std::pow(*r.value[std::size_t(channel)], 2);
        const double n = double(c.read.size());
        return std::sqrt(squares / n - sum / n * (sum / n));
    };
    EXPECT_NEAR(1000, sd(kIntakePressure), 60);
    EXPECT_NEAR(2000, sd(kExhaustPressure), 120);
    EXPECT_NEAR(0.01 * c.truth[0].flows.compressor_kgps, sd(kAirFlow), 1e-4);
    EXPECT_EQ(c.read[777].value, again.read[777].value);
    EXPECT_NE(c.read[777].value, other.read[777].value);
}

TEST(AirPath, ALeakLosesPressureAndErrorsStayWithinTheirShare) {
    const Course c = course(usual({fault(kIntakeLeak, FaultKind::step, 1, 60e-6)}), 4);
    EXPECT_LT(c.truth[400].flows.intake_pa, c.truth[99].flows.intake_pa - 2000);
    EXPECT_GT(c.truth[400].flows.leak_kgps, 5e-3);
    double largest = 0;
    for (std::uint32_t i = 0; i < 200; ++i) {
        const Errors e = draw_errors(0.02, RandomStream(i, 1));
        for (double value : {e.filling, e.egr_area, e.turbine_area, e.air_flow}) largest = std::max(largest, std::abs(value - 1));
    }
    EXPECT_LE(largest, 0.02);
    EXPECT_GT(largest, 0.019);
}

Scenario airpath_scenario(const std::vector<std::string> &changes = {}) {
    TomlFile file("s.toml", "engine = \"cat_3126b.toml\"\n[run]\nduration_s = 1.5\n[speed]\nrpm = 1500\n[load]\nbmep_bar = 8\n"
                            "[airpath]\negr = 0.35\nvgt = 0.44\nnoise = 0\n");
    for (const auto &change : changes) file.set(change);
    return read_scenario(file, SD_ENGINES);
}

TEST(AirPath, TheCrankDrivesItAsItsSpeedAndFuelWouldAndBreathesItsPressure) {
    const Scenario scenario = airpath_scenario();
    Plant plant(scenario, 1);
    EncoderEdge edge;
    Readings r;
    Truth crank{};
    while (plant.next_edge(edge))
        while (plant.next_air_path(edge.time_s, r, crank)) {}
    EXPECT_NEAR(1500 * kRadpsPerRpm, crank.speed_radps, 1);
    FullModel alone(*scenario.engine.air_path, scenario.engine.displacement_m3(), scenario.engine.shared.compression_ratio);
    alone.start({crank.speed_radps, crank.fuel_kgps, 0.35, 0.44, 0});
    EXPECT_NEAR(alone.flows().intake_pa, crank.flows.intake_pa, 0.01 * crank.flows.intake_pa);
    EXPECT_NEAR(alone.flows().exhaust_pa, crank.flows.exhaust_pa, 0.01 * crank.flows.exhaust_pa);
    EXPECT_NEAR(plant.intake_pressure_pa(), crank.flows.intake_pa, 500);
}

TEST(AirPath, AScenarioThatMakesNoSenseIsRefusedByField) {
    using plant_test::message;
    const auto refused = [](const std::string &change) { return message([&] { airpath_scenario({change}); }); };
    EXPECT_NE(std::string::npos, refused("airpath.egr=1.2").find("airpath.egr"));
    EXPECT_NE(std::string::npos, refused("airpath.fault=[{at=\"egr\",kind=\"silent\",from_s=1}]").find("only a sensor"));
    EXPECT_NE(std::string::npos, refused("airpath.fault=[{at=\"air.flow\",kind=\"slow\",from_s=1,size=0.5}]").find("can be slow"));
    EXPECT_NE(std::string::npos, refused("airpath.fault=[{at=\"fan\",from_s=1,size=1}]").find("'fan'"));
    EXPECT_NE(std::string::npos, refused("airpath.fault=[{at=\"egr\",from_s=2,to_s=1,size=1}]").find("not after"));
    EXPECT_EQ("", refused("airpath.fault=[{at=\"leak\",kind=\"ramp\",from_s=1,size=20,ramp_s=2}]"));
    EXPECT_NE("", message([] { plant_test::scenario({"airpath.egr=0.3", "airpath.vgt=0.4"}); })) << "an engine without an air path";
}

} // namespace
