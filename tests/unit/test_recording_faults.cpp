// SPDX-License-Identifier: MIT
// Every recording that cannot be used gets one line that names file, place and what is allowed.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/error.hpp"
#include "io/recording/guess.hpp"
#include "unit/crank_trace.hpp"
#include "unit/known_recording.hpp"

using namespace sixdeg;

namespace {

template <typename Action> std::string message(Action action) {
    try {
        action();
    } catch (const InputError &error) {
        return error.what();
    }
    return "";
}

struct BadText {
    const char *name, *text, *message;
};
void PrintTo(const BadText &bad, std::ostream *out) { *out << bad.name; }
struct BadTexts : ::testing::TestWithParam<BadText> {};

TEST_P(BadTexts, AreNamed) {
    EXPECT_EQ(message([] { guess(parse_recording("r.csv", GetParam().text)); }), GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Reader, BadTexts,
    ::testing::Values(
        BadText{"empty", "",
                "r.csv: is empty; rows of time in s and, after it, levels or voltages are wanted"},
        BadText{"blank", " \n\n# nothing\n",
                "r.csv: is empty; rows of time in s and, after it, levels or voltages are wanted"},
        BadText{"header_only", "time,level\n",
                "r.csv: holds no rows of numbers; rows of time in s and, after it, levels or voltages are wanted"},
        BadText{"logicdata", "\x7F\x01\x13\x01\x0A" "Data save2\x01\x18\n\n",
                "r.csv: is a .logicdata; tools/log/convert.py reads what rusEFI and FOME write, "
                "of Saleae's own Logic export the table as CSV"},
        BadText{"vcd", "$timescale 1us $end\n$var wire 1 ! crank $end\n$enddefinitions $end\n#0\n0!\n",
                "r.csv: is a VCD; tools/log/convert.py makes a table of it"},
        BadText{"levels_without_times", "a,b\n0,0\n1,0\n0,0\n1,0\n0,0\n1,0\n0,0\n1,0\n",
                "r.csv: has no column of times, levels alone; a time in every row is wanted"},
        BadText{"archive", "PK\x03\x04 digital-0.bin\n\n",
                "r.csv: is an archive: a .sal of Saleae's Logic 2, or a spreadsheet; open it there, and export the table as CSV"},
        BadText{"two_headers", "t,x\nt,x\n",
                "r.csv: holds no rows of numbers; rows of time in s and, after it, levels or voltages are wanted"},
        BadText{"no_number", "t,x\n0,1\n1,steep\n",
                "r.csv: line 3, column 1: 'steep' is not a finite number such as 0.0125 or 1.25e-2"},
        BadText{"half_number", "0,1\n1,2x\n",
                "r.csv: line 2, column 1: '2x' is not a finite number such as 0.0125 or 1.25e-2"},
        BadText{"too_large", "0,1\n1,1e999\n",
                "r.csv: line 2, column 1: '1e999' is not a finite number such as 0.0125 or 1.25e-2"},
        BadText{"binary", "0,1\n1,\x01\x02\n",
                "r.csv: line 2, column 1: '?\?' is not a finite number such as 0.0125 or 1.25e-2"},
        BadText{"time_is_no_number", "t,x\n0,1\n1,0\nsoon,1\n2,0\n",
                "r.csv: line 4, column 0: 'soon' is not a finite number such as 0.0125 or 1.25e-2"},
        BadText{"time_goes_back", "0,1\n2,0\n1.5,1\n",
                "r.csv: line 3, column 0: time 1.5 is before the 2 of the row above; "
                "time must not go back (a second recording in the file?)"},
        BadText{"short_row", "0,1\n1\n2,0\n",
                "r.csv: line 2: has 1 columns, the rows above have 2; every row must have as many"},
        BadText{"long_row", "0,1\n1,0\n2,2,3\n",
                "r.csv: line 3: has 3 columns, the rows above have 2; every row must have as many"}),
    [](const auto &param) { return std::string(param.param.name); });

TEST(Reader, MissingFileIsNamed) {
    EXPECT_EQ(message([] { read_recording("no-such-file.csv"); }), "no-such-file.csv: cannot be read");
}

TEST(Columns, ThatAreNotThereAreNamed) {
    const Recording recording = parse_recording("r.csv", "0,1,0\n1,0,1\n");
    EXPECT_EQ(message([&] {
                  guess(recording, with_column(3));
              }),
              "r.csv: column 3: is not a signal; columns are 0 to 2, and column 0 is the time");
    EXPECT_EQ(message([&] { edges(recording, 0, Edge::falling); }),
              "r.csv: column 0: is not a signal; columns are 0 to 2, and column 0 is the time");
    EXPECT_EQ(message([&] { edges(parse_recording("r.csv", "0\n1\n"), 1, Edge::falling); }),
              "r.csv: column 1: is not a signal: column 0 holds the edge times, and there is no other");
}

TEST(Edges, OnlyTwoWordsAreEdges) {
    EXPECT_EQ(parse_edge("rising", "--edge"), Edge::rising);
    EXPECT_EQ(message([] { parse_edge("up", "--edge"); }), "--edge: 'up' is not an edge: falling or rising");
}

TEST(Guess, SaysWhatItTriedAndWhatToGive) {
    std::string even; // teeth without any gap, and a column that never changes
    for (int i = 0; i < 400; ++i) even += fmt::format("{},{},5\n", i * 0.001, i % 2);
    EXPECT_EQ(message([&] { guess(parse_recording("r.csv", even)); }),
              "r.csv: no toothed wheel found (column 1 falling: 199 edges, 0 gaps, 0 of them one revolution "
              "apart; column 1 "
              "rising: 200 edges, 0 gaps, 0 of them one revolution apart); too few edges, or say more: "
              "--wheel 60-2, --edge "
              "falling or rising, --column N, --threshold V");
    EXPECT_NE(message([&] { guess(parse_recording("r.csv", "0,1\n1,1\n")); }).find("(no column has edges)"),
              std::string::npos);
}

TEST(Guess, FindsNoWheelInNoise) {
    std::mt19937 random(3);
    std::exponential_distribution<double> wait(1000);
    std::string rows;
    double t_s = 0;
    for (int i = 0; i < 3000; ++i) rows += fmt::format("{:.9f}\n", t_s += wait(random));
    EXPECT_NE(message([&] { guess(parse_recording("r.csv", rows)); }), "");
}

TEST(Guess, AGapOfSixMissingTeethIsNoMark) {
    crank_trace::Trace trace;
    trace.missing = 6;
    std::string rows;
    for (double t_s : crank_trace::edge_times(trace)) rows += fmt::format("{:.7f}\n", t_s);
    EXPECT_NE(message([&] { guess(parse_recording("r.csv", rows)); }), "");
}

TEST(Guess, WrongWheelFromTheCallerIsNotFound) {
    const std::vector<double> falling = crank_trace::edge_times({});
    std::vector<double> rising;
    for (std::size_t i = 1; i < falling.size(); ++i) rising.push_back((falling[i - 1] + falling[i]) / 2);
    const Recording recording = parse_recording("r.csv", crank_trace::level_rows(falling, rising));
    EXPECT_NE(message([&] {
                  guess(recording, with_wheel("36-1"));
              }).find("shows 60-2 (10 revolutions, mark of 3.0 spacings), not the 36-1 of --wheel"),
              std::string::npos);
}

TEST(Guess, FewerEdgesThanOneRevolutionAreNamed) {
    const Recording recording = parse_recording("r.csv", "0,1\n1,0\n2,1\n3,0\n");
    EXPECT_EQ(message([&] {
                  guess(recording, with_wheel("60-2", Edge::falling, 1));
              }),
              "r.csv: column 1: has 2 edges, too few: one revolution of 60-2 needs 59");
}

} // namespace
