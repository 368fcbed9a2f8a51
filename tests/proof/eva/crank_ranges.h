/* SPDX-License-Identifier: MIT */
/// crank_ranges.h - in which ranges the decoder's state and the numbers of its wheel are: crank_init.c shows that init leaves them so, and
/// crank.c that every call does. Numbers of marks that a wheel does not have are 0.
#ifndef SD_PROOF_CRANK_RANGES_H
#define SD_PROOF_CRANK_RANGES_H
#include "any.h"
#include "sd_crank_parts.h"

enum { TEETH_LEAST = 6, TEETH_MOST = 119 };
enum { LATE_MOST = 16 * ONE, WIDTH_MOST = (45 * ONE) / 10, WAY_MOST = 9 * WIDTH_MOST };
enum { TURN_LEAST = 2 * ONE, TURN_MOST = 140 * ONE };

#endif
