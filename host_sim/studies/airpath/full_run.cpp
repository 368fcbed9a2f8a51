// SPDX-License-Identifier: MIT
#include "studies/airpath/full_run.hpp"

#include <algorithm>

namespace sixdeg {
namespace {

constexpr double kReadS = 0.01;

} // namespace

double fuel_kgps(const PlantEngine &engine, double speed_radps, double bmep_pa) {
    const double work_j = (bmep_pa + engine.fmep_at_pa(speed_radps)) * engine.displacement_m3();
    return work_j / (engine.air_path->burn_efficiency * engine.heating_value_jpkg) * speed_radps / (4 * kPi);
}

void run_full(const PlantEngine &engine, const FullCase &c, const std::function<void(const airpath::Readings &,
    const airpath::Truth &)> &take) {
    airpath::AirPath air(*engine.air_path, engine.displacement_m3(), engine.shared.compression_ratio, c.setup, c.seed);
    const auto drive = [&](double t_s) {
        const double speed = c.speed_radps.at(t_s);
        return airpath::EngineDrive{speed, fuel_kgps(engine, speed, c.bmep_pa.at(t_s))};
    };
    air.start(drive(0));
    airpath::Readings readings;
    airpath::Truth truth;
    for (long i = 0; double(i) * kReadS < c.seconds; ++i) {
        const double t_s = double(i) * kReadS;
        air.advance(t_s, drive(t_s));
        while (air.next(1e300, readings, &truth)) take(readings, truth);
    }
}

sd_airpath_in_f32_t bank_input(const airpath::Readings &readings, const airpath::Truth &truth) {
    const auto value = [&](airpath::Channel channel) { return *readings.value[channel]; };
    sd_airpath_in_f32_t in{};
    in.speed_rpm = float(truth.speed_radps / kRadpsPerRpm);
    in.air_gps = float(1e3 * value(airpath::kAirFlow)), in.fuel_gps = float(1e3 * truth.fuel_kgps);
    in.charge_k = float(value(airpath::kChargeTemperature)), in.egr_k = float(value(airpath::kEgrTemperature));
    in.exhaust_k = float(value(airpath::kExhaustTemperature));
    in.egr_opening = float(value(airpath::kEgrPosition)), in.vgt_position = float(value(airpath::kVgtPosition));
    in.intake_kpa = float(1e-3 * value(airpath::kIntakePressure)), in.exhaust_kpa = float(1e-3 * value(airpath::kExhaustPressure));
    return in;
}

const Alarm *FullResult::first(double from_s, double to_s) const {
    const auto found = std::find_if(alarms.begin(), alarms.end(), [&](const Alarm &a) { return a.time_s >= from_s && a.time_s < to_s; });
    return found == alarms.end() ? nullptr : &*found;
}

FullResult judge_full(const PlantEngine &engine, const sd_airpath_tables_f32_t &tables, const sd_airpath_config_f32_t &config,
                      const FullCase &c) {
    sd_airpath_bank_f32_t bank;
    sd_airpath_start_f32(&bank);
    FullResult result;
    int fault = SD_AIRPATH_NO_FAULT;
    run_full(engine, c, [&](const airpath::Readings &readings, const airpath::Truth &truth) {
        const sd_airpath_in_f32_t in = bank_input(readings, truth);
        sd_airpath_out_f32_t out;
        sd_airpath_step_f32(&bank, &tables, &config, &in, &out);
        if (out.phase == SD_AIRPATH_DECIDES && result.decides_s < 0) result.decides_s = readings.time_s;
        if (int(out.fault) != fault && out.fault != SD_AIRPATH_NO_FAULT) result.alarms.push_back({readings.time_s, int(out.fault)});
        fault = int(out.fault);
    });
    result.suspect = bank.offsets.suspect != 0;
    return result;
}

} // namespace sixdeg
