/* SPDX-License-Identifier: MIT */
/// sd_stage_trims.h - the fuel trims in the ecu: what cylinders deviate by, from mixture or from firings, and the trims that go out.
#ifndef SD_STAGE_TRIMS_H
#define SD_STAGE_TRIMS_H
#include "sd_balance.h"
#include "sd_calibration.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Firings read since the end of a cycle, by firing order.
typedef struct sd_cycle_firings {
    float   torque_nm[SD_CYLINDERS_MAX], sd_nm[SD_CYLINDERS_MAX]; ///< As last read.
    uint8_t count;    ///< How many were read.
    uint8_t health;   ///< sd_health_t of the worst of them.
    uint8_t misfired; ///< 1: one of them was judged a misfire.
} sd_cycle_firings_t;

/// Owned by the stage.
typedef struct sd_stage_trims {
    sd_balance_t balance;
    sd_cycle_firings_t running, ended;      ///< Of the cycle under way and of the last one.
    float trim[SD_BALANCE_CYLINDERS_MAX];   ///< As commanded: the balance's and a probe's, by firing order.
} sd_stage_trims_t;

/// What the trims are to be made from.
typedef enum sd_trims_wish {
    SD_TRIMS_OFF,    ///< The controller forbids trims, or no source is chosen: they are 0.
    SD_TRIMS_LEARN,  ///< They follow the source.
    SD_TRIMS_FREEZE, ///< It is not known what the controller wants: they stay as they are.
} sd_trims_wish_t;

/// What cylinders deviate by from their mean, over the mean, by firing order.
typedef struct sd_deviations {
    float   value[SD_CYLINDERS_MAX], sd[SD_CYLINDERS_MAX]; ///< Deviation of each cylinder from the mean, a share of it; its deviation.
    float   follow; ///< Share of a change that the estimate takes up in a cycle, (0, 1].
    uint8_t told;   ///< 1: the estimate knows of the trims as they are now; 0: it follows them.
    uint8_t health; ///< sd_health_t.
} sd_deviations_t;

/// SD_OK, or SD_ERR_CONFIG with the state untouched. Trims are 0.
sd_result_t sd_stage_trims_init(sd_stage_trims_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// Other parameters from the next cycle on; as sd_balance_configure.
sd_result_t sd_stage_trims_configure(sd_stage_trims_t *self, const sd_calibration_t *page, const sd_parameters_t *p);
/// Another source of deviations: everything is forgotten, and trims go back to 0.
void sd_stage_trims_restart(sd_stage_trims_t *self);
/// A firing was read and judged.
void sd_stage_trims_firing(sd_stage_trims_t *self, const sd_firing_t *firing, uint8_t health, bool misfired);
/// The cycle has ended: its firings are kept for the deviations, and new ones are counted.
void sd_stage_trims_end_cycle(sd_stage_trims_t *self);
/// Deviations by the firings of the cycle that ended.
void sd_stage_trims_by_torque(const sd_stage_trims_t *self, uint32_t cylinders, sd_deviations_t *out);
/// Begins to move the trims by the cycle that ended; transient: speed or fuel moves, or a probe runs.
void sd_stage_trims_begin(sd_stage_trims_t *self, sd_trims_wish_t wish, const sd_deviations_t *deviations, bool transient);
/// The next piece of that. True while more is left.
bool sd_stage_trims_work(sd_stage_trims_t *self);
/// Makes trim[] of the balance's trims and a probe's (by firing order), both together within +-limit.
void sd_stage_trims_command(sd_stage_trims_t *self, const float *probe, float limit);

#ifdef __cplusplus
}
#endif
#endif
