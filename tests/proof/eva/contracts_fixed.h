/* SPDX-License-Identifier: MIT */
/// contracts_fixed.h - the ecu of fixed point (SD_ECU_FIXED), and what its kernels may do to their states, for Frama-C: each has a driver
/// of its own, so that here a state and what comes of a call may be anything. Where an index comes of it, its range stands here, and the
/// kernel's driver asserts it: crank.c, wheel_q31.c.
#ifndef SD_PROOF_CONTRACTS_FIXED_H
#define SD_PROOF_CONTRACTS_FIXED_H
#define SD_ECU_FIXED 1
#include "any.h"
#include "sd_ecu.h"
#include "sd_ecu_parts.h"
#include "sd_fixed_parts.h"

/* ---- decoder: of its ranges those that what is said of an edge takes */

/*@ predicate followed(sd_crank_clock_t *c) = -2147483647 <= c->change; */
/*@ predicate in_range(sd_crank_t *c) =
        c->now <= 1 && c->clocks[0].leader < SD_CRANK_CLOCKS && c->clocks[1].leader < SD_CRANK_CLOCKS &&
        followed(&c->clocks[0].clock[0]) && followed(&c->clocks[0].clock[1]) && followed(&c->clocks[0].clock[2]) &&
        followed(&c->clocks[1].clock[0]) && followed(&c->clocks[1].clock[1]) && followed(&c->clocks[1].clock[2]); */

/*@ assigns *self, *tooth \from *self, tick;
    ensures state: in_range(self) && \initialized(tooth) && tooth->cycle_position < 1024; */
void sd_crank_edge(sd_crank_t *self, uint32_t tick, sd_tooth_t *tooth);
/*@ assigns *self \from *self, tick;
    ensures state: in_range(self); */
void sd_crank_cam_edge(sd_crank_t *self, uint32_t tick);
/*@ assigns *self, \result \from *self, tick;
    ensures state: in_range(self);
    ensures flag: 0 <= \result <= 1; */
bool sd_crank_poll(sd_crank_t *self, uint32_t tick);
/*@ assigns *self \from *self;
    ensures state: in_range(self); */
void sd_crank_lose_sync(sd_crank_t *self);
/*@ assigns *self, \result \from *self, stall_ticks;
    ensures state: in_range(self); */
sd_result_t sd_crank_set_stall(sd_crank_t *self, uint32_t stall_ticks);
/*@ assigns *self, \result \from *config; */
sd_result_t sd_crank_init(sd_crank_t *self, const sd_crank_config_t *config);

/* ---- torque */

/*@ assigns *self \from *self, *tables, cycle_position, advance, period_ticks, trusted; */
void sd_fourier_advance_q31(sd_fourier_q31_t *self, const sd_fourier_tables_t *tables, uint32_t cycle_position, uint32_t advance,
                            uint32_t period_ticks, uint8_t trusted);
/*@ assigns *self \from *self; */
void sd_fourier_shift_revolution_q31(sd_fourier_q31_t *self);
/*@ assigns *self \from *self; */
void sd_fourier_restart_q31(sd_fourier_q31_t *self);
/*@ assigns *self, \result \from *config, *tables; */
sd_result_t sd_fourier_init_q31(sd_fourier_q31_t *self, const sd_fourier_config_t *config, const sd_fourier_tables_t *tables);
/*@ assigns \result \from *self; */
sd_status_t sd_fourier_health_q31(const sd_fourier_q31_t *self);
/*@ assigns *estimate \from *self;
    ensures said: \initialized(estimate); */
void sd_fourier_read_q31(const sd_fourier_q31_t *self, sd_fourier_estimate_t *estimate);

/* ---- misfires */

/*@ assigns *self, \result \from *self, *tables, *tooth, work;
    ensures firing: \result <= 15; */
uint32_t sd_wheel_tooth_q31(sd_wheel_q31_t *self, const sd_wheel_tables_t *tables, const sd_wheel_tooth_t *tooth, sd_q31_t work);
/*@ requires cylinders: tables->cylinders <= SD_CYLINDERS_MAX;
    assigns *self, *verdict \from *self, *tables, firing, inhibit;
    ensures firing: \initialized(verdict) && verdict->firing < SD_CYLINDERS_MAX; */
void sd_wheel_judge_q31(sd_wheel_q31_t *self, const sd_wheel_tables_t *tables, uint32_t firing, uint32_t inhibit,
                        sd_wheel_verdict_q31_t *verdict);
/*@ assigns *self, \result \from *config, *tables; */
sd_result_t sd_wheel_init_q31(sd_wheel_q31_t *self, const sd_wheel_config_q31_t *config, const sd_wheel_tables_t *tables);
/*@ assigns *self \from *self; */
void sd_wheel_restart_q31(sd_wheel_q31_t *self);

/* ---- mixture */

/*@ assigns *self, *now \from *self, psi[0 .. SD_EXHAUST_PSI], cycle_position;
    ensures said: \initialized(now); */
