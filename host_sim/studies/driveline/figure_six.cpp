// SPDX-License-Identifier: MIT
#include "studies/driveline/figure_six.hpp"

#include <fmt/format.h>

#include "plant/engine/units.hpp"
#include "plant/vehicle/vehicle_teeth.hpp"

namespace sixdeg {
namespace {

constexpr double kSpeedRadps = 2000 * kRadpsPerRpm, kStepNm = -10, kStepAtS = 2;

} // namespace

FigureSixCase canonical_figure() { return {}; }

FigureSixCase three_location_figure() {
    FigureSixCase figure;
    Driveline &d = figure.driveline;
    d.engine_inertia_kgm2 = 0.18;
    d.vehicle_inertia_kgm2 = 100;
    d.engine_viscous_nms = 0.02;
    d.damping_nms = 30;
    d.soft_nmprad = 1000;
    d.stiff_nmprad = 6000;
    figure.belief.threshold_rpm = 0.05;
    figure.belief.hold_s = 0;
    return figure;
}

FigureSix run_figure_six(const FigureSixCase &c) {
    const double ratio = c.driveline.ratios[0], shaft_nm = c.driveline.spring_nm(c.belief.equilibrium_rad), h = c.belief.period_s;
    const double engine_nm = ratio * shaft_nm + c.driveline.engine_viscous_nms * kSpeedRadps;
    VehicleModel car(c.driveline, [&](double t, double) { return engine_nm + (t >= kStepAtS ? kStepNm : 0); });
    car.set_extra_load(shaft_nm);
    car.start_rolling(kSpeedRadps, shaft_nm);
    VehicleTeeth teeth({60, 2, std::max(c.jitter_deg, 0.0) * kRadPerDeg, {}}, RandomStream(1, 1));
    const sd_driveline_bank_t bank = hybrid_tables(c.driveline, ratio, c.belief);
    sd_driveline_hybrid_t observer;
    sd_driveline_hybrid_init(&observer, &bank, std::uint8_t(c.begins_in));
    FigureSix figure;
    std::vector<ToothEdge> edges;
    double speed = kSpeedRadps, last_edge_s = 0;
    Location found = c.begins_in;
    int wrong = 0, counted = 0;
    for (int k = 1; k * h <= c.duration_s + 1e-9; ++k) {
        const double until = k * h;
        while (until - car.state().time_s > 1e-12) {
            car.step(until);
            const VehicleState &from = car.before(), &to = car.state();
            edges.clear();
            teeth.pass({from.time_s, from.angle_rad, from.speed_radps}, {to.time_s, to.angle_rad, to.speed_radps}, edges);
            for (const ToothEdge &edge : edges) {
                if (edge.time_s > last_edge_s) speed = edge.advance * 2 * kPi / 60 / (edge.time_s - last_edge_s);
                last_edge_s = edge.time_s;
            }
        }
        if (c.jitter_deg < 0) speed = car.state().speed_radps;
        sd_driveline_hybrid_out_t out;
        // The step of the torque falls on the end of a step of the observer.
        sd_driveline_hybrid_step(&observer, &bank, until > kStepAtS + 1e-9 ? float(kStepNm) : 0.0f, 0.0f,
                                 float((speed - kSpeedRadps) / kRadpsPerRpm), &out);
        if (out.location != found) figure.found.push_back({until, found, out.location});
        found = out.location;
        const double twist = car.state().twist_rad - c.belief.equilibrium_rad;
        figure.rows.push_back({until, twist, out.x[0], {out.residual_rpm[0], out.residual_rpm[1], out.residual_rpm[2]},
                               {observer.z[0][0], observer.z[1][0], observer.z[2][0]}, car.location(), found});
        if (until < kStepAtS) continue;
        counted++;
        wrong += found != car.location();
        figure.largest_error_rad = std::max(figure.largest_error_rad, std::abs(out.x[0] - twist));
    }
    figure.real = car.changes();
    figure.wrong_percent = 100.0 * wrong / counted;
    return figure;
}

Delays delays(const FigureSix &figure) {
    Delays result;
    std::vector<bool> used(figure.found.size(), false);
    for (std::size_t i = 0; i < figure.real.size(); ++i) {
        const LocationChange &real = figure.real[i];
        const double next = i + 1 < figure.real.size() ? figure.real[i + 1].time_s : figure.rows.back().time_s;
        double late = -1;
        for (std::size_t j = 0; j < figure.found.size() && late < 0; ++j) {
            const LocationChange &found = figure.found[j];
            if (used[j] || found.time_s < real.time_s || found.time_s >= next || found.to != real.to) continue;
            used[j] = true;
            late = found.time_s - real.time_s;
        }
        result.missed += late < 0;
        result.late_s.push_back(late);
    }
    for (const bool each : used) result.false_ones += !each;
    return result;
}

std::string figure_six_csv(const FigureSix &figure) {
    std::string text = "time_s,torsion_rad,estimate_rad,r1_rpm,r2_rpm,r3_rpm,location,found\n";
    for (const FigureSixRow &r : figure.rows) {
        text += fmt::format("{:.3f},{:.6f},{:.6f},{:.4f},{:.4f},{:.4f},{},{}\n", r.time_s, r.twist_rad, r.estimate_rad, r.residual_rpm[0],
                            r.residual_rpm[1], r.residual_rpm[2], r.real, r.found);
    }
    return text;
}

} // namespace sixdeg
