// SPDX-License-Identifier: MIT
// Starts of the crank decoder: when it knows the angle, and whether it is the right one. Every start of every row has a seed of
// its own. Prints a table with 95 % intervals; docs/results/crank.md quotes it. SD_FULL=1 draws 20,000 starts a row.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <gtest/gtest.h>
#include <string>

#include "support/poisson.hpp"
#include "support/start_trace.hpp"
extern "C" {
#include "sd_crank.h"
}

using namespace sixdeg::test;

namespace {

using Random = std::mt19937_64;
using Draw = std::function<void(StartTrace &, Random &)>;

bool full() { return std::getenv("SD_FULL") != nullptr; }
int starts_per_row() { return full() ? 20000 : 400; }

double between(Random &random, double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); }

/// Cranking with compression: the mark stands anywhere on the ripple.
void crank(StartTrace &start, Random &random) {
    start.rpm = between(random, 100, 300);
    start.ripple = between(random, 0, 0.4);
    start.ripple_phase = between(random, 0, 2 * M_PI);
}

struct Outcome {
    bool by_second_mark = false;       ///< A tooth is known by the second tooth after the second mark.
    bool in_three_revolutions = false;
    bool synced = false, first_wrong = false, wrong = false; ///< first_wrong: the first valid tooth; wrong: any valid one.
    unsigned losses = 0;
    std::uint64_t valid = 0, edges = 0; ///< From the first valid tooth on.
};

Outcome decode(const StartTrace &start, Random &random) {
    sd_crank_config_t config{};
    config.positions = std::uint8_t(start.positions);
    config.missing_count = std::uint8_t(start.missing.size());
    std::copy(start.missing.begin(), start.missing.end(), config.missing);
    config.stall_ticks = std::uint32_t(0.5 * start.tick_hz);
    sd_crank_t decoder;
    EXPECT_EQ(SD_OK, sd_crank_init(&decoder, &config));
    Outcome outcome;
    for (const StartEdge &edge : start_edges(start, random)) {
        sd_tooth_t tooth;
        sd_crank_edge(&decoder, std::uint32_t(edge.tick), &tooth);
        const bool off = std::fabs(std::remainder(tooth.position - edge.place, start.positions)) >= 0.5;
        if (!outcome.synced && tooth.edge_class != SD_EDGE_UNSYNCED) {
            outcome.synced = true;
            outcome.by_second_mark = edge.marks < 2 || (edge.marks == 2 && edge.teeth_since <= 1);
            outcome.in_three_revolutions = edge.revolutions <= 3;
        }
        if (tooth.health == SD_VALID) {
            outcome.first_wrong |= outcome.valid == 0 && off;
            outcome.wrong |= off;
            ++outcome.valid;
        }
        outcome.edges += outcome.valid > 0;
    }
    outcome.losses = decoder.counts.sync_losses;
    return outcome;
}

struct Row {
    std::uint64_t starts = 0, late = 0, slow = 0, never = 0, first_wrong = 0, wrong = 0, losses = 0, valid = 0, edges = 0;
};

/// `seed` differs from row to row.
Row run(const char *name, int seed, double revolutions, const Draw &draw) {
    Row row;
    for (int k = 0; k < starts_per_row(); ++k) {
        Random random(std::uint64_t(seed) * 1000003u + std::uint64_t(k));
        random.discard(10);
        StartTrace start;
        start.revolutions = revolutions;
        draw(start, random);
        start.first = int(between(random, 0, double(start.positions - int(start.missing.size()))));
        const Outcome outcome = decode(start, random);
        ++row.starts;
        row.late += !outcome.by_second_mark;
        row.slow += !outcome.in_three_revolutions;
        row.never += !outcome.synced;
        row.first_wrong += outcome.first_wrong;
        row.wrong += outcome.wrong;
        row.losses += outcome.losses;
        row.valid += outcome.valid;
        row.edges += outcome.edges;
    }
    const auto share = [&](const char *what, std::uint64_t count) {
        std::printf("  %s %llu (%.3f to %.3f %%)", what, (unsigned long long)count, 100 * poisson_bound(count, false) / double(row.starts),
                    100 * poisson_bound(count, true) / double(row.starts));
    };
    std::printf("%-34s %6llu starts:", name, (unsigned long long)row.starts);
    share("not by the 2nd mark", row.late);
    share("not in 3 revolutions", row.slow);
    share("first valid tooth wrong", row.first_wrong);
    share("any valid tooth wrong", row.wrong);
    const double valid = 100 * double(row.valid) / std::fmax(1, double(row.edges));
    std::printf("  losses %llu, then valid %.2f %%\n", (unsigned long long)row.losses, valid);
    return row;
}

