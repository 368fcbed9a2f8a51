// SPDX-License-Identifier: MIT
// Recordings in every accepted form, and their edges.
#include <filesystem>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "common/error.hpp"
#include "io/recording/guess.hpp"
#include "unit/crank_trace.hpp"
#include "unit/known_recording.hpp"

namespace fs = std::filesystem;
using namespace sixdeg;
using crank_trace::Trace;

namespace {

const std::vector<double> kTimes{0, 0.5, 0.75};
const std::vector<double> kLevels{1, 0, 1};

struct Form {
    const char *name, *text;
};
void PrintTo(const Form &form, std::ostream *out) { *out << form.name; }
struct Forms : ::testing::TestWithParam<Form> {};

TEST_P(Forms, ReadAlike) {
    const Recording recording = parse_recording("r.csv", GetParam().text);
    ASSERT_EQ(recording.columns.size(), 2u);
    EXPECT_EQ(recording.time, kTimes);
    EXPECT_EQ(recording.columns[1], kLevels);
    EXPECT_EQ(edges(recording, 1, Edge::falling), std::vector<double>{0.5});
    EXPECT_EQ(edges(recording, 1, Edge::rising), std::vector<double>{0.75});
}

INSTANTIATE_TEST_SUITE_P(
    Reader, Forms,
    ::testing::Values(Form{"comma", "0,1\n0.5,0\n0.75,1\n"},
                      Form{"comma_header", "Time[s], Channel 0\n0, 1\n0.5, 0\n0.75, 1\n"},
                      Form{"semicolon", "t;level\n0;1\n0.5;0\n0.75;1"},
                      Form{"tab", "0.0E+0\t1\n5.0E-1\t0\n7.5E-1\t1\n"},
                      Form{"blanks", "  0   1\n 0.5   0\n 0.75  1\n"},
                      Form{"blank_header", "time level\n0,1\n0.5,0\n0.75,1\n"},
                      Form{"windows", "\xEF\xBB\xBFt,level\r\n0,1\r\n0.5,0\r\n0.75,1\r\n"},
                      Form{"decimal_comma", "t;x\n0,0;1\n0,5;0\n0,75;1\n"},
                      Form{"decimal_comma_between_blanks", "0,00 1\n0,50 0\n0,75 1\n"},
                      Form{"commas_in_two_roles", "0,000,1\n0,500,0\n0,750,1\n"},
                      Form{"quotes", "\"t\",\"x\"\n\"0\",\"1\"\n\"0.5\",\"0\"\n\"0.75\",\"1\"\n"},
                      Form{"units_below_the_names", "Source,CH1\nSecond,Volt\n0,1\n0.5,0\n0.75,1\n"},
                      Form{"several_headers", "Scope 3\nSerial,17\nt [s],x\n0,1\n0.5,0\n0.75,1\n"},
                      Form{"words_for_levels", "t,x\n0,high\n0.5,low\n0.75,HIGH\n"},
                      Form{"blank_cells_hold", "t,x\n0,1\n0.5,0\n0.75,1\n"},
                      Form{"marker_lines", "t,x\n0,1\nMARK\n0.5,0\n0.75,1\n"},
                      Form{"carriage_returns_alone", "t,x\r0,1\r0.5,0\r0.75,1\r"},
                      Form{"letters_for_levels", "t,x\n0,H\n0.5,L\n0.75,h\n"},
                      Form{"a_sum_below_the_rows", "t,x\n0,1\n0.5,0\n0.75,1\nrows,3,in all\n"},
                      Form{"cut_off", "t,x\n0,1\n0.5,0\n0.75,1\n0.8"},
                      Form{"comments_and_ends", "# scope 3\n0,1,\n\n0.5,0,\n+0.75,+1,\n"}),
    [](const auto &param) { return std::string(param.param.name); });

TEST(Reader, TakesTheTimeWhereTheHeaderHasIt) {
    const Recording log = parse_recording("r.csv", "#Firmware: x\n\"PriLevel\",\"RefTime\",\"ToothTime\",\"Time\"\n"
                                                   "\"Flag\",\"ms\",\"ms\",\"ms\"\n0,0.1,0.3,1\n1,0.2,0.3,2\n0,0.2,0.4,3\n");
    EXPECT_EQ(log.layout.time_column, 3);
    EXPECT_EQ(log.layout.time_unit_s, 1e-3);
    EXPECT_EQ(log.columns[0], (std::vector<double>{0, 1, 0}));
}

TEST(Reader, TakesRowAndToothNumbersForNoSignal) {
    const Recording teeth = parse_recording("r.teeth", "1 0.001\n2 0.002\n3 0.0035\n4 0.004\n5 0.005\n");
    EXPECT_TRUE(teeth.is_edge_times());
    EXPECT_EQ(teeth.time, (std::vector<double>{0.001, 0.002, 0.0035, 0.004, 0.005}));
    const Recording rows = parse_recording("r.csv", "n,t,v\n0,0.5,1\n1,0.75,7\n2,1,3\n3,1.5,2\n4,1.75,9\n");
    EXPECT_EQ(rows.layout.time_column, 1);
    EXPECT_FALSE(rows.is_edge_times());
}

TEST(Reader, AddsUpIntervals) {
    const Recording log = parse_recording("r.csv", "ToothTime\n300\n310\n900\n290\n300\n310\n310\n300\n290\n");
    EXPECT_TRUE(log.layout.is_interval);
    EXPECT_EQ(log.time.back(), 3310);
}

TEST(Reader, TellsIntervalsBesideATooth) {
    for (const char *header : {"tooth,dt_us\n", "tooth,n\n"}) {
        std::string text = header;
        for (int i = 0; i < 48; ++i) text += fmt::format("{},{}\n", i % 24, i % 24 == 23 ? 30 : 10 + i % 2);
        const Recording log = parse_recording("r.csv", text);
        EXPECT_TRUE(log.layout.is_interval) << header;
        EXPECT_EQ(log.time.back(), 46 * 10 + 22 + 60) << header;
    }
}

TEST(Reader, TakesADateWithItsTime) {
    for (const char *text : {"2024-02-29T23:59:59.5Z,1\n2024-03-01T00:00:00.25Z,0\n", "2024/02/29 23:59:59.5,1\n2024/03/01 00:00:00.25,0\n",
                             "29.02.2024 23:59:59,5;1\n01.03.2024 00:00:00,25;0\n",
                             "2024-02-29T23:59:59.5+01:00,1\n2024-03-01T00:00:00.25+01:00,0\n"}) {
        const Recording log = parse_recording("r.csv", text);
        EXPECT_EQ(log.time, (std::vector<double>{0, 0.75})) << text;
        EXPECT_EQ(log.origin.value(), 1709251199.5) << text;
        EXPECT_EQ(log.columns[1], (std::vector<double>{1, 0})) << text;
    }
}

TEST(Reader, TakesWideCharactersWithAMarkOrWithout) {
    for (const bool big : {false, true}) {
        for (const bool marked : {false, true}) {
            std::string text;
            for (const char c : std::string("t,x\n0,1\n0.5,0\n")) text += big ? std::string{'\0', c} : std::string{c, '\0'};
            const Recording log = parse_recording("r.csv", (marked ? big ? "\xFE\xFF" : "\xFF\xFE" : "") + text);
            EXPECT_EQ(log.time, (std::vector<double>{0, 0.5}));
        }
    }
}

TEST(Reader, PassesOverWhatALoggerWithoutPowerLeft) {
    EXPECT_EQ(parse_recording("r.csv", "t,x\n0,1\n0.5,0\n" + std::string(500, '\0')).rows(), 2u);
}

TEST(Reader, SaysWhereTimesAreCounts) {
    EXPECT_TRUE(parse_recording("r.csv", "sample,v\n0,1\n1,0\n2,1\n3,1\n").layout.counts_time);
    EXPECT_TRUE(parse_recording("r.csv", "tick,v\n0,1\n7,0\n20,1\n31,1\n").layout.counts_time);
    EXPECT_FALSE(parse_recording("r.csv", "time [us],v\n0,1\n1,0\n2,1\n3,1\n").layout.counts_time);
}

TEST(Reader, CountsFromTheFirstRowWhereTimesAreNegativeOrLarge) {
    const Recording epoch = parse_recording("r.csv", "1699999999.5,1\n1700000000.25,0\n");
    EXPECT_EQ(epoch.time, (std::vector<double>{0, 0.75}));
    EXPECT_EQ(epoch.origin.value(), 1699999999.5);
    EXPECT_EQ(parse_recording("r.csv", "-0.5,1\n0.25,0\n").time, (std::vector<double>{0, 0.75}));
    EXPECT_EQ(parse_recording("r.csv", "4294967000,1\n4294967290,0\n4,1\n").time.back(), 300); // a 32-bit counter began anew
}

TEST(Reader, FillsBlankCellsWithTheValueAbove) {
    const Recording log = parse_recording("r.csv", "t,a,b\n0,1,X\n1,,5\n2,0,\n");
    EXPECT_EQ(log.columns[1], (std::vector<double>{1, 1, 0}));
}

TEST(Reader, RowsMayBeNumberedWithTheirStepInTheHeader) {
    const Recording log =
        parse_recording("r.csv", "X,CH1,Start,Increment,\nSequence,Volt,-0.6,1e-6\n0,0.1,\n1,0.2,\n2,0.3,\n3,0.1,\n4,0.1,\n");
    EXPECT_EQ(log.layout.time_column, 0);
    EXPECT_EQ(log.layout.time_unit_s, 1e-6);
}

TEST(Reader, NamesColumnsFromTheHeader) {
    const Recording recording = parse_recording("r.csv", "Time[s], Channel 0\n0, 1\n");
    EXPECT_EQ(column_label(recording, 1), "column 1 (Channel 0)");
    EXPECT_EQ(column_label(parse_recording("r.csv", "0,1\n"), 1), "column 1");
}

TEST(Edges, KindsAreToldByTheValues) {
    const Recording recording = parse_recording("r.csv", "0,5,0,0.1\n1,5,1,0.2\n2,5,0,0.3\n");
    EXPECT_EQ(column_kind(recording, 1), ColumnKind::constant);
    EXPECT_EQ(column_kind(recording, 2), ColumnKind::level);
    EXPECT_EQ(column_kind(recording, 3), ColumnKind::sampled);
    EXPECT_EQ(column_kind(parse_recording("r.csv", "0\n1\n"), 0), ColumnKind::edge_times);
    EXPECT_TRUE(edges(recording, 1, Edge::falling).empty());
}

TEST(Edges, AreInterpolatedBetweenSamples) {
    const Recording recording = parse_recording("r.csv", "0,0\n1,0\n2,1\n3,4\n4,4\n5,1\n6,0\n");
    ASSERT_EQ(edges(recording, 1, Edge::rising).size(), 1u);
    EXPECT_DOUBLE_EQ(edges(recording, 1, Edge::rising)[0], 2 + 1.0 / 3);
    ASSERT_EQ(edges(recording, 1, Edge::falling).size(), 1u);
    EXPECT_DOUBLE_EQ(edges(recording, 1, Edge::falling)[0], 4 + 2.0 / 3);
}

TEST(Edges, NoiseInsideTheDeadBandIsNoEdge) {
    // Threshold 2, dead band 1.76 to 2.24.
    const Recording recording =
        parse_recording("r.csv", "0,0\n1,1.9\n2,2.1\n3,1.9\n4,2.1\n5,4\n6,2.1\n7,1.9\n8,2.1\n9,4\n10,0\n");
    EXPECT_EQ(edges(recording, 1, Edge::rising).size(), 1u);
    EXPECT_EQ(edges(recording, 1, Edge::falling).size(), 1u);
}

TEST(Edges, AVoltageFoldedOverAtTheTopOfTheRangeIsUnfolded) {
    // A slow swing from 0 to 12 recorded with a range of 10: the top comes out at the bottom.
    std::string rows;
    for (int i = 0; i < 400; ++i) {
        const double v = 6 - 6 * std::cos(i * 0.1);
        rows += fmt::format("{},{:.3f}\n", i, v > 10 ? v - 10 : v);
    }
    EXPECT_EQ(edges(parse_recording("r.csv", rows), 1, Edge::rising).size(), 7u);
    EXPECT_EQ(edges(parse_recording("r.csv", rows), 1, Edge::falling).size(), 6u);
}

} // namespace
