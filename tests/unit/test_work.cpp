// SPDX-License-Identifier: MIT
// Work of a cycle from teeth: the block on made tooth times, and where the host puts its windows.
#include <cmath>
#include <gtest/gtest.h>
#include <utility>

#include "common/files.hpp"
#include "design/torque/work_windows.hpp"

using namespace sixdeg;

namespace {

EngineFile engine_named(const std::string &name) {
    TomlFile file(std::filesystem::path(SD_ENGINES) / name);
    return read_engine(file);
}

constexpr double kTickHz = 1e7, kEdgeRad = 1e-4;
constexpr int kStart = 60; // of a cycle here: where no window of the single is

/// A wheel of 60 - 2 whose teeth stand where they like, on a crank of 0.02 kg m2 whose energy is set between windows.
class Crank {
  public:
    explicit Crank(const sd_work_tables_t &tables) : tables_(tables) { sd_work_restart(&meter_, &tables_, kStart - 1); }

    /// One cycle at this speed; `lost`: a cycle position whose edge does not come; `unsure`: one that the decoder does not trust.
    std::vector<sd_work_out_t> turn(double radps, int lost = -1, int unsure = -1) {
        std::vector<sd_work_out_t> said;
        for (int i = 0; i < 120; ++i) {
            const int k = (kStart + i) % 120;
            time_s_ += M_PI / 30 / radps;
            ++advance_;
            if (k % 60 >= 58 || k == lost) continue;
            const double late_s = 0.003 * std::sin(7.0 * (k % 60)) / radps; // the tooth's own error, the same each time
            const auto tick = std::uint32_t(std::uint64_t(std::llround((time_s_ + late_s) * kTickHz)));
            const bool passes = sd_work_passes(&meter_, &tables_, std::uint32_t(k), std::uint32_t(std::exchange(advance_, 0)));
            if (!passes || !sd_work_edge(&meter_, &tables_, std::uint32_t(k), tick, k != unsure)) continue;
            sd_work_meter_t copy = meter_;
            sd_work_out_t f32, q31;
            sd_work_read_q31(&copy, &tables_, float(kEdgeRad), &q31);
            sd_work_read_f32(&meter_, &tables_, float(kEdgeRad), &f32);
            EXPECT_NEAR(double(q31.work_j), double(f32.work_j), 1e-5 + 1e-5 * std::abs(double(f32.work_j)));
            EXPECT_NEAR(double(q31.change_j), double(f32.change_j), 1e-4 + 1e-5 * std::abs(double(f32.change_j)));
            EXPECT_NEAR(double(q31.sd_j), double(f32.sd_j), 1e-5 * double(f32.sd_j));
            EXPECT_EQ(q31.known, f32.known);
            EXPECT_EQ(q31.change_known, f32.change_known);
            said.push_back(f32);
        }
        return said;
    }

