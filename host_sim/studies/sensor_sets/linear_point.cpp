// SPDX-License-Identifier: MIT
#include "studies/sensor_sets/linear_point.hpp"

#include <algorithm>
#include <bitset>
#include <cmath>
#include <fmt/format.h>

#include "studies/sensor_sets/turbo_si.hpp"

namespace sixdeg {
namespace {

Eigen::VectorXd by_state(TomlFile &file, const std::string &table, const SensorModel &model) {
    Eigen::VectorXd values(Eigen::Index(model.states.size()));
    for (std::size_t i = 0; i < model.states.size(); ++i) {
        values[Eigen::Index(i)] = file.number(table + "." + model.states[i], {1e-9, 1e9, "SI"});
    }
    return values;
}

Eigen::MatrixXd matrix(TomlFile &file, const std::string &field, Eigen::Index rows, Eigen::Index columns) {
    const auto flat = file.numbers(field, {-1e15, 1e15, "SI"}, std::size_t(rows * columns));
    return Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
        flat.data(), rows, columns);
}

LinearPoint read_jacobian(TomlFile &file, const std::string &entry, const SensorModel &model) {
    const auto n = Eigen::Index(model.states.size()), m = Eigen::Index(model.sensors.size());
    return {file.text(entry + "name"),
            file.text_or(entry + "regime", model.regimes.front().name),
            matrix(file, entry + "a", n, n),
            matrix(file, entry + "c", m, n),
            {}};
}

TurboSiInputs read_engine_point(TomlFile &file, const std::string &entry) {
    TurboSiInputs inputs;
    inputs.speed_radps = file.number(entry + "speed_rpm", {500, 8000, "rpm"}) * (M_PI / 30);
    inputs.throttle_rad = file.number(entry + "throttle_deg", {4, 90, "deg"}) * (M_PI / 180);
    inputs.wastegate = file.number(entry + "wastegate", {0, 1, ""});
    inputs.lambda = file.number_or(entry + "lambda", {0.7, 1.5, ""}, inputs.lambda);
    inputs.ambient_pa = file.number_or(entry + "ambient_pa", {5e4, 1.2e5, "Pa"}, inputs.ambient_pa);
    inputs.ambient_k = file.number_or(entry + "ambient_k", {230, 330, "K"}, inputs.ambient_k);
    return inputs;
}

void check_regime(TomlFile &file, const std::string &entry, const LinearPoint &point,
                  const SensorModel &model) {
    for (const auto &regime : model.regimes) {
        if (regime.name == point.regime) return;
    }
    file.fail(entry + "regime", "'" + point.regime + "' is not a regime of the model");
}

} // namespace

NumericModel read_numeric_model(TomlFile &file, const SensorModel &model) {
    NumericModel numeric;
    if (!file.has("numeric")) return numeric;
    numeric.step_s = file.number_or("numeric.step_s", {1e-6, 10, "s"}, numeric.step_s);
    numeric.scale = by_state(file, "numeric.scale", model);
    numeric.process_noise = by_state(file, "numeric.process_noise", model);
    for (const auto &sensor : model.sensors) {
        if (sensor.noise == 0)
            file.fail("sensors." + sensor.name + ".noise", "is missing; a model with \"numeric\" needs it");
    }
    for (std::size_t i = 0; i < file.array_size("numeric.jacobians"); ++i) {
        const std::string entry = fmt::format("numeric.jacobians[{}].", i);
        numeric.points.push_back(read_jacobian(file, entry, model));
        check_regime(file, entry, numeric.points.back(), model);
    }
    for (std::size_t i = 0; i < file.array_size("numeric.turbo_si_points"); ++i) {
        const std::string entry = fmt::format("numeric.turbo_si_points[{}].", i);
        if (!turbo_si_fits(model))
            file.fail(entry + "name", "needs the states, sensors and regimes of turbo_si_13.toml");
        auto point = turbo_si_point(read_engine_point(file, entry));
        point.name = file.text(entry + "name");
        numeric.points.push_back(std::move(point));
    }
    if (numeric.points.empty()) file.fail("numeric", "has neither jacobians nor turbo_si_points");
    return numeric;
}

Augmented augment(const SensorModel &model, const LinearPoint &point, const Eigen::VectorXd &scale,
                  SensorSet set) {
    Eigen::Index states = point.a.rows();
    for (std::size_t i = 0; i < model.sensors.size(); ++i) {
        if (set >> i & 1) states += Eigen::Index(model.sensors[i].lags_s.size());
    }
    Augmented all{Eigen::MatrixXd::Zero(states, states),
                  Eigen::MatrixXd::Zero(Eigen::Index(std::bitset<32>(set).count()), states),
                  Eigen::VectorXd(states)};
    const Eigen::Index n = point.a.rows();
    all.a.topLeftCorner(n, n) = point.a;
    all.scale.head(n) = scale;
    Eigen::Index own = n, row = 0;
    for (std::size_t i = 0; i < model.sensors.size(); ++i) {
        if (!(set >> i & 1)) continue;
        Eigen::RowVectorXd seen = Eigen::RowVectorXd::Zero(states);
        seen.head(n) = point.c.row(Eigen::Index(i));
        const double size = (seen.head(n).transpose().array() * scale.array()).abs().maxCoeff();
        for (const double lag_s : model.sensors[i].lags_s) {
            all.a.row(own) = seen / lag_s;
            all.a(own, own) -= 1 / lag_s;
            all.scale[own] = size > 0 ? size : 1;
            seen.setZero();
            seen[own++] = 1;
        }
        all.c.row(row++) = seen;
    }
    return all;
}

} // namespace sixdeg
