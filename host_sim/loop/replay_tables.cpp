// SPDX-License-Identifier: MIT
#include "loop/replay_tables.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <iterator>

namespace sixdeg {
namespace {

const char *verdict_name(float verdict) {
    static const char *const names[] = {"healthy", "partial", "misfire", "not judged"};
    return names[std::clamp(int(verdict), 0, 3)];
}

void put(fmt::memory_buffer &text, bool known, double value, int digits) {
    if (known) fmt::format_to(std::back_inserter(text), ",{:.{}f}", value, digits);
    else text.push_back(',');
}

void write(std::ostream &out, const fmt::memory_buffer &text) { out.write(text.data(), std::streamsize(text.size())); }

} // namespace

ReplayTables::ReplayTables(const ReplayStreams &streams, const ReplayEngine &engine) : to_(streams), engine_(engine) {
    to_.teeth << "edge,t_s,class,tooth,angle_deg,rpm,accel,torque_nm,health,torque_health,fourier_nm,fourier_health\n";
    to_.cycles << "cycle,t_s,cylinder,rpm,torque_nm,sd_nm,health,fourier_nm,fourier_sd_nm,fourier_health\n";
    to_.firings << "firing,t_s,cylinder,torque_nm,sd_nm,mean_nm,mean_sd_nm,health,misfire_index,misfire_limit,verdict,lambda,"
                   "lambda_health\n";
    to_.work << "work,t_s,cylinder,work_j,sd_j,change_j,health\n";
}

void ReplayTables::tooth(std::size_t index, const ToothRow &row) {
    const sd_signals_t &s = row.signals;
    const bool placed = is_placed(s), filter = placed && row.firing_health != SD_INVALID,
               fourier = placed && row.torque_health != SD_INVALID;
    fmt::memory_buffer text;
    fmt::format_to(std::back_inserter(text), "{},{:.9f},{}", index, row.t_s, class_name(s.crank_edge_class));
    put(text, placed, double(s.crank_tooth), 0);
    put(text, placed, double(s.crank_angle_deg), 3);
    put(text, placed, double(s.crank_speed_rpm), 3);
    put(text, placed, double(s.crank_acceleration_radps2), 2);
    put(text, filter, double(s.firing_waveform_nm), 3);
    fmt::format_to(std::back_inserter(text), ",{},{}", health_name(row.crank_health),
                   health_name(placed ? row.firing_health : std::uint8_t(SD_INVALID)));
    put(text, fourier, double(s.torque_mass_nm), 3);
    fmt::format_to(std::back_inserter(text), ",{}\n", health_name(row.torque_health));
    write(to_.teeth, text);
}

void ReplayTables::cycle(std::size_t index, const CycleRow &row) {
    for (const int number : engine_.firing_order) {
        const Cylinder &cylinder = cylinders_[std::size_t(number - 1)];
        const bool known = cylinder.health != SD_INVALID;
        fmt::memory_buffer text;
        fmt::format_to(std::back_inserter(text), "{},{:.9f},{},{:.3f}", index, row.t_s, number, row.signals.cycle_speed_rpm);
        put(text, known, cylinder.mean_nm, 3);
        put(text, known, cylinder.mean_sd_nm, 3);
        fmt::format_to(std::back_inserter(text), ",{},{:.3f},{:.3f},{}\n", health_name(cylinder.health),
                       row.signals.cycle_cylinder_torque_nm[number - 1], row.signals.cycle_cylinder_sd_nm[number - 1],
                       health_name(row.cylinder_health));
        write(to_.cycles, text);
    }
}

void ReplayTables::firing(std::size_t index, const FiringRow &row) {
    const sd_signals_t &s = row.signals;
    const int number = int(s.firing_cylinder);
    if (number < 1 || number > int(cylinders_.size())) return;
    cylinders_[std::size_t(number - 1)] = {double(s.firing_mean_nm), double(s.firing_mean_sd_nm), row.firing_health};
    const bool known = row.firing_health != SD_INVALID, judged = row.misfire_health != SD_INVALID && s.misfire_verdict < 2.5f;
    const double burned = double(s.afr_cylinder_burned[number - 1]);
    const bool mixture = row.afr_health != SD_INVALID && burned > 0.05;
    fmt::memory_buffer text;
    fmt::format_to(std::back_inserter(text), "{},{:.9f},{}", index, row.t_s, number);
    put(text, known, double(s.firing_torque_nm), 3);
    put(text, known, double(s.firing_sd_nm), 3);
    put(text, known, double(s.firing_mean_nm), 3);
    put(text, known, double(s.firing_mean_sd_nm), 3);
    fmt::format_to(std::back_inserter(text), ",{}", health_name(row.firing_health));
    put(text, judged, double(s.misfire_index), 4);
    put(text, judged, double(s.misfire_limit), 4);
    fmt::format_to(std::back_inserter(text), ",{}", judged ? verdict_name(s.misfire_verdict) : "not judged");
    put(text, mixture, mixture ? ((1 + engine_.stoichiometric) / burned - 1) / engine_.stoichiometric : 0, 4);
    fmt::format_to(std::back_inserter(text), ",{}", health_name(row.afr_health));
    text.push_back('\n');
    write(to_.firings, text);
}

void ReplayTables::work(std::size_t index, const WorkRow &row) {
    const sd_signals_t &s = row.signals;
    const auto firing = std::size_t(s.work_firing);
    if (firing >= engine_.firing_order.size()) return;
    const bool known = engine_.inertia_known && row.health != SD_INVALID;
    fmt::memory_buffer text;
    fmt::format_to(std::back_inserter(text), "{},{:.9f},{}", index, row.t_s, engine_.firing_order[firing]);
    put(text, known, double(s.work_cycle_j) + load_nm_ * 4 * M_PI, 3);
    put(text, known, double(s.work_sd_j), 3);
    put(text, known && s.work_cylinder > 0.5f, double(s.work_change_j), 3);
    fmt::format_to(std::back_inserter(text), ",{}\n", health_name(known ? row.health : std::uint8_t(SD_INVALID)));
    write(to_.work, text);
}

} // namespace sixdeg
