/* Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. */
/* SPDX-License-Identifier: MIT */
#ifndef SD_LCM_ROWS_H
#define SD_LCM_ROWS_H
#include "sixdeg_edge_t.h"
#include "sixdeg_cycle_t.h"
#include "sixdeg_firing_t.h"
#include "sixdeg_work_t.h"
#include "sixdeg_airpath_t.h"
#include "sixdeg_task_t.h"
#include "sixdeg_driveline_t.h"
#include "sixdeg_outputs_t.h"
#include "sd_row.h"

#ifdef __cplusplus
extern "C" {
#endif

static inline void sd_lcm_edge_from_row(sixdeg_edge_t *m, const sd_row_t *row) {
    m->tick = (int32_t)row->tick;
    m->crank_health = (int8_t)row->health[SD_OWNER_CRANK];
    m->crank_why = (int16_t)row->why[SD_OWNER_CRANK];
    m->torque_health = (int8_t)row->health[SD_OWNER_TORQUE];
    m->torque_why = (int16_t)row->why[SD_OWNER_TORQUE];
    m->firing_health = (int8_t)row->health[SD_OWNER_FIRING];
    m->firing_why = (int16_t)row->why[SD_OWNER_FIRING];
    m->crank_edge_class = row->value[0];
    m->crank_tooth = row->value[1];
    m->crank_angle = row->value[2];
    m->crank_phase_known = row->value[3];
    m->crank_speed = row->value[4];
    m->crank_acceleration = row->value[5];
    m->torque_mass = row->value[6];
    m->torque_innovation = row->value[7];
    m->firing_waveform = row->value[25];
}

static inline void sd_lcm_edge_to_row(sd_row_t *row, const sixdeg_edge_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_EDGE);
    sd_row_status(row, SD_OWNER_CRANK, (uint8_t)m->crank_health, (uint16_t)m->crank_why);
    sd_row_status(row, SD_OWNER_TORQUE, (uint8_t)m->torque_health, (uint16_t)m->torque_why);
    sd_row_status(row, SD_OWNER_FIRING, (uint8_t)m->firing_health, (uint16_t)m->firing_why);
    sd_row_put(row, 0, m->crank_edge_class);
    sd_row_put(row, 1, m->crank_tooth);
    sd_row_put(row, 2, m->crank_angle);
    sd_row_put(row, 3, m->crank_phase_known);
    sd_row_put(row, 4, m->crank_speed);
    sd_row_put(row, 5, m->crank_acceleration);
    sd_row_put(row, 6, m->torque_mass);
    sd_row_put(row, 7, m->torque_innovation);
    sd_row_put(row, 25, m->firing_waveform);
}

