// SPDX-License-Identifier: MIT
#include "loop/air_path_feed.hpp"

namespace sixdeg {
namespace {

struct Input {
    sd_input_t input;
    double unit; ///< The table's over the SI unit.
};

constexpr std::array<Input, airpath::kChannels> kInputs{{{SD_INPUT_AIR_FLOW, 1e-3},
                                                         {SD_INPUT_AIR_INTAKE_PRESSURE, 1e5},
                                                         {SD_INPUT_EXHAUST_PRESSURE, 1e5},
                                                         {SD_INPUT_AIR_CHARGE_TEMPERATURE, 1},
                                                         {SD_INPUT_EGR_TEMPERATURE, 1},
                                                         {SD_INPUT_EXHAUST_TEMPERATURE, 1},
                                                         {SD_INPUT_EGR_POSITION, 1},
                                                         {SD_INPUT_VGT_POSITION, 1},
                                                         {SD_INPUT_EGR_COMMAND, 1},
                                                         {SD_INPUT_VGT_COMMAND, 1}}};

} // namespace

void send_readings(EcuFeed &ecu, const airpath::Readings &readings) {
    for (std::size_t i = 0; i < kInputs.size(); ++i)
        if (readings.value[i]) ecu.sample(kInputs[i].input, *readings.value[i] / kInputs[i].unit, readings.time_s);
}

} // namespace sixdeg
