/* Rays aimed at the edges and corners of closed balls from inside, through trees of boxes, one in
 * four by every traversal: at scales from 1e-30 to 1e30, and up to a million radii from the origin,
 * where floats are coarse and balls angular, but closed. Integers know which triangles a ray hits.
 * RAYKIT_STRESS is the factor over make check, which aims 200,000 rays; make stress aims 100 times
 * as many, and 500 are 100 million. */
#include "../test.h"

#include "../closed_mesh.h"
#include "../test_scene.h"
#include "accel/kernel/wide_kernel.h"
#include "accel/query/crossings.h"
#include "features/bvh_median.h"
#include "features/wide_bvh.h"

enum {
    rows_max = 16,
    triangles_max = 8 * rows_max * rows_max,
    groups_per_ball = 2500,
    group_size = 8, /* rays from one point, at one triangle */
};

static uint32_t ball_count(void)
{
    const char *factor = getenv("RAYKIT_STRESS");
    return 10 * (uint32_t)(factor ? strtoul(factor, NULL, 10) : 1);
}

typedef struct ball {
    uint32_t count;
    int exponent;
    whole3 centre, triangles[triangles_max][3];
} ball;

static int64_t to_float(int64_t x)
{
    return (int64_t)(float)x;
}

static whole3 snap(whole3 a)
{
    return whole_of(to_float(a.x), to_float(a.y), to_float(a.z));
}

static const double radius = 0x1p22;

/* A whole number from low to high. */
static int between(int low, int high, uint32_t key, uint32_t dimension)
{
    return low + (int)(rk_hash(key, 0, dimension, 1) % (uint32_t)(high - low + 1));
}

/* Every third ball is around the origin, others lie up to a million radii away. Each sixth has a
 * radius of 2^-100 or 2^100, the others are between. */
static void place_ball(ball *b, uint32_t key)
{
    int rows = between(2, rows_max, key, 0);
    double away = key % 3 == 0 ? 0 : pow(10, 6.0 * (double)rk_unit_float(rk_hash(key, 0, 1, 1)));
    whole3 toward = random_point(key, 0, 1 << 20);
    double scale = away * radius / 0x1p20;
    b->centre =
        snap(whole_of((int64_t)(scale * (double)toward.x), (int64_t)(scale * (double)toward.y),
                      (int64_t)(scale * (double)toward.z)));
    b->exponent = key % 12 == 4 ? -122 : key % 12 == 9 ? 78 : between(-122, 78, key, 2);
    b->count = make_ball(b->triangles, rows, radius, b->centre);
    for (uint32_t i = 0; i < b->count; i++)
        for (int k = 0; k < 3; k++)
            b->triangles[i][k] = snap(b->triangles[i][k]);
}

/* Of glass, so that no crossing ends a ray. */
static rk_scene scene_of(const ball *b)
{
    rk_scene scene = test_scene_make(b->count);
    for (uint32_t i = 0; i < b->count; i++) {
        rk_triangle t = float_triangle(b->triangles[i], b->exponent, i);
        test_scene_triangle(&scene, i, t.a, t.b, t.c);
    }
    scene.mesh.materials[0].alpha = 0.5f;
    return scene;
}

static bool truly_hits(const ball *b, whole3 origin, whole3 direction)
{
    for (uint32_t i = 0; i < b->count; i++) {
        whole_determinants m = whole_determinants_of(b->triangles[i], origin, direction);
        if (whole_hits(&m))
            return true;
    }
    return false;
}

/* Moeller and Trumbore's test in float, without an epsilon. */
static bool classic_hits(const rk_mesh *mesh, const rk_ray *ray)
{
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const rk_vec3 *corner = &mesh->positions[3 * i];
        rk_vec3 ab = rk_sub(corner[1], corner[0]), ac = rk_sub(corner[2], corner[0]);
        rk_vec3 s = rk_sub(ray->origin, corner[0]), p = rk_cross(ray->direction, ac);
        rk_vec3 q = rk_cross(s, ab);
        float det = rk_dot(ab, p), u = rk_dot(s, p) / det, v = rk_dot(ray->direction, q) / det;
        if (u >= 0 && v >= 0 && u + v <= 1 && rk_dot(ac, q) / det > 0)
            return true;
    }
    return false;
}

/* --- Rays ------------------------------------------------------------------------------------- */

/* Rays from one point inside of a ball, exactly at edges and corners of a triangle, or just beside.
 */
typedef struct ray_set {
    uint32_t key;
    whole3 origin, directions[group_size];
    rk_ray rays[group_size];
} ray_set;

/* Directions of any length for which no t overflows a float: from 2^-90 to 2^90. */
static ray_set rays_at(const ball *b, uint32_t key)
{
    ray_set set = {.key = key};
    const whole3 *target = b->triangles[rk_hash(key, 0, 0, 8) % b->count];
    int low = b->exponent < -50 ? -140 : b->exponent - 90;
    int high = b->exponent > -10 ? 80 : b->exponent + 90;
    int exponent = key % 2 ? 0 : between(low, high, key, 3);
    if (exponent < low || exponent > high)
        exponent = b->exponent;
    set.origin = snap(whole_madd(b->centre, random_point(key, 30, (int64_t)(radius / 4)), 1));
    for (uint32_t i = 0; i < group_size; i++) {
        set.directions[i] = snap(aimed(group_size * key + i, target, set.origin));
        set.rays[i] = (rk_ray){float_of(set.origin, b->exponent),
                               float_of(set.directions[i], exponent), INFINITY};
    }
    return set;
}

