// SPDX-License-Identifier: MIT
#include "io/bus/live_view.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace sixdeg {
namespace {

constexpr int kTorqueColumns = 24, kIndexColumns = 16;
constexpr float kFullIndex = 1.6f; ///< At the end of its bar; a healthy firing scatters about 1.
constexpr const char *kVerdicts[] = {"healthy", "partial burn", "MISFIRE", "not judged"};
constexpr const char *kLamps[] = {"off", "pending", "on", "blinking"};

/// `columns` wide, filled up to `value` of `full`, with a stroke where `mark` lies.
std::string bar(float value, float mark, float full, int columns) {
    const auto column = [&](float x) { return full > 0 ? int(float(columns) * std::clamp(x / full, 0.0f, 1.0f)) : 0; };
    std::string text = std::string(std::size_t(column(value)), '#');
    text.resize(std::size_t(columns), ' ');
    text[std::size_t(std::min(column(mark), columns - 1))] = '|';
    return text;
}

/// Numbers of the bits that are set, or "none".
std::string cylinders(float bits) {
    std::string list;
    for (int i = 0; i < 8; ++i) {
        if ((int(bits) >> i & 1) != 0) list += fmt::format("{}{}", list.empty() ? "" : " ", i + 1);
    }
    return list.empty() ? "none" : list;
}

template <std::size_t N> const char *name_of(const char *const (&names)[N], float value) {
    return names[std::size_t(std::clamp(int(value), 0, int(N) - 1))];
}

} // namespace

void LiveView::take(const sd_event_t &event) {
    cycles_ += said_.take(event);
    if (event.kind != SD_EVENT_SIGNAL) return;
    const sd_signals_t &s = said_.signals();
    // The last of its row: the others are of the same firing now.
    if (event.channel == SD_SIGNAL_MISFIRE_CYLINDER && said_.health(SD_OWNER_FIRING) != SD_INVALID)
        firings_[int(s.misfire_cylinder)] = {int(s.misfire_verdict), s.misfire_index, s.misfire_limit};
}

std::string LiveView::cylinder(int number, float mean_nm, float largest_nm) const {
    const sd_signals_t &s = said_.signals();
    const std::size_t i = std::size_t(number - 1);
    std::string text = fmt::format("{:<9}", number);
    const float torque = s.cycle_cylinder_torque_nm[i];
    if (said_.health(SD_OWNER_CYLINDER) == SD_INVALID)
        text += fmt::format("{:>10} {:>8} {:<{}}", "-", "-", "", kTorqueColumns);
    else
        text += fmt::format("{:10.1f} {:+7.1f}% {}", torque, mean_nm > 0 ? 100 * (torque / mean_nm - 1) : 0,
                            bar(torque, mean_nm, largest_nm, kTorqueColumns));
    const auto firing = firings_.find(number);
    if (firing == firings_.end() || firing->second.verdict == 3)
        text += fmt::format(" {:<12} {:>6} {:<{}}", firing == firings_.end() ? "-" : kVerdicts[3], "-", "", kIndexColumns);
    else
        text += fmt::format(" {:<12} {:6.2f} {}", name_of(kVerdicts, float(firing->second.verdict)), firing->second.index,
                            bar(firing->second.index, firing->second.limit, kFullIndex, kIndexColumns));
    text += fmt::format(" {:5.1f} {:5.1f}", s.misfire_rate_200_percent[i], s.misfire_rate_1000_percent[i]);
    text += said_.health(SD_OWNER_AFR) == SD_INVALID ? fmt::format(" {:>7}", "-") : fmt::format(" {:7.3f}", s.afr_cylinder_burned[i]);
    return text + fmt::format(" {:+6.1f}%\n", 100 * s.balance_trim[i]);
}

std::string LiveView::text(bool silent) const {
    const sd_signals_t &s = said_.signals();
    const auto health = [&](sd_owner_t owner) { return health_name(said_.health(owner)); };
    std::string text = fmt::format("{}\n{:8.1f} rpm {:7.1f} deg  tooth {:3.0f}  torque {:8.1f} Nm  {} cycles\n",
                                   silent ? "THE ECU IS SILENT" : "", s.crank_speed_rpm, s.crank_angle_deg, s.crank_tooth,
                                   s.torque_mass_nm, cycles_);
    text += fmt::format("angle {}, torque {}, cylinders {}, firings {}, misfire {}, mixture {}, trims {}\n", health(SD_OWNER_CRANK),
                        health(SD_OWNER_TORQUE), health(SD_OWNER_CYLINDER), health(SD_OWNER_FIRING), health(SD_OWNER_MISFIRE),
                        health(SD_OWNER_AFR), health(SD_OWNER_BALANCE));
    text += fmt::format("lamp {}, misfires {:.0f}, partial burns {:.0f}, continuous: {}, suspects: {}\n\n", name_of(kLamps, s.misfire_lamp),
                        s.misfire_count, s.misfire_partial_burns, cylinders(s.misfire_continuous), cylinders(s.misfire_suspects));
    int count = firings_.empty() ? 0 : firings_.rbegin()->first;
    float sum = 0, largest = 0;
    for (int i = 0; i < int(std::size(s.cycle_cylinder_torque_nm)); ++i) {
        const float torque = s.cycle_cylinder_torque_nm[i];
        if (torque != 0) count = std::max(count, i + 1);
        sum += torque;
        largest = std::max(largest, torque);
    }
    text += fmt::format("{:<9}{:>10} {:>8} {:<{}} {:<12} {:>6} {:<{}} {:>5} {:>5} {:>7} {:>7}\n", "cylinder", "Nm", "of mean", "| mean",
                        kTorqueColumns, "last firing", "index", "| limit", kIndexColumns, "%/200", "/1000", "burned", "trim");
    for (int number = 1; number <= count; ++number) text += cylinder(number, sum / float(count), largest);
    return text;
}

} // namespace sixdeg
