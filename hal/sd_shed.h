/* SPDX-License-Identifier: MIT */
/// sd_shed.h - what an ecu leaves out while teeth come faster than it can handle them, in this order.
///
/// What is left out says so: its owners' health has SD_WHY_OVERLOAD. The decoder (angle, speed), the torque by the Fourier observer and
/// the clock are never left out.
#ifndef SD_SHED_H
#define SD_SHED_H

#ifdef __cplusplus
extern "C" {
#endif

/// value of SD_EVENT_LATE. Each level leaves out what the ones before it do, too.
typedef enum sd_shed {
    SD_SHED_NONE    = 0, ///< Everything is done.
    SD_SHED_CYCLE   = 1, ///< No work of a cycle's end is begun: torque of cylinders, mixture's readings, misfire rates; trims stay as they
                         ///< are. A cycle's row is still said, so that its health tells.
    SD_SHED_MIXTURE = 2, ///< The mixture does not follow the teeth, and starts afresh afterwards.
    SD_SHED_FIRINGS = 3, ///< Single firings and misfires are not followed, and start afresh afterwards.
    SD_SHED_MOST    = SD_SHED_FIRINGS, ///< The last level.
} sd_shed_t;

#ifdef __cplusplus
}
#endif

#endif
