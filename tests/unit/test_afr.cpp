// SPDX-License-Identifier: MIT
// The AFR blocks on the plant's exhaust, the filter against a full one in double, the gain limits by
// eigenvalues.
#include <Eigen/Eigenvalues>
#include <cstring>
#include <functional>
#include <gtest/gtest.h>

#include "calibration/calibration.hpp"
#include "calibration/chain_map.hpp"
#include "common/error.hpp"
#include "common/random.hpp"
#include "run/afr_blocks.hpp"

using namespace sixdeg;

namespace {

Scenario step_scenario(double rpm, double bmep_bar) {
    TomlFile file(
        "s.toml",
        "engine = \"diesel_22.toml\"\n[run]\ncycles = 70\n[speed]\nmode = \"prescribed\"\n[uego]\n[load]\n");
    file.set("speed.rpm=" + std::to_string(rpm));
    file.set("load.bmep_bar=" + std::to_string(bmep_bar));
    file.set("cylinders.fuel_step=[{at_s=" + std::to_string(30.25 * 120 / rpm) +
             ", cylinder=1, percent=20}]");
    return read_scenario(file, SD_ENGINES);
}

/// 1500 rpm, 9 bar, +20 % on cylinder 1, made once.
struct Step {
    Step() : scenario(step_scenario(1500, 9)), trace(afr_trace(scenario)) {
        const auto &last = trace.lambda.back();
        for (double l : last) mean += l / double(last.size());
        while (trace.lambda[at][0] < trace.lambda[30 * 120][0] + 0.02) ++at;
        point = exhaust_point(scenario.engine.shared, 1500 * M_PI / 30, trace.intake_pa, trace.sensor.back());
    }
    AfrEstimates run(const AfrSetup &setup, const std::vector<double> &noise = {}) const {
        return afr_estimate(scenario.engine.shared, point, trace, setup, noise);
    }
    /// Largest error of a cylinder after `cycles` from the step, points of mean lambda.
    double error_points(const AfrEstimates &e, double cycles) const {
        const auto c = std::size_t(std::ceil(double(at) / 120 + cycles)) - 1;
        double worst = 0;
        for (std::size_t i = 0; i < 4; ++i)
            worst = std::max(worst, std::abs(e.lambda[c][i] - trace.lambda.back()[i]));
        return 100 * worst / mean;
    }
    Scenario scenario;
    AfrTrace trace;
    ExhaustPoint point;
    std::size_t at = 0;
    double mean = 0;
};

const Step &step() {
    static const Step s;
    return s;
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

// Document 004's claim, noise free: 4 cycles to a 20 % band (of a 19 point step), by block A on the true gas and by the whole
// chain with either form of D.
TEST(AfrChain, ConvergesInFourCycles) {
    for (AfrMethod method : {AfrMethod::true_gas, AfrMethod::fourier, AfrMethod::oscillator}) {
        AfrSetup chain;
        chain.method = method;
        const AfrEstimates e = step().run(chain);
        EXPECT_GT(step().error_points(e, 0), 0.2 * 19);
        for (double cycles = 4; cycles < 30; ++cycles) EXPECT_LT(step().error_points(e, cycles), 0.2 * 19) << cycles;
        EXPECT_LT(step().error_points(e, 20), method == AfrMethod::true_gas ? 0.5 : 2.5);
    }
}

/// A gas whose cylinders differ, through the chain in one number type, with what `spoil` makes of its samples.
template <class V> struct ChainRun {
    ChainRun() {
        sd_exhaust_config_t e{};
        e.cycle_positions = 120, e.cylinders = 4, e.mass_base_kg = 0.01f;
        for (int i = 0; i < 4; ++i) e.firing_position[i] = std::uint16_t(30 * i);
        const auto psi = exhaust_psi();
        std::copy(psi.begin(), psi.end(), e.psi);
        must(V::exhaust_init(&exhaust, &e));
        const ExhaustPoint &p = step().point;
        share.assign(p.share.begin(), p.share.end());
        const sd_exhaust_point_t point{share.data(), float(p.charge_kg), float(p.rate_hz), float(p.z0_kg), float(p.transport_kg), SD_UEGO_LEAD};
        must(V::exhaust_set(&exhaust, &point, 6.667e-4f));
        for (int k = 0; k < 120; ++k) sine.push_back(std::int32_t(std::lround(2147483647.0 * std::sin(2 * M_PI * k / 120))));
        config = {120, 4, 2, 960, 0.03f, 0.015f, 0.1f, 4, 0.03f, 0.1f, sine.data()};
        must(V::chain_init(&chain, &config));
    }
    void cycles(int n, const std::function<double(double)> &spoil) {
        for (int k = 0; k < 120 * n; ++k) {
            if (k % 120 == 0) V::chain_set(&chain, 6.667e-4f, nullptr, float(step().point.charge_kg / 0.01));
            V::exhaust_step(&exhaust, std::uint32_t(k % 120), &now);
            V::chain_step(&chain, &now, std::uint32_t(k % 120), V::of(spoil(0.5 + 0.01 * std::cos(2 * M_PI * k / 120))));
        }
    }
    std::array<double, 4> lambda() const {
        std::array<double, 4> l{};
        for (std::uint32_t i = 0; i < 4; ++i) l[i] = double(V::chain_lambda(&chain, i));
        return l;
    }
    std::vector<float> share;
    std::vector<std::int32_t> sine;
    sd_afr_chain_config_t config{};
    typename V::Exhaust exhaust;
    typename V::Now now{};
    typename V::Chain chain;
};

TEST(AfrChain, BeginsAnewAfterBadSamplesAndSaysSo) {
    const auto good = [](double a) { return a; };
    ChainRun<F32> run, other;
    EXPECT_EQ(sd_afr_chain_status_f32(&run.chain).health, SD_INVALID);
    EXPECT_EQ(run.lambda()[0], 0);
    run.cycles(4, good);
    EXPECT_EQ(sd_afr_chain_status_f32(&run.chain).health, SD_DEGRADED) << "converging";
    run.cycles(200, good);
    EXPECT_EQ(sd_afr_chain_status_f32(&run.chain).health, SD_VALID);
    const auto settled = run.lambda();
    const float variance = sd_afr_chain_deviation_variance_f32(&run.chain);
    EXPECT_LT(variance, 1e-8f) << "no noise, nothing moves";
    EXPECT_GT(*std::max_element(settled.begin(), settled.end()) - *std::min_element(settled.begin(), settled.end()), 0.05);

    run.cycles(1, [](double) { return NAN; }); // no samples: it goes on with what it knows
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(run.lambda()[i], settled[i], 1e-3);
    run.cycles(3, [](double a) { return a + 0.45; }); // lies within the range
    EXPECT_GT(sd_afr_chain_deviation_variance_f32(&run.chain), 1e-4f) << "what it says of itself";
    for (double l : run.lambda()) EXPECT_TRUE(std::isfinite(l));
    run.cycles(40, good);
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(run.lambda()[i], settled[i], 1e-3) << "without a restart";
    EXPECT_EQ(sd_afr_chain_status_f32(&run.chain).health, SD_VALID);

    run.chain.uego.re[1] = NAN; // what cannot happen: the chain begins anew by itself
    run.cycles(1, good);
    EXPECT_EQ(sd_afr_chain_status_f32(&run.chain).health, SD_DEGRADED);
    run.chain.observer.air = NAN;
    run.cycles(40, good);
    sd_afr_chain_step_f32(&run.chain, &run.now, 120, 0.1f); // no such position
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(run.lambda()[i], settled[i], 1e-3);
    sd_afr_chain_restart_f32(&run.chain);
    EXPECT_EQ(sd_afr_chain_status_f32(&run.chain).health, SD_INVALID);

    other.cycles(30, good);
    sd_afr_chain_move_f32(&other.chain, 1, 0.02f);
    sd_afr_chain_move_f32(&other.chain, 2, NAN);
    sd_afr_chain_move_f32(&other.chain, 4, 0.1f);
    EXPECT_NEAR(other.lambda()[1], settled[1] + 0.02, 1e-3);
    EXPECT_NEAR(other.lambda()[2], settled[2], 1e-3);
    for (float sd_afr_chain_config_t::*field : {&sd_afr_chain_config_t::gain_air, &sd_afr_chain_config_t::inversion_gain, &sd_afr_chain_config_t::tau1_s}) {
        sd_afr_chain_config_t bad = run.config;
        bad.*field = NAN;
        const sd_afr_chain_f32_t before = run.chain;
        EXPECT_EQ(sd_afr_chain_init_f32(&run.chain, &bad), SD_ERR_CONFIG);
        EXPECT_EQ(0, std::memcmp(&before, &run.chain, sizeof before)) << "untouched";
    }
}

TEST(AfrChain, FixedPointFollowsFloatThroughBadSamples) {
    ChainRun<F32> f32;
    ChainRun<Q31> q31;
    RandomStream random(5, 0);
    for (int cycle = 0; cycle < 60; ++cycle) {
        const double lie = cycle % 20 == 10 ? 0.3 : 0, noise = 0.005 * random.normal();
        const auto spoil = [&](double a) { return cycle % 20 == 15 ? 1.5 : a + lie + noise; };
        f32.cycles(1, spoil);
        q31.cycles(1, spoil);
        for (std::size_t i = 0; i < 4; ++i) ASSERT_NEAR(f32.lambda()[i], q31.lambda()[i], 2e-4) << cycle;
    }
    EXPECT_NEAR(double(sd_afr_chain_deviation_variance_q31(&q31.chain)), double(sd_afr_chain_deviation_variance_f32(&f32.chain)), 1e-6);
}

TEST(AfrChain, FixedPointFollowsFloat) {
    for (AfrMethod method : {AfrMethod::fourier, AfrMethod::oscillator}) {
        AfrSetup chain;
        chain.method = method;
        const std::vector<double> noise = sensor_noise(step().trace, 0.005, 0, 1);
        const AfrEstimates f32 = step().run(chain, noise);
        chain.fixed_point = true;
        const AfrEstimates q31 = step().run(chain, noise);
        for (std::size_t c = 0; c < f32.lambda.size(); ++c)
            for (std::size_t i = 0; i < 4; ++i) ASSERT_NEAR(f32.lambda[c][i], q31.lambda[c][i], 2e-4) << c;
    }
}

/// Block A over a periodic gas at 1500 rpm, 9 bar, and what its error does over one cycle, written out in double.
struct ObserverLimits {
    ObserverLimits() {
        ChainRun<F32> run;
        const ExhaustPoint &p = step().point; // at the manifold: what goes in and out adds up exactly
        const sd_exhaust_point_t point{run.share.data(), float(p.charge_kg), float(p.rate_hz), float(p.z0_kg), 0, 0};
        must(sd_exhaust_set_f32(&run.exhaust, &point, 6.667e-4f));
        run.cycles(40, [](double a) { return a; }); // it repeats itself
        for (std::uint32_t k = 0; k < 120; ++k) {
            sd_exhaust_now_f32_t now;
            sd_exhaust_step_f32(&run.exhaust, k, &now);
            cycle.push_back(now);
        }
    }
    /// Largest eigenvalue of equation (9)'s error: x2 and the a_i.
    double radius(double gain_air, double gain_cylinder) const {
        Eigen::MatrixXd map = Eigen::MatrixXd::Identity(5, 5);
        for (const auto &now : cycle) {
            Eigen::MatrixXd predict = Eigen::MatrixXd::Identity(5, 5), correct = predict;
            for (int i = 0; i < 4; ++i) predict(0, 1 + i) = double(now.charge) * double(now.share[i]);
            correct(0, 0) -= gain_air;
            for (int i = 0; i < 4; ++i) correct(1 + i, 0) = -gain_cylinder * double(now.share[i]) / double(now.charge);
            map = correct * predict * map;
        }
        return map.eigenvalues().cwiseAbs().maxCoeff();
    }
    /// The gain at which it reaches 1, with the other one held.
    template <class Radius> static double limit(double stable, double unstable, Radius radius) {
        EXPECT_LT(radius(stable), 1);
        EXPECT_GT(radius(unstable), 1);
        while (unstable - stable > 1e-6 * stable) (radius((stable + unstable) / 2) < 1 ? stable : unstable) = (stable + unstable) / 2;
        return stable;
    }
    /// What becomes of an error of 0.001 in one cylinder and in the manifold in the firmware, over it, after so many cycles
    /// that by the eigenvalues it is `factor`; infinite where the observer left its range and began anew.
    double grown(double gain_air, double gain_cylinder, double factor) const {
        const int cycles = int(std::ceil(std::log(factor) / std::log(radius(gain_air, gain_cylinder))));
        const sd_afr_observer_config_t c{4, 0, 0.1f, 1};
        sd_afr_observer_f32_t o;
        must(sd_afr_observer_init_f32(&o, &c));
        o.gain_air.factor = float(gain_air), o.cylinder_gain = float(gain_cylinder); // beyond what init allows, too
        sd_afr_observer_set_f32(&o, cycle[0].charge);
        const sd_exhaust_now_f32_t &end = cycle.back();
        sd_afr_observer_step_f32(&o, &end, 0.3f);
        o.air_fraction[0] += 1e-3f, o.air += 1e-3f * end.mass;
        double worst = 1e-3;
        for (int n = 0; n < cycles && worst < 0.1; ++n) {
            for (const auto &now : cycle) sd_afr_observer_step_f32(&o, &now, 0.3f);
            if (o.steps < 121) return INFINITY;
            worst = std::abs(double(o.air / end.mass) - 0.3);
            for (int i = 0; i < 4; ++i) worst = std::max(worst, std::abs(double(o.air_fraction[i]) - 0.3));
        }
        return worst / 1e-3;
    }
    std::vector<sd_exhaust_now_f32_t> cycle;
};

TEST(AfrChain, GainLimitsOfBlockAAreThoseOfTheEigenvaluesOverOneCycle) {
    const ObserverLimits a;
    for (double air : {0.06, 0.12})
        for (double cylinder : {2.0, 5.0}) EXPECT_LT(a.radius(air, cylinder), 0.85) << air << " " << cylinder;
    const double air = a.limit(0.1, 3, [&](double gain) { return a.radius(gain, 4); });
    const double cylinder = a.limit(4, 4000, [&](double gain) { return a.radius(0.1, gain); });
    RecordProperty("limit_gain_air", std::to_string(air));
    RecordProperty("limit_gain_cylinder", std::to_string(cylinder));
    std::printf("limits at 1500 rpm 9 bar: L2 %.4f with L_cyl 4; L_cyl %.2f with L2 0.1\n", air, cylinder);
    for (double inside : {0.9, 0.98}) {
        EXPECT_LT(a.grown(inside * air, 4, 0.01), 0.1) << inside;
        EXPECT_LT(a.grown(0.1, inside * cylinder, 0.01), 0.1) << inside;
    }
    for (double outside : {1.02, 1.1}) {
        EXPECT_GT(a.grown(outside * air, 4, 1e5), 10) << outside;
        EXPECT_GT(a.grown(0.1, outside * cylinder, 1e5), 10) << outside;
    }
}

/// The whole chain at every point of the page.
TEST(AfrChain, CalibrationRefusesAChainThatDoesNotConverge) {
    const EngineFile &engine = step().scenario.engine.shared;
    TomlFile tune("tune.toml", "firing.enabled = 0\nafr.gain_air = 0.001\nafr.gain_cylinder = 100\n");
    const sd_parameters_t unstable = read_tune(tune);
    sd_calibration_t page = calibrate(engine, unstable, "tune.toml"); // the filter has no such gains
    EXPECT_EQ(chain_radius(page), 0);
    const auto radius = [&](float method, float gain_air, float gain_cylinder) {
        page.parameters.afr_method = method, page.parameters.afr_gain_air = gain_air, page.parameters.afr_gain_cylinder = gain_cylinder;
        return chain_radius(page);
    };
    for (float method : {2.0f, 3.0f}) {
        EXPECT_LT(radius(method, 0.1f, 4), 0.99) << "the defaults, at 4800 rpm too";
        EXPECT_LT(radius(method, 1.9f, 4), 1) << "below its limit";
        EXPECT_GT(radius(method, 0.001f, 100), 1);
    }
    sd_parameters_t chosen = unstable;
    chosen.afr_method = 3;
    try {
        calibrate(engine, chosen, "tune.toml");
        FAIL();
    } catch (const InputError &error) {
        EXPECT_NE(std::string(error.what()).find("tune.toml: afr.gain_air, gain_cylinder"), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("the chain does not converge"), std::string::npos) << error.what();
    }
}

// The joint filter's covariance against a full Kalman filter in double that shares no code with it.
TEST(AfrJoint, StructuredCovarianceIsTheFullOne) {
    sd_afr_joint_config_t c{4, 0.03f, 0.015f, 2e-4f, 0.01f, 0.1f, 1000};
    sd_afr_joint_t f;
    must(sd_afr_joint_init(&f, &c));
    const double dt = 1e-3, r = 4e-8 / (2 * dt), m2 = 1 - std::exp(-dt / 0.015),
                 m1 = 1 - std::exp(-dt / 0.03);
    sd_afr_joint_set(&f, float(dt), 0.01f, 0);
    Eigen::VectorXd x = Eigen::VectorXd::Constant(7, 0.5);
    Eigen::MatrixXd p = Eigen::MatrixXd::Identity(7, 7) * 0.01;
    sd_exhaust_now_f32_t now{};
    now.charge = 0.1f;
    sd_afr_joint_step(&f, &now, 0.5f, nullptr); // starts
    for (int k = 0; k < 600; ++k) {
        now.mass = float(0.1 + 0.02 * std::sin(k * 0.21));
        Eigen::MatrixXd phi = Eigen::MatrixXd::Identity(7, 7);
        double flow = 0;
        for (int i = 0; i < 4; ++i) {
            const int since = (k + 120 - 30 * i) % 120;
            now.share[i] = since < 40 ? 0.025f : 0;
            if (since == 0 || (k == 0 && since < 40)) p(1 + i, 1 + i) += 1e-4;
            flow += 0.1 * double(now.share[i]);
        }
        phi(0, 0) = (double(now.mass) - flow) / double(now.mass);
        for (int i = 0; i < 4; ++i) phi(0, 1 + i) = 0.1 * double(now.share[i]) / double(now.mass);
        phi.row(5) = m2 * phi.row(0);
        phi(5, 5) = 1 - m2;
        phi.row(6) = m1 * phi.row(5);
        phi(6, 6) += 1 - m1;
        const double y = 0.5 + 0.05 * std::sin(k * 0.1);
        x = phi * x;
        p = phi * p * phi.transpose();
        if (k % 7 != 3) { // some samples are missing
            const Eigen::VectorXd gain = p.col(6) / (p(6, 6) + r);
            x += gain * (y - x(6));
            p = (p - gain * p.row(6)).eval();
        }
        sd_afr_joint_step(&f, &now, k % 7 != 3 ? float(y) : 100.0f, nullptr);
    }
    EXPECT_NEAR(double(f.x), x(0), 2e-3);
    for (int i = 0; i < 4; ++i) EXPECT_NEAR(double(f.air_fraction[i]), x(1 + i), 2e-3);
    for (int i = 0, at = 0; i < 7; ++i)
        for (int j = 0; j <= i; ++j, ++at)
            EXPECT_NEAR(double(f.covariance[at]), p(i, j), 0.01 * std::sqrt(p(i, i) * p(j, j))) << i << j;
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
    const sd_afr_joint_config_t c{4, 0.03f, 0.015f, 2e-4f, 0.003f, 0.1f, 1000};
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
        sd_afr_joint_step(&f, &now, float(gas + 4.5e-3 * noise.normal()), nullptr);
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
    const sd_afr_joint_config_t c{4, 0.03f, 0.015f, 2e-4f, 0.01f, 0.1f, 1000};
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
            for (int j = 0; j <= i; ++j) f.covariance[(1 + i) * (2 + i) / 2 + 1 + j] = float(p(i, j));
        }
        const Eigen::Matrix4d whiten = Eigen::Matrix4d((p + 4e-4 * Eigen::Matrix4d::Identity()).inverse().llt().matrixU());
        double by[2] = {};
        for (const sd_afr_usual_t *usual : {&free, &known}) {
            const double pin = usual == &known ? 100 : 0; // a fifth reading: that the common part is 0, within 0.01
            Eigen::Matrix<double, 5, 2> design;
            Eigen::Matrix<double, 5, 1> seen;
            seen << whiten * off, 0;
            design.col(0) << whiten * Eigen::Vector4d::Ones(), pin;
            const auto left = [&](const auto &of) { return (seen - of * of.colPivHouseholderQr().solve(seen)).squaredNorm(); };
            const double together = left(design.leftCols(1).eval());
            int best = 0;
            double most = 0;
            for (int i = 0; i < 4; ++i) {
                design.col(1) << whiten * Eigen::Vector4d::Unit(i), 0;
                const double explained = together - left(design);
                if (explained > most) most = explained, best = i, by[usual == &known] = design.colPivHouseholderQr().solve(seen)(1);
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
    const sd_afr_joint_config_t c{4, 0.03f, 0.015f, 2e-4f, 0.01f, 0.1f, 8};
    sd_afr_joint_t f;
    must(sd_afr_joint_init(&f, &c));
    EXPECT_EQ(sd_afr_joint_status(&f).health, SD_INVALID);
    sd_exhaust_now_f32_t now{};
    now.charge = 0.1f, now.mass = 0.1f, now.share[0] = 0.02f;
    for (int k = 0; k < 200; ++k) sd_afr_joint_step(&f, &now, k % 3 == 0 ? NAN : 0.5f, nullptr);
    EXPECT_EQ(sd_afr_joint_status(&f).health, SD_VALID);
    EXPECT_NEAR(double(sd_afr_joint_lambda(&f, 0)), 0.5, 1e-3);
    sd_afr_joint_step(&f, &now, -1.5f, nullptr); // far off: left out
    EXPECT_EQ(sd_afr_joint_status(&f).rejected, 1);
    EXPECT_EQ(sd_afr_joint_status(&f).health, SD_DEGRADED);
    sd_afr_joint_step(&f, &now, 0.5f, nullptr);
    EXPECT_EQ(sd_afr_joint_status(&f).health, SD_VALID);
    sd_afr_joint_config_t bad = c;
    bad.tau1_s = NAN;
    EXPECT_EQ(sd_afr_joint_init(&f, &bad), SD_ERR_CONFIG);
}

// A periodic gas of known harmonics through two exact lags: the inversion finds it, in amplitude and angle.
TEST(AfrUego, BothFormsInvertTheSensorAndFixedPointFollowsFloat) {
    std::vector<std::int32_t> sine;
    for (int k = 0; k < 120; ++k)
        sine.push_back(std::int32_t(std::lround(2147483647.0 * std::sin(2 * M_PI * k / 120))));
    const double dt = 6.667e-4, tau1 = 0.03, tau2 = 0.015;
    const sd_uego_config_t c{120, 4, float(tau1), float(tau2), 0.005f, 0.1f, sine.data()};
    const sd_uego_gains_t gains = uego_gains({tau1, tau2, dt, 120, 4, 0.002, 0.02});
    const auto gas = [](double k) {
        return 0.5 + 0.05 * std::cos(2 * M_PI * k / 120) + 0.03 * std::sin(4 * M_PI * k / 120);
    };
    for (const sd_uego_gains_t *form : {(const sd_uego_gains_t *)nullptr, &gains}) {
        sd_uego_f32_t f32;
        sd_uego_q31_t q31;
        must(sd_uego_init_f32(&f32, &c));
        must(sd_uego_init_q31(&q31, &c));
        sd_uego_set_f32(&f32, float(dt), form);
        sd_uego_set_q31(&q31, float(dt), form);
        double lag2 = 0.5, lag1 = 0.5, worst = 0, unmoved = 0, apart = 0;
        for (int k = 0; k < 120 * 60; ++k) {
            for (int i = 1; i <= 20; ++i) { // fine steps
                lag2 += (1 - std::exp(-dt / 20 / tau2)) * (gas(k - 1 + i / 20.0) - lag2);
                lag1 += (1 - std::exp(-dt / 20 / tau1)) * (lag2 - lag1);
            }
            const double u = double(sd_uego_step_f32(&f32, std::uint32_t(k % 120), float(lag1)));
            const double fixed = double(sd_to_float_q31(
                sd_uego_step_q31(&q31, std::uint32_t(k % 120), sd_from_float_q31(float(lag1)))));
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
