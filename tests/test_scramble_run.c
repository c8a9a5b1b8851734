/* Many scrambled numbers at once are those of base/scramble.h, with every instruction set. */
#include "test.h"

#include "base/random.h"
#include "base/scramble.h"
#include "base/scramble_run.h"

enum { most = 64 };

static void check(uint32_t count, const uint32_t *bits, const uint32_t *keys, const float *numbers)
{
    for (uint32_t i = 0; i < count; i++) {
        const float want = rk_unit_float(rk_reverse_bits(rk_scramble_reversed(bits[i], keys[i])));
        rk_check(numbers[i] == want, "number %u of %u, of %#x with key %#x, is %.9g, not %.9g", i,
                 count, bits[i], keys[i], (double)numbers[i], (double)want);
    }
}

static void runs_are_single_numbers_to_the_bit(void **state)
{
    (void)state;
    for (uint32_t round = 0; round < 1000; round++) {
        const uint32_t count = round % (most + 1);
        uint32_t bits[most], keys[most];
        float numbers[most];
        for (uint32_t i = 0; i < most; i++) {
            bits[i] = round % 3 == 0 ? i : rk_hash(round, i, 0, 0);
            keys[i] = round % 5 == 0 ? 0u - i : rk_hash(round, i, 1, 0);
        }
        rk_scramble_run_plain(count, bits, keys, numbers);
        check(count, bits, keys, numbers);
        rk_scramble_run(count, bits, keys, numbers);
        check(count, bits, keys, numbers);
        if (rk_scramble_run_avx2(count, bits, keys, numbers))
            check(count, bits, keys, numbers);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(runs_are_single_numbers_to_the_bit),
};

RK_SUITE("scramble_run", tests)
