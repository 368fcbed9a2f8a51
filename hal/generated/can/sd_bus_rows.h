/* Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. */
/* SPDX-License-Identifier: MIT */
#ifndef SD_BUS_ROWS_H
#define SD_BUS_ROWS_H
#include "sd_bus.h"
#include "sd_row.h"

#ifdef __cplusplus
extern "C" {
#endif

static inline void sd_bus_edge_from_row(struct sd_bus_edge_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->crank_health = (uint8_t)row->health[SD_OWNER_CRANK];
    m->crank_why = (uint16_t)row->why[SD_OWNER_CRANK];
    m->torque_health = (uint8_t)row->health[SD_OWNER_TORQUE];
    m->torque_why = (uint16_t)row->why[SD_OWNER_TORQUE];
    m->firing_health = (uint8_t)row->health[SD_OWNER_FIRING];
    m->firing_why = (uint16_t)row->why[SD_OWNER_FIRING];
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

static inline void sd_bus_edge_to_row(sd_row_t *row, const struct sd_bus_edge_t *m) {
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

static inline void sd_bus_cycle_1_from_row(struct sd_bus_cycle_1_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->crank_health = (uint8_t)row->health[SD_OWNER_CRANK];
    m->crank_why = (uint16_t)row->why[SD_OWNER_CRANK];
    m->cylinder_health = (uint8_t)row->health[SD_OWNER_CYLINDER];
    m->cylinder_why = (uint16_t)row->why[SD_OWNER_CYLINDER];
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
}

static inline void sd_bus_cycle_1_to_row(sd_row_t *row, const struct sd_bus_cycle_1_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_CYCLE);
    sd_row_status(row, SD_OWNER_CRANK, (uint8_t)m->crank_health, (uint16_t)m->crank_why);
    sd_row_status(row, SD_OWNER_CYLINDER, (uint8_t)m->cylinder_health, (uint16_t)m->cylinder_why);
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
}

static inline void sd_bus_cycle_2_from_row(struct sd_bus_cycle_2_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->cylinder_health = (uint8_t)row->health[SD_OWNER_CYLINDER];
    m->cylinder_why = (uint16_t)row->why[SD_OWNER_CYLINDER];
    m->crank_health = (uint8_t)row->health[SD_OWNER_CRANK];
    m->crank_why = (uint16_t)row->why[SD_OWNER_CRANK];
    m->afr_health = (uint8_t)row->health[SD_OWNER_AFR];
    m->afr_why = (uint16_t)row->why[SD_OWNER_AFR];
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
}

static inline void sd_bus_cycle_2_to_row(sd_row_t *row, const struct sd_bus_cycle_2_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_CYCLE);
    sd_row_status(row, SD_OWNER_CYLINDER, (uint8_t)m->cylinder_health, (uint16_t)m->cylinder_why);
    sd_row_status(row, SD_OWNER_CRANK, (uint8_t)m->crank_health, (uint16_t)m->crank_why);
    sd_row_status(row, SD_OWNER_AFR, (uint8_t)m->afr_health, (uint16_t)m->afr_why);
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
}

static inline void sd_bus_cycle_3_from_row(struct sd_bus_cycle_3_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->afr_health = (uint8_t)row->health[SD_OWNER_AFR];
    m->afr_why = (uint16_t)row->why[SD_OWNER_AFR];
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
}

static inline void sd_bus_cycle_3_to_row(sd_row_t *row, const struct sd_bus_cycle_3_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_CYCLE);
    sd_row_status(row, SD_OWNER_AFR, (uint8_t)m->afr_health, (uint16_t)m->afr_why);
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
}

static inline void sd_bus_cycle_4_from_row(struct sd_bus_cycle_4_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->afr_health = (uint8_t)row->health[SD_OWNER_AFR];
    m->afr_why = (uint16_t)row->why[SD_OWNER_AFR];
    m->balance_health = (uint8_t)row->health[SD_OWNER_BALANCE];
    m->balance_why = (uint16_t)row->why[SD_OWNER_BALANCE];
    m->misfire_health = (uint8_t)row->health[SD_OWNER_MISFIRE];
    m->misfire_why = (uint16_t)row->why[SD_OWNER_MISFIRE];
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
}

static inline void sd_bus_cycle_4_to_row(sd_row_t *row, const struct sd_bus_cycle_4_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_CYCLE);
    sd_row_status(row, SD_OWNER_AFR, (uint8_t)m->afr_health, (uint16_t)m->afr_why);
    sd_row_status(row, SD_OWNER_BALANCE, (uint8_t)m->balance_health, (uint16_t)m->balance_why);
    sd_row_status(row, SD_OWNER_MISFIRE, (uint8_t)m->misfire_health, (uint16_t)m->misfire_why);
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
}