static inline void sd_lcm_cycle_from_row(sixdeg_cycle_t *m, const sd_row_t *row) {
    m->tick = (int32_t)row->tick;
    m->crank_health = (int8_t)row->health[SD_OWNER_CRANK];
    m->crank_why = (int16_t)row->why[SD_OWNER_CRANK];
    m->cylinder_health = (int8_t)row->health[SD_OWNER_CYLINDER];
    m->cylinder_why = (int16_t)row->why[SD_OWNER_CYLINDER];
    m->afr_health = (int8_t)row->health[SD_OWNER_AFR];
    m->afr_why = (int16_t)row->why[SD_OWNER_AFR];
    m->balance_health = (int8_t)row->health[SD_OWNER_BALANCE];
    m->balance_why = (int16_t)row->why[SD_OWNER_BALANCE];
    m->misfire_health = (int8_t)row->health[SD_OWNER_MISFIRE];
    m->misfire_why = (int16_t)row->why[SD_OWNER_MISFIRE];
    m->cycle_speed = row->value[8];
    m->cycle_cylinder_torque_1 = row->value[9];
    m->cycle_cylinder_torque_2 = row->value[10];
    m->cycle_cylinder_torque_3 = row->value[11];
    m->cycle_cylinder_torque_4 = row->value[12];
    m->cycle_cylinder_torque_5 = row->value[13];
    m->cycle_cylinder_torque_6 = row->value[14];
    m->cycle_cylinder_torque_7 = row->value[15];
    m->cycle_cylinder_torque_8 = row->value[16];
    m->cycle_cylinder_sd_1 = row->value[17];
    m->cycle_cylinder_sd_2 = row->value[18];
    m->cycle_cylinder_sd_3 = row->value[19];
    m->cycle_cylinder_sd_4 = row->value[20];
    m->cycle_cylinder_sd_5 = row->value[21];
    m->cycle_cylinder_sd_6 = row->value[22];
    m->cycle_cylinder_sd_7 = row->value[23];
    m->cycle_cylinder_sd_8 = row->value[24];
    m->wheel_pattern_sd = row->value[26];
    m->wheel_learned_cycles = row->value[27];
    m->afr_cylinder_burned_1 = row->value[39];
    m->afr_cylinder_burned_2 = row->value[40];
    m->afr_cylinder_burned_3 = row->value[41];
    m->afr_cylinder_burned_4 = row->value[42];
    m->afr_cylinder_burned_5 = row->value[43];
    m->afr_cylinder_burned_6 = row->value[44];
    m->afr_cylinder_burned_7 = row->value[45];
    m->afr_cylinder_burned_8 = row->value[46];
    m->afr_cylinder_sd_1 = row->value[47];
    m->afr_cylinder_sd_2 = row->value[48];
    m->afr_cylinder_sd_3 = row->value[49];
    m->afr_cylinder_sd_4 = row->value[50];
    m->afr_cylinder_sd_5 = row->value[51];
    m->afr_cylinder_sd_6 = row->value[52];
    m->afr_cylinder_sd_7 = row->value[53];
    m->afr_cylinder_sd_8 = row->value[54];
    m->afr_slow = row->value[55];
    m->afr_late = row->value[56];
    m->afr_late_sd = row->value[57];
    m->afr_lag = row->value[58];
    m->afr_probing = row->value[59];
    m->balance_trim_1 = row->value[60];
    m->balance_trim_2 = row->value[61];
    m->balance_trim_3 = row->value[62];
    m->balance_trim_4 = row->value[63];
    m->balance_trim_5 = row->value[64];
    m->balance_trim_6 = row->value[65];
    m->balance_trim_7 = row->value[66];
    m->balance_trim_8 = row->value[67];
    m->misfire_rate_200_1 = row->value[77];
    m->misfire_rate_200_2 = row->value[78];
    m->misfire_rate_200_3 = row->value[79];
    m->misfire_rate_200_4 = row->value[80];
    m->misfire_rate_200_5 = row->value[81];
    m->misfire_rate_200_6 = row->value[82];
    m->misfire_rate_200_7 = row->value[83];
    m->misfire_rate_200_8 = row->value[84];
    m->misfire_rate_1000_1 = row->value[85];
    m->misfire_rate_1000_2 = row->value[86];
    m->misfire_rate_1000_3 = row->value[87];
    m->misfire_rate_1000_4 = row->value[88];
    m->misfire_rate_1000_5 = row->value[89];
    m->misfire_rate_1000_6 = row->value[90];
    m->misfire_rate_1000_7 = row->value[91];
    m->misfire_rate_1000_8 = row->value[92];
    m->misfire_continuous = row->value[93];
    m->misfire_suspects = row->value[94];
    m->misfire_lamp = row->value[95];
    m->misfire_count = row->value[96];
    m->misfire_partial_burns = row->value[97];
}

