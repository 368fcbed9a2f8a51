/* SPDX-License-Identifier: MIT */
/// sd_calibration.h - the calibration page: all that distinguishes one engine from another, in one struct and in one
/// byte sequence of fixed order (little endian) that every target reads alike. `sixdeg calibrate` makes it.
#ifndef SD_CALIBRATION_H
#define SD_CALIBRATION_H
#include "sd_afr.h"
#include "sd_crank.h"
#include "sd_cylinders.h"
#include "sd_fourier.h"
#include "sd_kalman.h"
#include "sd_misfire.h"
#include "sd_signals.h"

/// Decoded page. Angles are positions of the wheel over the cycle: 0 to 2 positions - 1.
typedef struct sd_calibration {
    float    tick_hz;                       ///< Capture timer, [1e5, 2e8].
    uint8_t  positions, missing_count;      ///< As in sd_crank_config_t.
    uint8_t  missing[SD_CRANK_MISSING_MAX];
    uint8_t  has_cam;
    uint16_t cam_position;
    float    position_0_deg;                ///< Crank angle of position 0, [0, 360); 0 = firing TDC of firing_order[0].
    uint8_t  cylinders;                     ///< 1 to SD_CYLINDERS_MAX.
    uint8_t  firing_order[SD_CYLINDERS_MAX];    ///< Physical cylinder, 1-based, of each firing.
    uint16_t firing_position[SD_CYLINDERS_MAX]; ///< First cycle position at or after the firing TDC, in that order.
    sd_fourier_tables_t fourier;    ///< Of the torque observer; the AFR blocks take its sines too.
    sd_cylinder_map_t cylinder_map; ///< Of the gains in parameters as they came.
    sd_kalman_tables_t kalman;      ///< Of the parameters firing.* as they came; positions 0: none.
    sd_afr_grid_t afr;              ///< present 0: the engine file names no exhaust.
    sd_parameters_t parameters;
} sd_calibration_t;

#define SD_CALIBRATION_BYTES_MAX 131072u

/// Writes the page to `bytes` (room for SD_CALIBRATION_BYTES_MAX); returns its size.
uint32_t sd_calibration_encode(const sd_calibration_t *calibration, uint8_t *bytes);

/// SD_OK, or SD_ERR_PAGE with *calibration untouched: wrong magic, size, signal table or checksum; or all zero, which
/// init refuses: a right checksum over something else than a page.
sd_result_t sd_calibration_decode(sd_calibration_t *calibration, const uint8_t *bytes, uint32_t size);

/// What the blocks are initialised with.
sd_crank_config_t   sd_calibration_crank(const sd_calibration_t *calibration);
sd_fourier_config_t sd_calibration_torque(const sd_calibration_t *calibration);
sd_misfire_config_t sd_calibration_misfire(const sd_calibration_t *calibration);

#endif
