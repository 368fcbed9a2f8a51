/* SPDX-License-Identifier: MIT */
#include "sd_calibration.h"

#include <string.h>

#include "sd_page.h"

#define MAGIC 0x31434453u /* "SDC1" */

static void walk_map(sd_page_walk_t *walk, sd_cylinder_map_t *map) {
    sd_page_u8(walk, &map->cylinders);
    sd_page_u8(walk, &map->harmonics);
    sd_page_32(walk, &map->gain_energy);
    sd_page_32(walk, &map->gain_mean);
    sd_page_32(walk, &map->gain_reference);
    for (uint32_t i = 0; i < SD_CYLINDERS_MAX; ++i) {
        for (uint32_t j = 0; j <= 2u * SD_FOURIER_HARMONICS_MAX; ++j) { sd_page_32(walk, &map->map[i][j]); }
        sd_page_32(walk, &map->offset_nm[i]);
        sd_page_32(walk, &map->nm_per_bar[i]);
        sd_page_32(walk, &map->sd_kgm2[i]);
    }
}

static void walk_floats(sd_page_walk_t *walk, float *values, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) { sd_page_32(walk, &values[i]); }
}

static void walk_kalman(sd_page_walk_t *walk, sd_kalman_tables_t *t) {
    sd_page_u8(walk, &t->positions);
    if ((t->positions == 0u) || (t->positions > SD_KALMAN_POSITIONS_MAX)) { return; } /* none, or init will refuse it */
    sd_page_u8(walk, &t->coefficients);
    sd_page_u8(walk, &t->speeds);
    sd_page_u8(walk, &t->sets);
    sd_page_u8(walk, &t->firings);
    sd_page_u8(walk, &t->cylinders);
    sd_page_u8(walk, &t->modes);
    sd_page_u8(walk, &t->shapes);
    sd_page_u8(walk, &t->window);
    sd_page_u8(walk, &t->teeth);
    sd_page_u16(walk, &t->row_words);
    sd_page_u16(walk, &t->gains_at);
    sd_page_32(walk, &t->tick_hz);
    sd_page_32(walk, &t->pitch_rad);
    sd_page_32(walk, &t->shape_min_nm);
    sd_page_32(walk, &t->inertia_mean_kgm2);
    for (uint32_t m = 0; m < SD_KALMAN_MODES_MAX; ++m) {
        walk_floats(walk, (float *)&t->mode[m], sizeof t->mode[m] / sizeof(float)); /* floats without gaps */
    }
    walk_floats(walk, t->speed_radps, SD_KALMAN_SPEEDS_MAX);
    walk_floats(walk, t->gain_scale[0], SD_KALMAN_SETS_MAX * SD_KALMAN_SCALES);
    float *const of_gains[] = { t->noise_rad, t->expected_rad, t->single_sd, t->mean_sd, t->pattern_sd, t->load_sd_nm,
                                 t->mean_share, t->spread_share, t->charge_nm_per_bar, t->learned_nm_per_bar };
    for (uint32_t i = 0; i < sizeof of_gains / sizeof of_gains[0]; ++i) { walk_floats(walk, of_gains[i], SD_KALMAN_GAINS_MAX); }
    const uint32_t used = sd_kalman_pool_used(t);
    walk_floats(walk, &t->pool[0].value, (used <= SD_KALMAN_POOL) ? used : 0u); /* words of any kind, 32 bits each */
}

static void walk_afr(sd_page_walk_t *walk, sd_afr_grid_t *afr) {
    sd_page_u8(walk, &afr->present);
    if (afr->present == 0u) { return; }
    sd_page_u16(walk, &afr->open_position);
    walk_floats(walk, afr->speed_radps, SD_AFR_SPEEDS);
    walk_floats(walk, afr->pressure_bar, SD_AFR_PRESSURES);
    walk_floats(walk, afr->lambda, SD_AFR_LAMBDAS);
    sd_page_32(walk, &afr->air_kg_per_bar);
    sd_page_32(walk, &afr->dead_s);
    sd_page_32(walk, &afr->tau1_s);
    sd_page_32(walk, &afr->tau2_s);
    sd_page_32(walk, &afr->mass_base_kg);
    walk_floats(walk, afr->psi, SD_EXHAUST_PSI + 1u);
    for (uint32_t i = 0; i < SD_AFR_SPEEDS; ++i) {
        walk_floats(walk, (float *)&afr->inversion[i], sizeof afr->inversion[i] / sizeof(float)); /* floats without gaps */
    }
    sd_afr_node_t *node = &afr->node[0][0][0];
    for (uint32_t i = 0; i < SD_AFR_SPEEDS * SD_AFR_PRESSURES * SD_AFR_LAMBDAS; ++i, ++node) {
        for (uint32_t k = 0; k < SD_AFR_OPEN; ++k) { sd_page_u16(walk, &node->share[k]); }
        sd_page_32(walk, &node->rate_hz);
        sd_page_32(walk, &node->z0_kg);
        sd_page_32(walk, &node->transport_kg);
    }
}

