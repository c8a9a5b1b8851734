#include "accel/accel.h"

#include "accel/packet.h"
#include "features/bvh_median.h"
#include "features/sah_binning.h"

#include <stdio.h>

/* --- Building --------------------------------------------------------------------------------- */

static bool build_tree(rk_bvh *bvh, const rk_accel *accel, const rk_mesh *mesh, rk_error *error)
{
    if (accel->kind == RK_ACCEL_MEDIAN)
        return rk_bvh_build_median(bvh, mesh, error);
    const rk_sah_options options = {accel->bins, accel->kind == RK_ACCEL_SAH_3};
    return rk_bvh_build_sah(bvh, mesh, &options, error);
}

/* A tree over these triangles of the mesh alone; in it they keep their numbers. */
static bool build_part(rk_bvh *bvh, const rk_accel *accel, uint32_t first, uint32_t count,
                       rk_error *error)
{
    rk_mesh part = accel->scene->mesh;
    part.triangle_count = count;
    if (first > 0) {
        part.triangles += first;
        part.triangle_materials += first;
    }
    if (!build_tree(bvh, accel, &part, error))
        return false;
    for (uint32_t i = 0; first > 0 && i < count; i++)
        bvh->triangles[i].index += first;
    return true;
}

static bool check_method(const rk_accel *accel, rk_error *error)
{
    if (accel->kind > RK_ACCEL_SAH_3)
        return rk_fail(error, "the kind is %u, but rk_accel_kind goes from 0 to %u", accel->kind,
                       RK_ACCEL_SAH_3);
    if (accel->kind != RK_ACCEL_MEDIAN && (accel->bins < 2 || accel->bins > RK_SAH_BINS_MAX))
        return rk_fail(error, "there are 2 to %d bins, not %u", RK_SAH_BINS_MAX, accel->bins);
    return true;
}

/* Fills in how many triangles stand still. */
static bool check_moving(const rk_scene *scene, uint32_t *still, rk_error *error)
{
    uint32_t end = scene->mesh.triangle_count;
    if (scene->moving_count > RK_MOVING_MAX)
        return rk_fail(error, "%s: %u objects move, but at most %d can", scene->name,
                       scene->moving_count, RK_MOVING_MAX);
    for (uint32_t i = scene->moving_count; i > 0; i--) {
        const rk_moving *object = &scene->moving[i - 1];
        if (object->count < 1 || object->count > end || object->first != end - object->count)
            return rk_fail(error,
                           "%s: moving object %u has %u triangles from %u on: moving objects are a "
                           "mesh's last triangles, one behind the other",
                           scene->name, i - 1, object->count, object->first);
        end = object->first;
    }
    *still = end;
    return true;
}

bool rk_accel_build_binned(rk_accel *accel, rk_accel_kind kind, uint32_t bins,
                           const rk_scene *scene, rk_error *error)
{
    *accel = (rk_accel){.kind = kind, .bins = bins, .scene = scene};
    uint32_t still = 0;
    bool ok = check_method(accel, error) && check_moving(scene, &still, error) &&
              build_part(&accel->bvh, accel, 0, still, error);
    for (uint32_t i = 0; ok && i < scene->moving_count; i++)
        ok = build_part(&accel->moving[i], accel, scene->moving[i].first, scene->moving[i].count,
                        error);
    if (!ok)
        rk_accel_free(accel);
    return ok;
}

bool rk_accel_build(rk_accel *accel, rk_accel_kind kind, const rk_scene *scene, rk_error *error)
{
    return rk_accel_build_binned(accel, kind, rk_sah_options_default().bins, scene, error);
}

void rk_accel_free(rk_accel *accel)
{
    rk_bvh_free(&accel->bvh);
    for (uint32_t i = 0; i < RK_MOVING_MAX; i++)
        rk_bvh_free(&accel->moving[i]);
}

rk_accel_title rk_accel_name(const rk_accel *accel)
{
    rk_accel_title title = {"median"};
    if (accel->kind != RK_ACCEL_MEDIAN)
        snprintf(title.text, sizeof title.text, "sah%u%s", accel->bins,
                 accel->kind == RK_ACCEL_SAH_3 ? "_3" : "");
    return title;
}

const char *rk_accel_isa(rk_accel_kind kind)
{
    (void)kind;
    return "scalar";
}

/* --- Asking ----------------------------------------------------------------------------------- */

__attribute__((always_inline)) static inline void
intersect_spheres(const rk_scene *scene, const rk_ray *ray, rk_hit *hit, rk_counters *counters)
{
    for (uint32_t k = 0; k < scene->sphere_count; k++)
        rk_sphere_closest(&scene->spheres[k], scene->mesh.triangle_count + k, ray, hit);
    counters->sphere_tests += scene->sphere_count;
}

static bool occluded_by_sphere(const rk_scene *scene, const rk_ray *ray, rk_counters *counters)
{
    bool found = false;
    for (uint32_t k = 0; k < scene->sphere_count && !found; k++) {
        found = rk_sphere_intersect(&scene->spheres[k], ray, ray->t_max) < INFINITY;
        counters->sphere_tests++;
    }
    return found;
}

/* The ray as the object at rest sees it. */
static void intersect_object(const rk_bvh *bvh, rk_ray ray, rk_hit *hit, rk_counters *counters)
{
    ray.t_max = hit->t;
    rk_hit found = rk_bvh_closest(bvh, &ray, counters);
    if (found.t < hit->t || found.triangle < hit->triangle)
        *hit = found;
}

