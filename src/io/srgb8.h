/* From linear light to the 8 bits that picture files store, exactly rounded and without a power
 * function per pixel: the 255 steps of the rounded value are computed once, in double, and a table
 * of 4096 equal intervals gives the number of steps below each. */
#ifndef RK_IO_SRGB8_H
#define RK_IO_SRGB8_H

#include <stdint.h>

/* The two closest steps, on the linear foot of the curve, are 1 / (12.92 * 255) = 1 / 3294.6 apart:
 * an interval of 1 / 4096 contains at most one. */
enum { RK_SRGB8_INTERVALS = 4096 };

typedef struct rk_srgb8 {
    float step[256 + 1];                   /* value k begins at step[k]; step[256] is infinite */
    uint8_t below[RK_SRGB8_INTERVALS + 1]; /* the value at the lower end of each interval */
} rk_srgb8;

void rk_srgb8_init(rk_srgb8 *table);

/* Returns 255 times the sRGB encoding of `linear`, rounded to nearest; values outside [0, 1] are
 * clamped, and NaN gives 0. */
static inline uint8_t rk_srgb8_encode(const rk_srgb8 *table, float linear)
{
    float v = linear > 0 ? (linear < 1 ? linear : 1) : 0;
    unsigned value = table->below[(unsigned)(v * RK_SRGB8_INTERVALS)];
    return (uint8_t)(value + (v >= table->step[value + 1]));
}

#endif
