// SPDX-License-Identifier: MIT
#include "design/driveline/driveline_page.hpp"

#include <cmath>
#include <cstring>

#include "common/error.hpp"
#include "design/driveline/guard_design.hpp"
#include "design/driveline/hybrid_design.hpp"
extern "C" {
#include "hal.h"
}

namespace sixdeg {
namespace {

constexpr double kTaskS = 0.01;
constexpr double kMovingRadps = 0.1; // from firing to firing
constexpr double kSettleS = 1;       // the first torque is a mean that may be 3 N m off, and so is the torsion that goes with it

/// What the ecu's own torque is worth: late by a firing and a few N m off, so that what it lacks may be another within tenths of a second.
GuardBelief ecu_belief() {
    GuardBelief b;
    b.torque_noise_nm = 0.1;
    b.bias_walk_nm = 100;
    b.doubt_rad = 6e-3;
    return b;
}

/// The crank's inertia over a turn, kg m2.
double mean_inertia(const EngineFile &engine) {
    double sum = 0;
    for (int k = 0; k < 720; ++k) sum += crank_inertia_kgm2(engine, k * M_PI / 360) / 720;
    return sum;
}

/// Who takes the inertia as its mean has a speed w_m of the same energy: w = w_m sqrt(J_mean / J). Over d alpha it believes to turn
/// w_m dt = sqrt(J / J_mean) d alpha; what that adds up to beyond alpha is how far behind its place a tooth seems to stand.
void fill_places(const EngineFile &engine, sd_page_driveline_t &page) {
    constexpr int kParts = 16;
    const int positions = engine.wheel.positions;
    const double mean = mean_inertia(engine), pitch = 2 * M_PI / positions, start = engine.position_0_deg * M_PI / 180;
    std::vector<double> place(std::size_t(positions), 0.0);
    double sum = 0, whole = 0;
    for (int k = 0; k < positions; ++k) {
        place[std::size_t(k)] = sum;
        whole += sum / positions;
        for (int i = 0; i < kParts; ++i) {
            const double alpha = start + (k + (i + 0.5) / kParts) * pitch;
            sum += (std::sqrt(crank_inertia_kgm2(engine, alpha) / mean) - 1) * pitch / kParts;
        }
    }
    for (int k = 0; k < positions; ++k) {
        page.place_rad[k] = float(place[std::size_t(k)] - sum * k / positions - whole); // sum: what a turn is off, nearly 0
    }
}

sd_page_driveline_t driveline_page(const EngineFile &engine, const DrivelineFile &file) {
    sd_page_driveline_t page{};
    Driveline car = file.car;
    car.engine_inertia_kgm2 = mean_inertia(engine);
    GuardBelief belief = ecu_belief();
    if (file.wheel_teeth > 0) {
        belief.wheel_positions = file.wheel_teeth;
        belief.wheel_jitter_rad = file.wheel_jitter_deg * M_PI / 180;
        belief.twist_walk_rad = 1e-3;
    }
    const auto guard = file.guard_in_torque ? SD_GUARD_TORQUE : SD_GUARD_ANGLE;
    page.tables = guard_tables(car, belief, engine.wheel.positions, 1 / engine.tick_hz, guard);
    HybridBelief reference;
    reference.equilibrium_rad = 0;
    reference.at_rest = true;
    reference.period_s = kTaskS;
    for (std::size_t g = 0; g < car.ratios.size(); ++g) page.tables.gear[g].bank = hybrid_tables(car, car.ratios[g], reference);
    page.drag_nm = float(file.drag_nm);
    page.wheel = SD_WHEEL_FRONT_LEFT;
    page.firing_positions = std::uint16_t(std::max(1, 2 * engine.wheel.positions / engine.cylinders()));
    page.tables.moving_radps = float(kMovingRadps);
    page.tables.settle_s = float(kSettleS);
    fill_places(engine, page);
    return page;
}

} // namespace

void add_driveline(const EngineFile &engine, sd_calibration_t &page) {
    if (!engine.driveline) return;
    if (page.kalman.positions == 0) {
        throw InputError(engine.name, "driveline",
                         "needs the filter on tooth times, which knows the torque: firing.enabled, combustion.pulse");
    }
    const sd_page_driveline_t driveline = driveline_page(engine, *engine.driveline);
    const std::uint32_t at = sd_kalman_pool_used(&page.kalman), words = sd_page_driveline_words(driveline.tables.gears);
    if (at + words > SD_KALMAN_POOL) throw InputError(engine.name, "driveline", "has no room in the page beside the filter on tooth times");
    page.driveline_at = at;
    std::memcpy(&page.kalman.pool[at], &driveline, words * sizeof(float));
}

} // namespace sixdeg
