/* SPDX-License-Identifier: MIT */
/// sd_course.h - where in the engine cycle the crank is: whether a tooth follows the last one, and when a cycle has ended.
///
/// The decoder may move the angle (a slip put right, a phase found). The observers carry on only if they know by how much: half a
/// cycle changes signs, anything else is a fresh start.
#ifndef SD_COURSE_H
#define SD_COURSE_H
#include <stdbool.h>

#include "sd_crank.h"

#ifdef __cplusplus
extern "C" {
#endif

/// How far the course went back.
typedef enum sd_course_jump {
    SD_COURSE_NONE    = 0, ///< The tooth follows the last one.
    SD_COURSE_SHIFTED = 1, ///< It is one revolution off: the phase became known.
    SD_COURSE_RESTART = 2, ///< The first tooth, or an angle that moved.
} sd_course_jump_t;

/// A cycle that has ended.
typedef struct sd_cycle {
    uint32_t tick;        ///< Of the first tooth after it.
    float    speed_radps; ///< Mean speed; 0 when no time passed.
    bool     whole;       ///< Every position of it was passed.
    bool     clean;       ///< Nothing was wrong with the torque estimate in it, but that it may converge.
    bool     phase_known; ///< At its end.
} sd_cycle_t;

/// All zero is a valid start.
typedef struct sd_course {
    uint32_t cycle_ticks;     ///< Of the cycle so far.
    uint32_t cycle_positions; ///< Passed in it.
    uint16_t position;        ///< Cycle position of the last placed tooth.
    uint8_t  following;       ///< 1: the last placed tooth is known.
    uint8_t  spoilt;          ///< 1: something was wrong in this cycle.
} sd_course_t;

/// Compares a placed tooth with the last one; on a jump the cycle so far is dropped. positions: of the wheel, a revolution.
sd_course_jump_t sd_course_follow(sd_course_t *self, const sd_tooth_t *tooth, uint32_t positions);

/// True when this tooth is the first of a new cycle; *cycle then describes the one that ended, and a new one begins. Call it after
/// sd_course_follow and before sd_course_add.
bool sd_course_ended(sd_course_t *self, const sd_tooth_t *tooth, uint32_t positions, float tick_hz, sd_cycle_t *cycle);

/// The tooth belongs to the cycle under way; good: the torque estimate at it may be read at the cycle's end.
void sd_course_add(sd_course_t *self, const sd_tooth_t *tooth, bool good);

/// The angle is lost.
void sd_course_lose(sd_course_t *self);

#ifdef __cplusplus
}
#endif
#endif
