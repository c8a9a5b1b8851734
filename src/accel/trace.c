#include "accel/trace.h"

#include "accel/ray_group.h"
#include "accel/stand_in_tree.h"

/* --- Static surfaces -------------------------------------------------------------------------- */

/* After the triangles, whose hits end the rays early. */
static void intersect_spheres(const rk_scene *scene, const rk_ray_batch *rays, rk_hit_batch *hits,
                              rk_counters *counters)
{
    for (uint32_t i = 0; scene->sphere_count && i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_hit hit = rk_batch_hit(hits, i);
        for (uint32_t k = 0; k < scene->sphere_count; k++)
            rk_sphere_closest(&scene->spheres[k], scene->mesh.triangle_count + k, &ray, &hit);
        rk_batch_put_hit(hits, i, &hit);
        counters->sphere_tests += scene->sphere_count;
    }
}

static bool is_occluded_by_sphere(const rk_scene *scene, const rk_ray *ray, rk_counters *counters)
{
    bool occluded = false;
    for (uint32_t k = 0; k < scene->sphere_count && !occluded; k++) {
        occluded = rk_sphere_intersect(&scene->spheres[k], ray, ray->t_max) < INFINITY;
        counters->sphere_tests++;
    }
    return occluded;
}

void rk_accel_closest_static(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                             rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_hit hit = rk_tree_closest(&accel->bvh, &ray, counters);
        rk_batch_put_hit(hits, i, &hit);
    }
    intersect_spheres(accel->scene, rays, hits, counters);
}

void rk_accel_closest_static_grouped(const rk_accel *accel, const rk_ray_batch *rays,
                                     rk_hit_batch *hits, rk_counters *counters)
{
    rk_ray_group_closest(&accel->bvh, rays, hits, counters);
    intersect_spheres(accel->scene, rays, hits, counters);
}

void rk_accel_occluded_static(const rk_accel *accel, const rk_ray_batch *rays,
                              rk_occlusion_batch *answers, rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        answers->occluded[i] = rk_tree_occluded(&accel->bvh, &ray, counters) ||
                               is_occluded_by_sphere(accel->scene, &ray, counters);
    }
}

/* --- Moving objects, at rest -------------------------------------------------------------------
 */

static void intersect_object(const rk_bvh *bvh, rk_ray ray, rk_hit *hit, rk_counters *counters)
{
    ray.t_max = hit->t;
    rk_hit closest = rk_tree_closest(bvh, &ray, counters);
    if (closest.t < hit->t || closest.triangle < hit->triangle)
        *hit = closest;
}

void rk_accel_closest_at_rest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                              rk_counters *counters)
{
    const uint32_t objects = accel->scene->moving_count;
    for (uint32_t i = 0; objects && i < rays->count; i++) {
        rk_hit hit = rk_batch_hit(hits, i);
        for (uint32_t k = 0; k < objects; k++)
            intersect_object(&accel->moving[k], rk_batch_ray(rays, i), &hit, counters);
        rk_batch_put_hit(hits, i, &hit);
    }
}

void rk_accel_occluded_at_rest(const rk_accel *accel, const rk_ray_batch *rays,
                               rk_occlusion_batch *answers, rk_counters *counters)
{
    const uint32_t objects = accel->scene->moving_count;
    for (uint32_t i = 0; objects && i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        for (uint32_t k = 0; k < objects && !answers->occluded[i]; k++)
            answers->occluded[i] = rk_tree_occluded(&accel->moving[k], &ray, counters);
    }
}

/* --- Both parts ------------------------------------------------------------------------------- */

void rk_accel_closest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                      rk_counters *counters)
{
    rk_accel_closest_static(accel, rays, hits, counters);
    rk_accel_closest_at_rest(accel, rays, hits, counters);
}

void rk_accel_occluded(const rk_accel *accel, const rk_ray_batch *rays, rk_occlusion_batch *answers,
                       rk_counters *counters)
{
    rk_accel_occluded_static(accel, rays, answers, counters);
    rk_accel_occluded_at_rest(accel, rays, answers, counters);
}
