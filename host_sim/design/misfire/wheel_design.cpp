// SPDX-License-Identifier: MIT
#include "design/misfire/wheel_design.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "common/error.hpp"
#include "design/calibration.hpp"
#include "design/torque/pulse.hpp"

namespace sixdeg {
namespace {

constexpr double kRadPerDeg = M_PI / 180;
constexpr double kReadDeg = 300;     // as the filter on tooth times reads a firing
constexpr double kLongestWindowDeg = 240;
constexpr double kMeanTeeth = 512;   // MEAN_BITS of sd_switched_wheel.inc
constexpr int kCaptureCycles = 40;   // until nothing of the start is left

/// First cycle position at or after `deg` past the TDC of a firing.
int position_after(const EngineFile &engine, std::size_t firing, double deg) {
    const int cycle = 2 * engine.wheel.positions;
    const double off = (engine.firing_tdc_deg[firing] + deg - engine.position_0_deg) / 360 * engine.wheel.positions;
    return ((int(std::ceil(off - 1e-9)) % cycle) + cycle) % cycle;
}

double pitch_rad(const EngineFile &engine) { return 2 * M_PI / engine.wheel.positions; }

double inertia_before(const EngineFile &engine, int k) {
    return crank_inertia_kgm2(engine, engine.position_0_deg * kRadPerDeg + (k - 0.5) * pitch_rad(engine));
}

/// Mean and standard deviation of the heat release, deg from TDC. Wiebe: 1 - exp(-6.908 u^(shape + 1)).
void heat_moments(const EngineFile &engine, double &mean, double &deviation) {
    constexpr int kSteps = 2000;
    double sum = 0, square = 0, all = 0;
    for (const HeatPulse &pulse : engine.pulses) {
        const auto burned = [&](double u) { return 1 - std::exp(-6.908 * std::pow(u, pulse.shape + 1)); };
        for (int i = 0; i < kSteps; ++i) {
            const double part = pulse.share * (burned((i + 1.0) / kSteps) - burned(double(i) / kSteps));
            const double at = pulse.start_deg + pulse.duration_deg * (i + 0.5) / kSteps;
            all += part, sum += part * at, square += part * at * at;
        }
    }
    mean = sum / all;
    deviation = std::sqrt(square / all - mean * mean);
}

/// Acceleration over angle of a lag at `rate` under a rectangle of heat, from TDC on; area as `area`.
std::vector<double> lagged(double start_deg, double width_deg, double rate, std::size_t points, double step_deg, double area) {
    std::vector<double> out;
    double x = 0, sum = 0;
    const double keep = std::exp(-rate * step_deg * kRadPerDeg);
    for (std::size_t i = 0; i < points; ++i) {
        const double at = (double(i) + 0.5) * step_deg;
        x = keep * x + (at > start_deg && at <= start_deg + width_deg ? 1 - keep : 0);
        out.push_back(x), sum += x;
    }
    for (double &v : out) v *= area / sum;
    return out;
}

/// Squared distance of the lag's pulse from the torque of combustion over the 180 deg after TDC.
double misfit(const std::vector<double> &torque, double start_deg, double width_deg, double rate) {
    constexpr double kStepDeg = 720.0 / kPulsePoints;
    const auto points = std::size_t(180 / kStepDeg);
    double area = 0, sum = 0;
    for (std::size_t i = 0; i < points; ++i) area += torque[i];
    const auto fit = lagged(start_deg, width_deg, rate, points, kStepDeg, area);
    for (std::size_t i = 0; i < points; ++i) sum += std::pow(torque[i] - fit[i], 2);
    return sum;
}

PlantStep step_of(const EngineFile &engine, const WheelModel &model, sd_wheel_kind_t kind) {
    const CrankModel crank{model.k1_per_rad2(), model.damping_per_rad()};
    const double pitch = pitch_rad(engine);
    if (kind == SD_WHEEL_ROO) return roo_step(crank, model.roo_per_rad(), pitch);
    return folsmo_step(crank, kind == SD_WHEEL_FOLSMO ? model.luenberger_per_rad2() : 0, pitch);
}

double sliding_share(sd_wheel_kind_t kind) {
    return kind == SD_WHEEL_FOLSMO ? kFolsmoSliding : kind == SD_WHEEL_FOSMO ? kFosmoSliding : 0;
}

/// Inputs of one unit of acceleration gained over a firing, per radian: while the pulse lasts, beyond the mean, and the mean.
struct Inputs {
    int start, positions; ///< Of the pulse, from TDC.
    double pulse, mean;
};

Inputs inputs_of(const EngineFile &engine, const WheelModel &model) {
    const double pitch_deg = 360.0 / engine.wheel.positions;
    Inputs in{};
    in.start = int(std::lround(model.pulse_start_deg / pitch_deg));
    in.positions = std::max(1, int(std::lround(model.pulse_deg / pitch_deg)));
    in.pulse = model.k2_per_rad / (in.positions * pitch_rad(engine));      // its area over the lag is 1
    in.mean = model.k2_per_rad * engine.cylinders() / (4 * M_PI);
    return in;
}

/// Accelerations at teeth of the observer in double, on a crank that gains 1 by each firing; the firing `missing` gains nothing.
class CaptureRun {
  public:
    CaptureRun(const EngineFile &engine, const WheelModel &model, sd_wheel_kind_t kind)
        : engine_(engine), model_(model), step_(step_of(engine, model, kind)), in_(inputs_of(engine, model)),
          rho_(sliding_share(kind) * in_.mean), torque_(cylinder_pulse(engine, 0).combustion) {}

