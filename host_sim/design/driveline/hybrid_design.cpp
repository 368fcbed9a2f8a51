// SPDX-License-Identifier: MIT
#include "design/driveline/hybrid_design.hpp"

#include <Eigen/Geometry>
#include <limits>

#include "linalg/linalg.hpp"

namespace sixdeg {
namespace {

using Eigen::Matrix3d;
using Eigen::RowVector3d;
using Eigen::Vector3d;
using linalg::MatrixXd;

constexpr double kRpmPerRadps = 30 / 3.14159265358979323846;

double norm2(const MatrixXd &m) { return linalg::singular_values(m)(0); }

Matrix3d solved(const Matrix3d &a, const Matrix3d &b) { return linalg::solve(a, b); }

/// Over h, with E and u held and y straight: blocks of one exponential.
sd_driveline_map_t sampled(const Matrix3d &a, const LocationModel &model, const Vector3d &gain, double h) {
    MatrixXd g(3, 4);
    g << model.e, model.b, gain, model.d;
    MatrixXd all = MatrixXd::Zero(11, 11);
    all.block(0, 0, 3, 3) = a * h;
    all.block(0, 3, 3, 4) = g * h;
    all.block(3, 7, 4, 4) = MatrixXd::Identity(4, 4);
    const MatrixXd e = linalg::exponential(all);
    const MatrixXd held = e.block(0, 3, 3, 4), risen = e.block(0, 7, 3, 4); // for v = 1, and for v = t / h
    sd_driveline_map_t map;
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) map.by_state[i][j] = float(e(i, j));
        map.constant[i] = float(held(i, 0));
        map.by_torque[i] = float(held(i, 1));
        map.by_road[i] = float(held(i, 3));
        map.by_speed[0][i] = float(held(i, 2) - risen(i, 2));
        map.by_speed[1][i] = float(risen(i, 2));
    }
    return map;
}

} // namespace

LocationModel location_model(const Driveline &d, double ratio, double equilibrium_rad, Location location) {
    LocationModel m;
    const double je = d.engine_inertia_kgm2, jv = d.vehicle_inertia_kgm2;
    const double stiffness = location == 2 ? d.soft_nmprad : d.stiff_nmprad;
    const Vector3d shaft(0, -ratio / je, 1 / jv);
    m.a << 0, ratio, -1, 0, -d.engine_viscous_nms / je, 0, 0, 0, 0;
    m.a += shaft * RowVector3d(stiffness, d.damping_nms * ratio, -d.damping_nms);
    // What the spring gives at the equilibrium's torsion by this location's law, less what it gives there in truth.
    m.e = shaft * (d.spring_nm(equilibrium_rad, location) - d.spring_nm(equilibrium_rad));
    m.b = Vector3d(0, 1 / je, 0);
    m.d = Vector3d(0, 0, -1 / jv);
    m.c = RowVector3d(0, kRpmPerRadps, 0);
    return m;
}

Vector3d observer_gain(const LocationModel &m, const Vector3d &poles) {
    Matrix3d seen;
    seen << m.c, m.c * m.a, m.c * m.a * m.a;
    Matrix3d p = Matrix3d::Identity();
    for (int i = 0; i < 3; ++i) p *= m.a - poles(i) * Matrix3d::Identity();
    return p * linalg::solve(seen, Vector3d(0, 0, 1));
}

sd_driveline_bank_t hybrid_tables(const Driveline &driveline, double ratio, const HybridBelief &b) {
    sd_driveline_bank_t bank{};
    bank.period_s = float(b.period_s);
    bank.threshold_rpm = float(b.threshold_rpm);
    bank.rpm_per_radps = float(kRpmPerRadps);
    bank.middle_rad = float(-b.equilibrium_rad);
    bank.hold_s = float(b.hold_s);
    bank.calm_s = float(b.calm_s);
    bank.settle_s = float(b.settle_s);
    bank.ratio = b.at_rest ? float(ratio) : 0;
    for (Location q = 1; q <= 3; ++q) {
        const LocationModel m = location_model(driveline, ratio, b.equilibrium_rad, q);
        const Vector3d l = observer_gain(m, b.residual_poles), g = observer_gain(m, b.observer_poles);
        bank.residual[q - 1] = sampled(m.a - l * m.c, m, l, b.period_s);
        bank.observer[q - 1] = sampled(m.a - g * m.c, m, g, b.period_s);
    }
    return bank;
}

double eigenvector_condition(const Matrix3d &a) {
    const linalg::VectorXcd values = linalg::eigenvalues(a);
    Matrix3d vectors;
    for (int i = 0; i < 3; ++i) {
        const Matrix3d rest = a - values(i).real() * Matrix3d::Identity();
        const Vector3d rows[3] = {rest.row(0), rest.row(1), rest.row(2)};
        Vector3d best = Vector3d::Zero(); // what no row sees
        for (const auto &[p, q] : {std::pair{0, 1}, {0, 2}, {1, 2}}) {
            const Vector3d across = rows[p].cross(rows[q]);
            if (across.norm() > best.norm()) best = across;
        }
        vectors.col(i) = best.normalized();
    }
    return norm2(vectors) * norm2(solved(vectors, Matrix3d::Identity()));
}

