/* A light that is one point, without a falloff, shines alike on all that is seen: no samples,
 * nothing to settle. Each surface asks once, and where nothing can be in the way not at all. */
#include "render/lighting.h"

static inline void arrive(rk_tile *t, uint32_t i, rk_vec3 arriving)
{
    const rk_shading_point *seen = &t->seen[i];
    rk_vec3 *sum = &t->sum[seen->pixel];
    *sum = rk_add(*sum, rk_mul(seen->path.weight, arriving));
}

static void send(const rk_rendering *r, rk_tile *t, rk_vec3 position, rk_vec3 colour)
{
    for (uint32_t i = 0; i < t->seen_count; i++) {
        const rk_shading_point *seen = &t->seen[i];
        rk_vec3 to_light = rk_sub(position, seen->surface.point);
        rk_vec3 arriving = rk_reflected(r, seen, to_light, colour);
        if (!r->plan.shadow_rays)
            arrive(t, i, arriving);
        else if (!rk_is_black(arriving))
            rk_queue_shadow_ray(t, i, to_light, position, arriving);
    }
}

void rk_point_light_stage(const rk_rendering *r, rk_tile *t, const rk_light *light)
{
    const rk_light_options *options = &r->options->light;
    const rk_light_sample everywhere = rk_light_sample_at(light, options->falloff, options->domain,
                                                          light->position, (rk_vec2){0, 0});
    t->shadow.count = 0;
    send(r, t, everywhere.position, everywhere.colour);
    if (t->shadow.count == 0)
        return;
    rk_shadow_stage(r, t);
    for (uint32_t k = 0; k < t->shadow.count; k++)
        if (!t->blocked.found[k])
            arrive(t, t->arriving_at[k], t->arriving[k]);
}