    std::vector<double> accelerations(int missing) const {
        const int cycle = 2 * engine_.wheel.positions, n = engine_.cylinders();
        const double h = pitch_rad(engine_);
        double energy = 0, mean = 0, x[2] = {}, y = 0;
        std::vector<double> out;
        for (int k = 1; k <= (kCaptureCycles + 3) * cycle; ++k) {
            const double slope = torque_at(k, missing) - n / (4 * M_PI), before = energy;
            energy += slope * h;
            const double sample = (before + energy) / 2 - mean, error = y - x[0];
            mean += sample / kMeanTeeth;
            const double input = fires(k) - in_.mean + rho_ * (error > 0 ? 1 : error < 0 ? -1 : 0), ym = (y + sample) / 2;
            const double old[2] = {x[0], x[1]};
            for (int i = 0; i < 2; ++i)
                x[i] += step_.increment[i][0] * old[0] + step_.increment[i][1] * old[1] + step_.from_input[i] * input +
                        step_.from_output[i] * ym;
            y = sample;
            out.push_back(x[1] + step_.output_gain * y);
        }
        return out;
    }

  private:
    int tdc(int firing) const { return firing % engine_.cylinders() * 2 * engine_.wheel.positions / engine_.cylinders(); }
    /// Torque of combustion over the interval that ends at position k, areas 1 a firing.
    double torque_at(int k, int missing) const {
        const int cycle = 2 * engine_.wheel.positions;
        double sum = 0;
        for (int f = 0; f < engine_.cylinders(); ++f) {
            const int since = ((k - tdc(f)) % cycle + cycle) % cycle, number = (k - since - tdc(f)) / cycle * engine_.cylinders() + f;
            if (number != missing) sum += pulse_at(torque_, (since - 0.5) * pitch_rad(engine_)) / M_PI;
        }
        return sum;
    }
    double fires(int k) const {
        const int cycle = 2 * engine_.wheel.positions;
        for (int f = 0; f < engine_.cylinders(); ++f) {
            const int since = ((k - tdc(f) - in_.start) % cycle + cycle) % cycle;
            if (since > 0 && since <= in_.positions) return in_.pulse;
        }
        return 0;
    }
    const EngineFile &engine_;
    const WheelModel &model_;
    PlantStep step_;
    Inputs in_;
    double rho_;
    std::vector<double> torque_;
};

int window_positions(const EngineFile &engine, int from, int to) {
    const int cycle = 2 * engine.wheel.positions, longest = int(kLongestWindowDeg / 360 * engine.wheel.positions);
    return std::min(longest, (to - from - 1 + cycle) % cycle + 1);
}

/// Writes into the marks of one observer at `position`, which may lie outside the cycle.
std::uint16_t &mark_at(sd_wheel_tables_t &t, int kind, int position) {
    const int cycle = 2 * t.positions;
    return t.mark[kind][(position % cycle + cycle) % cycle];
}

template <class V, class Tables>
void fill(const EngineFile &engine, const WheelModel &model, const sd_wheel_tables_t &t, const std::vector<int> &windows,
          const std::vector<WheelCapture> &captures, Tables &out) {
    const double energy = std::ldexp(1, t.energy_exponent), accel = std::ldexp(1, t.accel_exponent), work = std::ldexp(1, t.work_exponent);
    const Inputs in = inputs_of(engine, model);
    const double gained = work / model.inertia_kgm2; // change of w^2/2 by a unit of work
    for (int kind = 0; kind < SD_WHEEL_KINDS; ++kind) {
        auto &design = out.design[kind];
        if (!switched_table<V>(step_of(engine, model, sd_wheel_kind_t(kind)), {energy, accel, accel}, design.table))
            throw InputError(engine.name, "combustion, wheel", "the observers of document 000 do not fit this wheel");
        design.sliding = V::gain(sliding_share(sd_wheel_kind_t(kind)) * in.mean * gained / accel);
        design.capture = V::gain(captures[std::size_t(kind)].share);
    }
    out.pulse = V::gain(in.pulse * gained / accel);
    out.mean = V::gain(in.mean * gained / accel);
    out.jump = V::gain(gained / energy);
    for (std::size_t i = 0; i < windows.size(); ++i) {
        out.accel[i] = V::gain(gained / (windows[i] * pitch_rad(engine)) / accel);
        out.per_tooth[i] = V::gain(64.0 / windows[i]);
    }
}

/// Length of each firing's window, from its TDC to the next.
std::vector<int> window_lengths(const EngineFile &engine, const sd_calibration_t &c) {
    std::vector<int> windows;
    for (std::size_t i = 0; i < c.cylinders; ++i)
        windows.push_back(window_positions(engine, c.firing_position[i], c.firing_position[(i + 1) % c.cylinders]));
    return windows;
}

/// What happens where, by one observer's delay.
void place(const EngineFile &engine, const sd_calibration_t &c, const Inputs &in, const std::vector<int> &windows, int kind,
           sd_wheel_tables_t &t) {
    const int burns = std::min(in.positions, *std::min_element(windows.begin(), windows.end()) - 1), delay = t.delay[kind];
    for (std::size_t i = 0; i < windows.size(); ++i) {
        const int tdc = c.firing_position[i], number = int(i) + 1;
        mark_at(t, kind, tdc + delay) |= std::uint16_t(number);
        mark_at(t, kind, position_after(engine, i, kReadDeg)) |= std::uint16_t(number << 4);
        mark_at(t, kind, tdc + in.start) |= std::uint16_t(number << 8);
        mark_at(t, kind, tdc + delay + windows[i]) |= SD_WHEEL_CLOSES;
        mark_at(t, kind, tdc + in.start + burns) |= SD_WHEEL_BURNED;
    }
}

void copy_inertia(const EngineFile &engine, const WheelModel &model, sd_wheel_tables_t &t) {
    for (int k = 0; k < t.positions; ++k)
        t.inertia_q31[k] = std::int32_t(std::min(2147483647.0, inertia_before(engine, k) / model.inertia_kgm2 * 2147483648.0));
}

void scale(const EngineFile &engine, const sd_parameters_t &p, sd_wheel_tables_t &t) {
    const double fastest = double(p.torque_speed_base_rpm) * M_PI / 30;
    const double displacement = M_PI / 4 * engine.bore_m * engine.bore_m * engine.stroke_m;
    t.energy_exponent = std::int8_t(std::ceil(std::log2(fastest * fastest / 2)));
    t.accel_exponent = std::int8_t(t.energy_exponent - 2);
    t.work_exponent = std::int8_t(std::max(0.0, std::ceil(std::log2(2 * 40e5 * displacement))));
    const double ticks = pitch_rad(engine) * engine.tick_hz / std::sqrt(2 * std::ldexp(1, t.energy_exponent));
    t.speed_per_tick = float(ticks);
    while (ticks * std::ldexp(1, 31 - t.speed_shift) >= 4294967295.0) ++t.speed_shift;
    t.speed_numerator = std::uint32_t(ticks * std::ldexp(1, 31 - t.speed_shift));
}

} // namespace

double WheelModel::luenberger_per_rad2() const { return damping_per_rad() * damping_per_rad() / 2 - k1_per_rad2(); }

WheelModel wheel_model(const EngineFile &engine) {
    WheelModel model{};
    double mean = 0, deviation = 0;
    heat_moments(engine, mean, deviation);
    model.pulse_deg = std::sqrt(12.0) * deviation;
    model.pulse_start_deg = mean - model.pulse_deg / 2;
    const auto torque = cylinder_pulse(engine, 0).combustion;
    double low = 0.3, high = 12; // golden section
    for (int i = 0; i < 60; ++i) {
        const double a = high - (high - low) * 0.6180339887498949, b = low + (high - low) * 0.6180339887498949;
        const auto of = [&](double rate) { return misfit(torque, model.pulse_start_deg, model.pulse_deg, rate); };
        const bool left = of(a) < of(b);
        (left ? high : low) = left ? b : a;
    }
    model.k2_per_rad = (low + high) / 2;
    model.mean_per_rad = 1 / (kMeanTeeth * pitch_rad(engine));
    for (int k = 0; k < engine.wheel.positions; ++k) model.inertia_kgm2 = std::max(model.inertia_kgm2, inertia_before(engine, k));
    return model;
}

WheelCapture wheel_capture(const EngineFile &engine, const WheelModel &model, sd_wheel_kind_t kind) {
    const int cycle = 2 * engine.wheel.positions, n = engine.cylinders(), missing = kCaptureCycles * n;
    const int window = window_positions(engine, 0, cycle / n);
    const CaptureRun run(engine, model, kind);
    const auto healthy = run.accelerations(-1), missed = run.accelerations(missing);
    const int latest = int(kReadDeg / 360 * engine.wheel.positions) - window;
    WheelCapture best{0, 0};
    for (int delay = 0; delay <= std::max(0, latest); ++delay) {
        double lost = 0; // entry i is of position i + 1
        const auto from = std::size_t(kCaptureCycles * cycle + delay);
        for (std::size_t k = from; k < from + std::size_t(window); ++k) lost += healthy[k] - missed[k];
        const double share = lost * pitch_rad(engine);
        if (share > best.share) best = {delay, share};
    }
    return best;
}

sd_wheel_tables_t wheel_tables(const EngineFile &engine, const sd_calibration_t &c) {
    sd_wheel_tables_t t{};
    if (engine.pulses.empty()) return t;
    const WheelModel model = wheel_model(engine);
    const std::vector<int> windows = window_lengths(engine, c);
    t.positions = c.positions;
    t.cylinders = c.cylinders;
    copy_inertia(engine, model, t);
    scale(engine, c.parameters, t);
    std::vector<WheelCapture> captures;
    for (int kind = 0; kind < SD_WHEEL_KINDS; ++kind) {
        captures.push_back(wheel_capture(engine, model, sd_wheel_kind_t(kind)));
        t.delay[kind] = std::uint8_t(captures.back().delay);
        place(engine, c, inputs_of(engine, model), windows, kind, t);
    }
    fill<NumberF32>(engine, model, t, windows, captures, t.f32);
    fill<NumberQ31>(engine, model, t, windows, captures, t.q31);
    return t;
}

} // namespace sixdeg