ResidualSpeed residual_speed(const Matrix3d &h, const RowVector3d &c, double delay_s, double first_error, double threshold) {
    const double condition = eigenvector_condition(h);
    return {linalg::eigenvalues(h).real().maxCoeff(), std::log(threshold / (3 * c.norm() * condition * first_error)) / delay_s, condition};
}

std::optional<int> hiding_order(const LocationModel &real, const LocationModel &believed, const Vector3d &gain) {
    const Matrix3d h = believed.a - gain * believed.c, difference = believed.a - real.a;
    for (int order = 2; order <= 6; ++order) { // C B_ji + C_ji B_i, the document's, is 0
        Matrix3d through = Matrix3d::Identity();
        double sum = 0, size = 0;
        for (int p = 0; p <= order - 2; ++p) {
            Matrix3d before = Matrix3d::Identity();
            for (int q = 0; q < order - 2 - p; ++q) before *= real.a;
            const double part = believed.c * through * difference * before * real.b;
            sum += part;
            size += std::abs(part);
            through *= h;
        }
        if (std::abs(sum) > 1e-12 * std::max(size, 1e-12)) return order;
    }
    return std::nullopt;
}

ErrorBound error_bound(const Matrix3d &f, double dwell_s, double delay_s, double drive) {
    const double nk = 3 * eigenvector_condition(f), abscissa = linalg::eigenvalues(f).real().maxCoeff();
    ErrorBound bound{nk * std::exp(abscissa * dwell_s), std::nullopt};
    if (bound.contraction < 1) bound.bound = nk * drive * delay_s / (1 - bound.contraction);
    return bound;
}

double printed_bound(const Matrix3d &f, double dwell_s, double delay_s, double drive) {
    const double abscissa = linalg::eigenvalues(f).real().maxCoeff();
    return 3 * eigenvector_condition(f) * drive * delay_s / (1 - std::exp(abscissa * dwell_s));
}

namespace {

/// P = R' R, R upper triangular, in coordinates in which the states are of one size.
struct CommonNorm {
    std::vector<Matrix3d> f;
    Vector3d push;
    double decay;

    static Matrix3d triangle(const Eigen::VectorXd &x) {
        Matrix3d r;
        r << std::exp(x(0)), x(3), x(4), 0, std::exp(x(1)), x(5), 0, 0, std::exp(x(2));
        return r;
    }
    /// Bound of the torsion for a unit push, plus a penalty where a location decays more slowly than wanted.
    double operator()(const Eigen::VectorXd &x) const {
        const Matrix3d r = triangle(x), inverse = solved(r, Matrix3d::Identity());
        double worst = -std::numeric_limits<double>::infinity();
        for (const Matrix3d &each : f) {
            const Matrix3d seen = r * each * inverse, symmetric = (seen + seen.transpose()) / 2;
            worst = std::max(worst, linalg::eigenvalues(symmetric).real().maxCoeff() + decay);
        }
        return std::log((r * push).norm() * inverse.row(0).norm()) + (worst > 0 ? 10 + worst : 0);
    }
};

/// Nelder and Mead's simplex.
template <class F> Eigen::VectorXd lowest(const F &value, const Eigen::VectorXd &start, double size, int steps) {
    const int n = int(start.size());
    std::vector<std::pair<double, Eigen::VectorXd>> at;
    for (int i = 0; i <= n; ++i) {
        Eigen::VectorXd x = start;
        if (i > 0) x(i - 1) += size;
        at.push_back({value(x), x});
    }
    const auto lower = [](const auto &a, const auto &b) { return a.first < b.first; };
    for (int k = 0; k < steps; ++k) {
        std::sort(at.begin(), at.end(), lower);
        Eigen::VectorXd middle = Eigen::VectorXd::Zero(n);
        for (int i = 0; i < n; ++i) middle += at[std::size_t(i)].second / n;
        const auto along = [&](double s) {
            const Eigen::VectorXd x = middle + s * (at.back().second - middle);
            return std::pair{value(x), x};
        };
        auto next = along(-1);
        if (next.first < at.front().first) next = std::min(next, along(-2), lower);
        else if (next.first >= at[std::size_t(n - 1)].first) next = std::min(along(-0.5), along(0.5), lower);
        if (next.first < at.back().first) {
            at.back() = next;
            continue;
        }
        for (int i = 1; i <= n; ++i) {
            Eigen::VectorXd x = (at[std::size_t(i)].second + at[0].second) / 2;
            at[std::size_t(i)] = {value(x), x};
        }
    }
    return std::min_element(at.begin(), at.end(), lower)->second;
}

} // namespace

std::optional<double> common_bound_rad(const std::vector<Matrix3d> &f, const Vector3d &push, double largest_nm, double decay,
                                       double dwell_s, double delay_s) {
    const Vector3d size(0.01, 1, 0.1);
    CommonNorm norm{{}, push.cwiseQuotient(size), decay};
    for (const Matrix3d &each : f) norm.f.push_back(size.cwiseInverse().asDiagonal() * each * size.asDiagonal());
    Eigen::VectorXd best = Eigen::VectorXd::Zero(6);
    for (double step : {1.0, 0.5, 0.3, 0.2, 0.1, 0.1, 0.05}) best = lowest(norm, best, step, 1500);
    const double value = norm(best);
    if (value > 8) return std::nullopt; // the penalty is in it: a bound of exp(8) of these units is none either
    return size(0) * std::exp(value) * largest_nm * delay_s / (1 - std::exp(-decay * dwell_s));
}

} // namespace sixdeg
