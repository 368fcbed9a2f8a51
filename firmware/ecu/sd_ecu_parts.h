/* SPDX-License-Identifier: MIT */
/* sd_ecu_parts.h - what the files of the ecu share; no part of its interface. sd_ecu.c calls the others, and none calls back. */
#ifndef SD_ECU_PARTS_H
#define SD_ECU_PARTS_H
#include <stddef.h>

#include "sd_ecu.h"
#include "sd_shed.h"

#ifdef __cplusplus
extern "C" {
#endif

/* What an ecu makes of events. An edge is said, speed in rad/s returned; a placed tooth with that speed; an edge that is none; the
 * angle is lost; work is left out from here on, or no longer; a sample was taken; an edge of a wheel's teeth. */
float sd_ecu_say_edge(sd_ecu_t *self, const sd_calibration_t *page, const sd_tooth_t *tooth);
void sd_ecu_tooth(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_tooth_t *tooth, float speed_radps);
void sd_ecu_spurious(sd_ecu_t *self, const sd_calibration_t *page);
void sd_ecu_lose_angle(sd_ecu_t *self, uint16_t why);
void sd_ecu_shed(sd_ecu_t *self, uint8_t level);
void sd_ecu_sample(sd_ecu_t *self, sd_input_t input, float value);
void sd_ecu_wheel(sd_ecu_t *self, const sd_calibration_t *page, uint16_t wheel, uint32_t tick);
/* The 10 ms task in three parts. What the crank says now is noted; the long part, which edges may interrupt, so that it touches nothing
 * that they do; what came of it is said, with a why beside what it is worth anyway (0: none). */
void sd_ecu_task_begin(sd_ecu_t *self, const sd_calibration_t *page, uint32_t tick);
void sd_ecu_task_work(sd_ecu_t *self, const sd_calibration_t *page);
void sd_ecu_task_say(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, uint16_t why);

/* sd_ecu_t.task: nothing is put off; the long part is due; it is done, and not said yet. */
enum { SD_TASK_NONE, SD_TASK_DUE, SD_TASK_DONE };

/* sd_ecu_cycle.c: pieces of work, in their order. */
typedef enum sd_piece {
    SD_PIECE_CYLINDERS, /* torque of each cylinder from the harmonics */
    SD_PIECE_DELAY,     /* trims told to the mixture's filter, delay learned */
    SD_PIECE_MIXTURE,   /* mixture read, operating point noted */
    SD_PIECE_TRIMS,     /* deviations chosen for the trims */
    SD_PIECE_BALANCE,   /* trims moved, in parts */
    SD_PIECE_COMMAND,   /* trims of balance and probe go out */
    SD_PIECE_MISFIRES,  /* rates and lamp read */
    SD_PIECE_SAY,       /* the cycle's row of signals, in parts */
    SD_PIECE_POINT,     /* tables of the operating point, in parts */
    SD_PIECE_NONE,
} sd_piece_t;

/* Begins the work of a cycle that ended; what the last one left is done at once. */
void sd_ecu_begin_work(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_cycle_t *cycle);
/* What the owners of a cycle's work are worth while none is begun. */
static inline void sd_ecu_say_cycle_shed(sd_publish_t *say) {
    sd_publish_worst_of(say, SD_OWNER_CYLINDER, SD_INVALID, SD_WHY_OVERLOAD);
    sd_publish_worst_of(say, SD_OWNER_AFR, SD_INVALID, SD_WHY_OVERLOAD);
    sd_publish_worst_of(say, SD_OWNER_BALANCE, SD_DEGRADED, SD_WHY_OVERLOAD);
}
/* Does one piece, if any is due. */
void sd_ecu_do_piece(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port);

/* Takes the working parameters over into the stage that owns this one: whole, or on an error not at all. */
sd_result_t sd_ecu_apply(sd_ecu_t *self, const sd_calibration_t *page, uint32_t index);
#define SD_PARAMETER_INDEX(field) ((uint32_t)(offsetof(sd_parameters_t, field) / sizeof(float)))

#ifndef SD_ECU_FIXED
/* sd_ecu_parameters.c */
sd_firings_config_t sd_ecu_firings_config(const sd_calibration_t *page, const sd_parameters_t *p);
#endif
/* sd_ecu_command.c: reads or changes a parameter and sends the answer. */
void sd_ecu_parameter(sd_ecu_t *self, const sd_calibration_t *page, const sd_port_t *port, const sd_event_t *request);

#ifdef __cplusplus
}
#endif

#endif
