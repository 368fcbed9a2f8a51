/* SPDX-License-Identifier: MIT */
#include "sd_calibration.h"

#include <string.h>

#define MAGIC 0x31434453u /* "SDC1" */

enum { HEADER_BYTES = 12, CHECKSUM_BYTES = 4 }; /* header: magic, size, table signature */

/* One walk over the fields serves both ways, so that they cannot disagree. */
typedef struct sd_walk {
    uint8_t *bytes;
    uint32_t at;
    bool     writing;
} sd_walk_t;

static void walk_bits(sd_walk_t *walk, uint32_t *bits, uint32_t count) {
    if (!walk->writing) { *bits = 0u; }
    for (uint32_t i = 0; i < count; ++i) {
        uint8_t *byte = &walk->bytes[walk->at++];
        if (walk->writing) { *byte = (uint8_t)(*bits >> (8u * i)); } else { *bits |= (uint32_t)*byte << (8u * i); }
    }
}

static void walk_u8(sd_walk_t *walk, uint8_t *value) {
    uint32_t bits = *value;
    walk_bits(walk, &bits, 1u);
    *value = (uint8_t)bits;
}

static void walk_u16(sd_walk_t *walk, uint16_t *value) {
    uint32_t bits = *value;
    walk_bits(walk, &bits, 2u);
    *value = (uint16_t)bits;
}

/* int32_t and float by their bits. */
static void walk_32(sd_walk_t *walk, void *value) {
    uint32_t bits;
    memcpy(&bits, value, sizeof bits);
    walk_bits(walk, &bits, 4u);
    memcpy(value, &bits, sizeof bits);
}

static void walk_map(sd_walk_t *walk, sd_cylinder_map_t *map) {
    walk_u8(walk, &map->cylinders);
    walk_u8(walk, &map->harmonics);
    walk_32(walk, &map->gain_energy);
    walk_32(walk, &map->gain_mean);
    walk_32(walk, &map->gain_reference);
    for (uint32_t i = 0; i < SD_CYLINDERS_MAX; ++i) {
        for (uint32_t j = 0; j <= 2u * SD_FOURIER_HARMONICS_MAX; ++j) { walk_32(walk, &map->map[i][j]); }
        walk_32(walk, &map->offset_nm[i]);
        walk_32(walk, &map->nm_per_bar[i]);
        walk_32(walk, &map->sd_kgm2[i]);
    }
}

static void walk_floats(sd_walk_t *walk, float *values, uint32_t count) {
    for (uint32_t i = 0; i < count; ++i) { walk_32(walk, &values[i]); }
}

static void walk_afr(sd_walk_t *walk, sd_afr_grid_t *afr) {
    walk_u8(walk, &afr->present);
    if (afr->present == 0u) { return; }
    walk_u16(walk, &afr->open_position);
    walk_floats(walk, afr->speed_radps, SD_AFR_SPEEDS);
    walk_floats(walk, afr->pressure_bar, SD_AFR_PRESSURES);
    walk_floats(walk, afr->lambda, SD_AFR_LAMBDAS);
    walk_32(walk, &afr->air_kg_per_bar);
    walk_32(walk, &afr->dead_s);
    walk_32(walk, &afr->tau1_s);
    walk_32(walk, &afr->tau2_s);
    walk_32(walk, &afr->mass_base_kg);
    walk_floats(walk, afr->psi, SD_EXHAUST_PSI + 1u);
    sd_afr_node_t *node = &afr->node[0][0][0];
    for (uint32_t i = 0; i < SD_AFR_SPEEDS * SD_AFR_PRESSURES * SD_AFR_LAMBDAS; ++i, ++node) {
        for (uint32_t k = 0; k < SD_AFR_OPEN; ++k) { walk_u16(walk, &node->share[k]); }
        walk_32(walk, &node->rate_hz);
        walk_32(walk, &node->z0_kg);
        walk_32(walk, &node->transport_kg);
    }
}

