// SPDX-License-Identifier: MIT
// The firmware's images on emulated controllers (hal/cortexm): the same bits as on this host, a controller that dies, teeth that come
// faster than they are handled. And the port itself, which knows no hardware.
#include <csignal>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "bench.hpp"
#include "common/error.hpp"
#include "loop/emulator_feed.hpp"
extern "C" {
#include "sd_cortexm.h"
#include "sd_shed.h"
}

using namespace sixdeg;

namespace {

const GoldenRun &run(const std::string &name) {
    static std::map<std::string, GoldenRun> runs;
    if (runs.count(name) == 0) runs.emplace(name, read_golden_run(std::filesystem::path(SD_GOLDEN) / (name + ".run"), SD_ENGINES));
    return runs.at(name);
}

std::size_t teeth(const std::vector<sd_event_t> &events) {
    return std::size_t(std::count_if(events.begin(), events.end(), [](const sd_event_t &e) { return e.kind == SD_EVENT_CRANK_EDGE; }));
}

/// The first events that hold so many teeth.
std::vector<sd_event_t> beginning(const std::vector<sd_event_t> &events, std::size_t most) {
    std::size_t end = 0, seen = 0;
    while (end < events.size() && seen < most) seen += events[end++].kind == SD_EVENT_CRANK_EDGE;
    return {events.begin(), events.begin() + std::ptrdiff_t(end)};
}

/// Everything that goes in and out of a feed, in order.
struct Heard {
    std::vector<sd_event_t> in, out;
    EventListener listener() {
        return [this](bool said, const sd_event_t &event) { (said ? out : in).push_back(event); };
    }
};

std::vector<sd_event_t> joined(const std::vector<std::vector<sd_event_t>> &parts) {
    std::vector<sd_event_t> all;
    for (const auto &part : parts) all.insert(all.end(), part.begin(), part.end());
    return all;
}

void expect_same_bits(const char *core, const std::string &name, std::size_t most) {
    const auto events = beginning(run(name).events, most);
    Heard heard;
    EmulatorFeed feed(emulated_core(core), run(name).calibration, heard.listener());
    for (const sd_event_t &event : events) feed.send(event);
    feed.finish_controller();
    EXPECT_TRUE(same(heard.in, events)) << core << " " << name;
    EXPECT_TRUE(same(heard.out, joined(host_says(run(name).calibration, events)))) << core << " " << name;
    EXPECT_GT(heard.out.size(), 10 * teeth(events));
    EXPECT_EQ(feed.figures().end.overruns + feed.figures().end.lost_edges + feed.figures().end.lost_others, 0u);
}

} // namespace

/* ---- lock-step -------------------------------------------------------------------------------------------------------- */

TEST(Controller, SaysTheSameBitsAsThisHost) {
    expect_same_bits("cortex-m7", "misfires", 100000);
    expect_same_bits("cortex-m4f", "q31", 100000);
    expect_same_bits("cortex-m3", "smooth", 600);
    EXPECT_GE(teeth(run("misfires").events) + teeth(run("q31").events) + 600, 20000u);
}

TEST(Controller, ThatIsKilledLosesWhatItHandledAndThenIsAsOneThatWasReset) {
    const GoldenRun &golden = run("smooth");
    const auto events = beginning(golden.events, 3000);
    const auto clock_at = [&](std::size_t from) {
        while (events[from].kind != SD_EVENT_TIME) ++from;
        return from + 1;
    };
    const std::size_t killed = clock_at(events.size() / 2), lost = clock_at(killed);
    ASSERT_LE(lost - killed, std::size_t(SD_LINK_EVENTS));
    Heard heard;
    EmulatorFeed feed(emulated_core("m7"), golden.calibration, heard.listener());
    for (std::size_t i = 0; i < events.size(); ++i) {
        if (i == killed) {
            kill(feed.process(), SIGKILL);
            siginfo_t ended;
            waitid(P_PID, id_t(feed.process()), &ended, WEXITED | WNOWAIT);
        }
        feed.send(events[i]);
    }
    feed.finish_controller();
    const std::vector<sd_event_t> before(events.begin(), events.begin() + std::ptrdiff_t(killed)),
        after(events.begin() + std::ptrdiff_t(lost), events.end());
    auto expected_in = before, expected_out = joined(host_says(golden.calibration, before));
    const auto fresh = joined(host_says(golden.calibration, after));
    expected_in.insert(expected_in.end(), after.begin(), after.end());
    expected_out.insert(expected_out.end(), fresh.begin(), fresh.end());
    EXPECT_TRUE(same(heard.in, expected_in));
    EXPECT_TRUE(same(heard.out, expected_out));
    EXPECT_EQ(feed.figures().died, 1u);
    EXPECT_EQ(feed.figures().restarts, 1u);
}

