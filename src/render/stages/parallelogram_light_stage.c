#include "render/stages/parallelogram_light_stage.h"

#include "render/stages/highlight_stage.h"

static uint32_t samples_of(const rk_rendering *r, const rk_light *light)
{
    return light->kind == RK_LIGHT_POINT ? 1 : r->options->light.samples;
}

static void start(const rk_shading_points *points, rk_light_sums *sums)
{
    for (uint32_t i = 0; i < points->count; i++) {
        sums->shadowed[i] = sums->unshadowed[i] = rk_vec(0, 0, 0);
        sums->traced[i] = sums->unoccluded[i] = 0;
        sums->visibility[i] = RK_LIGHT_UNDECIDED;
    }
}

/* Each bounce and light has dimensions of its own; all paths of a pixel are one set of samples. */
rk_vec2 rk_light_random(const rk_rendering *r, const rk_sample_pass *pass,
                        const rk_shading_point *point, uint32_t light, uint32_t dimension,
                        uint32_t samples, uint32_t sample)
{
    const rk_path *path = &point->path;
    const rk_sample_index index = rk_sample_index_of(pass, point->pixel);
    uint32_t bounce = r->options->max_depth - path->bounces_left;
    uint32_t paths = index.samples * (path->split ? r->options->glossy.samples : 1);
    uint32_t pixel = rk_picture_pixel(pass, r->options->width, point->pixel);
    const rk_sampler sampler = {r->options->light.sampling, r->options->seed, paths * samples};
    return rk_joint_2d(&sampler, pixel, path->sample * samples + sample,
                       index.dimension + dimension + 2 * (bounce * RK_LIGHTS_MAX + light));
}

static rk_light_sample light_sample(const rk_rendering *r, const rk_sample_pass *pass,
                                    const rk_shading_point *point, uint32_t index, uint32_t sample)
{
    const rk_light *light = &r->scene->lights[index];
    const rk_light_options *options = &r->options->light;
    rk_vec2 xi = {0, 0};
    if (light->kind != RK_LIGHT_POINT) {
        xi = rk_light_random(r, pass, point, index, RK_DIMENSION_LIGHT, options->samples, sample);
        pass->counters->light_samples++;
    }
    return rk_light_sample_at(light, options->falloff, options->domain, point->surface.point, xi);
}

/* Contributions of undecided points wait for their shadow rays; others count at once. */
static void queue_shadow_rays(const rk_rendering *r, const rk_sample_pass *pass,
                              const rk_shading_points *points, uint32_t index, uint32_t sample,
                              rk_light_sums *sums, rk_shadow_queue *queue)
{
    queue->rays.count = 0;
    for (uint32_t i = 0; i < points->count; i++) {
        if (sums->visibility[i] == RK_LIGHT_OCCLUDED)
            continue;
        const rk_shading_point *point = &points->points[i];
        rk_light_sample light = light_sample(r, pass, point, index, sample);
        rk_vec3 to_light = rk_sub(light.position, point->surface.point);
        rk_vec3 contribution =
            r->plan.sharp_highlights && sums->solid_angle[i] > 0
                ? rk_highlight_of_light_sample(r, point, &r->scene->lights[index],
                                               sums->solid_angle[i], &light)
                : rk_reflected_radiance(&r->options->shading, point, to_light, light.colour);
        if (rk_is_black(contribution))
            continue;
        sums->unshadowed[i] = rk_add(sums->unshadowed[i], contribution);
        if (!r->plan.shadow_rays || sums->visibility[i] == RK_LIGHT_UNOCCLUDED)
            sums->shadowed[i] = rk_add(sums->shadowed[i], contribution);
        else
            rk_queue_shadow_ray(queue, points, i, to_light, light.position, contribution);
    }
}

static bool is_attenuated(const rk_rendering *r, const rk_shadow_answers *answers, uint32_t k)
{
    const rk_vec3 *t = &answers->transmittance[k];
    return r->plan.transparency && (t->x < 1 || t->y < 1 || t->z < 1);
}

static void trace(const rk_rendering *r, rk_sample_pass *pass, const rk_shadow_queue *queue,
                  rk_shadow_answers *answers, rk_light_sums *sums)
{
    if (queue->rays.count == 0)
        return;
    rk_shadow_stage(r, pass, queue, answers);
    for (uint32_t k = 0; k < queue->rays.count; k++) {
        uint32_t i = queue->point[k];
        sums->traced[i]++;
        if (answers->occlusion.occluded[k])
            continue;
        sums->unoccluded[i]++;
        if (is_attenuated(r, answers, k))
            sums->visibility[i] = RK_LIGHT_ATTENUATED;
        sums->shadowed[i] = rk_add(sums->shadowed[i], rk_unoccluded(r, queue, answers, k));
    }
}

static void early_out(const rk_shading_points *points, rk_light_sums *sums)
{
    for (uint32_t i = 0; i < points->count; i++)
        if (sums->visibility[i] == RK_LIGHT_UNDECIDED && sums->traced[i] > 0 &&
            rk_light_early_out(sums->traced[i], sums->unoccluded[i]))
            sums->visibility[i] = sums->unoccluded[i] ? RK_LIGHT_UNOCCLUDED : RK_LIGHT_OCCLUDED;
}

