/* SPDX-License-Identifier: MIT */
/// sd_role.h - which side of a bus this is; it decides what is sent and what is listened to.
#ifndef SD_ROLE_H
#define SD_ROLE_H

#ifdef __cplusplus
extern "C" {
#endif

/// The sides of a bus.
typedef enum sd_role {
    SD_ROLE_ECU,   ///< Sends signals, never sees truth.
    SD_ROLE_PLANT, ///< Sends events and truth.
    SD_ROLE_TOOL,  ///< Sends parameter requests; listens to what the ecu says and to truth.
} sd_role_t;

#ifdef __cplusplus
}
#endif

#endif
