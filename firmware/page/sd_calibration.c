/* SPDX-License-Identifier: MIT */
#include "sd_calibration.h"

#include <stddef.h>
#include <string.h>

#include "sd_value.h"

#define MAGIC 0x33434453u /* "SDC3" */
#define NUMBER_MAX 1e9f
#define FIXED_BYTES ((uint32_t)offsetof(sd_calibration_t, kalman.pool))

_Static_assert(sizeof(sd_parameters_t) == SD_PARAMETER_COUNT * sizeof(float), "parameters are floats, without gaps");
_Static_assert(sizeof(sd_calibration_t) == FIXED_BYTES + sizeof(((sd_calibration_t *)0)->kalman.pool), "the pool ends the page");

uint32_t sd_calibration_bytes(const sd_calibration_t *page) {
    const sd_page_driveline_t *driveline = sd_calibration_driveline(page);
    const uint32_t words = (driveline != NULL) ? page->driveline_at + sd_page_driveline_words(driveline->tables.gears)
                                               : sd_kalman_pool_used(&page->kalman);
    return FIXED_BYTES + words * (uint32_t)sizeof page->kalman.pool[0];
}

uint32_t sd_page_driveline_words(uint32_t gears) {
    return (uint32_t)((offsetof(sd_page_driveline_t, tables.gear) + gears * sizeof(sd_driveline_gear_t)) / sizeof(float));
}

bool sd_page_driveline_ok(const sd_page_driveline_t *driveline) {
    bool ok = sd_bits_within(driveline->drag_nm, -1000.0f, 1000.0f) && (driveline->firing_positions >= 1u);
    for (uint32_t k = 0; ok && (k < SD_KALMAN_POSITIONS_MAX); ++k) { ok = sd_bits_within(driveline->place_rad[k], -0.1f, 0.1f); }
    return ok;
}

void sd_calibration_seal(sd_calibration_t *page) {
    page->fixed_bytes = FIXED_BYTES;
    sd_page_seal(&page->head, MAGIC, sd_calibration_bytes(page));
}

/* As far as its number of gears can be read. */
static bool driveline_lies_within(const sd_calibration_t *page, uint32_t size) {
    const uint32_t words = (size - FIXED_BYTES) / (uint32_t)sizeof page->kalman.pool[0], at = page->driveline_at;
    if (at == 0u) { return true; }
    return (at >= sd_kalman_pool_used(&page->kalman)) && (at < words) && (words - at >= sd_page_driveline_words(0u));
}

const sd_calibration_t *sd_calibration_view(const void *bytes, uint32_t size) {
    const sd_calibration_t *page = (const sd_calibration_t *)bytes;
    if ((size < FIXED_BYTES) || !sd_page_sealed(bytes, size, MAGIC) || !driveline_lies_within(page, size)) { return NULL; }
    return ((page->fixed_bytes == FIXED_BYTES) && (sd_calibration_bytes(page) == size)) ? page : NULL;
}

/* ---- ranges ---------------------------------------------------------------------------------------------------- */

static bool within(float x, float low, float high) { return sd_bits_within(x, low, high); } /* false for NaN */

static bool map_ok(const sd_calibration_t *page) {
    const sd_cylinder_map_t *map = &page->cylinder_map;
    bool ok = ((map->cylinders == 0u) || (map->cylinders == page->cylinders)) && (map->harmonics <= SD_FOURIER_HARMONICS_MAX);
    for (uint32_t i = 0; ok && (i < map->cylinders); ++i) {
        ok = within(map->offset_nm[i], -NUMBER_MAX, NUMBER_MAX) && within(map->nm_per_bar[i], -NUMBER_MAX, NUMBER_MAX) &&
             within(map->sd_kgm2[i], 0.0f, NUMBER_MAX);
        for (uint32_t j = 0; ok && (j <= 2u * map->harmonics); ++j) { ok = within(map->map[i][j], -NUMBER_MAX, NUMBER_MAX); }
    }
    return ok;
}

static bool cylinders_ok(const sd_calibration_t *page) {
    bool ok = (page->cylinders >= 1u) && (page->cylinders <= SD_CYLINDERS_MAX) && map_ok(page);
    for (uint32_t i = 0; ok && (i < page->cylinders); ++i) {
        ok = (page->firing_order[i] >= 1u) && (page->firing_order[i] <= SD_CYLINDERS_MAX) &&
             (page->firing_position[i] < 2u * page->positions);
    }
    return ok;
}

static bool wheel_ok(const sd_calibration_t *page) {
    const sd_wheel_tables_t *w = &page->wheel;
    const bool bases = (w->accel_exponent >= 0) && (w->accel_exponent <= 30) && (w->work_exponent >= 0) && (w->work_exponent <= 30);
    return bases && ((w->positions == 0u) || ((w->positions == page->positions) && (w->cylinders == page->cylinders)));
}

static bool work_ok(const sd_calibration_t *page) {
    const sd_work_tables_t *w = &page->work;
    return sd_work_tables_ok(w) && ((w->windows == 0u) || ((w->windows == page->cylinders) && (w->cycle == 2u * page->positions)));
}

static bool airpath_ok(const sd_calibration_t *page) {
#ifndef SD_ECU_FIXED /* which does not read these */
    if (!sd_airpath_tables_ok_f32(&page->airpath)) { return false; }
#endif
    return (page->airpath.present >= page->airpath_q31.present) && (page->airpath.present <= 1u) &&
           sd_airpath_tables_ok_q31(&page->airpath_q31);
}