void sd_exhaust_step_q31(sd_exhaust_q31_t *self, const sd_q31_t *psi, uint32_t cycle_position, sd_exhaust_now_q31_t *now);
/*@ assigns *self \from *self, pressure; */
void sd_exhaust_measured_q31(sd_exhaust_q31_t *self, sd_q31_t pressure);
/*@ assigns *self \from *self, *now, cycle_position, measured, sine_q31[0 .. 239]; */
void sd_afr_chain_step_q31(sd_afr_chain_q31_t *self, const int32_t *sine_q31, const sd_exhaust_now_q31_t *now, uint32_t cycle_position,
                           sd_q31_t measured);
/*@ assigns *self \from *self, step_s, charge, sine_q31[0 .. 239]; */
void sd_afr_chain_set_q31(sd_afr_chain_q31_t *self, const int32_t *sine_q31, float step_s, const sd_uego_gains_t *gains, sd_q31_t charge);
/*@ assigns *self \from *self; */
void sd_afr_chain_restart_q31(sd_afr_chain_q31_t *self);
/*@ assigns \result \from *self; */
sd_scaled_t sd_afr_chain_mean_q31(const sd_afr_chain_q31_t *self);
/*@ assigns \result \from *self; */
sd_status_t sd_afr_chain_status_q31(const sd_afr_chain_q31_t *self);
/*@ assigns *out \from *self;
    ensures said: \initialized(out); */
void sd_afr_chain_read_q31(const sd_afr_chain_q31_t *self, sd_afr_estimate_t *out);
/*@ assigns \result \from *config; */
sd_result_t sd_afr_chain_check_q31(const sd_afr_chain_config_t *config);
/*@ assigns *self, \result \from *config; */
sd_result_t sd_afr_chain_init_q31(sd_afr_chain_q31_t *self, const sd_afr_chain_config_t *config);
/*@ assigns self->at, self->part[0 .. 2], self->node[0 .. 2], self->piece, self->mean_lambda, \result \from *self, *at, mean_lambda;
    ensures flag: 0 <= \result <= 1; */
bool sd_afr_point_begin_q31(sd_afr_point_q31_t *self, const sd_afr_conditions_t *at, sd_scaled_t mean_lambda);
/*@ assigns *self, \result \from *self, *grid, late_s; */
sd_afr_progress_t sd_afr_point_work_q31(sd_afr_point_q31_t *self, const sd_afr_grid_t *grid, float late_s);
/*@ assigns *gains \from *self, *grid;
    ensures said: \initialized(gains); */
void sd_afr_point_gains_q31(const sd_afr_point_q31_t *self, const sd_afr_grid_t *grid, sd_uego_gains_t *gains);
/*@ assigns \result \from *config, *grid; */
sd_result_t sd_afr_point_check_q31(const sd_afr_point_config_t *config, const sd_afr_grid_t *grid);
/*@ assigns *self, \result \from *config, *grid; */
sd_result_t sd_afr_point_init_q31(sd_afr_point_q31_t *self, const sd_afr_point_config_t *config, const sd_afr_grid_t *grid);

/* ---- air path */

/*@ assigns *self \from \nothing;
    ensures begun: \initialized(self); */
void sd_airpath_start_q31(sd_airpath_bank_q31_t *self);
/*@ assigns *self, *out \from *self;
    ensures said: \initialized(out); */
void sd_airpath_wait_q31(sd_airpath_bank_q31_t *self, sd_airpath_out_q31_t *out);
/*@ assigns *self, *out \from *self, *tables, *config;
    ensures said: \initialized(out); */
void sd_airpath_hold_q31(sd_airpath_bank_q31_t *self, const sd_airpath_tables_q31_t *tables, const sd_airpath_config_q31_t *config,
                         sd_airpath_out_q31_t *out);
/*@ assigns *self, *out \from *self, *tables, *config, *in;
    ensures said: \initialized(out); */
void sd_airpath_step_q31(sd_airpath_bank_q31_t *self, const sd_airpath_tables_q31_t *tables, const sd_airpath_config_q31_t *config,
                         const sd_airpath_in_q31_t *in, sd_airpath_out_q31_t *out);
/*@ assigns \result \from *tables;
    ensures flag: 0 <= \result <= 1; */
bool sd_airpath_tables_ok_q31(const sd_airpath_tables_q31_t *tables);
/*@ assigns \result \from *thresholds;
    ensures flag: 0 <= \result <= 1; */
bool sd_cusum_thresholds_ok_q31(const sd_cusum_thresholds_q31_t *thresholds);

/* ---- pieces of a cycle's work: fixed_cycle.c has them */

/*@ assigns self->work, self->ended, self->mixture.point, self->mixture.chain, self->mixture.cycles, self->mixture.cycle_samples,
            self->mixture.slow, self->mixture.placed, self->trims, self->trims_wanted, self->say, self->last_speed_radps,
            self->last_fuel_mg, self->misfired \from *self, *page; */
void sd_ecu_do_piece(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port);

/*@ assigns self->work, self->ended, self->mixture.point, self->mixture.chain, self->mixture.cycles, self->mixture.cycle_samples,
            self->mixture.slow, self->mixture.placed, self->trims, self->trims_wanted, self->say, self->last_speed_radps,
            self->last_fuel_mg, self->misfired \from *self, *page, *cycle; */
void sd_fixed_begin_work(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_cycle_t *cycle);

#endif