static inline void sd_lcm_cycle_to_row(sd_row_t *row, const sixdeg_cycle_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_CYCLE);
    sd_row_status(row, SD_OWNER_CRANK, (uint8_t)m->crank_health, (uint16_t)m->crank_why);
    sd_row_status(row, SD_OWNER_CYLINDER, (uint8_t)m->cylinder_health, (uint16_t)m->cylinder_why);
    sd_row_status(row, SD_OWNER_AFR, (uint8_t)m->afr_health, (uint16_t)m->afr_why);
    sd_row_status(row, SD_OWNER_BALANCE, (uint8_t)m->balance_health, (uint16_t)m->balance_why);
    sd_row_status(row, SD_OWNER_MISFIRE, (uint8_t)m->misfire_health, (uint16_t)m->misfire_why);
    sd_row_put(row, 8, m->cycle_speed);
    sd_row_put(row, 9, m->cycle_cylinder_torque_1);
    sd_row_put(row, 10, m->cycle_cylinder_torque_2);
    sd_row_put(row, 11, m->cycle_cylinder_torque_3);
    sd_row_put(row, 12, m->cycle_cylinder_torque_4);
    sd_row_put(row, 13, m->cycle_cylinder_torque_5);
    sd_row_put(row, 14, m->cycle_cylinder_torque_6);
    sd_row_put(row, 15, m->cycle_cylinder_torque_7);
    sd_row_put(row, 16, m->cycle_cylinder_torque_8);
    sd_row_put(row, 17, m->cycle_cylinder_sd_1);
    sd_row_put(row, 18, m->cycle_cylinder_sd_2);
    sd_row_put(row, 19, m->cycle_cylinder_sd_3);
    sd_row_put(row, 20, m->cycle_cylinder_sd_4);
    sd_row_put(row, 21, m->cycle_cylinder_sd_5);
    sd_row_put(row, 22, m->cycle_cylinder_sd_6);
    sd_row_put(row, 23, m->cycle_cylinder_sd_7);
    sd_row_put(row, 24, m->cycle_cylinder_sd_8);
    sd_row_put(row, 26, m->wheel_pattern_sd);
    sd_row_put(row, 27, m->wheel_learned_cycles);
    sd_row_put(row, 39, m->afr_cylinder_burned_1);
    sd_row_put(row, 40, m->afr_cylinder_burned_2);
    sd_row_put(row, 41, m->afr_cylinder_burned_3);
    sd_row_put(row, 42, m->afr_cylinder_burned_4);
    sd_row_put(row, 43, m->afr_cylinder_burned_5);
    sd_row_put(row, 44, m->afr_cylinder_burned_6);
    sd_row_put(row, 45, m->afr_cylinder_burned_7);
    sd_row_put(row, 46, m->afr_cylinder_burned_8);
    sd_row_put(row, 47, m->afr_cylinder_sd_1);
    sd_row_put(row, 48, m->afr_cylinder_sd_2);
    sd_row_put(row, 49, m->afr_cylinder_sd_3);
    sd_row_put(row, 50, m->afr_cylinder_sd_4);
    sd_row_put(row, 51, m->afr_cylinder_sd_5);
    sd_row_put(row, 52, m->afr_cylinder_sd_6);
    sd_row_put(row, 53, m->afr_cylinder_sd_7);
    sd_row_put(row, 54, m->afr_cylinder_sd_8);
    sd_row_put(row, 55, m->afr_slow);
    sd_row_put(row, 56, m->afr_late);
    sd_row_put(row, 57, m->afr_late_sd);
    sd_row_put(row, 58, m->afr_lag);
    sd_row_put(row, 59, m->afr_probing);
    sd_row_put(row, 60, m->balance_trim_1);
    sd_row_put(row, 61, m->balance_trim_2);
    sd_row_put(row, 62, m->balance_trim_3);
    sd_row_put(row, 63, m->balance_trim_4);
    sd_row_put(row, 64, m->balance_trim_5);
    sd_row_put(row, 65, m->balance_trim_6);
    sd_row_put(row, 66, m->balance_trim_7);
    sd_row_put(row, 67, m->balance_trim_8);
    sd_row_put(row, 77, m->misfire_rate_200_1);
    sd_row_put(row, 78, m->misfire_rate_200_2);
    sd_row_put(row, 79, m->misfire_rate_200_3);
    sd_row_put(row, 80, m->misfire_rate_200_4);
    sd_row_put(row, 81, m->misfire_rate_200_5);
    sd_row_put(row, 82, m->misfire_rate_200_6);
    sd_row_put(row, 83, m->misfire_rate_200_7);
    sd_row_put(row, 84, m->misfire_rate_200_8);
    sd_row_put(row, 85, m->misfire_rate_1000_1);
    sd_row_put(row, 86, m->misfire_rate_1000_2);
    sd_row_put(row, 87, m->misfire_rate_1000_3);
    sd_row_put(row, 88, m->misfire_rate_1000_4);
    sd_row_put(row, 89, m->misfire_rate_1000_5);
    sd_row_put(row, 90, m->misfire_rate_1000_6);
    sd_row_put(row, 91, m->misfire_rate_1000_7);
    sd_row_put(row, 92, m->misfire_rate_1000_8);
    sd_row_put(row, 93, m->misfire_continuous);
    sd_row_put(row, 94, m->misfire_suspects);
    sd_row_put(row, 95, m->misfire_lamp);
    sd_row_put(row, 96, m->misfire_count);
    sd_row_put(row, 97, m->misfire_partial_burns);
}

