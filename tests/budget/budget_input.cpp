// SPDX-License-Identifier: MIT
// budget_input [--twice] RUN.run PAGE EVENTS [OUTPUTS]: the calibration page and the events of a golden run as budget_ecu takes them;
// prints "page_bytes HEX" and "hash HEX", which is of what the ecu says to them on this machine. Parameters stay as the page has
// them, so that a mean is of one configuration. --twice: the run, 2 s without an edge, and the run again. OUTPUTS: the events that go out,
// one behind the other.
#include <algorithm>
#include <cstdio>
#include <fmt/format.h>
#include <memory>
#include <string>

#include "common/error.hpp"
#include "common/files.hpp"
#include "golden_run.hpp"
#include "output_hash.h"
#include "loop/ecu_bench.hpp"

namespace sixdeg {
namespace {

struct Header {
    std::uint32_t event_count, page_bytes, unused[2];
};

std::uint64_t hash_of(const GoldenRun &run, std::vector<sd_event_t> &said) {
    std::uint64_t hash = SD_OUTPUT_HASH_START;
    const auto bench = std::make_unique<EcuBench>(run.calibration);
    bench->listen([&](bool out, const sd_event_t &event) {
        if (out) hash = sd_output_hash(hash, &event), said.push_back(event);
    });
    for (const sd_event_t &event : run.events) bench->exchange(event);
    return hash;
}

template <class T> std::string bytes_of(const T *first, std::size_t count) {
    return std::string(reinterpret_cast<const char *>(first), count * sizeof(T));
}

/// Behind the events the same again, after a pause in which the engine stands.
void repeat(GoldenRun &run) {
    const std::size_t count = run.events.size();
    const auto later = run.events[count - 1].tick - run.events[0].tick + std::uint32_t(2.0 * double(run.calibration.tick_hz));
    for (std::size_t i = 0; i < count; ++i) run.events.push_back(run.events[i]), run.events.back().tick += later;
}

} // namespace
} // namespace sixdeg

int main(int count, char **arguments) {
    using namespace sixdeg;
    try {
        const bool twice = count > 1 && std::string(arguments[1]) == "--twice";
        if (twice) --count, ++arguments;
        if (count != 4 && count != 5) throw InputError("budget_input", "", "usage: budget_input [--twice] RUN.run PAGE EVENTS [OUTPUTS]");
        GoldenRun run = read_golden_run(arguments[1], SD_ENGINES);
        const auto is_command = [](const sd_event_t &event) { return event.kind == SD_EVENT_PARAMETER; };
        run.events.erase(std::remove_if(run.events.begin(), run.events.end(), is_command), run.events.end());
        if (twice) repeat(run);
        const auto page = page_bytes(run.calibration);
        const Header header{std::uint32_t(run.events.size()), std::uint32_t(page.size()), {}};
        write_file(arguments[2], bytes_of(page.data(), page.size()));
        write_file(arguments[3], bytes_of(&header, 1) + bytes_of(run.events.data(), run.events.size()));
        std::vector<sd_event_t> said;
        fmt::print("page_bytes {:x}\nhash {:x}\n", page.size(), hash_of(run, said));
        if (count == 5) write_file(arguments[4], bytes_of(said.data(), said.size()));
        return 0;
    } catch (const InputError &error) {
        fmt::print(stderr, "budget_input: {}\n", error.what());
        return 2;
    }
}
