/* SPDX-License-Identifier: MIT */
/// sd_firings.h - torque of each single firing from crank teeth: all that belongs to it in one block.
///
///   tooth -> two filters on tooth times (sd_kalman.h), one for smooth and one for rough roads -> the road chooses (sd_road.h)
///         -> a firing, its deviation, and how far it may be trusted
///   tooth with fuel -> tooth pattern while the engine fires (sd_fired.h)
///   tooth without fuel -> tooth pattern (sd_pattern.h) and frequencies of the crank's twist (sd_twist.h), which correct the
///         teeth to come; firings read without fuel -> zero of each cylinder
///
/// A firing may be trusted when the filter has settled, the phase and the intake pressure are known, and no tooth since
/// its pulse began was doubtful.
///
/// Real-time contract: no heap, no globals, no I/O, no libm in a step. One writer per state, which is plain data without
/// pointers; but the long part of the 10 ms task, sd_firings_task_work, may be interrupted by teeth, as sd_fired.h says. Tables are read
/// only and may stand in flash. Call order: init; step for every placed tooth; restart when the angle was lost or moved; spurious for an
/// edge that is no tooth; every 10 ms task_begin, task_work, task_end. What is not said to be for that stays out between the first and the
/// last.
#ifndef SD_FIRINGS_H
#define SD_FIRINGS_H
#include <stddef.h>
#include "sd_pattern.h"
#include "sd_road.h"

