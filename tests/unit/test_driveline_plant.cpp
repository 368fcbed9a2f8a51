// SPDX-License-Identifier: MIT
// The simulated car: its motion in closed form, where it changes its location, its clutch, its teeth.
#include <gtest/gtest.h>

#include "linalg/linalg.hpp"
#include "design/driveline/hybrid_design.hpp"
#include "plant/engine/units.hpp"
#include "plant/vehicle/vehicle_teeth.hpp"
#include "studies/driveline/figure_six.hpp"

using namespace sixdeg;

namespace {

constexpr double kSpeed = 2000 * kRadpsPerRpm;

Driveline linear_car() {
    Driveline d;
    d.kink_rad = 1; // never left
    return d;
}

void run_to(VehicleModel &car, double until) {
    while (until - car.state().time_s > 1e-12) car.step(until);
}

} // namespace

TEST(Vehicle, WithinALocationMovesAsTheExponentialOfItsMatrix) {
    const Driveline d = linear_car();
    const double load = 50;
    VehicleModel car(d, [](double, double) { return 20.0; });
    car.set_extra_load(load);
    VehicleState at;
    at.speed_radps = at.gearbox_radps = 200;
    at.wheel_radps = 24;
    at.twist_rad = 0.01;
    car.start(at);
    run_to(car, 0.3);
    // x = (torsion, crank, wheels, 1)
    const LocationModel m = location_model(d, 0.125, 0, 2);
    Eigen::MatrixXd a = Eigen::MatrixXd::Zero(4, 4);
    a.topLeftCorner(3, 3) = m.a;
    a.col(3).head(3) = m.b * 20 + Eigen::Vector3d(0, 0, -load / d.vehicle_inertia_kgm2);
    const Eigen::VectorXd x = linalg::exponential(a * 0.3) * Eigen::Vector4d(0.01, 200, 24, 1);
    EXPECT_NEAR(car.state().twist_rad, x(0), 1e-10);
    EXPECT_NEAR(car.state().speed_radps, x(1), 1e-8);
    EXPECT_NEAR(car.state().wheel_radps, x(2), 1e-9);
    EXPECT_GT(std::abs(car.state().twist_rad - 0.01), 1e-3);
}

TEST(Vehicle, Figure6ChangesItsLocationWhereItShould) {
    const std::vector<double> canonical{2.066, 2.236, 2.375, 2.463}, three{2.060, 2.204, 2.278, 2.506, 2.582};
    const std::vector<Location> to_canonical{2, 3, 2, 3}, to_three{2, 1, 2, 3, 2};
    for (const auto &[figure, times, to] : {std::tuple{canonical_figure(), canonical, to_canonical},
                                            {three_location_figure(), three, to_three}}) {
        const auto real = run_figure_six(figure).real;
        ASSERT_EQ(real.size(), times.size());
        for (std::size_t i = 0; i < times.size(); ++i) {
            EXPECT_NEAR(real[i].time_s, times[i], 1e-3);
            EXPECT_EQ(real[i].to, to[i]);
        }
    }
}

TEST(Vehicle, TheTimeOfAChangeDoesNotDependOnTheStep) {
    double first[2];
    for (int i : {0, 1}) {
        const Driveline d;
        VehicleModel car(d, [](double, double) { return 40.0; }, i ? 1e-4 : 4e-4);
        car.start_rolling(kSpeed, 10);
        run_to(car, 0.5);
        ASSERT_FALSE(car.changes().empty());
        first[i] = car.changes()[0].time_s;
    }
    EXPECT_NEAR(first[0], first[1], 1e-9);
}

TEST(Vehicle, BacklashPassesNoSpringTorque) {
    Driveline d;
    d.soft_nmprad = 0;
    EXPECT_EQ(d.spring_nm(0.9 * d.kink_rad), 0);
    EXPECT_NEAR(d.spring_nm(d.kink_rad + 1e-3), 8, 1e-9);
    EXPECT_NEAR(d.spring_nm(-d.kink_rad - 1e-3), -8, 1e-9);
    VehicleModel car(d, [](double, double) { return 20.0; });
    car.start_rolling(kSpeed, 0);
    run_to(car, 1);
    ASSERT_FALSE(car.changes().empty());
    EXPECT_EQ(car.changes()[0].to, 3);
}

