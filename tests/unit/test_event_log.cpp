// SPDX-License-Identifier: MIT
// The event log: what is written comes back, what was touched does not; and the clock that unwraps its ticks.
#include "log/event_log.hpp"

#include <cstring>
#include <fstream>
#include <gtest/gtest.h>

#include "calibration/calibration.hpp"
#include "common/error.hpp"
#include "common/files.hpp"
#include "replay/replay_log.hpp"

using namespace sixdeg;
namespace fs = std::filesystem;

namespace {

sd_calibration_t page() {
    TomlFile engine(fs::path(SD_ENGINES) / "diesel_22.toml"), tune("tune", "");
    return calibrate(read_engine(engine), read_tune(tune), "tune");
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