static inline void sd_lcm_firing_from_row(sixdeg_firing_t *m, const sd_row_t *row) {
    m->tick = (int32_t)row->tick;
    m->firing_health = (int8_t)row->health[SD_OWNER_FIRING];
    m->firing_why = (int16_t)row->why[SD_OWNER_FIRING];
    m->misfire_health = (int8_t)row->health[SD_OWNER_MISFIRE];
    m->misfire_why = (int16_t)row->why[SD_OWNER_MISFIRE];
    m->firing_cylinder = row->value[28];
    m->firing_torque = row->value[29];
    m->firing_sd = row->value[30];
    m->firing_mean = row->value[31];
    m->firing_mean_sd = row->value[32];
    m->firing_rough = row->value[33];
    m->misfire_index = row->value[68];
    m->misfire_limit = row->value[69];
    m->misfire_verdict = row->value[70];
    m->misfire_inhibit = row->value[71];
    m->misfire_firing = row->value[72];
    m->misfire_cylinder = row->value[73];
    m->misfire_monitor = row->value[74];
    m->misfire_acceleration = row->value[75];
    m->misfire_residual = row->value[76];
}

static inline void sd_lcm_firing_to_row(sd_row_t *row, const sixdeg_firing_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_FIRING);
    sd_row_status(row, SD_OWNER_FIRING, (uint8_t)m->firing_health, (uint16_t)m->firing_why);
    sd_row_status(row, SD_OWNER_MISFIRE, (uint8_t)m->misfire_health, (uint16_t)m->misfire_why);
    sd_row_put(row, 28, m->firing_cylinder);
    sd_row_put(row, 29, m->firing_torque);
    sd_row_put(row, 30, m->firing_sd);
    sd_row_put(row, 31, m->firing_mean);
    sd_row_put(row, 32, m->firing_mean_sd);
    sd_row_put(row, 33, m->firing_rough);
    sd_row_put(row, 68, m->misfire_index);
    sd_row_put(row, 69, m->misfire_limit);
    sd_row_put(row, 70, m->misfire_verdict);
    sd_row_put(row, 71, m->misfire_inhibit);
    sd_row_put(row, 72, m->misfire_firing);
    sd_row_put(row, 73, m->misfire_cylinder);
    sd_row_put(row, 74, m->misfire_monitor);
    sd_row_put(row, 75, m->misfire_acceleration);
    sd_row_put(row, 76, m->misfire_residual);
}

static inline void sd_lcm_work_from_row(sixdeg_work_t *m, const sd_row_t *row) {
    m->tick = (int32_t)row->tick;
    m->work_health = (int8_t)row->health[SD_OWNER_WORK];
    m->work_why = (int16_t)row->why[SD_OWNER_WORK];
    m->work_cycle = row->value[34];
    m->work_sd = row->value[35];
    m->work_change = row->value[36];
    m->work_firing = row->value[37];
    m->work_cylinder = row->value[38];
}

static inline void sd_lcm_work_to_row(sd_row_t *row, const sixdeg_work_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_WORK);
    sd_row_status(row, SD_OWNER_WORK, (uint8_t)m->work_health, (uint16_t)m->work_why);
    sd_row_put(row, 34, m->work_cycle);
    sd_row_put(row, 35, m->work_sd);
    sd_row_put(row, 36, m->work_change);
    sd_row_put(row, 37, m->work_firing);
    sd_row_put(row, 38, m->work_cylinder);
}