/// With 20,000 starts the share itself must keep to the goal; with fewer, it must not be above it beyond chance.
void expect_at_most(const Row &row, std::uint64_t count, double goal) {
    EXPECT_LE(full() ? double(count) : poisson_bound(count, false), goal * double(row.starts));
}

TEST(CrankStarts, UnderCompressionRipple) {
    const Row row = run("ripple 0-40 %, 100-300 rpm", 1, 5, crank);
    expect_at_most(row, row.late, 1e-3);
    EXPECT_EQ(0u, row.wrong);
    EXPECT_EQ(0u, row.losses);
    const Row worst = run("ripple 40 %, 150 rpm", 2, 5, [](StartTrace &start, Random &random) {
        crank(start, random);
        start.ripple = 0.4;
        start.rpm = 150;
    });
    expect_at_most(worst, worst.late, 1e-3);
    EXPECT_EQ(0u, worst.wrong);
}

void weak_teeth(StartTrace &start, Random &random) {
    crank(start, random);
    start.before = between(random, 0.6, 1.4);
    start.after = between(random, 0.6, 1.4);
}

TEST(CrankStarts, WithWeakTeethBesideTheMark) {
    const Row row = run("teeth beside the mark 0.6-1.4", 3, 8, weak_teeth);
    expect_at_most(row, row.late, 1e-3);
    EXPECT_EQ(0u, row.wrong);
    EXPECT_EQ(0u, row.losses);
}

TEST(CrankStarts, WithMarksOfEveryWidth) {
    const Row row = run("mark ratio 1.6-4.5", 4, 8, [](StartTrace &start, Random &random) {
        crank(start, random);
        start.mark_ratio = between(random, 1.6, 4.5);
    });
    expect_at_most(row, row.late, 1e-3);
    EXPECT_EQ(0u, row.wrong);
    EXPECT_EQ(0u, row.losses);
}

/// Draws until the mark is, or is not, wider than 1.5 of the wider tooth beside it.
Draw jointly(bool clear) {
    return [clear](StartTrace &start, Random &random) {
        do {
            weak_teeth(start, random);
            start.mark_ratio = between(random, 1.6, 4.5);
        } while ((start.mark_ratio > 1.5 * std::max(start.before, start.after)) != clear);
    };
}

TEST(CrankStarts, WithWeakTeethAndMarksOfEveryWidth) {
    const Row clear = run("both, mark > 1.5 of its neighbours", 5, 8, jointly(true));
    expect_at_most(clear, clear.late, 1e-3);
    EXPECT_EQ(0u, clear.wrong);
    const Row unclear = run("both, mark < 1.5 of a neighbour", 6, 8, jointly(false));
    EXPECT_EQ(0u, unclear.wrong) << "rather no sync than a wrong one";
    EXPECT_GT(unclear.starts - unclear.never, unclear.starts / 2) << "a row without sync shows nothing";
}

TEST(CrankStarts, UnderJitter) {
    const auto jitter = [](double sd) {
        return [sd](StartTrace &start, Random &random) {
            start.rpm = between(random, 300, 3000);
            start.jitter = sd;
        };
    };
    const Row much = run("jitter 10 %", 7, 14, jitter(0.1));
    expect_at_most(much, much.slow, 1e-3);
    expect_at_most(much, much.first_wrong, 1e-3);
    expect_at_most(much, much.losses, 5e-3);
    EXPECT_GE(double(much.valid), 0.99 * double(much.edges));
    const Row some = run("jitter 5 %", 8, 14, jitter(0.05));
    expect_at_most(some, some.late, 1e-3);
    EXPECT_EQ(0u, some.wrong);
    const Row both = run("jitter 5 %, ripple 0-40 %", 9, 14, [](StartTrace &start, Random &random) {
        crank(start, random);
        start.jitter = 0.05;
    });
    expect_at_most(both, both.late, 1e-3);
    EXPECT_GE(double(both.valid), 0.9 * double(both.edges)) << "one clock must both average and follow: no goal but this";
}

