// SPDX-License-Identifier: MIT
#include <cmath>

#include "design/torque/pulse.hpp"
#include "identify/gas_torque.hpp"

namespace sixdeg {
namespace {

constexpr double kRad = M_PI / 180;
// What engines are: gamma of the charge about that of the model's dry air, wall loss about Hohenberg's (simulated engines lose 0 to 4
// times as much, published correlations differ by half), a data sheet's compression ratio, what of the pumping is not known.
constexpr double kExponentMean = -0.03, kExponentSd = 0.03, kWallMean = 1.5, kWallSd = 1.0, kCompressionSd = 0.012, kExchangeSd = 0.5,
    kWallPowerSd = 0.3;
constexpr double kFactorSd = 0.015, kLeastUnexplained = 0.006;
constexpr double kUsualSpeed = 200; // rad/s, at which the wall loss is what it is
constexpr double kSpeedStep = 0.05; // speeds so near share a table

} // namespace

CompressionTorque::CompressionTorque(const EngineFile &engine) : GasTorque(engine, kLeastUnexplained) {
    unknowns_.push_back({"exponent", kExponentMean, kExponentSd, kExponentSd});
    unknowns_.push_back({"wall loss", kWallMean, kWallSd, kWallSd});
    unknowns_.push_back({"compression ratio", 0, kCompressionSd, kCompressionSd});
    unknowns_.push_back({"wall loss over speed", 0, kWallPowerSd, kWallPowerSd});
    unknowns_.push_back({"gas exchange", 0, kExchangeSd, kExchangeSd});
    for (int lane = 0; lane < engine.cylinders(); ++lane) unknowns_.push_back({"cylinder factor", 0, kFactorSd, kFactorSd});
    add_unexplained();
}

CompressionTorque::Tables CompressionTorque::model(double speed_radps, const Eigen::Vector4d &moved) const {
    EngineFile engine = engine_;
    engine.compression_factors.clear();
    engine.compression_ratio *= 1 + moved(2);
    PulseConditions at;
    at.intake_bar = 0.8;
    at.speed_radps = speed_radps;
    at.exponent = moved(0);
    at.wall_factor = std::fmax(moved(1), 0) * std::pow(speed_radps / kUsualSpeed, moved(3));
    const CylinderPulse pulse = cylinder_pulse(engine, 0, at);
    return {pulse.motored_per_bar, pulse.motored_rest};
}

const CompressionTorque::At &CompressionTorque::tables(double speed_radps, const Eigen::VectorXd &values) const {
    const Eigen::Vector4d moved = values.segment<kModelled>(exponent);
    if (kept_for_.size() != kModelled || (kept_for_ - moved).norm() > 0) kept_.clear(), kept_for_ = moved;
    const int step = int(std::lround(std::log(speed_radps) / kSpeedStep));
    const auto found = kept_.find(step);
    if (found != kept_.end()) return found->second;
    const double speed = std::exp(step * kSpeedStep);
    At at{model(speed, moved), {}};
    const double change[] = {0.005, 0.1, 0.005, 0.05};
    for (int q = 0; q < kModelled; ++q) {
        Eigen::Vector4d other = moved;
        other(q) += change[q];
        Tables slope = model(speed, other);
        for (std::size_t k = 0; k < slope.per_bar.size(); ++k) {
            slope.per_bar[k] = (slope.per_bar[k] - at.base.per_bar[k]) / change[q];
            slope.rest[k] = (slope.rest[k] - at.base.rest[k]) / change[q];
        }
        at.moved.push_back(std::move(slope));
    }
    return kept_.emplace(step, std::move(at)).first->second;
}

GasTorque::Nm CompressionTorque::gas_nm(const WholeCycle &cycle, const Eigen::VectorXd &, const Eigen::VectorXd &values) const {
    const At &at = tables(cycle.speed_radps, values);
    const double bar = std::isfinite(cycle.intake_bar) ? cycle.intake_bar : 1, offset = values(wheel_offset), step = 0.25 * kRad;
    const double exchanged = 1 + values(exchange);
    Nm nm{Eigen::VectorXd::Zero(kGridPoints), Eigen::MatrixXd::Zero(kGridPoints, values.size())};
    for (std::size_t lane = 0; lane < std::size_t(engine_.cylinders()); ++lane) {
        const Eigen::Index own = first_factor + Eigen::Index(lane);
        const double factor = 1 + values(own);
        for (int i = 0; i < kGridPoints; ++i) {
            const double angle = (grid_deg(i) - tdc_deg(lane)) * kRad + offset;
            const auto torque = [&](const Tables &tables, double a) {
                return factor * bar * pulse_at(tables.per_bar, a) + exchanged * pulse_at(tables.rest, a);
            };
            nm.gas(i) += torque(at.base, angle);
            nm.slope(i, wheel_offset) += (torque(at.base, angle + step) - torque(at.base, angle - step)) / (2 * step);
            for (int q = 0; q < kModelled; ++q) nm.slope(i, exponent + q) += torque(at.moved[std::size_t(q)], angle);
            nm.slope(i, exchange) += pulse_at(at.base.rest, angle);
            nm.slope(i, own) += bar * pulse_at(at.base.per_bar, angle);
        }
    }
    return nm;
}

} // namespace sixdeg
