// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "identify/compression.hpp"
#include "identify/gas_torque.hpp"

namespace sixdeg {
namespace {

constexpr double kRad = M_PI / 180, kPascal = 1e5;
constexpr double kCrankcase_bar = 1.013;
constexpr double kLevelSd_bar = 0.1;  // of pegging and of the crankcase's pressure together
constexpr double kFactorSd = 0.02;    // of one cylinder's pressure against another's
constexpr double kBottomDeg = -180, kBottomHalfDeg = 10;
constexpr double kGainSd = 0.006;     // of a calibrated sensor: 1 % either way, evenly
constexpr double kLeastUnexplained = 0.003;
constexpr int kLevel = shared_unknowns, kGain = kLevel + 1, kFirstFactor = kGain + 1;

} // namespace

MeasuredTorque::MeasuredTorque(const EngineFile &engine, const std::vector<TimedValue> &pressure)
    : GasTorque(engine, kLeastUnexplained), pressure_(pressure) {
    unknowns_.push_back({"pressure level", 0, kLevelSd_bar, kLevelSd_bar});
    unknowns_.push_back({"pressure gain", 0, kGainSd, kGainSd});
    for (int lane = 1; lane < engine.cylinders(); ++lane) unknowns_.push_back({"cylinder factor", 0, kFactorSd, kFactorSd});
    add_unexplained();
}

bool MeasuredTorque::covers(const std::vector<TimedValue> &pressure, const WholeCycle &cycle) {
    const double margin = 20 * kRad / cycle.speed_radps;
    return !pressure.empty() && pressure.front().t_s <= cycle.t_s.front() - margin && pressure.back().t_s >= cycle.t_s.back() + margin;
}

Eigen::VectorXd MeasuredTorque::recorded_bar(const Eigen::VectorXd &grid_s) const {
    Eigen::VectorXd bar(kGridPoints);
    std::size_t at = std::size_t(std::lower_bound(pressure_.begin(), pressure_.end(), grid_s(0),
                                                  [](const TimedValue &r, double t) { return r.t_s < t; }) - pressure_.begin());
    for (int i = 0; i < kGridPoints; ++i) {
        while (at < pressure_.size() && pressure_[at].t_s < grid_s(i)) ++at;
        const TimedValue &after = pressure_[std::min(at, pressure_.size() - 1)], &before = at > 0 ? pressure_[at - 1] : after;
        const double wide = after.t_s - before.t_s, share = wide > 0 ? std::clamp((grid_s(i) - before.t_s) / wide, 0.0, 1.0) : 0;
        bar(i) = before.value + share * (after.value - before.value);
    }
    return bar;
}

double MeasuredTorque::level_bar(const WholeCycle &cycle, const Eigen::VectorXd &recorded, double offset_rad) const {
    if (!std::isfinite(cycle.intake_bar)) return compression_level_bar(engine_, recorded, offset_rad);
    double sum = 0;
    int count = 0;
    for (int i = 0; i < kGridPoints; ++i) {
        if (std::abs(grid_deg(i) + offset_rad / kRad - kBottomDeg) > kBottomHalfDeg) continue;
        sum += recorded(i), ++count;
    }
    return cycle.intake_bar - sum / count;
}

std::pair<Eigen::Index, double> MeasuredTorque::same_place(int i, std::size_t lane) const {
    // The cylinder's own cycle begins again where the grid ends.
    const double place = std::fmod(grid_deg(i) - tdc_deg(lane) + 360 + 720, 720) / kGridDeg;
    const auto point = std::min<Eigen::Index>(Eigen::Index(place), kGridPoints - 2);
    return {point, place - double(point)};
}

GasTorque::Nm MeasuredTorque::gas_nm(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const {
    const double newton_per_bar = M_PI / 4 * engine_.bore_m * engine_.bore_m * kPascal, offset = values(wheel_offset);
    const Eigen::VectorXd recorded = recorded_bar(grid_s);
    const double level = level_bar(cycle, recorded, offset) + values(kLevel) - kCrankcase_bar;
    const Arms &at = arms(offset);
    Nm nm{Eigen::VectorXd::Zero(kGridPoints), Eigen::MatrixXd::Zero(kGridPoints, values.size())};
    for (Eigen::Index lane = 0; lane < engine_.cylinders(); ++lane) {
        const Eigen::Index own = kFirstFactor + lane - 1;
        const double factor = newton_per_bar * (lane == 0 ? 1 : 1 + values(own));
        for (int i = 0; i < kGridPoints; ++i) {
            const auto [point, share] = same_place(i, std::size_t(lane));
            const double bar = recorded(point) + share * (recorded(point + 1) - recorded(point)) + level;
            nm.gas(i) += factor * bar * at.arm(i, lane);
            nm.slope(i, wheel_offset) += factor * bar * at.bend(i, lane);
            nm.slope(i, kLevel) += factor * at.arm(i, lane);
            if (lane > 0) nm.slope(i, own) += newton_per_bar * bar * at.arm(i, lane);
        }
    }
    nm.slope.col(kGain) = nm.gas;
    nm.gas *= 1 + values(kGain);
    return nm;
}

} // namespace sixdeg