TEST(Controller, WhoseCoreIsUnknownIsRefusedByName) {
    try {
        emulated_core("qemu:cortex-m33");
        FAIL();
    } catch (const InputError &error) {
        EXPECT_NE(std::string(error.what()).find("qemu:cortex-m4f"), std::string::npos) << error.what();
    }
}

/* ---- at their own times ------------------------------------------------------------------------------------------------- */

namespace {

struct Shown {
    std::vector<sd_event_t> in;
    std::uint32_t most = 0, last = 0;   ///< Levels that the port asked for.
    std::size_t wrong = 0, crank_shed = 0, shed = 0, edges = 0;
    std::size_t tasks = 0, late_tasks = 0, task_shed = 0; ///< Tasks done, clock events that came too early, signals that say so.
};

/// The bench's answers beside those of this host to the same events, the port's own among them.
Shown shown(const BenchResult &result, const sd_calibration_t &calibration) {
    Shown s;
    for (const EmulatedAnswer &answer : result.answers) s.in.push_back(answer.frame.in);
    const auto expected = host_says(calibration, s.in);
    for (std::size_t i = 0; i < s.in.size(); ++i) {
        s.wrong += !same(expected[i], result.answers[i].said);
        s.edges += s.in[i].kind == SD_EVENT_CRANK_EDGE;
        if (s.in[i].kind == SD_EVENT_TASK) ++s.tasks, s.late_tasks += s.in[i].value;
        if (s.in[i].kind == SD_EVENT_LATE) s.last = s.in[i].value, s.most = std::max(s.most, s.last);
        for (const sd_event_t &event : expected[i]) {
            if (event.kind != SD_EVENT_SIGNAL || ((event.flags >> 8) & SD_WHY_OVERLOAD) == 0) continue;
            ++s.shed;
            s.crank_shed += sd_signal_infos[event.channel].owner == SD_OWNER_CRANK;
            s.task_shed += sd_signal_infos[event.channel].owner == SD_OWNER_AIRPATH;
        }
    }
    return s;
}

} // namespace

TEST(Controller, FollowsTeethFromOneToTenThousandRpmWithoutAnOverrun) {
    const sd_calibration_t &calibration = run("smooth").calibration;
    const auto slow = even_teeth({{1, 6}, {10, 20}, {100, 200}});
    const auto fast = even_teeth({{1000, 400}, {3000, 800}, {10000, 4000}});
    for (const auto &[events, shift] : {std::pair(slow, 10), std::pair(fast, 3)}) { // 1 and 125 million instructions a second
        const BenchResult result = run_bench("m7", calibration, events, shift);
        ASSERT_TRUE(result.whole);
        const Shown s = shown(result, calibration);
        EXPECT_EQ(s.edges, teeth(events));
        EXPECT_EQ(s.wrong, 0u) << "this host says something else to the same events";
        EXPECT_EQ(result.end.overruns + result.end.lost_edges + result.end.lost_others, 0u);
        EXPECT_EQ(s.most, 0u);
    }
}