TEST(Vehicle, TheClutchSlipsByItsTorqueAndThenHolds) {
    const Driveline d = linear_car();
    VehicleModel car(d, [](double, double) { return 0.0; });
    VehicleState at;
    at.speed_radps = 250;
    at.gearbox_radps = 200;
    at.wheel_radps = 25;
    car.start(at);
    car.set_clutch(0);
    run_to(car, 0.1);
    // Open: nothing but its friction brakes the crank.
    EXPECT_NEAR(car.state().speed_radps, 250 * std::exp(-0.05 / 0.15 * 0.1), 1e-6);
    EXPECT_TRUE(car.slips());
    car.set_clutch(50);
    const double before = car.state().speed_radps;
    run_to(car, 0.11);
    EXPECT_NEAR((car.state().speed_radps - before) / 0.01, -(50 + 0.05 * before) / 0.15, 2);
    run_to(car, 1);
    EXPECT_FALSE(car.slips());
    EXPECT_EQ(car.state().gearbox_radps, car.state().speed_radps);
    EXPECT_EQ(car.clutch_events(), 1);
}

TEST(Vehicle, AGearChangeKeepsTheWheels) {
    Driveline d;
    d.ratios = {0.07, 0.125};
    VehicleModel car(d, [](double, double) { return 0.0; });
    car.start_rolling(300, 0);
    car.set_clutch(0);
    car.step(1);
    const double wheels = car.state().wheel_radps, winding = car.ratio() * car.state().gearbox_radps - wheels;
    car.set_gear(1);
    EXPECT_NEAR(car.ratio() * car.state().gearbox_radps - wheels, winding, 1e-12);
    EXPECT_EQ(car.state().wheel_radps, wheels);
}

TEST(VehicleTeeth, PassWhereTheWheelStandsAtThem) {
    VehicleTeeth teeth({60, 2, 0, {}}, RandomStream(1, 1));
    std::vector<ToothEdge> edges;
    // 200 rad/s and 1000 rad/s2 from angle 0, in steps of 0.1 ms.
    const auto at = [](double t) { return VehicleTeeth::Point{t, 200 * t + 500 * t * t, 200 + 1000 * t}; };
    for (int k = 0; k < 2000; ++k) teeth.pass(at(k * 1e-4), at((k + 1) * 1e-4), edges);
    int position = 0, turns = 0;
    for (const ToothEdge &e : edges) {
        position += e.advance;
        const double angle = position * 2 * kPi / 60, exact = 2 * angle / (200 + std::sqrt(200.0 * 200 + 2000 * angle));
        EXPECT_NEAR(e.time_s, exact, 1e-10);
        EXPECT_EQ(e.position, position % 60);
        EXPECT_LT(e.position, 58);
        turns += e.advance == 3;
    }
    EXPECT_EQ(turns, int(edges.size()) / 58);
}

TEST(VehicleTeeth, JitterIsWhiteAndThePatternStays) {
    std::vector<double> pattern(60, 0);
    pattern[7] = 2e-3;
    for (const double jitter : {0.0, 3.5e-4}) {
        VehicleTeeth teeth({60, 0, jitter, pattern}, RandomStream(3, 1));
        std::vector<ToothEdge> edges;
        for (int k = 0; k < 40000; ++k) teeth.pass({k * 1e-3, 200e-3 * k, 200}, {(k + 1) * 1e-3, 200e-3 * (k + 1), 200}, edges);
        double squares = 0, seventh = 0;
        int count = 0, sevenths = 0;
        for (std::size_t i = 0; i < edges.size(); ++i) {
            const double off = 200 * edges[i].time_s - double(i + 1) * 2 * kPi / 60;
            if (edges[i].position == 7) seventh += off, sevenths++;
            else squares += off * off, count++;
        }
        EXPECT_NEAR(std::sqrt(squares / count), jitter, 0.02 * jitter + 1e-9);
        EXPECT_NEAR(seventh / sevenths, 2e-3, 0.1 * jitter + 1e-9);
    }
}