/* The ratio estimator needs the closed form, which exists for Lambert's law and a light of one
 * colour. */
static bool has_closed_form(const rk_rendering *r, const rk_light *light)
{
    return r->options->light.ratio && r->options->shading.model == RK_SHADING_LAMBERT &&
           r->options->light.falloff == RK_FALLOFF_PHYSICAL && rk_light_has_one_colour(light);
}

static rk_vec3 closed_form(const rk_rendering *r, const rk_shading_point *point,
                           const rk_light *light, rk_vec3 shadowed, rk_vec3 unshadowed)
{
    const rk_surface *surface = &point->surface;
    float irradiance = rk_light_irradiance(light, surface->point, surface->normal);
    rk_vec3 exact = rk_shade(&r->options->shading, point->kd, surface->material->ks,
                             surface->material->shininess, surface->normal, surface->normal,
                             point->to_viewer, rk_scale(light->colours[0], irradiance));
    return rk_light_ratio(exact, shadowed, unshadowed);
}

static void add_means(const rk_rendering *r, const rk_shading_points *points, const rk_light *light,
                      const rk_light_sums *sums, rk_film *film)
{
    bool in_closed_form = has_closed_form(r, light);
    for (uint32_t i = 0; i < points->count; i++) {
        const rk_shading_point *point = &points->points[i];
        rk_vec3 mean = rk_scale(sums->shadowed[i], 1 / (float)samples_of(r, light));
        if (in_closed_form && !rk_is_black(sums->unshadowed[i]))
            mean = closed_form(r, point, light, sums->shadowed[i], sums->unshadowed[i]);
        rk_film_add(film, point->pixel, rk_mul(point->path.throughput, mean));
    }
}

void rk_parallelogram_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                                  const rk_shading_points *points, uint32_t index,
                                  rk_shadow_queue *queue, rk_shadow_answers *answers,
                                  rk_light_sums *sums, rk_film *film)
{
    const rk_light *light = &r->scene->lights[index];
    uint32_t samples = samples_of(r, light);
    uint32_t directions = 0;
    start(points, sums);
    if (r->plan.sharp_highlights)
        directions = rk_highlight_start(r, points, light, sums);
    for (uint32_t sample = 0; sample < samples; sample++) {
        if (sample > 0 && sample == r->options->light.early_out)
            early_out(points, sums);
        queue_shadow_rays(r, pass, points, index, sample, sums, queue);
        trace(r, pass, queue, answers, sums);
    }
    for (uint32_t sample = 0; sample < directions; sample++) {
        rk_highlight_stage(r, pass, points, index, sample, sums, queue);
        trace(r, pass, queue, answers, sums);
    }
    add_means(r, points, light, sums, film);
}

/* --- The feature ----------------------------------------------------------------------------- */

RK_NAMES(rk_light_domain_names, rk_light_domain, RK_LIGHT_DOMAIN_SOLID_ANGLE, "area",
         "solid-angle");
RK_NAMES(rk_light_falloff_names, rk_light_falloff, RK_FALLOFF_PHYSICAL, "none", "physical");

RK_NAMES(rk_highlight_names, rk_highlight_sampling, RK_HIGHLIGHT_BALANCE, "light", "balance");

static const rk_option rows[] = {
    {"light-samples", RK_FIELD(rk_render_options, light.samples), "N",
     "samples per light with an extent and shading point", 1, RK_SAMPLES_MAX, 16},
    {"light-sampling", RK_CHOICE(rk_render_options, light.sampling, rk_sampler_names),
     "distribution of the samples over the light", .initial = RK_SAMPLER_SOBOL},
    {"light-domain", RK_CHOICE(rk_render_options, light.domain, rk_light_domain_names),
     "samples are uniform over the light's area, or over its solid angle", .alias = "light-map"},
    {"highlights", RK_CHOICE(rk_render_options, light.highlights, rk_highlight_names),
     "sample sharp highlights by the light alone, or by directions of their lobe, too",
     .initial = RK_HIGHLIGHT_BALANCE},
    {"falloff", RK_CHOICE(rk_render_options, light.falloff, rk_light_falloff_names),
     "does light decrease with distance and slant?"},
    {"ratio", RK_FIELD(rk_render_options, light.ratio), NULL,
     "ratio estimator: unshadowed light in closed form, times the sampled ratio; for a "
     "parallelogram of one colour with --falloff physical and Lambert's law"},
    {"early-out", RK_FIELD(rk_render_options, light.early_out), "N",
     "stop after this many shadow rays if all or none of them are occluded; 0: trace all", 0,
     RK_SAMPLES_MAX, RK_LIGHT_EARLY_OUT, .alias = "settle"},
    {0},
};

static bool is_wide(const rk_light *light)
{
    return light->kind != RK_LIGHT_POINT && rk_light_emits(light);
}

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    (void)options;
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (is_wide(&scene->lights[i]))
            return true;
    return false;
}

static uint32_t samples(const rk_scene *scene, const rk_render_options *options)
{
    (void)scene;
    return options->light.samples;
}

const rk_feature rk_parallelogram_light_feature = {.stem = "parallelogram_light",
                                                   .options = rows,
                                                   .takes = "a light that is not a point",
                                                   .wanted = wanted,
                                                   .samples = samples};