static inline void sd_lcm_airpath_from_row(sixdeg_airpath_t *m, const sd_row_t *row) {
    m->tick = (int32_t)row->tick;
    m->airpath_health = (int8_t)row->health[SD_OWNER_AIRPATH];
    m->airpath_why = (int16_t)row->why[SD_OWNER_AIRPATH];
    m->airpath_residual_1 = row->value[98];
    m->airpath_residual_2 = row->value[99];
    m->airpath_decision_1 = row->value[100];
    m->airpath_decision_2 = row->value[101];
    m->airpath_decision_3 = row->value[102];
    m->airpath_decision_4 = row->value[103];
    m->airpath_fault = row->value[104];
    m->airpath_since = row->value[105];
    m->airpath_phase = row->value[106];
    m->airpath_offset_1 = row->value[107];
    m->airpath_offset_2 = row->value[108];
    m->airpath_tracking = row->value[109];
}

static inline void sd_lcm_airpath_to_row(sd_row_t *row, const sixdeg_airpath_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_AIRPATH);
    sd_row_status(row, SD_OWNER_AIRPATH, (uint8_t)m->airpath_health, (uint16_t)m->airpath_why);
    sd_row_put(row, 98, m->airpath_residual_1);
    sd_row_put(row, 99, m->airpath_residual_2);
    sd_row_put(row, 100, m->airpath_decision_1);
    sd_row_put(row, 101, m->airpath_decision_2);
    sd_row_put(row, 102, m->airpath_decision_3);
    sd_row_put(row, 103, m->airpath_decision_4);
    sd_row_put(row, 104, m->airpath_fault);
    sd_row_put(row, 105, m->airpath_since);
    sd_row_put(row, 106, m->airpath_phase);
    sd_row_put(row, 107, m->airpath_offset_1);
    sd_row_put(row, 108, m->airpath_offset_2);
    sd_row_put(row, 109, m->airpath_tracking);
}

static inline void sd_lcm_task_from_row(sixdeg_task_t *m, const sd_row_t *row) {
    m->tick = (int32_t)row->tick;
    m->inputs_health = (int8_t)row->health[SD_OWNER_INPUTS];
    m->inputs_why = (int16_t)row->why[SD_OWNER_INPUTS];
    m->inputs_stale_1 = row->value[110];
    m->inputs_stale_2 = row->value[111];
    m->inputs_missing_1 = row->value[112];
    m->inputs_missing_2 = row->value[113];
}

static inline void sd_lcm_task_to_row(sd_row_t *row, const sixdeg_task_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_TASK);
    sd_row_status(row, SD_OWNER_INPUTS, (uint8_t)m->inputs_health, (uint16_t)m->inputs_why);
    sd_row_put(row, 110, m->inputs_stale_1);
    sd_row_put(row, 111, m->inputs_stale_2);
    sd_row_put(row, 112, m->inputs_missing_1);
    sd_row_put(row, 113, m->inputs_missing_2);
}

static inline void sd_lcm_driveline_from_row(sixdeg_driveline_t *m, const sd_row_t *row) {
    m->tick = (int32_t)row->tick;
    m->driveline_health = (int8_t)row->health[SD_OWNER_DRIVELINE];
    m->driveline_why = (int16_t)row->why[SD_OWNER_DRIVELINE];
    m->driveline_reference_health = (int8_t)row->health[SD_OWNER_DRIVELINE_REFERENCE];
    m->driveline_reference_why = (int16_t)row->why[SD_OWNER_DRIVELINE_REFERENCE];
    m->driveline_location = row->value[114];
    m->driveline_torsion = row->value[115];
    m->driveline_winding = row->value[116];
    m->driveline_shaft = row->value[117];
    m->driveline_wheel_speed = row->value[118];
    m->driveline_bias = row->value[119];
    m->driveline_moving = row->value[120];
    m->driveline_damping_request = row->value[121];
    m->driveline_reference_location = row->value[122];
    m->driveline_reference_torsion = row->value[123];
    m->driveline_reference_residual_1 = row->value[124];
    m->driveline_reference_residual_2 = row->value[125];
    m->driveline_reference_residual_3 = row->value[126];
}

