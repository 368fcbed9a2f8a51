// SPDX-License-Identifier: MIT
#include "studies/airpath/matched_compare.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "studies/airpath/matched_filter.hpp"
extern "C" {
#include "sd_cusum.h"
}

namespace sixdeg {
namespace {

constexpr double kNever = 9999, kInjection = 8; ///< 1/s, of the scalar observers.
constexpr double kFlowWalkGps = 0.3, kExpected = 0.65;
constexpr int kBatch = 100, kSettle = 200, kMost = 300;

using Residuals = std::array<double, 2>; ///< Of VGT, of EGR.
using Method = std::function<Residuals(const MatchedRun &)>;
using MakeMethod = std::function<Method()>;

/// Both flows from what is measured; each residual is that of one balance.
struct ScalarInjection {
    const MatchedSetup &setup;
    MeanValueModel model;
    bool begun = false;
    double p = 0, q = 0, air = 0, egr = 0; ///< kPa; kPa: p + egr's share of the exhaust's mass; g; g.

    Residuals operator()(const MatchedRun &run) {
        const sd_airpath_in_f32_t &in = run.readings();
        const AirPathSystem &s = setup.system;
        const double per_air = 1e-6 * 287 * s.charge_k / s.intake_m3, per_egr = 1e-6 * 286 * s.egr_k / s.intake_m3;
        const double y = double(in.intake_kpa), mass = double(in.exhaust_kpa) / (1e-6 * 286 * s.exhaust_k / s.exhaust_m3);
        const double k = model.emptying_ps(double(in.speed_rpm) * M_PI / 30);
        const MeanValueFlows w = model.flows({0, 0, 0, double(in.egr_opening), double(in.vgt_position)}, 1e3 * y,
            1e3 * double(in.exhaust_kpa));
        if (!begun) p = y, q = y + per_egr * mass, air = double(in.air_gps) / k, egr = (y - per_air * air) / per_egr, begun = true;
        const Residuals r{y + per_egr * mass - q, y - p};
        const double flow = 1e3 * w.egr_kgps, dt = kMatchedPeriodS;
        q += dt * (per_air * double(in.air_gps) - k * y + per_egr * (k * (air + egr) + double(in.fuel_gps) - 1e3 * w.turbine_kgps)
            + kInjection * r[0]);
        p += dt * (per_air * double(in.air_gps) + per_egr * flow - k * y + kInjection * r[1]);
        air += dt * (double(in.air_gps) - k * air);
        egr += dt * (flow - k * egr) + dt * kInjection * (y - per_air * air - per_egr * egr) / per_egr;
        return r;
    }
};

Residuals of_bank(const MatchedRun &run) { return {double(run.bank().residual[0]), double(run.bank().residual[1])}; }

Residuals difference(const Residuals &a, const Residuals &b) { return {a[0] - b[0], a[1] - b[1]}; }

/// What the decision needs to know of a method's residuals.
struct Known {
    Residuals mean{}, long_run{}, fault{}; ///< fault: what 0.05 leaves, with its sign.
};

Known learn(const MatchedSetup &setup, const MakeMethod &make, double healthy_s, std::uint64_t seed) {
    RandomStream random(seed, 20);
    MatchedRun run(setup, kNever, kNever, random);
    const Method method = make();
    for (int i = 0; i < kSettle; ++i) run.step(draw_noise(random)), method(run);
    const int batches = int(healthy_s / kMatchedPeriodS / kBatch);
    std::vector<Residuals> means(std::size_t(batches), Residuals{});
    Known known;
    for (Residuals &mean : means) {
        for (int i = 0; i < kBatch; ++i) {
            run.step(draw_noise(random));
            const Residuals r = method(run);
            for (std::size_t j = 0; j < 2; ++j) mean[j] += r[j] / kBatch, known.mean[j] += r[j] / kBatch / batches;
        }
    }
    for (const Residuals &mean : means)
        for (std::size_t j = 0; j < 2; ++j) known.long_run[j] += kBatch * std::pow(mean[j] - known.mean[j], 2) / (batches - 1);
    for (std::size_t fault : {std::size_t(2), std::size_t(3)}) {
        RandomStream first(seed, 21), second(seed, 21);
        MatchedRun healthy(setup, kNever, kNever, first), faulty(setup, kNever, kNever, second);
        const Method a = make(), b = make();
        Residuals end{};
        for (int i = 0; i < 2 * kSettle + kMost; ++i) {
            if (i == 2 * kSettle) faulty.set_fault(matched_faults()[fault]);
            healthy.step({0, 0, 0}), faulty.step({0, 0, 0});
            end = difference(b(faulty), a(healthy));
        }
        known.fault[3 - fault] = end[3 - fault];
    }
    return known;
}

sd_cusum_tables_f32_t tables_of(const Known &known) {
    sd_cusum_tables_f32_t t{};
    t.hypotheses = 4, t.residuals = 2;
    for (int l = 0; l < 4; ++l) {
        const std::size_t j = l < 2 ? 1 : 0;
        const double mean = kExpected * known.fault[j] * (l % 2 ? -1 : 1);
        t.weight[l][j] = float(mean / known.long_run[j]);
        t.offset[l] = float(mean * mean / known.long_run[j] / 2);
        t.group[l] = std::uint8_t(l / 2);
    }
    return t;
}

/// One run of a method with its decision.
struct Decided {
    MatchedRun run;
    Method method;
    const Known &known;
    sd_cusum_tables_f32_t tables;
    sd_cusum_thresholds_f32_t thresholds;
    sd_cusum_f32_t sums{};
    sd_cusum_out_f32_t out{};

