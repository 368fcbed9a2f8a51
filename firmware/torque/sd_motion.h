/* SPDX-License-Identifier: MIT */
/// sd_motion.h - motion of a crank from tooth to tooth, under torques that are known and torques that are estimated.
///
/// The model that sd_kalman.h corrects and sd_pattern.h lets run free: equations there. Tables of one engine and wheel are
/// here, and what is predicted from them. A position's known torque is summed once (sd_motion_known) and serves all
/// estimates that run on it.
///
/// Real-time contract: no heap, no globals, no libm; constant time. Tables are read only and may stand in flash.
#ifndef SD_MOTION_H
#define SD_MOTION_H
#include "sd_limits.h"
#include "sd_math.h"

#ifdef __cplusplus
extern "C" {
#endif

#define SD_KALMAN_COEFFICIENTS_MAX 25  ///< Torque coefficients, the constant one included.
#define SD_KALMAN_POSITIONS_MAX    120 ///< Wheel positions a revolution.
#define SD_KALMAN_SPEEDS_MAX       12  ///< Speeds of a set of gains.
#define SD_KALMAN_FIRINGS_MAX      SD_CYLINDERS_MAX ///< Firings of a cycle.
#define SD_KALMAN_SETS_MAX         2    ///< Of gains.
#define SD_KALMAN_GAINS_MAX        (SD_KALMAN_SETS_MAX * SD_KALMAN_SPEEDS_MAX) ///< Gain tables of all sets.
#define SD_KALMAN_MODES_MAX        2 ///< Vibrations of a crank that twists.
#define SD_KALMAN_PARTS_MAX        (3 + SD_KALMAN_FIRINGS_MAX) ///< Parts that a cycle's lateness is split into.
#define SD_KALMAN_HIDDEN_MAX       (SD_KALMAN_FIRINGS_MAX / 2) ///< Directions of the tooth pattern that look like torque.
#define SD_KALMAN_SCALES           (5 + 2 * SD_KALMAN_MODES_MAX) ///< Scales of a set of gains.
#ifndef SD_KALMAN_POOL
/// Words for torques and gains: 12 harmonics at 4 speeds take 26,400, 8 cylinders with 2 modes at 12 speeds 17,640. A build for less
/// may define it.
#define SD_KALMAN_POOL             26500
#endif

/// A natural vibration that moves the toothed wheel. Torques in Nm hold it at a twist of the wheel in rad.
typedef struct sd_kalman_mode {
    float frequency_radps;  ///< w_m, [1, 1e5].
    float damping;          ///< z, share of critical, [0, 1).
    float constant_radpnm;  ///< Compliance to x_0, [-1, 1].
    float cylinder_radpnm[SD_KALMAN_FIRINGS_MAX]; ///< Compliance to each cylinder's torque, [-1, 1].
    float spring_nmprad;    ///< Torque that leaves the crank through a flywheel's spring, per rad of q, [-1e7, 1e7].
    float damper_nmprad;    ///< The same per rad of v, [-1e7, 1e7].
} sd_kalman_mode_t;

/// One word of a row.
typedef union sd_kalman_word {
    float   value;   ///< In the unit of its place.
    int16_t gain[2]; ///< Two gains, each over its scale, times 32767.
    struct {
        uint8_t first; ///< The pulses of this row are those of firings first, first + 1 ... round the firing order.
        uint8_t close; ///< Bit i: cylinder i's intake valve closes here.
        uint8_t read;  ///< 1 + i: firing i is read here; 0: none.
        uint8_t tooth; ///< 1: the wheel has a tooth here.
    } at;
} sd_kalman_word_t;

/// Where the parts of a row begin, in words. Behind the motored torques, three words a cylinder, come the pulses, six words
/// each of `window` ones, then two words a mode, then the gains.
enum {
    SD_ROW_AT       = 0, ///< What happens at the position: `at` of the word.
    SD_ROW_INTERVAL = 1, ///< 2 over J_interval, the inertia that takes as long as J(alpha) does, 1/(kg m2).
    SD_ROW_TOOTH    = 2, ///< 2 over J at the tooth, 1/(kg m2).
    SD_ROW_KNOWN    = 3, ///< Motored torque beside what scales with intake pressure, Nm: mean, moment, point.
    SD_ROW_COMMON   = 6, ///< What an exponent of compression larger by 1 adds to all cylinders' motored torque, Nm per bar of their
                         ///< mean intake pressure: mean, moment, point; 0 where that is not learned.
    SD_ROW_LATE     = 9, ///< How late, in fuel cut, that makes the tooth at SD_PATTERN_REFERENCE_RADPS, rad per bar, as the learning of
                         ///< the tooth pattern reads it: trend and mean taken out; the same in both revolutions, 0 without a tooth.
    SD_ROW_MOTORED  = 10 ///< Of each cylinder: mean, moment, point, Nm per bar of its intake pressure.
};

/// Read only. One row of `pool` a cycle position k, angles between the teeth k - 1 and k. mean: over the interval; moment:
/// of (1 - s) f, s from 0 to 1 over the interval; point: at tooth k. A pulse: mean, moment, point of the basis f_j, and of
/// its bend g_j; pulses that are not in the row are 0 there. A mode: the twist that its mean known torques hold that do not
/// scale with intake pressure: rad, and rad a w^2 of (rad/s)^2. Gains, as multiples of their scale, 16 bits each: for each
/// set the columns K_0, K_1, K_x[m], K_s with a shape, and K_q, K_v of each mode, all speeds of a column side by side, so that
/// the two that a speed lies between are a pair; then one more and up to a whole word. Behind the rows, for sd_fired.h: for each tooth of
/// a revolution the columns of the parts, times 32767, a word with the entries of both revolutions for each part; `restore`, parts by
/// parts; and for each hidden direction its pattern over the parts, what it reads of the parts and of the firings, the rms of its torque
/// over the firings less their mean over J w^2, the sum of the sizes of what it reads of the firings, and the share of the mean torque that
/// they may be off by as speed and fuel change.
typedef struct sd_kalman_tables {
    uint8_t  positions;    ///< Wheel positions a revolution N, even, 12 to 120. 0: there are no tables.
    uint8_t  coefficients; ///< m, 1 to SD_KALMAN_COEFFICIENTS_MAX, x_0 included.
    uint8_t  speeds;       ///< Gain tables of a set, 1 to SD_KALMAN_SPEEDS_MAX.
    uint8_t  sets;         ///< 1: for smooth roads; 2: for rough ones too.
    uint8_t  firings;      ///< Coefficient 1 + i belongs to firing i; 0 with the Fourier basis. Below m.
    uint8_t  cylinders;    ///< n, 1 to SD_KALMAN_FIRINGS_MAX, in firing order.
    uint8_t  modes;        ///< Up to SD_KALMAN_MODES_MAX; 0 with the Fourier basis.
    uint8_t  shapes;       ///< 1: the pulses have a shape to learn; 0: none, as with the Fourier basis.
    uint8_t  window;       ///< Pulses of a row, below m; m - 1 with the Fourier basis.
    uint8_t  teeth;        ///< Teeth that are there, a revolution, 4 to N.
    uint8_t  parts;        ///< 3 + firings: phase, energy, load and firings; 0: nothing is learned while the engine fires.
    uint8_t  hidden;       ///< Directions of the tooth pattern that look like torque, up to SD_KALMAN_HIDDEN_MAX.
    uint16_t row_words;    ///< Words of a row, as sd_motion_row_words says.
    uint16_t gains_at;     ///< Word of a row where its gains begin, as sd_motion_gains_at says.
    float    tick_hz;          ///< Capture ticks a second, [1e5, 2e8].
    float    pitch_rad;        ///< 2 pi over N, (0, 0.6].
    float    shape_min_nm;     ///< Mean torque of all cylinders below which the shape is not learned, [0, 20000].
    float    inertia_mean_kgm2;///< J_mean, (0, 10].
    sd_kalman_mode_t mode[SD_KALMAN_MODES_MAX];
    float    speed_radps[SD_KALMAN_SPEEDS_MAX]; ///< Of the gain tables, ascending, [1, 2000].
    /// Of K_0, K_1, K_x[0], all other K_x, K_s, and K_q, K_v of each mode; each [0, 1e4].
    float    gain_scale[SD_KALMAN_SETS_MAX][SD_KALMAN_SCALES];
    float    noise_rad[SD_KALMAN_GAINS_MAX];    ///< Of each speed of each set: timing error that the gains were made for, > 0.
    float    expected_rad[SD_KALMAN_GAINS_MAX]; ///< Expected rms of the innovation, at least noise_rad.
    /// Standard deviation of a firing less the mean of all cylinders (of one cylinder, of itself), per rad of timing error, over J_mean
    /// w^2: one firing, errors new at each edge; mean of SD_KALMAN_MEAN cycles, the same; either, errors that stay with a tooth.
    float    single_sd[SD_KALMAN_GAINS_MAX], mean_sd[SD_KALMAN_GAINS_MAX], pattern_sd[SD_KALMAN_GAINS_MAX];
    float    load_sd_nm[SD_KALMAN_GAINS_MAX]; ///< Of a firing, from the load's walk that the gains were made for, >= 0.
    /// Standard deviation of a firing less the mean of all cylinders from what is not known of the engine: share of the mean torque, share
    /// of the cylinders' rms difference from it, and Nm per bar of charge: before and after the cylinder's zero was learned. Each >= 0.
    float    mean_share[SD_KALMAN_GAINS_MAX], spread_share[SD_KALMAN_GAINS_MAX];
    /// The last of these, before and after; >= 0.
    float    charge_nm_per_bar[SD_KALMAN_GAINS_MAX], learned_nm_per_bar[SD_KALMAN_GAINS_MAX];
    sd_kalman_word_t pool[SD_KALMAN_POOL]; ///< Last, so that a page may end where the used part ends.
} sd_kalman_tables_t;

/// Intake pressure, and how it stood when each cylinder's intake valve closed.
typedef struct sd_motion_charge {
    float   intake_bar; ///< Last good one, [0, 10].
    float   charge_bar[SD_KALMAN_FIRINGS_MAX]; ///< Of each cylinder, in firing order.
    float   exponent;   ///< By which compression's exponent is larger than the calibration's, as learned; 0: as the calibration has it.
    float   common_bar; ///< exponent times the mean of charge_bar.
    uint8_t held;       ///< 1: the last intake pressure was no number in range.
} sd_motion_charge_t;

/// What was learned of the crank's modes (sd_twist.h): how much faster they swing than in the tables. To the gains a mode
/// of r times the frequency at r times the speed is what it was, so they are looked up at 1 / r of the speed.
typedef struct sd_motion_tuning {
    float frequency;  ///< r, [0.9, 1.1].
    float gain_speed; ///< 1/r, by which speeds are looked up.
    float compliance; ///< 1 / r^2: the twist that a torque holds, over that of the tables.
} sd_motion_tuning_t;

/// An estimate.
typedef struct sd_motion {
    float lateness_s; ///< When the last tooth was due, after it came.
    float energy_j;   ///< At the last tooth.
    float coefficient_nm[SD_KALMAN_COEFFICIENTS_MAX]; ///< x.
    float twist_rad[SD_KALMAN_MODES_MAX]; ///< q of each mode.
    float swing_rad[SD_KALMAN_MODES_MAX]; ///< v of each mode.
} sd_motion_t;

/// One position, its known torques summed for the charges as they are.
typedef struct sd_motion_row {
    const sd_kalman_word_t *word; ///< Row of the pool.
    float mean_nm, moment_nm;     ///< Known torque over the interval.
    float held_rad[SD_KALMAN_MODES_MAX]; ///< Twist of each mode that it holds.
} sd_motion_row_t;

/// Whether every field is in its range.
bool sd_kalman_tables_ok(const sd_kalman_tables_t *tables);

/// Word of a row where the gains begin, and words of a row, for tables with these sizes.
uint32_t sd_motion_gains_at(const sd_kalman_tables_t *tables);
uint32_t sd_motion_row_words(const sd_kalman_tables_t *tables);

/// Words of a hidden direction.
static inline uint32_t sd_motion_hidden_words(const sd_kalman_tables_t *t) { return 2u * t->parts + t->firings + 3u; }

/// Words of `pool` that such tables use.
uint32_t sd_kalman_pool_used(const sd_kalman_tables_t *tables);

/// Gains of one speed of one set.
static inline uint32_t sd_motion_columns(const sd_kalman_tables_t *t) { return t->coefficients + 2u + t->shapes + 2u * t->modes; }

/// Row of cycle position k, below 2 N.
static inline const sd_kalman_word_t *sd_motion_word(const sd_kalman_tables_t *t, uint32_t k) { return &t->pool[k * t->row_words]; }

/// Whether the wheel has a tooth at a position.
static inline bool sd_kalman_has_tooth(const sd_kalman_tables_t *t, uint32_t k) { return sd_motion_word(t, k)[SD_ROW_AT].at.tooth != 0u; }

/// Energy below which the crank counts as standing, J: that of 5 rad/s.
static inline float sd_motion_energy_min(const sd_kalman_tables_t *t) { return 12.5f * t->inertia_mean_kgm2; }

/// Takes this for the intake pressure of every cylinder.
void sd_motion_fill(sd_motion_charge_t *charge, float intake_bar);

/// Takes a learned `exponent`, for the torque that all cylinders have in common.
void sd_motion_set_exponent(sd_motion_charge_t *charge, const sd_kalman_tables_t *tables, float exponent);

/// Takes an intake pressure; anything but [0, 10], NaN included, is held off.
static inline void sd_motion_take_intake(sd_motion_charge_t *charge, float intake_bar) {
    const bool good = sd_within(intake_bar, 0.0f, 10.0f);
    charge->held = good ? (uint8_t)0 : (uint8_t)1;
    if (good) { charge->intake_bar = intake_bar; }
}

/// The cylinders whose intake valve closes at a row keep the pressure.
void sd_motion_close_valves(sd_motion_charge_t *charge, const sd_kalman_tables_t *tables, const sd_kalman_word_t *word);

/// Sums the known torque of the interval that ends at cycle position k.
void sd_motion_known(const sd_kalman_tables_t *t, uint32_t k, const sd_motion_charge_t *charge, sd_motion_row_t *row);

/// Moves an estimate over an interval. `shape` bends its pulses. False when the crank would stand still in it.
bool sd_motion_predict(sd_motion_t *self, const sd_kalman_tables_t *t, const sd_motion_row_t *row, float shape,
                       const sd_motion_tuning_t *tuning);

/// How far the modes have the wheel ahead of the rigid crank at a tooth, rad, at a speed w of the rigid crank, rad/s: a wheel twisted
/// ahead by q and turning faster by q' comes q / (w + q') early. 0 without modes.
float sd_motion_ahead(const sd_motion_t *self, const sd_kalman_tables_t *t, float speed, const sd_motion_tuning_t *tuning);

/// Lateness of the last tooth against the prediction, rad, its own error not taken out. speed: of the rigid crank there, rad/s.
static inline float sd_motion_late(const sd_motion_t *self, const sd_kalman_tables_t *t, float speed, const sd_motion_tuning_t *tuning) {
    const float ahead = (t->modes != 0u) ? sd_motion_ahead(self, t, speed, tuning) : 0.0f;
    return ahead - self->lateness_s * speed;
}

/// Torque at tooth k, Nm, with what a dual-mass flywheel's spring takes away; known_nm is what is motored of it.
float sd_motion_torque(const sd_motion_t *self, const sd_kalman_tables_t *t, uint32_t k, float known_nm, float shape,
                       const sd_motion_tuning_t *tuning);

#ifdef __cplusplus
}
#endif

#endif
