// SPDX-License-Identifier: MIT
// An interacting-multiple-model filter of the driveline, for comparison: three Kalman filters, one a location, whose chances of a change
// come from where each believes the torsion to be. With covariances of its own; it shares nothing with the firmware.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cmath>

#include "common/driveline.hpp"

namespace sixdeg {

class ImmFilter {
  public:
    using Vector = Eigen::Matrix<double, 5, 1>; // phase, speed, torsion, wheels, bias
    using Matrix = Eigen::Matrix<double, 5, 5>;

    ImmFilter(const Driveline &driveline, double jitter_rad, double speed_radps, double shaft_nm) : d_(driveline),
        r_(jitter_rad * jitter_rad) {
        for (Model &m : models_) {
            m.x << 0, speed_radps, d_.twist_rad(shaft_nm), d_.ratios[0] * speed_radps, 0;
            m.p = Vector(1e-6, 0.1, 1e-5, 0.01, 1).asDiagonal();
        }
    }

    /// h seconds later a tooth comes, `turned` rad behind the last one.
    void step(double h, double turned, double torque_nm) {
        mix();
        double sum = 0;
        for (int j = 0; j < 3; ++j) {
            Model &m = models_[std::size_t(j)];
            predict(m, j + 1, h, turned, torque_nm);
            const double late = -m.x(0), s = m.p(0, 0) + r_;
            const Vector k = m.p.col(0) / s;
            m.x += k * late;
            m.p -= (k * m.p.row(0)).eval();
            m.chance = std::max(m.chance * std::exp(-late * late / (2 * s)) / std::sqrt(s), 1e-300);
            sum += m.chance;
        }
        twist_ = 0;
        for (Model &m : models_) {
            m.chance /= sum;
            twist_ += m.chance * m.x(2);
        }
    }
    double twist_rad() const { return twist_; }
    Location location() const {
        int best = 0;
        for (int j = 1; j < 3; ++j) best = models_[std::size_t(j)].chance > models_[std::size_t(best)].chance ? j : best;
        return best + 1;
    }

  private:
    struct Model {
        Vector x;
        Matrix p;
        double chance = 1.0 / 3;
    };
    /// Chance that the torsion lies beyond a place.
    static double beyond(double mean, double variance, double place) { return 0.5 * std::erfc((place - mean) / std::sqrt(2 * variance)); }

    void mix() {
        std::array<Model, 3> mixed;
        for (Model &m : mixed) m = {Vector::Zero(), Matrix::Zero(), 0};
        Eigen::Matrix3d weight;
        for (int i = 0; i < 3; ++i) {
            const Model &m = models_[std::size_t(i)];
            const double high = beyond(m.x(2), m.p(2, 2), d_.kink_rad), low = 1 - beyond(m.x(2), m.p(2, 2), -d_.kink_rad);
            Eigen::Vector3d to(low, 1 - low - high, high);
            to = 0.98 * to + 0.02 * Eigen::Vector3d::Unit(i);
            weight.row(i) = m.chance * to.transpose();
        }
        for (int j = 0; j < 3; ++j) {
            Model &m = mixed[std::size_t(j)];
            m.chance = weight.col(j).sum() + 1e-12;
            for (int i = 0; i < 3; ++i) m.x += (weight(i, j) + 1e-12 / 3) / m.chance * models_[std::size_t(i)].x;
            for (int i = 0; i < 3; ++i) {
                const Vector off = models_[std::size_t(i)].x - m.x;
                m.p += (weight(i, j) + 1e-12 / 3) / m.chance * (models_[std::size_t(i)].p + off * off.transpose());
            }
        }
        models_ = mixed;
    }

    void predict(Model &m, Location at, double h, double turned, double torque_nm) {
        const double je = d_.engine_inertia_kgm2, jv = d_.vehicle_inertia_kgm2, ratio = d_.ratios[0], b = d_.damping_nms;
        const double k = at == 2 ? d_.soft_nmprad : d_.stiff_nmprad, constant = d_.spring_nm(0, at);
        Matrix a = Matrix::Zero();
        a(0, 1) = 1;
        a.row(1) << 0, -(d_.engine_viscous_nms + ratio * ratio * b) / je, -ratio * k / je, ratio * b / je, 1 / je;
        a.row(2) << 0, ratio, 0, -1, 0;
        a.row(3) << 0, ratio * b / jv, k / jv, -b / jv, 0;
        Vector u;
        u << 0, (torque_nm - ratio * constant) / je, 0, (constant - d_.road_nm(m.x(3))) / jv, 0;
        const Matrix ah = a * h, f = Matrix::Identity() + ah + ah * ah / 2 + ah * ah * ah / 6;
        m.x = f * m.x + (Matrix::Identity() + ah / 2) * u * h;
        m.x(0) -= turned;
        m.p = (f * m.p * f.transpose()).eval();
        const Vector walk(0, std::pow(0.02 / je, 2), 1e-10, 4e-4, 1);
        m.p.diagonal() += h * walk;
    }

    Driveline d_;
    double r_, twist_ = 0;
    std::array<Model, 3> models_;
};

} // namespace sixdeg