#ifdef __cplusplus
extern "C" {
#endif

/// What may change while the engine runs, SI but where a name says otherwise.
typedef struct sd_firings_config {
    float   torque_base_nm; ///< Highest |torque| of a firing, [1e-3, 20000] N m; beyond it the filter starts anew.
    float   reject_deg;     ///< Lateness of a tooth, [6e-5, 57] deg, beyond which it is left out while the filter settles.
    float   settle_cycles;  ///< Cycles until the filter counts as converged, [0, 200].
    float   pattern_deg;    ///< Standard deviation of a tooth's place while its pattern is not learned, [0, 10] deg.
    uint8_t teeth;          ///< Teeth that are there, a revolution, 1 to 120.
    uint8_t enabled;        ///< 0: the block rests, and says uncalibrated.
} sd_firings_config_t;

/// Whether the driveline moves, from whoever knows.
typedef enum sd_driveline_word {
    SD_DRIVELINE_UNKNOWN = 0, ///< Nobody says: the block guesses from firings whether the load moves.
    SD_DRIVELINE_STILL   = 1, ///< It rests, so that the guess stands alone for what reaches the crank otherwise.
    SD_DRIVELINE_MOVES   = 2, ///< The load moves: the filter for rough roads is believed, whatever firings say.
} sd_driveline_word_t;

/// A placed tooth, and the inputs as they stand at it.
typedef struct sd_firings_tooth {
    uint16_t cycle_position; ///< Position over the cycle, [0, 2 N) for a wheel of N positions.
    uint16_t position;       ///< The same over a revolution, [0, N).
    uint16_t advance;        ///< Positions since the last placed tooth, 1 to 2 N.
    uint32_t period_ticks;   ///< Time since the last placed tooth, capture ticks.
    uint8_t  health;         ///< sd_health_t of the tooth; only teeth that are SD_VALID correct the filters.
    uint8_t  phase_known;    ///< 1: which of the two revolutions this is has been confirmed.
    uint8_t  intake_known;   ///< 0: intake_bar is a usual value that stands for a sensor that does not speak.
    uint8_t  fuel_cut;       ///< 1: it is known that no cylinder is given fuel now.
    uint8_t  driveline;      ///< sd_driveline_word_t: what is known of the driveline behind the crank.
    float    fuel_mg;        ///< Fuel commanded for a firing, mg; below 0 where it is not known.
    float    intake_bar;     ///< Intake pressure, [0, 10] bar; anything else, NaN included: the last good one is held.
    float    speed_radps;    ///< Crank speed at the tooth, rad/s; weighs what is learned of the cylinders' zeros.
} sd_firings_tooth_t;

/// What the block says at a tooth.
typedef struct sd_firings_out {
    uint8_t     complete;    ///< 1: `firing` has just been completed; 0: `firing` is not set.
    uint8_t     rough;       ///< 1: the road is rough, and all that is said comes from the filter for rough roads.
    uint8_t     restarted;   ///< 1: a filter began anew at this tooth, so that what follows has no past.
    uint8_t     learned;     ///< 1: the tooth pattern from fuel cut changed, and what sd_firings_believed says.
    sd_firing_t firing;      ///< Torque and deviation of one firing.
    sd_status_t status;      ///< Of the block; innovation in rad, test_ratio 0: sd_kalman_status gives it to who asks. Invalid and
                             ///< uncalibrated while it rests.
    float       waveform_nm; ///< Torque of the whole engine at the tooth, N m, friction and load taken off; 0 while resting.
    float       level_nm;    ///< What of waveform_nm no cylinder gives: less load, less friction; 0 while resting.
    float       energy_j;    ///< Kinetic energy at the tooth, J; 0 while no filter runs.
    float       speed_radps; ///< Speed that belongs to it by the mean inertia, rad/s; set with a firing, as `firing` is.
} sd_firings_out_t;

/// State. What is public to read: `pattern` and whether `on_rough`.
typedef struct sd_firings {
    sd_kalman_t  kalman;   ///< Filter 0 for smooth roads, filter 1 for rough ones where the tables have two sets of gains.
    sd_road_t    road;     ///< Which of them to believe.
    sd_pattern_t pattern;  ///< Of the wheel, learned in fuel cut, with the crank's twist and the cylinders' zeros.
    sd_fired_t   fired;    ///< Pattern of the wheel, learned while the engine fires; its sums stand in `pattern`.
    float        unlearned_rad; ///< Standard deviation of a tooth's place while its pattern is not learned.
    uint16_t     doubt;    ///< Positions until no firing under way holds a tooth that was not trusted.
    uint16_t     motored;  ///< Positions since the fuel was cut, saturating.
    uint8_t      on_rough; ///< 1: what is said of firings comes from filter 1.
    uint8_t      enabled;  ///< The block runs; 0 without tables.
    uint8_t      corrects; ///< Which pattern is believed: 0 none, 1 that from fuel cut, 2 that from firing.
} sd_firings_t;

/// Forgets everything, learned values included. Tables with positions 0 are none: the block rests. SD_OK, or
/// SD_ERR_CONFIG with the state untouched: a field of *config or *tables is out of range.
sd_result_t sd_firings_init(sd_firings_t *self, const sd_firings_config_t *config, const sd_kalman_tables_t *tables);

/// Takes another configuration, between two teeth; nothing is forgotten, but the filters begin anew when `enabled`
/// becomes 1. SD_OK, or SD_ERR_CONFIG with nothing changed: a field is out of range. Without
/// tables it rests whatever *config says.
sd_result_t sd_firings_configure(sd_firings_t *self, const sd_firings_config_t *config, const sd_kalman_tables_t *tables);

/// The angle was lost or moved: the filters begin anew. What was learned stays.
void sd_firings_restart(sd_firings_t *self);

/// An edge that stands for no tooth was seen. Which of two near each other is the tooth may have been decided wrongly, so the
/// firings of the next two revolutions are in doubt.
void sd_firings_spurious(sd_firings_t *self, const sd_kalman_tables_t *tables);

/// Takes a placed tooth and fills *out.
void sd_firings_step(sd_firings_t *self, const sd_kalman_tables_t *tables, const sd_firings_tooth_t *tooth, sd_firings_out_t *out);

/// The 10 ms task, in which the tooth pattern is learned while the engine fires. Between two teeth: a cycle is handed to it.
void sd_firings_task_begin(sd_firings_t *self);
/// Its long part. sd_firings_step, restart and spurious may interrupt it at any instruction.
void sd_firings_task_work(sd_firings_t *self, const sd_kalman_tables_t *tables);
/// Between two teeth again: what came of it is taken over. Returns true when the tooth pattern changed.
bool sd_firings_task_end(sd_firings_t *self);

/// The tooth pattern as it is believed now.
typedef struct sd_firings_pattern {
    const float *late_rad; ///< How late each tooth of a revolution comes, rad; NULL: nothing is believed.
    float cycles;          ///< Number of cycles that it was learned in; where nothing is believed, of cycles without fuel so far.
    float sd_rad;          ///< Its standard deviation; 0: nothing learned.
    float tooth_rad;       ///< The part of sd_rad that teeth have by themselves, or the deviation of a wheel that is not known.
    float hidden_share;    ///< What the other part leaves in a firing less the mean of all, over J w^2.
} sd_firings_pattern_t;

/// The pattern that is known best: from fuel cut, from firing, or none.
sd_firings_pattern_t sd_firings_believed(const sd_firings_t *self);

/// How late a tooth comes by that pattern, rad; 0 where none is believed, and beyond the wheel.
static inline float sd_firings_late(const sd_firings_pattern_t *pattern, uint32_t position) {
    return ((pattern->late_rad != NULL) && (position < SD_KALMAN_POSITIONS_MAX)) ? pattern->late_rad[position] : 0.0f;
}

/// What to keep when the engine is off. Passes over the whole wheel: not for a tooth. Without tables all is 0.
void sd_firings_keep(const sd_firings_t *self, const sd_kalman_tables_t *tables, sd_pattern_sums_t *learned);

/// Goes on with what was learned before. SD_OK, or SD_ERR_CONFIG with nothing changed: it is of another wheel or crank, or the
/// block rests.
sd_result_t sd_firings_resume(sd_firings_t *self, const sd_kalman_tables_t *tables, const sd_pattern_sums_t *learned);

#ifdef __cplusplus
}
#endif

#endif
