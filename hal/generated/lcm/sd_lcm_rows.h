/* Generated from hal/signals.toml by tools/signals/generate.py: change the table, not this file. */
/* SPDX-License-Identifier: MIT */
#ifndef SD_LCM_ROWS_H
#define SD_LCM_ROWS_H

#include "sixdeg_cycle_t.h"
#include "sixdeg_edge_t.h"
#include "sd_row.h"

static inline void sd_lcm_edge_from_row(sixdeg_edge_t *m, const sd_row_t *row) {
    m->tick = (int32_t)row->tick;
    m->crank_health = (int8_t)row->health[SD_OWNER_CRANK];
    m->crank_why = (int8_t)row->why[SD_OWNER_CRANK];
    m->torque_health = (int8_t)row->health[SD_OWNER_TORQUE];
    m->torque_why = (int8_t)row->why[SD_OWNER_TORQUE];
    m->crank_edge_class = row->value[0];
    m->crank_tooth = row->value[1];
    m->crank_angle = row->value[2];
    m->crank_phase_known = row->value[3];
    m->crank_speed = row->value[4];
    m->crank_acceleration = row->value[5];
    m->torque_mass = row->value[6];
    m->torque_innovation = row->value[7];
}

static inline void sd_lcm_edge_to_row(sd_row_t *row, const sixdeg_edge_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_EDGE);
    sd_row_status(row, SD_OWNER_CRANK, (uint8_t)m->crank_health, (uint8_t)m->crank_why);
    sd_row_status(row, SD_OWNER_TORQUE, (uint8_t)m->torque_health, (uint8_t)m->torque_why);
    sd_row_put(row, 0, m->crank_edge_class);
    sd_row_put(row, 1, m->crank_tooth);
    sd_row_put(row, 2, m->crank_angle);
    sd_row_put(row, 3, m->crank_phase_known);
    sd_row_put(row, 4, m->crank_speed);
    sd_row_put(row, 5, m->crank_acceleration);
    sd_row_put(row, 6, m->torque_mass);
    sd_row_put(row, 7, m->torque_innovation);
}

static inline void sd_lcm_cycle_from_row(sixdeg_cycle_t *m, const sd_row_t *row) {
    m->tick = (int32_t)row->tick;
    m->crank_health = (int8_t)row->health[SD_OWNER_CRANK];
    m->crank_why = (int8_t)row->why[SD_OWNER_CRANK];
    m->cylinder_health = (int8_t)row->health[SD_OWNER_CYLINDER];
    m->cylinder_why = (int8_t)row->why[SD_OWNER_CYLINDER];
    m->afr_health = (int8_t)row->health[SD_OWNER_AFR];
    m->afr_why = (int8_t)row->why[SD_OWNER_AFR];
    m->balance_health = (int8_t)row->health[SD_OWNER_BALANCE];
    m->balance_why = (int8_t)row->why[SD_OWNER_BALANCE];
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
    m->afr_cylinder_burned_1 = row->value[25];
    m->afr_cylinder_burned_2 = row->value[26];
    m->afr_cylinder_burned_3 = row->value[27];
    m->afr_cylinder_burned_4 = row->value[28];
    m->afr_cylinder_burned_5 = row->value[29];
    m->afr_cylinder_burned_6 = row->value[30];
    m->afr_cylinder_burned_7 = row->value[31];
    m->afr_cylinder_burned_8 = row->value[32];
    m->afr_cylinder_sd_1 = row->value[33];
    m->afr_cylinder_sd_2 = row->value[34];
    m->afr_cylinder_sd_3 = row->value[35];
    m->afr_cylinder_sd_4 = row->value[36];
    m->afr_cylinder_sd_5 = row->value[37];
    m->afr_cylinder_sd_6 = row->value[38];
    m->afr_cylinder_sd_7 = row->value[39];
    m->afr_cylinder_sd_8 = row->value[40];
    m->afr_slow = row->value[41];
    m->balance_trim_1 = row->value[42];
    m->balance_trim_2 = row->value[43];
    m->balance_trim_3 = row->value[44];
    m->balance_trim_4 = row->value[45];
    m->balance_trim_5 = row->value[46];
    m->balance_trim_6 = row->value[47];
    m->balance_trim_7 = row->value[48];
    m->balance_trim_8 = row->value[49];
}

static inline void sd_lcm_cycle_to_row(sd_row_t *row, const sixdeg_cycle_t *m) {
    sd_row_begin(row, (uint32_t)m->tick, SD_RATE_CYCLE);
    sd_row_status(row, SD_OWNER_CRANK, (uint8_t)m->crank_health, (uint8_t)m->crank_why);
    sd_row_status(row, SD_OWNER_CYLINDER, (uint8_t)m->cylinder_health, (uint8_t)m->cylinder_why);
    sd_row_status(row, SD_OWNER_AFR, (uint8_t)m->afr_health, (uint8_t)m->afr_why);
    sd_row_status(row, SD_OWNER_BALANCE, (uint8_t)m->balance_health, (uint8_t)m->balance_why);
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
    sd_row_put(row, 25, m->afr_cylinder_burned_1);
    sd_row_put(row, 26, m->afr_cylinder_burned_2);
    sd_row_put(row, 27, m->afr_cylinder_burned_3);
    sd_row_put(row, 28, m->afr_cylinder_burned_4);
    sd_row_put(row, 29, m->afr_cylinder_burned_5);
    sd_row_put(row, 30, m->afr_cylinder_burned_6);
    sd_row_put(row, 31, m->afr_cylinder_burned_7);
    sd_row_put(row, 32, m->afr_cylinder_burned_8);
    sd_row_put(row, 33, m->afr_cylinder_sd_1);
    sd_row_put(row, 34, m->afr_cylinder_sd_2);
    sd_row_put(row, 35, m->afr_cylinder_sd_3);
    sd_row_put(row, 36, m->afr_cylinder_sd_4);
    sd_row_put(row, 37, m->afr_cylinder_sd_5);
    sd_row_put(row, 38, m->afr_cylinder_sd_6);
    sd_row_put(row, 39, m->afr_cylinder_sd_7);
    sd_row_put(row, 40, m->afr_cylinder_sd_8);
    sd_row_put(row, 41, m->afr_slow);
    sd_row_put(row, 42, m->balance_trim_1);
    sd_row_put(row, 43, m->balance_trim_2);
    sd_row_put(row, 44, m->balance_trim_3);
    sd_row_put(row, 45, m->balance_trim_4);
    sd_row_put(row, 46, m->balance_trim_5);
    sd_row_put(row, 47, m->balance_trim_6);
    sd_row_put(row, 48, m->balance_trim_7);
    sd_row_put(row, 49, m->balance_trim_8);
}

#endif
