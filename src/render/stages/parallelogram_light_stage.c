/* A light sends samples to all that is seen, one after the other for the whole batch: what each
 * would add, and a shadow ray to ask whether it may. A point that the first samples agree on, all
 * or none arriving, is settled, and asks no more. */
#include "render/lighting.h"

static uint32_t samples_of(const rk_rendering *r, const rk_light *light)
{
    return light->kind == RK_LIGHT_POINT ? 1 : r->options->light.samples;
}

static rk_light_sample sample_of(const rk_rendering *r, const rk_tile *t,
                                 const rk_shading_point *seen, uint32_t index, uint32_t sample)
{
    const rk_light *light = &r->scene->lights[index];
    const rk_light_options *options = &r->options->light;
    rk_vec2 xi = {0, 0};
    if (light->kind != RK_LIGHT_POINT) {
        /* Each bounce is a stream of its own, which all rays of a pixel share. */
        const rk_sample_index draw = rk_sample_index_of(t, seen->pixel);
        uint32_t bounce = r->options->max_depth - seen->path.left;
        const rk_sampler sampler = {options->sampling, r->options->seed,
                                    rk_path_samples(r, t, seen->pixel, seen->path.spread) *
                                        options->samples};
        xi = rk_sample_2d(&sampler, rk_tile_pixel(r, t, seen->pixel),
                          seen->path.sample * options->samples + sample,
                          draw.dimension + RK_DIMENSION_LIGHT +
                              2 * (bounce * RK_LIGHTS_MAX + index));
        t->counters->light_samples++;
    }
    return rk_light_sample_at(light, options->falloff, options->domain, seen->surface.point, xi);
}

/* What the sample would add to each surface; where that hangs on shadows, a ray that asks. */
static void send(const rk_rendering *r, rk_tile *t, uint32_t index, uint32_t sample)
{
    rk_tile_light_sums *sums = &t->sums;
    t->shadow.count = 0;
    for (uint32_t i = 0; i < t->seen_count; i++) {
        if (sums->state[i] == RK_LIGHT_BLOCKED)
            continue;
        const rk_shading_point *seen = &t->seen[i];
        rk_light_sample light = sample_of(r, t, seen, index, sample);
        rk_vec3 to_light = rk_sub(light.position, seen->surface.point);
        rk_vec3 arriving = rk_reflected(r, seen, to_light, light.colour);
        if (rk_is_black(arriving))
            continue;
        sums->all[i] = rk_add(sums->all[i], arriving);
        if (!r->plan.shadow_rays || sums->state[i] == RK_LIGHT_UNBLOCKED) {
            sums->lit[i] = rk_add(sums->lit[i], arriving);
            continue;
        }
        rk_queue_shadow_ray(t, i, to_light, light.position, arriving);
    }
}

static void arrive(const rk_rendering *r, rk_tile *t)
{
    rk_tile_light_sums *sums = &t->sums;
    for (uint32_t k = 0; k < t->shadow.count; k++) {
        uint32_t i = t->arriving_at[k];
        sums->asked[i]++;
        if (t->blocked.found[k])
            continue;
        sums->free[i]++;
        if (r->plan.transparency && t->tinted[k])
            sums->state[i] = RK_LIGHT_TINTED;
        sums->lit[i] = rk_add(sums->lit[i], t->arriving[k]);
    }
}

static void settle(rk_tile *t)
{
    for (uint32_t i = 0; i < t->seen_count; i++)
        if (t->sums.state[i] == RK_LIGHT_OPEN && t->sums.asked[i] > 0 &&
            rk_light_early_out(t->sums.asked[i], t->sums.free[i]))
            t->sums.state[i] = t->sums.free[i] ? RK_LIGHT_UNBLOCKED : RK_LIGHT_BLOCKED;
}

/* The ratio estimator needs the closed form: of Lambert's law, for a light of one colour. */
static bool has_closed_form(const rk_rendering *r, const rk_light *light)
{
    return r->options->light.ratio && r->options->shading.model == RK_SHADING_LAMBERT &&
           r->options->light.falloff == RK_FALLOFF_PHYSICAL && rk_light_has_one_colour(light);
}

static rk_vec3 closed_form(const rk_rendering *r, const rk_shading_point *seen,
                           const rk_light *light, rk_vec3 lit, rk_vec3 all)
{
    const rk_surface *surface = &seen->surface;
    float irradiance = rk_light_irradiance(light, surface->point, surface->normal);
    rk_vec3 unshadowed = rk_shade(&r->options->shading, seen->kd, surface->material->ks,
                                  surface->material->shininess, surface->normal, surface->normal,
                                  seen->to_viewer, rk_scale(light->colours[0], irradiance));
    return rk_light_ratio(unshadowed, lit, all);
}

void rk_parallelogram_light_stage(const rk_rendering *r, rk_tile *t, uint32_t index)
{
    const rk_light *light = &r->scene->lights[index];
    uint32_t samples = samples_of(r, light);
    for (uint32_t i = 0; i < t->seen_count; i++) {
        t->sums.lit[i] = t->sums.all[i] = rk_vec(0, 0, 0);
        t->sums.asked[i] = t->sums.free[i] = 0;
        t->sums.state[i] = RK_LIGHT_OPEN;
    }
    for (uint32_t sample = 0; sample < samples; sample++) {
        if (sample > 0 && sample == r->options->light.early_out)
            settle(t);
        send(r, t, index, sample);
        if (t->shadow.count == 0)
            continue;
        rk_shadow_stage(r, t);
        arrive(r, t);
    }
    bool in_closed_form = has_closed_form(r, light);
    for (uint32_t i = 0; i < t->seen_count; i++) {
        const rk_shading_point *seen = &t->seen[i];
        rk_vec3 mean = rk_scale(t->sums.lit[i], 1 / (float)samples);
        if (in_closed_form && !rk_is_black(t->sums.all[i]))
            mean = closed_form(r, seen, light, t->sums.lit[i], t->sums.all[i]);
        rk_vec3 *sum = &t->sum[seen->pixel];
        *sum = rk_add(*sum, rk_mul(seen->path.weight, mean));
    }
}
