/* Many scrambled numbers at once; not installed. */
#ifndef RK_BASE_SCRAMBLE_RUN_H
#define RK_BASE_SCRAMBLE_RUN_H

#include <stdbool.h>
#include <stdint.h>

/* Runs are read and written in whole eights: arrays have a multiple of 8 numbers, those beyond
 * `count` may be anything. */
enum { RK_SCRAMBLE_EIGHT = 8 };

/* numbers[i] is rk_unit_float(rk_reverse_bits(rk_scramble_reversed(bits[i], keys[i]))). */
void rk_scramble_run(uint32_t count, const uint32_t *bits, const uint32_t *keys, float *numbers);

/* The same without AVX2, and with it; false if the machine or the compiler does not have it. */
void rk_scramble_run_plain(uint32_t count, const uint32_t *bits, const uint32_t *keys,
                           float *numbers);
bool rk_scramble_run_avx2(uint32_t count, const uint32_t *bits, const uint32_t *keys,
                          float *numbers);

#endif