TEST(Controller, OverloadedLeavesOutWorkSaysSoAndTakesItUpAgain) {
    const sd_calibration_t &calibration = run("smooth").calibration;
    // 31 million instructions a second: of a tooth's 3,700 on average 3,125 fit between two at 10,000 rpm.
    const auto events = even_teeth({{3000, 600}, {10000, 3000}, {3000, 10000}});
    const BenchResult result = run_bench("m7", calibration, events, 5);
    ASSERT_TRUE(result.whole);
    const Shown s = shown(result, calibration);
    EXPECT_EQ(s.edges, teeth(events)) << "no tooth is lost";
    EXPECT_EQ(s.wrong, 0u) << "this host says something else to the same events";
    EXPECT_GT(result.end.overruns, 0u);
    EXPECT_GT(result.end.nested, 0u) << "the capture interrupt goes before the work";
    EXPECT_EQ(result.end.lost_edges + result.end.lost_others, 0u);
    EXPECT_GE(s.most, std::uint32_t(SD_SHED_CYCLE));
    EXPECT_EQ(s.last, 0u) << "at 3000 rpm everything is done again";
    EXPECT_GT(s.shed, 0u) << "what is left out says so";
    EXPECT_EQ(s.crank_shed, 0u) << "the angle is never left out";
}

namespace {

/// What goes into the ecu of an engine with an air path within two seconds: teeth at 1500 rpm, samples, the clock.
const std::vector<sd_event_t> &air_path_events(sd_calibration_t &calibration) {
    static const Scenario scenario =
        read_scenario(std::filesystem::path(SD_ENGINES) / ".." / "scenarios" / "airpath_section7.toml", {"run.duration_s=2"});
    static const sd_calibration_t page = [] {
        TomlFile tune("tune", "");
        return calibrate(scenario.engine.shared, read_tune(tune), "tune");
    }();
    static const std::vector<sd_event_t> events = [] {
        Heard heard;
        run_on_bench(scenario, page, nullptr, nullptr, heard.listener());
        return heard.in;
    }();
    calibration = page;
    return events;
}

} // namespace

TEST(Controller, TeethInterruptTheTaskOfTenMilliseconds) {
    sd_calibration_t calibration;
    const auto &events = air_path_events(calibration);
    const BenchResult result = run_bench("m7", calibration, events, 5); // 31 million instructions a second
    ASSERT_TRUE(result.whole);
    const Shown s = shown(result, calibration);
    EXPECT_EQ(s.wrong, 0u) << "this host says something else to the same events";
    EXPECT_EQ(s.edges, teeth(events));
    EXPECT_GT(s.tasks, 150u);
    EXPECT_GT(result.end.interrupted, 0u) << "no tooth was handled while the task was under way";
    EXPECT_EQ(result.end.tasks_late + result.end.lost_edges + result.end.lost_others + result.end.overruns, 0u);
    EXPECT_EQ(s.late_tasks + s.task_shed, 0u);
}

TEST(Controller, WhoseTaskOfTenMillisecondsIsLateSaysSo) {
    sd_calibration_t calibration;
    const auto &events = air_path_events(calibration);
    const BenchResult result = run_bench("m7", calibration, events, 9); // 2 million a second: 1,300 a tooth
    ASSERT_TRUE(result.whole);
    const Shown s = shown(result, calibration);
    EXPECT_EQ(s.wrong, 0u) << "this host says something else to the same events";
    const auto edges = [](const std::vector<sd_event_t> &all) { // of the cam, too
        const auto cams = std::count_if(all.begin(), all.end(), [](const sd_event_t &e) { return e.kind == SD_EVENT_CAM_EDGE; });
        return teeth(all) + std::size_t(cams);
    };
    EXPECT_EQ(edges(s.in) + result.end.lost_edges, edges(events)) << "each edge is handled or counted";
    EXPECT_GT(result.end.tasks_late, 0u);
    EXPECT_EQ(s.late_tasks, result.end.tasks_late);
    EXPECT_GT(s.task_shed, 0u) << "what comes late says so";
    EXPECT_GT(s.tasks, 0u);
}

TEST(Controller, HopelesslyOverloadedLosesTeethAndSaysWhere) {
    const sd_calibration_t &calibration = run("smooth").calibration;
    const auto events = even_teeth({{1500, 200}, {10000, 1500}, {1000, 400}});
    const BenchResult result = run_bench("m7", calibration, events, 8); // 3.9 million a second: 390 a tooth
    ASSERT_TRUE(result.whole);
    const Shown s = shown(result, calibration);
    EXPECT_EQ(s.wrong, 0u);
    EXPECT_GT(result.end.lost_edges, 0u);
    EXPECT_EQ(s.edges + result.end.lost_edges, teeth(events)) << "each edge is handled or counted";
    EXPECT_TRUE(std::any_of(s.in.begin(), s.in.end(), [](const sd_event_t &e) { return e.kind == SD_EVENT_GAP; }));
    EXPECT_EQ(s.most, std::uint32_t(SD_SHED_MOST));
}

