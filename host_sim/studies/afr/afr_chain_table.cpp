// SPDX-License-Identifier: MIT
// The document's chain (docs/theory/afr.md), its blocks and gains one by one.
#include <algorithm>
#include <cmath>
#include <complex>
#include <fmt/format.h>
#include <functional>

#include "studies/afr/afr_errors.hpp"
#include "studies/afr/afr_parts.hpp"

namespace sixdeg::afr_study {
namespace {

/// The same run with its gas repeating the last cycle's first n_h harmonics for ever: all that D can give A.
Run cut_to_harmonics(Run run, int harmonics) {
    const std::size_t cycle = std::size_t(run.trace.cycle_positions), end = run.trace.gas.size();
    std::vector<double> cut(cycle, 0.0);
    for (int h = 0; h <= harmonics; ++h) {
        std::complex<double> c = 0;
        for (std::size_t k = 0; k < cycle; ++k)
            c += run.trace.gas[end - cycle + k] * std::polar((h > 0 ? 2.0 : 1.0) / double(cycle),
                                                             -2 * M_PI * h * double(k) / double(cycle));
        for (std::size_t k = 0; k < cycle; ++k) cut[k] += (c * std::polar(1.0, 2 * M_PI * h * double(k) / double(cycle))).real();
    }
    for (std::size_t k = 0; k < end; ++k) run.trace.gas[end - 1 - k] = cut[cycle - 1 - k % cycle];
    return run;
}

} // namespace

void chain(int seeds) {
    const std::vector<Case> cases{{"1500/9", 1500, 9, 30, 15, 0.005, 10},      {"1000/3", 1000, 3, 30, 15, 0.005, 10},
                                  {"2500/9", 2500, 9, 30, 15, 0.005, 10},      {"1500/9 fast", 1500, 9, 15, 5, 0.005, 10},
                                  {"2500/9 fast", 2500, 9, 15, 5, 0.005, 10}};
    std::vector<Run> runs;
    fmt::print("\nthe document's chain, +20 % on cylinder 1: cycles, noise free, until every error is in 20 % of the step; the "
               "largest then left, points; rms at 0.5 % noise, {} seeds; stated over rms of deviations\n{:<34}", seeds, "");
    for (const Case &c : cases) {
        runs.emplace_back(c, 20);
        fmt::print("{:>24}", c.name);
    }
    const auto row = [&](const char *name, AfrMethod method, const std::function<void(AfrSetup &)> &change = [](AfrSetup &) {}) {
        fmt::print("\n{:<34}", name);
        for (std::size_t i = 0; i < cases.size(); ++i) {
            AfrSetup setup = setup_for(runs[i], cases[i]);
            setup.method = method;
            change(setup);
            const AfrEstimates clean = runs[i].run(setup);
            fmt::print("{:7.1f}{:5.2f}", runs[i].band_cycles(clean), runs[i].largest_left(clean));
            if (method == AfrMethod::true_gas) { // not the sensor's noise
                fmt::print("{:>12}", "");
                continue;
            }
            const auto noisy = errors_of_seeds(runs[i], setup, cases[i], 0, false, seeds);
            fmt::print("{:6.2f}{:6.2f}", rms(noisy, &Errors::rms), rms(noisy, &Errors::stated) / rms(noisy, &Errors::deviations));
        }
    };
    row("A on the true gas", AfrMethod::true_gas);
    fmt::print("\n{:<34}", "  cut to 2 harmonics");
    for (const Run &run : runs) {
        AfrSetup setup;
        setup.method = AfrMethod::true_gas;
        const Run cut = cut_to_harmonics(run, 2);
        fmt::print("{:7}{:5.2f}{:12}", "", cut.largest_left(cut.run(setup)), "");
    }
    row("D (Fourier law), C, B, A", AfrMethod::fourier);
    row("  in q31", AfrMethod::fourier, [](AfrSetup &s) { s.fixed_point = true; });
    row("  g 0.005, L_cyl 3", AfrMethod::fourier, [](AfrSetup &s) { s.inversion_gain = 0.005, s.gain_cylinder = 3; });
    row("  g 0.02", AfrMethod::fourier, [](AfrSetup &s) { s.inversion_gain = 0.02; });
    row("  g 0.04", AfrMethod::fourier, [](AfrSetup &s) { s.inversion_gain = 0.04; });
    row("  rho 0.05", AfrMethod::fourier, [](AfrSetup &s) { s.inversion_floor = 0.05; });
    row("  rho 0.2", AfrMethod::fourier, [](AfrSetup &s) { s.inversion_floor = 0.2; });
    row("  n_h 4", AfrMethod::fourier, [](AfrSetup &s) { s.harmonics = 4; });
    row("D (oscillators), C, B, A", AfrMethod::oscillator);
    row("  in q31", AfrMethod::oscillator, [](AfrSetup &s) { s.fixed_point = true; });
    row("  drift 0.02, L_cyl 3, n_h 4", AfrMethod::oscillator,
        [](AfrSetup &s) { s.oscillator_drift = 0.02, s.gain_cylinder = 3, s.harmonics = 4; });
    row("  drift 0.003", AfrMethod::oscillator, [](AfrSetup &s) { s.oscillator_drift = 0.003; });
    row("  drift 0.01", AfrMethod::oscillator, [](AfrSetup &s) { s.oscillator_drift = 0.01; });
    row("  L_cyl 3", AfrMethod::oscillator, [](AfrSetup &s) { s.gain_cylinder = 3; });
    row("  L_cyl 5", AfrMethod::oscillator, [](AfrSetup &s) { s.gain_cylinder = 5; });
    row("  L2 0.06", AfrMethod::oscillator, [](AfrSetup &s) { s.gain_air = 0.06; });
    row("  L2 0.2", AfrMethod::oscillator, [](AfrSetup &s) { s.gain_air = 0.2; });
    row("  n_h 4", AfrMethod::oscillator, [](AfrSetup &s) { s.harmonics = 4; });
    fmt::print("\n");
}

} // namespace sixdeg::afr_study
