// SPDX-License-Identifier: MIT
// The guard filter in fixed point beside the one in floating point, on the same teeth.
#include <cstring>
#include <functional>
#include <gtest/gtest.h>
#include <limits>
#include <memory>
#include <random>

#include "plant/engine/units.hpp"
#include "studies/driveline/fixed_beside.hpp"

using namespace sixdeg;

namespace {

DriveCase drive_of(double seconds) {
    DriveCase c = usual_drive();
    c.duration_s = seconds;
    return c;
}

sd_driveline_tables_t usual_tables() { return guard_tables(Driveline(), GuardBelief(), 60, 1e-6); }

struct Drive {
    const char *name;
    std::function<void(DriveCase &)> change;
};

const Drive kDrives[] = {{"nominal", [](DriveCase &) {}},
                         {"damping", [](DriveCase &c) { c.real.damping_nms *= 1.3; }},
                         {"ripple", [](DriveCase &c) { c.ripple_nm = 60; }},
                         {"slope", [](DriveCase &c) { c.slope_nm = 50; }},
                         {"guard in torque", [](DriveCase &c) { c.guard = SD_GUARD_TORQUE; }},
                         {"wheel teeth", [](DriveCase &c) {
                              c.wheel_jitter_deg = 0.05;
                              c.belief.wheel_jitter_rad = 0.05 * kRadPerDeg;
                              c.belief.twist_walk_rad = 1e-3;
                          }}};

} // namespace

TEST(FixedGuard, SaysWhatTheOneInFloatingPointSays) {
    for (const Drive &drive : kDrives) {
        SCOPED_TRACE(drive.name);
        DriveCase c = drive_of(60);
        drive.change(c);
        const Beside b = fixed_beside(c);
        EXPECT_GT(b.teeth, 60000);
        EXPECT_LT(b.other_location, 3e-4 * b.teeth);
        // A tenth of the goal for the torsion, which rounding of f32 takes; where one settles anew and the other does not, the error's
        // size.
        EXPECT_LT(b.twist_apart_rms_rad, std::max(5e-6, 0.3 * b.f32.twist_rms_rad));
        EXPECT_LT(b.q31.twist_rms_rad, 1.05 * b.f32.twist_rms_rad);
        EXPECT_NEAR(b.q31.wrong_percent, b.f32.wrong_percent, 0.01 + 0.02 * b.f32.wrong_percent);
    }
}

TEST(FixedGuard, SaysTheSameOfTeethThatAreWrong) {
    const sd_driveline_tables_t tables = usual_tables();
    GuardFilter f32(tables, false), q31(tables, true);
    int other_location = 0;
    const auto both = [&](std::uint32_t period, int advance, int gear, sd_health_t health = SD_VALID) {
        sd_driveline_tooth_f32_t tooth{};
        tooth.period_ticks = period;
        tooth.advance = std::uint16_t(advance);
        tooth.gear = std::uint8_t(gear);
        tooth.health = health;
        tooth.torque_nm = 20;
        f32.step(tooth);
        q31.step(tooth);
        other_location += f32.out().location != q31.out().location;
        EXPECT_EQ(f32.out().moving, q31.out().moving);
        EXPECT_EQ(f32.out().status.health, q31.out().status.health);
        EXPECT_EQ(f32.out().status.why, q31.out().status.why);
        EXPECT_EQ(f32.rejected(), q31.rejected());
        // A wheel at 26 rad/s moves by 2e-6 at least in f32, and not at all for less than 0.2 N m at 2000 rpm: q31 has 8 times as fine
        // steps.
        const double late = double(f32.out().status.innovation);
        EXPECT_NEAR(q31.out().status.innovation, late, 5e-6 + 2e-5 * std::abs(late));
        EXPECT_NEAR(q31.out().status.test_ratio, std::abs(double(q31.out().status.innovation)) * double(tables.per_reject), 1e-5);
    };
    int valid = 0, left_out = 0;
    for (int round = 0; round < 3; ++round) {
        for (int i = 0; i < 2000; ++i) both(500, 1, 1);
        valid += q31.out().status.health == SD_VALID;
        both(1500, 3, 1);
        both(500, 1, 1, SD_DEGRADED);
        both(900, 1, 1);
        left_out += q31.out().status.why == SD_WHY_REJECTED;
        for (int i = 0; i < 9; ++i) both(900, 1, 1);
        both(0, 1, 1);
        both(500, 0, 1);
        both(500, 121, 1);
        both(500, 1, 2);
        both(500, 1, 0);
        EXPECT_EQ(q31.out().status.why, SD_WHY_NO_INPUT);
    }
    EXPECT_LE(other_location, 2); // a tooth earlier or later
    EXPECT_EQ(valid, 3);
    EXPECT_EQ(left_out, 3);
    EXPECT_GT(q31.rejected(), 3);
}