bool sd_calibration_in_range(const sd_calibration_t *page) {
    const float *parameter = (const float *)&page->parameters;
    bool ok = within(page->position_0_deg, 0.0f, 360.0f) && within(page->tick_hz, 1e5f, 2e8f) && cylinders_ok(page) &&
              ((page->kalman.positions == 0u) || (page->kalman.positions == page->positions)) && wheel_ok(page) && airpath_ok(page) &&
              work_ok(page);
    for (uint32_t i = 0; ok && (i < SD_PARAMETER_COUNT); ++i) {
        ok = within(parameter[i], sd_parameter_infos[i].low, sd_parameter_infos[i].high);
    }
    return ok;
}

/* ---- configurations -------------------------------------------------------------------------------------------- */

sd_crank_config_t sd_calibration_crank(const sd_calibration_t *page, const sd_parameters_t *p) {
    sd_crank_config_t config = { .positions = page->positions,
                                 .missing_count = page->missing_count,
                                 .stall_ticks = V(floor)(V(mul)(V(of)(p->crank_stall_time_s), V(of)(page->tick_hz))),
                                 .has_cam = page->has_cam,
                                 .cam_position = page->cam_position };
    memcpy(config.missing, page->missing, sizeof config.missing);
    return config;
}

sd_fourier_config_t sd_calibration_torque(const sd_calibration_t *page, const sd_parameters_t *p) {
    const sd_value_t teeth = V(mul)(V(mul)(V(of)(p->torque_settle_cycles), V(int)(2)), V(int)(page->positions - page->missing_count));
    return (sd_fourier_config_t){ .positions = page->positions,
                                  .harmonics = (uint8_t)V(floor)(V(of)(p->torque_harmonics)),
                                  .gain_energy = p->torque_gain_energy_per_rad,
                                  .gain_mean = p->torque_gain_mean_per_rad2,
                                  .gain_reference = p->torque_gain_reference_per_rad2,
                                  .reject_energy = p->torque_reject_energy_share,
                                  .settle_steps = (uint16_t)V(floor)(teeth),
                                  .tick_hz = page->tick_hz,
                                  .speed_base_radps = V(float)(V(mul)(V(of)(p->torque_speed_base_rpm), V(of)(0.10471976f))),
                                  .torque_base_nm = p->torque_torque_base_nm };
}

sd_misfire_config_t sd_calibration_misfire(const sd_calibration_t *page, const sd_parameters_t *p) {
    const float cylinders = (float)page->cylinders;
    sd_misfire_config_t config = { .cylinders = page->cylinders,
                                   .work_per_fuel_jpmg = p->misfire_work_per_fuel_jpmg,
                                   .cyclic = p->misfire_cyclic_variation,
                                   .z_false = p->misfire_z_false,
                                   .z_missed = p->misfire_z_missed,
                                   .definition = p->misfire_misfire_below,
                                   .partial = p->misfire_partial_burn_below,
                                   .fuel_min_mg = p->misfire_fuel_min_mg,
                                   .torque_min_nm = p->misfire_torque_min_nm,
                                   .speed_change = p->misfire_shift_speed_change,
                                   .start_firings = (uint16_t)(p->misfire_start_inhibit_cycles * cylinders),
                                   .hold_firings = (uint16_t)(p->misfire_resume_inhibit_cycles * cylinders),
                                   .continuous_firings = (uint16_t)p->misfire_continuous_firings,
                                   .emission_percent = p->misfire_emission_percent,
                                   .catalyst_percent = p->misfire_catalyst_percent,
                                   .emission_exceedances = (uint16_t)p->misfire_emission_windows,
                                   .catalyst_exceedances = (uint16_t)p->misfire_catalyst_windows };
    memcpy(config.firing_order, page->firing_order, sizeof config.firing_order);
    return config;
}

float sd_calibration_work(const sd_calibration_t *page, const sd_parameters_t *p) {
    return p->misfire_work_per_fuel_jpmg / (float)(1u << (uint32_t)page->wheel.work_exponent);
}

static float clamp(float x, float low, float high) { return (x < low) ? low : (x > high) ? high : x; }

sd_wheel_config_f32_t sd_calibration_wheel(const sd_calibration_t *page, const sd_parameters_t *p, sd_wheel_kind_t kind) {
    const float cylinders = (float)page->cylinders, of_torque_mg = p->misfire_torque_min_nm * 3.14159265f / p->misfire_work_per_fuel_jpmg;
    const float fuel_min_mg = (p->misfire_fuel_min_mg > of_torque_mg) ? p->misfire_fuel_min_mg : of_torque_mg;
    return (sd_wheel_config_f32_t){ .definition = p->misfire_misfire_below,
                                    .work_min = clamp(fuel_min_mg * sd_calibration_work(page, p), 1e-6f, 0.999f),
                                    .speed_change = clamp(2.0f * p->misfire_shift_speed_change, 1e-3f, 0.999f), /* of the square */
                                    .start_firings = (uint16_t)(p->misfire_start_inhibit_cycles * cylinders),
                                    .hold_firings = (uint16_t)(p->misfire_resume_inhibit_cycles * cylinders),
                                    .kind = (uint8_t)kind };
}
