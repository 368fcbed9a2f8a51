// SPDX-License-Identifier: MIT
#include <cstring>
#include <filesystem>
#include <map>

#include "design/calibration.hpp"
#include "design/torque/known_torque.hpp"
#include "support/kalman_bench.hpp"

namespace sixdeg {
namespace {

using namespace test;

/// Found by doubling; here by going round the cycle with whole matrices until nothing changes.
TEST(KalmanGains, AreWhereTheRecursionEnds) {
    constexpr double kWalk = 1e-4; // large, so that going round ends soon
    for (const char *name : {"diesel_22.toml", "eight_diesel.toml"}) {
        TomlFile file(std::filesystem::path(SD_ENGINES) / name), tune("tune", "");
        const EngineFile engine = read_engine(file);
        const ToothModel model = tooth_model(engine, sixdeg::known_torque(engine, read_tune(tune)).value(), 300);
        const ToothNoise noise{2e-4, kWalk, 1e-3, kWalk};
        const PeriodicGains gains = design_gains(model, noise, 10);
        const int n = model.states(), first = 3 + int(model.inject_at.size());
        const Eigen::VectorXd h = seen(model).transpose();
        Eigen::MatrixXd p = Eigen::MatrixXd::Identity(n, n), last(model.cycle(), n);
        for (int step = 0; step < 60 * model.cycle(); ++step) {
            const int k = step % model.cycle();
            StateMatrix a = StateMatrix::Identity(n, n);
            predict_error(model, k, a);
            p = (a * p * a.transpose()).eval();
            p(2, 2) += kWalk * kWalk;
            for (int j = first; j < 2 + model.torques(); ++j) p(j, j) += kWalk * kWalk;
            last.row(k).setZero();
            if (model.present[std::size_t(k % model.positions)]) {
                last.row(k) = (p * h).transpose() / (h.dot(p * h) + 4e-8);
                p -= (last.row(k).transpose() * (h.transpose() * p)).eval();
            }
            for (std::size_t i = 0; i < model.inject_at.size(); ++i) {
                if (model.inject_at[i] == k) p(3 + int(i), 3 + int(i)) += 1e-6;
            }
        }
        EXPECT_LT((last - gains.gain).cwiseAbs().maxCoeff(), 1e-6 * gains.gain.cwiseAbs().maxCoeff()) << name << ' ' << gains.radius;
    }
}

TEST(Kalman, FindsEveryFiringAndTheWaveform) {
    for (double rpm : {600.0, 1000.0, 3000.0, 6000.0}) {
        TorqueSignal signal;
        signal.rpm = rpm;
        Bench bench(pulse_tables().tables, Edges(signal, 0, 0, 1));
        bench.run(100); // at 6000 rpm the common part takes 60 cycles to 0.2 %
        ASSERT_EQ(bench.firings.size(), 4u * 100 - 2) << "two are read in the first revolution, before their pulses were seen";
        for (std::size_t i = 380; i < bench.firings.size(); ++i) {
            const sd_firing_t &firing = bench.firings[i].said;
            const double truth = signal.fuel[firing.index] * pulse_mean();
            EXPECT_NEAR(double(firing.torque_nm), truth, 2e-3 * truth) << rpm << " rpm, firing " << int(firing.index);
            EXPECT_NEAR(double(firing.mean_nm), truth, 2e-3 * truth);
        }
        double worst = 0;
        bench.on_tooth = [&] {
            const double alpha = 2 * M_PI * bench.k / kPositions;
            worst = std::max(worst, std::abs(double(sd_kalman_torque(&bench.kalman, &bench.tables, 0, std::uint32_t(bench.k % kCycle)))
                                             - signal.torque(alpha)));
        };
        bench.run(102);
        EXPECT_LT(worst, 5e-3 * signal.peak_to_peak()) << rpm;
    }
}

TEST(Kalman, FourierBasisFollowsTheSameTorque) {
    KnownTorque known = known_torque();
    known.basis = fourier_basis(12);
    known.firings = false;
    KalmanTune tune;
    tune.speeds_rpm = {1000};
    const KalmanTables made = kalman_tables(engine_file(), known, tune);
    EXPECT_LT(made.gains[0].radius, 1);
    TorqueSignal signal;
    Bench bench(made.tables, Edges(signal, 0, 0, 1));
    bench.run(20);
    double square = 0;
    int count = 0;
    bench.on_tooth = [&] { square += std::pow(double(sd_kalman_torque(&bench.kalman, &bench.tables, 0, std::uint32_t(bench.k % kCycle)))
                                              - signal.torque(2 * M_PI * bench.k / kPositions), 2), ++count; };
    bench.run(22);
    EXPECT_LT(std::sqrt(square / count), 0.03 * signal.peak_to_peak()) << "12 harmonics leave out 2.6 %";
    EXPECT_TRUE(bench.firings.empty());
}

TEST(Kalman, GainsAreStableAndZeroWhereNoToothIs) {
    for (const PeriodicGains &gains : pulse_tables().gains) {
        EXPECT_LT(gains.radius, 1);
        for (int k : {58, 59, 118, 119}) EXPECT_EQ(gains.gain.row(k).cwiseAbs().maxCoeff(), 0);
        EXPECT_GE(gains.innovation, 1);
    }
    EXPECT_LT(pulse_tables().radius_between, 1);
}

/// Statistics of the filter's errors against what it said of them.
TEST(Kalman, StatedDeviationsAreHonest) {
    const auto ratios = [](double rpm, double jitter_deg, double pattern_deg, double &single, double &mean) {
        TorqueSignal signal;
        signal.rpm = rpm;
        double errors[2] = {}, stated[2] = {};
        for (unsigned seed = 1; seed <= 12; ++seed) {
            Bench bench(pulse_tables().tables, Edges(signal, jitter_deg, pattern_deg, seed));
            bench.tooth.pattern_rad = float(pattern_deg * M_PI / 180);
            bench.run(60);
            const std::size_t first = 4 * 40; // the firings read in a cycle
            for (std::size_t i = first; i + 4 <= bench.firings.size(); i += 4) {
                double torque[4], average[4], torque_sum = 0, average_sum = 0, fuel_sum = 0;
                for (std::size_t c = 0; c < 4; ++c) {
                    const sd_firing_t &said = bench.firings[i + c].said;
                    const double fuel = signal.fuel[said.index] * pulse_mean();
                    torque[c] = double(said.torque_nm) - fuel, average[c] = double(said.mean_nm) - fuel;
                    torque_sum += torque[c] / 4, average_sum += average[c] / 4, fuel_sum += fuel;
                    stated[0] += std::pow(double(said.sd_nm), 2), stated[1] += std::pow(double(said.mean_sd_nm), 2);
                }
                for (std::size_t c = 0; c < 4; ++c)
                    errors[0] += std::pow(torque[c] - torque_sum, 2), errors[1] += std::pow(average[c] - average_sum, 2);
            }
        }
        single = std::sqrt(errors[0] / stated[0]), mean = std::sqrt(errors[1] / stated[1]);
    };
    for (double rpm : {1000.0, 3000.0, 6000.0}) {
        double single, mean;
        ratios(rpm, 0.02, 0, single, mean);
        EXPECT_NEAR(single, 1, 0.3) << rpm;
        EXPECT_NEAR(mean, 1, 0.3) << rpm;
        ratios(rpm, 0.005, 0.02, single, mean);
        EXPECT_NEAR(single, 1, 0.3) << rpm << " with a pattern";
        EXPECT_NEAR(mean, 1, 0.3) << rpm << " with a pattern";
    }
}

TEST(Kalman, LearnedPatternIsTakenOut) {
    TorqueSignal signal;
    signal.rpm = 3000;
    const auto worst = [&](bool learned) {
        Bench bench(pulse_tables().tables, Edges(signal, 0, 0.1, 1));
        bench.before_tooth = [&] { bench.tooth.late_rad = learned ? float(bench.edges.late_rad(bench.k)) : 0.f; };
        bench.run(40);
        double error = 0;
        for (std::size_t i = bench.firings.size() - 4; i < bench.firings.size(); ++i) {
            const sd_firing_t &said = bench.firings[i].said;
            const double truth = signal.fuel[said.index] * pulse_mean();
            error = std::max(error, std::abs(double(said.torque_nm) / truth - 1));
        }
        return error;
    };
    EXPECT_LT(worst(true), 3e-3);
    EXPECT_GT(worst(false), 1e-2);
}

TEST(Kalman, BadInputsNeverGiveNan) {
    TorqueSignal signal;
    Bench bench(pulse_tables().tables, Edges(signal, 0.01, 0, 3));
    std::mt19937 random(7);
    const auto sane = [&] {
        ASSERT_TRUE(std::isfinite(sd_kalman_torque(&bench.kalman, &bench.tables, 0, 7)));
        ASSERT_TRUE(std::isfinite(bench.motion().energy_j));
        for (float x : bench.motion().coefficient_nm) ASSERT_TRUE(std::isfinite(x));
    };
    bench.on_tooth = [&] {
        sane();
        bench.tooth.trusted = random() % 5 != 0;
        bench.tooth.intake_bar = random() % 7 == 0 ? NAN : random() % 7 == 0 ? -3.f : 1.f;
    };
    bench.run(20);
    sd_firing_t firing{};
    for (int i = 0; i < 20000; ++i) {
        sd_kalman_tooth_t tooth{};
        tooth.cycle_position = std::uint16_t(random() % 130);
        tooth.advance = std::uint16_t(random() % 5);
        tooth.period_ticks = random() % 3 == 0 ? std::uint32_t(random()) : random() % 200000;
        tooth.trusted = random() % 2;
        tooth.intake_bar = float(random() % 12);
        sd_kalman_step(&bench.kalman, &bench.tables, &tooth, &firing);
        sane();
        ASSERT_TRUE(std::isfinite(firing.torque_nm) && std::isfinite(firing.sd_nm) && std::isfinite(firing.mean_sd_nm));
    }
    // And it recovers without a restart from outside.
    bench.on_tooth = nullptr;
    bench.tooth.trusted = 1, bench.tooth.intake_bar = 1;
    bench.firings.clear();
    bench.run(50);
    EXPECT_EQ(sd_kalman_status(&bench.kalman, &bench.tables, 0).health, SD_VALID);
    const double truth = signal.fuel[bench.firings.back().said.index] * pulse_mean();
    EXPECT_NEAR(double(bench.firings.back().said.torque_nm), truth, 0.02 * truth);
}

TEST(Kalman, SaysWhenItCannotBeTrusted) {
    TorqueSignal signal;
    Bench bench(pulse_tables().tables, Edges(signal, 0, 0, 1));
    EXPECT_EQ(sd_kalman_status(&bench.kalman, &bench.tables, 0).health, SD_INVALID);
    bench.run(1);
    EXPECT_EQ(sd_kalman_status(&bench.kalman, &bench.tables, 0).why, SD_WHY_CONVERGING);
    bench.run(10);
    EXPECT_EQ(sd_kalman_status(&bench.kalman, &bench.tables, 0).health, SD_VALID);
    bench.tooth.intake_bar = NAN;
    bench.run(11);
    EXPECT_EQ(sd_kalman_status(&bench.kalman, &bench.tables, 0).health, SD_DEGRADED);
    sd_kalman_restart(&bench.kalman);
    EXPECT_EQ(sd_kalman_status(&bench.kalman, &bench.tables, 0).health, SD_INVALID);
}

/// Mean square error of a firing less the mean of its cycle, share of the mean torque, for each cycle read whole.
std::vector<double> imbalance_square(const Bench &bench, const TorqueSignal &signal) {
    std::map<int, std::vector<double>> errors;
    for (const Firing &firing : bench.firings)
        errors[firing.cycle].push_back(double(firing.said.torque_nm) / pulse_mean() - signal.fuel[firing.said.index]);
    std::vector<double> squares;
    for (const auto &[cycle, error] : errors) {
        if (error.size() < 4) continue;
        const double mean = (error[0] + error[1] + error[2] + error[3]) / 4;
        squares.push_back(0);
        for (double e : error) squares.back() += (e - mean) * (e - mean) / 4;
    }
    return squares;
}

TEST(Kalman, ColdStartTakesTwoCyclesAt1000RpmAndThreeAt3000) {
    constexpr int kSeeds = 8;
    for (const auto &[rpm, cycles] : std::map<double, std::size_t>{{1000, 2}, {3000, 3}}) {
        TorqueSignal signal;
        signal.rpm = rpm;
        std::vector<double> sum(30, 0.0);
        for (unsigned seed = 1; seed <= kSeeds; ++seed) {
            Bench bench(pulse_tables().tables, Edges(signal, 0.01, 0.002, seed));
            bench.run(30);
            const auto squares = imbalance_square(bench, signal);
            for (std::size_t i = 0; i < squares.size(); ++i) sum[i] += squares[i] / kSeeds;
        }
        // The first group is complete when two cycles have passed from the first tooth.
        for (std::size_t i = cycles - 2; i < sum.size(); ++i) EXPECT_LT(100 * std::sqrt(sum[i]), 2) << rpm << " rpm, cycle " << i + 2;
    }
}

TEST(Kalman, RefusesTablesOutOfRange) {
    sd_kalman_t filter{}, before{};
    const auto refused = [&](auto change) {
        sd_kalman_tables_t tables = pulse_tables().tables;
        change(tables);
        return sd_kalman_init(&filter, &tables, &kChoice, 1) == SD_ERR_CONFIG && std::memcmp(&filter, &before, sizeof filter) == 0;
    };
    EXPECT_TRUE(refused([](auto &t) { t.positions = 61; }));
    EXPECT_TRUE(refused([](auto &t) { t.coefficients = 0; }));
    EXPECT_TRUE(refused([](auto &t) { t.speeds = 5; }));
    EXPECT_TRUE(refused([](auto &t) { t.sets = 0; }));
    EXPECT_TRUE(refused([](auto &t) { t.sets = 3; }));
    EXPECT_TRUE(refused([](auto &t) { t.load_sd_nm[5] = -1; }));
    EXPECT_TRUE(refused([](auto &t) { t.firings = 5; }));
    EXPECT_TRUE(refused([](auto &t) { t.pool[7 * t.row_words].at.read = 5; }));
    EXPECT_TRUE(refused([](auto &t) { t.speed_radps[1] = t.speed_radps[0]; }));
    EXPECT_TRUE(refused([](auto &t) { t.pool[17].value = NAN; }));
    EXPECT_TRUE(refused([](auto &t) { t.shape_min_nm = -1; }));
    EXPECT_TRUE(refused([](auto &t) { t.shapes = 2; }));
    EXPECT_TRUE(refused([](auto &t) { t.window = t.coefficients; }));
    EXPECT_TRUE(refused([](auto &t) { t.row_words++; }));
    EXPECT_TRUE(refused([](auto &t) { t.gains_at++; }));
    EXPECT_TRUE(refused([](auto &t) { t.teeth--; }));
    EXPECT_TRUE(refused([](auto &t) { t.pitch_rad = 0; }));
    EXPECT_TRUE(refused([](auto &t) { t.gain_scale[1][2] = NAN; }));
    EXPECT_TRUE(refused([](auto &t) { t.pool[3 * t.row_words].at.first = 4; }));
    EXPECT_TRUE(refused([](auto &t) { t.pool[3 * t.row_words].at.close = 16; }));
    EXPECT_TRUE(refused([](auto &t) { t.mean_share[3] = NAN; }));
    EXPECT_TRUE(refused([](auto &t) { t.learned_nm_per_bar[0] = -1; }));
    EXPECT_TRUE(refused([](auto &t) { t.pool[5 * t.row_words + SD_ROW_KNOWN + 1].value = INFINITY; }));
    EXPECT_TRUE(refused([](auto &t) { t.pool[59 * t.row_words + SD_ROW_TOOTH].value = INFINITY; }));
    EXPECT_FALSE(refused([](auto &) {}));
}

// Every mantissa would take minutes: some millions of them, over two binades and over all exponents.
TEST(Kalman, TheRootIsRoundedOnceWithAndWithoutAnInstructionForIt) {
    const auto check = [](std::uint32_t bits) {
        float x;
        std::memcpy(&x, &bits, sizeof x);
        const float root = std::sqrt(x);
        ASSERT_EQ(sd_sqrt_f32(x), root) << x;
        ASSERT_EQ(sd_sqrt_by_bits_f32(x), root) << x;
    };
    for (std::uint32_t bits = 0x3f800000u; bits < 0x40800000u; bits += 7u) check(bits);
    for (std::uint32_t bits = 0x00800000u; bits < 0x7f800000u; bits += 1009u) check(bits);
}

} // namespace
} // namespace sixdeg
