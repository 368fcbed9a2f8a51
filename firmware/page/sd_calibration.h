/* SPDX-License-Identifier: MIT */
/// sd_calibration.h - the calibration page: all that distinguishes one engine from another, in one struct that is read where
/// it lies and never copied. `sixdeg calibrate` makes it, as a file or as a C array for a target's flash.
///
/// The page ends where the used part of kalman.pool ends, so a stored page may be shorter than sizeof(sd_calibration_t): hold it
/// by pointer, and do not copy it by assignment.
#ifndef SD_CALIBRATION_H
#define SD_CALIBRATION_H
#include "sd_afr.h"
#include "sd_airpath_bank.h"
#include "sd_crank.h"
#include "sd_cylinders.h"
#include "sd_driveline_tables.h"
#include "sd_fourier.h"
#include "sd_kalman.h"
#include "sd_misfire.h"
#include "sd_page.h"
#include "sd_signals.h"
#include "sd_switched_wheel.h"

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

/// What the ecu knows of the driveline, where the engine file tells of one.
typedef struct sd_page_driveline {
    /// How far behind its nominal place each tooth seems to stand to who takes the crank's inertia as constant, rad, [-0.1, 0.1]: it
    /// varies with the angle, and the crank's speed with it. By position; beyond the wheel's, 0.
    float    place_rad[SD_KALMAN_POSITIONS_MAX];
    float    drag_nm;     ///< What friction takes of the cylinders' torque, beside tables.viscous_nms, [-1000, 1000] N m.
    uint16_t wheel;       ///< sd_wheel_t whose teeth tell the speed of the driven wheels.
    uint16_t firing_positions; ///< Wheel positions from firing to firing, on average, 1 to 240.
    sd_driveline_tables_t tables; ///< Stored as far as its gears go.
} sd_page_driveline_t;

/// Angles are positions of the wheel over the cycle: 0 to 2 positions - 1. Fields that no table needs are 0.
typedef struct sd_calibration {
    sd_page_head_t head;          ///< Filled by sd_calibration_seal.
    uint32_t fixed_bytes;         ///< Of the page before kalman.pool: another value is another format. Filled by sd_calibration_seal.
    float    tick_hz;             ///< Capture timer, [1e5, 2e8].
    float    position_0_deg;      ///< Crank angle of position 0, [0, 360]; 0 = firing TDC of firing_order[0].
    uint16_t cam_position;        ///< Of the cam edge, as in sd_crank_config_t.
    uint8_t  has_cam;             ///< As in sd_crank_config_t.
    uint8_t  positions;           ///< Tooth positions a revolution, missing ones included, as in sd_crank_config_t.
    uint8_t  missing[SD_CRANK_MISSING_MAX]; ///< Missing positions, ascending.
    uint8_t  missing_count;       ///< How many of them count.
    uint8_t  cylinders;           ///< 1 to SD_CYLINDERS_MAX.
    uint8_t  reserved[2];         ///< 0.
    uint32_t driveline_at;        ///< Word of kalman.pool, behind those that it uses, where sd_page_driveline_t begins; 0: there is none.
    uint8_t  firing_order[SD_CYLINDERS_MAX];    ///< Physical cylinder, 1-based, of each firing.
    uint16_t firing_position[SD_CYLINDERS_MAX]; ///< First cycle position at or after the firing TDC, in that order.
    sd_parameters_t   parameters;   ///< As the firmware starts with them.
    sd_fourier_tables_t fourier;    ///< Of the torque observer; the AFR blocks take its sines too.
    sd_cylinder_map_t cylinder_map; ///< Of the gains in `parameters`.
    sd_afr_grid_t     afr;          ///< present 0: the engine file names no exhaust.
    sd_airpath_tables_f32_t airpath;     ///< present 0: the engine file names no air path with a design.
    sd_airpath_tables_q31_t airpath_q31; ///< The same in fixed point; present 0: there is none, or its numbers do not fit.
    sd_wheel_tables_t wheel;      ///< Document 000's observers; positions 0: the engine file tells no heat release.
    sd_kalman_tables_t kalman;      ///< Of the parameters firing.*; positions 0: none. Its pool ends the page, the driveline behind it.
} sd_calibration_t;

/// The driveline of the page, where it lies; NULL: it has none.
static inline const sd_page_driveline_t *sd_calibration_driveline(const sd_calibration_t *page) {
    return (page->driveline_at == 0u) ? NULL : (const sd_page_driveline_t *)(const void *)&page->kalman.pool[page->driveline_at];
}

/// Words that one takes with so many gears.
uint32_t sd_page_driveline_words(uint32_t gears);

/// Whether its numbers that the guard filter does not check are in their ranges.
bool sd_page_driveline_ok(const sd_page_driveline_t *driveline);

/// Size of the page: up to the end of the used part of kalman.pool, and of the driveline behind it.
uint32_t sd_calibration_bytes(const sd_calibration_t *page);

/// Makes the first sd_calibration_bytes() bytes of *page a page that can be stored.
void sd_calibration_seal(sd_calibration_t *page);

/// The page in stored bytes, where they lie. NULL when they are no such page: not aligned to 4 bytes, of another size, format,
/// byte order or signal table, or with a wrong checksum. Whether its numbers can be used, sd_ecu_init says.
const sd_calibration_t *sd_calibration_view(const void *bytes, uint32_t size);

/// A right checksum is no proof of right numbers: false when a field that no block checks itself is out of its range, NaN
/// included.
bool sd_calibration_in_range(const sd_calibration_t *page);

/// What the blocks are initialised with: from the page, and from the parameters that rule now.
sd_crank_config_t   sd_calibration_crank(const sd_calibration_t *page, const sd_parameters_t *parameters);
sd_fourier_config_t sd_calibration_torque(const sd_calibration_t *page, const sd_parameters_t *parameters);
sd_misfire_config_t sd_calibration_misfire(const sd_calibration_t *page, const sd_parameters_t *parameters);
sd_wheel_config_f32_t sd_calibration_wheel(const sd_calibration_t *page, const sd_parameters_t *parameters, sd_wheel_kind_t kind);
/// Work of 1 mg of fuel, per unit of the wheel's work base.
float sd_calibration_work(const sd_calibration_t *page, const sd_parameters_t *parameters);

#ifdef __cplusplus
}
#endif
#endif
