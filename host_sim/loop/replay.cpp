// SPDX-License-Identifier: MIT
#include "loop/replay.hpp"

#include <fmt/format.h>
#include <memory>

#include "common/error.hpp"

namespace sixdeg {
namespace {

/// Whole revolutions, from tooth 0 to tooth 0 without losing sync between.
void count_revolutions(ReplayResult &result) {
    std::optional<double> last_zero_s;
    for (std::size_t i = 0; i < result.teeth.size(); ++i) {
        const ToothRow &row = result.teeth[i];
        const int edge_class = int(row.signals.crank_edge_class);
        if (edge_class == SD_EDGE_UNSYNCED) last_zero_s.reset();
        if (edge_class == SD_EDGE_UNSYNCED || edge_class == SD_EDGE_SPURIOUS) continue;
        if (!result.first_sync_edge) result.first_sync_edge = i;
        if (row.signals.crank_tooth != 0) continue;
        if (last_zero_s) {
            ++result.revolutions;
            result.rpm_last = 60 / (row.t_s - *last_zero_s);
        }
        last_zero_s = row.t_s;
    }
}

} // namespace

void ReplayRows::edge(double t_s, bool cycle_ended, const EcuBench &bench) {
    result_.teeth.push_back({t_s, bench.signals(), bench.health(SD_OWNER_CRANK), bench.health(SD_OWNER_TORQUE)});
    if (cycle_ended) result_.cycles.push_back({t_s, bench.signals(), bench.health(SD_OWNER_CYLINDER)});
}

ReplayResult ReplayRows::finish(const EcuBench &bench) {
    result_.counts = bench.crank().counts;
    for (int m = 0; m < bench.crank().mark_count; ++m)
        result_.mark_spacings.push_back(double(bench.crank().mark_spacings[m]) / SD_SPACING_ONE);
    count_revolutions(result_);
    return std::move(result_);
}

ReplayResult replay(const std::string &file, const std::vector<double> &crank_s, const std::vector<double> &cam_s,
                    const sd_calibration_t &calibration) {
    const auto bench = std::make_unique<EcuBench>(calibration);
    const double tick_hz = double(calibration.tick_hz);
    ReplayRows rows;
    rows.reserve(crank_s.size());
    std::size_t cam = 0;
    for (const double t_s : crank_s) {
        if (!(t_s >= 0) || t_s * tick_hz > 9e15) {
            throw InputError(file, "time", fmt::format("{:g} s is outside [0, {:g}] s, what the capture timer can count", t_s, 9e15 / tick_hz));
        }
        for (; cam < cam_s.size() && cam_s[cam] < t_s; ++cam) bench->exchange(SD_EVENT_CAM_EDGE, bench->tick_at(cam_s[cam]));
        bench->tell_time_until(t_s);
        rows.edge(t_s, bench->exchange(SD_EVENT_CRANK_EDGE, bench->tick_at(t_s)), *bench);
    }
    return rows.finish(*bench);
}

std::string teeth_csv(const ReplayResult &result) {
    std::string text = "edge,t_s,class,tooth,angle_deg,rpm,accel,torque_nm,health,torque_health\n";
    for (std::size_t i = 0; i < result.teeth.size(); ++i) {
        const ToothRow &row = result.teeth[i];
        const sd_signals_t &s = row.signals;
        const bool placed = is_placed(s);
        fmt::format_to(std::back_inserter(text), "{},{:.9f},{},", i, row.t_s, class_name(s.crank_edge_class));
        if (placed) {
            fmt::format_to(std::back_inserter(text), "{:.0f},{:.3f},{:.3f},{:.2f},", s.crank_tooth, s.crank_angle_deg,
                           s.crank_speed_rpm, s.crank_acceleration_radps2);
        } else {
            text += ",,,,";
        }
        if (placed && row.torque_health != SD_INVALID) text += fmt::format("{:.3f}", s.torque_mass_nm);
        fmt::format_to(std::back_inserter(text), ",{},{}\n", health_name(row.crank_health), health_name(row.torque_health));
    }
    return text;
}

std::string cycles_csv(const ReplayResult &result, const std::vector<int> &firing_order) {
    std::string text = "cycle,t_s,cylinder,rpm,torque_nm,health\n";
    for (std::size_t i = 0; i < result.cycles.size(); ++i) {
        const CycleRow &row = result.cycles[i];
        for (const int cylinder : firing_order) {
            fmt::format_to(std::back_inserter(text), "{},{:.9f},{},{:.3f},{:.3f},{}\n", i, row.t_s, cylinder, row.signals.cycle_speed_rpm,
                           row.signals.cycle_cylinder_torque_nm[cylinder - 1], health_name(row.health));
        }
    }
    return text;
}

} // namespace sixdeg