  private:
    sd_work_tables_t tables_;
    sd_work_meter_t meter_{};
    double time_s_ = 400; // the timer wraps after 429 s
    int advance_ = 0;
};

EngineFile single() {
    EngineFile engine = engine_named("single_generator.toml");
    engine.inertia_kgm2 = 0.02, engine.reciprocating_mass_kg = 0;
    return engine;
}

double gained(double from, double to) { return 0.01 * (to * to - from * from); }

TEST(Work, IsTheEnergyGainedOverACycle) {
    Crank crank(work_windows(single(), 0));
    EXPECT_EQ(crank.turn(300).at(0).known, 0) << "nothing to compare with";
    double before = 300, last = 0;
    for (const double radps : {300.0, 301.0, 300.5, 310.0, 280.0}) {
        const sd_work_out_t out = crank.turn(radps).at(0);
        ASSERT_TRUE(out.known);
        EXPECT_NEAR(double(out.work_j), gained(before, radps), 0.001 * std::abs(gained(before, radps)) + 0.02);
        if (out.change_known) { EXPECT_NEAR(double(out.change_j), double(out.work_j) - last, 0.01); }
        before = radps, last = double(out.work_j);
    }
}

TEST(Work, HoldsOverTheTimersWrap) {
    Crank crank(work_windows(single(), 0));
    crank.turn(300);
    double worst = 0;
    for (int i = 0; i < 1000; ++i) worst = std::max(worst, std::abs(double(crank.turn(300).at(0).work_j))); // 42 s
    EXPECT_LT(worst, 0.02);
    EXPECT_GT(worst, 1e-6) << "times are rounded to ticks";
}

TEST(Work, StatesWhatEdgesLeave) {
    const sd_work_tables_t tables = work_windows(single(), 0);
    Crank crank(tables);
    crank.turn(300);
    const sd_work_out_t out = crank.turn(300).at(0);
    EXPECT_NEAR(double(out.sd_j), 4 * 900 * kEdgeRad / double(tables.window[0].span_rad), 0.02);
}

TEST(Work, ALostOrUnsureEndCostsTwoValuesAndNoWrongOne) {
    const sd_work_tables_t tables = work_windows(single(), 0);
    for (const int at : {int(tables.window[0].first), int(tables.window[0].last)}) {
        ASSERT_LT((tables.window[0].first + 120 - kStart) % 120, (tables.window[0].last + 120 - kStart) % 120);
        for (const bool lost : {true, false}) {
            Crank crank(tables);
            crank.turn(300), crank.turn(300);
            std::vector<sd_work_out_t> said;
            for (const auto &out : crank.turn(305, lost ? at : -1, lost ? -1 : at)) said.push_back(out);
            for (int i = 0; i < 3; ++i)
                for (const auto &out : crank.turn(305)) said.push_back(out);
            int unknown = 0;
            for (const auto &out : said) {
                unknown += !out.known;
                if (out.known) { EXPECT_NEAR(double(out.work_j), 0, 0.02) << at << lost; }
            }
            EXPECT_EQ(unknown, 2) << at << lost;
        }
    }
}

TEST(Work, TeethLostWithinAWindowDoNotMatter) {
    const sd_work_tables_t tables = work_windows(single(), 0);
    Crank crank(tables);
    crank.turn(300);
    EXPECT_NEAR(double(crank.turn(301, (tables.window[0].first + 3) % 120).at(0).work_j), gained(300, 301), 0.05);
}

TEST(Work, AnEngineWithoutWindowsSaysNothing) {
    Crank crank(sd_work_tables_t{});
    EXPECT_TRUE(crank.turn(300).empty());
    EXPECT_TRUE(crank.turn(310).empty());
}

TEST(Work, TablesOutOfRangeAreRefused) {
    const sd_work_tables_t good = work_windows(single(), 0);
    EXPECT_TRUE(sd_work_tables_ok(&good));
    const auto refused = [&](auto change) {
        sd_work_tables_t bad = good;
        change(bad);
        return !sd_work_tables_ok(&bad);
    };
    EXPECT_TRUE(refused([](sd_work_tables_t &t) { t.window[0].energy_jticks2 = NAN; }));
    EXPECT_TRUE(refused([](sd_work_tables_t &t) { t.window[0].energy_jticks2 = 0; }));
    EXPECT_TRUE(refused([](sd_work_tables_t &t) { t.window[0].span_rad = 13; }));
    EXPECT_TRUE(refused([](sd_work_tables_t &t) { t.window[0].last = 120; }));
    EXPECT_TRUE(refused([](sd_work_tables_t &t) { t.window[0].last = t.window[0].first; }));
    EXPECT_TRUE(refused([](sd_work_tables_t &t) { t.windows = SD_WORK_WINDOWS_MAX + 1; }));
}

double from_tdc_deg(const EngineFile &engine, std::size_t firing, int position) {
    const double deg = engine.position_0_deg + position * 360.0 / engine.wheel.positions - engine.firing_tdc_deg[firing];
    return deg - 720 * std::floor(deg / 720);
}

TEST(WorkWindows, OfASingleReachFromExhaustToCompression) {
    const EngineFile engine = single();
    const sd_work_tables_t tables = work_windows(engine, 0);
    ASSERT_EQ(tables.windows, 1);
    EXPECT_NEAR(from_tdc_deg(engine, 0, tables.window[0].first), 180, 7);
    EXPECT_NEAR(from_tdc_deg(engine, 0, tables.window[0].last), engine.intake_close_deg, 19); // the mark may stand there
    EXPECT_EQ(tables.own, 1);
    EXPECT_EQ(tables.alike, 0);
    EXPECT_NEAR(double(work_windows(engine, 90).window[0].span_rad), M_PI / 2, 0.22);
}

TEST(WorkWindows, OfEveryEngineLieBetweenTeethInFiringOrder) {
    for (const char *name : {"diesel_22.toml", "eight_diesel.toml", "vee6_uneven.toml", "vw_aba.toml", "cat_3126b.toml"}) {
        const EngineFile engine = engine_named(name);
        const sd_work_tables_t tables = work_windows(engine, 0);
        ASSERT_EQ(tables.windows, engine.cylinders()) << name;
        ASSERT_TRUE(sd_work_tables_ok(&tables)) << name;
        double before = 0;
        for (std::size_t i = 0; i < std::size_t(tables.windows); ++i) {
            const auto &w = tables.window[i];
            for (const int k : {int(w.first), int(w.last)})
                for (const int missing : engine.wheel.missing) EXPECT_NE(k % engine.wheel.positions, missing) << name;
            const double pitch_deg = 360.0 / engine.wheel.positions;
            const double first = engine.firing_tdc_deg[i] + from_tdc_deg(engine, i, w.first);
            EXPECT_GT(first, before) << name << i;
            before = first + double(w.span_rad) * 180 / M_PI;
            EXPECT_NEAR(from_tdc_deg(engine, i, w.last) - from_tdc_deg(engine, i, w.first), before - first, 1e-3) << name << i;
            EXPECT_GE(before - first, 3 * pitch_deg - 1e-6) << name << i;
        }
    }
}

TEST(WorkWindows, SayWhoseTheDifferenceIs) {
    const EngineFile four = engine_named("diesel_22.toml"), eight = engine_named("eight_diesel.toml");
    const sd_work_tables_t of_four = work_windows(four, 0), of_eight = work_windows(eight, 0);
    EXPECT_EQ(of_four.own, 0xf);
    EXPECT_EQ(of_four.alike, 1);
    EXPECT_EQ(of_eight.own, 0) << "firings 90 deg apart overlap";
    for (const double share : own_shares(four, of_four)) EXPECT_GT(share, 0.9);
    for (const double share : own_shares(eight, of_eight)) EXPECT_LT(share, 0.9);
    EXPECT_EQ(work_windows(engine_named("triple_10.toml"), 0).windows, 0) << "two masses and a spring between them";
}

} // namespace