    void step(RandomStream &random) {
        run.step(draw_noise(random));
        const Residuals r = difference(method(run), known.mean);
        const float residual[2] = {float(r[0]), float(r[1])};
        sd_cusum_step_f32(&sums, &tables, &thresholds, residual, &out);
    }
};

double threshold_of(const MatchedSetup &setup, const MakeMethod &make, const Known &known, double healthy_s, double alarm_s,
    std::uint64_t seed) {
    RandomStream random(seed, 22);
    Decided d{MatchedRun(setup, kNever, kNever, random), make(), known, tables_of(known), {1e-3f, 1e-3f}};
    for (int i = 0; i < kSettle; ++i) d.step(random);
    std::vector<double> peaks;
    for (int b = 0; b < int(healthy_s / kMatchedPeriodS / kBatch); ++b) {
        double peak = 0;
        for (int i = 0; i < kBatch; ++i) {
            d.step(random);
            for (int l = 0; l < 4; ++l) peak = std::max(peak, double(d.out.decision[l]));
        }
        peaks.push_back(peak);
    }
    std::sort(peaks.rbegin(), peaks.rend());
    return peaks[std::size_t(healthy_s / alarm_s)];
}

} // namespace

std::vector<MethodFigures> compare_methods(const MatchedSetup &setup, double healthy_s, double alarm_s, int runs, std::uint64_t seed) {
    const std::pair<const char *, MakeMethod> methods[] = {
        {"unknown-input observers", [] { return of_bank; }},
        {"scalar output injection", [&] { return ScalarInjection{setup, MeanValueModel(setup.system, setup.displaced_m3)}; }},
        {"augmented Kalman filter", [&] {
             return [filter = MatchedFilter(setup, kFlowWalkGps)](const MatchedRun &run) mutable {
                 filter.step(run.readings());
                 return Residuals{filter.flow_error()(1), filter.flow_error()(0)};
             };
         }}};
    std::vector<MethodFigures> all;
    for (const auto &[name, make] : methods) {
        const Known known = learn(setup, make, healthy_s, seed);
        MethodFigures f{name, threshold_of(setup, make, known, healthy_s, alarm_s, seed), {}, {}};
        for (std::size_t i = 0; i < 4; ++i) {
            RandomStream random(seed, 23);
            for (int r = 0; r < runs; ++r) {
                const float h = float(f.threshold);
                Decided d{MatchedRun(setup, kNever, kNever, random), make(), known, tables_of(known), {h, h}};
                for (int k = 0; k < kSettle; ++k) d.step(random);
                sd_cusum_start_f32(&d.sums);
                d.run.set_fault(matched_faults()[i]);
                int steps = 0;
                do d.step(random);
                while (++steps < kMost && d.out.named == 0);
                f.delay_s[i] += steps * kMatchedPeriodS / runs;
                if (d.out.named == (i % 2 ? 3 : 1)) f.right_percent[i] += 100.0 / runs;
            }
        }
        all.push_back(f);
    }
    return all;
}

} // namespace sixdeg
