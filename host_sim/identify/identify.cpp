// SPDX-License-Identifier: MIT
#include "identify/identify.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "common/error.hpp"
#include "identify/compression.hpp"
#include "identify/gas_exchange.hpp"
#include "identify/motion_fit.hpp"

namespace sixdeg {
namespace {

constexpr double kDeg = 180 / M_PI, kTwoSided95 = 1.96;
constexpr std::size_t kLeastCycles = 3;
constexpr double kMostInertia = 0.5;        // relative half-width beyond which a number is none
constexpr double kMostOffsetDeg = 3, kMostPatternDeg = 0.3, kMostExponent = 0.1;
constexpr double kLeastSwing_bar = 2, kMostSwing_bar = 400; // of a cylinder between its lowest and highest pressure
constexpr double kSteady = 0.01;              // relative, of a cycle's mean speed against its neighbours'
constexpr std::size_t kLeastSteady = 5;       // in a row
constexpr double kGuessedInertiaSd = 0.2;     // relative, of a first engine file
constexpr double kGainSd = 0.006;             // of the pressure sensor
constexpr double kCompressionRatioSd = 0.012; // of a data sheet: 2 % either way, evenly

double positive_deg(double deg) { return std::fmod(deg + 720, 360); }

Found refuse(const std::string &reason) {
    Found found;
    found.refused = reason;
    return found;
}

Found found(double value, double sd, double most, const char *of, const char *unit) {
    if (kTwoSided95 * sd < most) return {value, kTwoSided95 * sd, ""};
    return refuse(fmt::format("the recording leaves {} open by +-{:.2g}{}", of, kTwoSided95 * sd, unit));
}

/// Of a sensor in the intake, and of what the cylinder breathes of it.
double intake_sd_bar(const WholeCycle &cycle) {
    return std::isfinite(cycle.intake_bar) ? 0.012 * cycle.intake_bar : std::numeric_limits<double>::infinity();
}

/// n of each cycle's compression. Its interval holds what cycles scatter by, what the angle of TDC and the level of the pressure leave
/// open, and the compression ratio.
Found exponent_of(const EngineFile &engine, const MeasuredTorque &gas, const std::vector<WholeCycle> &cycles, const MotionFit &fit) {
    const bool levelled = std::isfinite(cycles.front().intake_bar);
    if (!levelled)
        return refuse("the level of the recorded pressure is found from its compression with an exponent of 1.32; give --intake");
    const double offset = fit.values(wheel_offset), step = 0.2 / kDeg, bar = 0.02;
    double sum = 0, squares = 0, over_offset = 0, over_level = 0, over_ratio = 0, over_gain = 0, count = 0;
    for (std::size_t c = 0; c < cycles.size(); ++c) {
        const Eigen::VectorXd recorded = gas.recorded_bar(fit.grid_s[c]);
        const auto n = [&](double at, double more_bar, double ratio, double gain = 1) {
            const Eigen::VectorXd absolute = gain * recorded.array() + gas.level_bar(cycles[c], gain * recorded, at) + more_bar;
            return compression_exponent(engine, absolute, at, ratio);
        };
        const double own = n(offset, 0, 1);
        if (!std::isfinite(own)) continue;
        sum += own, squares += own * own, count += 1;
        over_offset += (n(offset + step, 0, 1) - n(offset - step, 0, 1)) / (2 * step);
        over_level += (n(offset, bar, 1) - own) / bar;
        over_ratio += (n(offset, 0, 1.01) - own) / 0.01;
        over_gain += (n(offset, 0, 1, 1.01) - own) / 0.01;
    }
    if (count < 2) return refuse("the recorded pressure falls below zero in compression");
    const double mean = sum / count, scatter = std::fmax(squares / count - mean * mean, 0) / count;
    const double intake_sd = intake_sd_bar(cycles.front());
    const double variance = scatter + std::pow(over_offset / count * fit.sd(wheel_offset), 2) + std::pow(over_level / count * intake_sd,
        2) +
                            std::pow(over_ratio / count * kCompressionRatioSd, 2) + std::pow(over_gain / count * kGainSd, 2);
    return found(mean, std::sqrt(variance), kMostExponent, "it", "");
}

/// By the pressure alone; it stands in where the motion of the crank leaves TDC open.
void take_compression(const EngineFile &engine, const MeasuredTorque &gas, const std::vector<WholeCycle> &cycles, const MotionFit &fit,
                      Identified &result) {
    const double level_sd = intake_sd_bar(cycles.front());
    std::vector<Eigen::VectorXd> bar;
    for (std::size_t c = 0; c < cycles.size(); ++c) {
        bar.push_back(gas.recorded_bar(fit.grid_s[c]));
        if (std::isfinite(level_sd)) bar.back().array() += gas.level_bar(cycles[c], bar.back(), fit.values(wheel_offset));
    }
    const CompressionTdc tdc = compression_tdc(engine, bar, level_sd);
    if (!std::isfinite(tdc.offset_rad)) {
        result.compression_0_deg = refuse("nowhere within 15 deg of the engine file's TDC is the recorded compression polytropic");
        return;
    }
    const double deg = positive_deg(engine.position_0_deg + tdc.offset_rad * kDeg);
    result.compression_0_deg = found(deg, tdc.sd_rad * kDeg, kMostOffsetDeg, "TDC", " deg");
    if (!result.position_0_deg.told() && result.compression_0_deg.told()) result.position_0_deg = result.compression_0_deg;
}

void take_pattern(const EngineFile &engine, const MotionFit &fit, std::size_t cycles, Identified &result) {
    result.pattern_deg.clear();
    result.pattern_refused.clear();
    result.pattern_cycles = cycles - fit.disturbed;
    for (int p = 0; p < engine.wheel.positions; ++p) {
        if (fit.pattern_sd(p) == 0) result.pattern_deg.push_back(refuse("no tooth"));
        else result.pattern_deg.push_back(found(fit.pattern_rad(p) * kDeg, fit.pattern_sd(p) * kDeg, kMostPatternDeg, "the tooth", " deg"));
        if (!result.pattern_deg.back().told() && fit.pattern_sd(p) > 0)
            result.pattern_refused = "one speed alone does not tell the wheel from the torque; record cycles at other speeds too";
    }
}

double rms(const Eigen::VectorXd &values) { return std::sqrt(values.squaredNorm() / double(values.size())); }

/// Of a single cylinder the gas exchange tells the pattern too, whatever burns; the better of the two counts. `whole`: of whole cycles.
void take_exchange(const EngineFile &engine, const CrankRecord &record, const MotionFit *whole, Identified &result) {
    const std::vector<WholeCycle> exchanges = gas_exchanges(engine, record);
    if (exchanges.size() < kLeastCycles) return;
    const Found &inertia = result.inertia_kgm2;
    const double sd = inertia.told() ? inertia.half_width / kTwoSided95 / inertia.value : kGuessedInertiaSd;
    EngineFile known = engine;
    if (inertia.told()) known.inertia_kgm2 = inertia.value;
    const ExchangeTorque gas(known, exchanges, record.pressure, sd);
    const MotionFit fit = fit_motion(known, gas, exchanges);
    if (whole && rms(whole->pattern_sd) <= rms(fit.pattern_sd)) return;
    take_pattern(known, fit, exchanges.size(), result);
    result.pattern_by_exchange = true;
    if (!whole) result.scatter_deg = fit.scatter_rad * kDeg, result.unexplained_deg = fit.repeating_rad * kDeg;
}

/// `inertia`: NaN where only torque over the inertia is known. In N m the inertia hardly counts: at steady speed load is what gas gives.
void take_drag(const MotionFit &fit, double inertia, Identified &result) {
    for (const DragFound &drag : fit.drag) {
        DragAt at{drag.rpm, drag.motored, drag.cycles, refuse("the teeth alone give torque over inertia; give --pressure"), {}};
        at.over_inertia = {drag.over_inertia, kTwoSided95 * drag.over_inertia_sd, ""};
        if (std::isfinite(inertia)) {
            // Of J d both factors are from one fit, so that their errors hang together.
            const double together = drag.slope.dot(fit.covariance.col(log_inertia)), d = drag.over_inertia;
            const double variance = std::pow(drag.over_inertia_sd, 2) + 2 * d * together + d * d * fit.covariance(log_inertia, log_inertia);
            at.nm = {inertia * d, kTwoSided95 * inertia * std::sqrt(std::fmax(variance, 0)), ""};
        }
        result.drag.push_back(at);
    }
}

/// Speed as in the cycles about it: load does not stand still while it moves, least of all when somebody accelerates.
bool steady(const std::vector<WholeCycle> &cycles, std::size_t i) {
    const auto near = [&](std::size_t other) {
        return other >= cycles.size() || std::abs(cycles[other].speed_radps / cycles[i].speed_radps - 1) < kSteady;
    };
    return near(i - 1) && near(i + 1); // ahead of the first one the index wraps round
}

/// Without combustion any cycle; the firing ones of a single cylinder with pressure where several in a row are steady.
std::vector<WholeCycle> usable(const EngineFile &engine, const CrankRecord &record, const std::vector<WholeCycle> &cycles) {
    const bool fired_too = engine.cylinders() == 1 && !record.pressure.empty();
    std::vector<WholeCycle> use, row;
    const auto end_row = [&] {
        if (row.size() >= kLeastSteady) use.insert(use.end(), row.begin(), row.end());
        row.clear();
    };
    for (std::size_t i = 0; i < cycles.size(); ++i) {
        const bool covered = record.pressure.empty() || MeasuredTorque::covers(record.pressure, cycles[i]);
        const bool fires = covered && fired_too && !cycles[i].motored && steady(cycles, i);
        if (!fires) end_row();
        if (fires) row.push_back(cycles[i]);
        else if (covered && cycles[i].motored) use.push_back(cycles[i]);
    }
    end_row();
    return use;
}

/// A pressure in the wrong unit would come out as an inertia that is as wrong.
void check_swing(const std::vector<TimedValue> &pressure, const std::vector<WholeCycle> &cycles, const std::string &from) {
    double most = 0;
    for (const WholeCycle &cycle : cycles) {
        if (!MeasuredTorque::covers(pressure, cycle)) continue;
        const auto earlier = [](const TimedValue &r, double t) { return r.t_s < t; };
        double low = 1e300, high = -1e300;
        for (auto at = std::lower_bound(pressure.begin(), pressure.end(), cycle.t_s.front(), earlier); at->t_s < cycle.t_s.back(); ++at)
            low = std::fmin(low, at->value), high = std::fmax(high, at->value);
        most = std::fmax(most, high - low);
    }
    if (most < kLeastSwing_bar || most > kMostSwing_bar)
        throw InputError(from, "--pressure",
                         fmt::format("changes by {:.3g} bar within a cycle at most, outside [{}, {}] bar; --bar says what one unit of the "
                                     "column is", most, kLeastSwing_bar, kMostSwing_bar));
}

void refuse_all(const std::string &reason, Identified &result) {
    for (Found *f : {&result.inertia_kgm2, &result.position_0_deg, &result.compression_0_deg, &result.exponent, &result.compression_share})
        *f = refuse(reason);
    result.pattern_refused = reason;
}

/// Why no cycle can be used.
const char *why_none(const EngineFile &engine, const CrankRecord &record) {
    if (record.pressure.empty())
        return "in a firing engine the teeth show combustion, whose torque nobody knows; "
               "record a fuel cut and name it by --fuel or --motored";
    if (engine.cylinders() == 1) return "no five cycles in a row have about the same speed and pressure beside them; record steady running";
    return "the pressure of one cylinder tells the others' only without combustion; record a fuel cut and name it by --fuel or --motored";
}

} // namespace

Identified identify(const EngineFile &engine, const CrankRecord &record, const IdentifyOptions &options, const std::string &from) {
    const std::vector<WholeCycle> cycles = whole_cycles(engine, record, options.motored);
    if (cycles.size() < kLeastCycles)
        throw InputError(from, "", fmt::format("holds {} whole cycles with every tooth in place; at least {} are wanted", cycles.size(),
            kLeastCycles));
    if (!record.pressure.empty()) check_swing(record.pressure, cycles, from);
    Identified result;
    result.cycles = cycles.size();
    for (const WholeCycle &cycle : cycles) result.motored += cycle.motored;
    const std::vector<WholeCycle> use = usable(engine, record, cycles);
    result.used = use.size();
    if (use.size() < kLeastCycles) {
        refuse_all(why_none(engine, record), result);
        take_exchange(engine, record, nullptr, result);
        return result;
    }
    const bool measured = !record.pressure.empty();
    std::unique_ptr<GasTorque> gas;
    if (measured) gas = std::make_unique<MeasuredTorque>(engine, record.pressure);
    else gas = std::make_unique<CompressionTorque>(engine);
    const MotionFit fit = fit_motion(engine, *gas, use);

    result.scatter_deg = fit.scatter_rad * kDeg;
    result.unexplained_deg = fit.repeating_rad * kDeg;
    result.unexplained_percent = 100 * fit.unexplained_share;
    const double ratio = std::exp(fit.values(log_inertia)), inertia = engine.inertia_kgm2 * ratio;
    if (measured) {
        result.inertia_kgm2 = found(inertia, inertia * fit.sd(log_inertia), kMostInertia * inertia, "it", " kg m2");
        result.compression_share = refuse("the inertia is known");
        result.exponent = exponent_of(engine, static_cast<const MeasuredTorque &>(*gas), use, fit);
    } else {
        result.inertia_kgm2 = refuse("the teeth alone give torque over inertia; give --pressure");
        result.compression_share = found(1 / ratio, fit.sd(log_inertia) / ratio, kMostInertia, "it", "");
        result.exponent = refuse("the teeth alone give the torque of compression over inertia; give --pressure");
    }
    const double offset = fit.values(wheel_offset) * kDeg;
    result.position_0_deg = found(positive_deg(engine.position_0_deg + offset), fit.sd(wheel_offset) * kDeg, kMostOffsetDeg, "it", " deg");
    if (measured) take_compression(engine, static_cast<const MeasuredTorque &>(*gas), use, fit, result);
    else result.compression_0_deg = refuse("without --pressure there is no compression to look at");
    take_pattern(engine, fit, use.size(), result);
    take_exchange(engine, record, &fit, result);
    take_drag(fit, measured ? inertia : std::nan(""), result);
    return result;
}

} // namespace sixdeg