static inline void sd_bus_cycle_5_from_row(struct sd_bus_cycle_5_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->misfire_health = (uint8_t)row->health[SD_OWNER_MISFIRE];
    m->misfire_why = (uint16_t)row->why[SD_OWNER_MISFIRE];
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
}

static inline void sd_bus_cycle_5_to_row(sd_row_t *row, const struct sd_bus_cycle_5_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_CYCLE);
    sd_row_status(row, SD_OWNER_MISFIRE, (uint8_t)m->misfire_health, (uint16_t)m->misfire_why);
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
}

static inline void sd_bus_cycle_6_from_row(struct sd_bus_cycle_6_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->misfire_health = (uint8_t)row->health[SD_OWNER_MISFIRE];
    m->misfire_why = (uint16_t)row->why[SD_OWNER_MISFIRE];
    m->misfire_suspects = row->value[94];
    m->misfire_lamp = row->value[95];
    m->misfire_count = row->value[96];
    m->misfire_partial_burns = row->value[97];
}

static inline void sd_bus_cycle_6_to_row(sd_row_t *row, const struct sd_bus_cycle_6_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_CYCLE);
    sd_row_status(row, SD_OWNER_MISFIRE, (uint8_t)m->misfire_health, (uint16_t)m->misfire_why);
    sd_row_put(row, 94, m->misfire_suspects);
    sd_row_put(row, 95, m->misfire_lamp);
    sd_row_put(row, 96, m->misfire_count);
    sd_row_put(row, 97, m->misfire_partial_burns);
}

static inline void sd_bus_firing_1_from_row(struct sd_bus_firing_1_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->firing_health = (uint8_t)row->health[SD_OWNER_FIRING];
    m->firing_why = (uint16_t)row->why[SD_OWNER_FIRING];
    m->misfire_health = (uint8_t)row->health[SD_OWNER_MISFIRE];
    m->misfire_why = (uint16_t)row->why[SD_OWNER_MISFIRE];
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
}

static inline void sd_bus_firing_1_to_row(sd_row_t *row, const struct sd_bus_firing_1_t *m) {
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
}

static inline void sd_bus_firing_2_from_row(struct sd_bus_firing_2_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->misfire_health = (uint8_t)row->health[SD_OWNER_MISFIRE];
    m->misfire_why = (uint16_t)row->why[SD_OWNER_MISFIRE];
    m->misfire_acceleration = row->value[75];
    m->misfire_residual = row->value[76];
}

static inline void sd_bus_firing_2_to_row(sd_row_t *row, const struct sd_bus_firing_2_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_FIRING);
    sd_row_status(row, SD_OWNER_MISFIRE, (uint8_t)m->misfire_health, (uint16_t)m->misfire_why);
    sd_row_put(row, 75, m->misfire_acceleration);
    sd_row_put(row, 76, m->misfire_residual);
}

static inline void sd_bus_work_from_row(struct sd_bus_work_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->work_health = (uint8_t)row->health[SD_OWNER_WORK];
    m->work_why = (uint16_t)row->why[SD_OWNER_WORK];
    m->work_cycle = row->value[34];
    m->work_sd = row->value[35];
    m->work_change = row->value[36];
    m->work_firing = row->value[37];
    m->work_cylinder = row->value[38];
}

static inline void sd_bus_work_to_row(sd_row_t *row, const struct sd_bus_work_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_WORK);
    sd_row_status(row, SD_OWNER_WORK, (uint8_t)m->work_health, (uint16_t)m->work_why);
    sd_row_put(row, 34, m->work_cycle);
    sd_row_put(row, 35, m->work_sd);
    sd_row_put(row, 36, m->work_change);
    sd_row_put(row, 37, m->work_firing);
    sd_row_put(row, 38, m->work_cylinder);
}