/* ---- what is left out ------------------------------------------------------------------------------------------------------ */

namespace {

/// Reasons of an owner's last signals, by owner.
std::map<int, std::uint32_t> last_reasons(const std::vector<std::vector<sd_event_t>> &said, std::size_t begin, std::size_t end) {
    std::map<int, std::uint32_t> reasons;
    for (std::size_t i = begin; i < end; ++i)
        for (const sd_event_t &event : said[i])
            if (event.kind == SD_EVENT_SIGNAL) reasons[sd_signal_infos[event.channel].owner] = event.flags >> 8;
    return reasons;
}

} // namespace

TEST(Shed, LeavesOutWhatItsLevelSaysAndNothingElse) {
    const GoldenRun &golden = run("smooth");
    for (std::uint32_t level = SD_SHED_NONE; level <= SD_SHED_MOST; ++level) {
        auto events = beginning(golden.events, 4500);
        const std::size_t from = events.size() / 2, to = from + events.size() / 4;
        events.insert(events.begin() + std::ptrdiff_t(to), {events[to].tick, SD_EVENT_LATE, 0, SD_SHED_NONE, 0});
        events.insert(events.begin() + std::ptrdiff_t(from), {events[from].tick, SD_EVENT_LATE, 0, level, 1});
        const auto said = host_says(golden.calibration, events);
        auto during = last_reasons(said, from, to), after = last_reasons(said, to + 1, said.size());
        const auto shed = [&](sd_owner_t owner) { return (during.at(owner) & SD_WHY_OVERLOAD) != 0; };
        for (const sd_owner_t owner : {SD_OWNER_CYLINDER, SD_OWNER_AFR, SD_OWNER_BALANCE}) EXPECT_EQ(shed(owner), level >= SD_SHED_CYCLE);
        for (const sd_owner_t owner : {SD_OWNER_FIRING, SD_OWNER_MISFIRE}) EXPECT_EQ(shed(owner), level >= SD_SHED_FIRINGS) << level;
        for (const sd_owner_t owner : {SD_OWNER_CRANK, SD_OWNER_TORQUE, SD_OWNER_INPUTS}) EXPECT_FALSE(shed(owner));
        for (const auto &[owner, why] : after) EXPECT_EQ(why & SD_WHY_OVERLOAD, 0u) << "owner " << owner << " after level " << level;
    }
}

/* ---- the port alone ------------------------------------------------------------------------------------------------------ */

namespace {

struct Port {
    sd_cortexm_t self;
    std::uint32_t tick = 0;
    Port() { sd_cortexm_init(&self); }
    void edge() { sd_cortexm_edge(&self, SD_EVENT_CRANK_EDGE, ++tick); }
    /// Handles what waits; returns kinds in order.
    std::vector<int> handle(std::uint32_t *level = nullptr) {
        std::vector<int> kinds;
        sd_event_t event;
        while (sd_cortexm_next(&self, &event)) {
            kinds.push_back(event.kind);
            if (event.kind == SD_EVENT_LATE && level != nullptr) *level = event.value;
        }
        return kinds;
    }
    /// Edges handled in time until the level changes; how many.
    std::uint32_t calm(std::uint32_t &level) {
        const std::uint32_t before = level;
        std::uint32_t edges = 0;
        while (level == before && edges < 4 * SD_CORTEXM_PATIENCE_MAX) edge(), handle(&level), ++edges;
        return edges;
    }
};

} // namespace

TEST(Port, HandsOutEdgesBeforeWhatIsLessUrgentAndKeepsTheirOrder) {
    Port port;
    const sd_event_t clock{5, SD_EVENT_TIME, 0, 0, 0};
    sd_cortexm_post(&port.self, &clock);
    sd_cortexm_edge(&port.self, SD_EVENT_CAM_EDGE, 3);
    port.edge();
    EXPECT_EQ(port.handle(), (std::vector<int>{SD_EVENT_CAM_EDGE, SD_EVENT_CRANK_EDGE, SD_EVENT_TIME}));
    EXPECT_EQ(port.self.overruns, 0u);
}