TEST(FixedGuard, AVeryLongStepEndsAtItsBase) {
    const sd_driveline_tables_t tables = usual_tables();
    GuardFilter filter(tables, true);
    sd_driveline_tooth_f32_t tooth{};
    tooth.advance = tooth.gear = 1;
    for (const std::uint32_t period : {500u, 250000u, 4000000u, UINT32_MAX, 500u, 500u}) {
        tooth.period_ticks = period;
        filter.step(tooth);
        EXPECT_LE(std::abs(filter.out().twist_rad), 2);
        EXPECT_NE(filter.out().status.health, SD_VALID);
    }
    tooth.period_ticks = 500;
    for (int i = 0; i < 3000; ++i) filter.step(tooth);
    EXPECT_EQ(filter.out().status.health, SD_VALID); // it has found its way back
    EXPECT_NEAR(filter.out().wheel_radps, 0.125 * 2 * kPi / 60 / 500e-6, 0.1);
}

TEST(FixedGuard, RefusesWhatHasNoRoomInItsBase) {
    using T = sd_driveline_tables_t;
    sd_driveline_guard_f32_t f32;
    sd_driveline_guard_q31_t q31{};
    T tables = usual_tables();
    ASSERT_EQ(sd_driveline_guard_init_q31(&q31, &tables), SD_OK);
    const sd_driveline_guard_q31_t kept = q31;
    const std::pair<float T::*, float> too_large[] = {{&T::per_inertia, 260}, {&T::per_vehicle, 0.26f}, {&T::soft_nmprad, 2.1e6f},
                                                      {&T::stiff_nmprad, 2.1e6f}, {&T::damping_nms, 8200}, {&T::drag_nms2, 4.1f},
                                                      {&T::shortest_s, 0.26f}};
    for (const auto &[field, value] : too_large) {
        T wide = usual_tables();
        wide.*field = value;
        EXPECT_EQ(sd_driveline_guard_init_f32(&f32, &wide), SD_OK);
        EXPECT_EQ(sd_driveline_guard_init_q31(&q31, &wide), SD_ERR_CONFIG);
    }
    T sum = usual_tables(); // each fits, their sum does not
    sum.stiff_nmprad = 1.5e6f;
    sum.damping_nms = 6000;
    EXPECT_EQ(sd_driveline_guard_init_q31(&q31, &sum), SD_ERR_CONFIG);
    T nothing = usual_tables();
    nothing.tick_s = std::numeric_limits<float>::quiet_NaN();
    EXPECT_EQ(sd_driveline_guard_init_q31(&q31, &nothing), SD_ERR_CONFIG);
    EXPECT_EQ(std::memcmp(&q31, &kept, sizeof q31), 0);
}

// What a sanitizer watches: no state, tables or tooth leads out of the integers or the tables.
TEST(FixedGuard, AnyStateAndAnyTooth) {
    std::mt19937_64 random(1);
    const auto fill = [&](auto &object) {
        auto *byte = reinterpret_cast<unsigned char *>(&object);
        for (std::size_t i = 0; i < sizeof object; ++i) byte[i] = random() % 5 ? (unsigned char)random() : random() % 2 ? 0xff : 0;
    };
    const auto half = [&] { return sd_q31_t(random() & 0x3fffffff); };
    auto tables = std::make_unique<sd_driveline_tables_t>();
    int placed = 0;
    for (int k = 0; k < 30000; ++k) {
        if (k % 64 == 0) fill(*tables);
        tables->gears = std::uint8_t(random() % (SD_DRIVELINE_GEARS_MAX + 1));
        sd_driveline_guard_q31_t filter;
        fill(filter);
        for (sd_gain_q31_t &gain : filter.gain) gain.exponent = int(random() % 41) - 20;
        filter.gear = std::uint8_t(random() % (SD_DRIVELINE_GEARS_MAX + 1));
        sd_driveline_model_q31_t &m = filter.model;
        m.tick &= 0x7fffffff, m.tick_down %= 64;
        for (sd_q31_t *x : {&m.pitch_rad, &m.wheel_pitch_rad, &m.shortest_s, &m.per_inertia, &m.per_vehicle, &m.kink_rad, &m.rolling_nm,
                            &m.drag_nms2}) *x &= INT32_MAX;
        m.ratio = half(), m.viscous_nms = half(), m.soft_nmprad = half(), m.stiff_nmprad = half(), m.damping_nms = half();
        sd_driveline_tooth_q31_t tooth;
        fill(tooth);
        if (random() % 2) tooth.advance = std::uint16_t(1 + random() % 3);
        if (random() % 2) tooth.gear = filter.gear;
        sd_driveline_out_q31_t out{};
        for (int i = 0; i < 3; ++i) sd_driveline_guard_step_q31(&filter, tables.get(), &tooth, &out);
        EXPECT_LE(out.location, 3);
        EXPECT_LE(out.status.health, SD_INVALID);
        placed += out.location != 0;
        sd_driveline_guard_wheel_q31(&filter, tables.get(), std::uint32_t(random()), std::uint16_t(random()));
    }
    EXPECT_GT(placed, 1000);
}
