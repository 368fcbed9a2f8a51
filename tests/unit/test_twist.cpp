// SPDX-License-Identifier: MIT
// A crank that twists: its modes against closed forms, and the filter on tooth times on a wheel that swings.
#include <complex>

#include "design/crank/crank_modes.hpp"
#include "support/kalman_bench.hpp"
extern "C" {
#include "sd_pattern.h"
}

namespace sixdeg {
namespace {

using namespace test;

EngineFile with_dual_mass() {
    EngineFile engine = engine_file();
    engine.reciprocating_mass_kg = 0;
    engine.dual_mass = DualMassFlywheel{0.15, 800, 6};
    return engine;
}

EngineFile with_torsion(bool at_front) {
    EngineFile engine = engine_file();
    engine.torsion = CrankTorsion{4e5, 0.03, 0.02, 0.03, at_front};
    return engine;
}

TEST(CrankModes, TwoMassesOnASpringInClosedForm) {
    const auto modes = crank_modes(with_dual_mass(), 2);
    ASSERT_EQ(modes.size(), 1u);
    const double j1 = 0.25, j2 = 0.15, inverse = 1 / j1 + 1 / j2, w = std::sqrt(800 * inverse);
    EXPECT_NEAR(modes[0].frequency_radps, w, 1e-9 * w);
    EXPECT_NEAR(modes[0].damping, 6 * inverse / (2 * w), 1e-12);
    // A torque on the crank turns both, and holds the crank ahead by its share of what the spring is twisted.
    const double held = j2 / (j1 + j2) * (j2 / (j1 + j2)) / 800;
    EXPECT_NEAR(modes[0].cylinder_radpnm[2], held, 1e-12);
    EXPECT_NEAR(modes[0].constant_radpnm, held, 1e-12);
    // Through the spring goes what the secondary needs.
    EXPECT_NEAR(modes[0].spring_nmprad * held, j2 / (j1 + j2), 1e-9);
    EXPECT_NEAR(modes[0].damper_nmprad / modes[0].spring_nmprad, 6 * w / 800, 1e-9);
}

/// Holzer's table: link after link along the chain, starting with amplitude 1; the torque left over at its end.
double torque_left(const EngineFile &engine, double w, std::vector<double> &shape) {
    const CrankTorsion &t = *engine.torsion;
    shape.assign(1, 1.0);
    double torque = t.front_inertia_kgm2 * w * w;
    for (int i = 0; i < engine.cylinders() + 1; ++i) {
        shape.push_back(shape.back() - torque / t.section_stiffness_nmprad);
        const double flywheel = engine.inertia_kgm2 - t.front_inertia_kgm2 - engine.cylinders() * t.throw_inertia_kgm2;
        torque += (i < engine.cylinders() ? t.throw_inertia_kgm2 : flywheel) * w * w * shape.back();
    }
    return torque;
}

TEST(CrankModes, ChainAgreesWithHolzer) {
    const EngineFile engine = with_torsion(true);
    const auto modes = crank_modes(engine, 3);
    ASSERT_EQ(modes.size(), 3u);
    std::vector<double> shape;
    for (const CrankMode &mode : modes) {
        const double w = mode.frequency_radps;
        EXPECT_LT(torque_left(engine, w * 0.9999, shape) * torque_left(engine, w * 1.0001, shape), 0) << w;
        torque_left(engine, w, shape);
        for (std::size_t lane = 0; lane < 4; ++lane) {
            const double ratio = shape[std::size_t(engine.firing_order[lane])] / shape.back();
            EXPECT_NEAR(mode.cylinder_radpnm[lane] / mode.constant_radpnm, ratio, 1e-6 * std::abs(ratio));
        }
        EXPECT_GT(mode.constant_radpnm * shape.back(), 0) << "the wheel at the front moves with shape 1";
        EXPECT_EQ(mode.damping, 0.03);
        EXPECT_EQ(mode.spring_nmprad, 0);
    }
    EXPECT_GT(crank_modes(with_torsion(false), 1)[0].constant_radpnm, 0) << "a wheel at the flywheel follows its torque";
    EXPECT_TRUE(crank_modes(engine_file(), 2).empty());
}

TEST(Twist, SwingsAsTheClosedForm) {
    KnownTorque none = known_torque();
    none.motored_per_bar.front() = none.motored.front();
    EngineFile engine = with_dual_mass();
    for (double stiffness : {100.0, 800.0, 20000.0, 100000.0}) {
        engine.dual_mass->stiffness_nmprad = stiffness;
        const KalmanTables made = kalman_tables(engine, none, {});
        const sd_kalman_mode_t &mode = made.tables.mode[0];
        sd_kalman_t filter;
        ASSERT_EQ(sd_kalman_init(&filter, &made.tables, &kChoice, 1), SD_OK);
        const double w = 20; // slow: a pitch is a long time
        sd_motion_t &motion = filter.filter[0].motion;
        filter.filter[0].running = 1, motion.energy_j = float(0.5 * double(made.tables.inertia_mean_kgm2) * w * w);
        motion.twist_rad[0] = 0.1f;
        sd_kalman_tooth_t tooth{};
        tooth.advance = 1, tooth.intake_bar = 1;
        sd_firing_t firing;
        for (int k = 1; k <= 7; ++k) {
            tooth.cycle_position = std::uint16_t(k);
            tooth.period_ticks = std::uint32_t(2 * M_PI / 60 / w * 1e8);
            sd_kalman_step(&filter, &made.tables, &tooth, &firing);
            const double z = double(mode.damping), f = double(mode.frequency_radps), t = k * 2 * M_PI / 60 / w, root = std::sqrt(1 - z * z);
            const double twist = 0.1 * std::exp(-z * f * t) * (std::cos(root * f * t) + z / root * std::sin(root * f * t));
            EXPECT_NEAR(double(motion.twist_rad[0]), twist, 2e-5) << stiffness << " Nm/rad, tooth " << k;
        }
    }
}

/// Twist of the wheel at alpha, the crank turning evenly: each harmonic of the torques through each mode.
class TwistedEdges {
  public:
    TwistedEdges(const TorqueSignal &signal, const std::vector<CrankMode> &modes) {
        const double w = signal.rpm * M_PI / 30;
        for (int h = 1; h <= kHarmonics; ++h) {
            std::complex<double> sum = 0;
            for (std::size_t lane = 0; lane < 4; ++lane) {
                std::complex<double> torque = 0; // of one cylinder: a quarter of the compression is not its own, but the sum's
                for (int i = 0; i < kGrid; ++i) {
                    const double alpha = 4 * M_PI * i / kGrid;
                    torque += 2.0 / kGrid * signal.fuel[lane] * pulse_of(lane, alpha) * std::polar(1.0, -h * alpha / 2);
                }
                for (const CrankMode &mode : modes) {
                    const double r = h * w / 2 / mode.frequency_radps;
                    sum += mode.cylinder_radpnm[lane] * torque / std::complex<double>(1 - r * r, 2 * mode.damping * r);
                }
            }
            series_.push_back(sum);
        }
    }
    double twist(double alpha) const { return at(alpha, 0); }
    double slope(double alpha) const { return at(alpha, 1); } ///< A rad of crank angle.

