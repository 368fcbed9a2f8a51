/* SPDX-License-Identifier: MIT */
/// sd_ecu_parts.h - what the files of the ecu share; no part of its interface.
#ifndef SD_ECU_PARTS_H
#define SD_ECU_PARTS_H
#include "sd_ecu.h"

#ifdef __cplusplus
extern "C" {
#endif

/// Sends all signals of a rate, each with its owner's health.
void sd_ecu_publish(sd_ecu_t *self, const sd_port_t *port, uint32_t tick, sd_rate_t rate);
/// Health becomes no better than this; reasons add up.
void sd_ecu_worst_of(sd_status_t *status, uint8_t health, uint16_t why);

/// The angle was lost or moved: the filter begins anew.
void sd_ecu_firing_restart(sd_ecu_t *self);
/// An edge that stands for no tooth was seen. Which of two near each other is the tooth may have been decided wrongly.
void sd_ecu_firing_spurious(sd_ecu_t *self);
/// Filter, pattern learning and firing signals, for a placed tooth.
void sd_ecu_firing_tooth(sd_ecu_t *self, const sd_port_t *port, const sd_tooth_t *tooth);

/// Reads or changes a parameter and sends the answer.
void sd_ecu_parameter(sd_ecu_t *self, const sd_port_t *port, const sd_event_t *request);

/// What the block of single firings is configured with.
sd_firings_config_t sd_ecu_firings_config(const sd_calibration_t *calibration);

/// Latest reading of a sensor that spoke lately; NULL when it did not.
const sd_sample_t *sd_ecu_recent(const sd_ecu_t *self, sd_input_t input, uint32_t tick);

/// Keeps the fuel that each firing was commanded.
void sd_ecu_misfire_tooth(sd_ecu_t *self, const sd_tooth_t *tooth);
/// Judges the firing that was completed at `tick` and sets its signals.
void sd_ecu_misfire_firing(sd_ecu_t *self, const sd_firings_out_t *out, uint32_t tick);

#ifdef __cplusplus
}
#endif

#endif
