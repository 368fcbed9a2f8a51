// SPDX-License-Identifier: MIT
// The joint filter on the plant's exhaust and against a full one in double; the sensor's inversion.
#include <cstring>
#include <functional>
#include <gtest/gtest.h>

#include "design/calibration.hpp"
#include "common/random.hpp"
#include "linalg/linalg.hpp"
#include "support/afr_step.hpp"

using namespace sixdeg;

namespace {

/// Of four cylinders.
void joint_step(sd_afr_joint_t &f, sd_exhaust_now_f32_t now, float measured, const float *gains) {
    now.count = 0;
    for (int i = 0; i < 4; ++i)
        if (now.share[i] > 0) now.flowing[now.count++] = std::uint8_t(i);
    const sd_afr_inflow_t in = inflow(now);
    sd_afr_joint_step(&f, &in, measured, gains);
}

TEST(AfrModel, CalibrationsOwnExhaustIsNearThePlants) {
    const Step &s = step();
    double plant_kg = 0;
    for (std::size_t k = s.trace.mass_kg.size() - 1200; k < s.trace.mass_kg.size(); ++k)
        plant_kg += s.trace.mass_kg[k] / 1200;
    EXPECT_NEAR(s.point.mean_kg / plant_kg, 1, 0.04);
    double sum = 0;
    for (double share : s.point.share) sum += share;
    EXPECT_GT(sum, 0.9); // the rest fills the clearance
    EXPECT_LT(sum, 0.97);
}

/// A full Kalman filter in double that shares no code with the joint filter's; state x, a_i, s2, s1.
struct FullFilter {
    /// Covariance and state over the time that `step` describes.
    void move(const Eigen::MatrixXd &step) { p = step * p * step.transpose(); }
    void update(double error, double noise_var) {
        const Eigen::VectorXd gain = p.col(6) / (p(6, 6) + noise_var);
        x += gain * error;
        p = (p - gain * p.row(6)).eval();
    }
    Eigen::VectorXd x = Eigen::VectorXd::Constant(7, 0.5);
    Eigen::MatrixXd p = Eigen::MatrixXd::Identity(7, 7) * 0.01;
};

/// Row x of a position: what flows in is mixed in.
Eigen::MatrixXd mixing(const sd_exhaust_now_f32_t &now) {
    Eigen::MatrixXd m = Eigen::MatrixXd::Identity(7, 7);
    double flow = 0;
    for (int i = 0; i < 4; ++i) flow += m(0, 1 + i) = double(now.charge * now.share[i] / now.mass);
    m(0, 0) = 1 - flow;
    return m;
}

/// The lags follow x.
Eigen::MatrixXd lagging(double m2, double m1) {
    Eigen::MatrixXd second = Eigen::MatrixXd::Identity(7, 7), first = second;
    second(5, 5) = 1 - m2, second(5, 0) = m2;
    first(6, 6) = 1 - m1, first(6, 5) = m1;
    return first * second;
}

// The joint filter against a full one that takes in the same groups of samples; and what one that takes in every sample by
// itself, at its position, would state.
void structured_is_full(double dt, int group) {
    SCOPED_TRACE(group);
    sd_afr_joint_config_t c{4, 120, 0.03f, 0.015f, 2e-4f, 0.01f, 0.1f, 1000};
    sd_afr_joint_t f;
    must(sd_afr_joint_init(&f, &c));
    const double r = 4e-8 / (2 * dt), m2 = 1 - std::exp(-dt / 0.015), m1 = 1 - std::exp(-dt / 0.03);
    sd_afr_joint_set(&f, float(dt), 0.01f, 0);
    EXPECT_EQ(int(f.group), group);
    FullFilter grouped, single;
    Eigen::MatrixXd group_mixing = Eigen::MatrixXd::Identity(7, 7);
    double error = 0;
    int samples = 0;
    sd_exhaust_now_f32_t now{};
    now.charge = 0.1f;
    joint_step(f, now, 0.5f, nullptr); // starts
    for (int k = 0; k < 600; ++k) {
        now.mass = float(0.1 + 0.02 * std::sin(k * 0.21));
        for (int i = 0; i < 4; ++i) {
            const int since = (k + 120 - 30 * i) % 120;
            now.share[i] = since < 40 ? 0.025f : 0;
            if (since == 0 || (k == 0 && since < 40)) single.p(1 + i, 1 + i) += 1e-4, grouped.p(1 + i, 1 + i) += 1e-4;
        }
        const Eigen::MatrixXd step = lagging(m2, m1) * mixing(now);
        const double y = 0.5 + 0.05 * std::sin(k * 0.1);
        const bool seen = k % 7 != 3; // some samples are missing
        single.move(step);
        if (seen) single.update(0, r);
        grouped.x = step * grouped.x;
        group_mixing = mixing(now) * group_mixing;
        if (seen) error += y - grouped.x(6), ++samples;
        if (k % group == group - 1) {
            grouped.move(group_mixing * lagging(1 - std::pow(1 - m2, group), 1 - std::pow(1 - m1, group)));
            grouped.update(error / samples, r / samples);
            group_mixing.setIdentity(), error = 0, samples = 0;
        }
        joint_step(f, now, seen ? float(y) : 100.0f, nullptr);
    }
    const auto state = [&f](int i) { return double(i == 0 ? f.x : i < 5 ? f.air_fraction[i - 1] : i == 5 ? f.lag2 : f.lag1); };
    for (int i = 0; i < 7; ++i) {
        EXPECT_NEAR(state(i), grouped.x(i), 1e-3) << i;
        for (int j = 0; j <= i; ++j) {
            const double p = double(sd_afr_joint_covariance(&f, std::uint32_t(i), std::uint32_t(j)));
            EXPECT_EQ(p, double(sd_afr_joint_covariance(&f, std::uint32_t(j), std::uint32_t(i))));
            EXPECT_NEAR(p, grouped.p(i, j), 0.01 * std::sqrt(grouped.p(i, i) * grouped.p(j, j))) << i << j;
        }
    }
    for (int i = 1; i < 5; ++i) EXPECT_NEAR(std::sqrt(grouped.p(i, i) / single.p(i, i)), 1, 0.05) << i << ": single samples say no more";
}

TEST(AfrJoint, StructuredCovarianceIsTheFullOne) {
    structured_is_full(1e-3, SD_AFR_GROUP);
    structured_is_full(2e-4, 2 * SD_AFR_GROUP); // the sensor's lags are 225 positions
}

TEST(AfrJoint, TwoGroupsFitBetweenFirings) {
    const auto group = [](std::uint8_t cylinders, std::uint16_t cycle_positions) {
        const sd_afr_joint_config_t c{cylinders, cycle_positions, 0.03f, 0.015f, 2e-4f, 0.01f, 0.1f, 1000};
        sd_afr_joint_t f;
        must(sd_afr_joint_init(&f, &c));
        sd_afr_joint_set(&f, 2e-4f, 0.01f, 0);
        return int(f.group);
    };
    EXPECT_EQ(group(8, 120), 2 * SD_AFR_GROUP);
    EXPECT_EQ(group(6, 72), 2 * SD_AFR_GROUP);
    EXPECT_EQ(group(8, 72), SD_AFR_GROUP);
}

TEST(AfrJoint, SettlesInFourCyclesNearItsBoundAndStatesItsDeviation) {
    AfrSetup joint;
    joint.drift = 0.016 * step().mean;
    const AfrEstimates clean = step().run(joint);
    const std::size_t settled = step().at / 120 + 8;
    double square = 0, count = 0;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
        const AfrEstimates noisy = step().run(joint, sensor_noise(step().trace, 0.005, 0, seed));
        for (std::size_t c = settled; c < clean.lambda.size(); ++c) {
            for (std::size_t i = 0; i < 4; ++i)
                square += std::pow(noisy.lambda[c][i] - clean.lambda[c][i], 2), ++count;
        }
    }
    const double rms = std::sqrt(square / count),
                 bound = afr_bound(step().scenario.engine.shared, step().point, step().trace, 0.005, 4);
    EXPECT_LT(step().error_points(clean, 5), 2.5); // bias included
    EXPECT_LT(rms, 1.5 * bound);
    EXPECT_NEAR(clean.sd.back() / rms, 1, 0.45); // its own drift is part of it; the truth does not drift
}

