/* Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. */
/* SPDX-License-Identifier: MIT */
#include "sd_signals.h"

const sd_signal_info_t sd_signal_infos[SD_SIGNAL_COUNT] = {
    { "crank.edge_class", "", 0.0f, 3.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_CRANK },
    { "crank.tooth", "", 0.0f, 119.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_CRANK },
    { "crank.angle", "deg", 0.0f, 720.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_CRANK },
    { "crank.phase_known", "", 0.0f, 1.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_CRANK },
    { "crank.speed", "rpm", 0.0f, 20000.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_CRANK },
    { "crank.acceleration", "rad/s2", -1000000.0f, 1000000.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_CRANK },
    { "torque.mass", "Nm", -20000.0f, 20000.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "torque.innovation", "J", -1000000.0f, 1000000.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "cycle.speed", "rpm", 0.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CRANK },
    { "cycle.cylinder_torque[1]", "Nm", -20000.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_torque[2]", "Nm", -20000.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_torque[3]", "Nm", -20000.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_torque[4]", "Nm", -20000.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_torque[5]", "Nm", -20000.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_torque[6]", "Nm", -20000.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_torque[7]", "Nm", -20000.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_torque[8]", "Nm", -20000.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_sd[1]", "Nm", 0.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_sd[2]", "Nm", 0.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_sd[3]", "Nm", 0.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_sd[4]", "Nm", 0.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_sd[5]", "Nm", 0.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_sd[6]", "Nm", 0.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_sd[7]", "Nm", 0.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
    { "cycle.cylinder_sd[8]", "Nm", 0.0f, 20000.0f, 0.0f, SD_RATE_CYCLE, SD_OWNER_CYLINDER },
};

const sd_signal_info_t sd_input_infos[SD_INPUT_COUNT] = {
    { "air.intake_pressure", "bar", 0.05f, 6.0f, 0.0f, 0, 0 },
    { "fuel.injected", "mg", 0.0f, 1000.0f, 0.0f, 0, 0 },
    { "exhaust.lambda", "", 0.5f, 20.0f, 0.0f, 0, 0 },
    { "exhaust.pressure", "bar", 0.05f, 10.0f, 0.0f, 0, 0 },
};

const sd_signal_info_t sd_parameter_infos[SD_PARAMETER_COUNT] = {
    { "crank.stall", "s", 0.005f, 10.0f, 0.5f, SD_RATE_EDGE, SD_OWNER_CRANK },
    { "torque.harmonics", "", 0.0f, 12.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "torque.gain_energy", "1/rad", 0.01f, 38.0f, 1.0f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "torque.gain_mean", "1/rad2", 0.0001f, 100.0f, 0.3f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "torque.gain_reference", "1/rad2", 1e-05f, 100.0f, 0.05f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "torque.reject_energy", "", 0.01f, 1.0f, 0.5f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "torque.settle", "cycles", 1.0f, 200.0f, 8.0f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "torque.tooth_sd", "deg", 0.0f, 1.0f, 0.01f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "torque.speed_base", "rpm", 500.0f, 19000.0f, 8000.0f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "torque.torque_base", "Nm", 0.0f, 20000.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_TORQUE },
    { "torque.fixed_point", "", 0.0f, 1.0f, 0.0f, SD_RATE_EDGE, SD_OWNER_TORQUE },
};
