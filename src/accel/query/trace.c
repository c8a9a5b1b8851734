/* Static surfaces first: the tree, then spheres, one by one. Moving objects at rest come after
 * that, with rays that end at the hits so far. */
#include "accel/query/trace.h"

#include "accel/query/tree.h"

#include <string.h>

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
    const rk_tree tree = rk_accel_static_tree(accel);
    rk_tree_closest(&tree, rays, hits, counters);
    intersect_spheres(accel->scene, rays, hits, counters);
}

void rk_accel_occluded_static(const rk_accel *accel, const rk_ray_batch *rays,
                              rk_occlusion_batch *answers, rk_counters *counters)
{
    const rk_tree tree = rk_accel_static_tree(accel);
    rk_tree_occluded(&tree, rays, answers, counters);
    for (uint32_t i = 0; accel->scene->sphere_count && i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        answers->occluded[i] =
            answers->occluded[i] || is_occluded_by_sphere(accel->scene, &ray, counters);
    }
}

/* --- Moving objects, at rest ------------------------------------------------------------------ */

/* Adds the hits in one object to those of the rest. */
static void closest_in_object(const rk_tree *tree, const rk_ray_batch *rays, rk_hit_batch *hits,
                              rk_counters *counters)
{
    rk_ray_batch shortened = *rays;
    rk_hit_batch found;
    memcpy(shortened.t_max, hits->t, rays->count * sizeof *hits->t);
    rk_tree_closest(tree, &shortened, &found, counters);
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_hit hit = rk_batch_hit(&found, i);
        if (hit.t < hits->t[i] || hit.triangle < hits->triangle[i])
            rk_batch_put_hit(hits, i, &hit);
    }
}

/* Tests the rays that are not occluded yet. */
static void occluded_by_object(const rk_tree *tree, const rk_ray_batch *rays,
                               rk_occlusion_batch *answers, rk_counters *counters)
{
    rk_ray_batch open;
    uint32_t index[RK_BATCH_MAX];
    rk_occlusion_batch found;
    open.count = 0;
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        index[open.count] = i;
        if (!answers->occluded[i])
            rk_batch_push(&open, &ray);
    }
    rk_tree_occluded(tree, &open, &found, counters);
    for (uint32_t i = 0; i < open.count; i++)
        answers->occluded[index[i]] = found.occluded[i];
}

void rk_accel_closest_at_rest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                              rk_counters *counters)
{
    for (uint32_t k = 0; k < accel->scene->moving_count; k++) {
        const rk_tree tree = rk_accel_moving_tree(accel, k);
        closest_in_object(&tree, rays, hits, counters);
    }
}

void rk_accel_occluded_at_rest(const rk_accel *accel, const rk_ray_batch *rays,
                               rk_occlusion_batch *answers, rk_counters *counters)
{
    for (uint32_t k = 0; k < accel->scene->moving_count; k++) {
        const rk_tree tree = rk_accel_moving_tree(accel, k);
        occluded_by_object(&tree, rays, answers, counters);
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
