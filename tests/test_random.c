/* Random numbers: fixed, uniform, and independent wherever they are used. Seeds are fixed, so these
 * tests always give the same result; a truly random generator would exceed their limits once in a
 * million times (z = 4.75), so a failure means a broken generator. */
#include "test.h"

#include "base/sampler.h"

static const double z_limit = 4.75;

static void the_hash_is_the_published_one(void **state)
{
    (void)state;
    /* Computed from the paper's formula, independently of this code: pictures depend on these
     * bits. */
    rk_check_equal(rk_hash(0, 0, 0, 0), 0xdc27b0c3, "pcg4d of zeros");
    rk_check_equal(rk_hash(1, 2, 3, 4), 0x349b8139, "pcg4d of 1, 2, 3, 4");
    rk_check_equal(rk_hash(UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX), 0x36f57a9a,
                   "pcg4d of all ones");
}

static void unit_floats_cover_0_to_1_evenly_and_never_are_1(void **state)
{
    (void)state;
    rk_check_close(rk_unit_float(0), 0, 0, "the smallest");
    rk_check_close(rk_unit_float(UINT32_MAX), 1 - 0x1p-24, 0, "the largest is below 1");
    rk_check_close(rk_unit_float(1u << 31), 0.5, 0, "the middle");
    for (uint32_t i = 0; i < 1u << 16; i++) {
        uint32_t step = rk_hash(i, 0, 0, 0) >> 8;
        rk_check_close(rk_unit_float(step << 8), step * 0x1p-24, 0, "a multiple of 2^-24");
        rk_check_close(rk_unit_float(step << 8 | 255), step * 0x1p-24, 0,
                       "low bits do not round up");
    }
}

/* How often a bit of the hash changes with a bit of an argument, of 1,024 times. */
static unsigned changes_of(int bit, int argument, int by)
{
    unsigned changes = 0;
    for (uint32_t i = 0; i < 1024; i++) {
        uint32_t of[4] = {i * 2654435761u, ~i, i << 16 ^ 77, i * 40503};
        uint32_t before = rk_hash(of[0], of[1], of[2], of[3]);
        of[argument] ^= 1u << by;
        changes += (before ^ rk_hash(of[0], of[1], of[2], of[3])) >> bit & 1;
    }
    return changes;
}

static void the_upper_half_of_the_hash_depends_on_all_bits(void **state)
{
    (void)state;
    for (int bit = 0; bit < 32; bit++)
        for (int argument = 0; argument < 4; argument++)
            for (int by = 0; by < 32; by++) {
                unsigned changes = changes_of(bit, argument, by);
                if (bit < 16)
                    rk_check(by <= bit + 16 || changes == 0,
                             "bit %d changes with bit %d of argument %d: random.h says never", bit,
                             by, argument);
                else
                    rk_check(changes > 256 && changes < 768,
                             "bit %d changes with bit %d of argument %d in %u of 1024 cases", bit,
                             by, argument, changes);
            }
}

/* --- one number ------------------------------------------------------------------------------ */

enum { draws = 1 << 16, bins = 64, side = 16 };

/* The four coordinates of a hash; one of them counts up, the others stay. */
typedef struct place {
    uint32_t seed, pixel, sample, dimension;
} place;

static float draw(place p)
{
    rk_sampler sampler = {.kind = RK_SAMPLER_UNIFORM, .seed = p.seed};
    return rk_sample_1d(&sampler, p.pixel, p.sample, p.dimension);
}

static place step(place p, int coordinate, uint32_t by)
{
    uint32_t *const coordinates[] = {&p.seed, &p.pixel, &p.sample, &p.dimension};
    *coordinates[coordinate] += by;
    return p;
}

static const char *const coordinate_names[] = {"seed", "pixel", "sample", "dimension"};

/* Chi-squared as a normal deviate (Wilson and Hilferty, "The distribution of chi-square", 1931). */
static double deviate(const unsigned *counts, int cells)
{
    double want = (double)draws / cells, chi = 0, f = cells - 1;
    for (int i = 0; i < cells; i++)
        chi += (counts[i] - want) * (counts[i] - want) / want;
    return (cbrt(chi / f) - (1 - 2 / (9 * f))) / sqrt(2 / (9 * f));
}

static void mean_and_variance_are_those_of_the_uniform_distribution(void **state)
{
    (void)state;
    for (int coordinate = 0; coordinate < 4; coordinate++) {
        double sum = 0, squares = 0;
        for (uint32_t i = 0; i < draws; i++) {
            double x = (double)draw(step((place){1, 2, 3, 4}, coordinate, i)) - 0.5;
            sum += x, squares += x * x;
        }
        rk_check_close(sum / draws, 0, z_limit * sqrt(1.0 / 12 / draws), "4.75 standard errors");
        /* The variance of x^2 is 1/80 - 1/144 = 1/180. */
        rk_check_close(squares / draws, 1.0 / 12, z_limit * sqrt(1.0 / 180 / draws),
                       "4.75 standard errors");
    }
}