TEST(Port, HandsOutNothingButEdgesUntilTheTaskIsDoneAndSaysWhetherItWasLate) {
    Port port;
    const sd_event_t clock{5, SD_EVENT_TIME, 0, 0, 0}, sample{6, SD_EVENT_SAMPLE, 0, 0, 0}, next{7, SD_EVENT_TIME, 0, 0, 0};
    sd_event_t event;
    sd_cortexm_post(&port.self, &clock);
    ASSERT_TRUE(sd_cortexm_next(&port.self, &event));
    EXPECT_EQ(event.flags, SD_TIME_PUT_OFF);
    EXPECT_TRUE(sd_cortexm_task_due(&port.self));
    sd_cortexm_post(&port.self, &sample), sd_cortexm_post(&port.self, &next);
    port.edge();
    EXPECT_EQ(port.handle(), (std::vector<int>{SD_EVENT_CRANK_EDGE}));
    EXPECT_EQ(port.self.tasks_late, 1u);
    sd_cortexm_task_done(&port.self);
    EXPECT_FALSE(sd_cortexm_task_due(&port.self));
    port.edge();
    ASSERT_TRUE(sd_cortexm_next(&port.self, &event));
    EXPECT_EQ(event.kind, SD_EVENT_CRANK_EDGE) << "edges go first";
    ASSERT_TRUE(sd_cortexm_next(&port.self, &event));
    EXPECT_EQ(event.kind, SD_EVENT_TASK);
    EXPECT_EQ(event.tick, clock.tick);
    EXPECT_EQ(event.value, 1u);
    EXPECT_EQ(port.handle(), (std::vector<int>{SD_EVENT_SAMPLE, SD_EVENT_TIME}));
    sd_cortexm_task_done(&port.self);
    ASSERT_TRUE(sd_cortexm_next(&port.self, &event));
    EXPECT_EQ(event.value, 0u) << "this one was in time";
}

TEST(Port, SaysOneLevelMoreAfterAnOverrunAndTakesItBackAfterItsPatience) {
    Port port;
    std::uint32_t level = 0;
    port.edge(), port.edge();
    EXPECT_EQ(port.handle(&level), (std::vector<int>{SD_EVENT_LATE, SD_EVENT_CRANK_EDGE, SD_EVENT_CRANK_EDGE}));
    EXPECT_EQ(level, 1u);
    const std::uint32_t first = port.calm(level);
    EXPECT_EQ(level, 0u);
    port.edge(), port.edge(), port.handle(&level); // at once again: more patience
    EXPECT_EQ(level, 1u);
    EXPECT_GE(port.calm(level), 2 * first - 4);
    for (int i = 0; i < 10; ++i) port.edge(), port.edge(), port.handle(&level);
    EXPECT_EQ(level, std::uint32_t(SD_SHED_MOST));
}

TEST(Port, CountsWhatItHasNoRoomForAndSaysWhereEdgesAreMissing) {
    Port port;
    for (std::uint32_t i = 0; i < SD_CORTEXM_EDGES + 3; ++i) port.edge();
    EXPECT_EQ(port.self.lost_edges, 3u);
    auto kinds = port.handle();
    EXPECT_EQ(std::count(kinds.begin(), kinds.end(), int(SD_EVENT_CRANK_EDGE)), std::ptrdiff_t(SD_CORTEXM_EDGES));
    EXPECT_EQ(std::count(kinds.begin(), kinds.end(), int(SD_EVENT_GAP)), 0);
    port.edge();
    EXPECT_EQ(port.handle(), (std::vector<int>{SD_EVENT_GAP, SD_EVENT_CRANK_EDGE}));
    const sd_event_t sample{0, SD_EVENT_SAMPLE, 0, 0, 0};
    for (std::uint32_t i = 0; i < SD_CORTEXM_OTHERS + 2; ++i) sd_cortexm_post(&port.self, &sample);
    EXPECT_EQ(port.self.lost_others, 2u);
}
