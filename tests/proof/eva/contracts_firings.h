/* SPDX-License-Identifier: MIT */
/// contracts_firings.h - what the filters and what is learned may do to their states, for Frama-C: each has a driver of its own
/// (f32_kalman_*.c, f32_pattern.c, f32_fired.c), so that here a state and what comes of a call may be any bits.
#ifndef SD_PROOF_CONTRACTS_FIRINGS_H
#define SD_PROOF_CONTRACTS_FIRINGS_H
#include "any.h"
#include "sd_firings.h"

/*@ assigns self->charge, self->shape, self->free, self->free_runs, self->filter[0 .. 1], firing[0 .. 1], \result
        \from *self, *tables, *tooth;
    ensures index: \initialized(&firing[0]) && \initialized(&firing[1]) && firing[0].index < SD_KALMAN_FIRINGS_MAX &&
                   firing[1].index < SD_KALMAN_FIRINGS_MAX; */
uint32_t sd_kalman_step(sd_kalman_t *self, const sd_kalman_tables_t *tables, const sd_kalman_tooth_t *tooth, sd_firing_t *firing);
/*@ assigns \result \from *self, *tables, which, cycle_position; */
float sd_kalman_torque(const sd_kalman_t *self, const sd_kalman_tables_t *tables, uint32_t which, uint32_t cycle_position);
/*@ assigns self->filter[0 .. 1] \from \nothing; */
void sd_kalman_restart(sd_kalman_t *self);
/*@ assigns *self, \result \from *tables, *choice, filters; */
sd_result_t sd_kalman_init(sd_kalman_t *self, const sd_kalman_tables_t *tables, const sd_kalman_choice_t *choice, uint8_t filters);
/*@ assigns \result \from *tables; ensures flag: 0 <= \result <= 1; */
bool sd_kalman_tables_ok(const sd_kalman_tables_t *tables);
/*@ assigns \result \from *choice; ensures flag: 0 <= \result <= 1; */
bool sd_kalman_choice_ok(const sd_kalman_choice_t *choice);
/*@ assigns *self, \result \from *self, *smooth, *rough; ensures flag: 0 <= \result <= 1; */
bool sd_road_step(sd_road_t *self, const sd_firing_t *smooth, const sd_firing_t *rough);
/*@ assigns *self \from \nothing; */
void sd_road_restart(sd_road_t *self);
/*@ assigns *self, \result \from *self, *tables, *tooth; ensures flag: 0 <= \result <= 1; */
bool sd_pattern_step(sd_pattern_t *self, const sd_kalman_tables_t *tables, const sd_kalman_tooth_t *tooth);
/*@ assigns *self, \result \from *self, *tables; ensures flag: 0 <= \result <= 1; */
bool sd_pattern_rest(sd_pattern_t *self, const sd_kalman_tables_t *tables);
/*@ assigns *self \from *self; */
void sd_pattern_pause(sd_pattern_t *self);
/*@ assigns *self \from *tables; */
void sd_pattern_init(sd_pattern_t *self, const sd_kalman_tables_t *tables);
/*@ assigns *self, \result \from *self, *tables, *sums; */
sd_result_t sd_pattern_resume(sd_pattern_t *self, const sd_kalman_tables_t *tables, const sd_pattern_sums_t *sums);
/*@ assigns *sums \from *self, *tables; */
void sd_pattern_keep(const sd_pattern_t *self, const sd_kalman_tables_t *tables, sd_pattern_sums_t *sums);
/*@ assigns self->sums, \result \from *self, *tables, *firing, charge_bar, speed_radps; ensures flag: 0 <= \result <= 1; */
bool sd_pattern_take_zero(sd_pattern_t *self, const sd_kalman_tables_t *tables, const sd_firing_t *firing, float charge_bar,
                          float speed_radps);
/*@ assigns zero_nm_per_bar[0 .. SD_KALMAN_FIRINGS_MAX - 1] \from *self, *tables; */
void sd_pattern_zeros(const sd_pattern_t *self, const sd_kalman_tables_t *tables, float *zero_nm_per_bar);
/*@ assigns *self, kalman->free, kalman->free_runs \from *self, *tables, *kalman, cycle_position, fuel_mg, corrected;
    ensures used: self->used <= 1; */
void sd_fired_step(sd_fired_t *self, const sd_kalman_tables_t *tables, sd_kalman_t *kalman, uint32_t cycle_position, float fuel_mg,
                   bool corrected);
/*@ assigns *self, kalman->free_runs \from *self;
    ensures used: self->used <= 1; */
void sd_fired_rest(sd_fired_t *self, sd_kalman_t *kalman);
/*@ assigns *self \from *self;
    ensures used: self->used <= 1; */
void sd_fired_hand_over(sd_fired_t *self);
/*@ assigns *self, *sums \from *self, *sums, *tables;
    ensures used: self->used <= 1; */
void sd_fired_work(sd_fired_t *self, const sd_kalman_tables_t *tables, sd_fired_sums_t *sums);
/*@ assigns *self, \result \from *self; ensures flag: 0 <= \result <= 1;
    ensures used: self->used <= 1; */
bool sd_fired_take_over(sd_fired_t *self);
/*@ assigns *self \from \nothing;
    ensures used: self->used <= 1; */
void sd_fired_init(sd_fired_t *self);
/*@ assigns *self \from *self, *tables, *sums;
    ensures used: self->used <= 1; */
void sd_fired_resume(sd_fired_t *self, const sd_kalman_tables_t *tables, const sd_fired_sums_t *sums);

#endif
