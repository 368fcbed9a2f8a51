/* SPDX-License-Identifier: MIT */
/// sd_cylinders.h - combustion torque of each cylinder from the coefficients of the torque observer.
///
/// The coefficients at the end of a cycle are a linear image of what each cylinder did: of its combustion torque, of
/// the intake pressure, which is measured, and of the load, through pulse shapes that the calibration knows. The map
/// here undoes it by weighted least squares, what truncation leaves of the pulses included, and leaves the load out (docs/theory/torque.md,
/// "Torque of each cylinder"; `sixdeg calibrate` computes it). Integrating the truncated torque would not do.
///
/// The map belongs to the gains it was computed for. No state, no libm; n_cylinders (2 n_h + 1)
/// multiplications a cycle.
#ifndef SD_CYLINDERS_H
#define SD_CYLINDERS_H
#include "sd_fourier.h"
#include "sd_limits.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Part of the calibration page, read only.
typedef struct sd_cylinder_map {
    uint8_t cylinders; ///< 1 to SD_CYLINDERS_MAX; 0: the harmonics are too few to tell the cylinders apart.
    uint8_t harmonics; ///< n_h of the observer.
    float gain_energy, gain_mean, gain_reference; ///< Gains of the observer that it was made for, as in sd_fourier_config_t.
    float map[SD_CYLINDERS_MAX][2 * SD_FOURIER_HARMONICS_MAX + 1]; ///< By firing order; N m for a N m of coefficient.
    float offset_nm[SD_CYLINDERS_MAX];  ///< Motored torque of each cylinder at no intake pressure.
    float nm_per_bar[SD_CYLINDERS_MAX]; ///< Of intake pressure.
    float sd_kgm2[SD_CYLINDERS_MAX]; ///< Standard deviation over omega^2 and over the tooth times' error in rad.
} sd_cylinder_map_t;

/// Whether the map was computed for an observer with this configuration.
bool sd_cylinders_fit(const sd_cylinder_map_t *map, const sd_fourier_config_t *config);

/// Mean combustion torque over the 180 deg after TDC, N m, of firing `index` < map->cylinders in firing order, from
/// the estimate at the end of a cycle (last tooth before position 0) and the intake pressure. An error of the pressure
/// moves all cylinders alike. Finite for finite inputs.
float sd_cylinders_torque(const sd_cylinder_map_t *map, const sd_fourier_estimate_t *estimate, float intake_bar,
                          uint32_t index);

/// Standard deviation of that torque, N m: what white errors of the tooth times make of it, in rad at speed_radps.
/// Errors of the engine model are not in it.
float sd_cylinders_sd(const sd_cylinder_map_t *map, uint32_t index, float speed_radps, float tooth_error_rad);

#ifdef __cplusplus
}
#endif

#endif
