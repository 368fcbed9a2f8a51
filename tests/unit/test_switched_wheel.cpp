// SPDX-License-Identifier: MIT
// Document 000's observers on the toothed wheel: on a crank of this file's own, whose firings are torques over angle, and on the
// simulated engine, where the table of docs/results/observers.md comes from.
#include <cmath>
#include <gtest/gtest.h>
#include <memory>
#include <vector>

#include "design/calibration.hpp"
#include "design/misfire/wheel_design.hpp"
#include "studies/observers/misfire_detection.hpp"

using namespace sixdeg;

namespace {

constexpr double kPitch = 2 * M_PI / 60, kWork = 400, kSpeed = 200;

EngineFile diesel() {
    TomlFile file(std::filesystem::path(SD_ENGINES) / "diesel_22.toml");
    return read_engine(file);
}

const sd_calibration_t &page() {
    static const auto made = [] {
        TomlFile tune("tune", "");
        return std::make_unique<sd_calibration_t>(calibrate(diesel(), read_tune(tune), "tune"));
    }();
    return *made;
}

struct F32 {
    using State = sd_wheel_f32_t;
    using Config = sd_wheel_config_f32_t;
    using Verdict = sd_wheel_verdict_f32_t;
    static constexpr auto init = sd_wheel_init_f32;
    static constexpr auto tooth = sd_wheel_tooth_f32;
    static constexpr auto judge = sd_wheel_judge_f32;
    static constexpr auto restart = sd_wheel_restart_f32;
    static float in(double x) { return float(x); }
    static double out(float x) { return double(x); }
};
struct Q31 {
    using State = sd_wheel_q31_t;
    using Config = sd_wheel_config_q31_t;
    using Verdict = sd_wheel_verdict_q31_t;
    static constexpr auto init = sd_wheel_init_q31;
    static constexpr auto tooth = sd_wheel_tooth_q31;
    static constexpr auto judge = sd_wheel_judge_q31;
    static constexpr auto restart = sd_wheel_restart_q31;
    static sd_q31_t in(double x) { return sd_from_float_q31(float(x)); }
    static double out(sd_q31_t x) { return double(sd_to_float_q31(x)); }
};

template <class V> typename V::Config config(sd_wheel_kind_t kind = SD_WHEEL_FOLSMO) {
    typename V::Config c{};
    c.definition = V::in(0.5), c.work_min = V::in(0.002), c.speed_change = V::in(0.3);
    c.start_firings = 16, c.hold_firings = 8, c.kind = std::uint8_t(kind);
    return c;
}

/// A crank of constant inertia whose firings give `work(firing)` evenly over 60 deg from 5 deg after TDC, against a constant load.
template <class V> struct Crank {
    typename V::State wheel{};
    double energy = kSpeed * kSpeed / 2;
    long k = 0, firings = 0;
    std::vector<typename V::Verdict> said;

    explicit Crank(sd_wheel_kind_t kind = SD_WHEEL_FOLSMO) {
        const auto c = config<V>(kind);
        EXPECT_EQ(SD_OK, V::init(&wheel, &c, &page().wheel));
    }
    /// `gives` and `told`: of the firing whose TDC passed last, J; `missing` teeth are passed without an edge.
    template <class Work> void cycles(int count, Work gives, double load_j = kWork, double told = kWork) {
        const sd_wheel_tables_t &t = page().wheel;
        for (long end = k + count * 120; k < end;) {
            const long position = (k + 1) % 120, since = ((position - page().firing_position[0]) % 30 + 30) % 30;
            const long firing = (k + 1 - page().firing_position[0] + 120) / 30 - 4;
            const double before = energy;
            if (since >= 1 && since <= 10) energy += gives(firing) / 10 / inertia;
            energy -= load_j / 30 / inertia;
            const double j = t.inertia_q31[position % 60] / 2147483648.0, speed = std::sqrt((before + energy) / j); // mean of j w^2/2
            ++k;
            const auto period = std::uint32_t(std::lround(kPitch * double(page().tick_hz) / speed));
            const sd_wheel_tooth_t tooth{std::uint16_t(position), 1, period, 1};
            const std::uint32_t read = V::tooth(&wheel, &t, &tooth, V::in(told / std::ldexp(1, t.work_exponent)));
            if (read == 0) continue;
            typename V::Verdict v;
            V::judge(&wheel, &t, read - 1, 0, &v);
            said.push_back(v);
        }
    }
    double index(std::size_t i) const { return 16 * V::out(said[i].index); }
    std::size_t misfires(std::size_t from = 0) const {
        std::size_t count = 0;
        for (std::size_t i = from; i < said.size(); ++i) count += said[i].verdict == SD_MISFIRE;
        return count;
    }
    double inertia = wheel_model(diesel()).inertia_kgm2;
};

template <class V> struct Wheel : ::testing::Test {};
using Variants = ::testing::Types<F32, Q31>;
TYPED_TEST_SUITE(Wheel, Variants);

TYPED_TEST(Wheel, AHealthyEngineIsHealthyAndTheFirstCyclesAreNotJudged) {
    Crank<TypeParam> crank;
    crank.cycles(40, [](long) { return kWork; });
    ASSERT_GT(crank.said.size(), 150u);
    EXPECT_EQ(SD_NOT_JUDGED, crank.said[3].verdict);
    for (std::size_t i = 60; i < crank.said.size(); ++i) {
        EXPECT_EQ(SD_HEALTHY, crank.said[i].verdict);
        EXPECT_NEAR(1, crank.index(i), 0.1);
    }
}

TYPED_TEST(Wheel, OneMisfireIsFoundAndNamed) {
    Crank<TypeParam> crank;
    crank.cycles(40, [](long) { return kWork; });
    const std::size_t before = crank.said.size();
    const long fails = crank.k / 30 + 5;
    crank.cycles(10, [&](long firing) { return firing == fails ? 0.0 : kWork; });
    ASSERT_EQ(1u, crank.misfires(before));
    for (std::size_t i = before; i < crank.said.size(); ++i) {
        if (crank.said[i].verdict != SD_MISFIRE) continue;
        EXPECT_EQ(fails % 4, crank.said[i].firing);
        EXPECT_NEAR(0, crank.index(i), 0.2);
        EXPECT_LT(TypeParam::out(crank.said[i].residual), 0);
    }
}

TYPED_TEST(Wheel, ALoadThatRisesAtOnceIsNotAMisfireForLong) {
    Crank<TypeParam> crank;
    crank.cycles(40, [](long) { return kWork; });
    const std::size_t before = crank.said.size();
    crank.cycles(30, [](long) { return kWork; }, 1.9 * kWork);
    EXPECT_LE(crank.misfires(before), 12u);
    EXPECT_EQ(0u, crank.misfires(before + 24));
}

TYPED_TEST(Wheel, UnknownAndLittleFuelAreNotJudged) {
    for (double told : {-1.0, 1.0}) {
        Crank<TypeParam> crank;
        crank.cycles(20, [](long) { return 0.0; }, 0, told);
        for (std::size_t i = 0; i < crank.said.size(); ++i) {
            const auto &v = crank.said[i];
            EXPECT_EQ(SD_NOT_JUDGED, v.verdict);
            if (i < 4) continue; // their TDC was before the first tooth
            EXPECT_NE(0, v.inhibit & (told < 0 ? SD_INHIBIT_OUTSIDE : SD_INHIBIT_FUEL_CUT));
        }
    }
}

TYPED_TEST(Wheel, InitRefusesWhatIsOutOfRange) {
    typename TypeParam::State s{};
    const auto init = [&](auto spoil) {
        auto c = config<TypeParam>();
        spoil(c);
        return TypeParam::init(&s, &c, &page().wheel);
    };
    EXPECT_EQ(SD_OK, init([](auto &) {}));
    EXPECT_EQ(SD_ERR_CONFIG, init([](auto &c) { c.definition = TypeParam::in(0.1); }));
    EXPECT_EQ(SD_ERR_CONFIG, init([](auto &c) { c.work_min = 0; }));
    EXPECT_EQ(SD_ERR_CONFIG, init([](auto &c) { c.kind = SD_WHEEL_KINDS; }));
    const auto c = config<TypeParam>();
    const sd_wheel_tables_t none{};
    EXPECT_EQ(SD_ERR_CONFIG, TypeParam::init(&s, &c, &none));
}

TEST(WheelDesign, NumbersComeFromTheEngineFile) {
    const EngineFile engine = diesel();
    const WheelModel model = wheel_model(engine);
    EXPECT_NEAR(-1.6, model.pulse_start_deg, 1);
    EXPECT_NEAR(36, model.pulse_deg, 6);
    EXPECT_NEAR(1.44, model.k2_per_rad, 0.2);
    const double k1 = model.k1_per_rad2() + model.luenberger_per_rad2();
    EXPECT_NEAR(1 / std::sqrt(2.0), model.damping_per_rad() / (2 * std::sqrt(k1)), 1e-9);
    for (const auto kind : {SD_WHEEL_FOLSMO, SD_WHEEL_FOSMO, SD_WHEEL_ROO}) {
        const WheelCapture capture = wheel_capture(engine, model, kind);
        EXPECT_GT(capture.share, 0.3);
        EXPECT_LT(capture.share, 1.2);
    }
    EngineFile lighter = engine;
    lighter.inertia_kgm2 /= 2;
    EXPECT_NEAR(model.k2_per_rad, wheel_model(lighter).k2_per_rad, 1e-9) << "of the pulse alone";
}

const DetectionRow &row(const Detection &d, const std::string &method) {
    for (const DetectionRow &r : d.rows) {
        if (r.method == method) return r;
    }
    throw std::logic_error("no such row");
}

/// A small version of the table in docs/results/observers.md, bounded on both sides.
TEST(MisfireDetection, FolsmoInTheEcuFindsWhatNobodyToldItOf) {
    for (const DetectionCell &cell : {DetectionCell{6000, 1, false}, DetectionCell{1500, 1, true}}) {
        const Detection d = run_detection(detection_scenario(cell, 700, 1), {});
        const MisfireFigures &folsmo = row(d, "FOLSMO").figures, &roo = row(d, "ROO").figures, &monitor = row(d, "monitor").figures;
        ASSERT_GT(folsmo.missed, 40u);
        EXPECT_GE(double(folsmo.detected), 0.956 * double(folsmo.missed)) << cell.rpm;
        EXPECT_LE(double(folsmo.false_alarms), (cell.rpm > 3000 ? 0.011 : 0.001) * double(folsmo.healthy)) << cell.rpm;
        EXPECT_GT(folsmo.separation(), 9);
        EXPECT_LT(folsmo.separation(), monitor.separation()) << "the monitor knows the pulses and every tooth's time";
        EXPECT_LT(roo.separation(), folsmo.separation());
        EXPECT_LE(1000 * d.differing, d.compared) << "f32 and q31";
        EXPECT_GT(d.compared, 7000u);
        EXPECT_FALSE(d.run.stalled);
    }
}

} // namespace