static inline void sd_bus_airpath_from_row(struct sd_bus_airpath_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->airpath_health = (uint8_t)row->health[SD_OWNER_AIRPATH];
    m->airpath_why = (uint16_t)row->why[SD_OWNER_AIRPATH];
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

static inline void sd_bus_airpath_to_row(sd_row_t *row, const struct sd_bus_airpath_t *m) {
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

static inline void sd_bus_task_from_row(struct sd_bus_task_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->inputs_health = (uint8_t)row->health[SD_OWNER_INPUTS];
    m->inputs_why = (uint16_t)row->why[SD_OWNER_INPUTS];
    m->inputs_stale_1 = row->value[110];
    m->inputs_stale_2 = row->value[111];
    m->inputs_missing_1 = row->value[112];
    m->inputs_missing_2 = row->value[113];
}

static inline void sd_bus_task_to_row(sd_row_t *row, const struct sd_bus_task_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_TASK);
    sd_row_status(row, SD_OWNER_INPUTS, (uint8_t)m->inputs_health, (uint16_t)m->inputs_why);
    sd_row_put(row, 110, m->inputs_stale_1);
    sd_row_put(row, 111, m->inputs_stale_2);
    sd_row_put(row, 112, m->inputs_missing_1);
    sd_row_put(row, 113, m->inputs_missing_2);
}

static inline void sd_bus_driveline_from_row(struct sd_bus_driveline_t *m, const sd_row_t *row) {
    m->tick = (uint32_t)row->tick;
    m->driveline_health = (uint8_t)row->health[SD_OWNER_DRIVELINE];
    m->driveline_why = (uint16_t)row->why[SD_OWNER_DRIVELINE];
    m->driveline_reference_health = (uint8_t)row->health[SD_OWNER_DRIVELINE_REFERENCE];
    m->driveline_reference_why = (uint16_t)row->why[SD_OWNER_DRIVELINE_REFERENCE];
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

static inline void sd_bus_driveline_to_row(sd_row_t *row, const struct sd_bus_driveline_t *m) {
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

#define SD_BUS_INPUTS_FIRST 0xd0u
#define SD_BUS_INPUTS_END   0xe2u /* the identifier after the last input's */
#define SD_BUS_ROW_FRAMES   6u /* of the longest row */
#define SD_BUS_WHEELS       14u /* whose edges a teeth frame can carry */

/* How many bytes frame `part` of a row of `rate` takes, its identifier in *id; 0 when there is no such part. */
static inline uint32_t sd_bus_row_pack(const sd_row_t *row, uint32_t part, uint32_t *id, uint8_t bytes[64]) {
    uint32_t at = 0;
    if ((row->rate == SD_RATE_EDGE) && (at++ == part)) {
        struct sd_bus_edge_t m;
        sd_bus_edge_from_row(&m, row);
        *id = SD_BUS_EDGE_FRAME_ID;
        return (uint32_t)sd_bus_edge_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_CYCLE) && (at++ == part)) {
        struct sd_bus_cycle_1_t m;
        sd_bus_cycle_1_from_row(&m, row);
        *id = SD_BUS_CYCLE_1_FRAME_ID;
        return (uint32_t)sd_bus_cycle_1_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_CYCLE) && (at++ == part)) {
        struct sd_bus_cycle_2_t m;
        sd_bus_cycle_2_from_row(&m, row);
        *id = SD_BUS_CYCLE_2_FRAME_ID;
        return (uint32_t)sd_bus_cycle_2_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_CYCLE) && (at++ == part)) {
        struct sd_bus_cycle_3_t m;
        sd_bus_cycle_3_from_row(&m, row);
        *id = SD_BUS_CYCLE_3_FRAME_ID;
        return (uint32_t)sd_bus_cycle_3_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_CYCLE) && (at++ == part)) {
        struct sd_bus_cycle_4_t m;
        sd_bus_cycle_4_from_row(&m, row);
        *id = SD_BUS_CYCLE_4_FRAME_ID;
        return (uint32_t)sd_bus_cycle_4_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_CYCLE) && (at++ == part)) {
        struct sd_bus_cycle_5_t m;
        sd_bus_cycle_5_from_row(&m, row);
        *id = SD_BUS_CYCLE_5_FRAME_ID;
        return (uint32_t)sd_bus_cycle_5_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_CYCLE) && (at++ == part)) {
        struct sd_bus_cycle_6_t m;
        sd_bus_cycle_6_from_row(&m, row);
        *id = SD_BUS_CYCLE_6_FRAME_ID;
        return (uint32_t)sd_bus_cycle_6_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_FIRING) && (at++ == part)) {
        struct sd_bus_firing_1_t m;
        sd_bus_firing_1_from_row(&m, row);
        *id = SD_BUS_FIRING_1_FRAME_ID;
        return (uint32_t)sd_bus_firing_1_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_FIRING) && (at++ == part)) {
        struct sd_bus_firing_2_t m;
        sd_bus_firing_2_from_row(&m, row);
        *id = SD_BUS_FIRING_2_FRAME_ID;
        return (uint32_t)sd_bus_firing_2_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_WORK) && (at++ == part)) {
        struct sd_bus_work_t m;
        sd_bus_work_from_row(&m, row);
        *id = SD_BUS_WORK_FRAME_ID;
        return (uint32_t)sd_bus_work_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_AIRPATH) && (at++ == part)) {
        struct sd_bus_airpath_t m;
        sd_bus_airpath_from_row(&m, row);
        *id = SD_BUS_AIRPATH_FRAME_ID;
        return (uint32_t)sd_bus_airpath_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_TASK) && (at++ == part)) {
        struct sd_bus_task_t m;
        sd_bus_task_from_row(&m, row);
        *id = SD_BUS_TASK_FRAME_ID;
        return (uint32_t)sd_bus_task_pack(bytes, &m, 64);
    }
    if ((row->rate == SD_RATE_DRIVELINE) && (at++ == part)) {
        struct sd_bus_driveline_t m;
        sd_bus_driveline_from_row(&m, row);
        *id = SD_BUS_DRIVELINE_FRAME_ID;
        return (uint32_t)sd_bus_driveline_pack(bytes, &m, 64);
    }
    return 0;
}