static inline void sd_lcm_driveline_to_row(sd_row_t *row, const sixdeg_driveline_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_DRIVELINE);
    sd_row_status(row, SD_OWNER_DRIVELINE, (uint8_t)m->driveline_health, (uint16_t)m->driveline_why);
    sd_row_status(row, SD_OWNER_DRIVELINE_REFERENCE, (uint8_t)m->driveline_reference_health, (uint16_t)m->driveline_reference_why);
    sd_row_put(row, 114, m->driveline_location);
    sd_row_put(row, 115, m->driveline_torsion);
    sd_row_put(row, 116, m->driveline_winding);
    sd_row_put(row, 117, m->driveline_shaft);
    sd_row_put(row, 118, m->driveline_wheel_speed);
    sd_row_put(row, 119, m->driveline_bias);
    sd_row_put(row, 120, m->driveline_moving);
    sd_row_put(row, 121, m->driveline_damping_request);
    sd_row_put(row, 122, m->driveline_reference_location);
    sd_row_put(row, 123, m->driveline_reference_torsion);
    sd_row_put(row, 124, m->driveline_reference_residual_1);
    sd_row_put(row, 125, m->driveline_reference_residual_2);
    sd_row_put(row, 126, m->driveline_reference_residual_3);
}

#define SD_LCM_ROWS 512 /* of a rate in one message; beyond it a message goes early */

/* What goes out with the next message. */
typedef struct sd_lcm_rows {
    sixdeg_edge_t edge[SD_LCM_ROWS];
    sixdeg_cycle_t cycle[SD_LCM_ROWS];
    sixdeg_firing_t firing[SD_LCM_ROWS];
    sixdeg_work_t work[SD_LCM_ROWS];
    sixdeg_airpath_t airpath[SD_LCM_ROWS];
    sixdeg_task_t task[SD_LCM_ROWS];
    sixdeg_driveline_t driveline[SD_LCM_ROWS];
    int32_t count[SD_RATE_COUNT];
    int32_t places; /* Rows in all. */
} sd_lcm_rows_t;

/* 1: the row has joined the others; 0: there is no room. */
static inline int sd_lcm_rows_add(sd_lcm_rows_t *self, const sd_row_t *row) {
    if ((row->rate >= SD_RATE_COUNT) || (self->count[row->rate] >= SD_LCM_ROWS)) { return 0; }
    const int32_t at = self->count[row->rate]++;
    if (row->rate == SD_RATE_EDGE) {
        sd_lcm_edge_from_row(&self->edge[at], row);
        self->edge[at].place = self->places;
    }
    if (row->rate == SD_RATE_CYCLE) {
        sd_lcm_cycle_from_row(&self->cycle[at], row);
        self->cycle[at].place = self->places;
    }
    if (row->rate == SD_RATE_FIRING) {
        sd_lcm_firing_from_row(&self->firing[at], row);
        self->firing[at].place = self->places;
    }
    if (row->rate == SD_RATE_WORK) {
        sd_lcm_work_from_row(&self->work[at], row);
        self->work[at].place = self->places;
    }
    if (row->rate == SD_RATE_AIRPATH) {
        sd_lcm_airpath_from_row(&self->airpath[at], row);
        self->airpath[at].place = self->places;
    }
    if (row->rate == SD_RATE_TASK) {
        sd_lcm_task_from_row(&self->task[at], row);
        self->task[at].place = self->places;
    }
    if (row->rate == SD_RATE_DRIVELINE) {
        sd_lcm_driveline_from_row(&self->driveline[at], row);
        self->driveline[at].place = self->places;
    }
    self->places++;
    return 1;
}

/* 1: of some rate there is no room for another row. */
static inline int sd_lcm_rows_full(const sd_lcm_rows_t *self) {
    for (uint32_t rate = 0; rate < SD_RATE_COUNT; ++rate) {
        if (self->count[rate] >= SD_LCM_ROWS) { return 1; }
    }
    return 0;
}

static inline void sd_lcm_rows_clear(sd_lcm_rows_t *self) {
    memset(self->count, 0, sizeof self->count);
    self->places = 0;
}

