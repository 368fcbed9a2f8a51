// SPDX-License-Identifier: MIT
// `sixdeg sensors` as a user runs it: page, JSON, exit status and one-line errors.
#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <sys/wait.h>
#include <unistd.h>

#include "common/files.hpp"

namespace fs = std::filesystem;
using namespace sixdeg;

namespace {

struct Result {
    int status;
    std::string page, errors;
};

struct SensorsCommand : ::testing::Test {
    // Tests may run side by side.
    fs::path folder = fs::path(::testing::TempDir()) / ("sixdeg-sensors-" + std::to_string(getpid()));
    void SetUp() override { fs::create_directories(folder); }
    void TearDown() override { fs::remove_all(folder); }

    Result run(const std::string &arguments) const {
        const auto out = (folder / "out").string(), err = (folder / "err").string();
        const int raw = std::system(
            (std::string(SD_SIXDEG) + " sensors " + arguments + " >" + out + " 2>" + err).c_str());
        return {WEXITSTATUS(raw), read_file(out), read_file(err)};
    }
    std::string model(const std::string &text) const {
        write_file(folder / "m.toml", text);
        return (folder / "m.toml").string();
    }
    static std::string shipped(const std::string &name) { return std::string(SD_MODELS) + "/" + name; }
};

TEST_F(SensorsCommand, PrintsHistogramsTimesAndTable1) {
    const auto result = run(shipped("turbo_si_13.toml") + " --target pim,Tim,pem --size 3");
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.page.find("#1  2:1 3:6 4:3 5:606 6:49 7:15\n"), std::string::npos) << result.page;
    EXPECT_NE(result.page.find("#2  2:1 3:6 4:3 5:480 6:19 7:87 8:74 9:10\n"), std::string::npos);
    EXPECT_NE(result.page.find("observable 17 / 17 of 17; the three answers agree on 17"), std::string::npos);
    EXPECT_NE(result.page.find("    4   5   5  pim pem pt\n"), std::string::npos); // Table 1 says 4
    EXPECT_NE(result.errors.find(" ms\n"), std::string::npos);                     // computing time
}

TEST_F(SensorsCommand, AllMeansEverySizeUpToTheGiven) {
    EXPECT_NE(run(shipped("turbo_si_13.toml") + " --all --size 2").page.find("153 sets of 1 to 2 sensors"),
              std::string::npos);
    EXPECT_NE(run(shipped("satellite_orbit.toml") + " --all").page.find("15 sets of 1 to 4 sensors"),
              std::string::npos);
}

TEST_F(SensorsCommand, SameInputSameBytes) {
    const auto a = (folder / "a.json").string(), b = (folder / "b.json").string();
    const std::string command = shipped("satellite_orbit.toml") + " --all --numeric --json ";
    EXPECT_EQ(run(command + a).page, run(command + b).page);
    EXPECT_EQ(read_file(a), read_file(b));
    const auto found = nlohmann::json::parse(read_file(a));
    EXPECT_EQ(found["sets"].size(), 15u);
    EXPECT_EQ(found["published"][0]["index"][0], 4);
    EXPECT_TRUE(found["sets"].back()["relative_sigma"].is_null()); // infinite: nobody sees the angle
}

TEST_F(SensorsCommand, AnotherSeedGivesTheSameAnswer) {
    const std::string command = shipped("turbo_si_13.toml") + " --size 3 ";
    EXPECT_EQ(run(command + "--seed 1").page, run(command + "--seed 12345 --draws 3").page);
}

TEST_F(SensorsCommand, NumericStudyStandsBesideTheGenericAnswer) {
    const auto result = run(shipped("turbo_si_13.toml") + " --size 1 --numeric --top 2");
    EXPECT_EQ(result.status, 0);
    EXPECT_NE(result.page.find("Numeric index at 8 points"), std::string::npos) << result.page;
    EXPECT_NE(result.page.find("Sensitivity of the numeric index"), std::string::npos);
    EXPECT_NE(result.page.find("steady Kalman standard deviation"), std::string::npos);
}

TEST_F(SensorsCommand, BadInputIsOneLineAndStatus2) {
    const std::string head = "name = 't'\n[states]\na = ['a']\n[sensors]\ny = { sees = ['a'] }\n";
    const auto one_line = [&](const std::string &arguments, const std::string &part) {
        const auto result = run(arguments);
        EXPECT_EQ(result.status, 2) << arguments;
        EXPECT_EQ(result.page, "") << arguments;
        EXPECT_NE(result.errors.find(part), std::string::npos) << result.errors;
        EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
    };
    one_line(model(head + "z = { sees = ['ghost'] }"), "sensors.z.sees: 'ghost' is not a state");
    one_line(model(head + "[regimes.cold]"), "regimes.cold: is empty");
    one_line(model(head + "y = { sees = ['a'] }"), "line 6"); // duplicate name
    one_line(model(head) + " --target ghost", "ghost: is not a state of the model; allowed: a");
    one_line(model(head) + " --size 2", "2 is outside [1, 1]");
    one_line(model(head) + " --numeric", "numeric: is missing");
    one_line((folder / "nothing.toml").string(), "nothing.toml");
    one_line(shipped("turbo_si_13.toml") + " --all --numeric", "131071 sets, at most 10000");
}

} // namespace