static void each_coordinate_alone_gives_uniform_numbers(void **state)
{
    (void)state;
    for (int coordinate = 0; coordinate < 4; coordinate++)
        for (uint32_t stride = 1; stride <= 1 << 16; stride *= 16) {
            unsigned counts[bins] = {0};
            for (uint32_t i = 0; i < draws; i++)
                counts[(int)(draw(step((place){0, 0, 0, 0}, coordinate, i * stride)) * bins)]++;
            rk_check_close(deviate(counts, bins), 0, z_limit, coordinate_names[coordinate]);
        }
}

static void the_lowest_bits_are_uniform_too(void **state)
{
    (void)state;
    for (int coordinate = 0; coordinate < 4; coordinate++) {
        unsigned counts[bins] = {0};
        for (uint32_t i = 0; i < draws; i++) {
            float fine = draw(step((place){0, 0, 0, 0}, coordinate, i)) * 0x1p18f;
            counts[(int)((fine - floorf(fine)) * bins)]++;
        }
        rk_check_close(deviate(counts, bins), 0, z_limit, coordinate_names[coordinate]);
    }
}

/* --- two numbers ----------------------------------------------------------------------------- */

/* Fills the square with the pairs (draw at p, draw at p + the offset), p along `along`. */
static double pair_deviate(int along, int offset_coordinate, uint32_t offset)
{
    unsigned counts[side * side] = {0};
    for (uint32_t i = 0; i < draws; i++) {
        place p = step((place){5, 6, 7, 8}, along, i);
        int x = (int)(draw(p) * side), y = (int)(draw(step(p, offset_coordinate, offset)) * side);
        counts[y * side + x]++;
    }
    return deviate(counts, side * side);
}

static void neighbours_in_every_coordinate_are_unrelated(void **state)
{
    (void)state;
    const uint32_t offsets[] = {1, 3, 800, 1u << 16, 1u << 31};
    for (int along = 0; along < 4; along++)
        for (int coordinate = 0; coordinate < 4; coordinate++)
            for (int k = 0; k < 5; k++) {
                char hint[80];
                snprintf(hint, sizeof hint, "along %s, %u apart in %s", coordinate_names[along],
                         offsets[k], coordinate_names[coordinate]);
                rk_check_close(pair_deviate(along, coordinate, offsets[k]), 0, z_limit, hint);
            }
}

static int compare_numbers(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

static void the_four_coordinates_are_not_interchangeable(void **state)
{
    (void)state;
    /* 16^4 combinations give 65,536 numbers; with 2^24 values, 128 coincidences are expected, with
     * a standard deviation of their root. */
    static float numbers[draws];
    for (uint32_t i = 0; i < draws; i++)
        numbers[i] = draw((place){i & 15, i >> 4 & 15, i >> 8 & 15, i >> 12});
    qsort(numbers, draws, sizeof *numbers, compare_numbers);
    unsigned coincidences = 0;
    for (uint32_t i = 1; i < draws; i++)
        coincidences += numbers[i] == numbers[i - 1];
    rk_check_close(coincidences, 128, z_limit * sqrt(128), "pairs of places with the same number");
}

/* --- the sampler ----------------------------------------------------------------------------- */

static void a_pair_of_numbers_is_its_two_dimensions(void **state)
{
    (void)state;
    rk_sampler sampler = {.kind = RK_SAMPLER_UNIFORM, .seed = 9};
    for (uint32_t i = 0; i < 100; i++) {
        rk_vec2 pair = rk_sample_2d(&sampler, i, 3 * i, 2 * i);
        rk_check_close(pair.x, rk_sample_1d(&sampler, i, 3 * i, 2 * i), 0, "the first dimension");
        rk_check_close(pair.y, rk_sample_1d(&sampler, i, 3 * i, 2 * i + 1), 0,
                       "the second dimension");
    }
}

static void the_same_place_gives_the_same_number(void **state)
{
    (void)state;
    float first = draw((place){1, 2, 3, 4});
    draw((place){4, 3, 2, 1});
    rk_check_close(draw((place){1, 2, 3, 4}), first, 0, "there is no hidden state");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_hash_is_the_published_one),
    cmocka_unit_test(the_upper_half_of_the_hash_depends_on_all_bits),
    cmocka_unit_test(unit_floats_cover_0_to_1_evenly_and_never_are_1),
    cmocka_unit_test(a_pair_of_numbers_is_its_two_dimensions),
    cmocka_unit_test(the_same_place_gives_the_same_number),
    cmocka_unit_test(mean_and_variance_are_those_of_the_uniform_distribution),
    cmocka_unit_test(each_coordinate_alone_gives_uniform_numbers),
    cmocka_unit_test(the_lowest_bits_are_uniform_too),
    cmocka_unit_test(neighbours_in_every_coordinate_are_unrelated),
    cmocka_unit_test(the_four_coordinates_are_not_interchangeable),
};

RK_SUITE("random", tests)
