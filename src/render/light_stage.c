/* A light sends samples to all that is seen, one after the other for the whole batch: what each
 * would add, and a shadow ray to ask whether it may. A point that the first samples agree on, all
 * or none arriving, is settled, and asks no more. */
#include "render/tile.h"

static bool is_black(rk_vec3 colour)
{
    return colour.x == 0 && colour.y == 0 && colour.z == 0;
}

static uint32_t samples_of(const rk_rendering *r, const rk_light *light)
{
    return light->kind == RK_LIGHT_POINT ? 1 : r->options->light.samples;
}

static rk_light_sample sample_of(const rk_rendering *r, const rk_tile *t, const rk_seen *seen,
                                 uint32_t index, uint32_t sample)
{
    const rk_light *light = &r->scene->lights[index];
    const rk_light_options *options = &r->options->light;
    rk_vec2 xi = {0, 0};
    if (light->kind != RK_LIGHT_POINT) {
        /* Each bounce is a stream of its own, which all rays of a pixel share. */
        const rk_draw draw = rk_draw_of(t, seen->pixel);
        uint32_t bounce = r->options->recursion - seen->left;
        const rk_sampler sampler = {options->sampling, r->options->seed,
                                    rk_path_samples(r, t, seen->pixel, seen->sample) *
                                        options->samples};
        xi = rk_sample_2d(&sampler, rk_tile_pixel(r, t, seen->pixel),
                          seen->sample.index * options->samples + sample,
                          draw.dimension + RK_DIMENSION_LIGHT +
                              2 * (bounce * RK_LIGHTS_MAX + index));
        t->counters->light_samples++;
    }
    return rk_light_sample_at(light, options->falloff, options->map, seen->surface.point, xi);
}

/* What the sample would add to each surface; where that hangs on shadows, a ray that asks. */
static void send(const rk_rendering *r, rk_tile *t, uint32_t index, uint32_t sample)
{
    rk_light_sums *sums = &t->sums;
    t->arriving_count = 0;
    t->shadow.count = 0;
    for (uint32_t i = 0; i < t->seen_count; i++) {
        if (sums->state[i] == RK_LIGHT_BLOCKED)
            continue;
        const rk_seen *seen = &t->seen[i];
        const rk_surface *surface = &seen->surface;
        rk_light_sample light = sample_of(r, t, seen, index, sample);
        rk_vec3 to_light = rk_sub(light.position, surface->point);
        rk_vec3 arriving = rk_shade(&r->options->shading, seen->kd, surface->material->ks,
                                    surface->material->shininess, surface->normal,
                                    rk_normalize(to_light), seen->to_viewer, light.colour);
        if (is_black(arriving))
            continue;
        sums->all[i] = rk_add(sums->all[i], arriving);
        if (!r->plan.shadow_rays || sums->state[i] == RK_LIGHT_UNBLOCKED) {
            sums->lit[i] = rk_add(sums->lit[i], arriving);
            continue;
        }
        /* From the point, t = 0, to the light, t = 1. */
        rk_vec3 start = rk_surface_leave(surface, to_light);
        rk_ray ray = {start, rk_sub(light.position, start), 1};
        rk_batch_push(&t->shadow, &ray);
        t->arriving_at[t->arriving_count] = (uint16_t)i;
        t->arriving[t->arriving_count++] = arriving;
    }
}

/* Shadow rays are traced at the time of the pixel that they are for. */
static rk_moments shadow_moments(rk_asker *asker, uint16_t *pixels)
{
    const rk_tile *t = asker->t;
    for (uint32_t k = 0; k < t->arriving_count; k++)
        pixels[k] = t->seen[t->arriving_at[k]].pixel;
    return rk_moments_of(asker);
}

static void arrive_or_not(const rk_rendering *r, rk_tile *t)
{
    rk_any_batch blocked;
    if (r->plan.motion) {
        uint16_t pixels[RK_BATCH_MAX];
        rk_asker asker = {r, t, pixels, false};
        const rk_moments when = shadow_moments(&asker, pixels);
        rk_accel_any_at(r->accel, &t->shadow, &when, &blocked, t->counters);
    } else {
        rk_accel_any(r->accel, &t->shadow, &blocked, t->counters);
    }
    for (uint32_t k = 0; k < t->arriving_count; k++) {
        uint32_t i = t->arriving_at[k];
        t->sums.asked[i]++;
        if (blocked.found[k])
            continue;
        t->sums.free[i]++;
        t->sums.lit[i] = rk_add(t->sums.lit[i], t->arriving[k]);
    }
}