// A calibration whose lags are off by up to 20 % and that says so: what is stated holds for it, too.
TEST(AfrJoint, StatesWhatAWrongCalibrationCosts) {
    AfrSetup joint;
    joint.mean_lambda = step().mean, joint.noise = 0.002;
    const std::size_t settled = step().at / 120 + 8;
    for (bool says_so : {false, true}) {
        if (says_so) joint.known.lag_sd = 0.115f;
        double square = 0, stated = 0;
        for (int draw = 0; draw < 11; ++draw) {
            joint.error.tau = -0.2 + 0.04 * draw;
            const AfrEstimates e = step().run(joint, sensor_noise(step().trace, 0.002, 0, std::uint64_t(draw)));
            for (std::size_t c = settled; c < e.lambda.size(); ++c) {
                double mean = 0, true_mean = 0;
                for (std::size_t i = 0; i < 4; ++i) mean += e.lambda[c][i] / 4, true_mean += step().trace.lambda.back()[i] / 4;
                for (std::size_t i = 0; i < 4; ++i)
                    square += std::pow(e.lambda[c][i] - mean - step().trace.lambda.back()[i] + true_mean, 2), stated += e.sd[c] * e.sd[c];
            }
        }
        const double ratio = std::sqrt(stated / square);
        if (says_so) {
            EXPECT_NEAR(ratio, 1, 0.3);
        } else {
            EXPECT_LT(ratio, 0.75) << "or there is nothing to say";
        }
    }
}

