// SPDX-License-Identifier: MIT
// Every way to write a wrong scenario or engine, and the line the user reads.
#include <gtest/gtest.h>

#include "common/files.hpp"
#include "plant_fixture.hpp"

using namespace plant_test;

namespace {

struct Wrong {
    std::vector<std::string> changes;
    std::string line; // after "s.toml: "
};

TEST(Scenario, EveryErrorNamesFieldAndRange) {
    const std::vector<Wrong> all{
        {{"engine=3"}, "engine: is not a text in quotes"},
        {{"run.duration_s=2"}, "run: needs exactly one of duration_s and cycles"},
        {{"run={}"}, "run: needs exactly one of duration_s and cycles"},
        {{"run={duration_s=0}"}, "run.duration_s: 0 is outside [0.001, 1e+06] s"},
        {{"run.cycles=0"}, "run.cycles: 0 is outside [1, 1e+08]"},
        {{"run.step_deg=0.7"}, "run.step_deg: 0.7 does not divide 180 deg a whole number of times"},
        {{"run.step_deg=2"}, "run.step_deg: 2 is outside [0.05, 1] deg"},
        {{"run.start_deg=720"}, "run.start_deg: 720 is outside [0, 719.999] deg"},
        {{"seed=1.5"}, "seed: 1.5 is not a whole number in [0, 4503599627370496]"},
        {{"speed.mode=\"cruise\""},
         "speed.mode: 'cruise' is not \"dyno\", \"governor\", \"free\" or \"prescribed\""},
        {{"speed={}"}, "speed.rpm: is missing; allowed range [50, 12000] rpm"},
        {{"speed.rpm=20"}, "speed.rpm: 20 is outside [50, 12000] rpm"},
        {{"speed={time_s=[0, 1], rpm=[1000]}"}, "speed.rpm: has 1 entries, not 2"},
        {{"speed={time_s=[1, 1], rpm=[1000, 2000]}"}, "speed.time_s: is not ascending"},
        {{"speed={time_s=[], rpm=[1000]}"}, "speed.time_s: is empty"},
        {{"load.bmep_bar=-1"}, "load.bmep_bar: -1 is outside [0, 40] bar"},
        {{"load.torque_nm=50"},
         "load.torque_nm: is for speed.mode \"free\" and \"governor\"; the others find the torque "
         "themselves"},
        {{"load.fuel_cut_s=[1]"}, "load.fuel_cut_s: is not a list of pairs: from, to, from, to"},
        {{"load.fuel_cut_s=[3, 1]"}, "load.fuel_cut_s: is not ascending"},
        {{"load.road_rms_nm=-1"}, "load.road_rms_nm: -1 is outside [0, 1000] N m"},
        {{"load.road_low_hz=20"}, "load.road_high_hz: is not above load.road_low_hz"},
        {{"cylinders.fuel_percent=[1, 2, 3]"}, "cylinders.fuel_percent: has 3 entries, not 4"},
        {{"cylinders.trapped_mass_percent=[0, 0, 0, 80]"},
         "cylinders.trapped_mass_percent: entry 3 is not a number in [-50, 50] %"},
        {{"cylinders.compression_percent=[0, 0, 0, 30]"},
         "cylinders.compression_percent: entry 3 is not a number in [-20, 20] %"},
        {{"cyclic.cov_percent=70"}, "cyclic.cov_percent: 70 is outside [0, 60] %"},
        {{"cyclic.start_sd_deg=11"}, "cyclic.start_sd_deg: 11 is outside [0, 10] deg"},
        {{"cyclic.duration_cov_percent=31"}, "cyclic.duration_cov_percent: 31 is outside [0, 30] %"},
        {{"misfires.event=[{cycle=1, cylinder=5}]"}, "misfires.event[0].cylinder: 5 is outside [1, 4]"},
        {{"misfires.event=[{cylinder=1}]"}, "misfires.event[0].cycle: is missing; allowed range [0, 1e+08]"},
        {{"misfires.event=[{cycle=1, cylinder=1, burned_fraction=2}]"},
         "misfires.event[0].burned_fraction: 2 is outside [0, 1]"},
        {{"misfires.one_in=0"}, "misfires.one_in: 0 is outside [1, 1e+09] combustions"},
        {{"misfires.continuous=[5]"}, "misfires.continuous: entry 0 is not a number in [1, 4]"},
        {{"misfires.continuous=[1.5]"}, "misfires.continuous: 1.5 is not a cylinder"},
        {{"misfires.burned_fraction=-1"}, "misfires.burned_fraction: -1 is outside [0, 1]"},
        {{"encoder.offset_deg=40"}, "encoder.offset_deg: 40 is outside [-30, 30] deg"},
        {{"encoder.pattern_rms_deg=1"}, "encoder.pattern_rms_deg: 1 is outside [0, 0.5] deg"},
        {{"encoder.tooth_width=1"}, "encoder.tooth_width: 1 is outside [0.1, 0.9] of the pitch"},
        {{"encoder.jitter_deg=1"}, "encoder.jitter_deg: 1 is outside [0, 0.5] deg"},
        {{"encoder.delay_us=-1"}, "encoder.delay_us: -1 is outside [0, 1000] us"},
        {{"encoder.lag_deg=9"}, "encoder.lag_deg: 9 is outside [-5, 5] deg"},
        {{"encoder.drop_rate=2"}, "encoder.drop_rate: 2 is outside [0, 1]"},
        {{"encoder.drop_burst=0"}, "encoder.drop_burst: 0 is outside [1, 500] edges"},
        {{"encoder.extra_rate=-1"}, "encoder.extra_rate: -1 is outside [0, 1]"},
        {{"encoder.extra_burst=501"}, "encoder.extra_burst: 501 is outside [1, 500] edges"},
        {{"encoder.cam.retard_deg=90"}, "encoder.cam.retard_deg: 90 is outside [-60, 60] deg"},
        {{"encoder.cam.jitter_deg=9"}, "encoder.cam.jitter_deg: 9 is outside [0, 5] deg"},
        {{"encoder.cam.drop_rate=9"}, "encoder.cam.drop_rate: 9 is outside [0, 1]"},
        {{"encoder.jiter_deg=0.1"}, "encoder.jiter_deg: is not a known field; the nearest is 'encoder.jitter_deg'"},
    };
    for (const Wrong &wrong : all)
        EXPECT_EQ(message([&] { scenario(wrong.changes); }), "s.toml: " + wrong.line);
}

TEST(Scenario, MissingEngineFileIsNamed) {
    EXPECT_NE(message([] { scenario({"engine=\"none.toml\""}); }).find("none.toml"), std::string::npos);
}

TEST(Scenario, LoadBeyondTheTrappedAirIsRefused) {
    const Scenario s = scenario({"load.bmep_bar=30"});
    EXPECT_EQ(message([&] { Plant(s, 1); }), "s.toml: load.bmep_bar: demands more than the trapped air can "
                                             "burn; lower it or raise plant.air.intake_pressure_bar");
}

std::string changed(const std::string &from, const std::string &to) {
    std::string text = read_file(std::filesystem::path(SD_ENGINES) / "diesel_22.toml");
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

TEST(PlantEngineFile, EveryErrorNamesFieldAndRange) {
    const std::vector<std::array<std::string, 3>> all{
        {"bmep_bar = [0, 5, 10, 16]", "bmep_bar = [0, 5, 5, 16]", "plant.air.bmep_bar: is not ascending"},
        {"bmep_bar = [0, 5, 10, 16]", "bmep_bar = [0, 5]", "plant.air.bmep_bar: has 2 entries, not 4"},
        {"intake_pressure_bar = [1.0, 1.15, 1.6, 2.2]", "intake_pressure_bar = []",
         "plant.air.intake_pressure_bar: is empty"},
        {"intake_pressure_bar = [1.0", "intake_pressure_bar = [0.01",
         "plant.air.intake_pressure_bar: entry 0 is not a number in [0.1, 5] bar"},
        {"exhaust_pressure_bar = 1.15", "exhaust_pressure_bar = 9",
         "plant.air.exhaust_pressure_bar: 9 is outside [0.1, 6] bar"},
        {"charge_temperature_k = 340", "charge_temperature_k = 20",
         "plant.air.charge_temperature_k: 20 is outside [250, 500] K"},
        {"exhaust_open_deg = 130", "exhaust_open_deg = 20",
         "valves.exhaust_open_deg: 20 is outside [60, 200] deg"},
        {"intake_close_deg = 580", "intake_close_deg = 700",
         "valves.intake_close_deg: 700 is outside [500, 640] deg"},
        {"share = 0.12", "share = 0.2", "combustion.pulse: shares add up to 1.08, not 1"},
        {"duration_deg = 9", "duration_deg = 1",
         "combustion.pulse[0].duration_deg: 1 is outside [3, 120] deg"},
        {"shape = 2", "shape = 9", "combustion.pulse[0].shape: 9 is outside [0.5, 5]"},
        {"start_deg = -2", "start_deg = -90",
         "combustion.pulse[0].start_deg: -90 is outside [-60, 60] deg"},
        {"temperature_k = 430", "temperature_k = 900",
         "plant.wall.temperature_k: 900 is outside [250, 700] K"},
        {"factor = 1", "factor = 7", "plant.wall.factor: 7 is outside [0, 5]"},
        {"fmep_bar = [0.75, 0.25, 0.04]", "fmep_bar = [0.75]",
         "plant.friction.fmep_bar: has 1 entries, not 3"},
        {"[plant.wall]", "[plant.walls]", "plant.walls.factor: is not a known field; the nearest is 'plant.wall.factor'"},
        {"[plant.wall]", "[plant.driveline]\ninertia_kgm2 = -1\n[plant.wall]",
         "plant.driveline.inertia_kgm2: -1 is outside [0, 100] kg m2"},
        {"[plant.wall]", "[dual_mass]\n[plant.wall]",
         "dual_mass.secondary_inertia_kgm2: is missing; allowed range [0.001, 10] kg m2"},
        {"[plant.wall]", "[torsion]\nsection_stiffness_nmprad = 1\n[plant.wall]",
         "torsion.section_stiffness_nmprad: 1 is outside [10000, 1e+08] N m/rad"},
        {"[plant.wall]",
         "[torsion]\nsection_stiffness_nmprad = 1e6\nfront_inertia_kgm2 = 0.1\nthrow_inertia_kgm2 = "
         "0.05\n[plant.wall]",
         "torsion.throw_inertia_kgm2: with the front end makes 0.3 kg m2 and leaves nothing of "
         "crank.inertia_kgm2 to the flywheel"},
        {"[plant.wall]",
         "[torsion]\nsection_stiffness_nmprad = 1e6\nfront_inertia_kgm2 = 0.01\nthrow_inertia_kgm2 = "
         "0.01\nwheel_at = \"rear\"\n[plant.wall]",
         "torsion.wheel_at: 'rear' is not \"front\" or \"flywheel\""},
    };
    for (const auto &[from, to, line] : all) {
        EXPECT_EQ(message([&] { read_plant_engine("e.toml", changed(from, to)); }), "e.toml: " + line);
    }
}

TEST(PlantEngineFile, WithoutPlantDataSaysSo) {
    const std::string text = read_file(std::filesystem::path(SD_ENGINES) / "diesel_22.toml");
    EXPECT_EQ(message([&] { read_plant_engine("e.toml", text.substr(0, text.find("[plant.air]"))); }),
              "e.toml: plant: is missing: this engine file has no data for the simulated engine");
}

TEST(PlantEngineFile, PulsesAreAtMostTwoAndGuessedWhenAbsent) {
    std::string text = read_file(std::filesystem::path(SD_ENGINES) / "diesel_22.toml");
    const auto from = text.find("[[combustion.pulse]]"), to = text.find("[crank]");
    const std::string pulses = text.substr(from, to - from);
    EXPECT_EQ(message([&] { read_plant_engine("e.toml", std::string(text).insert(from, pulses)); }),
              "e.toml: combustion.pulse: has 4 entries, not 1 or 2");
    const EngineFile engine = read_plant_engine("e.toml", text.erase(from, to - from)).shared;
    EXPECT_EQ(1u, engine.pulses.size());
    EXPECT_EQ("combustion.pulse", engine.guessed.back());
}

TEST(Scenario, ShippedScenariosRead) {
    int count = 0;
    for (const auto &entry :
         std::filesystem::directory_iterator(std::filesystem::path(SD_ENGINES) / ".." / "scenarios")) {
        EXPECT_EQ(message([&] { read_scenario(entry.path()); }), "") << entry.path();
        ++count;
    }
    EXPECT_GE(count, 1);
}

} // namespace
