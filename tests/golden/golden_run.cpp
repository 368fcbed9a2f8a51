// SPDX-License-Identifier: MIT
#include "golden_run.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <sstream>

#include "common/error.hpp"
#include "common/files.hpp"
extern "C" {
#include "sd_signals.h"
}

namespace sixdeg {
namespace {

/// Index of `name` in a generated table, or its size.
template <class Info, std::size_t N> std::size_t index_of(const Info (&infos)[N], const std::string &name) {
    return std::size_t(std::find_if(infos, infos + N, [&](const Info &info) { return name == info.name; }) - infos);
}

std::uint32_t bits(float value) {
    std::uint32_t result;
    std::memcpy(&result, &value, sizeof result);
    return result;
}

class Reader {
  public:
    Reader(const std::filesystem::path &file, const std::filesystem::path &engines) : file_(file.string()), engines_(engines) {
        std::istringstream text(read_file(file));
        run_.name = file.stem().string();
        for (std::string line; std::getline(text, line);) {
            ++line_;
            if (line.empty() || line[0] == '#') continue;
            in_events_ ? event(line) : header(line);
        }
        if (!in_events_) fail("has no events");
    }
    GoldenRun take() { return std::move(run_); }

  private:
    [[noreturn]] void fail(const std::string &problem) const { throw InputError(file_, "line " + std::to_string(line_), problem); }

    void header(const std::string &line) {
        std::istringstream words(line);
        std::string what, key, value;
        words >> what >> key >> value;
        if (what == "engine") engine_ = key;
        else if (what == "tune") tune_.push_back(key + "=" + value);
        else if (what == "input") inputs_[key[0]] = input(value);
        else if (what == "events") in_events_ = true, calibrate_run();
        else fail("'" + what + "' is none of engine, tune, input, events");
    }

    std::uint16_t input(const std::string &name) const {
        const std::size_t index = index_of(sd_input_infos, name);
        if (index == SD_INPUT_COUNT) fail("there is no input '" + name + "'");
        return std::uint16_t(index);
    }

    void calibrate_run() {
        TomlFile engine(engines_ / engine_);
        TomlFile tune("tune", "");
        for (const std::string &assignment : tune_) tune.set(assignment);
        run_.calibration = calibrate(read_engine(engine), read_tune(tune), file_);
    }

    void event(const std::string &line) {
        static const std::map<char, sd_event_kind_t> bare = {
            {'c', SD_EVENT_CRANK_EDGE}, {'k', SD_EVENT_CAM_EDGE}, {'t', SD_EVENT_TIME}, {'g', SD_EVENT_GAP}};
        if (line[0] == 'p' || line[0] == 'd' || line[0] == 'q') return parameter(line);
        char *rest = const_cast<char *>(line.c_str()) + 1;
        if (*rest != ' ') tick_ += std::uint32_t(std::strtol(rest, &rest, 10));
        const auto kind = bare.find(line[0]);
        const auto input = inputs_.find(line[0]);
        if (kind != bare.end() && *rest == 0) {
            add(kind->second, 0, 0, 0);
        } else if (input != inputs_.end() && *rest == ' ') {
            add(SD_EVENT_SAMPLE, input->second, bits(std::strtof(rest, nullptr)), 0);
        } else {
            fail("'" + line + "' is no event");
        }
    }

    void parameter(const std::string &line) {
        std::istringstream words(line);
        std::string what, name;
        float value = 0;
        words >> what >> name >> value;
        const std::size_t index = name == "all" ? SD_PARAMETER_ALL : index_of(sd_parameter_infos, name);
        if (index == SD_PARAMETER_COUNT) fail("there is no parameter '" + name + "'");
        const sd_parameter_command_t command = what == "p" ? SD_PARAMETER_SET : what == "d" ? SD_PARAMETER_RESTORE : SD_PARAMETER_READ;
        add(SD_EVENT_PARAMETER, std::uint16_t(index), bits(value), command);
    }

    void add(sd_event_kind_t kind, std::uint16_t channel, std::uint32_t value, std::uint32_t flags) {
        run_.events.push_back({tick_, std::uint16_t(kind), channel, value, flags});
    }

    std::string file_, engine_;
    std::filesystem::path engines_;
    std::vector<std::string> tune_;
    std::map<char, std::uint16_t> inputs_; ///< By the letter that the file gives them.
    GoldenRun run_{};
    std::uint32_t tick_ = 0;
    std::size_t line_ = 0;
    bool in_events_ = false;
};

} // namespace

GoldenRun read_golden_run(const std::filesystem::path &file, const std::filesystem::path &engines) {
    return Reader(file, engines).take();
}

} // namespace sixdeg
