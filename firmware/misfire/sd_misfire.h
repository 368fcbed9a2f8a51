/* SPDX-License-Identifier: MIT */
/// sd_misfire.h - the event monitor: from the torque of every single firing to verdicts, rates and a decision.
///
/// Index of a firing = torque it gave / torque expected of its fuel: 1 healthy, 0 misfire. The expectation is
///     expected = fuel x work_per_fuel / pi x factor of the cylinder            (mean over the 180 deg after TDC)
/// and the factor learns slowly from firings that were found healthy (and from weak ones in a cylinder's first 16, when
/// the expectation itself may be wrong), within 0.6 to 1.5. No firing is ever compared with its
/// neighbours, so two cylinders missing together, or all, are seen like one.
///
/// From firing to firing the estimate errs alike, or the other way, where the load moves: what the last firing was off
/// its level (1, or 0 for a misfire) tells of this one. The index is that of the torque less rho times that, rho the
/// lag-one correlation of healthy firings, learned; where they are independent it is near 0.
///
/// The healthy index scatters by sd_0 (combustion and estimate), that of a misfire by sd_1 (estimate alone):
///     sd_0^2 = (min(r, 1) + d) cyclic^2 + (torque_sd / expected)^2,   sd_1^2 = d cyclic^2 + (torque_sd / expected)^2
/// r is learned from the upper half of the scatter, which no misfire reaches. Up to 1 it is combustion; sqrt(8/n) more, two deviations of a
/// mean of n squares (n up to 132), may be chance; what is beyond, d, is disturbance that a misfire has too: the adaptation to rough roads.
/// A misfire is less than `definition` of the work expected. Where that would break the wanted error rates, the limit
/// moves to the nearest that keeps both, limit in [z_missed sd_1, 1 - z_false sd_0]; where none does, it shares the
/// shortage between both in proportion: z_missed sd_1 / (z_missed sd_1 + z_false sd_0). Status is degraded then.
/// A partial burn is a firing below `partial` and below 1 - z_false sd_0 that is no misfire.
///
/// Windows of 200 and 1000 revolutions follow one another and count monitored firings only; the shape of the decision is
/// that of OBD II as recalled, not verified against the regulation (docs/theory/misfire.md).
///
/// Real-time contract: no heap, no globals, no libm; one call a firing, loops over cylinders only. One writer per state.
/// Call order: init; start whenever the engine or the estimator started; firing for each; read.
#ifndef SD_MISFIRE_H
#define SD_MISFIRE_H
#include "sd_limits.h"
#include "sd_misfire_verdict.h"
#include "sd_num.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_MISFIRE_CYLINDERS_MAX SD_CYLINDERS_MAX ///< Cylinders of an engine.

/// SI units but for fuel; read by init only, need not outlive it.
typedef struct sd_misfire_config {
    uint8_t  cylinders;                              ///< 1 to SD_MISFIRE_CYLINDERS_MAX.
    uint8_t  firing_order[SD_MISFIRE_CYLINDERS_MAX]; ///< Physical cylinder, 1 to cylinders, of each firing; each once.
    float    work_per_fuel_jpmg; ///< Work of combustion of a healthy firing, [0.001, 100].
    float    cyclic;             ///< Largest usual standard deviation of a healthy firing's work over its mean, [0.001, 0.5].
    float    z_false, z_missed;  ///< Wanted distances in deviations: 3.54 is 2 in 10,000, 2.58 is 5 in 1000; [1, 6].
    float    definition;         ///< Share of the work below which it is a misfire, [0.2, 0.8].
    float    partial;            ///< Share of the work below which it is a partial burn, [definition, 1].
    float    fuel_min_mg;        ///< Below it there is nothing to monitor, > 0.
    float    torque_min_nm;      ///< The same for the expected torque, >= 0.
    float    speed_change;       ///< Change of speed from firing to firing beyond which the gear is being shifted, (0, 1].
    uint16_t start_firings;      ///< Not monitored after a start, any number.
    uint16_t hold_firings;       ///< Not monitored after fuel cut or a shift, whoever noticed it, any number.
    uint16_t continuous_firings; ///< Of a cylinder, all misfires, from which it counts as continuous; >= 2.
    float    emission_percent;   ///< Of the firings in 1000 revolutions, [0.001, 100].
    float    catalyst_percent;   ///< Of the firings in 200 revolutions, [0.001, 100].
    uint16_t emission_exceedances; ///< Windows that light the lamp, after the first 1000 revolutions; >= 1.
    uint16_t catalyst_exceedances; ///< Windows that make it blink; >= 1.
} sd_misfire_config_t;

/// The malfunction lamp.
typedef enum sd_lamp {
    SD_LAMP_OFF = 0,      ///< No window was exceeded.
    SD_LAMP_PENDING = 1,  ///< A window was exceeded.
    SD_LAMP_ON = 2,       ///< Emissions.
    SD_LAMP_BLINKS = 3,   ///< Catalyst.
} sd_lamp_t;