// Steps the filter over a gas of four cylinders in turn that the sensor has long followed, with white noise.
int jumps_after(float jump, double moved_lambda) {
    const sd_afr_joint_config_t c{4, 120, 0.03f, 0.015f, 2e-4f, 0.003f, 0.1f, 1000};
    sd_afr_joint_t f;
    must(sd_afr_joint_init(&f, &c));
    sd_afr_joint_set(&f, 1e-3f, 0.003f, jump);
    RandomStream noise(7, 0);
    sd_exhaust_now_f32_t now{};
    now.charge = 0.1f, now.mass = 0.1f;
    int before = 0;
    for (int k = 0; k < 12000; ++k) {
        for (int i = 0; i < 4; ++i) now.share[i] = (k + 120 - 30 * i) % 120 < 40 ? 0.025f : 0;
        if (k == 6000) before = f.jumps;
        const double gas = 0.5 + (k < 6000 ? 0 : moved_lambda);
        joint_step(f, now, float(gas + 4.5e-3 * noise.normal()), nullptr);
    }
    EXPECT_EQ(before, 0) << "noise alone is no step";
    EXPECT_NEAR(1 - double(sd_afr_joint_lambda(&f, 0)), 0.5 + moved_lambda, 0.02);
    return f.jumps;
}

TEST(AfrJoint, AStepIsSeenInTheMeanInnovationAndNoiseIsNot) {
    EXPECT_EQ(jumps_after(0.1f, 0), 0);
    EXPECT_GE(jumps_after(0.1f, 0.05), 1);
    EXPECT_EQ(jumps_after(0, 0.05), 0) << "switched off";
}

