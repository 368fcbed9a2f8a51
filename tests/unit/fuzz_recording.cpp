// SPDX-License-Identifier: MIT
// Readers of foreign bytes against damaged and made-up texts: whatever comes, they read it or refuse it in one line.
//   fuzz_recording SECONDS [SEED]        for so long
//   fuzz_recording --count N [SEED]      so many executions
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <random>
#include <string>
#include <vector>

#include "common/error.hpp"
#include "io/recording/guess.hpp"

namespace {

using Random = std::mt19937_64;

// Pieces of every form that docs/start/recordings.md lists.
const char *const kSeeds[] = {
    "0,1\n0.5,0\n0.75,1\n", "Time [s];Channel 0\n-0,0010000;1\n0,0000000;0\n0,0003333;1\n", "-0,0010000,1\n0,0000000,0\n0,0003333,1\n",
    "\"Time\",\"crank\"\n\"-0.001\",\"1\"\n\"0.0\",\"0\"\n", "Time [s],Channel 0,Channel 1\n-0.001,1,X\n0,0,X\n0.1,1,X\n",
    "Source,CH1\nSecond,Volt\n-0.401,5.00\n-0.4,0.00\n", "#Firmware: x\n\"PriLevel\",\"Time\"\n\"Flag\",\"ms\"\n0,0.000\n1,0.333\n",
    "1 0.001\n2 0.002\n3 0.0035\n1 0.005\n", "\xEF\xBB\xBFt,level\r\n0,1\r\n0.5,0\r\n",
        "ToothTime\n333\n334\n1000\n333\n332\n331\n900\n334\n",
    "X,CH1,Start,Increment\nSequence,Volt,-0.6,1e-6\n0,0.1,\n1,0.2,\n", "12:30:05.25 1\n12:30:05.50 0\n",
        "2024-03-12T10:11:05.25Z,1\n2024-03-12T10:11:05.50Z,0\n",
    "12.03.2024 10:11:05,25;H\n12.03.2024 10:11:05,50;L\n", "tooth,dt_us\n0,333\n1,334\n2,1000\n0,332\n1,331\n", "t,v\r0,1\r0.5,0\r",
    "Record Length,2500,,-0.001,0.02\n,,,0.000,0.04\n,,,0.001,0.02\n"};
const char kAlphabet[] = "0123456789.,;\t \n\r\"-+eExXnaNifs#:|\xEF\xBB\xBF\xFF\xFE\0";

std::string damaged(Random &random) {
    std::string text = kSeeds[random() % std::size(kSeeds)];
    if (random() % 3 == 0) text += kSeeds[random() % std::size(kSeeds)];
    for (unsigned i = unsigned(random() % 6); i > 0 && !text.empty(); --i) {
        const std::size_t at = random() % text.size();
        switch (random() % 4) {
        case 0: text[at] = kAlphabet[random() % sizeof kAlphabet]; break;
        case 1: text.insert(at, 1, kAlphabet[random() % sizeof kAlphabet]); break;
        case 2: text.erase(at, 1 + random() % 4); break;
        default: text.insert(at, text.substr(random() % text.size(), random() % 20)); break;
        }
    }
    return text;
}

/// A train of edges with gaps here and there, some of it a wheel.
std::string train(Random &random) {
    std::string text;
    const int teeth = 9 + int(random() % 30), edges = 40 + int(random() % 130);
    const bool single = random() % 3 == 0; // an even wheel, and one tooth in a column of its own
    double time = 0;
    char line[64];
    for (int i = 0; i < edges; ++i) {
        if (single) {
            std::snprintf(line, sizeof line, "%.4f,%d,0\n%.4f,%d,%d\n", i + 1e-3 * double(random() % 100), i % 2, i + 0.5, i % 2,
                          i % 48 == 5);
            text += line;
            continue;
        }
        time += i % teeth == 0 ? 2.0 + double(random() % 3) : double(random() % 9 == 0 ? random() % 4 : 1) + 1e-3 * double(random() % 100);
        std::snprintf(line, sizeof line, "%.4f,%d\n", time, i % 2);
        text += line;
    }
    return text;
}

/// One execution. Aborts where something is neither read nor refused as it should be.
void execute(const std::string &text) {
    try {
        const sixdeg::Recording recording = sixdeg::parse_recording("fuzz", text);
        for (std::size_t i = 1; i < recording.rows(); ++i)
            if (!(recording.time[i] >= recording.time[i - 1])) std::abort();
        for (const auto &column : recording.columns)
            for (double value : column)
                if (!std::isfinite(value)) std::abort();
        const sixdeg::Guess found = sixdeg::guess(recording);
        if (found.wheel.positions < 12 || found.wheel.positions > 120 || found.wheel.missing.empty()) std::abort();
    } catch (const sixdeg::InputError &error) {
        if (std::strchr(error.what(), '\n') || std::strncmp(error.what(), "fuzz", 4) != 0) std::abort();
    }
}

} // namespace

int main(int argc, char **argv) {
    const bool counted = argc > 2 && std::strcmp(argv[1], "--count") == 0;
    const double seconds = counted ? 1e9 : argc > 1 ? std::atof(argv[1]) : 5;
    const long most = counted ? std::atol(argv[2]) : 1000000000L;
    const char *const seed = argc > (counted ? 3 : 2) ? argv[counted ? 3 : 2] : "1";
    Random random(std::strtoull(seed, nullptr, 10));
    const auto start = std::chrono::steady_clock::now();
    long executions = 0;
    for (; executions < most; ++executions) {
        if (executions % 64 == 0 && std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() > seconds) break;
        execute(random() % 8 == 0 ? train(random) : damaged(random));
    }
    std::printf("%ld executions, none did harm\n", executions);
}
