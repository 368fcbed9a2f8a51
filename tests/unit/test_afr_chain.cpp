// SPDX-License-Identifier: MIT
// Document 004's chain on the plant's exhaust: convergence, bad samples, fixed point, and the gain limits by eigenvalues.
#include <cstring>
#include <functional>
#include <gtest/gtest.h>

#include "design/calibration.hpp"
#include "design/afr/chain_map.hpp"
#include "common/error.hpp"
#include "common/random.hpp"
#include "linalg/linalg.hpp"
#include "support/afr_step.hpp"

using namespace sixdeg;

namespace {

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

/// With a pressure in the manifold it does not matter what the calibration believes of the turbine: 20 % of its area either way move
/// the estimates by less than half of what they do without one.
TEST(AfrChain, APressureSensorMakesUpForAWrongTurbine) {
    for (bool fixed_point : {false, true}) {
        for (double area : {-0.2, 0.2}) {
            double moved[2];
            for (bool sensor : {false, true}) {
                AfrSetup chain;
                chain.method = AfrMethod::fourier, chain.fixed_point = fixed_point, chain.gain_mass = sensor ? 0.1 : 0;
                const AfrEstimates right = step().run(chain);
                chain.error.turbine = area;
                const AfrEstimates wrong = step().run(chain);
                for (double cycles = 4; cycles < 30; ++cycles) EXPECT_LT(step().error_points(right, cycles), 0.2 * 19) << cycles << sensor;
                moved[sensor] = 0;
                for (std::size_t i = 0; i < 4; ++i)
                    moved[sensor] = std::max(moved[sensor], 100 * std::abs(wrong.lambda.back()[i] - right.lambda.back()[i]) / step().mean);
            }
            EXPECT_GT(moved[false], 0.5) << area;
            EXPECT_LT(moved[true], 0.1) << area;
            EXPECT_LT(moved[true], 0.5 * moved[false]) << area;
        }
    }
}

/// A gas whose cylinders differ, through the chain in one number type, with what `spoil` makes of its samples.
template <class V> struct ChainRun {
    ChainRun() {
        sd_exhaust_config_t e{};
        e.cycle_positions = 120, e.cylinders = 4, e.mass_base_kg = 0.01f;
        for (int i = 0; i < 4; ++i) e.firing_position[i] = std::uint16_t(30 * i);
        const ExhaustPoint &p = step().point;
        e.open_position = open_position(p.share);
        must(V::exhaust_init(&exhaust, &e));
        give_shares<V>(exhaust, p.share);
        const sd_exhaust_point_t point{float(p.charge_kg), float(p.rate_hz), float(p.z0_kg), float(p.transport_kg), SD_UEGO_LEAD, 0};
        must(V::exhaust_set(&exhaust, &point, 6.667e-4f));
        for (int k = 0; k < 120; ++k) sine.push_back(std::int32_t(std::lround(2147483647.0 * std::sin(2 * M_PI * k / 120))));
        config = {120, 4, 2, 960, 0.03f, 0.015f, 0.1f, 4, 0.03f, 0.1f};
        must(V::chain_init(&chain, &config));
    }
    void cycles(int n, const std::function<double(double)> &spoil) {
        for (int k = 0; k < 120 * n; ++k) {
            if (k % 120 == 0) V::chain_set(&chain, sine.data(), 6.667e-4f, nullptr, exhaust.charge);
            V::exhaust_step(&exhaust, psi.data(), std::uint32_t(k % 120), &now);
            V::chain_step(&chain, sine.data(), &now, std::uint32_t(k % 120), V::of(spoil(0.5 + 0.01 * std::cos(2 * M_PI * k / 120))));
        }
    }
    std::array<double, 4> lambda() const {
        std::array<double, 4> l{};
        for (std::uint32_t i = 0; i < 4; ++i) l[i] = double(V::chain_lambda(&chain, i));
        return l;
    }
    std::vector<typename V::Type> psi = psi_table<V>();
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
    sd_afr_chain_step_f32(&run.chain, run.sine.data(), &run.now, 120, 0.1f); // no such position
    for (std::size_t i = 0; i < 4; ++i) EXPECT_NEAR(run.lambda()[i], settled[i], 1e-3);
    sd_afr_chain_restart_f32(&run.chain);
    EXPECT_EQ(sd_afr_chain_status_f32(&run.chain).health, SD_INVALID);

    other.cycles(30, good);
    sd_afr_chain_move_f32(&other.chain, 1, 0.02f);
    sd_afr_chain_move_f32(&other.chain, 2, NAN);
    sd_afr_chain_move_f32(&other.chain, 4, 0.1f);
    EXPECT_NEAR(other.lambda()[1], settled[1] + 0.02, 1e-3);
    EXPECT_NEAR(other.lambda()[2], settled[2], 1e-3);
    for (float sd_afr_chain_config_t::*field
         : {&sd_afr_chain_config_t::gain_air, &sd_afr_chain_config_t::inversion_gain, &sd_afr_chain_config_t::tau1_s}) {
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
        const sd_exhaust_point_t point{float(p.charge_kg), float(p.rate_hz), float(p.z0_kg), 0, 0, 0};
        must(sd_exhaust_set_f32(&run.exhaust, &point, 6.667e-4f));
        run.cycles(40, [](double a) { return a; }); // it repeats itself
        for (std::uint32_t k = 0; k < 120; ++k) {
            sd_exhaust_now_f32_t now;
            sd_exhaust_step_f32(&run.exhaust, run.psi.data(), k, &now);
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
        return linalg::spectral_radius(map);
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

} // namespace
