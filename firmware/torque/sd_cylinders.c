/* SPDX-License-Identifier: MIT */
#include "sd_cylinders.h"

bool sd_cylinders_fit(const sd_cylinder_map_t *map, const sd_fourier_config_t *config) {
    return (map->cylinders > 0u) && (map->harmonics == config->harmonics) && (map->gain_energy == config->gain_energy) &&
           (map->gain_mean == config->gain_mean) && (map->gain_reference == config->gain_reference);
}

float sd_cylinders_torque(const sd_cylinder_map_t *map, const sd_fourier_estimate_t *estimate, float intake_bar,
                          uint32_t index) {
    float torque_nm = map->offset_nm[index] + map->nm_per_bar[index] * intake_bar;
    for (uint32_t j = 0; j <= 2u * map->harmonics; ++j) { torque_nm += map->map[index][j] * estimate->coefficient_nm[j]; }
    return torque_nm;
}

float sd_cylinders_sd(const sd_cylinder_map_t *map, uint32_t index, float speed_radps, float tooth_error_rad) {
    return map->sd_kgm2[index] * speed_radps * speed_radps * tooth_error_rad;
}