static void put_hit(rk_hit_batch *hits, uint32_t i, const rk_hit *hit)
{
    hits->t[i] = hit->t;
    hits->u[i] = hit->u;
    hits->v[i] = hit->v;
    hits->triangle[i] = hit->triangle;
}

void rk_accel_put_hit(const rk_accel *accel, const rk_ray *ray, rk_hit hit, rk_hit_batch *hits,
                      uint32_t i, rk_counters *counters)
{
    intersect_spheres(accel->scene, ray, &hit, counters);
    put_hit(hits, i, &hit);
}

void rk_accel_closest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                      rk_counters *counters)
{
    const uint32_t moving = accel->scene->moving_count;
    const bool spheres = accel->scene->sphere_count > 0;
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_hit hit = rk_bvh_closest(&accel->bvh, &ray, counters);
        for (uint32_t k = 0; k < moving; k++)
            intersect_object(&accel->moving[k], ray, &hit, counters);
        if (spheres)
            intersect_spheres(accel->scene, &ray, &hit, counters);
        put_hit(hits, i, &hit);
    }
}

void rk_accel_occluded(const rk_accel *accel, const rk_ray_batch *rays, rk_occlusion_batch *answers,
                       rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        bool found = rk_bvh_occluded(&accel->bvh, &ray, counters);
        for (uint32_t k = 0; k < accel->scene->moving_count && !found; k++)
            found = rk_bvh_occluded(&accel->moving[k], &ray, counters);
        answers->found[i] = found || occluded_by_sphere(accel->scene, &ray, counters);
    }
}

/* --- Asking what moves ------------------------------------------------------------------------ */

/* Rays on their way to one moving object, as the object at rest sees them. Neighbours among the
 * rays of a batch go nearly the same way, so they go together. */
typedef struct group {
    uint32_t count;
    uint32_t index[RK_PACKET_MAX]; /* in the batch */
    rk_ray rays[RK_PACKET_MAX];
} group;

static void group_closest(group *g, const rk_bvh *bvh, rk_hit_batch *hits, rk_counters *counters)
{
    rk_hit found[RK_PACKET_MAX];
    for (uint32_t i = 0; i < g->count; i++)
        g->rays[i].t_max = hits->t[g->index[i]];
    rk_packet_closest(bvh, g->rays, g->count, found, counters);
    for (uint32_t i = 0; i < g->count; i++) {
        uint32_t index = g->index[i];
        if (found[i].t < hits->t[index] || found[i].triangle < hits->triangle[index])
            put_hit(hits, index, &found[i]);
    }
    g->count = 0;
}

static void group_any(group *g, const rk_bvh *bvh, rk_occlusion_batch *answers,
                      rk_counters *counters)
{
    bool found[RK_PACKET_MAX];
    rk_packet_occluded(bvh, g->rays, g->count, found, counters);
    for (uint32_t i = 0; i < g->count; i++)
        answers->found[g->index[i]] |= found[i];
    g->count = 0;
}

/* Puts the ray into the groups of all objects that it may meet. True if one of them is full. */
static bool join(group *groups, uint32_t objects, const rk_moments *when, uint32_t index,
                 const rk_ray *ray, float t_max)
{
    const rk_slabs slabs = rk_slabs_of(ray);
    rk_vec3 offset;
    bool full = false;
    for (uint32_t k = 0; k < objects; k++)
        if (when->reaches(when->asker, index, k, &slabs, t_max, &offset)) {
            group *g = &groups[k];
            g->index[g->count] = index;
            g->rays[g->count++] = rk_motion_ray(offset, ray);
            full |= g->count == RK_PACKET_MAX;
        }
    return full;
}

void rk_accel_closest_at(const rk_accel *accel, const rk_ray_batch *rays, const rk_moments *when,
                         rk_hit_batch *hits, rk_counters *counters)
{
    const uint32_t objects = accel->scene->moving_count;
    group groups[RK_MOVING_MAX] = {0};
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_hit hit = rk_bvh_closest(&accel->bvh, &ray, counters);
        intersect_spheres(accel->scene, &ray, &hit, counters);
        put_hit(hits, i, &hit);
        if (!join(groups, objects, when, i, &ray, hit.t) && i + 1 < rays->count)
            continue;
        for (uint32_t k = 0; k < objects; k++)
            if (groups[k].count == RK_PACKET_MAX || i + 1 == rays->count)
                group_closest(&groups[k], &accel->moving[k], hits, counters);
    }
}

void rk_accel_any_at(const rk_accel *accel, const rk_ray_batch *rays, const rk_moments *when,
                     rk_occlusion_batch *answers, rk_counters *counters)
{
    const uint32_t objects = accel->scene->moving_count;
    group groups[RK_MOVING_MAX] = {0};
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        answers->found[i] = rk_bvh_occluded(&accel->bvh, &ray, counters) ||
                            occluded_by_sphere(accel->scene, &ray, counters);
        bool full = !answers->found[i] && join(groups, objects, when, i, &ray, ray.t_max);
        if (!full && i + 1 < rays->count)
            continue;
        for (uint32_t k = 0; k < objects; k++)
            if (groups[k].count == RK_PACKET_MAX || i + 1 == rays->count)
                group_any(&groups[k], &accel->moving[k], answers, counters);
    }
}