/* 1: `id` is a row's and *row holds it; 0: it is not; -1: it is, and too short. */
static inline int sd_bus_row_unpack(sd_row_t *row, uint32_t id, const uint8_t *bytes, size_t size) {
    if (id == SD_BUS_EDGE_FRAME_ID) {
        struct sd_bus_edge_t m;
        if ((size != SD_BUS_EDGE_LENGTH) || (sd_bus_edge_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_edge_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_CYCLE_1_FRAME_ID) {
        struct sd_bus_cycle_1_t m;
        if ((size != SD_BUS_CYCLE_1_LENGTH) || (sd_bus_cycle_1_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_cycle_1_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_CYCLE_2_FRAME_ID) {
        struct sd_bus_cycle_2_t m;
        if ((size != SD_BUS_CYCLE_2_LENGTH) || (sd_bus_cycle_2_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_cycle_2_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_CYCLE_3_FRAME_ID) {
        struct sd_bus_cycle_3_t m;
        if ((size != SD_BUS_CYCLE_3_LENGTH) || (sd_bus_cycle_3_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_cycle_3_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_CYCLE_4_FRAME_ID) {
        struct sd_bus_cycle_4_t m;
        if ((size != SD_BUS_CYCLE_4_LENGTH) || (sd_bus_cycle_4_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_cycle_4_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_CYCLE_5_FRAME_ID) {
        struct sd_bus_cycle_5_t m;
        if ((size != SD_BUS_CYCLE_5_LENGTH) || (sd_bus_cycle_5_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_cycle_5_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_CYCLE_6_FRAME_ID) {
        struct sd_bus_cycle_6_t m;
        if ((size != SD_BUS_CYCLE_6_LENGTH) || (sd_bus_cycle_6_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_cycle_6_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_FIRING_1_FRAME_ID) {
        struct sd_bus_firing_1_t m;
        if ((size != SD_BUS_FIRING_1_LENGTH) || (sd_bus_firing_1_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_firing_1_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_FIRING_2_FRAME_ID) {
        struct sd_bus_firing_2_t m;
        if ((size != SD_BUS_FIRING_2_LENGTH) || (sd_bus_firing_2_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_firing_2_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_WORK_FRAME_ID) {
        struct sd_bus_work_t m;
        if ((size != SD_BUS_WORK_LENGTH) || (sd_bus_work_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_work_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_AIRPATH_FRAME_ID) {
        struct sd_bus_airpath_t m;
        if ((size != SD_BUS_AIRPATH_LENGTH) || (sd_bus_airpath_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_airpath_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_TASK_FRAME_ID) {
        struct sd_bus_task_t m;
        if ((size != SD_BUS_TASK_LENGTH) || (sd_bus_task_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_task_to_row(row, &m);
        return 1;
    }
    if (id == SD_BUS_DRIVELINE_FRAME_ID) {
        struct sd_bus_driveline_t m;
        if ((size != SD_BUS_DRIVELINE_LENGTH) || (sd_bus_driveline_unpack(&m, bytes, size) != 0)) { return -1; }
        sd_bus_driveline_to_row(row, &m);
        return 1;
    }
    return 0;
}

#ifdef __cplusplus
}
#endif
#endif
