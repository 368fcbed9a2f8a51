/* SPDX-License-Identifier: MIT */
/// sd_limits.h - how much this build can hold. Limits that several blocks share stand here and nowhere else.
#ifndef SD_LIMITS_H
#define SD_LIMITS_H

#ifdef __cplusplus
extern "C" {
#endif

/// Largest number of cylinders of an engine. A build option (-DSD_CYLINDERS_MAX=4): arrays of a cylinder each are that long,
/// and an init refuses an engine that has more.
#ifndef SD_CYLINDERS_MAX
#define SD_CYLINDERS_MAX 8
#endif
#if (SD_CYLINDERS_MAX != 4) && (SD_CYLINDERS_MAX != 8)
#error "SD_CYLINDERS_MAX is 4 or 8"
#endif

#ifdef __cplusplus
}
#endif

#endif