// Least squares written out: what all have in common (free, or known to so much) and one cylinder's deviation, each cylinder
// in turn.
TEST(AfrJoint, BlameIsTheOneCylinderThatExplainsMost) {
    RandomStream draw(11, 0);
    sd_afr_joint_t f;
    const sd_afr_joint_config_t c{4, 120, 0.03f, 0.015f, 2e-4f, 0.01f, 0.1f, 1000};
    must(sd_afr_joint_init(&f, &c));
    const sd_afr_usual_t free{0.02f, 0, 0}, known{0.02f, 0.5f, 0.01f}, unusable{NAN, 0.5f, 0.01f};
    EXPECT_EQ(sd_afr_joint_blame(&f, &free).explained, 0) << "not running";
    f.running = 1;
    int other_than_largest = 0, other_sign = 0;
    for (int round = 0; round < 200; ++round) {
        Eigen::Matrix4d root;
        Eigen::Vector4d off;
        for (int i = 0; i < 16; ++i) root(i / 4, i % 4) = 0.03 * draw.normal();
        for (int i = 0; i < 4; ++i) off(i) = 0.05 * draw.normal();
        const Eigen::Matrix4d p = root * root.transpose();
        for (int i = 0; i < 4; ++i) {
            f.air_fraction[i] = float(0.5 - off(i));
            for (int j = 0; j < 4; ++j) f.p.a[i][j] = float(p(i, j));
        }
        Eigen::MatrixXd both(8, 4); // W' W is the inverse of P + 4e-4 I
        both << root.transpose(), 0.02 * Eigen::Matrix4d::Identity();
        const Eigen::Matrix4d whiten = linalg::inverse_of_triangle(linalg::upper_triangle(both)).transpose();
        double by[2] = {};
        for (const sd_afr_usual_t *usual : {&free, &known}) {
            const double pin = usual == &known ? 100 : 0; // a fifth reading: that the common part is 0, within 0.01
            Eigen::Matrix<double, 5, 2> design;
            Eigen::Matrix<double, 5, 1> seen;
            seen << whiten * off, 0;
            design.col(0) << whiten * Eigen::Vector4d::Ones(), pin;
            const auto left = [&](const auto &of) { return (seen - of * linalg::least_squares(of, seen)).squaredNorm(); };
            const double together = left(design.leftCols(1).eval());
            int best = 0;
            double most = 0;
            for (int i = 0; i < 4; ++i) {
                design.col(1) << whiten * Eigen::Vector4d::Unit(i), 0;
                const double explained = together - left(design);
                if (explained > most) most = explained, best = i, by[usual == &known] = linalg::least_squares(design, seen)(1);
            }
            const sd_afr_blame_t blame = sd_afr_joint_blame(&f, usual);
            EXPECT_EQ(int(blame.cylinder), best) << round;
            EXPECT_NEAR(double(blame.deviation), by[usual == &known], 1e-4);
            EXPECT_NEAR(double(blame.explained), most, 1e-3 * most);
            int largest = 0;
            (off.array() - off.mean()).abs().maxCoeff(&largest);
            other_than_largest += best != largest;
        }
        other_sign += by[0] * by[1] < 0;
    }
    EXPECT_GT(other_than_largest, 20) << "or the weights would not matter";
    EXPECT_GT(other_sign, 20) << "or the mean would not matter";
    EXPECT_EQ(sd_afr_joint_blame(&f, &unusable).explained, 0);
}

