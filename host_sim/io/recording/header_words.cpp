// SPDX-License-Identifier: MIT
#include "io/recording/header_words.hpp"

#include <algorithm>

#include "io/recording/text_fields.hpp"

namespace sixdeg {
namespace {

template <std::size_t count> bool is_one_of(const std::string &word, const char *const (&words)[count]) {
    return std::find(std::begin(words), std::end(words), word) != std::end(words);
}

} // namespace

std::string lower(std::string_view text) {
    std::string out;
    for (char c : text) out += c >= 'A' && c <= 'Z' ? char(c + 'a' - 'A') : c;
    return out;
}

bool is_time_name(const std::string &name) {
    const std::string text = lower(name);
    const auto end = text.find_first_of("[(");
    static const char *const words[] = {"time", "t", "zeit", "timestamp", "time_s", "t_s", "time_ms", "time_us", "x", "second", "seconds",
                                        "sec", "time stamp", "timestamps", "elapsed", "elapsed time", "temps", "tiempo", "tempo", "time s"};
    return is_one_of(std::string(trimmed(std::string_view(text).substr(0, end))), words);
}

bool is_interval_name(const std::string &name) {
    const std::string text = lower(name);
    if (text.substr(0, 2) == "dt" && (text.size() == 2 || text[2] < 'a' || text[2] > 'z')) return true;
    for (const char *word : {"toothtime", "tooth time", "tooth_time", "interval", "period", "delta", "gap time"})
        if (text.find(word) != std::string::npos) return true;
    return false;
}

bool is_count_name(const std::string &name) {
    static const char *const words[] = {"tick", "ticks", "sample", "samples", "index", "count", "row", "n"};
    return is_one_of(lower(name), words);
}

bool looks_like_units(const std::vector<std::string> &cells) {
    static const char *const units[] = {"s",      "ms",      "us",  "ns",  "v",   "mv", "volt", "volts", "flag",
                                        "second", "seconds", "rpm", "deg", "bar", "a",  "sec",  "bits",  "hex"};
    for (const std::string &cell : cells) {
        std::string bare = lower(cell);
        bare.erase(std::remove_if(bare.begin(), bare.end(),
                                  [](char c) { return std::string_view("[](){} ").find(c) != std::string_view::npos; }),
                   bare.end());
        if (is_one_of(bare, units)) return true;
    }
    return false;
}

double time_unit_of(std::string_view text) {
    const std::string name = lower(text);
    std::string word;
    double found = 0;
    for (std::size_t i = 0; i <= name.size(); ++i) {
        const char c = i < name.size() ? name[i] : ' ';
        const bool letter = (c >= 'a' && c <= 'z') || (static_cast<unsigned char>(c) & 0x80) != 0;
        if (letter) {
            word += c;
            continue;
        }
        if (word == "s" || word == "sec" || word == "secs" || word == "second" || word == "seconds") found = 1;
        if (word == "ms" || word == "msec" || word == "millisecond" || word == "milliseconds" || word == "millis") found = 1e-3;
        if (word == "us" || word == "usec" || word == "microsecond" || word == "microseconds" || word == "micros" || word == "\xC2\xB5s" ||
            word == "\xCE\xBCs" || word == "\xB5s")
            found = 1e-6;
        if (word == "ns" || word == "nsec" || word == "nanosecond" || word == "nanoseconds") found = 1e-9;
        word.clear();
    }
    return found;
}

} // namespace sixdeg
