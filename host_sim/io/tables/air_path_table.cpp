// SPDX-License-Identifier: MIT
#include "io/tables/air_path_table.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "io/tables/fixed_text.hpp"

namespace sixdeg {

AirPathTable::AirPathTable() {
    for (std::uint16_t channel = 0; channel < SD_SIGNAL_COUNT; ++channel)
        if (std::string(sd_owner_infos[sd_signal_infos[channel].owner].name) == "airpath") signals_.push_back(channel);
}

void AirPathTable::row(const airpath::Readings &readings, const airpath::Truth &truth) {
    std::vector<float> said = rows_.empty() ? std::vector<float>(signals_.size(), std::numeric_limits<float>::quiet_NaN())
        : rows_.back().said;
    rows_.push_back({readings, truth, std::move(said)});
}

void AirPathTable::said(const sd_event_t &event) {
    if (event.kind != SD_EVENT_SIGNAL || rows_.empty()) return;
    const auto found = std::find(signals_.begin(), signals_.end(), event.channel);
    if (found != signals_.end()) std::memcpy(&rows_.back().said[std::size_t(found - signals_.begin())], &event.value, sizeof(float));
}

std::string AirPathTable::csv() const {
    using namespace airpath;
    std::string text = "t_s,rpm,fuel_gps,egr_command,vgt_command,egr_read,vgt_read,egr_true,vgt_true,air_gps,air_true_gps,egr_true_gps,"
                       "turbine_true_gps,cylinder_true_gps,intake_kpa,intake_true_kpa,exhaust_kpa,exhaust_true_kpa,"
                       "charge_k,egr_k,exhaust_k";
    for (std::uint16_t channel : signals_) text += std::string(",") + sd_signal_infos[channel].name;
    text += '\n';
    for (const Row &row : rows_) {
        const Flows &f = row.truth.flows;
        const auto add = [&text](double value, int decimals) { text += ',', append_fixed(text, value, decimals); };
        const auto read = [&](Channel channel, double unit, int decimals) {
            text += ',';
            if (const auto &value = row.readings.value[channel]) append_fixed(text, *value / unit, decimals);
        };
        append_fixed(text, row.truth.time_s, 3);
        add(row.truth.speed_radps * 30 / M_PI, 1), add(1e3 * row.truth.fuel_kgps, 4);
        read(kEgrCommand, 1, 4), read(kVgtCommand, 1, 4), read(kEgrPosition, 1, 4), read(kVgtPosition, 1, 4);
        add(row.truth.egr, 4), add(row.truth.vgt, 4);
        read(kAirFlow, 1e-3, 3), add(1e3 * f.compressor_kgps, 3), add(1e3 * f.egr_kgps, 3), add(1e3 * f.turbine_kgps, 3), add(1e3 *
            f.cylinder_kgps, 3);
        read(kIntakePressure, 1e3, 3), add(1e-3 * f.intake_pa, 3), read(kExhaustPressure, 1e3, 3), add(1e-3 * f.exhaust_pa, 3);
        read(kChargeTemperature, 1, 2), read(kEgrTemperature, 1, 2), read(kExhaustTemperature, 1, 2);
        for (float value : row.said) {
            text += ',';
            if (std::isfinite(value)) append_fixed(text, double(value), 5);
        }
        text += '\n';
    }
    return text;
}

} // namespace sixdeg
