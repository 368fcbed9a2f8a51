// SPDX-License-Identifier: MIT
// The Cramer-Rao bound against a least-squares problem written out, and against the filter it bounds.

#include "linalg/linalg.hpp"
#include "studies/limits/firing_bound.hpp"
#include "support/kalman_bench.hpp"

namespace sixdeg {
namespace {

using namespace test;

constexpr double kSpeed = 314; // rad/s

/// Every edge of `cycles` as a row: how its lateness depends on all unknowns, found by moving each of them. Firings of
/// different cycles are unknowns of their own. Teeth's own errors come last.
/// Steps of the load, one each quarter turn, stand behind them.
Eigen::MatrixXd rows(const ToothModel &model, int cycles, double edge_rad, double pattern_rad, double load_step) {
    const int firings = 3 + 4 * (cycles + 1), swings = firings + model.positions, steps = swings + 2 * int(model.modes.size());
    const int unknowns = steps + cycles * model.cycle() / 15;
    std::vector<Eigen::RowVectorXd> out;
    Eigen::RowVectorXd phi = Eigen::RowVectorXd::Zero(unknowns), eps = phi;
    phi(0) = 1, eps(1) = 1;
    std::vector<Eigen::RowVectorXd> twist(model.modes.size(), Eigen::RowVectorXd::Zero(unknowns)), rate = twist;
    for (std::size_t i = 0; i < model.modes.size(); ++i) twist[i](swings + 2 * int(i)) = rate[i](swings + 2 * int(i) + 1) = 1;
    std::vector<int> now{3, 4, 5, 6}; // which unknown each coefficient is at present
    int next = 7;
    std::vector<int> load{2}; // which unknowns add up to the constant
    for (int step = 0; step < cycles * model.cycle(); ++step) {
        const int k = step % model.cycle();
        const double d = model.pitch(), turn = d / model.inertia_ratio[std::size_t(k % model.positions)];
        phi -= turn * eps;
        for (int part : load) phi(part) -= turn * d * model.moment(k, 0), eps(part) += d * model.mean(k, 0);
        for (int i = 0; i < 4; ++i) {
            phi(now[std::size_t(i)]) -= turn * d * model.moment(k, 1 + i);
            eps(now[std::size_t(i)]) += d * model.mean(k, 1 + i);
        }
        for (std::size_t i = 0; i < model.modes.size(); ++i) { // exp of the 2 x 2 matrix written out, over the twist held
            const ToothMode &mode = model.modes[i];
            Eigen::RowVectorXd held = Eigen::RowVectorXd::Zero(unknowns);
            for (int part : load) held(part) = mode.compliance(0) * model.mean(k, 0);
            for (int f = 0; f < 4; ++f) held(now[std::size_t(f)]) += mode.compliance(1 + f) * model.mean(k, 1 + f);
            const Eigen::RowVectorXd away = twist[i] - held, before = rate[i];
            twist[i] = held + mode.a * away + mode.b * before;
            rate[i] = (mode.a - 2 * mode.damping * mode.b) * before - mode.b * away;
        }
        if (model.present[std::size_t(k % model.positions)]) {
            Eigen::RowVectorXd seen = phi;
            for (const Eigen::RowVectorXd &q : twist) seen -= q;
            out.push_back(seen / edge_rad);
            out.back()(firings + k % model.positions) = 1 / edge_rad;
        }
        for (int i = 0; i < 4; ++i) {
            if (model.inject_at[std::size_t(i)] == k) now[std::size_t(i)] = next++;
        }
        if (step % 15 == 14) load.push_back(steps + step / 15);
    }
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(int(out.size()) + unknowns, unknowns);
    for (std::size_t i = 0; i < out.size(); ++i) all.row(int(i)) = out[i];
    for (int i = 0; i < unknowns; ++i) all(int(out.size()) + i, i) = i >= steps ? 1 / load_step : i < firings ||
        i >= swings ? 1e-2 : 1 / pattern_rad;
    return all;
}

void expect_least_squares(const EngineFile &engine, double walk = 1e-7) {
    const ToothModel model = tooth_model(engine, known_torque(), kSpeed);
    const int cycles = 4;
    const double edge = 2e-4, pattern = 3e-4;
    const Eigen::MatrixXd all = rows(model, cycles, edge, pattern, walk * std::sqrt(15.0));
    const Eigen::MatrixXd variance = linalg::solve_symmetric(all.transpose() * all, Eigen::MatrixXd::Identity(all.cols(), all.cols()));
    // The firings read in the last cycle: which unknowns they are follows from the order of injections.
    std::vector<int> now{3, 4, 5, 6}, read(4);
    int next = 7;
    for (int step = 0; step < cycles * model.cycle(); ++step) {
        for (int i = 0; i < 4; ++i) {
            if (model.read_at[std::size_t(i)] == step % model.cycle()) read[std::size_t(i)] = now[std::size_t(i)];
            if (model.inject_at[std::size_t(i)] == step % model.cycle()) now[std::size_t(i)] = next++;
        }
    }
    Eigen::MatrixXd pick = Eigen::MatrixXd::Zero(4, all.cols());
    for (int i = 0; i < 4; ++i) {
        for (int j = 0; j < 4; ++j) pick(i, read[std::size_t(j)]) = (i == j) - 0.25;
    }
    const double expected = std::sqrt((pick * variance * pick.transpose()).trace() / 4);
    // Free steps from cycle to cycle make each firing an unknown of its own.
    EXPECT_NEAR(firing_bound(model, {edge, pattern, walk, 1e3}, 1, cycles) / expected, 1, 1e-3);
}

TEST(FiringBound, IsTheVarianceOfLeastSquaresWrittenOut) { expect_least_squares(engine_file()); }

TEST(FiringBound, TheSameWhereTheLoadWalks) { expect_least_squares(engine_file(), 2e-5); }

TEST(FiringBound, TheSameWhereTheCrankTwists) {
    EngineFile engine = engine_file();
    engine.torsion = CrankTorsion{4e5, 0.03, 0.02, 0.03, true};
    expect_least_squares(engine);
}

TEST(FiringBound, NoFilterIsBelowItAndOursIsNear) {
    const EngineFile engine = engine_file();
    const ToothModel model = tooth_model(engine, known_torque(), kSpeed);
    KalmanTune tune;
    tune.firing_torque_change_nm = 20; // so wide that it costs nothing: the deviations are of timing errors alone
    for (double rpm : {1000.0, 3000.0, 6000.0}) {
        const ToothNoise noise = tooth_noise(engine, tune, rpm * M_PI / 30);
        const PeriodicGains gains = design_gains(model, noise, 10);
        const double pattern = 0.002 * M_PI / 180;
        const double single = std::hypot(gains.single_sd * noise.edge_rad, gains.pattern_sd * pattern);
        const double mean = std::hypot(gains.mean_sd * noise.edge_rad, gains.pattern_sd * pattern);
        const BoundNoise constant{noise.edge_rad, pattern, 0, noise.firing_change};
        EXPECT_GT(single, firing_bound(model, constant, 1, 25)) << rpm;
        EXPECT_GT(mean, firing_bound(model, constant, 10, 25)) << rpm;
        EXPECT_LT(single, 6 * firing_bound(model, constant, 1, 25)) << rpm;
    }
}

} // namespace
} // namespace sixdeg
