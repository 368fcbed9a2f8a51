// SPDX-License-Identifier: MIT
#include <cmath>
#include <cstdlib>
#include <fmt/format.h>
#include "run/afr_judge.hpp"
using namespace sixdeg;
namespace {
struct Bench { Scenario s; AfrTrace t; ExhaustPoint p; int at; double mean; };
Bench bench(double rpm, double bmep, double percent, int cylinder, double t1, double t2) {
    TomlFile file("bench", "engine = \"diesel_22.toml\"\n[run]\ncycles = 90\n[speed]\nmode=\"prescribed\"\n[uego]\n[load]\n");
    file.set(fmt::format("speed.rpm={}", rpm)); file.set(fmt::format("load.bmep_bar={}", bmep));
    if (percent != 0) file.set(fmt::format("cylinders.fuel_step=[{{at_s={}, cylinder={}, percent={}}}]", 50.25 * 120 / rpm, cylinder, percent));
    Bench b{read_scenario(file, SD_ENGINES), {}, {}, 0, 0};
    b.s.engine.shared.exhaust->uego_tau_s[0] = t1; b.s.engine.shared.exhaust->uego_tau_s[1] = t2;
    b.t = afr_trace(b.s);
    b.p = exhaust_point(b.s.engine.shared, rpm * M_PI / 30, b.t.intake_pa, b.t.sensor[b.t.sensor.size() - 1]);
    for (std::size_t k = 1; k < b.t.lambda.size(); ++k) for (int i = 0; i < 4; ++i) if (b.at == 0 && k > 40 * 120 && std::abs(b.t.lambda[k][i] - b.t.lambda[k-1][i]) > 0.005) b.at = int(k);
    for (int i = 0; i < 4; ++i) b.mean += b.t.lambda.back()[i] / 4;
    return b;
}
double err(const Bench &b, const AfrEstimates &e, int c, int i) { return (e.lambda[c][i] - b.t.lambda[b.t.lambda.size() - 1][i]) / b.mean * 100; }
double settle(const Bench &b, const AfrEstimates &e, double share) {
    int last = 0; int from = b.at / 120, to = std::min(int(e.lambda.size()), from + 30);
    double step = (b.t.lambda.back()[0] - b.t.lambda[0][0]) / b.mean * 100;
    for (int i = 0; i < 4; ++i) { double m = 0; for (int c = to - 5; c < to; ++c) m += err(b, e, c, i) / 5;
        for (int c = from; c < to; ++c) if (std::abs(err(b, e, c, i) - m) > std::abs(share * step)) last = std::max(last, c + 1); }
    return last == 0 ? 0 : ((last + 1) * 120 - b.at) / 120.0;
}
}
int main(int argc, char **argv) {
    double rpm = atof(argv[1]), bmep = atof(argv[2]), t1 = argc > 3 ? atof(argv[3]) * 1e-3 : 0.03, t2 = argc > 4 ? atof(argv[4]) * 1e-3 : 0.015;
    Bench b = bench(rpm, bmep, 20, 1, t1, t2);
    for (double noise : {0.005, 0.002}) {
        double crb = 100 * afr_bound(b.s.engine.shared, b.p, b.t, noise, 4) / b.mean;
        fmt::print("noise {} CRB4 {:.3f}\n", noise, crb);
        for (double q : {0.003, 0.006, 0.009, 0.012, 0.016, 0.02, 0.03, 0.04, 0.06}) {
            AfrSetup u; u.drift = q; u.noise = noise;
            auto clean = afr_estimate(b.s.engine.shared, b.p, b.t, u, {});
            double st = settle(b, clean, 0.05);
            double bias = 0; for (int i = 0; i < 4; ++i) bias = std::max(bias, std::abs(err(b, clean, 85, i)));
            double ss = 0, n = 0, dev = 0; for (int seed = 0; seed < 20; ++seed) {
                auto e = afr_estimate(b.s.engine.shared, b.p, b.t, u, sensor_noise(b.t, noise, 0, seed));
                for (int c = b.at / 120 + int(std::ceil(st)) + 1; c < 90; ++c) for (int i = 0; i < 4; ++i) { ss += std::pow(err(b, e, c, i), 2); n++; dev += std::pow((e.lambda[c][i] - clean.lambda[c][i]) / b.mean * 100, 2); }
            }
            fmt::print("  q {:.3f} settle {:.1f} bias {:.2f} rms {:.2f} noise part {:.2f} stated {:.2f}\n", q, st, bias, std::sqrt(ss / n), std::sqrt(dev / n), 100 * clean.sd[80] / b.mean);
        }
    }
    for (auto m : {AfrMethod::true_gas, AfrMethod::fourier, AfrMethod::oscillator}) for (double lc : {2., 3., 5.}) for (double ga : {0.06, 0.12}) for (double g : {0.003, 0.006}) {
        AfrSetup u; u.method = m; u.gain_cylinder = lc; u.gain_air = ga; u.fourier_gain = g; u.drift = 0.02; u.noise=0.005;
        if (m != AfrMethod::fourier && g > 0.004) continue;
        auto e = afr_estimate(b.s.engine.shared, b.p, b.t, u, {});
        double bias = 0; for (int i = 0; i < 4; ++i) bias = std::max(bias, std::abs(err(b, e, 80, i)));
        fmt::print("chain {} L {} g {} : settle20 {:.1f} settle5 {:.1f} bias {:.2f}\n", int(m), lc, m == AfrMethod::fourier ? g : ga, settle(b, e, 0.2), settle(b, e, 0.05), bias);
    }
}
