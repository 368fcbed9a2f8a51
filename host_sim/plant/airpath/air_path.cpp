// SPDX-License-Identifier: MIT
#include "plant/airpath/air_path.hpp"

#include <cmath>

#include "common/streams.hpp"

namespace sixdeg::airpath {
namespace {

constexpr double kStepS = 1e-3, kOutOfRange = 1e9;
constexpr std::int64_t kStepsARead = 10;

/// Noise of a reading: of its value, and beside it.
struct Noise {
    double share, size;
};
constexpr std::array<Noise, kChannels> kNoise{
    {{0.01, 0}, {0, 1000}, {0, 2000}, {0, 0.3}, {0, 0.5}, {0, 1}, {0, 0.002}, {0, 0.002}, {0, 0}, {0, 0}}};

double lag_of(const Setup &setup, int channel) {
    switch (channel) {
    case kAirFlow: return setup.flow_lag_s;
    case kIntakePressure:
    case kExhaustPressure: return setup.pressure_lag_s;
    case kChargeTemperature:
    case kEgrTemperature:
    case kExhaustTemperature: return setup.temperature_lag_s;
    default: return 0; // a potentiometer, or the controller's own word
    }
}

} // namespace

AirPath::AirPath(const FullData &data, double displacement_m3, double compression_ratio, const Setup &setup, std::uint64_t seed)
    : setup_(setup), model_(setup.errors.applied(data), displacement_m3, compression_ratio), egr_(data.egr, kEgrActuator),
      vgt_(data.vgt, kVgtActuator), random_(seed, stream::kAirPath) {
    for (int channel = 0; channel < kChannels; ++channel) {
        const double lag_s = lag_of(setup, channel);
        share_[std::size_t(channel)] = lag_s > 0 ? 1 - std::exp(-kStepS / lag_s) : 1;
    }
}

void AirPath::start(const EngineDrive &engine) {
    egr_.start(setup_.egr.at(0));
    vgt_.start(setup_.vgt.at(0));
    model_.start({engine.speed_radps, engine.fuel_kgps, egr_.position(), vgt_.position(), 0});
    seen_ = seen_now();
    steps_ = 0;
    samples_.clear();
    read(0, engine);
}

std::array<double, kChannels> AirPath::seen_now() const {
    const Flows &f = model_.flows();
    const double t_s = double(steps_) * kStepS;
    const Errors &e = setup_.errors;
    return {f.compressor_kgps * e.air_flow, f.intake_pa * e.intake_pressure, f.exhaust_pa * e.exhaust_pressure, f.charge_k,
            model_.state().egr_k, f.exhaust_k, egr_.reading(), vgt_.reading(), setup_.egr.at(t_s), setup_.vgt.at(t_s)};
}

void AirPath::advance(double time_s, const EngineDrive &engine) {
    while (double(steps_ + 1) * kStepS <= time_s + 1e-9) {
        const double t_s = double(++steps_) * kStepS;
        egr_.step(t_s, kStepS, setup_.egr.at(t_s), setup_.faults);
        vgt_.step(t_s, kStepS, setup_.vgt.at(t_s), setup_.faults);
        model_.step({engine.speed_radps, engine.fuel_kgps, egr_.position(), vgt_.position(), offset_at(setup_.faults, kIntakeLeak, t_s)},
            kStepS);
        const auto now = seen_now();
        for (std::size_t i = 0; i < now.size(); ++i) seen_[i] += (now[i] - seen_[i]) * share_[i];
        if (steps_ % kStepsARead == 0) read(t_s, engine);
    }
}

void AirPath::read(double time_s, const EngineDrive &engine) {
    Sample s;
    s.readings.time_s = time_s;
    for (int channel = 0; channel < kChannels; ++channel) {
        const auto i = std::size_t(channel);
        // Drawn always, so that a fault of one sensor changes no other's noise.
        const double noise = setup_.noise * (kNoise[i].share * seen_[i] + kNoise[i].size) * random_.normal();
        const int place = kFirstSensor + channel;
        const auto has = [&](FaultKind kind) { return find_fault(setup_.faults, place, kind, time_s) != nullptr; };
        if (!has(FaultKind::stuck)) last_[i] = seen_[i] + noise + offset_at(setup_.faults, place, time_s);
        s.readings.value[i] = has(FaultKind::out_of_range) ? kOutOfRange : last_[i];
        if (has(FaultKind::silent)) s.readings.value[i].reset();
    }
    s.truth = {time_s, engine.speed_radps, engine.fuel_kgps, egr_.position(), vgt_.position(), model_.flows(), model_.state().egr_k,
               model_.state().turbo_radps};
    samples_.push_back(std::move(s));
}

bool AirPath::next(double time_s, Readings &readings, Truth *truth) {
    if (samples_.empty() || samples_.front().readings.time_s >= time_s) return false;
    readings = samples_.front().readings;
    if (truth) *truth = samples_.front().truth;
    samples_.pop_front();
    return true;
}

} // namespace sixdeg::airpath
