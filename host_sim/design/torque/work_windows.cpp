// SPDX-License-Identifier: MIT
#include "design/torque/work_windows.hpp"

#include <algorithm>
#include <cmath>

#include "design/calibration.hpp"
#include "design/torque/pulse.hpp"

namespace sixdeg {
namespace {

constexpr double kRadPerDeg = M_PI / 180, kBdcDeg = 180;
constexpr double kUsualDeg = 60, kBeforeNextDeg = 45; // length, and where it begins, when there is no quiet stretch
constexpr double kLeastPitches = 3;
constexpr double kOwnShare = 0.9;

double next_tdc_deg(const EngineFile &engine, std::size_t firing) {
    const auto &tdc = engine.firing_tdc_deg;
    return firing + 1 < tdc.size() ? tdc[firing + 1] : tdc[0] + 720;
}

struct Stretch {
    double from_deg, to_deg; ///< Crank angle, from 0 on without end.
};

/// What nobody's combustion or compression disturbs, or the usual stretch.
Stretch stretch_behind(const EngineFile &engine, std::size_t firing, double longest_deg) {
    const double tdc = engine.firing_tdc_deg[firing], next = next_tdc_deg(engine, firing);
    Stretch s{tdc + std::max(kBdcDeg, engine.exhaust_open_deg), next - (720 - engine.intake_close_deg)};
    if (s.to_deg - s.from_deg < kUsualDeg) s = {next - kBeforeNextDeg, next - kBeforeNextDeg + kUsualDeg};
    if (longest_deg <= 0) return s;
    const double middle = (s.from_deg + s.to_deg) / 2, half = std::min(longest_deg, s.to_deg - s.from_deg) / 2;
    return {middle - half, middle + half};
}

double pitch_deg(const EngineFile &engine) { return 360.0 / engine.wheel.positions; }

bool has_tooth(const EngineFile &engine, long position) {
    const long n = engine.wheel.positions;
    const auto &missing = engine.wheel.missing;
    return std::find(missing.begin(), missing.end(), int(((position % n) + n) % n)) == missing.end();
}

/// Positions of the first and last tooth in it, counted from position 0 without end.
std::pair<long, long> teeth_within(const EngineFile &engine, const Stretch &s) {
    long first = long(std::ceil((s.from_deg - engine.position_0_deg) / pitch_deg(engine) - 1e-9));
    long last = long(std::floor((s.to_deg - engine.position_0_deg) / pitch_deg(engine) + 1e-9));
    while (!has_tooth(engine, first)) ++first;
    while (!has_tooth(engine, last)) --last;
    return {first, last};
}

/// J of a crank that, at constant energy, takes as long from tooth to tooth as this one does.
double inertia_between(const EngineFile &engine, long first, long last) {
    constexpr int kSteps = 10; // a pitch
    const long steps = (last - first) * kSteps;
    double sum = 0;
    for (long i = 0; i < steps; ++i) {
        const double deg = engine.position_0_deg + (double(first) + (double(i) + 0.5) / kSteps) * pitch_deg(engine);
        sum += std::sqrt(crank_inertia_kgm2(engine, deg * kRadPerDeg)) / double(steps);
    }
    return sum * sum;
}

/// Share of a firing's work that is done at `deg` behind its TDC, read from the pulse of its torque.
double done_at(const std::vector<double> &pulse, double deg) {
    constexpr double kStepDeg = 720.0 / kPulsePoints;
    double sum = 0, all = 0;
    for (double at = -180; at < 540; at += kStepDeg) {
        const double torque = pulse_at(pulse, at * kRadPerDeg);
        all += torque;
        if (at < deg) sum += torque;
    }
    return sum / all;
}

} // namespace

std::vector<double> own_shares(const EngineFile &engine, const sd_work_tables_t &tables) {
    std::vector<double> shares;
    const double pitch = pitch_deg(engine);
    for (std::size_t i = 0; i < std::size_t(tables.windows); ++i) {
        const std::vector<double> pulse = cylinder_pulse(engine, i).combustion;
        const auto mean_done = [&](const sd_work_window_t &w) { // over the window, which begins within a cycle before or after the TDC
            const double from = engine.position_0_deg + w.first * pitch - engine.firing_tdc_deg[i];
            const double length = double(w.span_rad) / kRadPerDeg;
            double sum = 0;
            constexpr int kSteps = 20;
            for (int j = 0; j < kSteps; ++j) {
                double at = std::fmod(from + length * (j + 0.5) / kSteps + 1440 + 180, 720) - 180;
                sum += done_at(pulse, at) / kSteps;
            }
            return sum;
        };
        const sd_work_window_t &before = tables.window[i > 0 ? i - 1 : tables.windows - 1u];
        shares.push_back(tables.windows == 1 ? mean_done(tables.window[0]) : mean_done(tables.window[i]) - mean_done(before));
    }
    return shares;
}

sd_work_tables_t work_windows(const EngineFile &engine, double longest_deg) {
    sd_work_tables_t tables{};
    if (engine.dual_mass) return tables;
    const long cycle = 2 * engine.wheel.positions;
    tables.cycle = std::uint16_t(cycle);
    long end = 0; // of the window before
    for (std::size_t i = 0; i < std::size_t(engine.cylinders()); ++i) {
        auto [first, last] = teeth_within(engine, stretch_behind(engine, i, longest_deg));
        if (i > 0) first = std::max(first, end + 1);
        while (!has_tooth(engine, first)) ++first;
        end = last;
        if (double(last - first) < kLeastPitches) return {};
        const double span_rad = double(last - first) * pitch_deg(engine) * kRadPerDeg, per_tick = span_rad * engine.tick_hz;
        const auto position = [cycle](long at) { return std::uint16_t(((at % cycle) + cycle) % cycle); };
        tables.window[i] = {float(inertia_between(engine, first, last) / 2 * per_tick * per_tick), float(span_rad), position(first),
                            position(last)};
    }
    tables.windows = std::uint8_t(engine.cylinders());
    const auto repeats = [&](const sd_work_window_t &w) {
        return std::any_of(tables.window, tables.window + tables.windows,
                           [&](const sd_work_window_t &other) { return other.first == (w.first + cycle / 2) % cycle; });
    };
    tables.alike = std::all_of(tables.window, tables.window + tables.windows, repeats);
    if (engine.pulses.empty()) return tables;
    const std::vector<double> shares = own_shares(engine, tables);
    for (std::size_t i = 0; i < shares.size(); ++i)
        if (shares[i] >= kOwnShare) tables.own = std::uint8_t(tables.own | (1u << i));
    return tables;
}

} // namespace sixdeg