/* --- Traversals ------------------------------------------------------------------------------- */

typedef struct leak_count {
    unsigned long long aimed, in_every_way, leaks, sampled, classic_leaks;
} leak_count;

/* By the wide tree, with the instructions of every set that the machine has: hits as by single rays
 * through the binary tree. Returns the number of misses. */
static unsigned check_wide(const rk_accel *accel, const rk_ray_batch *rays, uint32_t key)
{
    static const char *const isas[] = {"scalar", "sse2", "avx2", "avx512"};
    unsigned misses = 0;
    for (int k = 0; k < 4; k++) {
        const rk_wide_kernel *kernel = rk_wide_kernel_named(isas[k], NULL);
        rk_counters counters = {0};
        rk_hit_batch hits;
        rk_occlusion_batch answers;
        if (!kernel)
            continue;
        kernel->closest(&accel->wide, rays, &hits, &counters);
        kernel->occluded(&accel->wide, rays, &answers, &counters);
        for (uint32_t i = 0; i < rays->count; i++) {
            rk_ray ray = rk_batch_ray(rays, i);
            rk_hit want = rk_bvh_closest(&accel->bvh, &ray, &counters);
            rk_check(hits.triangle[i] == want.triangle && hits.t[i] == want.t &&
                         answers.occluded[i] == (want.triangle != RK_MISS),
                     "rays %u, ray %u: with %s triangle %u is hit, by itself %u", key, i, isas[k],
                     hits.triangle[i], want.triangle);
            misses += hits.triangle[i] == RK_MISS;
        }
    }
    return misses;
}

/* The rays themselves, and unit directions; these are rounded, but a closed ball has no way out. */
static unsigned leaks_of_wide(const rk_accel *accel, const ray_set *set)
{
    rk_ray_batch batches[2] = {{.count = 0}, {.count = 0}};
    for (uint32_t i = 0; i < group_size; i++) {
        rk_ray ray = {set->rays[i].origin, rk_normalize(float_of(set->directions[i], 0)), INFINITY};
        rk_batch_push(&batches[0], &set->rays[i]);
        rk_batch_push(&batches[1], &ray);
    }
    return check_wide(accel, &batches[0], set->key) + check_wide(accel, &batches[1], set->key);
}

static void check_crossings(const rk_accel *accel, const ray_set *set, uint32_t i)
{
    rk_counters counters = {0};
    rk_crossing_list list;
    rk_crossings_gather(accel, &set->rays[i], RK_CROSSINGS_MAX, &list, &counters);
    int left = 0;
    for (uint32_t k = 0; k < list.count; k++)
        left += list.crossings[k].entering ? -1 : 1;
    rk_check(left == 1,
             "rays %u, ray %u: got %d crossings out of the ball more than into it, want 1",
             set->key, i, left);
}

static void trace(const ball *b, const rk_accel *accel, const ray_set *set, leak_count *count)
{
    rk_counters counters = {0};
    rk_hit hits[group_size];
    for (uint32_t i = 0; i < group_size; i++) {
        const rk_ray *ray = &set->rays[i];
        hits[i] = rk_bvh_closest(&accel->bvh, ray, &counters);
        bool hit = hits[i].triangle != RK_MISS;
        rk_check(rk_bvh_occluded(&accel->bvh, ray, &counters) == hit,
                 "rays %u, ray %u: the closest hit and occlusion disagree", set->key, i);
        count->aimed++;
        count->leaks += !hit;
    }
    if (set->key % 4 == 0) {
        for (uint32_t i = 0; i < group_size; i++)
            check_crossings(accel, set, i);
        count->leaks += leaks_of_wide(accel, set);
        count->in_every_way += group_size;
    }
    if (set->key % 50 == 0) {
        bool truly = truly_hits(b, set->origin, set->directions[0]);
        rk_check(truly, "rays %u: integers find no way through the ball's surface", set->key);
        count->sampled++;
        count->classic_leaks += !classic_hits(&accel->scene->mesh, &set->rays[0]);
    }
}

static void no_aimed_ray_leaves_a_ball(void **state)
{
    (void)state;
    static ball b;
    leak_count count = {0};
    const rk_accel_kind kinds[] = {RK_ACCEL_MEDIAN, RK_ACCEL_SAH, RK_ACCEL_SAH_3};
    for (uint32_t key = 0; key < ball_count(); key++) {
        rk_accel accel;
        rk_error error;
        place_ball(&b, key);
        rk_scene scene = scene_of(&b);
        rk_check_ok(rk_accel_build(&accel, kinds[key / 2 % 3], &scene, &error) &&
                        rk_wide_bvh_build(&accel.wide, &accel.bvh, &error),
                    error);
        for (uint32_t i = 0; i < groups_per_ball; i++) {
            const ray_set set = rays_at(&b, key * groups_per_ball + i);
            trace(&b, &accel, &set, &count);
        }
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
    printf("# %llu rays, %llu of them by every traversal: %llu leaks; of %llu of them the classic "
           "test "
           "leaks %llu\n",
           count.aimed, count.in_every_way, count.leaks, count.sampled, count.classic_leaks);
    rk_check(count.leaks == 0, "%llu of %llu rays leave a closed ball", count.leaks, count.aimed);
    rk_check(count.classic_leaks > 0, "the classic test leaks nothing: the rays are too easy");
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(no_aimed_ray_leaves_a_ball)};

RK_SUITE("stress_watertight", tests)