static void walk_fields(sd_walk_t *walk, sd_calibration_t *c) {
    walk_32(walk, &c->tick_hz);
    walk_u8(walk, &c->positions);
    walk_u8(walk, &c->missing_count);
    for (uint32_t i = 0; i < SD_CRANK_MISSING_MAX; ++i) { walk_u8(walk, &c->missing[i]); }
    walk_u8(walk, &c->has_cam);
    walk_u16(walk, &c->cam_position);
    walk_32(walk, &c->position_0_deg);
    walk_u8(walk, &c->cylinders);
    for (uint32_t i = 0; i < SD_CYLINDERS_MAX; ++i) { walk_u8(walk, &c->firing_order[i]); }
    for (uint32_t i = 0; i < SD_CYLINDERS_MAX; ++i) { walk_u16(walk, &c->firing_position[i]); }
    for (uint32_t i = 0; i < SD_FOURIER_POSITIONS_MAX; ++i) { walk_32(walk, &c->inertia_kgm2[i]); }
    for (uint32_t i = 0; i < 2u * SD_FOURIER_POSITIONS_MAX; ++i) { walk_32(walk, &c->sine_q31[i]); }
    walk_map(walk, &c->cylinder_map);
    walk_afr(walk, &c->afr);
    float *parameter = (float *)&c->parameters;
    for (uint32_t i = 0; i < SD_PARAMETER_COUNT; ++i) { walk_32(walk, &parameter[i]); }
}

_Static_assert(sizeof(sd_parameters_t) == SD_PARAMETER_COUNT * sizeof(float), "parameters are floats, without gaps");

/* CRC-32 of IEEE 802.3, bit by bit: a page is read once. */
static uint32_t checksum(const uint8_t *bytes, uint32_t size) {
    uint32_t crc = 0xffffffffu;
    for (uint32_t i = 0; i < size; ++i) {
        crc ^= bytes[i];
        for (uint32_t bit = 0; bit < 8u; ++bit) { crc = (crc >> 1) ^ ((crc & 1u) ? 0xedb88320u : 0u); }
    }
    return ~crc;
}

static void walk_header(sd_walk_t *walk, uint32_t header[3]) {
    for (uint32_t i = 0; i < 3u; ++i) { walk_32(walk, &header[i]); }
}

uint32_t sd_calibration_encode(const sd_calibration_t *calibration, uint8_t *bytes) {
    sd_calibration_t copy = *calibration;
    sd_walk_t walk = { bytes, HEADER_BYTES, true };
    walk_fields(&walk, &copy);
    const uint32_t end = walk.at;
    uint32_t header[3] = { MAGIC, end + CHECKSUM_BYTES, SD_SIGNALS_SIGNATURE };
    walk.at = 0;
    walk_header(&walk, header);
    uint32_t crc = checksum(bytes, end);
    walk.at = end;
    walk_32(&walk, &crc);
    return walk.at;
}

sd_result_t sd_calibration_decode(sd_calibration_t *calibration, const uint8_t *bytes, uint32_t size) {
    if ((size < HEADER_BYTES + CHECKSUM_BYTES) || (size > SD_CALIBRATION_BYTES_MAX)) { return SD_ERR_PAGE; }
    uint8_t copy[SD_CALIBRATION_BYTES_MAX] = { 0 };
    memcpy(copy, bytes, size);
    sd_walk_t walk = { copy, 0, false };
    uint32_t header[3], crc;
    walk_header(&walk, header);
    if ((header[0] != MAGIC) || (header[1] != size) || (header[2] != SD_SIGNALS_SIGNATURE)) { return SD_ERR_PAGE; }
    sd_calibration_t fresh;
    memset(&fresh, 0, sizeof fresh);
    walk_fields(&walk, &fresh);
    if (walk.at + CHECKSUM_BYTES != size) { return SD_ERR_PAGE; }
    walk_32(&walk, &crc);
    if (crc != checksum(bytes, size - CHECKSUM_BYTES)) { return SD_ERR_PAGE; }
    *calibration = fresh;
    return SD_OK;
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
                                  .torque_base_nm = p->torque_torque_base_nm,
                                  .inertia_kgm2 = calibration->inertia_kgm2,
                                  .sine_q31 = calibration->sine_q31 };
}