TEST(CrankStarts, OverFaults) {
    const auto faults = [](bool bursts, bool widths) {
        return [bursts, widths](StartTrace &start, Random &random) {
            crank(start, random);
            if (widths) start.mark_ratio = between(random, 1.6, 4.5);
            start.drop_rate = start.add_rate = 0.01;
            start.bursts = bursts;
        };
    };
    const Row singly = run("1e-2 dropped and added", 10, 8, faults(false, false));
    expect_at_most(singly, singly.first_wrong, 0.01);
    const Row widths = run("1e-2, mark ratio 1.6-4.5", 11, 8, faults(false, true));
    expect_at_most(widths, widths.first_wrong, 0.01);
    const Row bursts = run("1e-2, bursts", 12, 8, faults(true, false));
    expect_at_most(bursts, bursts.first_wrong, 0.02);
    for (const Row &row : {singly, widths}) EXPECT_LT(row.never, row.starts / 100);
}

TEST(CrankStarts, OnARamp) {
    const Row start = run("ramp 3000 rpm/s from 100-300 rpm", 13, 14, [](StartTrace &w, Random &random) {
        crank(w, random);
        w.ripple /= 2;
        w.rpm_per_s = 3000;
    });
    const Row up = run("ramp 3000 rpm/s from 300-2000 rpm", 14, 14, [](StartTrace &w, Random &random) {
        w.rpm = between(random, 300, 2000);
        w.ripple = 0.03;
        w.rpm_per_s = 3000;
    });
    const Row down = run("ramp -3000 rpm/s from 2400-4000 rpm", 15, 14, [](StartTrace &w, Random &random) {
        w.rpm = between(random, 2400, 4000);
        w.ripple = 0.03;
        w.rpm_per_s = -3000;
    });
    for (const Row &row : {start, up, down}) {
        expect_at_most(row, row.late, 1e-3);
        EXPECT_EQ(0u, row.wrong);
        EXPECT_EQ(0u, row.losses);
    }
}

struct Wheel {
    const char *name;
    int positions;
    std::vector<int> missing;
};

/// Every wheel that the decoder takes starts; several marks need a revolution and a mark.
TEST(CrankStarts, OfOtherWheels) {
    const std::vector<Wheel> wheels{{"12-1", 12, {11}}, {"24-1", 24, {23}}, {"36-1", 36, {35}}, {"36-2", 36, {34, 35}},
                                    {"12-3", 12, {9, 10, 11}}, {"120-3", 120, {117, 118, 119}}, {"36-2-2-2", 36, {16, 17, 26, 27, 34, 35}},
                                    {"36-2-2-2 with one tooth between two", 36, {16, 17, 19, 20, 34, 35}},
                                    {"36-2-1", 36, {20, 34, 35}}, {"44-2-2", 44, {19, 20, 42, 43}},
                                    {"120-2-3-2-2", 120, {28, 29, 57, 58, 59, 88, 89, 118, 119}}};
    int seed = 16;
    for (const Wheel &wheel : wheels) {
        const Row row = run(wheel.name, seed++, 5, [&](StartTrace &start, Random &random) {
            start.positions = wheel.positions;
            start.missing = wheel.missing;
            start.mark_ratio = between(random, 1.8, 3.5);
            start.rpm = between(random, 100, 300);
            start.ripple = between(random, 0, 0.2);
            start.ripple_phase = between(random, 0, 2 * M_PI);
        });
        expect_at_most(row, row.slow, 1e-3);
        EXPECT_EQ(0u, row.wrong) << wheel.name;
        EXPECT_EQ(0u, row.losses) << wheel.name;
    }
}

} // namespace
