// Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file.
// SPDX-License-Identifier: MIT
// Parameters that had another name before, for messages.
#pragma once

namespace sixdeg {

struct Renamed {
    const char *before, *now;
};

inline constexpr Renamed renamed_parameters[] = {
    {"crank.stall", "crank.stall_time"},
    {"torque.reject_energy", "torque.reject_energy_share"},
    {"torque.settle", "torque.settle_cycles"},
    {"torque.tooth_sd", "torque.edge_sd"},
    {"firing.pattern", "firing.pattern_sd"},
    {"firing.change", "firing.torque_change"},
    {"firing.reject", "firing.reject_lateness"},
    {"firing.settle", "firing.settle_cycles"},
    {"misfire.cyclic", "misfire.cyclic_variation"},
    {"misfire.definition", "misfire.misfire_below"},
    {"misfire.partial", "misfire.partial_burn_below"},
    {"misfire.speed_change", "misfire.shift_speed_change"},
    {"misfire.start", "misfire.start_inhibit_cycles"},
    {"misfire.hold", "misfire.resume_inhibit_cycles"},
    {"misfire.continuous", "misfire.continuous_firings"},
    {"misfire.emission", "misfire.emission_percent"},
    {"misfire.catalyst", "misfire.catalyst_percent"},
    {"afr.noise", "afr.sensor_noise"},
    {"afr.drift", "afr.cylinder_drift"},
    {"afr.jump", "afr.cylinder_jump"},
    {"afr.drift_slow", "afr.cylinder_drift_slow"},
    {"afr.slow_above", "afr.slow_mode_above"},
    {"afr.identify", "afr.delay_learning"},
    {"afr.probe", "afr.delay_probe"},
    {"afr.late_error", "afr.delay_error_sd"},
    {"afr.lag_error", "afr.lag_error_sd"},
    {"balance.gain", "balance.integral_gain"},
    {"balance.proportional", "balance.proportional_gain"},
    {"balance.rate", "balance.trim_rate"},
    {"balance.limit", "balance.trim_limit"},
    {"balance.hold", "balance.hold_cycles"},
    {"airpath.detect", "airpath.detect_threshold"},
    {"airpath.isolate", "airpath.isolate_threshold"},
    {"airpath.settle", "airpath.settle_time"},
    {"airpath.window", "airpath.offset_window"},
    {"airpath.late", "airpath.late_after"},
    {"airpath.stuck", "airpath.stuck_after"},
};

} // namespace sixdeg
