// SPDX-License-Identifier: MIT
// MODEL.toml: what is read, and what is said of a file that cannot be.
#include <gtest/gtest.h>

#include "common/error.hpp"
#include "studies/sensor_sets/sensor_model.hpp"

using namespace sixdeg;

namespace {

using Names = std::vector<std::string>;

SensorModel parse(const std::string &text) {
    TomlFile file("m.toml", text);
    auto model = read_sensor_model(file);
    file.finish();
    return model;
}

std::string complaint(const std::string &text) {
    try {
        parse(text);
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

const std::string two_states =
    "name = 't'\n[states]\na = ['b']\nb = ['a', 'b']\n[sensors]\ny = { sees = ['a'] }\n";

TEST(SensorModelFile, ReadsTheSmallestModel) {
    const auto model = parse(two_states);
    EXPECT_EQ(model.states, (Names{"a", "b"}));
    EXPECT_EQ(model.targets, (std::vector<int>{0, 1}));
    EXPECT_EQ(model.regimes[0].structure.states[1].states, (std::vector<int>{0, 1}));
}

TEST(SensorModelFile, NamesWhatIsWrong) {
    const auto with = [](const std::string &more) { return complaint(two_states + more); };
    EXPECT_EQ(with("z = { sees = ['c'] }"), "m.toml: sensors.z.sees: 'c' is not a state");
    EXPECT_EQ(with("z = { sees = ['a', 'a'] }"), "m.toml: sensors.z.sees: names 'a' twice");
    EXPECT_EQ(with("y = { sees = ['b'] }").substr(0, 15), "m.toml: line 7:"); // duplicate name
    EXPECT_EQ(with("[regimes.cold]"),
              "m.toml: regimes.cold: is empty: it must name at least one link that full_regime "
              "has and it has not");
    EXPECT_EQ(with("[regimes.cold.states]\na = []").substr(0, 31), "m.toml: regimes.cold: is empty:");
    EXPECT_EQ(with("[regimes.cold.states]\na = ['a']"),
              "m.toml: regimes.cold.states.a: a does not depend on 'a'");
    EXPECT_EQ(with("[regimes.cold.states]\nc = ['a']"), "m.toml: regimes.cold.states.c: 'c' is not defined");
    EXPECT_EQ(with("[regimes.cold.sensors]\ny = ['q']"),
              "m.toml: regimes.cold.sensors.y: 'q' is not a state");
    EXPECT_EQ(with("[regimes.full.states]\na = ['b']"),
              "m.toml: regimes.full: is full_regime, which loses nothing");
    EXPECT_EQ(with("[[forbidden]]\nsensors = ['q']"), "m.toml: forbidden[0].sensors: 'q' is not a sensor");
    EXPECT_EQ(with("[[forbidden]]\nsensors = []"), "m.toml: forbidden[0].sensors: names no sensor");
    EXPECT_EQ(with("z = { sees = ['a'], cost = -1 }"), "m.toml: sensors.z.cost: -1 is outside [0, 1e+09]");
    EXPECT_EQ(with("z = { sees = ['a'], price = 1 }"), "m.toml: sensors.z.price: is not a known field");
    EXPECT_EQ(with("z = { sees = ['a'], lags_s = [0] }").substr(0, 24), "m.toml: sensors.z.lags_s");
    EXPECT_EQ(with("[shared]\na = ['b']"), "m.toml: shared.a: has the name of a state");
    EXPECT_EQ(with("[shared]\nq = ['q']"), "m.toml: shared.q: 'q' must be defined before it is used");
    EXPECT_EQ(complaint("name = 't'\ntargets = ['c']\n" + two_states.substr(11)),
              "m.toml: targets: 'c' is not a state");
    EXPECT_EQ(complaint("name = 't'\n[states]\n[sensors]\n"),
              "m.toml: states: has 0 entries, allowed 1 to 64");
    EXPECT_EQ(complaint("name = 't'\n"), "m.toml: states: is not a table");
}

TEST(SensorModelFile, TargetsOfTheUserAreChecked) {
    const auto model = parse(two_states);
    EXPECT_EQ(model.find_states({"b"}, "--target"), std::vector<int>{1});
    EXPECT_THROW(model.find_states({"q"}, "--target"), InputError);
    EXPECT_THROW(model.find_states({"a", "a"}, "--target"), InputError);
}

} // namespace
