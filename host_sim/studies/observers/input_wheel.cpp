// SPDX-License-Identifier: MIT
#include "studies/observers/input_wheel.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

extern "C" {
#include "sd_misfire_verdict.h"
}

namespace sixdeg {
namespace {

constexpr double kMeanTeeth = 512;
constexpr int kSettleCycles = 5;

double pitch_rad(const sd_calibration_t &page) { return 2 * M_PI / page.positions; }

InputConfig configure(const sd_calibration_t &page, const WheelModel &model, const InputTune &tune) {
    const double pitch_deg = 360.0 / page.positions;
    InputConfig config{};
    config.step = plant_step({model.k1_per_rad2(), model.damping_per_rad()}, pitch_rad(page));
    config.inputs = page.cylinders;
    config.noise = 2 * std::sqrt(2.0) * tune.jitter_deg / pitch_deg; // of w^2/2 over itself: twice that of a period
    config.start_speed = 0.1;
    config.start_accel = 1;
    config.start_strength = 0.5;
    config.walk_strength = tune.walk;
    config.alarm_sd = tune.alarm_sd;
    return config;
}

} // namespace

InputWheel::InputWheel(const EngineFile &engine, const sd_calibration_t &page, const InputTune &tune)
    : engine_(engine), page_(page), model_(wheel_model(engine)), step_(configure(page, model_, tune).step),
      observer_(configure(page, model_, tune)), work_j_(page.cylinders, -1.0) {
    const sd_crank_config_t config = sd_calibration_crank(&page, &page.parameters);
    sd_crank_init(&crank_, &config);
}

std::optional<InputWheel::Firing> InputWheel::take(const sd_event_t &event) {
    if (event.kind == SD_EVENT_CAM_EDGE) sd_crank_cam_edge(&crank_, event.tick);
    if (event.kind == SD_EVENT_SAMPLE && event.channel == SD_INPUT_FUEL_INJECTED) {
        float value;
        std::memcpy(&value, &event.value, sizeof value);
        fuel_mg_ = double(value);
    }
    if (event.kind != SD_EVENT_CRANK_EDGE) return std::nullopt;
    sd_tooth_t seen;
    sd_crank_edge(&crank_, event.tick, &seen);
    if (seen.edge_class == SD_EDGE_UNSYNCED || seen.edge_class == SD_EDGE_SPURIOUS) return std::nullopt;
    return tooth(seen);
}

std::optional<InputWheel::Firing> InputWheel::tooth(const sd_tooth_t &tooth) {
    const std::uint32_t cycle = 2u * page_.positions;
    std::optional<Firing> out;
    for (std::uint32_t left = tooth.advance; left > 0; --left) {
        const std::uint32_t k = (tooth.cycle_position + cycle - (left - 1)) % cycle, mark = page_.wheel.mark[SD_WHEEL_FOLSMO][k];
        step(k, tooth, left == 1 && tooth.advance == 1 && tooth.health == SD_VALID);
        if ((mark & SD_WHEEL_BURNED) != 0) burning_ = -1;
        if (SD_WHEEL_FIRES(mark) != 0) {
            active_ = burning_ = int(SD_WHEEL_FIRES(mark)) - 1;
            work_j_[std::size_t(active_)] = fuel_mg_ * double(page_.parameters.misfire_work_per_fuel_jpmg);
        }
        if (SD_WHEEL_READS(mark) != 0) out = read(SD_WHEEL_READS(mark) - 1);
    }
    return out;
}

/// Inputs are those of one radian, over the mean of w^2/2: a pulse of the burning cylinder. What the load does against the mean input is
/// known, and goes off the sample.
void InputWheel::step(std::uint32_t k, const sd_tooth_t &tooth, bool measured) {
    double sample = std::numeric_limits<double>::quiet_NaN();
    if (measured) {
        const double speed = pitch_rad(page_) * double(page_.tick_hz) / tooth.period_ticks;
        const double energy = speed * speed / 2 * page_.wheel.inertia_q31[k % page_.positions] / 2147483648.0;
        if (!observer_.running()) mean_ = energy, settled_ = 0, load_[0] = load_[1] = 0;
        sample = energy / mean_ - 1;
        mean_ += (energy - mean_) / kMeanTeeth;
    }
    std::vector<double> input(page_.cylinders, 0.0);
    double load = 0;
    const double work = work_j_[std::size_t(active_)];
    if (work >= 0 && mean_ > 0) {
        const double gained = work / model_.inertia_kgm2 / mean_;
        if (burning_ >= 0) input[std::size_t(burning_)] = model_.k2_per_rad * gained / (pulse_positions() * pitch_rad(page_));
        load = -model_.k2_per_rad * gained * page_.cylinders / (4 * M_PI);
    }
    const double at[2] = {load_[0], load_[1]};
    for (int i = 0; i < 2; ++i) load_[i] += step_.increment[i][0] * at[0] + step_.increment[i][1] * at[1] + step_.from_input[i] * load;
    observer_.step(sample - load_[0], input, active_);
    ++settled_;
}

double InputWheel::pulse_positions() const { return std::max(1.0, std::round(model_.pulse_deg * page_.positions / 360)); }

InputWheel::Firing InputWheel::read(std::uint32_t lane) const {
    const bool judged = observer_.running() && settled_ > 2 * page_.positions * kSettleCycles && work_j_[lane] > 0 &&
                        sd_crank_phase_known(&crank_);
    const double strength = observer_.strength(int(lane));
    const int verdict = !judged ? SD_NOT_JUDGED : strength < double(page_.parameters.misfire_misfire_below) ? SD_MISFIRE : SD_HEALTHY;
    return {engine_.firing_order[lane], verdict, strength};
}

} // namespace sixdeg