/* Through panes, a part of the light arrives. */
static void arrive_in_part(const rk_rendering *r, rk_tile *t)
{
    uint16_t pixels[RK_BATCH_MAX];
    rk_asker asker = {r, t, pixels, false};
    const rk_moments when = shadow_moments(&asker, pixels);
    for (uint32_t k = 0; k < t->arriving_count; k++) {
        uint32_t i = t->arriving_at[k];
        rk_ray ray = rk_batch_ray(&t->shadow, k);
        rk_vec3 share = rk_crossings_transmit_at(r->accel, &ray, r->plan.motion ? &when : NULL, k,
                                                 r->options->glass, t->counters);
        bool tinted = share.x < 1 || share.y < 1 || share.z < 1;
        if (tinted && !is_black(share))
            t->sums.state[i] = RK_LIGHT_TINTED;
        t->sums.asked[i]++;
        t->sums.free[i] = (uint16_t)(t->sums.free[i] + !is_black(share));
        t->sums.lit[i] = rk_add(t->sums.lit[i], rk_mul(t->arriving[k], share));
    }
}

static void settle(rk_tile *t)
{
    for (uint32_t i = 0; i < t->seen_count; i++)
        if (t->sums.state[i] == RK_LIGHT_OPEN && t->sums.asked[i] > 0 &&
            rk_light_settled(t->sums.asked[i], t->sums.free[i]))
            t->sums.state[i] = t->sums.free[i] ? RK_LIGHT_UNBLOCKED : RK_LIGHT_BLOCKED;
}

/* The ratio estimator needs the closed form: of Lambert's law, for a light of one colour. */
static bool has_closed_form(const rk_rendering *r, const rk_light *light)
{
    return r->options->light.ratio && r->options->shading.model == RK_SHADING_LAMBERT &&
           r->options->light.falloff == RK_FALLOFF_PHYSICAL && rk_light_has_one_colour(light);
}

static rk_vec3 closed_form(const rk_rendering *r, const rk_seen *seen, const rk_light *light,
                           rk_vec3 lit, rk_vec3 all)
{
    const rk_surface *surface = &seen->surface;
    float irradiance = rk_light_irradiance(light, surface->point, surface->normal);
    rk_vec3 unshadowed = rk_shade(&r->options->shading, seen->kd, surface->material->ks,
                                  surface->material->shininess, surface->normal, surface->normal,
                                  seen->to_viewer, rk_scale(light->colours[0], irradiance));
    return rk_light_ratio(unshadowed, lit, all);
}

void rk_light_stage(const rk_rendering *r, rk_tile *t, uint32_t index)
{
    const rk_light *light = &r->scene->lights[index];
    uint32_t samples = samples_of(r, light);
    for (uint32_t i = 0; i < t->seen_count; i++) {
        t->sums.lit[i] = t->sums.all[i] = rk_vec(0, 0, 0);
        t->sums.asked[i] = t->sums.free[i] = 0;
        t->sums.state[i] = RK_LIGHT_OPEN;
    }
    for (uint32_t sample = 0; sample < samples; sample++) {
        if (sample > 0 && sample == r->options->light.settle)
            settle(t);
        send(r, t, index, sample);
        t->counters->shadow_rays += t->shadow.count;
        if (t->shadow.count && r->plan.transparency)
            arrive_in_part(r, t);
        else if (t->shadow.count)
            arrive_or_not(r, t);
    }
    bool in_closed_form = has_closed_form(r, light);
    for (uint32_t i = 0; i < t->seen_count; i++) {
        const rk_seen *seen = &t->seen[i];
        rk_vec3 mean = rk_scale(t->sums.lit[i], 1 / (float)samples);
        if (in_closed_form && !is_black(t->sums.all[i]))
            mean = closed_form(r, seen, light, t->sums.lit[i], t->sums.all[i]);
        rk_vec3 *sum = &t->sum[seen->pixel];
        *sum = rk_add(*sum, rk_mul(seen->weight, mean));
    }
}