  private:
    double at(double alpha, int derivative) const {
        double sum = 0;
        for (int h = 1; h <= kHarmonics; ++h)
            sum += std::real(series_[std::size_t(h - 1)] * (derivative ? std::complex<double>(0, h / 2.0) : 1.0) * std::polar(1.0,
                h * alpha / 2));
        return sum;
    }
    static constexpr int kHarmonics = 60, kGrid = 2880;
    std::vector<std::complex<double>> series_;
};

/// Largest error of a firing less the mean of its cycle, share of the mean torque, of a filter with these tables.
double worst_imbalance(const sd_kalman_tables_t &tables, const TorqueSignal &signal, const std::vector<CrankMode> &modes) {
    Bench bench(tables, Edges(signal, 0, 0, 1));
    const TwistedEdges twisted(signal, modes);
    const double w = signal.rpm * M_PI / 30;
    bench.earlier_s = [&](int k) {
        const double alpha = 2 * M_PI * k / kPositions;
        return twisted.twist(alpha) / (1 + twisted.slope(alpha)) / w;
    };
    bench.run(60);
    double error[4], mean = 0, worst = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const sd_firing_t &said = bench.firings[bench.firings.size() - 4 + i].said;
        error[i] = double(said.torque_nm) / pulse_mean() - signal.fuel[said.index];
        mean += error[i] / 4;
    }
    for (double e : error) worst = std::max(worst, std::abs(e - mean));
    return worst;
}

TEST(Twist, FiringsAreFoundOnAWheelThatSwings) {
    KnownTorque known = known_torque();
    known.motored_per_bar.front() = known.motored.front();
    TorqueSignal signal;
    signal.compression_nm = 0;
    for (double rpm : {3000.0, 4500.0}) {
        signal.rpm = rpm;
        EngineFile engine = with_torsion(true);
        engine.reciprocating_mass_kg = signal.recip_mass_kg = 0;
        const auto modes = crank_modes(engine, SD_KALMAN_MODES_MAX);
        const KalmanTables twisting = kalman_tables(engine, known, {});
        EXPECT_LT(twisting.radius_between, 1);
        engine.torsion.reset();
        const KalmanTables rigid = kalman_tables(engine, known, {});
        EXPECT_LT(worst_imbalance(twisting.tables, signal, modes), 0.01) << rpm;
        EXPECT_GT(worst_imbalance(rigid.tables, signal, modes), 0.05) << rpm;
    }
}

/// Every cylinder turns the crank alike and as the tables know, so that only its place in the modes makes half orders. Gently:
/// TwistedEdges takes the crank's speed for even.
constexpr double kGently = 0.5;

KnownTorque driven() {
    KnownTorque known = known_torque();
    for (std::size_t lane = 0; lane < 4; ++lane) known.motored_per_bar[lane] = [=](double a) { return kGently * pulse_of(lane, a); };
    return known;
}

EngineFile stiffer(double frequency_ratio) {
    EngineFile engine = with_torsion(true);
    engine.reciprocating_mass_kg = 0;
    engine.torsion->section_stiffness_nmprad *= frequency_ratio * frequency_ratio;
    return engine;
}

/// Cycles of a crank whose modes swing at a ratio of what the tables say.
void motor(sd_pattern_t &pattern, const sd_kalman_tables_t &tables, double ratio, double rpm, int cycles, double pattern_deg) {
    TorqueSignal signal;
    signal.compression_nm = signal.recip_mass_kg = 0;
    signal.fuel.assign(4, kGently);
    signal.rpm = rpm;
    Bench bench(tables, Edges(signal, 0.01, pattern_deg, unsigned(rpm)));
    const TwistedEdges twisted(signal, crank_modes(stiffer(ratio), SD_KALMAN_MODES_MAX));
    bench.earlier_s = [&](int k) {
        const double alpha = 2 * M_PI * k / kPositions;
        return twisted.twist(alpha) / (1 + twisted.slope(alpha)) / (rpm * M_PI / 30);
    };
    bench.take = [&](const sd_kalman_tooth_t &tooth) { sd_pattern_step(&pattern, &tables, &tooth); };
    bench.run(cycles);
    sd_pattern_pause(&pattern);
}

const sd_kalman_tables_t &twisting_tables() {
    static const KalmanTables made = kalman_tables(stiffer(1), driven(), {});
    return made.tables;
}

TEST(Twist, FrequencyIsLearnedWhileMotored) {
    for (double ratio : {0.95, 0.985, 1.0, 1.05}) {
        sd_pattern_t pattern;
        sd_pattern_init(&pattern, &twisting_tables());
        for (double rpm : {4060.0, 3160.0}) motor(pattern, twisting_tables(), ratio, rpm, 60, 0.02);
        const double error = double(pattern.sums.twist.deviation) - (ratio - 1), stated = double(sd_twist_sd(&pattern.sums.twist));
        EXPECT_LT(std::abs(error), 0.0025) << ratio;
        EXPECT_LT(std::abs(error), 3 * stated) << ratio;
        EXPECT_GT(pattern.sums.cycles, 40) << "the pattern is learned when the frequency is known";
    }
}

TEST(Twist, AFasterModeIsTheSameModeAtALowerSpeed) {
    const double w = 3000 * M_PI / 30, ratio = 1.04;
    const ToothModel faster = tooth_model(stiffer(ratio), driven(), ratio * w), tables = tooth_model(stiffer(1), driven(), w);
    ASSERT_EQ(faster.modes.size(), 2u);
    for (std::size_t m = 0; m < 2; ++m) {
        EXPECT_NEAR(faster.modes[m].a, tables.modes[m].a, 1e-9);
        EXPECT_NEAR(faster.modes[m].b, tables.modes[m].b, 1e-9);
        EXPECT_LT((faster.modes[m].compliance - tables.modes[m].compliance).norm(), 1e-9 * tables.modes[m].compliance.norm());
    }
    // And so the firmware takes the gains, the frequencies and the twist that a torque holds.
    sd_kalman_t filter;
    ASSERT_EQ(sd_kalman_init(&filter, &twisting_tables(), &kChoice, 1), SD_OK);
    const sd_twist_sums_t sums{0.04f, 1e-6f, 0};
    filter.tuning = sd_twist_tuning(&sums);
    EXPECT_FLOAT_EQ(filter.tuning.frequency, 1.04f);
    EXPECT_FLOAT_EQ(filter.tuning.gain_speed, 1 / 1.04f);
    EXPECT_FLOAT_EQ(filter.tuning.compliance, 1 / (1.04f * 1.04f));
    sd_kalman_restart(&filter);
    EXPECT_FLOAT_EQ(filter.tuning.frequency, 1.04f) << "a restart keeps it";
}

TEST(Twist, KeptFrequencyGoesOnAndAWrongOneIsRefused) {
    sd_pattern_t pattern;
    sd_pattern_init(&pattern, &twisting_tables());
    sd_pattern_sums_t sums = pattern.sums;
    sums.twist = {0.03f, 1e-7f, 1e-4f};
    ASSERT_EQ(sd_pattern_resume(&pattern, &twisting_tables(), &sums), SD_OK);
    EXPECT_FLOAT_EQ(pattern.tuning.frequency, 1.03f);
    motor(pattern, twisting_tables(), 1.03, 4500, 20, 0);
    EXPECT_NEAR(double(pattern.sums.twist.deviation), 0.03, 0.001);
    const auto refused = [&](sd_twist_sums_t twist, const sd_kalman_tables_t &tables) {
        sums.twist = twist;
        return sd_pattern_resume(&pattern, &tables, &sums) == SD_ERR_CONFIG;
    };
    EXPECT_TRUE(refused({NAN, 1e-7f, 0}, twisting_tables()));
    EXPECT_TRUE(refused({0.11f, 1e-7f, 0}, twisting_tables()));
    EXPECT_TRUE(refused({0, NAN, 0}, twisting_tables()));
    EXPECT_TRUE(refused({0, 0, 0}, twisting_tables())) << "of a rigid crank";
    EXPECT_TRUE(refused({0, 1e-3f, 0}, pulse_tables().tables)) << "of a crank that twists";
    EXPECT_FALSE(refused({0, 0, 0}, pulse_tables().tables));
}

TEST(Twist, BadTeethNeverGiveNan) {
    const KalmanTables made = kalman_tables(with_torsion(true), known_torque(), {});
    ASSERT_EQ(made.tables.modes, 2);
    sd_kalman_t filter;
    ASSERT_EQ(sd_kalman_init(&filter, &made.tables, &kChoice, 1), SD_OK);
    std::mt19937 random(7);
    sd_firing_t firing{};
    sd_pattern_t pattern;
    sd_pattern_init(&pattern, &made.tables);
    const sd_motion_t &motion = filter.filter[0].motion;
    for (int i = 0; i < 20000; ++i) {
        sd_kalman_tooth_t tooth{};
        tooth.cycle_position = std::uint16_t(i % 300 < 200 ? i % 120 : random() % 130);
        tooth.advance = std::uint16_t(i % 300 < 200 ? 1 : random() % 5);
        tooth.period_ticks = random() % 3 == 0 ? std::uint32_t(random()) : 30000 + random() % 2000000;
        tooth.trusted = random() % 8 != 0;
        tooth.intake_bar = random() % 7 == 0 ? NAN : 1.f;
        sd_kalman_step(&filter, &made.tables, &tooth, &firing);
        sd_pattern_step(&pattern, &made.tables, &tooth);
        ASSERT_TRUE(std::isfinite(pattern.sums.twist.deviation) && pattern.sums.twist.variance > 0) << i;
        ASSERT_TRUE(std::isfinite(motion.energy_j) && std::isfinite(sd_kalman_torque(&filter, &made.tables, 0, 7)) &&
                    std::isfinite(firing.sd_nm)) << i;
        for (std::size_t m = 0; m < 2; ++m) ASSERT_TRUE(std::isfinite(motion.twist_rad[m]) && std::isfinite(motion.swing_rad[m])) << i;
        for (float x : motion.coefficient_nm) ASSERT_TRUE(std::isfinite(x)) << i;
    }
}

TEST(Twist, ModesOutOfRangeAreRefused) {
    const KalmanTables made = kalman_tables(with_torsion(true), known_torque(), {});
    sd_kalman_t filter{};
    const auto refused = [&](auto change) {
        sd_kalman_tables_t tables = made.tables;
        change(tables);
        return sd_kalman_init(&filter, &tables, &kChoice, 1) == SD_ERR_CONFIG;
    };
    EXPECT_TRUE(refused([](auto &t) { t.modes = 3; }));
    EXPECT_TRUE(refused([](auto &t) { t.firings = 0; }));
    EXPECT_TRUE(refused([](auto &t) { t.pool[9 * t.row_words].at.close = 16; }));
    EXPECT_TRUE(refused([](auto &t) { t.mode[1].frequency_radps = NAN; }));
    EXPECT_TRUE(refused([](auto &t) { t.mode[0].damping = 1; }));
    EXPECT_TRUE(refused([](auto &t) { t.mode[0].cylinder_radpnm[3] = INFINITY; }));
    EXPECT_FALSE(refused([](auto &) {}));
}

} // namespace
} // namespace sixdeg
