// SPDX-License-Identifier: MIT
#include "replay/replay.hpp"

#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <memory>
#include <stdexcept>

#include "common/error.hpp"
extern "C" {
#include "sd_inproc.h"
}

namespace sixdeg {
namespace {

constexpr double kTimeEventS = 0.01;

/// An ecu behind the in-process port, and the latest of what it says.
class Bench {
  public:
    explicit Bench(const sd_calibration_t &calibration) : ecu_side_(sd_inproc_ecu_side(&port_)), host_side_(sd_inproc_host_side(&port_)) {
        if (sd_ecu_init(&ecu_, &calibration) != SD_OK) throw std::logic_error("a checked calibration was refused");
    }

    /// Sends one event and takes in the answer. Returns true when it ended a cycle.
    bool exchange(std::uint16_t kind, std::uint32_t tick) {
        const sd_event_t event{tick, kind, 0, 0, 0};
        host_side_.send(host_side_.context, &event, 1);
        sd_ecu_run(&ecu_, &ecu_side_);
        bool cycle_ended = false;
        sd_event_t answer;
        while (host_side_.receive(host_side_.context, &answer, 1) == 1) cycle_ended |= take(answer);
        return cycle_ended;
    }

    const sd_signals_t &signals() const { return signals_; }
    std::uint8_t health(sd_owner_t owner) const { return health_[owner]; }
    const sd_crank_t &crank() const { return ecu_.crank; }

  private:
    bool take(const sd_event_t &event) {
        float value;
        std::memcpy(&value, &event.value, sizeof value);
        std::memcpy(reinterpret_cast<float *>(&signals_) + event.channel, &value, sizeof value);
        const sd_signal_info_t &info = sd_signal_infos[event.channel];
        health_[info.owner] = std::uint8_t(event.flags & 0xff);
        return info.rate == SD_RATE_CYCLE;
    }

    sd_inproc_t port_{};
    sd_port_t ecu_side_, host_side_;
    sd_ecu_t ecu_{};
    sd_signals_t signals_{};
    std::uint8_t health_[SD_OWNER_COUNT] = {};
};

std::uint32_t to_tick(double t_s, double tick_hz) { return std::uint32_t(std::uint64_t(std::llround(t_s * tick_hz))); }

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

const char *class_name(float edge_class) {
    static const char *const names[] = {"tooth", "coasted", "spurious", "unsynced"};
    return names[int(edge_class)];
}

const char *health_name(std::uint8_t health) {
    static const char *const names[] = {"valid", "degraded", "invalid"};
    return names[health];
}

} // namespace

ReplayResult replay(const std::string &file, const std::vector<double> &crank_s, const std::vector<double> &cam_s,
                    const sd_calibration_t &calibration) {
    const auto bench = std::make_unique<Bench>(calibration);
    const double tick_hz = double(calibration.tick_hz);
    ReplayResult result;
    result.teeth.reserve(crank_s.size());
    std::size_t cam = 0;
    double next_time_s = crank_s.empty() ? 0 : crank_s.front();
    for (const double t_s : crank_s) {
        if (!(t_s >= 0) || t_s * tick_hz > 9e15) {
            throw InputError(file, "time", fmt::format("{:g} s is outside [0, {:g}] s, what the capture timer can count", t_s, 9e15 / tick_hz));
        }
        for (; cam < cam_s.size() && cam_s[cam] < t_s; ++cam) bench->exchange(SD_EVENT_CAM_EDGE, to_tick(cam_s[cam], tick_hz));
        // A pause of hours needs no time event each 10 ms: one before the next edge tells as much.
        if (t_s - next_time_s > 10) next_time_s = t_s - 10;
        for (; next_time_s < t_s; next_time_s += kTimeEventS) bench->exchange(SD_EVENT_TIME, to_tick(next_time_s, tick_hz));
        const bool cycle_ended = bench->exchange(SD_EVENT_CRANK_EDGE, to_tick(t_s, tick_hz));
        result.teeth.push_back({t_s, bench->signals(), bench->health(SD_OWNER_CRANK), bench->health(SD_OWNER_TORQUE)});
        if (cycle_ended) result.cycles.push_back({t_s, bench->signals(), bench->health(SD_OWNER_CYLINDER)});
    }
    result.counts = bench->crank().counts;
    for (int m = 0; m < bench->crank().mark_count; ++m) {
        result.mark_spacings.push_back(double(bench->crank().mark_spacings[m]) / SD_SPACING_ONE);
    }
    count_revolutions(result);
    return result;
}

std::string teeth_csv(const ReplayResult &result) {
    std::string text = "edge,t_s,class,tooth,angle_deg,rpm,accel,torque_nm,health,torque_health\n";
    for (std::size_t i = 0; i < result.teeth.size(); ++i) {
        const ToothRow &row = result.teeth[i];
        const sd_signals_t &s = row.signals;
        const bool placed = s.crank_edge_class == SD_EDGE_TOOTH || s.crank_edge_class == SD_EDGE_COASTED;
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

std::string cycles_csv(const ReplayResult &result, const EngineFile &engine) {
    std::string text = "cycle,t_s,cylinder,rpm,torque_nm,health\n";
    for (std::size_t i = 0; i < result.cycles.size(); ++i) {
        const CycleRow &row = result.cycles[i];
        for (const int cylinder : engine.firing_order) {
            fmt::format_to(std::back_inserter(text), "{},{:.9f},{},{:.3f},{:.3f},{}\n", i, row.t_s, cylinder, row.signals.cycle_speed_rpm,
                           row.signals.cycle_cylinder_torque_nm[cylinder - 1], health_name(row.health));
        }
    }
    return text;
}

} // namespace sixdeg
