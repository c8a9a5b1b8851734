/* The samples of a rough mirror, four at a time: to the bit those of the feature, for runs of any
 * length. */
#include "test.h"

#include "base/random.h"
#include "render/glossy_run.h"

#include <string.h>

static float number(uint32_t i, uint32_t axis)
{
    return rk_unit_float(rk_hash(i, axis, 0, 3));
}

static rk_vec3 unit_vector(uint32_t i)
{
    return rk_normalize(rk_vec(number(i, 0) - 0.5f, number(i, 1) - 0.5f, number(i, 2) - 0.5f));
}

static void fill(rk_glossy_run *run, uint32_t key)
{
    memset(run, 0, sizeof *run);
    for (uint32_t i = 0; i < RK_GLOSSY_RUN_MAX; i++) {
        run->x[i] = number(key + i, 4);
        run->y[i] = number(key + i, 5);
    }
}

static void check_points(const rk_glossy_run *got, const rk_glossy_run *from, rk_disk_map map,
                         uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const rk_vec2 at = rk_disk_at(map, (rk_vec2){from->x[i], from->y[i]});
        rk_check(memcmp(&at.x, &got->x[i], sizeof at.x) == 0 &&
                     memcmp(&at.y, &got->y[i], sizeof at.y) == 0,
                 "point %u of %u differs from rk_disk_at's", i, count);
    }
}

static uint32_t check_directions(const rk_glossy_run *got, const rk_glossy_disk *disk,
                                 uint32_t count)
{
    uint32_t below = 0;
    for (uint32_t i = 0; i < count; i++) {
        rk_vec3 d;
        const bool above = rk_glossy_direction(disk, (rk_vec2){got->x[i], got->y[i]}, &d);
        rk_check(memcmp(&d.x, &got->direction_x[i], sizeof d.x) == 0 &&
                     memcmp(&d.y, &got->direction_y[i], sizeof d.y) == 0 &&
                     memcmp(&d.z, &got->direction_z[i], sizeof d.z) == 0,
                 "direction %u of %u differs from rk_glossy_direction's", i, count);
        rk_check((got->is_above[i] > 0) == above, "direction %u of %u is on the other side", i,
                 count);
        below += !above;
    }
    return below;
}

static void runs_are_the_features_to_the_bit(void **state)
{
    uint32_t below = 0, all = 0;
    (void)state;
    for (uint32_t k = 0; k < 400; k++) {
        const uint32_t count = 1 + k % RK_GLOSSY_RUN_MAX;
        const rk_disk_map map = k % 3 == 0 ? RK_DISK_POLAR : RK_DISK_CONCENTRIC;
        const rk_glossy_disk disk =
            rk_glossy_disk_of(unit_vector(2 * k), number(k, 6), unit_vector(2 * k + 1));
        rk_glossy_run from, run;
        fill(&from, 1000 * k);
        run = from;
        rk_glossy_run_map(&run, map, count, k % 2 == 0);
        check_points(&run, &from, map, count);
        rk_glossy_run_aim(&run, &disk, count, k % 2 == 0);
        below += check_directions(&run, &disk, count);
        all += count;
    }
    rk_check(below > 1000 && all - below > 1000, "%u of %u are below: both should happen", below,
             all);
}

static void equal_runs_are_taken_for_equal(void **state)
{
    (void)state;
    rk_check(rk_glossy_run_agrees(), "the feature is asked one direction after the other");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(runs_are_the_features_to_the_bit),
    cmocka_unit_test(equal_runs_are_taken_for_equal),
};

RK_SUITE("glossy_run", tests)