/// A firing as the estimator reports it.
typedef struct sd_misfire_firing {
    uint8_t index;        ///< In firing order.
    uint8_t health;       ///< sd_health_t of the torque; invalid is not judged.
    uint8_t geared;       ///< 1: it is known that a gear is in and the clutch closed; a change of speed is then no sign of a shift.
    uint8_t inhibit;      ///< Not 0: not judged; sd_inhibit_t bits that the caller knows of.
    float   torque_nm;    ///< Mean combustion torque over the 180 deg after its TDC.
    float   torque_sd_nm; ///< >= 0.
    float   fuel_mg;      ///< Commanded for this firing.
    float   speed_radps;  ///< > 0.
    float   energy_j;     ///< Kinetic energy of the crank; widens what counts as a shift by what a misfire does. 0: unknown.
} sd_misfire_firing_t;

/// What is said of a firing.
typedef struct sd_misfire_verdict {
    uint8_t verdict;   ///< sd_verdict_t.
    uint8_t inhibit;   ///< sd_inhibit_t bits, 0 when judged.
    uint8_t firing;    ///< In firing order, from 0.
    uint8_t cylinder;  ///< Physical, from 1.
    float   index, index_sd, limit; ///< Torque given over torque expected; sd_0, the deviation of a healthy one; limit of the index. 0 when
                                    ///< not judged.
} sd_misfire_verdict_t;

/// Firings and misfires in a window, by physical cylinder.
typedef struct sd_misfire_window {
    uint32_t firings, misfires[SD_MISFIRE_CYLINDERS_MAX]; ///< Monitored, of all cylinders; misfires of each.
} sd_misfire_window_t;

/// Decisions and rates; those of a window are of the last complete one.
typedef struct sd_misfire_report {
    float    percent_200[SD_MISFIRE_CYLINDERS_MAX], percent_1000[SD_MISFIRE_CYLINDERS_MAX]; ///< Of that cylinder's firings.
    uint32_t firings, misfires, partial_burns; ///< Judged since init, saturating.
    uint8_t  continuous;   ///< Bit n - 1: cylinder n misfires each time.
    uint8_t  suspects;     ///< Bit n - 1: cylinder n has over a tenth of the misfires of the window that decided.
    uint8_t  lamp;         ///< sd_lamp_t.
    uint16_t emission_exceeded, catalyst_exceeded; ///< Windows so far.
    sd_status_t status;    ///< rejected: firings not judged. test_ratio: wanted over available distance; above 1 degraded.
} sd_misfire_report_t;

/// Plain data, caller-owned.
typedef struct sd_misfire {
    float    factor[SD_MISFIRE_CYLINDERS_MAX];     ///< By firing.
    uint8_t  learned[SD_MISFIRE_CYLINDERS_MAX];    ///< Firings that the factor has learned from, up to 64.
    uint16_t in_row[SD_MISFIRE_CYLINDERS_MAX];     ///< Misfires, by firing.
    uint8_t  scatter_seen;                         ///< Firings that the scatter has learned from, up to 64.
    float    scatter;                              ///< r, a mean of squares over the expected one, >= 0; 1 at init.
    float    last_off;                             ///< Index of the firing before less its level, over sd_0; 0: unknown.
    float    off_square, off_product;              ///< Running means, of neighbours both healthy; their ratio is rho.
    float    last_speed_radps, test_ratio, innovation; ///< At the last firing; the last two as in sd_status_t.
    uint16_t hold, since_start;                    ///< Firings left; firings since start, saturating.
    uint16_t rejected, emission_exceeded, catalyst_exceeded, why; ///< As in the report and in its status.
    uint8_t  health, lamp, suspects;               ///< As in the report and in its status.
    uint8_t  first_1000_done;                      ///< 1: the first 1000 revolutions are over.
    uint32_t firings, misfires, partial_burns;     ///< Judged since init, saturating.
    sd_misfire_window_t running_200, running_1000, last_200, last_1000;
    sd_misfire_config_t config;
} sd_misfire_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched.
sd_result_t sd_misfire_init(sd_misfire_t *self, const sd_misfire_config_t *config);
/// Other choices from the next firing on, of the same engine. SD_OK, or SD_ERR_CONFIG with the state untouched. Counts stay,
/// and what was learned too, unless it was relative to what changes (work_per_fuel_jpmg, cyclic): then as after a start.
sd_result_t sd_misfire_configure(sd_misfire_t *self, const sd_misfire_config_t *config);
/// The engine, or the estimator, starts: the next start_firings are not judged. Counts and what was learned stay.
void sd_misfire_start(sd_misfire_t *self);
/// Judges a firing and learns from it; never NaN. An index out of range is counted as rejected and not judged.
sd_misfire_verdict_t sd_misfire_assess(sd_misfire_t *self, const sd_misfire_firing_t *firing);
/// Counts a judged firing for rates and the lamp, whoever judged it: `firing`, `cylinder` and `verdict` of *verdict. One that was
/// not judged counts for nothing.
void sd_misfire_count(sd_misfire_t *self, const sd_misfire_verdict_t *verdict);
/// Both.
sd_misfire_verdict_t sd_misfire_judge(sd_misfire_t *self, const sd_misfire_firing_t *firing);
/// As in the report. rejected: firings not judged.
sd_status_t sd_misfire_status(const sd_misfire_t *self);
void sd_misfire_read(const sd_misfire_t *self, sd_misfire_report_t *report);

#ifdef __cplusplus
}
#endif

#endif
