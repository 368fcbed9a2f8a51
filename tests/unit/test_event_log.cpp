// SPDX-License-Identifier: MIT
// The event log: what is written comes back, what was touched does not; and the clock that unwraps its ticks.
#include "io/log/event_log.hpp"

#include <cmath>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <random>

#include "design/calibration.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "loop/replay_log.hpp"

using namespace sixdeg;
namespace fs = std::filesystem;

namespace {

const sd_calibration_t &page() {
    static const sd_calibration_t made = [] {
        TomlFile engine(fs::path(SD_ENGINES) / "diesel_22.toml"), tune("tune", "");
        return calibrate(read_engine(engine), read_tune(tune), "tune");
    }();
    return made;
}

class EventLogFile : public testing::Test {
  protected:
    EventLogFile() {
        folder = fs::path(testing::TempDir()) / testing::UnitTest::GetInstance()->current_test_info()->name();
        fs::remove_all(folder);
        file = folder / "a.sdlog";
    }
    ~EventLogFile() override { fs::remove_all(folder); }

    void write() const {
        LogWriter log(file, R"({"name": "test"})", page());
        for (const auto &[out, event] : events) log.add(out, event);
        log.finish();
    }
    /// What reading the file with these bytes says.
    std::string refusal(const std::string &bytes) const {
        write_file(file, bytes);
        try {
            read_log(file);
            return "";
        } catch (const InputError &error) {
            return error.what();
        }
    }

    fs::path folder, file;
    const std::vector<std::pair<bool, sd_event_t>> events = {
        {false, {0xfffffff0u, SD_EVENT_CRANK_EDGE, 0, 0, 0}},
        {true, {0xfffffff0u, SD_EVENT_SIGNAL, 7, 0x3f800000u, 0x102u}},
        {false, {5u, 0x7fffu, 0xffffu, 0xffffffffu, 0x80000000u}},
    };
};

TEST_F(EventLogFile, ComesBackAsItWas) {
    write();
    EXPECT_TRUE(is_log(file));
    const EventLog log = read_log(file);
    EXPECT_EQ(R"({"name": "test"})", log.about);
    EXPECT_EQ(page_bytes(page()), page_bytes(log.calibration));
    ASSERT_EQ(events.size(), log.events.size());
    for (std::size_t i = 0; i < events.size(); ++i) {
        const auto &[out, event] = events[i];
        const sd_event_t &back = log.events[i];
        EXPECT_EQ(event.kind | (out ? kLoggedOut : 0), back.kind);
        EXPECT_EQ(0, std::memcmp(&event.tick, &back.tick, sizeof event.tick));
        EXPECT_EQ(event.channel, back.channel);
        EXPECT_EQ(event.value, back.value);
        EXPECT_EQ(event.flags, back.flags);
    }
}

TEST_F(EventLogFile, EveryTouchedByteAndEveryCutIsRefused) {
    write();
    const std::string whole = read_file(file);
    for (std::size_t i = 0; i < whole.size(); i += 5) {
        std::string touched = whole;
        touched[i] = char(touched[i] ^ 0x20);
        EXPECT_NE("", refusal(touched)) << i;
        EXPECT_NE("", refusal(whole.substr(0, i))) << i;
    }
    EXPECT_NE("", refusal(whole + "x"));
    EXPECT_EQ(file.string() + ": is truncated or damaged: its checksum is wrong",
              refusal(whole.substr(0, whole.size() - 16)));
    EXPECT_EQ("", refusal(whole));
}

std::uint32_t crc32(const std::string &bytes) {
    std::uint32_t crc = 0xffffffffu;
    for (const char byte : bytes) {
        crc ^= std::uint8_t(byte);
        for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1u) ? 0xedb88320u : 0u);
    }
    return ~crc;
}

TEST_F(EventLogFile, WhateverStandsBehindRightChecksumsIsRefusedOrReplayed) {
    {
        LogWriter log(file, "{}", page());
        for (std::uint32_t k = 0; k < 600; ++k) {
            if (k % 60 < 58) log.add(false, {1000 * k, SD_EVENT_CRANK_EDGE, 0, 0, 0});
            if (k % 120 == 25) log.add(false, {1000 * k + 3, SD_EVENT_CAM_EDGE, 0, 0, 0});
            if (k % 10 == 9) log.add(false, {1000 * k + 500, SD_EVENT_TIME, 0, 0, 0});
        }
        log.finish();
    }
    const std::string whole = read_file(file);
    const std::size_t first = 24 + 2, size = page_bytes(page()).size();
    std::mt19937 random(5);
    int refused = 0, replayed = 0;
    for (int i = 0; i < 400; ++i) {
        std::string bytes = whole.substr(0, whole.size() - 32);
        for (unsigned flips = 1 + random() % 3; flips > 0; --flips) {
            // Half of them near a beginning: of the page, or of the file.
            const std::size_t at = random() % 2 ? random() % bytes.size()
                : (random() % 4 ? first + sizeof(sd_page_head_t) + random() % 400 : random() % 64);
            bytes[at] = char(random() % 4 ? random() : 0xff);
        }
        constexpr std::size_t head = sizeof(sd_page_head_t); // its last field is the checksum of all behind it
        const std::uint32_t crc = crc32(bytes.substr(first + head, size - head));
        for (unsigned b = 0; b < 4; ++b) bytes[first + head - 4 + b] = char(crc >> (8 * b));
        const std::string hex = sha256(bytes);
        for (std::size_t b = 0; b < 32; ++b) bytes += char(std::stoi(hex.substr(2 * b, 2), nullptr, 16));
        write_file(file, bytes);
        try {
            const EventLog log = read_log(file);
            const LogReplay replay = replay_log(log, log.calibration);
            for (const ToothRow &row : replay.teeth) {
                const auto *value = reinterpret_cast<const float *>(&row.signals);
                for (std::size_t c = 0; c < SD_SIGNAL_COUNT; ++c) ASSERT_TRUE(std::isfinite(value[c])) << i << ": "
                    << sd_signal_infos[c].name;
            }
            ++replayed;
        } catch (const InputError &error) {
            EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos);
            ++refused;
        }
    }
    EXPECT_GT(refused, 20);
    EXPECT_GT(replayed, 20);
}

TEST_F(EventLogFile, NothingStaysUntilItIsFinished) {
    {
        LogWriter log(file, "{}", page());
        for (int i = 0; i < 10000; ++i) log.add(false, events[0].second);
        EXPECT_FALSE(fs::exists(file));
    }
    EXPECT_TRUE(fs::is_empty(folder));
    fs::create_directories(file);
    EXPECT_THROW(LogWriter(file, "{}", page()), InputError) << "a folder of that name";
    EXPECT_FALSE(is_log(file));
    EXPECT_THROW(read_log(folder / "none"), InputError);
}

TEST(TickClock, GoesThroughTheWrapAndALittleBack) {
    TickClock clock(1e6);
    EXPECT_DOUBLE_EQ(4294.967290, clock.seconds(4294967290u));
    EXPECT_DOUBLE_EQ(4294.967300, clock.seconds(4u));
    EXPECT_DOUBLE_EQ(4294.967291, clock.seconds(4294967291u));
    EXPECT_DOUBLE_EQ(6000.0, clock.seconds(std::uint32_t(6000000000u % 4294967296u)));
}

} // namespace