TEST(AfrJoint, ForgetsWhatIsNotANumber) {
    const sd_afr_joint_config_t c{4, 120, 0.03f, 0.015f, 2e-4f, 0.01f, 0.1f, 8};
    sd_afr_joint_t f;
    must(sd_afr_joint_init(&f, &c));
    EXPECT_EQ(sd_afr_joint_status(&f).health, SD_INVALID);
    sd_exhaust_now_f32_t now{};
    now.charge = 0.1f, now.mass = 0.1f, now.share[0] = 0.02f;
    for (int k = 0; k < 2 + 33 * SD_AFR_GROUP; ++k) joint_step(f, now, k % 3 == 0 ? NAN : 0.5f, nullptr); // begins at k = 1
    EXPECT_EQ(sd_afr_joint_status(&f).health, SD_VALID);
    EXPECT_NEAR(double(sd_afr_joint_lambda(&f, 0)), 0.5, 1e-3);
    for (int k = 0; k < SD_AFR_GROUP; ++k) joint_step(f, now, k != 1 ? 0.5f : -1.5f, nullptr); // far off: its group is left out
    EXPECT_EQ(sd_afr_joint_status(&f).rejected, 1);
    EXPECT_EQ(sd_afr_joint_status(&f).health, SD_DEGRADED);
    for (int k = 0; k < SD_AFR_GROUP; ++k) joint_step(f, now, 0.5f, nullptr);
    EXPECT_EQ(sd_afr_joint_status(&f).health, SD_VALID);
    sd_afr_joint_config_t bad = c;
    bad.tau1_s = NAN;
    EXPECT_EQ(sd_afr_joint_init(&f, &bad), SD_ERR_CONFIG);
    bad = c;
    bad.cycle_positions = 23;
    EXPECT_EQ(sd_afr_joint_init(&f, &bad), SD_ERR_CONFIG);
}

// A periodic gas of known harmonics through two exact lags: the inversion finds it, in amplitude and angle.
TEST(AfrUego, BothFormsInvertTheSensorAndFixedPointFollowsFloat) {
    std::vector<std::int32_t> sine;
    for (int k = 0; k < 120; ++k)
        sine.push_back(std::int32_t(std::lround(2147483647.0 * std::sin(2 * M_PI * k / 120))));
    const double dt = 6.667e-4, tau1 = 0.03, tau2 = 0.015;
    const sd_uego_config_t c{120, 4, float(tau1), float(tau2), 0.005f, 0.1f};
    const sd_uego_gains_t gains = uego_gains({tau1, tau2, dt, 120, 4, 0.002, 0.02});
    const auto gas = [](double k) {
        return 0.5 + 0.05 * std::cos(2 * M_PI * k / 120) + 0.03 * std::sin(4 * M_PI * k / 120);
    };
    for (const sd_uego_gains_t *form : {(const sd_uego_gains_t *)nullptr, &gains}) {
        sd_uego_f32_t f32;
        sd_uego_q31_t q31;
        must(sd_uego_init_f32(&f32, &c));
        must(sd_uego_init_q31(&q31, &c));
        sd_uego_set_f32(&f32, sine.data(), float(dt), form);
        sd_uego_set_q31(&q31, sine.data(), float(dt), form);
        double lag2 = 0.5, lag1 = 0.5, worst = 0, unmoved = 0, apart = 0;
        for (int k = 0; k < 120 * 60; ++k) {
            for (int i = 1; i <= 20; ++i) { // fine steps
                lag2 += (1 - std::exp(-dt / 20 / tau2)) * (gas(k - 1 + i / 20.0) - lag2);
                lag1 += (1 - std::exp(-dt / 20 / tau1)) * (lag2 - lag1);
            }
            const double u = double(sd_uego_step_f32(&f32, sine.data(), std::uint32_t(k % 120), float(lag1)));
            const double fixed = double(sd_to_float_q31(
                sd_uego_step_q31(&q31, sine.data(), std::uint32_t(k % 120), sd_from_float_q31(float(lag1)))));
            apart = std::max(apart, std::abs(u - fixed));
            // Samples are taken at the ends of positions here: no mean, and half a position less than SD_UEGO_LEAD.
            if (k >= 120 * 58) worst = std::max(worst, std::abs(u - gas(k - 1))), unmoved = std::max(unmoved, std::abs(u - gas(k)));
        }
        EXPECT_LT(worst, 5e-4);
        EXPECT_GT(unmoved, 4e-3) << "or the lead would not matter";
        EXPECT_LT(apart, 1e-4);
    }
}

} // namespace
