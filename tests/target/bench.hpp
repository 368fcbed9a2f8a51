// SPDX-License-Identifier: MIT
// Events for a controller, in lock-step and at their own times, and what an ecu on this host says to the same.
#pragma once
#include <cmath>
#include <cstring>
#include <filesystem>
#include <unistd.h>
#include <vector>

#include "common/files.hpp"
#include "golden_run.hpp"
#include "io/emulator/emulator.hpp"
#include "loop/ecu_bench.hpp"

namespace sixdeg {

/// A stretch of even teeth.
struct Stretch {
    double rpm;
    int edges;
};

/// A wheel of 60 - 2 teeth, its marks left out, and the clock every 10 ms; ticks of 1 us.
inline std::vector<sd_event_t> even_teeth(const std::vector<Stretch> &stretches) {
    std::vector<sd_event_t> events;
    double now_us = 20000, clock_us = 10000;
    int position = 0;
    for (const Stretch &stretch : stretches) {
        for (int edges = 0; edges < stretch.edges; ++position) {
            now_us += 1e6 / stretch.rpm;
            for (; clock_us < now_us; clock_us += 10000) events.push_back({std::uint32_t(clock_us), SD_EVENT_TIME, 0, 0, 0});
            if (position % 60 >= 58) continue;
            events.push_back({std::uint32_t(std::lround(now_us)), SD_EVENT_CRANK_EDGE, 0, 0, 0});
            ++edges;
        }
    }
    return events;
}

/// What the ecu of this host says to events, one by one.
inline std::vector<std::vector<sd_event_t>> host_says(const sd_calibration_t &calibration, const std::vector<sd_event_t> &events) {
    std::vector<std::vector<sd_event_t>> said;
    EcuBench bench(calibration);
    bench.listen([&](bool out, const sd_event_t &event) {
        if (out) said.back().push_back(event);
    });
    for (const sd_event_t &event : events) said.emplace_back(), bench.exchange(event);
    return said;
}

inline bool same(const std::vector<sd_event_t> &a, const std::vector<sd_event_t> &b) {
    return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(sd_event_t)) == 0);
}

/// Files of one bench, removed with it.
class BenchFiles {
  public:
    BenchFiles(const sd_calibration_t &calibration, const std::vector<sd_event_t> &events, std::uint32_t tick_ns) {
        const auto bytes = page_bytes(calibration);
        const std::uint32_t header[4] = {std::uint32_t(events.size()), std::uint32_t(bytes.size()), tick_ns, 0};
        write_file(page(), std::string(bytes.begin(), bytes.end()));
        write_file(events_file(), std::string(reinterpret_cast<const char *>(header), sizeof header) +
                                      std::string(reinterpret_cast<const char *>(events.data()), events.size() * sizeof(sd_event_t)));
    }
    ~BenchFiles() {
        std::error_code ignored;
        std::filesystem::remove(page(), ignored), std::filesystem::remove(events_file(), ignored);
    }
    std::filesystem::path page() const { return name("page"); }
    std::filesystem::path events_file() const { return name("events"); }

  private:
    std::filesystem::path name(const char *end) const {
        return std::filesystem::temp_directory_path() / ("bench_" + std::to_string(getpid()) + "." + end);
    }
};

/// What came of a bench.
struct BenchResult {
    std::vector<EmulatedAnswer> answers;
    sd_link_end_t end{};
    bool whole = false; ///< It came to its end.
};

/// Lets events happen at their own times on a controller whose instructions take 2^shift ns each.
inline BenchResult run_bench(const char *core_name, const sd_calibration_t &calibration, const std::vector<sd_event_t> &events, int shift,
                             std::uint32_t tick_ns = 1000) {
    const EmulatedCore &core = emulated_core(core_name);
    const BenchFiles files(calibration, events, tick_ns);
    Emulator emulator(core, {image_of(core), files.page(), files.events_file(), shift});
    BenchResult result;
    result.whole = emulator.take_bench(result.answers, result.end);
    return result;
}

} // namespace sixdeg
