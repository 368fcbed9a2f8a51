// SPDX-License-Identifier: MIT
// The plant's exhaust at every wheel position of a run, free of noise: what the AFR blocks are judged on.
#pragma once
#include <vector>

#include "plant/scenario/scenario.hpp"

namespace sixdeg {

struct AfrTrace {
    int cycle_positions = 0;
    double step_s = 0; ///< Mean duration of a position.
    double intake_pa = 0;
    std::size_t first_cycle_position = 0; ///< Of entry 0, position 0 = position_0_deg.
    std::vector<double> sensor;           ///< lambda, mean over each position.
    std::vector<double> gas;              ///< lambda in the manifold at each position.
    std::vector<double> pressure_bar;     ///< In the manifold, mean over each position.
    std::vector<double> mass_kg;          ///< In the manifold at each position.
    std::vector<std::vector<double>>
        lambda; ///< True, of each lane (firing order) as last let out, at each position.
    double egr_share = 0;     ///< Recirculated of all that leaves the manifold, as `reading`.
    ExhaustReading reading{}; ///< A test bench's, over the second half of a run in cycles.
};

/// Runs the scenario (its uego noise and sampling are replaced) and samples it at wheel positions.
AfrTrace afr_trace(Scenario scenario);

} // namespace sixdeg
