// SPDX-License-Identifier: MIT
#include "loop/bus_run.hpp"

#include <algorithm>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include "loop/bus_truth.hpp"
#include "design/calibration.hpp"
#include "common/error.hpp"
#include "common/files.hpp"

extern char **environ;

namespace sixdeg {
namespace {

/// `sixdeg ecu` with this very page, for as long as this object lives.
class EcuChild {
  public:
    EcuChild(const std::string &transport, const sd_calibration_t &calibration)
        : page_(std::filesystem::temp_directory_path() / fmt::format("sixdeg_{}.bin", getpid())) {
        const auto bytes = page_bytes(calibration);
        write_file(page_, std::string(bytes.begin(), bytes.end()));
        std::string words[] = {"sixdeg", "ecu", page_.string(), "--transport", transport};
        char *arguments[6] = {};
        std::transform(std::begin(words), std::end(words), arguments, [](std::string &word) { return word.data(); });
        const int error = posix_spawn(&child_, "/proc/self/exe", nullptr, nullptr, arguments, environ);
        if (error != 0) throw InputError("sixdeg ecu", "", std::strerror(error));
    }
    ~EcuChild() {
        kill(child_, SIGTERM);
        if (!ends_within(std::chrono::seconds(10))) {
            kill(child_, SIGKILL);
            ends_within(std::chrono::seconds(10));
        }
        std::error_code ignored;
        std::filesystem::remove(page_, ignored);
    }
    EcuChild(const EcuChild &) = delete;
    EcuChild &operator=(const EcuChild &) = delete;

  private:
    bool ends_within(std::chrono::seconds allowed) const {
        const auto until = std::chrono::steady_clock::now() + allowed;
        while (waitpid(child_, nullptr, WNOHANG) == 0) {
            if (std::chrono::steady_clock::now() > until) return false;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        return true;
    }

    std::filesystem::path page_;
    pid_t child_ = 0;
};

double share(std::vector<float> values, double part) {
    if (values.empty()) return 0;
    const auto at = values.begin() + std::ptrdiff_t(part * double(values.size() - 1));
    std::nth_element(values.begin(), at, values.end());
    return double(*at);
}

} // namespace

RunResult run_on_bus(const BusChoice &choice, const Scenario &scenario, const sd_calibration_t &calibration,
                     RunTables *tables, const EventListener &listener, BusFigures &figures) {
    const auto bus = open_bus(choice.transport, SD_ROLE_PLANT);
    std::optional<EcuChild> ecu;
    if (choice.start_ecu) ecu.emplace(choice.transport, calibration);
    BusFeed feed(*bus, double(calibration.tick_hz), choice.pace, listener);
    BusTruth truth(*bus);
    const auto start = std::chrono::steady_clock::now();
    const RunResult result = run_scenario(scenario, calibration, feed, tables, &truth);
    truth.end();
    figures.took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    figures.counts = bus->counts();
    figures.clock_events = feed.clock_events();
    figures.silences = feed.silences();
    figures.restarts = feed.restarts();
    figures.missed = feed.missed();
    figures.dropped = feed.dropped();
    figures.round_trip_p50_us = share(feed.round_trips_us(), 0.5);
    figures.round_trip_p99_us = share(feed.round_trips_us(), 0.99);
    return result;
}

nlohmann::ordered_json bus_json(const BusChoice &choice, const BusFigures &figures) {
    return {{"transport", choice.transport},
            {"pace", choice.pace.real_time ? "real time" : "lock-step"},
            {"clock_events", figures.clock_events},
            {"missed_deadlines", figures.missed},
            {"silences", figures.silences},
            {"restarts", figures.restarts},
            {"events_dropped", figures.dropped},
            {"unsent", figures.counts.unsent},
            {"foreign", figures.counts.foreign},
            {"malformed", figures.counts.malformed}};
}

void print_bus(const BusFigures &f, std::size_t unanswered) {
    const auto row = [](const char *name, const std::string &value) { fmt::print("{:<34}{}\n", name, value); };
    double load[3] = {};
    getloadavg(load, 3);
    row("bus", describe(f.counts));
    row("  load average of this kernel",
        fmt::format("{:.2f} {:.2f} {:.2f} on {} CPUs", load[0], load[1], load[2], std::thread::hardware_concurrency()));
    row("  frames or messages a second", fmt::format("{:.0f}", (f.counts.sent + f.counts.received) / f.took_s));
    row("  round trip of a clock event", fmt::format("p50 {:.0f} us, p99 {:.0f} us", f.round_trip_p50_us, f.round_trip_p99_us));
    row("  clock events, deadlines missed", fmt::format("{}, {}", f.clock_events, f.missed));
    row("  edges without an answer", std::to_string(unanswered));
    row("  ecu silent, started anew", fmt::format("{}, {}", f.silences, f.restarts));
}

} // namespace sixdeg
