// SPDX-License-Identifier: MIT
// The tooth pattern learned while the engine fires, on an engine by other equations (other_engine.hpp). Prints what
// docs/results/firing-learning.md quotes; SD_FULL=1 adds other injectors and a wrong engine file.
#include "design/torque/fired_tables.hpp"
#include "support/other_bench.hpp"

namespace sixdeg {
namespace {

using namespace test;

constexpr double kDeg = M_PI / 180;

/// Of the teeth, their mean taken out.
double pattern_error_deg(const OtherBench &bench, const float *late_rad) {
    double mean = 0, square = 0;
    for (int k = 0; k < 58; ++k) mean += (double(late_rad[k]) - bench.late_rad[k]) / 58;
    for (int k = 0; k < 58; ++k) square += std::pow(double(late_rad[k]) - bench.late_rad[k] - mean, 2) / 58;
    return std::sqrt(square) / kDeg;
}

OtherEngine kind_of(double gamma, bool wrong_file = false) {
    OtherEngine kind;
    kind.gamma = gamma;
    if (wrong_file) kind.j0_kgm2 *= 0.97, kind.compression_ratio *= 1.02, kind.start_deg = -0.5;
    return kind;
}

struct FiredBench : OtherBench {
    explicit FiredBench(unsigned of_seed, const OtherEngine &of, double pattern = 0.2) : OtherBench(of, pattern) {
        seed = of_seed;
        fuel = {1.1, 1, 1, 0.8};
    }
    /// Steady points of 5 s each, 60 s in all. What a mg of fuel gives differs between them by 4 %, and the firings by what injectors do.
    void drive(double injectors_percent) {
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        for (const Point &at : {Point{1000, 1.1, 400}, {1000, 1.2, 750}, {1500, 1.1, 500}, {1500, 1.4, 1300}, {2000, 1.2, 900},
                                {2000, 1.6, 1600}, {3000, 1.2, 400}, {3000, 1.4, 1000}, {3000, 1.8, 1700}, {4000, 1.2, 500},
                                {4500, 1.3, 900}, {4500, 1.6, 1500}}) {
            const double efficiency = 0.4 * (1 + 0.04 * normal(random)), apart = injectors_percent / 100 * normal(random);
            fuel_mg = at.heat_j / (42 * efficiency);
            fuel = {1.1 + apart, 1 - apart, 1 + apart, 0.8 - apart};
            run(engine(at.rpm, at.intake_bar, at.heat_j), int(at.rpm / 24), false);
        }
        fuel = {1.1, 1, 1, 0.8}, fuel_mg = -1;
    }
    const sd_fired_pattern_t &fired() const { return *sd_fired_used(&block.fired); }
    double error_deg() const { return pattern_error_deg(*this, fired().late_rad); }
    double stated_deg() const { return double(fired().sd_rad) / kDeg; }
};

double rms(const std::vector<double> &values) {
    double square = 0;
    for (double value : values) square += value * value / double(values.size());
    return std::sqrt(square);
}

/// Rms over wheels of imbalance and of its ratio to what is stated, at 1000, 3000 and 4500 rpm; of the pattern's error in both ways, too.
struct AfterDrives {
    std::vector<double> percent, over_stated;
    double error_deg = 0, error_over_stated = 0;
};

AfterDrives after_drives(bool wrong_file, double injectors_percent) {
    std::vector<double> error, ratio, percent[3], stated[3];
    for (unsigned seed = 21; seed < 45; ++seed) {
        FiredBench bench(seed, kind_of(seed % 2 == 0 ? 1.30 : 1.35, wrong_file));
        bench.drive(injectors_percent);
        error.push_back(bench.error_deg()), ratio.push_back(bench.error_deg() / bench.stated_deg());
        for (std::size_t i = 0; i < 3; ++i) {
            const Imbalance at = imbalance(bench, {std::vector<double>{1000, 3000, 4500}[i], 1.2, 750}, 80);
            percent[i].push_back(at.mean_percent), stated[i].push_back(at.over_stated);
        }
    }
    AfterDrives out{{}, {}, rms(error), rms(ratio)};
    for (std::size_t i = 0; i < 3; ++i) out.percent.push_back(rms(percent[i])), out.over_stated.push_back(rms(stated[i]));
    for (const auto &[name, value] : {std::pair("pattern_deg", out.error_deg), {"pattern_over_stated", out.error_over_stated},
                                      {"imbalance_1000", out.percent[0]}, {"imbalance_3000", out.percent[1]},
                                      {"imbalance_4500", out.percent[2]},
                                      {"over_stated_1000", out.over_stated[0]}, {"over_stated_3000", out.over_stated[1]},
                                      {"over_stated_4500", out.over_stated[2]}})
        std::printf("%s %s, injectors %g %%: %.4f\n", wrong_file ? "wrong file" : "right file", name, injectors_percent, value);
    return out;
}

TEST(Fired, PatternAndImbalanceAfterADriveOfAMinute) {
    const bool full = std::getenv("SD_FULL") != nullptr;
    for (double injectors : full ? std::vector<double>{0, 0.5} : std::vector<double>{0.5}) {
        const AfterDrives right = after_drives(false, injectors);
        EXPECT_LT(right.error_deg, 0.004);
        EXPECT_LT(right.error_over_stated, 1.5);
        EXPECT_LT(right.percent[0], 0.25);
        EXPECT_LT(right.percent[1], 0.35);
        EXPECT_LT(right.percent[2], 0.75);
        for (double ratio : right.over_stated) EXPECT_LT(ratio, 1.3);
    }
    if (!full) return;
    const AfterDrives wrong = after_drives(true, 0.5);
    EXPECT_LT(wrong.error_deg, 0.008);
    EXPECT_LT(wrong.percent[0], 0.6);
    EXPECT_LT(wrong.percent[1], 0.7);
    EXPECT_LT(wrong.percent[2], 1.2);
}

TEST(Fired, OnePointSaysWhatItDoesNotKnow) {
    for (const Point &at : {Point{1000, 1.2, 750}, {3000, 1.4, 1000}, {4500, 1.4, 1000}}) {
        for (double mg : {-1., 40.}) {
            FiredBench bench(8, kind_of(1.35));
            bench.fuel_mg = mg;
            bench.run(bench.engine(at.rpm, at.intake_bar, at.heat_j), int(at.rpm / 10), false);
            EXPECT_LT(bench.error_deg(), 0.04) << "of 0.2";
            EXPECT_LT(bench.error_deg(), bench.stated_deg());
            EXPECT_GT(bench.stated_deg(), 0.035) << "two directions look like torque";
            EXPECT_LT(double(bench.fired().tooth_rad), 0.7 * double(bench.fired().sd_rad));
            const Imbalance found = imbalance(bench, {at.rpm, 1.2, 750}, 80);
            EXPECT_LT(found.over_stated, 1.5) << at.rpm << " rpm: firings say so too";
        }
    }
}

TEST(Fired, IsKeptAndTakenUpAgain) {
    FiredBench first(31, kind_of(1.33)), second(31, kind_of(1.33));
    first.drive(0.5);
    sd_pattern_sums_t sums;
    sd_firings_keep(&first.block, &first.tables, &sums);
    ASSERT_EQ(sd_firings_resume(&second.block, &second.tables, &sums), SD_OK);
    for (int k = 0; k < 58; ++k) EXPECT_NEAR(second.fired().late_rad[k], first.fired().late_rad[k], 2e-5);
    EXPECT_NEAR(second.stated_deg(), first.stated_deg(), 2e-4);
    const sd_firings_pattern_t believed = sd_firings_believed(&second.block);
    EXPECT_EQ(believed.late_rad, second.fired().late_rad);
    EXPECT_EQ(believed.cycles, sums.fired.cycles);
    for (auto spoil : {+[](sd_pattern_sums_t &s) { s.fired.late[3] = NAN; }, +[](sd_pattern_sums_t &s) { s.fired.late[59] = 1e-3f; },
                       +[](sd_pattern_sums_t &s) { s.fired.hidden[0].c[0] = -1; }, +[](sd_pattern_sums_t &s) { s.fired.psi2 = -1; }}) {
        sd_pattern_sums_t bad = sums;
        spoil(bad);
        EXPECT_EQ(sd_firings_resume(&second.block, &second.tables, &bad), SD_ERR_CONFIG);
    }
}

TEST(Fired, AFuelCutThatKnowsBetterIsBelieved) {
    FiredBench bench(32, kind_of(1.33));
    bench.drive(0.5);
    for (int i = 0; i < 2; ++i) bench.fuel_cut(1500, 80), bench.fuel_cut(3000, 80);
    const sd_firings_pattern_t believed = sd_firings_believed(&bench.block);
    EXPECT_EQ(believed.late_rad, bench.learned().late_rad);
    EXPECT_LT(believed.sd_rad, bench.fired().sd_rad);
    EXPECT_EQ(believed.hidden_share, 0);
}

TEST(Fired, TeethThatInterruptTheTaskChangeNothingOfIt) {
    FiredBench first(33, kind_of(1.33)), last(33, kind_of(1.33));
    first.task = OtherBench::Task::kFirst, last.task = OtherBench::Task::kLast;
    for (FiredBench *bench : {&first, &last}) {
        bench->fuel_mg = 60;
        for (double rpm : {1000., 3000., 6000.}) bench->run(bench->engine(rpm, 1.4, 1000), int(rpm / 25), false);
    }
    sd_firings_task_work(&last.block, &last.tables); // of the last clock
    EXPECT_GT(first.fired().cycles, 300);
    EXPECT_GT(first.block.pattern.sums.fired.hidden[0].c[0], 0) << "fuel was known";
    EXPECT_EQ(std::memcmp(&first.block, &last.block, sizeof first.block), 0);
}

/// What is taken for torque and what for pattern, against equations solved by themselves.
TEST(Fired, TablesTellPatternFromTorque) {
    for (const char *name : {"diesel_22.toml", "vee6_uneven.toml", "triple_10.toml", "single_generator.toml"}) {
        TomlFile file(std::filesystem::path(SD_ENGINES) / name);
        const EngineFile engine = read_engine(file);
        TomlFile tune("tune", "");
        const FiredTables fired = fired_tables(engine, *known_torque(engine, read_tune(tune)));
        const int n = engine.wheel.positions, parts = 3 + engine.cylinders();
        EXPECT_LT((fired.columns.transpose() * fired.columns - Eigen::MatrixXd::Identity(parts, parts)).norm(), 1e-9);
        Eigen::VectorXd pattern(n);
        std::mt19937 random(3);
        for (int k = 0; k < n; ++k) pattern(k) = std::normal_distribution<double>()(random);
        for (int k : engine.wheel.missing) pattern(k) = 0;
        Eigen::VectorXd both(2 * n);
        both << pattern, pattern;
        both += fired.columns * Eigen::VectorXd::LinSpaced(parts, -3, 5); // any torque
        const Eigen::VectorXd rest = both - fired.columns * (fired.columns.transpose() * both), m = (rest.head(n) + rest.tail(n)) / 2;
        const Eigen::MatrixXd half = (fired.columns.topRows(n) + fired.columns.bottomRows(n)) / 2;
        Eigen::VectorXd left = pattern - (m + half * (fired.restore * (half.transpose() * m)));
        for (const HiddenPattern &hidden : fired.hidden) {
            const Eigen::VectorXd v = half * hidden.pattern;
            EXPECT_NEAR(v.norm(), 1, 1e-9);
            EXPECT_NEAR(v.sum(), 0, 1e-9);
            left -= v * v.dot(left);
            Eigen::VectorXd twice(2 * n);
            twice << v, v;
            EXPECT_NEAR(hidden.from_parts.dot(fired.columns.transpose() * twice), 1, 0.02) << "read as torque over J w^2 as large as it is";
        }
        const double constant = left.sum() / engine.wheel.teeth();
        for (int k = 0; k < n; ++k) {
            if (std::count(engine.wheel.missing.begin(), engine.wheel.missing.end(), k) > 0) continue;
            EXPECT_NEAR(left(k), constant, 0.02) << name << ", tooth " << k << ": what is left is phase";
        }
    }
}

} // namespace
} // namespace sixdeg
