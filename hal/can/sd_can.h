/* SPDX-License-Identifier: MIT */
/// sd_can.h - the CAN port: SocketCAN, CAN FD, frames as sixdeg.dbc says.
///
/// It needs an interface of mtu 72 that is up (`ip link set vcan0 mtu 72 up`). Nothing here blocks but sd_can_wait. An
/// interface that goes down and up again only costs frames. Edges travel in frames of 14, the rest of them when the
/// clock event comes, so a port is as late as the clock events are apart.
#ifndef SD_CAN_H
#define SD_CAN_H
#include "sd_can_codec.h"

#ifdef __cplusplus
extern "C" {
#endif

/// The port on one interface. Caller-owned.
typedef struct sd_can {
    int fd;
    sd_can_codec_t codec;
} sd_can_t;

/// 0, or an errno: ENODEV no such interface, EMSGSIZE its mtu is below 72, else what the system said.
int  sd_can_open(sd_can_t *self, const char *interface, sd_role_t role, uint16_t session);
void sd_can_close(sd_can_t *self);
/// The stream of events. send takes what there is room for; what the bus will not have waits for the next call.
sd_port_t sd_can_port(sd_can_t *self);
/// Waits until a frame comes, at most so long. 1: one is there.
int  sd_can_wait(sd_can_t *self, int milliseconds);
/// Sends waiting frames. 1: none is left.
int  sd_can_flush(sd_can_t *self);
/// Reads frames until one brings truth (1; codec.truth holds it) or none is left, or a few thousand are read (0). For a tool: its receive
/// only
/// hands out what this has read.
int  sd_can_read(sd_can_t *self);

#ifdef __cplusplus
}
#endif

#endif
