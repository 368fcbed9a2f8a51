// SPDX-License-Identifier: MIT
#include "design/afr/chain_map.hpp"

#include <limits>
#include <vector>

#include "linalg/linalg.hpp"
extern "C" {
#include "sd_stage_mixture.h"
}

namespace sixdeg {
namespace {

constexpr float kSmall = 1e-6f; // air fraction; a diverging chain stays far within its range for one cycle
constexpr int kSettle = 30;     // cycles until the manifold repeats itself

std::vector<float *> states(sd_afr_chain_f32_t &chain) {
    std::vector<float *> x{&chain.uego.re[0], &chain.observer.air};
    for (int k = 1; k <= chain.uego.harmonics; ++k) x.push_back(&chain.uego.re[k]), x.push_back(&chain.uego.im[k]);
    if (chain.uego.oscillator) x.push_back(&chain.uego.lag2), x.push_back(&chain.uego.lag1);
    for (int i = 0; i < chain.observer.cylinders; ++i) x.push_back(&chain.observer.air_fraction[i]);
    return x;
}

/// Of the chain's states over a cycle in which the sensor says 0; infinite where the chain began anew on the way.
double radius_here(const sd_afr_t &settled, const sd_afr_tables_t &tables) {
    sd_afr_t afr = settled;
    const auto size = Eigen::Index(states(afr.chain).size());
    Eigen::MatrixXd map(size, size);
    for (Eigen::Index i = 0; i < size; ++i) {
        afr = settled;
        const std::vector<float *> x = states(afr.chain);
        for (float *state : x) *state = 0;
        afr.chain.uego.running = afr.chain.observer.running = 1;
        afr.chain.observer.steps = 0;
        *x[std::size_t(i)] = kSmall;
        for (std::uint32_t k = 0; k < afr.config.cycle_positions; ++k) sd_afr_step(&afr, &tables, k, 1, 0); // lambda 1: no air
        if (afr.chain.observer.steps != afr.config.cycle_positions) return std::numeric_limits<double>::infinity();
        for (Eigen::Index j = 0; j < size; ++j) map(j, i) = double(*x[std::size_t(j)] / kSmall);
    }
    return linalg::spectral_radius(map);
}

} // namespace

double chain_radius(const sd_calibration_t &page) {
    sd_stage_mixture_t stage;
    if (page.afr.present == 0 || page.parameters.afr_method < 1.5f) return 0;
    sd_parameters_t parameters = page.parameters;
    parameters.afr_arithmetic = 0; // q31 holds the same map
    if (sd_stage_mixture_init(&stage, &page, &parameters) != SD_OK) return std::numeric_limits<double>::infinity();
    sd_afr_t &afr = stage.afr;
    const sd_afr_tables_t tables{&page.afr, page.fourier.sine_q31};
    double worst = 0;
    for (int half = 0; half <= 2 * (SD_AFR_SPEEDS - 1); ++half) {
        const float speed = 0.5f * (page.afr.speed_radps[half / 2] + page.afr.speed_radps[(half + 1) / 2]);
        for (float bar : page.afr.pressure_bar) {
            for (float lambda : page.afr.lambda) {
                afr.mean_lambda = lambda;
                const sd_afr_conditions_t at{speed, bar, 0, 0, 0, 0, 0};
                sd_afr_cycle(&afr, &at);
                while (sd_afr_work(&afr, &tables)) {}
                sd_exhaust_now_f32_t now;
                for (std::uint32_t k = 0; k < kSettle * std::uint32_t(afr.config.cycle_positions); ++k)
                    sd_exhaust_step_f32(&afr.point.exhaust, page.afr.psi, k % afr.config.cycle_positions, &now);
                worst = std::max(worst, radius_here(afr, tables));
            }
        }
    }
    return worst;
}

} // namespace sixdeg
