// SPDX-License-Identifier: MIT
#include "plant/scenario/combustion_plan.hpp"

#include <algorithm>

#include "common/streams.hpp"

namespace sixdeg {
namespace {

constexpr double kCut = 3; // standard deviations
constexpr double kLeastFactor = 0.05;

double draw_normal(RandomStream &random) { return std::clamp(random.normal(), -kCut, kCut); }

} // namespace

CombustionPlan::CombustionPlan(const Scenario &scenario, std::uint64_t seed) : scenario_(scenario) {
    for (int lane = 0; lane < scenario.engine.shared.cylinders(); ++lane) {
        cyclic_.emplace_back(seed, stream::kCyclic + std::uint32_t(lane));
        misfire_.emplace_back(seed, stream::kMisfire + std::uint32_t(lane));
    }
}

double CombustionPlan::burned_fraction(int lane, std::int64_t cycle) {
    const bool by_chance = misfire_[std::size_t(lane)].chance(scenario_.misfire_rate);
    const int cylinder = scenario_.engine.shared.firing_order[std::size_t(lane)];
    const auto &list = scenario_.misfires;
    auto event = std::lower_bound(list.begin(), list.end(), cycle,
                                  [](const MisfireEvent &e, std::int64_t c) { return e.cycle < c; });
    for (; event != list.end() && event->cycle == cycle; ++event) {
        if (event->cylinder == cylinder) return event->burned_fraction;
    }
    const auto &always = scenario_.continuous;
    const bool continuous = std::find(always.begin(), always.end(), cylinder) != always.end();
    return continuous || by_chance ? scenario_.misfire_burned_fraction : 1;
}

double CombustionPlan::fuel_factor(int cylinder, double time_s) const {
    double factor = scenario_.fuel_factor[std::size_t(cylinder - 1)];
    for (const FuelStep &step : scenario_.fuel_steps) {
        if (step.cylinder == cylinder && step.at_s <= time_s) factor = step.factor;
    }
    return factor;
}

Charge CombustionPlan::draw(int lane, std::int64_t cycle, double time_s, double fuel_kg, double bmep_pa) {
    const int cylinder = scenario_.engine.shared.firing_order[std::size_t(lane)];
    RandomStream &random = cyclic_[std::size_t(lane)];
    Charge charge;
    charge.fuel_kg = fuel_kg * fuel_factor(cylinder, time_s);
    charge.heat_factor = std::max(kLeastFactor, 1 + scenario_.cyclic_cov.at(bmep_pa) * draw_normal(random));
    charge.start_shift_rad = scenario_.cyclic_start_sd_rad * draw_normal(random);
    charge.duration_factor = 1 + scenario_.cyclic_duration_cov * draw_normal(random);
    charge.burned_fraction = burned_fraction(lane, cycle);
    return charge;
}

} // namespace sixdeg
