// SPDX-License-Identifier: MIT
// budget_fixed PAGE EVENTS [OUTPUTS]: what the ecu of fixed point says on this machine to the page and the events that budget_input
// made; prints "hash HEX" as the target does, and writes the events that went out.
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "output_hash.h"
extern "C" {
#include "sd_ecu.h"
}

namespace {

struct Port {
    const sd_event_t *waiting = nullptr;
    std::uint64_t hash = SD_OUTPUT_HASH_START;
    std::vector<sd_event_t> out;
};

std::uint32_t receive(void *context, sd_event_t *events, std::uint32_t) {
    auto &port = *static_cast<Port *>(context);
    if (port.waiting == nullptr) return 0;
    *events = *port.waiting;
    port.waiting = nullptr;
    return 1;
}

std::uint32_t send(void *context, const sd_event_t *events, std::uint32_t count) {
    auto &port = *static_cast<Port *>(context);
    for (std::uint32_t i = 0; i < count; ++i) port.hash = sd_output_hash(port.hash, &events[i]);
    port.out.insert(port.out.end(), events, events + count);
    return count;
}

/// A file, aligned as a page must be.
std::vector<std::uint32_t> words_of(const char *path, std::size_t &bytes) {
    std::ifstream file(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    bytes = text.size();
    std::vector<std::uint32_t> words(bytes / 4 + 1);
    std::memcpy(words.data(), text.data(), bytes);
    return words;
}

} // namespace

int main(int count, char **arguments) {
    if (count != 3 && count != 4) return std::fprintf(stderr, "usage: budget_fixed PAGE EVENTS [OUTPUTS]\n"), 2;
    std::size_t page_bytes = 0, event_bytes = 0;
    const auto page_words = words_of(arguments[1], page_bytes), event_words = words_of(arguments[2], event_bytes);
    const sd_calibration_t *page = sd_calibration_view(page_words.data(), std::uint32_t(page_bytes));
    const auto ecu = std::make_unique<sd_ecu_t>();
    if (page == nullptr || sd_ecu_init(ecu.get(), page) != SD_OK) return std::fprintf(stderr, "budget_fixed: the page was refused\n"), 2;
    Port port;
    const sd_port_t wires{&port, receive, send};
    const auto *events = reinterpret_cast<const sd_event_t *>(event_words.data() + 4); // behind the header, whose first word counts them
    for (std::uint32_t i = 0; i < event_words[0]; ++i) {
        port.waiting = &events[i];
        sd_ecu_run(ecu.get(), page, &wires);
    }
    std::printf("hash %llx\n", static_cast<unsigned long long>(port.hash));
    if (count < 4) return 0;
    std::ofstream out(arguments[3], std::ios::binary);
    out.write(reinterpret_cast<const char *>(port.out.data()), std::streamsize(port.out.size() * sizeof(sd_event_t)));
    return 0;
}
