/* A shading point: a path's hit, with the data that lights and reflections need; not installed. */
#ifndef RK_RENDER_SHADING_POINT_H
#define RK_RENDER_SHADING_POINT_H

#include "base/colour.h"
#include "render/path_batch.h"
#include "scene/surface.h"

typedef struct rk_shading_point {
    rk_surface surface;
    rk_vec3 kd;
    rk_vec3 to_viewer; /* unit, back along the ray; 0 unless plan.viewer */
    rk_path path;      /* from this point on */
    uint16_t pixel;
} rk_shading_point;

typedef struct rk_shading_points {
    uint32_t count;
    rk_shading_point points[RK_BATCH_MAX];
} rk_shading_points;

/* Returns the radiance reflected to the viewer from a light in this direction: unit. */
static inline rk_vec3 rk_reflected_radiance_from(const rk_shading *shading,
                                                 const rk_shading_point *point, rk_vec3 direction,
                                                 rk_vec3 light)
{
    const rk_material *material = point->surface.material;
    return rk_shade(shading, point->kd, material->ks, material->shininess, point->surface.normal,
                    direction, point->to_viewer, light);
}

/* The same for a direction of any length. */
static inline rk_vec3 rk_reflected_radiance(const rk_shading *shading,
                                            const rk_shading_point *point, rk_vec3 to_light,
                                            rk_vec3 light)
{
    return rk_reflected_radiance_from(shading, point, rk_normalize(to_light), light);
}

#endif
