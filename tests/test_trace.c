/* Tracing in parts: static surfaces first, then moving objects at the rays' times. Together they
 * find the same hits as single rays, to the bit. */
#include "test_scene.h"
#include "test_soup.h"

#include "accel/query/trace.h"
#include "accel/query/trace_moving.h"
#include "features/bvh_median.h"

static const char *const names[] = {"moving", "statue:967", "cover:500", "spheres"};
enum { name_count = sizeof names / sizeof *names };

static rk_scene scene_of(const char *name)
{
    rk_scene scene = test_scene_builtin(name);
    if (scene.moving_count == 0) {
        uint32_t count = scene.mesh.triangle_count / 2;
        scene.moving[0] =
            (rk_moving){scene.mesh.triangle_count - count, count, rk_motion_default()};
        scene.moving_count = 1;
    }
    return scene;
}

enum { kind_count = RK_ACCEL_WIDE + 1 };

static rk_accel accel_of(const rk_scene *scene, uint32_t kind)
{
    rk_accel accel;
    rk_error error;
    rk_check_ok(rk_accel_build(&accel, (rk_accel_kind)kind, scene, &error), error);
    return accel;
}

/* Rays from around the scene towards its middle, some of them bounded. */
static rk_ray_batch make_rays(uint32_t key)
{
    rk_ray_batch rays = {.count = 0};
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        rk_vec3 from = rk_scale(noise3(key, 2 * i), 3), to = noise3(key, 2 * i + 1);
        rk_ray ray = {from, rk_sub(to, from), i % 3 == 0 ? 0.9f : INFINITY};
        rk_batch_push(&rays, &ray);
    }
    return rays;
}

/* Every ray at a time of its own, or all at one, for a few or all of the objects. */
static rk_ray_times make_times(uint32_t key, float most)
{
    rk_ray_times times;
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        times.objects[i] = (uint16_t)rk_hash(key, i, 5, 1);
        times.time[i] = times.objects[i] ? most * noise(key, i, 6) : NAN;
    }
    return times;
}

static void check_same_hit(const rk_hit_batch *got, const rk_hit_batch *want, uint32_t i,
                           const char *name)
{
    rk_check(
        got->triangle[i] == want->triangle[i] && got->t[i] == want->t[i] &&
            (want->triangle[i] == RK_MISS || (got->u[i] == want->u[i] && got->v[i] == want->v[i])),
        "%s, ray %u: hit %d at %.9g, want %d at %.9g", name, i, (int)got->triangle[i],
        (double)got->t[i], (int)want->triangle[i], (double)want->t[i]);
}

/* One ray after the other, one object after the other. */
static void trace_alone(const rk_accel *accel, const rk_ray_batch *rays, const rk_ray_times *times,
                        rk_hit_batch *hits, rk_counters *counters)
{
    rk_accel_closest_static(accel, rays, hits, counters);
    for (uint32_t i = 0; i < rays->count; i++)
        for (uint32_t k = 0; k < accel->scene->moving_count; k++) {
            rk_hit hit = rk_batch_hit(hits, i);
            rk_ray ray = rk_batch_ray(rays, i);
            if (!(times->objects[i] >> k & 1))
                continue;
            ray = rk_accel_ray_at(accel, k, times->time[i], &ray);
            ray.t_max = hit.t;
            rk_hit closer = rk_bvh_closest(&accel->moving[k], &ray, counters);
            if (closer.t < hit.t || closer.triangle < hit.triangle)
                rk_batch_put_hit(hits, i, &closer);
        }
}

static void batches_at_ray_times_find_the_hits_of_single_rays(void **state)
{
    (void)state;
    for (uint32_t c = 0; c < name_count * kind_count; c++) {
        const uint32_t n = c / kind_count;
        rk_scene scene = scene_of(names[n]);
        rk_accel accel = accel_of(&scene, c % kind_count);
        uint32_t moved = 0;
        for (uint32_t key = 0; key < 40; key++) {
            rk_ray_batch rays = make_rays(key);
            rk_ray_times times = make_times(key, 0.5f);
            rk_hit_batch got, want;
            rk_occlusion_batch answers;
            rk_counters counters = {0};
            trace_alone(&accel, &rays, &times, &want, &counters);
            rk_accel_closest_static(&accel, &rays, &got, &counters);
            rk_accel_closest_moving(&accel, &rays, &times, &got, &counters);
            rk_accel_occluded_static(&accel, &rays, &answers, &counters);
            rk_accel_occluded_moving(&accel, &rays, &times, &answers, &counters);
            for (uint32_t i = 0; i < rays.count; i++) {
                check_same_hit(&got, &want, i, names[n]);
                rk_check(answers.occluded[i] == (want.triangle[i] != RK_MISS),
                         "%s, ray %u: is it occluded?", names[n], i);
                moved += want.triangle[i] >= scene.moving[0].first &&
                         want.triangle[i] < scene.mesh.triangle_count;
            }
        }
        rk_check(moved > 20, "%s: only %u rays hit a moving object", names[n], moved);
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
}

static void at_time_0_objects_are_at_rest(void **state)
{
    (void)state;
    for (uint32_t c = 0; c < name_count * kind_count; c++) {
        const uint32_t n = c / kind_count;
        rk_scene scene = scene_of(names[n]);
        rk_accel accel = accel_of(&scene, c % kind_count);
        rk_ray_times times = make_times(1, 0);
        for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
            times.time[i] = 0;
            times.objects[i] = 0xffff;
        }
        for (uint32_t key = 0; key < 40; key++) {
            rk_ray_batch rays = make_rays(key);
            rk_hit_batch got, want;
            rk_occlusion_batch answers, whole;
            rk_counters counters = {0};
            rk_accel_closest(&accel, &rays, &want, &counters);
            rk_accel_closest_static(&accel, &rays, &got, &counters);
            rk_accel_closest_moving(&accel, &rays, &times, &got, &counters);
            rk_accel_occluded(&accel, &rays, &whole, &counters);
            rk_accel_occluded_static(&accel, &rays, &answers, &counters);
            rk_accel_occluded_moving(&accel, &rays, &times, &answers, &counters);
            for (uint32_t i = 0; i < rays.count; i++) {
                check_same_hit(&got, &want, i, names[n]);
                rk_check(answers.occluded[i] == whole.occluded[i], "%s, ray %u: is it occluded?",
                         names[n], i);
            }
        }
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
}

static void rays_at_rest_cost_nothing(void **state)
{
    (void)state;
    rk_scene scene = scene_of("moving");
    rk_accel accel = accel_of(&scene, RK_ACCEL_WIDE);
    rk_ray_batch rays = make_rays(1);
    rk_ray_times times;
    rk_hit_batch hits, before;
    rk_occlusion_batch answers;
    rk_counters counters = {0}, none = {0};
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        times.time[i] = NAN;
        times.objects[i] = 0;
    }
    rk_accel_closest_static(&accel, &rays, &hits, &counters);
    rk_accel_occluded_static(&accel, &rays, &answers, &counters);
    before = hits;
    rk_accel_closest_moving(&accel, &rays, &times, &hits, &none);
    rk_accel_occluded_moving(&accel, &rays, &times, &answers, &none);
    for (uint32_t i = 0; i < rays.count; i++)
        check_same_hit(&hits, &before, i, "moving");
    rk_check_equal(none.box_tests + none.triangle_tests, 0, "no ray needs a time");
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(batches_at_ray_times_find_the_hits_of_single_rays),
    cmocka_unit_test(at_time_0_objects_are_at_rest),
    cmocka_unit_test(rays_at_rest_cost_nothing),
};

RK_SUITE("trace", tests)
