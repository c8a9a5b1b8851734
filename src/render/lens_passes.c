/* Samples are taken in groups, each pixel's in an order in which neighbours' rays are close
 * together; their radiance is kept until it can be added in the usual order. */
#include "render/lens_passes.h"

#include "render/feature_hooks.h"
#include "render/lens_rays.h"
#include "render/render_sample.h"

#include <string.h>

/* Adding a number for each sample, in another order of samples, would round differently. So the
 * radiance of a group is kept until it can be added in theirs; which gives the same sum only if a
 * sample adds to its pixel once. */
typedef struct group_radiance {
    rk_vec3 of[RK_LENS_GROUP_MAX][RK_BATCH_MAX]; /* by sample and lens pixel */
} group_radiance;

static bool adds_once(const rk_rendering *r)
{
    uint32_t lights = 0;
    for (uint32_t i = 0; i < r->scene->light_count; i++)
        lights += rk_light_emits(&r->scene->lights[i]);
    return lights <= 1 && !r->plan.reflections && !r->plan.transparency && !r->plan.motion_blur &&
           !rk_features_any_shade(&r->plan);
}

static void take_out(const rk_sample_pass *pass, rk_film *film, group_radiance *radiance)
{
    const uint8_t *sample = pass->lens_group->order[pass->lens_round];
    for (uint32_t i = 0; i < pass->lens->count; i++) {
        rk_vec3 *sum = &film->sum[pass->lens->pixel[i]];
        radiance->of[sample[i]][i] = *sum;
        *sum = rk_vec(0, 0, 0);
    }
}

static void add_group(const rk_sample_pass *pass, const group_radiance *radiance, rk_film *film)
{
    for (uint32_t s = 0; s < pass->lens_group->count; s++)
        for (uint32_t i = 0; i < pass->lens->count; i++)
            rk_film_add(film, pass->lens->pixel[i], radiance->of[s][i]);
}

void rk_lens_passes(const rk_rendering *r, rk_sample_pass *pass, rk_path_workspace *workspace,
                    rk_film *film)
{
    const bool sorts = adds_once(r);
    rk_lens_group group;
    rk_film own;
    group_radiance radiance;
    pass->lens_group = &group;
    memset(&own, 0, sizeof own);
    for (uint32_t first = 0; first < pass->samples; first += group.count) {
        const uint32_t left = pass->samples - first;
        rk_lens_group_start(&group, pass->lens, first,
                            left < RK_LENS_GROUP_MAX ? left : RK_LENS_GROUP_MAX);
        if (sorts)
            rk_lens_group_sort(&group, pass->lens);
        for (pass->lens_round = 0; pass->lens_round < group.count; pass->lens_round++) {
            pass->sample = first + pass->lens_round;
            rk_render_sample(r, pass, workspace, sorts ? &own : film);
            if (sorts)
                take_out(pass, &own, &radiance);
        }
        if (sorts)
            add_group(pass, &radiance, film);
    }
}
