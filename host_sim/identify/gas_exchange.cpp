// SPDX-License-Identifier: MIT
#include "identify/gas_exchange.hpp"

#include <algorithm>
#include <cmath>

namespace sixdeg {
namespace {

constexpr double kPascal = 1e5, kCrankcase_bar = 1.013;
constexpr double kAfterOpening = 35, kAheadOfClosing = 15; // deg: the blow-down is over; the piston compresses little yet
constexpr double kLeastOverlapDeg = 12;
constexpr double kOffsetSd = 2 * M_PI / 180;
constexpr double kExhaust_bar = 1.08, kExhaustSd = 0.06;   // of a muffler
constexpr double kIntake_bar = 0.8, kIntakeSd = 0.2;       // from a throttle nearly closed to none
constexpr double kReadSd = 0.03, kSeenSd = 0.1;            // of a sensor in the intake; of one in the cylinder, which drifts with its heat
constexpr double kLeastUnexplained = 0.15;
constexpr double kTop = 360, kStrokeFrom = 60, kStrokeTo = 120; // deg from its TDC: the middle of a stroke

double time_at(const WholeCycle &cycle, double deg) {
    const auto after = std::upper_bound(cycle.deg.begin() + 1, cycle.deg.end() - 1, deg) - cycle.deg.begin();
    const auto k = std::size_t(after);
    return cycle.t_s[k - 1] + (cycle.t_s[k] - cycle.t_s[k - 1]) * (deg - cycle.deg[k - 1]) / (cycle.deg[k] - cycle.deg[k - 1]);
}

/// By how much the pressure is higher while the piston drives the gas out than while it draws it in, mean of the cycles; NaN without.
double exchange_difference(const std::vector<WholeCycle> &cycles, const std::vector<TimedValue> &pressure) {
    double sum = 0, count = 0;
    for (const WholeCycle &c : cycles) {
        const double out = mean_within(pressure, time_at(c, -kStrokeTo), time_at(c, -kStrokeFrom));
        const double in = mean_within(pressure, time_at(c, kStrokeFrom), time_at(c, kStrokeTo));
        if (std::isfinite(out - in)) sum += out - in, count += 1;
    }
    return sum / count;
}

} // namespace

ExchangeTorque::ExchangeTorque(const EngineFile &engine, const std::vector<WholeCycle> &cycles, const std::vector<TimedValue> &pressure,
                               double inertia_sd)
    : GasTorque(engine, kLeastUnexplained) {
    unknowns_[log_inertia].prior_sd = inertia_sd;
    unknowns_[wheel_offset].prior_sd = kOffsetSd;
    double intake = 0;
    for (const WholeCycle &cycle : cycles) intake += cycle.intake_bar / double(cycles.size());
    const double difference = pressure.empty() ? std::nan("") : exchange_difference(cycles, pressure);
    unknowns_.push_back({"exhaust pressure", kExhaust_bar, kExhaustSd, kExhaustSd});
    if (std::isfinite(intake)) unknowns_.push_back({"intake pressure", intake, kReadSd, kReadSd});
    else if (std::isfinite(difference)) unknowns_.push_back({"intake pressure", kExhaust_bar - difference, kSeenSd, kSeenSd});
    else unknowns_.push_back({"intake pressure", kIntake_bar, kIntakeSd, kIntakeSd});
    add_unexplained();
}

GasTorque::Nm ExchangeTorque::gas_nm(const WholeCycle &, const Eigen::VectorXd &, const Eigen::VectorXd &values) const {
    const double newton_per_bar = M_PI / 4 * engine_.bore_m * engine_.bore_m * kPascal, offset = values(wheel_offset);
    const Arms &at = arms(offset); // a revolution away from the firing TDC they are the same
    Nm nm{Eigen::VectorXd::Zero(kGridPoints), Eigen::MatrixXd::Zero(kGridPoints, values.size())};
    for (int i = 0; i < kGridPoints; ++i) {
        const double deg = grid_deg(i);
        if (deg < engine_.exhaust_open_deg - kTop || deg > engine_.intake_close_deg - kTop) continue;
        const int which = deg < 0 ? exhaust_bar : intake_bar;
        const double bar = values(which) - kCrankcase_bar;
        nm.gas(i) = newton_per_bar * bar * at.arm(i, 0);
        nm.slope(i, wheel_offset) = newton_per_bar * bar * at.bend(i, 0);
        nm.slope(i, which) = newton_per_bar * at.arm(i, 0);
    }
    return nm;
}

std::vector<WholeCycle> gas_exchanges(const EngineFile &engine, const CrankRecord &record) {
    const double from = engine.exhaust_open_deg + kAfterOpening, to = engine.intake_close_deg - kAheadOfClosing;
    std::vector<WholeCycle> found;
    if (engine.cylinders() != 1 || to - from < 360 + kLeastOverlapDeg) return found;
    const double pitch = 360.0 / engine.wheel.positions;
    const auto positions = long(engine.wheel.positions);
    const auto has_tooth = [&](long place) {
        return !std::binary_search(engine.wheel.missing.begin(), engine.wheel.missing.end(), int(((place % positions) + positions)
            % positions));
    };
    const auto place_from = [&](double deg) { return long(std::ceil((deg - engine.position_0_deg) / pitch)); };
    const long first = place_from(from), last = place_from(to) - 1;
    std::size_t wanted = 0;
    for (long place = first; place <= last; ++place) wanted += has_tooth(place);
    std::size_t i = 0;
    while (i < record.teeth.size()) {
        const auto cycle = long(std::floor(double(record.teeth[i].place - first) / double(2 * positions)));
        WholeCycle one{};
        for (; i < record.teeth.size() && record.teeth[i].place < first + (cycle + 1) * 2 * positions; ++i) {
            const long own = record.teeth[i].place - cycle * 2 * positions;
            if (own < first) break; // the angle was lost and counts anew
            if (own > last) continue;
            one.t_s.push_back(record.teeth[i].t_s);
            one.deg.push_back(engine.position_0_deg + pitch * double(own) - kTop);
            one.position.push_back(int(((own % positions) + positions) % positions));
        }
        if (one.t_s.size() != wanted) continue;
        one.speed_radps = (one.deg.back() - one.deg.front()) * M_PI / 180 / (one.t_s.back() - one.t_s.front());
        one.motored = false;
        one.intake_bar = mean_within(record.intake, one.t_s.front(), one.t_s.back());
        found.push_back(std::move(one));
    }
    return found;
}

} // namespace sixdeg
