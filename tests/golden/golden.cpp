// SPDX-License-Identifier: MIT
// golden [--update | --dump NAME] FILE.run...: runs the firmware on what golden runs hold and compares a hash of each output with the
// one kept beside the run (docs/results/golden.md). Ends with 1 when one differs or is missing.
#include <cstdio>
#include <cstring>
#include <fmt/format.h>
#include <map>
#include <sstream>

#include "common/error.hpp"
#include "common/files.hpp"
#include "golden_run.hpp"
#include "loop/ecu_bench.hpp"

namespace sixdeg {
namespace {

/// FNV-1a, 64 bits, over words given byte by byte, least significant first.
class Hash {
  public:
    void add(std::uint32_t word) {
        for (int i = 0; i < 4; ++i, word >>= 8) value_ = (value_ ^ (word & 0xffu)) * 1099511628211ull;
    }
    std::uint64_t value() const { return value_; }

  private:
    std::uint64_t value_ = 14695981039346656037ull;
};

/// What was said under one name.
struct Output {
    Hash hash;
    std::size_t count = 0;
    float last = 0; ///< For the reader; of an array the last element said.
};

using Outputs = std::map<std::string, Output>;

/// One expected line.
struct Expected {
    std::string hash;
    std::size_t count;
};

std::string parameter_name(std::uint16_t index) {
    return index < SD_PARAMETER_COUNT ? sd_parameter_infos[index].name : index == SD_PARAMETER_ALL ? "all" : "unknown";
}

/// The name an event goes under, and which element of the array of that name it is, from 1; 0: none.
std::pair<std::string, std::uint32_t> name_of(const sd_event_t &event) {
    if (event.kind == SD_EVENT_PARAMETER) return {"parameter:" + parameter_name(event.channel), 0};
    if (event.kind != SD_EVENT_SIGNAL) return {"done", 0};
    const std::string name = sd_signal_infos[event.channel].name;
    const std::size_t bracket = name.find('[');
    if (bracket == std::string::npos) return {name, 0};
    return {name.substr(0, bracket), std::uint32_t(std::stoul(name.substr(bracket + 1)))};
}

/// No channel number goes in, and `why` as a number of any width: neither a new signal nor a wider `why` changes a hash.
void note(Outputs &outputs, const sd_event_t &event) {
    const auto [name, element] = name_of(event);
    Output &output = outputs[name];
    for (const std::uint32_t word : {element, event.tick, event.value, event.flags & 0xffu, event.flags >> 8}) output.hash.add(word);
    ++output.count;
    std::memcpy(&output.last, &event.value, sizeof output.last);
}

/// What was said under `dumped` is printed, to see where two builds part.
Outputs outputs_of(const GoldenRun &run, const std::string &dumped) {
    Outputs outputs;
    const auto bench = std::make_unique<EcuBench>(run.calibration);
    bench->listen([&](bool out, const sd_event_t &event) {
        if (!out) return;
        note(outputs, event);
        if (name_of(event).first != dumped) return;
        float value;
        std::memcpy(&value, &event.value, sizeof value);
        fmt::print("{} {} {:.9g} {} {:#x}\n", event.tick, name_of(event).second, value, event.flags & 0xffu, event.flags >> 8);
    });
    for (const sd_event_t &event : run.events) bench->exchange(event);
    return outputs;
}

std::string hash_text(const Output &output) { return fmt::format("{:016x}", output.hash.value()); }

std::string table(const Outputs &outputs) {
    std::string text = "# SPDX-License-Identifier: MIT\n"
                       "# name, hash, how many, last value; written by golden --update (docs/results/golden.md)\n";
    for (const auto &[name, output] : outputs)
        text += fmt::format("{:<28} {} {:>6} {:.9g}\n", name, hash_text(output), output.count, output.last);
    return text;
}

std::map<std::string, Expected> read_expected(const std::filesystem::path &file) {
    std::map<std::string, Expected> expected;
    std::istringstream text(read_file(file));
    for (std::string line; std::getline(text, line);) {
        if (line.empty() || line[0] == '#') continue;
        std::istringstream words(line);
        std::string name, hash;
        std::size_t count;
        if (!(words >> name >> hash >> count)) throw InputError(file.string(), "", "'" + line + "' is no name, hash and count");
        expected[name] = {hash, count};
    }
    return expected;
}

/// Prints what differs; returns how much does.
std::size_t compare(const std::string &run, const std::map<std::string, Expected> &expected, const Outputs &outputs) {
    std::size_t wrong = 0;
    for (const auto &[name, want] : expected) {
        const auto got = outputs.find(name);
        if (got == outputs.end()) {
            fmt::print("{}: {} is missing\n", run, name);
        } else if (hash_text(got->second) != want.hash) {
            fmt::print("{}: {} differs: {} in place of {} values, last {:.9g}\n", run, name, got->second.count, want.count,
                       got->second.last);
        } else {
            continue;
        }
        ++wrong;
    }
    for (const auto &[name, output] : outputs)
        if (expected.count(name) == 0) fmt::print("{}: {} is new: {} values, last {:.9g}\n", run, name, output.count, output.last);
    fmt::print("{}: {} outputs kept, {} changed\n", run, expected.size() - wrong, wrong);
    return wrong;
}

int golden(int count, char **arguments) {
    bool update = false;
    std::string dumped;
    std::size_t wrong = 0, runs = 0;
    for (int i = 1; i < count; ++i) {
        if (std::string(arguments[i]) == "--update") {
            update = true;
            continue;
        }
        if (std::string(arguments[i]) == "--dump" && i + 1 < count) {
            dumped = arguments[++i];
            continue;
        }
        const std::filesystem::path file = arguments[i], kept = std::filesystem::path(file).replace_extension(".expected");
        const GoldenRun run = read_golden_run(file, SD_ENGINES);
        const Outputs outputs = outputs_of(run, dumped);
        ++runs;
        if (update) write_file(kept, table(outputs)), fmt::print("{}: {} outputs written\n", run.name, outputs.size());
        else wrong += compare(run.name, read_expected(kept), outputs);
    }
    if (runs == 0) throw InputError("golden", "", "usage: golden [--update | --dump NAME] FILE.run...");
    return wrong == 0 ? 0 : 1;
}

} // namespace
} // namespace sixdeg

int main(int count, char **arguments) {
    try {
        return sixdeg::golden(count, arguments);
    } catch (const sixdeg::InputError &error) {
        fmt::print(stderr, "golden: {}\n", error.what());
        return 2;
    }
}
