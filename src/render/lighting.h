/* What the stages of lights hand to each other; not installed. */
#ifndef RK_RENDER_LIGHTING_H
#define RK_RENDER_LIGHTING_H

#include "base/colour.h"
#include "render/tile.h"

/* What the seen surface sends on to the viewer of light from a direction (any length). */
static inline rk_vec3 rk_reflected(const rk_rendering *r, const rk_shading_point *seen,
                                   rk_vec3 to_light, rk_vec3 colour)
{
    const rk_material *material = seen->surface.material;
    return rk_shade(&r->options->shading, seen->kd, material->ks, material->shininess,
                    seen->surface.normal, rk_normalize(to_light), seen->to_viewer, colour);
}

/* Puts a shadow ray before light on its way by the seen surface i: from the point, t = 0, to the
 * light, t = 1. */
static inline void rk_queue_shadow_ray(rk_tile *t, uint32_t i, rk_vec3 to_light, rk_vec3 light,
                                       rk_vec3 arriving)
{
    rk_vec3 start = rk_surface_spawn(&t->seen[i].surface, to_light);
    rk_ray ray = {start, rk_sub(light, start), 1};
    t->arriving_at[t->shadow.count] = (uint16_t)i;
    t->arriving[t->shadow.count] = arriving;
    rk_batch_push(&t->shadow, &ray);
}

/* Asks the tile's shadow rays; `arriving` becomes what panes leave of it. */
void rk_shadow_stage(const rk_rendering *r, rk_tile *t);

/* Adds to the pixels' sums what one light sends by way of the tile's seen surfaces, and keeps
 * account of it in the tile's `sums`. */
void rk_parallelogram_light_stage(const rk_rendering *r, rk_tile *t, uint32_t light);

/* The same sums without the account, for a point without a falloff. */
void rk_point_light_stage(const rk_rendering *r, rk_tile *t, const rk_light *light);

#endif
