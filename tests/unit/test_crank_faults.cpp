// SPDX-License-Identifier: MIT
// Fault rates of the crank decoder against an oracle that knows every edge. Prints a table with 95 % intervals; docs/results/crank.md
// quotes it. SD_FULL=1 runs ten times as many teeth.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <gtest/gtest.h>
#include <string>

#include "support/poisson.hpp"
#include "support/wheel_trace.hpp"
extern "C" {
#include "sd_crank.h"
}

using namespace sixdeg::test;

namespace {

constexpr int kValidAgainWithin = 8; // edges after a fault

std::size_t teeth_per_row() {
#ifdef __SANITIZE_ADDRESS__
    return 40000;
#else
    return std::getenv("SD_FULL") ? 3000000 : 300000;
#endif
}

struct Score {
    std::uint64_t edges = 0, true_edges = 0, valid = 0, wrong = 0, late = 0, faults = 0, losses = 0;
};

/// Every row has faults of its own: the seed comes from its name.
std::uint32_t seed_of(const std::string &name) {
    std::uint32_t hash = 2166136261u;
    for (const char c : name) hash = (hash ^ std::uint8_t(c)) * 16777619u;
    return hash;
}

Score run(const std::string &name, WheelTrace wheel) {
    wheel.seed = seed_of(name);
    sd_crank_config_t config{};
    config.positions = std::uint8_t(wheel.positions);
    config.missing_count = std::uint8_t(wheel.missing.size());
    std::copy(wheel.missing.begin(), wheel.missing.end(), config.missing);
    config.stall_ticks = std::uint32_t(0.5 * wheel.tick_hz);
    sd_crank_t crank;
    EXPECT_EQ(SD_OK, sd_crank_init(&crank, &config));
    const Trace trace = make_trace(wheel, teeth_per_row());
    Score score;
    score.faults = trace.faults;
    bool synced = false, recovered = true;
    int since_fault = 0;
    for (const OracleEdge &edge : trace.edges) {
        sd_tooth_t tooth;
        sd_crank_edge(&crank, edge.tick, &tooth);
        const bool valid = tooth.health == SD_VALID;
        synced |= valid;
        if (!synced) continue;
        ++score.edges;
        if (edge.position >= 0) {
            ++score.true_edges;
            score.valid += valid;
        }
        if (edge.after_fault) {
            since_fault = 0;
            recovered = false;
        } else {
            ++since_fault;
        }
        recovered |= valid;
        if (!recovered && since_fault == kValidAgainWithin) {
            ++score.late;
            recovered = true;
        }
        const double off = std::fabs(std::remainder(tooth.position - edge.place, wheel.positions));
        score.wrong += valid && off >= 0.5;
    }
    score.losses = crank.counts.sync_losses;
    return score;
}

void print(const std::string &name, const Score &s) {
    const double faults = std::fmax(1, double(s.faults)), edges = double(s.edges);
    std::printf("%-34s %8llu edges %7llu faults  losses %llu, a fault %.1e [%.1e, %.1e]  valid %.3f %%  "
                "late %llu  wrong/edge %.1e [%.1e, %.1e]\n",
                name.c_str(), (unsigned long long)s.edges, (unsigned long long)s.faults, (unsigned long long)s.losses,
                    double(s.losses) / faults,
                poisson_bound(s.losses, false) / faults, poisson_bound(s.losses, true) / faults,
                100 * double(s.valid) / double(s.true_edges), (unsigned long long)s.late, double(s.wrong) / edges,
                poisson_bound(s.wrong, false) / edges, poisson_bound(s.wrong, true) / edges);
}

enum class Fault { drop, add, both };

WheelTrace with(WheelTrace wheel, Fault fault, double rate, bool bursts) {
    wheel.drop_rate = fault == Fault::add ? 0 : rate;
    wheel.add_rate = fault == Fault::drop ? 0 : rate;
    wheel.bursts = bursts;
    return wheel;
}

std::string name_of(const char *what, Fault fault, double rate, bool bursts) {
    static const char *const names[] = {"dropped", "added", "dropped and added"};
    char text[80];
    std::snprintf(text, sizeof text, "%s, %g %s%s", what, rate, names[int(fault)], bursts ? ", bursts" : "");
    return text;
}

/// The goals of the decoder: at most 0.02 losses a fault in any row and 0.001 beyond chance, 99 % of true edges valid at 1e-3 and
/// 98 % at 1e-2.
Score expect_goals(const std::string &name, const WheelTrace &wheel, double rate) {
    const Score s = run(name, wheel);
    print(name, s);
    EXPECT_GT(s.true_edges, teeth_per_row() * 9 / 10) << name << ": hardly ever synced";
    EXPECT_LE(double(s.losses), 0.02 * double(s.faults)) << name;
    EXPECT_LE(poisson_bound(s.losses, false), 0.001 * double(s.faults)) << name;
    EXPECT_GE(double(s.valid), (rate > 2e-3 ? 0.98 : 0.99) * double(s.true_edges)) << name;
    return s;
}

WheelTrace at_speed(double rpm) {
    WheelTrace wheel;
    wheel.rpm = rpm;
    wheel.ripple = rpm < 1000 ? 0.05 : 0.02;
    return wheel;
}

std::string rpm_name(double rpm) { return std::to_string(int(rpm)) + " rpm"; }

TEST(CrankFaults, DroppedOrAddedEdgesAtSpeed) {
    std::uint64_t edges = 0, wrong = 0, rare_edges = 0, rare_wrong = 0;
    for (const double rpm : {800.0, 2000.0, 6000.0}) {
        for (const double rate : {1e-3, 1e-2}) {
            for (const bool bursts : {false, true}) {
                for (const Fault fault : {Fault::drop, Fault::add}) {
                    const std::string name = name_of(rpm_name(rpm).c_str(), fault, rate, bursts);
                    const Score s = expect_goals(name, with(at_speed(rpm), fault, rate, bursts), rate);
                    // Two or three edges added inside a mark may look like a slip until the next mark.
                    EXPECT_LE(poisson_bound(s.late, false), 5e-4 * double(s.faults)) << "valid again within 8 edges of a fault";
                    edges += s.edges;
                    wrong += s.wrong;
                    rare_edges += rate < 2e-3 ? s.edges : 0;
                    rare_wrong += rate < 2e-3 ? s.wrong : 0;
                }
            }
        }
    }
    const auto tell = [](const char *rows, std::uint64_t of, std::uint64_t count) {
        std::printf("%s: %llu edges, valid but wrong by half a tooth: %llu, 95 %% upper bound %.1e an edge\n", rows, (unsigned long long)of,
                    (unsigned long long)count, poisson_bound(count, true) / double(of));
    };
    tell("all rows", edges, wrong);
    tell("rows at 1e-3", rare_edges, rare_wrong);
    EXPECT_LE(double(wrong), 1e-6 * double(edges));
    EXPECT_LE(double(rare_wrong), 5e-7 * double(rare_edges));
}

TEST(CrankFaults, DroppedAndAddedAtOnce) {
    for (const double rpm : {800.0, 2000.0, 6000.0}) {
        for (const double rate : {1e-3, 1e-2}) {
            for (const bool bursts : {false, true}) {
                const std::string name = name_of(rpm_name(rpm).c_str(), Fault::both, rate, bursts);
                expect_goals(name, with(at_speed(rpm), Fault::both, rate, bursts), rate);
            }
        }
    }
}

TEST(CrankFaults, Jitter) {
    for (const double jitter : {0.05, 0.1}) {
        WheelTrace wheel = at_speed(3000);
        wheel.ripple = 0;
        wheel.jitter_teeth = jitter;
        const std::string what = "jitter " + std::to_string(int(100 * jitter)) + " %";
        const Score clean = run(what, wheel);
        print(what, clean);
        EXPECT_LE(clean.losses, 1u) << "peers: 53 and 239 in 1000 revolutions";
        EXPECT_GE(double(clean.valid), 0.99 * double(clean.true_edges));
        // Goal 1e-6; with 10 % a vote goes wrong once in some two million edges and takes a revolution with it.
        EXPECT_LE(double(clean.wrong), (jitter > 0.05 ? 1e-4 : 1e-6) * double(clean.edges));
        for (const double rate : {1e-3, 1e-2}) {
            expect_goals(name_of(what.c_str(), Fault::both, rate, false), with(wheel, Fault::both, rate, false), rate);
        }
    }
}

TEST(CrankFaults, MarksOfEveryWidth) {
    for (const double ratio : {1.6, 2.0, 2.5, 3.3, 4.0, 4.5}) {
        WheelTrace wheel = at_speed(2000);
        wheel.mark_ratio = ratio;
        char what[40];
        std::snprintf(what, sizeof what, "mark ratio %.1f", ratio);
        for (const double rate : {1e-3, 1e-2}) {
            for (const bool bursts : {false, true}) {
                expect_goals(name_of(what, Fault::both, rate, bursts), with(wheel, Fault::both, rate, bursts), rate);
            }
        }
    }
}

WheelTrace cranking() {
    WheelTrace wheel;
    wheel.rpm = 250;
    wheel.ripple = 0.4;
    return wheel;
}

TEST(CrankFaults, CompressionRippleWhileCranking) {
    const Score clean = run("cranking", cranking());
    print("cranking", clean);
    EXPECT_EQ(0u, clean.losses);
    EXPECT_EQ(0u, clean.wrong);
    for (const double rate : {1e-3, 1e-2}) {
        for (const bool bursts : {false, true}) {
            for (const Fault fault : {Fault::drop, Fault::add}) {
                expect_goals(name_of("cranking", fault, rate, bursts), with(cranking(), fault, rate, bursts), rate);
            }
        }
    }
}

} // namespace
