#include "render/accel.h"

#include "features/bvh_median.h"

bool rk_accel_build(rk_accel *accel, rk_accel_kind kind, const rk_mesh *mesh, rk_error *error)
{
    *accel = (rk_accel){.kind = kind};
    return rk_bvh_build_median(&accel->bvh, mesh, error);
}

void rk_accel_free(rk_accel *accel)
{
    rk_bvh_free(&accel->bvh);
}

const char *rk_accel_name(rk_accel_kind kind)
{
    (void)kind;
    return "median";
}

const char *rk_accel_isa(rk_accel_kind kind)
{
    (void)kind;
    return "scalar";
}

void rk_accel_closest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                      rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_hit hit = rk_bvh_closest(&accel->bvh, &ray, counters);
        hits->t[i] = hit.t;
        hits->u[i] = hit.u;
        hits->v[i] = hit.v;
        hits->triangle[i] = hit.triangle;
    }
}

void rk_accel_any(const rk_accel *accel, const rk_ray_batch *rays, rk_any_batch *answers,
                  rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        answers->found[i] = rk_bvh_any(&accel->bvh, &ray, counters);
    }
}