/* The message points into *self. */
static inline void sd_lcm_rows_to_message(sixdeg_outputs_t *m, sd_lcm_rows_t *self) {
    m->edges = self->count[SD_RATE_EDGE];
    m->edge = self->edge;
    m->cycles = self->count[SD_RATE_CYCLE];
    m->cycle = self->cycle;
    m->firings = self->count[SD_RATE_FIRING];
    m->firing = self->firing;
    m->works = self->count[SD_RATE_WORK];
    m->work = self->work;
    m->airpaths = self->count[SD_RATE_AIRPATH];
    m->airpath = self->airpath;
    m->tasks = self->count[SD_RATE_TASK];
    m->task = self->task;
    m->drivelines = self->count[SD_RATE_DRIVELINE];
    m->driveline = self->driveline;
}

/* 1: *row is the next one of the message by its place; taken[], zero to begin, counts those handed out of each rate. 0: that was all. */
static inline int sd_lcm_rows_next(sd_row_t *row, const sixdeg_outputs_t *m, int32_t taken[SD_RATE_COUNT]) {
    int32_t place = 0;
    uint32_t next = SD_RATE_COUNT;
    if ((taken[SD_RATE_EDGE] < m->edges) && ((next == SD_RATE_COUNT) || (m->edge[taken[SD_RATE_EDGE]].place < place))) {
        place = m->edge[taken[SD_RATE_EDGE]].place;
        next = SD_RATE_EDGE;
    }
    if ((taken[SD_RATE_CYCLE] < m->cycles) && ((next == SD_RATE_COUNT) || (m->cycle[taken[SD_RATE_CYCLE]].place < place))) {
        place = m->cycle[taken[SD_RATE_CYCLE]].place;
        next = SD_RATE_CYCLE;
    }
    if ((taken[SD_RATE_FIRING] < m->firings) && ((next == SD_RATE_COUNT) || (m->firing[taken[SD_RATE_FIRING]].place < place))) {
        place = m->firing[taken[SD_RATE_FIRING]].place;
        next = SD_RATE_FIRING;
    }
    if ((taken[SD_RATE_WORK] < m->works) && ((next == SD_RATE_COUNT) || (m->work[taken[SD_RATE_WORK]].place < place))) {
        place = m->work[taken[SD_RATE_WORK]].place;
        next = SD_RATE_WORK;
    }
    if ((taken[SD_RATE_AIRPATH] < m->airpaths) && ((next == SD_RATE_COUNT) || (m->airpath[taken[SD_RATE_AIRPATH]].place < place))) {
        place = m->airpath[taken[SD_RATE_AIRPATH]].place;
        next = SD_RATE_AIRPATH;
    }
    if ((taken[SD_RATE_TASK] < m->tasks) && ((next == SD_RATE_COUNT) || (m->task[taken[SD_RATE_TASK]].place < place))) {
        place = m->task[taken[SD_RATE_TASK]].place;
        next = SD_RATE_TASK;
    }
    if ((taken[SD_RATE_DRIVELINE] < m->drivelines) && ((next == SD_RATE_COUNT) || (m->driveline[taken[SD_RATE_DRIVELINE]].place < place))) {
        place = m->driveline[taken[SD_RATE_DRIVELINE]].place;
        next = SD_RATE_DRIVELINE;
    }
    if (next == SD_RATE_EDGE) { sd_lcm_edge_to_row(row, &m->edge[taken[SD_RATE_EDGE]]); }
    if (next == SD_RATE_CYCLE) { sd_lcm_cycle_to_row(row, &m->cycle[taken[SD_RATE_CYCLE]]); }
    if (next == SD_RATE_FIRING) { sd_lcm_firing_to_row(row, &m->firing[taken[SD_RATE_FIRING]]); }
    if (next == SD_RATE_WORK) { sd_lcm_work_to_row(row, &m->work[taken[SD_RATE_WORK]]); }
    if (next == SD_RATE_AIRPATH) { sd_lcm_airpath_to_row(row, &m->airpath[taken[SD_RATE_AIRPATH]]); }
    if (next == SD_RATE_TASK) { sd_lcm_task_to_row(row, &m->task[taken[SD_RATE_TASK]]); }
    if (next == SD_RATE_DRIVELINE) { sd_lcm_driveline_to_row(row, &m->driveline[taken[SD_RATE_DRIVELINE]]); }
    if (next == SD_RATE_COUNT) { return 0; }
    taken[next]++;
    return 1;
}

#ifdef __cplusplus
}
#endif
#endif
