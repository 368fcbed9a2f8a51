// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cmath>

#include "design/crank/slider_crank.hpp"
#include "identify/compression.hpp"
#include "identify/gas_torque.hpp"

namespace sixdeg {
namespace {

constexpr double kRad = M_PI / 180, kPascal = 1e5;
constexpr double kCrankcase_bar = 1.013;
constexpr double kLevelSd_bar = 0.1;  // of pegging and of the crankcase's pressure together
constexpr double kFactorSd = 0.02;    // of one cylinder's pressure against another's
constexpr double kBottomDeg = -180, kBottomHalfDeg = 10;
constexpr int kLevel = shared_unknowns, kFirstFactor = shared_unknowns + 1;

} // namespace

MeasuredTorque::MeasuredTorque(const EngineFile &engine, const std::vector<TimedValue> &pressure)
    : GasTorque(engine), pressure_(pressure) {
    unknowns_.push_back({"pressure level", 0, kLevelSd_bar, kLevelSd_bar});
    for (int lane = 1; lane < engine.cylinders(); ++lane) unknowns_.push_back({"cylinder factor", 0, kFactorSd, kFactorSd});
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

GasTorque::Nm MeasuredTorque::gas_nm(const WholeCycle &cycle, const Eigen::VectorXd &grid_s, const Eigen::VectorXd &values) const {
    const SliderCrank crank(engine_);
    const Eigen::VectorXd recorded = recorded_bar(grid_s);
    const double offset = values(wheel_offset), level = level_bar(cycle, recorded, offset) + values(kLevel) - kCrankcase_bar;
    const double step = 0.1 * kRad;
    Nm nm{Eigen::VectorXd::Zero(kGridPoints), Eigen::MatrixXd::Zero(kGridPoints, values.size())};
    for (std::size_t lane = 0; lane < std::size_t(engine_.cylinders()); ++lane) {
        const double factor = lane == 0 ? 1 : 1 + values(kFirstFactor + Eigen::Index(lane) - 1);
        for (int i = 0; i < kGridPoints; ++i) {
            // The same place of the other cylinder's own cycle, which begins again where the grid ends.
            double own_deg = std::fmod(grid_deg(i) - tdc_deg(lane) + 360 + 720, 720) - 360;
            const double at = (own_deg + 360) / kGridDeg;
            const auto point = std::min<Eigen::Index>(Eigen::Index(at), kGridPoints - 2);
            const double bar = recorded(point) + (at - double(point)) * (recorded(point + 1) - recorded(point)) + level;
            const double angle = own_deg * kRad + offset, arm = crank.volume_slope(angle) * kPascal;
            const double bend = (crank.volume_slope(angle + step) - crank.volume_slope(angle - step)) * kPascal / (2 * step);
            nm.gas(i) += factor * bar * arm;
            nm.slope(i, wheel_offset) += factor * bar * bend;
            nm.slope(i, kLevel) += factor * arm;
            if (lane > 0) nm.slope(i, kFirstFactor + Eigen::Index(lane) - 1) += bar * arm;
        }
    }
    return nm;
}

} // namespace sixdeg
