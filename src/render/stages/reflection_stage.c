/* A direction that a shading normal would send into the surface is reflected at the face normal
 * instead. */
#include "render/stages/reflection_stage.h"

#include "base/reflect.h"

bool rk_is_specular(const rk_shading_point *point)
{
    return point->path.bounces_left > 0 &&
           !rk_is_black(rk_mul(point->path.throughput, point->surface.material->ks));
}

rk_vec3 rk_reflected_direction(const rk_shading_point *point)
{
    rk_vec3 incoming = rk_negate(point->to_viewer);
    rk_vec3 direction = rk_reflect(incoming, point->surface.normal);
    return rk_dot(direction, point->surface.face_normal) > 0
               ? direction
               : rk_reflect(incoming, point->surface.face_normal);
}

void rk_spawn_reflection(const rk_shading_point *point, rk_path_batch *reflected)
{
    rk_vec3 direction = rk_reflected_direction(point);
    rk_ray ray = {rk_surface_spawn(&point->surface, direction), direction, INFINITY};
    const rk_path *path = &point->path;
    rk_path_push(reflected, &ray, point->pixel,
                 rk_path_of(rk_mul(path->throughput, point->surface.material->ks), path->sample,
                            path->split, path->bounces_left - 1u));
}

void rk_reflection_stage(const rk_sample_pass *pass, const rk_shading_points *points,
                         rk_path_batch *reflected)
{
    reflected->rays.count = 0;
    for (uint32_t i = 0; i < points->count; i++)
        if (rk_is_specular(&points->points[i]))
            rk_spawn_reflection(&points->points[i], reflected);
    pass->counters->reflected_rays += reflected->rays.count;
}
