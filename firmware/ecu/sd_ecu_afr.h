/* SPDX-License-Identifier: MIT */
/// sd_ecu_afr.h - the ecu's part for the exhaust side: when the AFR blocks and the trims run, and on what. For sd_ecu.c.
#ifndef SD_ECU_AFR_H
#define SD_ECU_AFR_H
#include "sd_ecu.h"

#ifdef __cplusplus
extern "C" {
#endif

/// From the working page, anew; what fails changes nothing. SD_OK without an exhaust: the block stays idle and says so.
sd_result_t sd_ecu_afr_init(sd_afr_t *afr, const sd_calibration_t *c);
/// What the exhaust side reads of the page, in place.
sd_afr_tables_t sd_ecu_afr_tables(const sd_calibration_t *c);
sd_result_t sd_ecu_delay_init(sd_afr_delay_t *delay, const sd_calibration_t *c);
/// End of a cycle, fuel_trim the trims whose gas arrives from now on: learns the delay, and starts or ends a probe. moves: speed or fuel does.
void sd_ecu_delay_cycle(sd_ecu_t *self, float speed_radps, bool moves);
sd_balance_config_t sd_ecu_balance_config(const sd_calibration_t *c);
sd_result_t sd_ecu_balance_init(sd_balance_t *balance, const sd_calibration_t *c);
/// The angle is lost, or off by a revolution.
void sd_ecu_afr_restart(sd_ecu_t *self);
/// A reading of the lambda sensor, air to fuel over stoichiometric.
void sd_ecu_afr_sample(sd_ecu_t *self, float lambda);
void sd_ecu_afr_tooth(sd_ecu_t *self, const sd_tooth_t *tooth);
/// End of a cycle, its speed and firings known: learns the delay and notes what sd_ecu_afr_work does in the teeth that follow.
void sd_ecu_afr_cycle(sd_ecu_t *self);
/// A piece of the last cycle's work, once a tooth: fills the signals, moves the trims, then sets the next operating point, each
/// piece about as much as a step. Returns true once a cycle: with the piece after which its signals are complete.
bool sd_ecu_afr_work(sd_ecu_t *self);

#ifdef __cplusplus
}
#endif

#endif
