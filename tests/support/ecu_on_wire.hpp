// SPDX-License-Identifier: MIT
// An ecu of the diesel behind the in-process port.
#pragma once
#include <cstring>
#include <filesystem>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "design/calibration.hpp"
extern "C" {
#include "sd_ecu.h"
#include "sd_inproc.h"
}

namespace sixdeg::test {

inline EngineFile diesel() {
    TomlFile file(std::filesystem::path(SD_ENGINES) / "diesel_22.toml");
    EngineFile engine = read_engine(file);
    engine.tick_hz = 1e7;
    return engine;
}

/// Made once for each tune: it takes a quarter of a second.
inline const sd_calibration_t &page(const std::string &tune_text = "") {
    static std::map<std::string, sd_calibration_t> made;
    if (made.count(tune_text) == 0) {
        TomlFile tune("tune", tune_text);
        made[tune_text] = calibrate(diesel(), read_tune(tune), "tune");
    }
    return made[tune_text];
}

struct Ecu {
    StoredPage page;
    std::unique_ptr<sd_ecu_t> ecu = std::make_unique<sd_ecu_t>();
    std::unique_ptr<sd_inproc_t> wire = std::make_unique<sd_inproc_t>();
    sd_port_t ecu_side = sd_inproc_ecu_side(wire.get()), host_side = sd_inproc_host_side(wire.get());
    std::vector<sd_event_t> answers;

    explicit Ecu(const sd_calibration_t &calibration) : page(calibration) { EXPECT_EQ(SD_OK, sd_ecu_init(ecu.get(), page.view())); }

    const std::vector<sd_event_t> &send(std::uint16_t kind, std::uint32_t tick, std::uint16_t channel = 0, float value = 0) {
        sd_event_t event{tick, kind, channel, 0, 0};
        std::memcpy(&event.value, &value, sizeof value);
        return send(event);
    }

    const std::vector<sd_event_t> &send(const sd_event_t &event) {
        EXPECT_EQ(1u, host_side.send(host_side.context, &event, 1));
        sd_ecu_run(ecu.get(), page.view(), &ecu_side);
        answers.clear();
        sd_event_t answer;
        while (host_side.receive(host_side.context, &answer, 1) == 1) answers.push_back(answer);
        return answers;
    }
};

inline float value_of(const sd_event_t &event) {
    float value;
    std::memcpy(&value, &event.value, sizeof value);
    return value;
}

} // namespace sixdeg::test
