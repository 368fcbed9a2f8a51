// SPDX-License-Identifier: MIT
// Pulses whose shape the calibration has wrong: what the filter reads then, what it learns of it, and what it states.
#include <array>

#include "design/calibration.hpp"
#include "design/torque/known_torque.hpp"
#include "design/torque/model_error.hpp"
#include "support/kalman_bench.hpp"

namespace sixdeg {
namespace {

using namespace test;

/// A change of shape: as of a pulse that comes 4 deg later, its mean over the half turn still 1.
double bend(std::size_t lane, double alpha) {
    static const double mean = pulse_mean();
    return (pulse_of(lane, alpha - 4 * M_PI / 180) - pulse_of(lane, alpha)) / mean;
}

/// The calibration's pulses are bent by half of that.
KnownTorque bent(bool learns) {
    KnownTorque known = known_torque();
    double mean = 0;
    for (int i = 0; i < 3600; ++i) mean += bend(0, M_PI * (i + 0.5) / 3600) / 3600;
    for (std::size_t lane = 0; lane < 4; ++lane) {
        const TorqueOverAngle straight = known.basis[lane];
        const auto change = [=](double a) { return (bend(lane, a) - mean * straight(a)) / (1 + mean); };
        known.basis[lane] = [=](double a) { return straight(a) + 0.5 * change(a); };
        if (learns) known.shape.push_back(change);
    }
    return known;
}

KalmanTune smooth() {
    KalmanTune tune;
    tune.rough_walk_nm = 0;
    return tune;
}

TorqueSignal unequal() {
    TorqueSignal signal;
    signal.fuel = {1.3, 1, 0.9, 0.6};
    return signal;
}

/// Reading of each firing in the last cycle over its truth, less 1; the mean of all is taken out of both first.
std::array<double, 4> errors(const Bench &bench, const TorqueSignal &signal) {
    std::array<double, 4> error{};
    for (std::size_t i = bench.firings.size() - 4; i < bench.firings.size(); ++i) {
        const sd_firing_t &said = bench.firings[i].said;
        error[said.index] = double(said.torque_nm) - signal.fuel[said.index] * pulse_mean();
    }
    const double mean = (error[0] + error[1] + error[2] + error[3]) / 4;
    for (double &e : error) e -= mean;
    return error;
}

TEST(ModelError, TheSteadyAnswerIsWhatTheFilterReads) {
    const KnownTorque known = bent(false), truth = known_torque();
    KalmanTune tune;
    tune.speeds_rpm = {2000}; // fast enough for the speed to be nearly even within a cycle, as the linear answer has it
    const KalmanTables made = kalman_tables(engine_file(), known, tune), right = kalman_tables(engine_file(), truth, tune);
    TorqueSignal signal = unequal();
    signal.rpm = 2000;
    Bench bench(made.tables, Edges(signal, 0, 0, 1)), exact(right.tables, Edges(signal, 0, 0, 1));
    bench.run(100), exact.run(100);
    const auto read = errors(bench, signal), without = errors(exact, signal); // the bench's own 0.2 %
    std::vector<TorqueOverAngle> lacking;
    for (std::size_t lane = 0; lane < 4; ++lane)
        lacking.push_back([&, lane, nm =
                           signal.fuel[lane] * pulse_mean()](double a) { return nm * (truth.basis[lane](a) - known.basis[lane](a)); });
    const auto [mean, moment] = interval_tables(engine_file(), lacking);
    Eigen::VectorXd predicted = steady_reading(tooth_model(engine_file(), known, 2000 * M_PI / 30), made.gains[0].gain, mean,
                                               moment).rowwise().sum();
    predicted.array() -= predicted.mean();
    const double most = predicted.cwiseAbs().maxCoeff();
    EXPECT_GT(most, 0.002 * pulse_mean()) << "or there is nothing to see";
    for (std::size_t lane = 0; lane < 4; ++lane) EXPECT_NEAR(read[lane] - without[lane], predicted(Eigen::Index(lane)), 0.1 * most) << lane;
}

TEST(ModelError, TheFilterLearnsThePulsesShape) {
    const KalmanTables stiff = kalman_tables(engine_file(), bent(false), smooth()),
        learning = kalman_tables(engine_file(), bent(true), smooth());
    for (const PeriodicGains &gains : learning.gains) EXPECT_LT(gains.radius, 1);
    EXPECT_LT(learning.radius_between, 1);
    for (double rpm : {1000.0, 3000.0}) {
        TorqueSignal signal = unequal();
        signal.rpm = rpm;
        const auto worst = [&](Bench &bench) {
            bench.run(250);
            double most = 0;
            for (double e : errors(bench, signal)) most = std::max(most, std::abs(e) / pulse_mean());
            return most;
        };
        Bench with(learning.tables, Edges(signal, 0, 0, 1)), without(stiff.tables, Edges(signal, 0, 0, 1));
        EXPECT_LT(worst(with), 0.2 * worst(without)) << rpm;
        EXPECT_NEAR(double(with.kalman.shape), -0.5, 0.05) << rpm;
        sd_kalman_restart(&with.kalman);
        EXPECT_NEAR(double(with.kalman.shape), -0.5, 0.05) << "kept";
    }
}

TEST(ModelError, TheShapeStandsStillWithoutCombustion) {
    const KalmanTables made = kalman_tables(engine_file(), bent(true), smooth());
    TorqueSignal signal;
    signal.fuel = {0, 0, 0, 0};
    Bench bench(made.tables, Edges(signal, 0.05, 0, 1));
    const_cast<sd_kalman_tables_t &>(bench.tables).shape_min_nm = 20;
    bench.kalman.shape = 0.3f;
    bench.run(50);
    EXPECT_EQ(0.3f, bench.kalman.shape);
}

TEST(ModelError, StatedDeviationsHoldWhatIsNotKnown) {
    sd_kalman_tables_t tables = pulse_tables().tables;
    for (int i = 0; i < SD_KALMAN_GAINS_MAX; ++i)
        tables.mean_share[i] = 0.02f, tables.spread_share[i] = 0.1f, tables.charge_nm_per_bar[i] = 3, tables.learned_nm_per_bar[i] = 1;
    const TorqueSignal signal = unequal();
    Bench certain(pulse_tables().tables, Edges(signal, 0.01, 0, 1)), doubting(tables, Edges(signal, 0.01, 0, 1));
    certain.run(60), doubting.run(60);
    const auto added = [&](float sd_firing_t::*deviation) {
        return std::pow(double(doubting.firings.back().said.*deviation), 2) - std::pow(double(certain.firings.back().said.*deviation), 2);
    };
    double spread = 0;
    for (double fuel : signal.fuel) spread += std::pow((fuel - 0.95) * pulse_mean(), 2) / 4;
    const double share = std::pow(0.02 * 0.95 * pulse_mean(), 2) + 0.01 * spread;
    EXPECT_NEAR(added(&sd_firing_t::sd_nm) / (share + 9), 1, 0.03);
    EXPECT_NEAR(added(&sd_firing_t::mean_sd_nm) / (share + 9), 1, 0.03);
    std::fill_n(doubting.kalman.zero_nm_per_bar, 4, 1e-3f);
    doubting.run(61);
    EXPECT_NEAR(added(&sd_firing_t::sd_nm) / (share + 1), 1, 0.03) << "zeros learned";
}

/// A spark-ignition four that fires unevenly, with tolerances.
EngineFile uneven() {
    EngineFile engine = engine_file();
    engine.firing_tdc_deg = {0, 150, 360, 510};
    engine.bore_m = 0.087, engine.compression_ratio = 10, engine.exhaust_open_deg = 135, engine.intake_close_deg = 580;
    engine.pulses = {{-15, 60, 2, 1}};
    return engine;
}

KalmanTune one_set() {
    KalmanTune tune = smooth();
    tune.speeds_rpm = {1000, 2000};
    return tune;
}

TEST(ModelError, OverlappingPulsesShowAndTheShapeTakesThemUp) {
    sd_parameters_t parameters{};
    const auto share = [&](const EngineFile &engine, bool learns) {
        parameters.firing_shape_walk_nm = learns ? 0.1f : 0.f;
        const KnownTorque known = *known_torque(engine, parameters);
        const KalmanTables made = kalman_tables(engine, known, one_set());
        return double(made.tables.mean_share[1]);
    };
    EngineFile even = uneven();
    even.firing_tdc_deg = {0, 180, 360, 540};
    EXPECT_GT(share(uneven(), false), 5 * share(even, false)) << "alike pulses at even distances err alike";
    EXPECT_LT(share(uneven(), true), 0.3 * share(uneven(), false));
}

TEST(ModelError, ToleranceOfTheEngineIsStated) {
    const auto tables = [](auto change) {
        EngineFile engine = uneven();
        change(engine.tolerance);
        sd_parameters_t parameters{};
        return kalman_tables(engine, *known_torque(engine, parameters), one_set()).tables;
    };
    const sd_kalman_tables_t exact = tables([](auto &) {}), inertia = tables([](auto &t) { t.inertia_percent = 3; }),
                             mass = tables([](auto &t) { t.trapped_mass_percent = 3; });
    EXPECT_NEAR(std::sqrt(std::pow(double(inertia.spread_share[0]), 2) - std::pow(double(exact.spread_share[0]), 2)), 0.03 / std::sqrt(3.0),
                1e-4);
    EXPECT_NEAR(double(inertia.mean_share[0]), double(exact.mean_share[0]), 1e-6) << "of all firings alike";
    EXPECT_GT(mass.charge_nm_per_bar[0], 2 * exact.charge_nm_per_bar[0]);
    EXPECT_LT(mass.learned_nm_per_bar[0], 0.7f * mass.charge_nm_per_bar[0]) << "fuel cut shows it";
    EXPECT_EQ(mass.mean_share[0], exact.mean_share[0]) << "it is not of combustion";
}

/// Of one cylinder no mean can be taken out, so its deviation is that of the torque itself.
TEST(ModelError, OneCylinderStatesWhatItsOwnPatternAndMotoredTorqueHide) {
    const auto tables = [](bool exact) {
        TomlFile file(std::filesystem::path(SD_ENGINES) / "single_generator.toml"), tune("tune", "");
        EngineFile engine = read_engine(file);
        if (exact) engine.tolerance = {};
        const sd_parameters_t parameters = read_tune(tune);
        return kalman_tables(engine, *known_torque(engine, parameters), kalman_tune(engine, parameters)).tables;
    };
    const sd_kalman_tables_t usual = tables(false), exact = tables(true);
    EXPECT_GT(usual.single_sd[0], 0) << "timing noise";
    EXPECT_GT(usual.pattern_sd[0], 0);
    EXPECT_GT(usual.charge_nm_per_bar[0], usual.learned_nm_per_bar[0]);
    EXPECT_GT(double(usual.mean_share[0]), 0.04 / std::sqrt(3.0)) << "the scale of the inertia is the scale of the torque";
    EXPECT_LT(exact.mean_share[0], usual.mean_share[0]);
}

} // namespace
} // namespace sixdeg
