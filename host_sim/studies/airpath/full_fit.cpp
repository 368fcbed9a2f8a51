// SPDX-License-Identifier: MIT
#include "studies/airpath/full_fit.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <fmt/format.h>

#include "plant/airpath/full_model.hpp"

namespace sixdeg {
namespace {

constexpr double kAirR = 287, kGasR = 286;

/// One quantity at many points: `value` is what `curve(at)` should be, `weight` how much it says.
struct Points {
    std::vector<double> at, value, weight;
    void add(double x, double v, double w) { at.push_back(x), value.push_back(v), weight.push_back(w); }
};

/// Values at the knots of the piecewise straight curve with the least squares of weighted errors.
Profile fitted(const Points &points, const std::vector<double> &knots) {
    const auto n = Eigen::Index(knots.size());
    Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(n, n);
    Eigen::VectorXd right = Eigen::VectorXd::Zero(n);
    for (std::size_t i = 0; i < points.at.size(); ++i) {
        Eigen::VectorXd hat = Eigen::VectorXd::Zero(n);
        for (Eigen::Index k = 0; k < n; ++k) {
            std::vector<double> unit(knots.size(), 0);
            unit[std::size_t(k)] = 1;
            hat[k] = Profile(knots, unit).at(points.at[i]);
        }
        normal += points.weight[i] * points.weight[i] * hat * hat.transpose();
        right += points.weight[i] * points.weight[i] * points.value[i] * hat;
    }
    const Eigen::VectorXd solved = normal.ldlt().solve(right);
    return Profile(knots, {solved.data(), solved.data() + n});
}

/// Root of the mean square of the flow's relative error that the curve leaves.
double rest_percent(const Points &points, const Profile &curve) {
    double sum = 0;
    for (std::size_t i = 0; i < points.at.size(); ++i) {
        const double e = curve.at(points.at[i]) / points.value[i] - 1;
        sum += e * e;
    }
    return 100 * std::sqrt(sum / double(points.at.size()));
}

struct Found {
    Points efficiency, egr, turbine;
};

/// The laws of document 001's model, solved for what they multiply.
void add_point(const airpath::FullModel &model, const airpath::Drive &drive, double displacement_m3, Found &found) {
    const airpath::Flows &f = model.flows();
    const double rpm = drive.speed_radps * 30 / kPi, exhaust = f.exhaust_pa / std::sqrt(kGasR * f.exhaust_k);
    const double drawn = displacement_m3 * drive.speed_radps / (4 * kPi) * f.intake_pa;
    found.efficiency.add(rpm, (kAirR * f.charge_k * f.charge_kgps + kGasR * model.state().egr_k * f.egr_kgps) / drawn, 1);
    const double open = 1 - std::min(f.intake_pa / f.exhaust_pa, 1.0), share = std::max(1 - open / 0.35, 0.0);
    const double egr_per_m2 = exhaust * (1 - share * share);
    if (drive.egr > 0 && open > 0.03) found.egr.add(drive.egr, f.egr_kgps / egr_per_m2, egr_per_m2);
    const double turbine_per_m2 = exhaust * 0.762 * std::sqrt(1 - std::pow(model.data().ambient_pa / f.exhaust_pa, 2.89));
    found.turbine.add(drive.vgt, f.turbine_kgps / turbine_per_m2, turbine_per_m2);
}

Found measure(const PlantEngine &engine) {
    Found found;
    for (double rpm : {1000., 1250., 1500., 1750., 2000.})
        for (double fuel_mg : {40., 60., 80.})
            for (double egr : {0.1, 0.2, 0.35, 0.5})
                for (double vgt : {0.3, 0.44, 0.6}) {
                    airpath::FullModel model(*engine.air_path, engine.displacement_m3(), engine.shared.compression_ratio);
                    airpath::Drive drive;
                    drive.speed_radps = rpm * kRadpsPerRpm;
                    drive.fuel_kgps = 1e-6 * fuel_mg * engine.shared.cylinders() * rpm / 120;
                    drive.egr = egr, drive.vgt = vgt;
                    model.start(drive);
                    add_point(model, drive, engine.displacement_m3(), found);
                }
    return found;
}

std::string line(const char *field, const std::vector<double> &values, double factor, int digits) {
    std::string out = fmt::format("{} = [", field);
    for (std::size_t i = 0; i < values.size(); ++i) out += fmt::format("{}{:.{}f}", i ? ", " : "", values[i] * factor, digits);
    return out + "]\n";
}

} // namespace

std::string fit_air_path(const PlantEngine &engine) {
    Found found = measure(engine);
    const Profile efficiency = fitted(found.efficiency, {1000, 1250, 1500, 1750, 2000});
    const double shut = 0; // a shut valve is tight, on every bench
    for (int i = 0; i < 4; ++i) found.egr.add(0, shut, 1e6);
    const Profile egr = fitted(found.egr, {0, 0.1, 0.2, 0.35, 0.5}), turbine = fitted(found.turbine, {0.3, 0.44, 0.6});
    found.egr.at.resize(found.egr.at.size() - 4);
    return line("efficiency_rpm", efficiency.x(), 1, 0) + line("volumetric_efficiency", efficiency.value(), 1, 4) +
           line("egr_opening", egr.x(), 1, 2) + line("egr_area_mm2", egr.value(), 1e6, 1) +
           line("turbine_position", turbine.x(), 1, 2) + line("turbine_area_mm2", turbine.value(), 1e6, 1) +
           fmt::format("rest: efficiency {:.2f} %, EGR area {:.2f} %, turbine area {:.2f} %, rms of {} points\n",
                       rest_percent(found.efficiency, efficiency), rest_percent(found.egr, egr), rest_percent(found.turbine, turbine),
                       found.turbine.at.size());
}

} // namespace sixdeg
