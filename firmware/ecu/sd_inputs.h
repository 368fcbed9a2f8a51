/* SPDX-License-Identifier: MIT */
/// sd_inputs.h - the sampled sensors and commands that the ecu is given: latest reading, its age, and what stands in for it.
///
/// Each row of hal/signals.toml says how long a reading counts (age) and which usual value stands in before the first reading
/// and after the last one has grown too old. Each owner of signals says there which inputs it is degraded or invalid
/// without; sd_inputs_judge brings that into its status, so that no block can forget it.
///
/// Real-time contract: no heap, no globals; take is constant, age and judge pass over the inputs. One writer per state.
#ifndef SD_INPUTS_H
#define SD_INPUTS_H
#include <stdbool.h>

#include "sd_signals.h"
#include "sd_status.h"

#ifdef __cplusplus
extern "C" {
#endif
/// A reading as it came last.
typedef struct sd_reading {
    float    value; ///< In the unit and within the range of sd_input_infos; 0 before the first one.
    uint32_t tick;  ///< When it was taken, capture ticks.
} sd_reading_t;

/// All zero is a valid start: nothing was read.
typedef struct sd_inputs {
    sd_reading_t reading[SD_INPUT_COUNT]; ///< By sd_input_t.
    uint32_t seen;     ///< Bit i: input i was read since init.
    uint32_t fresh;    ///< Bit i: its last reading is not older than its age limit.
    uint32_t rejected; ///< Samples of an unknown sensor, out of range or NaN: ignored and counted, wraps.
} sd_inputs_t;

/// Takes a sample. False, and counted, when it is of no known input or `value`, in the unit of its signal, is out of its range; the last
/// reading then stands.
bool sd_inputs_take(sd_inputs_t *self, uint16_t channel, uint32_t tick, float value);

/// Compares every reading's age with its limit. Call it every 10 ms: between two calls a reading ages by no more than that.
void sd_inputs_age(sd_inputs_t *self, uint32_t tick, float tick_hz);

/// Whether the input was read within its age limit.
static inline bool sd_inputs_fresh(const sd_inputs_t *self, sd_input_t input) { return ((self->fresh >> (uint32_t)input) & 1u) != 0u; }

/// The reading, in the unit of its signal, while it is fresh, otherwise the usual value of the table.
static inline float sd_inputs_value(const sd_inputs_t *self, sd_input_t input) {
    return sd_inputs_fresh(self, input) ? self->reading[input].value : sd_input_infos[input].usual;
}

/// The reading, in the unit of its signal, while it is fresh, otherwise 0: for what is as it was calibrated where nobody measures it.
static inline float sd_inputs_value_or_0(const sd_inputs_t *self, sd_input_t input) {
    return sd_inputs_fresh(self, input) ? self->reading[input].value : 0.0f;
}

/// Whether the input was read once and has grown too old since.
static inline bool sd_inputs_fell_silent(const sd_inputs_t *self, sd_input_t input) {
    return (((self->seen & ~self->fresh) >> (uint32_t)input) & 1u) != 0u;
}

/// Makes a status no better than the owner may be without the inputs that are not fresh, and says why: SD_WHY_NO_INPUT for one
/// that was never read, SD_WHY_STALE_INPUT for one that has grown too old.
void sd_inputs_judge(const sd_inputs_t *self, sd_owner_t owner, sd_status_t *status);

#ifdef __cplusplus
}
#endif
#endif
