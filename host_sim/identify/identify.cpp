// SPDX-License-Identifier: MIT
#include "identify/identify.hpp"

#include <cmath>
#include <fmt/format.h>
#include <memory>

#include "common/error.hpp"
#include "identify/compression.hpp"
#include "identify/motion_fit.hpp"

namespace sixdeg {
namespace {

constexpr double kDeg = 180 / M_PI, kTwoSided95 = 1.96;
constexpr std::size_t kLeastCycles = 3;
constexpr double kMostInertia = 0.5;        // relative half-width beyond which a number is none
constexpr double kMostOffsetDeg = 3, kMostPatternDeg = 0.3, kMostExponent = 0.1;
constexpr double kGainSd = 0.006;             // of the pressure sensor
constexpr double kCompressionRatioSd = 0.012; // of a data sheet: 2 % either way, evenly

Found refuse(const std::string &reason) {
    Found found;
    found.refused = reason;
    return found;
}

Found found(double value, double sd, double most, const char *of) {
    if (kTwoSided95 * sd < most) return {value, kTwoSided95 * sd, ""};
    return refuse(fmt::format("the recording leaves {} open by +-{:.2g}", of, kTwoSided95 * sd));
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
    const double intake_sd = 0.012 * cycles.front().intake_bar; // of a sensor in the intake, and of what the cylinder breathes of it
    const double variance = scatter + std::pow(over_offset / count * fit.sd(wheel_offset), 2) + std::pow(over_level / count * intake_sd,
        2) +
                            std::pow(over_ratio / count * kCompressionRatioSd, 2) + std::pow(over_gain / count * kGainSd, 2);
    return found(mean, std::sqrt(variance), kMostExponent, "it");
}

void take_pattern(const EngineFile &engine, const MotionFit &fit, Identified &result) {
    for (int p = 0; p < engine.wheel.positions; ++p) {
        if (fit.pattern_sd(p) == 0) result.pattern_deg.push_back(refuse("no tooth"));
        else result.pattern_deg.push_back(found(fit.pattern_rad(p) * kDeg, fit.pattern_sd(p) * kDeg, kMostPatternDeg, "the tooth"));
        if (!result.pattern_deg.back().told() && fit.pattern_sd(p) > 0)
            result.pattern_refused = "one speed alone does not tell the wheel from the torque; record cycles at other speeds too";
    }
}

void take_drag(const MotionFit &fit, double inertia, bool with_inertia, Identified &result) {
    for (const DragFound &drag : fit.drag) {
        DragAt at{drag.rpm, drag.motored, drag.cycles, refuse("the inertia is not known"), {}};
        at.over_inertia = {drag.over_inertia, kTwoSided95 * drag.over_inertia_sd, ""};
        if (with_inertia) {
            // Of J d both factors are from one fit, so that their errors hang together.
            const double together = drag.slope.dot(fit.covariance.col(log_inertia)), d = drag.over_inertia;
            const double variance = std::pow(drag.over_inertia_sd, 2) + 2 * d * together + d * d * fit.covariance(log_inertia, log_inertia);
            at.nm = {inertia * d, kTwoSided95 * inertia * std::sqrt(std::fmax(variance, 0)), ""};
        }
        result.drag.push_back(at);
    }
}

std::vector<WholeCycle> usable(const EngineFile &engine, const CrankRecord &record, const std::vector<WholeCycle> &cycles) {
    std::vector<WholeCycle> use;
    const bool fired_too = engine.cylinders() == 1 && !record.pressure.empty();
    for (const WholeCycle &cycle : cycles)
        if ((cycle.motored || fired_too) && (record.pressure.empty() || MeasuredTorque::covers(record.pressure,
            cycle))) use.push_back(cycle);
    return use;
}

void refuse_all(const std::string &reason, Identified &result) {
    for (Found *f : {&result.inertia_kgm2, &result.position_0_deg, &result.exponent, &result.compression_share}) *f = refuse(reason);
    result.pattern_refused = reason;
}

} // namespace

Identified identify(const EngineFile &engine, const CrankRecord &record, const IdentifyOptions &options, const std::string &from) {
    const std::vector<WholeCycle> cycles = whole_cycles(engine, record, options.motored);
    if (cycles.size() < kLeastCycles)
        throw InputError(from, "", fmt::format("holds {} whole cycles with every tooth in place; at least {} are wanted", cycles.size(),
            kLeastCycles));
    Identified result;
    result.cycles = cycles.size();
    for (const WholeCycle &cycle : cycles) result.motored += cycle.motored;
    const std::vector<WholeCycle> use = usable(engine, record, cycles);
    result.used = use.size();
    if (use.size() < kLeastCycles) {
        refuse_all(record.pressure.empty()
            ? "in a firing engine the teeth show combustion, whose torque nobody knows; record a fuel cut and name "
                                             "it by --fuel or --motored"
                                           : "the pressure of one cylinder tells the others' only without combustion; "
                                             "record a fuel cut and name it by --fuel or --motored",
                   result);
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
        result.inertia_kgm2 = found(inertia, inertia * fit.sd(log_inertia), kMostInertia * inertia, "it");
        result.compression_share = refuse("the inertia is known");
        result.exponent = exponent_of(engine, static_cast<const MeasuredTorque &>(*gas), use, fit);
    } else {
        result.inertia_kgm2 = refuse("the teeth alone give torque over inertia; give --pressure");
        result.compression_share = found(1 / ratio, fit.sd(log_inertia) / ratio, kMostInertia, "it");
        result.exponent = refuse("the teeth alone give the torque of compression over inertia; give --pressure");
    }
    const double offset = fit.values(wheel_offset) * kDeg;
    result.position_0_deg = found(std::fmod(engine.position_0_deg + offset + 360, 360), fit.sd(wheel_offset) * kDeg, kMostOffsetDeg, "it");
    take_pattern(engine, fit, result);
    take_drag(fit, inertia, result.inertia_kgm2.told(), result);
    return result;
}

} // namespace sixdeg