static void walk_fields(sd_page_walk_t *walk, sd_calibration_t *c) {
    sd_page_32(walk, &c->tick_hz);
    sd_page_u8(walk, &c->positions);
    sd_page_u8(walk, &c->missing_count);
    for (uint32_t i = 0; i < SD_CRANK_MISSING_MAX; ++i) { sd_page_u8(walk, &c->missing[i]); }
    sd_page_u8(walk, &c->has_cam);
    sd_page_u16(walk, &c->cam_position);
    sd_page_32(walk, &c->position_0_deg);
    sd_page_u8(walk, &c->cylinders);
    for (uint32_t i = 0; i < SD_CYLINDERS_MAX; ++i) { sd_page_u8(walk, &c->firing_order[i]); }
    for (uint32_t i = 0; i < SD_CYLINDERS_MAX; ++i) { sd_page_u16(walk, &c->firing_position[i]); }
    sd_page_32(walk, &c->fourier.inertia_base_kgm2);
    for (uint32_t i = 0; i < SD_FOURIER_POSITIONS_MAX; ++i) { sd_page_32(walk, &c->fourier.inertia_q31[i]); }
    for (uint32_t i = 0; i < 2u * SD_FOURIER_POSITIONS_MAX; ++i) { sd_page_32(walk, &c->fourier.sine_q31[i]); }
    walk_map(walk, &c->cylinder_map);
    walk_kalman(walk, &c->kalman);
    walk_afr(walk, &c->afr);
    float *parameter = (float *)&c->parameters;
    for (uint32_t i = 0; i < SD_PARAMETER_COUNT; ++i) { sd_page_32(walk, &parameter[i]); }
}

_Static_assert(sizeof(sd_parameters_t) == SD_PARAMETER_COUNT * sizeof(float), "parameters are floats, without gaps");

uint32_t sd_calibration_encode(const sd_calibration_t *calibration, uint8_t *bytes) {
    sd_page_walk_t walk = sd_page_write(bytes);
    /* Writing changes no field: the walk takes them by pointer because reading does. */
    walk_fields(&walk, (sd_calibration_t *)calibration);
    return sd_page_seal(&walk, MAGIC);
}

sd_result_t sd_calibration_decode(sd_calibration_t *calibration, const uint8_t *bytes, uint32_t size) {
    sd_page_walk_t walk = sd_page_read(bytes, size);
    if (!sd_page_sealed(&walk, MAGIC)) { return SD_ERR_PAGE; }
    memset(calibration, 0, sizeof *calibration);
    walk_fields(&walk, calibration);
    if (sd_page_complete(&walk)) { return SD_OK; }
    memset(calibration, 0, sizeof *calibration);
    return SD_ERR_PAGE;
}

sd_crank_config_t sd_calibration_crank(const sd_calibration_t *calibration) {
    sd_crank_config_t config = { .positions = calibration->positions,
                                 .missing_count = calibration->missing_count,
                                 .stall_ticks = (uint32_t)(calibration->parameters.crank_stall_s * calibration->tick_hz),
                                 .has_cam = calibration->has_cam,
                                 .cam_position = calibration->cam_position };
    memcpy(config.missing, calibration->missing, sizeof config.missing);
    return config;
}

sd_fourier_config_t sd_calibration_torque(const sd_calibration_t *calibration) {
    const sd_parameters_t *p = &calibration->parameters;
    return (sd_fourier_config_t){ .positions = calibration->positions,
                                  .harmonics = (uint8_t)p->torque_harmonics,
                                  .gain_energy = p->torque_gain_energy_per_rad,
                                  .gain_mean = p->torque_gain_mean_per_rad2,
                                  .gain_reference = p->torque_gain_reference_per_rad2,
                                  .reject_energy = p->torque_reject_energy,
                                  .settle_steps = (uint16_t)(p->torque_settle_cycles * 2.0f *
                                                             (float)(calibration->positions - calibration->missing_count)),
                                  .tick_hz = calibration->tick_hz,
                                  .speed_base_radps = p->torque_speed_base_rpm * 0.10471976f,
                                  .torque_base_nm = p->torque_torque_base_nm };
}

sd_misfire_config_t sd_calibration_misfire(const sd_calibration_t *calibration) {
    const sd_parameters_t *p = &calibration->parameters;
    const float cylinders = (float)calibration->cylinders;
    sd_misfire_config_t config = { .cylinders = calibration->cylinders,
                                   .work_per_fuel_jpmg = p->misfire_work_per_fuel_jpmg,
                                   .cyclic = p->misfire_cyclic,
                                   .z_false = p->misfire_z_false,
                                   .z_missed = p->misfire_z_missed,
                                   .definition = p->misfire_definition,
                                   .partial = p->misfire_partial,
                                   .fuel_min_mg = p->misfire_fuel_min_mg,
                                   .torque_min_nm = p->misfire_torque_min_nm,
                                   .speed_change = p->misfire_speed_change,
                                   .start_firings = (uint16_t)(p->misfire_start_cycles * cylinders),
                                   .hold_firings = (uint16_t)(p->misfire_hold_cycles * cylinders),
                                   .continuous_firings = (uint16_t)p->misfire_continuous,
                                   .emission_percent = p->misfire_emission_percent,
                                   .catalyst_percent = p->misfire_catalyst_percent,
                                   .emission_exceedances = (uint16_t)p->misfire_emission_windows,
                                   .catalyst_exceedances = (uint16_t)p->misfire_catalyst_windows };
    memcpy(config.firing_order, calibration->firing_order, sizeof config.firing_order);
    return config;
}
