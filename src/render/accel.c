#include "render/accel.h"

#include "features/bvh_median.h"
#include "features/sah_binning.h"

#include <stdio.h>

bool rk_accel_build_binned(rk_accel *accel, rk_accel_kind kind, uint32_t bins,
                           const rk_scene *scene, rk_error *error)
{
    *accel = (rk_accel){.kind = kind, .bins = bins, .scene = scene};
    if (kind == RK_ACCEL_MEDIAN)
        return rk_bvh_build_median(&accel->bvh, &scene->mesh, error);
    const rk_sah_options options = {bins, kind == RK_ACCEL_SAH_3};
    return rk_bvh_build_sah(&accel->bvh, &scene->mesh, &options, error);
}

bool rk_accel_build(rk_accel *accel, rk_accel_kind kind, const rk_scene *scene, rk_error *error)
{
    return rk_accel_build_binned(accel, kind, rk_sah_options_default().bins, scene, error);
}

void rk_accel_free(rk_accel *accel)
{
    rk_bvh_free(&accel->bvh);
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

static void meet_spheres(const rk_scene *scene, const rk_ray *ray, rk_hit *hit,
                         rk_counters *counters)
{
    for (uint32_t k = 0; k < scene->sphere_count; k++)
        rk_sphere_closest(&scene->spheres[k], scene->mesh.triangle_count + k, ray, hit);
    counters->sphere_tests += scene->sphere_count;
}

static bool meets_any_sphere(const rk_scene *scene, const rk_ray *ray, rk_counters *counters)
{
    bool found = false;
    for (uint32_t k = 0; k < scene->sphere_count && !found; k++) {
        found = rk_sphere_meet(&scene->spheres[k], ray, ray->t_max) < INFINITY;
        counters->sphere_tests++;
    }
    return found;
}

void rk_accel_put_hit(const rk_accel *accel, const rk_ray *ray, rk_hit hit, rk_hit_batch *hits,
                      uint32_t i, rk_counters *counters)
{
    meet_spheres(accel->scene, ray, &hit, counters);
    hits->t[i] = hit.t;
    hits->u[i] = hit.u;
    hits->v[i] = hit.v;
    hits->triangle[i] = hit.triangle;
}

void rk_accel_closest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                      rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_hit hit = rk_bvh_closest(&accel->bvh, &ray, counters);
        rk_accel_put_hit(accel, &ray, hit, hits, i, counters);
    }
}

void rk_accel_any(const rk_accel *accel, const rk_ray_batch *rays, rk_any_batch *answers,
                  rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        answers->found[i] = rk_bvh_any(&accel->bvh, &ray, counters) ||
                            meets_any_sphere(accel->scene, &ray, counters);
    }
}
