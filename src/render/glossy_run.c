/* The feature's formula once more, in four lanes. It is used only if examples give the same numbers
 * to the bit, so that a student's function that differs draws its own picture. */
#include "render/glossy_run.h"

#include "base/random.h"
#include "base/simd4.h"
#include "render/disk_run.h"

#include <string.h>

_Static_assert((int)RK_GLOSSY_RUN_MAX <= (int)RK_DISK_RUN_MAX, "one run of points fits the other");

/* --- One at a time ---------------------------------------------------------------------------- */

static void map_each(rk_glossy_run *run, rk_disk_map map, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const rk_vec2 at = rk_disk_at(map, (rk_vec2){run->x[i], run->y[i]});
        run->x[i] = at.x;
        run->y[i] = at.y;
    }
}

static void aim_each(rk_glossy_run *run, const rk_glossy_disk *disk, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        rk_vec3 direction;
        run->is_above[i] =
            rk_glossy_direction(disk, (rk_vec2){run->x[i], run->y[i]}, &direction) ? 1 : 0;
        run->direction_x[i] = direction.x;
        run->direction_y[i] = direction.y;
        run->direction_z[i] = direction.z;
    }
}

/* --- Four at a time --------------------------------------------------------------------------- */

static inline rk_simd4x3 madd(rk_simd4x3 a, rk_vec3 b, rk_simd4 s)
{
    return (rk_simd4x3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

static void aim_fours(rk_glossy_run *run, const rk_glossy_disk *disk, uint32_t count)
{
    const rk_glossy_disk own = *disk; /* which the run's stores cannot change */
    const rk_simd4 one = rk_simd4_all(1), zero = rk_simd4_all(0);
    for (uint32_t i = 0; i < count; i += RK_SIMD4_WIDTH) {
        const rk_simd4 x = own.radius * rk_simd4_load(&run->x[i]);
        const rk_simd4 y = own.radius * rk_simd4_load(&run->y[i]);
        const rk_simd4x3 to = madd(madd(rk_simd4x3_all(own.w), own.u, x), own.v, y);
        const rk_simd4x3 d = rk_simd4x3_scale(to, one / rk_simd4_sqrt(one + x * x + y * y));
        const rk_simd4 slope = rk_simd4x3_dot(d, rk_simd4x3_all(own.face_normal));
        rk_simd4_store(&run->direction_x[i], d.x);
        rk_simd4_store(&run->direction_y[i], d.y);
        rk_simd4_store(&run->direction_z[i], d.z);
        rk_simd4_store(&run->is_above[i], rk_simd4_select(slope > zero, one, zero));
    }
}

void rk_glossy_run_map(rk_glossy_run *run, rk_disk_map map, uint32_t count, bool agrees)
{
    if (agrees && map == RK_DISK_CONCENTRIC)
        rk_disk_run(count, run->x, run->y);
    else
        map_each(run, map, count);
}

void rk_glossy_run_aim(rk_glossy_run *run, const rk_glossy_disk *disk, uint32_t count, bool agrees)
{
    if (agrees)
        aim_fours(run, disk, count);
    else
        aim_each(run, disk, count);
}

/* --- Are they the features'? ------------------------------------------------------------------ */

static float number(uint32_t i, uint32_t axis)
{
    return 2 * rk_unit_float(rk_hash(i, axis, 0, 0)) - 1;
}

static rk_vec3 unit_vector(uint32_t key)
{
    const rk_vec3 v = rk_vec(number(key, 0), number(key, 1), number(key, 2));
    return rk_dot(v, v) > 0 ? rk_normalize(v) : rk_vec(0, 0, 1);
}

/* A disk whose directions are mostly above the surface. */
static rk_glossy_disk example_disk(uint32_t i)
{
    const rk_vec3 reflected = unit_vector(2 * i), normal = unit_vector(2 * i + 1);
    const float radius = 1 / (float)(1 + i);
    return rk_glossy_disk_of(reflected, radius,
                             rk_dot(normal, reflected) < 0 ? rk_negate(normal) : normal);
}

static bool disk_agrees(const rk_glossy_disk *disk, uint32_t key)
{
    rk_glossy_run fours, each;
    for (uint32_t i = 0; i < RK_GLOSSY_RUN_MAX; i++) {
        fours.x[i] = each.x[i] = rk_unit_float(rk_hash(key, i, 0, 1));
        fours.y[i] = each.y[i] = rk_unit_float(rk_hash(key, i, 1, 1));
    }
    rk_disk_run(RK_GLOSSY_RUN_MAX, fours.x, fours.y);
    aim_fours(&fours, disk, RK_GLOSSY_RUN_MAX);
    map_each(&each, RK_DISK_CONCENTRIC, RK_GLOSSY_RUN_MAX);
    aim_each(&each, disk, RK_GLOSSY_RUN_MAX);
    return memcmp(&fours, &each, sizeof each) == 0;
}

bool rk_glossy_run_agrees(void)
{
    enum { examples = 8 };
    for (uint32_t i = 0; i < examples; i++) {
        const rk_glossy_disk disk = example_disk(i);
        if (!disk_agrees(&disk, i))
            return false;
    }
    return true;
}
