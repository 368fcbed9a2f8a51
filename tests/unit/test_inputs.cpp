// SPDX-License-Identifier: MIT
// Inputs of the ecu: age, usual value, and for every pair of input and output what is said once the input falls silent.
#include <cstring>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <vector>

#include "common/toml_file.hpp"
#include "design/airpath/airpath_tables.hpp"
#include "golden_run.hpp"
#include "loop/ecu_bench.hpp"
#include "sd_inputs.h"

using namespace sixdeg;

namespace {

constexpr float kTickHz = 1e6f;

TEST(Inputs, EveryReadingCountsForItsAgeAndNoLongerHoweverTheTimerWraps) {
    for (std::uint32_t i = 0; i < SD_INPUT_COUNT; ++i) {
        SCOPED_TRACE(sd_input_infos[i].name);
        const auto input = sd_input_t(i);
        const float age_s = sd_input_infos[i].age_s, reading = sd_input_infos[i].high;
        for (std::uint32_t start : {0u, 0xfffffff0u}) {
            sd_inputs_t inputs{};
            EXPECT_EQ(sd_input_infos[i].usual, sd_inputs_value(&inputs, input)) << "never read";
            ASSERT_TRUE(sd_inputs_take(&inputs, std::uint16_t(i), start, reading));
            const auto after = [&](double s) { return start + std::uint32_t(s * double(kTickHz)); };
            sd_inputs_age(&inputs, start - 5, kTickHz);
            EXPECT_TRUE(sd_inputs_fresh(&inputs, input)) << "taken after the clock was read";
            sd_inputs_age(&inputs, after(0.99 * double(age_s)), kTickHz);
            EXPECT_EQ(reading, sd_inputs_value(&inputs, input));
            sd_inputs_age(&inputs, after(1.01 * double(age_s)), kTickHz);
            EXPECT_EQ(age_s == 0, sd_inputs_fresh(&inputs, input));
            for (double s = 1.02 * double(age_s); s < 9000; s += 1500) sd_inputs_age(&inputs, after(s), kTickHz); // two wraps
            EXPECT_EQ(age_s == 0, sd_inputs_fresh(&inputs, input)) << "once too old it stays so";
            ASSERT_TRUE(sd_inputs_take(&inputs, std::uint16_t(i), start + 77, reading));
            EXPECT_EQ(reading, sd_inputs_value(&inputs, input)) << "it speaks again";
        }
    }
}

TEST(Inputs, WhatIsUnknownOutOfRangeOrNoNumberIsCountedAndLeftOut) {
    sd_inputs_t inputs{};
    const sd_input_info_t &info = sd_input_infos[0];
    EXPECT_FALSE(sd_inputs_take(&inputs, SD_INPUT_COUNT, 1, 1));
    EXPECT_FALSE(sd_inputs_take(&inputs, 0, 1, info.high * 1.01f));
    EXPECT_FALSE(sd_inputs_take(&inputs, 0, 1, NAN));
    EXPECT_EQ(3u, inputs.rejected);
    EXPECT_EQ(0u, inputs.seen);
}

/// Health and reasons of every row an owner's signals came in, with the tick of the event that was handled then.
struct Said {
    std::uint32_t tick;
    std::uint8_t health;
    std::uint32_t why;
};

struct Heard {
    std::map<int, std::vector<Said>> of; ///< By owner.
    std::vector<std::pair<std::uint32_t, float>> trims;
};

/// The page of the smooth golden run has no air path; it gets another engine's, so that this owner speaks too.
GoldenRun golden_run_with_air_path() {
    GoldenRun run = read_golden_run(std::filesystem::path(SD_GOLDEN) / "smooth.run", SD_ENGINES);
    TomlFile air_path_file{std::filesystem::path(SD_MODELS) / "airpath_matched.toml"};
    TomlFile design_file{std::filesystem::path(SD_MODELS) / "airpath_matched_design.toml"};
    run.calibration.airpath = read_air_path_design(design_file, *read_air_path(air_path_file), 7.2e-3).tables;
    return run;
}

/// The smooth golden run, with a reading of every input that it does not hold at each clock event; of `silent` nothing from
/// `from_tick` on. SD_INPUT_COUNT: all speak.
Heard drive(std::uint32_t silent, std::uint32_t from_tick) {
    static const GoldenRun run = golden_run_with_air_path();
    std::uint32_t held = 0;
    for (const sd_event_t &event : run.events) {
        if (event.kind == SD_EVENT_SAMPLE) held |= 1u << event.channel;
    }
    Heard heard;
    std::uint32_t now = 0;
    const auto bench = std::make_unique<EcuBench>(run.calibration);
    bench->listen([&](bool out, const sd_event_t &event) {
        if (!out || event.kind != SD_EVENT_SIGNAL) return;
        heard.of[sd_signal_infos[event.channel].owner].push_back({now, std::uint8_t(event.flags & 0xff), event.flags >> 8});
        if (event.channel != SD_SIGNAL_BALANCE_TRIM) return;
        float value;
        std::memcpy(&value, &event.value, sizeof value);
        heard.trims.emplace_back(now, value);
    });
    for (const sd_event_t &event : run.events) {
        now = event.tick;
        if (event.kind == SD_EVENT_SAMPLE && event.channel == silent && now >= from_tick) continue;
        for (std::uint16_t i = 0; event.kind == SD_EVENT_TIME && i < SD_INPUT_COUNT; ++i) {
            if ((held >> i & 1u) != 0 || (i == silent && now >= from_tick)) continue;
            sd_event_t sample{now, SD_EVENT_SAMPLE, i, 0, 0};
            const float value = i == SD_INPUT_FUEL_LEVEL ? 50.0f : sd_input_infos[i].usual;
            std::memcpy(&sample.value, &value, sizeof value);
            bench->exchange(sample);
        }
        bench->exchange(event);
    }
    return heard;
}

constexpr double kHz = 1e6; ///< Of the diesel's capture timer.
constexpr std::uint32_t kFallsSilent = 3'000'000, kFallsEarly = 2'000'000; ///< The second of what counts for longer than 1.5 s.
constexpr double kCycle_s = 0.085; ///< At the 1500 rpm of the run, a little more.

/// The worst an owner says from `from_tick` on, and the reasons that stand in every row from there.
std::pair<std::uint8_t, std::uint32_t> standing(const std::vector<Said> &rows, std::uint32_t from_tick) {
    std::uint8_t best = SD_INVALID;
    std::uint32_t always = 0xffffu;
    int count = 0;
    for (const Said &row : rows) {
        if (row.tick < from_tick) continue;
        best = std::min(best, row.health), always &= row.why, ++count;
    }
    EXPECT_GT(count, 5);
    return {best, always};
}

/// Owners of what the page has no tables of say nothing: a driveline's.
bool has_no_tables(int owner) { return std::string(sd_owner_infos[owner].name).rfind("driveline", 0) == 0; }

std::uint8_t promised(const sd_owner_info_t &owner, std::uint32_t input) {
    return (owner.invalid_without >> input & 1u) != 0 ? SD_INVALID : (owner.degraded_without >> input & 1u) != 0 ? SD_DEGRADED : SD_VALID;
}

TEST(Inputs, EveryOutputSaysWithinLimitAndCycleThatAnInputItTakesFellSilent) {
    const Heard all = drive(SD_INPUT_COUNT, 0);
    for (std::uint32_t input = 0; input < SD_INPUT_COUNT; ++input) {
        SCOPED_TRACE(sd_input_infos[input].name);
        const double age_s = double(sd_input_infos[input].age_s);
        const std::uint32_t falls = age_s > 1.5 ? kFallsEarly : kFallsSilent;
        const auto due = std::uint32_t(falls + (age_s + 0.011 + kCycle_s) * kHz);
        const Heard heard = drive(input, falls);
        if (age_s > 2.5) { // longer than this run: then nothing may depend on it, which the table says
            for (const sd_owner_info_t &owner : sd_owner_infos) EXPECT_EQ(SD_VALID, promised(owner, input)) << owner.name;
            continue;
        }
        for (int owner = 0; owner < int(SD_OWNER_COUNT); ++owner) {
            SCOPED_TRACE(sd_owner_infos[owner].name);
            if (has_no_tables(owner)) continue;
            const std::uint8_t least = promised(sd_owner_infos[owner], input);
            const auto [best, always] = standing(heard.of.at(owner), due);
            EXPECT_GE(best, least);
            EXPECT_EQ(least != SD_VALID, (always & SD_WHY_STALE_INPUT) != 0);
            const auto [best_before, always_before] = standing(all.of.at(owner), falls);
            EXPECT_EQ(0u, always_before & SD_WHY_STALE_INPUT) << "while all speak";
            EXPECT_EQ(0u, always_before & SD_WHY_NO_INPUT) << "while all speak";
        }
    }
}

TEST(Inputs, EveryOutputSaysThatAnInputItTakesWasNeverRead) {
    for (std::uint32_t input = 0; input < SD_INPUT_COUNT; ++input) {
        SCOPED_TRACE(sd_input_infos[input].name);
        const Heard heard = drive(input, 0);
        for (int owner = 0; owner < int(SD_OWNER_COUNT); ++owner) {
            SCOPED_TRACE(sd_owner_infos[owner].name);
            if (has_no_tables(owner)) continue;
            const std::uint8_t least = promised(sd_owner_infos[owner], input);
            const auto [best, always] = standing(heard.of.at(owner), kFallsSilent);
            EXPECT_GE(best, least);
            EXPECT_EQ(least != SD_VALID, (always & SD_WHY_NO_INPUT) != 0);
            EXPECT_EQ(0u, always & SD_WHY_STALE_INPUT);
        }
    }
}

TEST(Inputs, TrimsFreezeWhereAnInputOfTheirsFallsSilent) {
    const auto moved_after = [](const Heard &heard, std::uint32_t tick) {
        std::map<float, int> values; // of cylinder 1, the first channel of the array
        for (const auto &[when, trim] : heard.trims) {
            if (when >= tick) ++values[trim];
        }
        return values.size();
    };
    EXPECT_GT(moved_after(drive(SD_INPUT_COUNT, 0), kFallsSilent), 5u) << "they move while all speak";
    for (sd_input_t input : {SD_INPUT_AIR_INTAKE_PRESSURE, SD_INPUT_FUEL_INJECTED, SD_INPUT_EXHAUST_LAMBDA, SD_INPUT_BALANCE_ENABLE}) {
        SCOPED_TRACE(sd_input_infos[input].name);
        const double age_s = double(sd_input_infos[input].age_s);
        const Heard heard = drive(input, kFallsSilent);
        EXPECT_EQ(1u, moved_after(heard, std::uint32_t(kFallsSilent + (age_s + 0.011 + 2 * kCycle_s) * kHz)));
        EXPECT_NE(0.0f, heard.trims.back().second) << "frozen, not taken back";
    }
}

} // namespace
