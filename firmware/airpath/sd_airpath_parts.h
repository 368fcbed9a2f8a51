/* SPDX-License-Identifier: MIT */
/* What the bodies of this folder share. N is set by the including file. */
#ifndef SD_AIRPATH_PARTS_H
#define SD_AIRPATH_PARTS_H

#define JOIN_(a, b) a##_##b
#define JOIN(a, b)  JOIN_(a, b)
#define F(name)     JOIN(name, N) /* F(sd_mul) -> sd_mul_f32 */
#define ONE         JOIN(SD_ONE, N)
#define CONSTANT_(n, x, bits) SD_CONSTANT_##n(x, bits)
#define CONSTANT_OF(n, x, bits) CONSTANT_(n, x, bits)
#define CONSTANT(x, bits) CONSTANT_OF(N, x, bits) /* in q31 per unit of 2^bits */
#define SMALL_(n, x, bits) SD_SMALL_##n(x, bits)
#define SMALL_OF(n, x, bits) SMALL_(n, x, bits)
#define SMALL(x, bits) SMALL_OF(N, x, bits)          /* of 2^-bits */
#define R(name)     JOIN(sd_real_##name, N)          /* numbers of any size: sd_num.h */

#endif
