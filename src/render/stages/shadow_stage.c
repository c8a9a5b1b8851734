/* Is something in the way of the light that is on its way? A ray to the light asks, at the time of
 * the pixel that it is for; panes take a part. */
#include "render/lighting.h"

static void block(const rk_rendering *r, rk_tile *t, const rk_moments *when)
{
    if (when)
        rk_accel_any_at(r->accel, &t->shadow, when, &t->blocked, t->counters);
    else
        rk_accel_occluded(r->accel, &t->shadow, &t->blocked, t->counters);
}

static void tint(const rk_rendering *r, rk_tile *t, const rk_moments *when)
{
    for (uint32_t k = 0; k < t->shadow.count; k++) {
        rk_ray ray = rk_batch_ray(&t->shadow, k);
        rk_vec3 share =
            rk_crossings_transmit_at(r->accel, &ray, when, k, r->options->glass, t->counters);
        t->tinted[k] = share.x < 1 || share.y < 1 || share.z < 1;
        t->blocked.found[k] = rk_is_black(share);
        t->arriving[k] = rk_mul(t->arriving[k], share);
    }
}

void rk_shadow_stage(const rk_rendering *r, rk_tile *t)
{
    uint16_t pixels[RK_BATCH_MAX];
    rk_asker asker = {r, t, pixels, false};
    rk_moments moments;
    t->counters->shadow_rays += t->shadow.count;
    if (r->plan.motion) {
        for (uint32_t k = 0; k < t->shadow.count; k++)
            pixels[k] = t->seen[t->arriving_at[k]].pixel;
        moments = rk_moments_of(&asker);
    }
    if (r->plan.transparency)
        tint(r, t, r->plan.motion ? &moments : NULL);
    else
        block(r, t, r->plan.motion ? &moments : NULL);
}
