// SPDX-License-Identifier: MIT
// What every command leans on: files that appear whole or not at all, and TOML errors that name field and range.
#include <filesystem>
#include <functional>
#include <gtest/gtest.h>
#include <unistd.h>

#include "common/error.hpp"
#include "common/files.hpp"
#include "common/toml_file.hpp"

namespace fs = std::filesystem;
using namespace sixdeg;

namespace {

std::string message(const std::function<void()> &action) {
    try {
        action();
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

struct Files : ::testing::Test {
    // A folder of its own: ctest runs the tests side by side.
    fs::path folder = fs::path(::testing::TempDir()) / ("sixdeg-files-" + std::to_string(getpid()));
    void SetUp() override { fs::remove_all(folder); }
    void TearDown() override { fs::remove_all(folder); }
};

TEST_F(Files, WriteLeavesNothingBeside) {
    write_file(folder / "a.txt", "hello");
    EXPECT_EQ(read_file(folder / "a.txt"), "hello");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

TEST_F(Files, FolderThatCannotBeWholeChangesNothing) {
    write_file(folder / "a.txt", "old");
    fs::create_directories(folder / "b.txt.partial"); // makes writing b.txt fail, for root too
    OutputFolder out(folder);
    out.add("a.txt", "new");
    out.add("b.txt", "new");
    EXPECT_NE(message([&] { out.commit(); }).find("b.txt"), std::string::npos);
    EXPECT_EQ(read_file(folder / "a.txt"), "old");
    EXPECT_FALSE(fs::exists(folder / "a.txt.partial"));
}

TEST(Sha256, MatchesThePublishedVector) { // FIPS 180-2, appendix B.1
    EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(TomlFile, NamesFileFieldAndRange) {
    TomlFile file("e.toml", "[crank]\ninertia_kgm2 = 30\nname = 3\n");
    EXPECT_EQ(message([&] { file.number("crank.inertia_kgm2", {0, 10, "kg m2"}); }),
              "e.toml: crank.inertia_kgm2: 30 is outside [0, 10] kg m2");
    EXPECT_EQ(message([&] { file.number("crank.bore_m", {0.01, 1, "m"}); }),
              "e.toml: crank.bore_m: is missing; allowed range [0.01, 1] m");
    EXPECT_EQ(message([&] { file.text("crank.name"); }), "e.toml: crank.name: is not a text in quotes");
}

TEST(TomlFile, NanIsOutsideEveryRange) {
    TomlFile file("e.toml", "x = nan");
    EXPECT_NE(message([&] { file.number("x", {-1, 1, ""}); }), "");
}

TEST(TomlFile, UnknownFieldIsAnError) {
    TomlFile file("e.toml", "x = 1\n[[c]]\ny = 2\n");
    file.number("x", {0, 2, ""});
    EXPECT_EQ(message([&] { file.finish(); }), "e.toml: c[0].y: is not a known field");
    file.number("c[0].y", {0, 2, ""});
    EXPECT_EQ(message([&] { file.finish(); }), "");
}

TEST(TomlFile, SetReplacesAndCreates) {
    TomlFile file("e.toml", "x = 1");
    file.set("x=2.5");
    file.set("a.b=7");
    EXPECT_EQ(file.number("x", {0, 10, ""}), 2.5);
    EXPECT_EQ(file.integer("a.b", 0, 10), 7);
    EXPECT_NE(message([&] { file.set("x"); }), "");
    EXPECT_NE(message([&] { file.set("x=["); }), "");
    EXPECT_NE(message([&] { file.set("x.y=1"); }), "");
}

TEST(TomlFile, BrokenTomlNamesTheLine) {
    EXPECT_EQ(message([] { TomlFile("e.toml", "x = 1\ny = = 2"); }).substr(0, 15), "e.toml: line 2:");
}

} // namespace
