// SPDX-License-Identifier: MIT
#include "design/perturbation.hpp"

#include <cmath>

#include "common/random.hpp"
#include "common/streams.hpp"

namespace sixdeg {

Perturbation draw_perturbation(const EngineFile &engine, std::uint64_t seed, const PerturbationRanges &ranges) {
    RandomStream random(seed, stream::kPerturbation);
    const auto within = [&](double range) { return range * (2 * random.uniform() - 1); };
    Perturbation p{within(ranges.inertia_percent), within(ranges.reciprocating_percent),
                   within(ranges.wheel_offset_deg), {}, {}, 0, 0, 0};
    for (int i = 0; i < engine.cylinders(); ++i) {
        p.compression_percent.push_back(within(ranges.compression_percent));
        p.trapped_mass_percent.push_back(within(ranges.trapped_mass_percent));
    }
    p.exhaust_flow_percent = within(ranges.exhaust_flow_percent);
    p.uego_tau_percent = within(ranges.uego_tau_percent);
    p.uego_delay_deg = within(ranges.uego_delay_deg);
    return p;
}

EngineFile perturbed(const EngineFile &engine, const Perturbation &perturbation, const PerturbationRanges &ranges) {
    const auto factors = [](const std::vector<double> &percent) {
        std::vector<double> factor;
        for (double p : percent) factor.push_back(1 + p / 100);
        return factor;
    };
    EngineFile belief = engine;
    belief.inertia_kgm2 *= 1 + perturbation.inertia_percent / 100;
    belief.reciprocating_mass_kg *= 1 + perturbation.reciprocating_percent / 100;
    belief.position_0_deg = std::fmod(engine.position_0_deg + perturbation.wheel_offset_deg + 360, 360);
    belief.compression_factors = factors(perturbation.compression_percent);
    belief.trapped_factors = factors(perturbation.trapped_mass_percent);
    belief.tolerance.inertia_percent = ranges.inertia_percent;
    belief.tolerance.compression_percent = ranges.compression_percent;
    belief.tolerance.trapped_mass_percent = ranges.trapped_mass_percent;
    belief.tolerance.wheel_offset_deg = ranges.wheel_offset_deg;
    if (belief.exhaust) {
        constexpr double kDegPerS = 9000; // at 1500 rpm
        belief.exhaust->flow_factor = 1 + perturbation.exhaust_flow_percent / 100;
        for (double &tau : belief.exhaust->uego_tau_s) tau *= 1 + perturbation.uego_tau_percent / 100;
        belief.exhaust->dead_time_s += perturbation.uego_delay_deg / kDegPerS;
    }
    return belief;
}

} // namespace sixdeg
