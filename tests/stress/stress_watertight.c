/* Rays aimed at the edges and corners of closed balls from inside, through trees of boxes: at
 * scales from 1e-15 to 1e15, and up to a million radii from the origin, where floats are coarse and
 * balls angular, but closed. Integers know which triangles a ray hits. RAYKIT_STRESS is the factor
 * over make check, which aims 200,000 rays; make stress aims 100 times as many, and 500 are 100
 * million. */
#include "../test.h"

#include "../closed_mesh.h"
#include "features/bvh_median.h"
#include "features/sah_binning.h"
#include "scene/mesh.h"

enum { rows_max = 16, triangles_max = 8 * rows_max * rows_max, rays_per_ball = 20000 };

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

/* Every third ball is around the origin, others lie up to a million radii away. */
static void place_ball(ball *b, uint32_t key)
{
    int rows = 2 + (int)(rk_hash(key, 0, 0, 1) % (rows_max - 1));
    double away = key % 3 == 0 ? 0 : pow(10, 6.0 * (double)rk_unit_float(rk_hash(key, 0, 1, 1)));
    whole3 toward = random_point(key, 0, 1 << 20);
    double scale = away * radius / 0x1p20;
    b->centre =
        snap(whole_of((int64_t)(scale * (double)toward.x), (int64_t)(scale * (double)toward.y),
                      (int64_t)(scale * (double)toward.z)));
    b->exponent = (int)(rk_hash(key, 0, 2, 1) % 101) - 72;
    b->count = make_ball(b->triangles, rows, radius, b->centre);
    for (uint32_t i = 0; i < b->count; i++)
        for (int k = 0; k < 3; k++)
            b->triangles[i][k] = snap(b->triangles[i][k]);
}

static rk_mesh mesh_of(const ball *b)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 3 * b->count, b->count, 1, 0, &error), error);
    for (uint32_t i = 0; i < b->count; i++)
        for (uint32_t k = 0; k < 3; k++) {
            mesh.positions[3 * i + k] = float_of(b->triangles[i][k], b->exponent);
            mesh.triangles[i][k] = 3 * i + k;
        }
    return mesh;
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

typedef struct leak_count {
    unsigned long long aimed, leaks, sampled, classic_leaks;
} leak_count;

static void aim_at(const ball *b, const rk_mesh *mesh, const rk_bvh *bvh, uint32_t key,
                   leak_count *count)
{
    rk_counters counters = {0};
    for (uint32_t i = 0; i < rays_per_ball; i++) {
        uint32_t ray_key = key * rays_per_ball + i;
        whole3 origin =
            snap(whole_madd(b->centre, random_point(ray_key, 30, (int64_t)(radius / 4)), 1));
        whole3 direction =
            snap(aimed(ray_key, b->triangles[rk_hash(ray_key, 0, 0, 8) % b->count], origin));
        rk_ray ray = {float_of(origin, b->exponent), float_of(direction, 0), INFINITY};
        bool hits = rk_bvh_closest(bvh, &ray, &counters).triangle != RK_MISS;
        rk_check(rk_bvh_occluded(bvh, &ray, &counters) == hits,
                 "ball %u, ray %u: the closest hit and occlusion disagree", key, i);
        count->aimed++;
        count->leaks += !hits && truly_hits(b, origin, direction);
        if (i % 200 == 0) {
            bool truly = truly_hits(b, origin, direction);
            rk_check(hits == truly, "ball %u, ray %u: got %s, want %s by integers", key, i,
                     hits ? "a hit" : "a miss", truly ? "a hit" : "a miss");
            count->sampled++;
            count->classic_leaks += truly && !classic_hits(mesh, &ray);
        }
    }
}

static void no_aimed_ray_leaves_a_ball(void **state)
{
    (void)state;
    static ball b;
    leak_count count = {0};
    for (uint32_t key = 0; key < ball_count(); key++) {
        rk_bvh bvh;
        rk_error error;
        place_ball(&b, key);
        rk_mesh mesh = mesh_of(&b);
        const rk_sah_options options = {20, false};
        rk_check_ok(key % 2 ? rk_bvh_build_median(&bvh, &mesh, &error)
                            : rk_bvh_build_sah(&bvh, &mesh, &options, &error),
                    error);
        aim_at(&b, &mesh, &bvh, key, &count);
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
    printf("# %llu rays: %llu leaks; of %llu of them the classic test leaks %llu\n", count.aimed,
           count.leaks, count.sampled, count.classic_leaks);
    rk_check(count.leaks == 0, "%llu of %llu rays leave a closed ball", count.leaks, count.aimed);
    rk_check(count.classic_leaks > 0, "the classic test leaks nothing: the rays are too easy");
}

static const struct CMUnitTest tests[] = {cmocka_unit_test(no_aimed_ray_leaves_a_ball)};

RK_SUITE("stress_watertight", tests)
