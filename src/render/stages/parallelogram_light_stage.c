/* Samples of all points are queued in runs; a batch of shadow rays is traced when it is full.
 * Points that need no random samples have been decided before
 * (render/stages/unoccluded_light_stage.h). */
#include "render/stages/parallelogram_light_stage.h"

#include "base/simd4.h"
#include "render/stages/highlight_stage.h"
#include "render/stages/unoccluded_light_stage.h"

/* After an early out, this many of the next rays are traced, per as many as the first. */
enum { EARLY_OUT_CHECKS = 2 };

/* Beside the light's and the lobes' dimensions. */
enum { RK_DIMENSION_EARLY_OUT = RK_DIMENSION_LIGHT + 3 * (1 << 14) };

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
void rk_light_random(const rk_rendering *r, const rk_sample_pass *pass,
                     const rk_shading_point *point, uint32_t light, uint32_t dimension,
                     uint32_t samples, uint32_t first, uint32_t count, rk_vec2 *numbers)
{
    const rk_path *path = &point->path;
    const rk_sample_index index = rk_sample_index_of(pass, point->pixel);
    uint32_t bounce = r->options->max_depth - path->bounces_left;
    uint32_t paths = index.samples * (path->split ? r->options->glossy.samples : 1);
    uint32_t pixel = rk_picture_pixel(pass, r->options->width, point->pixel);
    const rk_sampler sampler =
        rk_render_sampler(r->options, r->options->light.sampling, paths * samples);
    rk_joint_run(&r->joint_runs, &sampler, pixel, path->sample * samples + first, count,
                 index.dimension + dimension + 2 * (bounce * RK_LIGHTS_MAX + light), numbers);
}

static bool is_decided(const rk_light_sums *sums, uint32_t i)
{
    return sums->visibility[i] == RK_LIGHT_UNOCCLUDED || sums->visibility[i] == RK_LIGHT_OCCLUDED;
}

/* Consecutive samples of one light. */
typedef struct sample_run {
    uint32_t light, first, count;
} sample_run;

/* After an early out, one ray of each run of this length is traced all the same, and stands for all
 * of them, so that the mean is right however small the part of the light that the first rays
 * missed. */
static uint32_t checked_run(const rk_rendering *r)
{
    const uint32_t rays = r->options->light.early_out / EARLY_OUT_CHECKS;
    return rays < 1 ? 1 : rays < RK_LIGHT_RUN_MAX ? rays : RK_LIGHT_RUN_MAX;
}

/* The sample of the run whose ray is traced, at random; of a run cut short, maybe none. */
static uint32_t checked_sample(const rk_rendering *r, const rk_sample_pass *pass,
                               const rk_shading_point *point, sample_run run)
{
    const rk_path *path = &point->path;
    const uint32_t bounce = r->options->max_depth - path->bounces_left;
    const uint32_t random =
        rk_hash(r->options->seed, rk_picture_pixel(pass, r->options->width, point->pixel),
                path->sample * r->options->light.samples + run.first,
                rk_sample_index_of(pass, point->pixel).dimension + RK_DIMENSION_EARLY_OUT +
                    bounce * RK_LIGHTS_MAX + run.light);
    return (uint32_t)(rk_unit_float(random) * (float)checked_run(r));
}

static void draw(const rk_rendering *r, const rk_sample_pass *pass, const rk_shading_point *point,
                 sample_run run, rk_vec2 numbers[RK_LIGHT_RUN_MAX])
{
    if (r->scene->lights[run.light].kind == RK_LIGHT_POINT) {
        numbers[0] = (rk_vec2){0, 0};
        return;
    }
    rk_light_random(r, pass, point, run.light, RK_DIMENSION_LIGHT, r->options->light.samples,
                    run.first, run.count, numbers);
    pass->counters->light_samples += run.count;
}

/* Unit directions from the point to the samples, four at once. Lanes beyond the last sample hold
 * anything. */
static void find_directions(const rk_shading_point *point, const rk_light_sample *samples,
                            uint32_t count, float to_light[3][RK_LIGHT_RUN_MAX])
{
    const rk_simd4x3 from = rk_simd4x3_all(point->surface.point);
    for (uint32_t k = 0; k < count; k += RK_SIMD4_WIDTH) {
        const rk_simd4x3 to = rk_simd4x3_load(&samples[k].position, &samples[k + 1].position,
                                              &samples[k + 2].position, &samples[k + 3].position);
        const rk_simd4x3 d = rk_simd4x3_normalize(rk_simd4x3_sub(to, from));
        rk_simd4_store(&to_light[0][k], d.x);
        rk_simd4_store(&to_light[1][k], d.y);
        rk_simd4_store(&to_light[2][k], d.z);
    }
}

void rk_light_contributions(const rk_rendering *r, const rk_shading_point *point,
                            const rk_light *light, double solid_angle, uint32_t count,
                            const rk_light_sample *samples, rk_vec3 *contributions)
{
    float d[3][RK_LIGHT_RUN_MAX];
    if (solid_angle > 0) {
        for (uint32_t k = 0; k < count; k++)
            contributions[k] =
                rk_highlight_of_light_sample(r, point, light, solid_angle, &samples[k]);
        return;
    }
    find_directions(point, samples, count, d);
    for (uint32_t k = 0; k < count; k++)
        contributions[k] = rk_reflected_radiance_from(
            &r->options->shading, point, rk_vec(d[0][k], d[1][k], d[2][k]), samples[k].colour);
}

/* The samples of one shading point. Contributions of an undecided point wait for their shadow rays;
 * others count at once, and are corrected by a ray that disagrees. */
static void queue_shadow_rays(const rk_rendering *r, const rk_sample_pass *pass,
                              const rk_shading_points *points, uint32_t i, sample_run run,
                              rk_light_sums *sums, rk_shadow_queue *queue)
{
    const rk_light_options *options = &r->options->light;
    const rk_light *light = &r->scene->lights[run.light];
    const rk_shading_point *point = &points->points[i];
    const rk_light_visibility visibility = sums->visibility[i];
    const bool decided = is_decided(sums, i);
    const bool all_count = !r->plan.shadow_rays || visibility == RK_LIGHT_CLEAR;
    const double solid_angle = r->plan.sharp_highlights ? sums->solid_angle[i] : 0;
    const float stands_for = decided ? (float)checked_run(r) : 1;
    uint32_t checked = decided ? checked_sample(r, pass, point, run) : 0;
    rk_vec2 numbers[RK_LIGHT_RUN_MAX];
    rk_light_sample samples[RK_LIGHT_RUN_MAX];
    rk_vec3 contributions[RK_LIGHT_RUN_MAX];
    rk_spawner spawner;
    if (visibility == RK_LIGHT_SUMMED)
        return;
    if (visibility == RK_LIGHT_OCCLUDED) {
        if (checked >= run.count)
            return;
        run = (sample_run){run.light, run.first + checked, 1};
        checked = 0;
    }
    draw(r, pass, point, run, numbers);
    for (uint32_t k = 0; k < run.count; k++)
        samples[k] = rk_light_sample_at(light, options->falloff, options->domain,
                                        point->surface.point, numbers[k]);
    rk_light_contributions(r, point, light, solid_angle, run.count, samples, contributions);
    rk_spawner_start(&spawner, &point->surface);
    for (uint32_t k = 0; k < run.count; k++) {
        const rk_vec3 contribution = contributions[k];
        if (rk_is_black(contribution))
            continue;
        sums->unshadowed[i] = rk_madd(sums->unshadowed[i], contribution,
                                      visibility == RK_LIGHT_OCCLUDED ? stands_for : 1);
        if (all_count || visibility == RK_LIGHT_UNOCCLUDED)
            sums->shadowed[i] = rk_add(sums->shadowed[i], contribution);
        if (!all_count && (!decided || k == checked)) {
            rk_vec3 to_light = rk_sub(samples[k].position, point->surface.point);
            rk_queue_contribution(queue, point, i, rk_scale(contribution, stands_for));
            rk_queue_shadow_ray(queue, rk_spawner_origin_to_light(&spawner, to_light),
                                samples[k].position);
        }
    }
}

static bool is_attenuated(const rk_rendering *r, const rk_shadow_answers *answers, uint32_t k)
{
    const rk_vec3 *t = &answers->transmittance[k];
    return r->plan.transparency && (t->x < 1 || t->y < 1 || t->z < 1);
}

/* A ray that disagrees with the decision reverses it. */
static void trace(const rk_rendering *r, rk_sample_pass *pass, rk_shadow_queue *queue,
                  rk_shadow_answers *answers, rk_light_sums *sums)
{
    if (queue->rays.count == 0)
        return;
    rk_shadow_stage(r, pass, queue, answers);
    for (uint32_t k = 0; k < queue->rays.count; k++) {
        const uint32_t i = queue->point[k];
        const bool occluded = answers->occlusion.occluded[k];
        const bool attenuated = !occluded && is_attenuated(r, answers, k);
        rk_vec3 seen = occluded ? rk_vec(0, 0, 0) : rk_unoccluded(r, queue, answers, k);
        sums->traced[i]++;
        sums->unoccluded[i] += !occluded;
        if (sums->visibility[i] == RK_LIGHT_UNOCCLUDED)
            seen = rk_sub(seen, queue->contribution[k]);
        if (is_decided(sums, i) && occluded == (sums->visibility[i] == RK_LIGHT_UNOCCLUDED))
            sums->visibility[i] = RK_LIGHT_UNDECIDED;
        if (attenuated)
            sums->visibility[i] = RK_LIGHT_ATTENUATED;
        sums->shadowed[i] = rk_add(sums->shadowed[i], seen);
    }
    queue->rays.count = 0;
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

/* A point's samples are queued `run` at a time, those of all points one after the other. */
static void sample_light(const rk_rendering *r, rk_sample_pass *pass,
                         const rk_shading_points *points, sample_run all, uint32_t run,
                         rk_shadow_queue *queue, rk_shadow_answers *answers, rk_light_sums *sums)
{
    const uint32_t end = all.first + all.count;
    for (sample_run now = all; now.first < end; now.first += now.count) {
        now.count = end - now.first < run ? end - now.first : run;
        for (uint32_t i = 0; i < points->count; i++) {
            if (queue->rays.count + now.count > RK_BATCH_MAX)
                trace(r, pass, queue, answers, sums);
            queue_shadow_rays(r, pass, points, i, now, sums, queue);
        }
        trace(r, pass, queue, answers, sums);
    }
}

void rk_parallelogram_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                                  const rk_shading_points *points, uint32_t index,
                                  rk_shadow_queue *queue, rk_shadow_answers *answers,
                                  rk_light_sums *sums, rk_film *film)
{
    const rk_light *light = &r->scene->lights[index];
    const uint32_t samples = samples_of(r, light), early = r->options->light.early_out;
    const uint32_t first_round = early > 0 && early < samples ? early : samples;
    uint32_t directions = 0;
    start(points, sums);
    queue->rays.count = 0;
    if (light->kind != RK_LIGHT_POINT)
        rk_unoccluded_light_stage(r, pass, points, index, sums);
    if (r->plan.sharp_highlights)
        directions = rk_highlight_start(r, points, light, sums);
    sample_light(r, pass, points, (sample_run){index, 0, first_round}, RK_LIGHT_RUN_MAX, queue,
                 answers, sums);
    if (first_round < samples) {
        early_out(points, sums);
        sample_light(r, pass, points, (sample_run){index, first_round, samples - first_round},
                     checked_run(r), queue, answers, sums);
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

RK_NAMES(rk_light_visibility_names, rk_light_visibility_method, RK_LIGHT_PYRAMIDS, "rays",
         "pyramids");

RK_NAMES(rk_highlight_names, rk_highlight_sampling, RK_HIGHLIGHT_BALANCE, "light", "balance");

static const rk_option rows[] = {
    {"light-samples", RK_FIELD(rk_render_options, light.samples), "N",
     "samples per light with an extent and shading point", 1, RK_SAMPLES_MAX, 16},
    {"light-sampling", RK_CHOICE(rk_render_options, light.sampling, rk_sampler_names),
     "distribution of the samples over the light", .initial = RK_SAMPLER_SOBOL},
    {"light-domain", RK_CHOICE(rk_render_options, light.domain, rk_light_domain_names),
     "samples are uniform over the light's area, or over its solid angle", .alias = "light-map"},
    {"light-visibility", RK_CHOICE(rk_render_options, light.visibility, rk_light_visibility_names),
     "shadow rays for all samples, or not where the pyramid from the point to the light is empty",
     .initial = RK_LIGHT_PYRAMIDS},
    {"highlights", RK_CHOICE(rk_render_options, light.highlights, rk_highlight_names),
     "sample sharp highlights by the light alone, or by directions of their lobe, too",
     .initial = RK_HIGHLIGHT_BALANCE},
    {"falloff", RK_CHOICE(rk_render_options, light.falloff, rk_light_falloff_names),
     "does light decrease with distance and slant?"},
    {"ratio", RK_FIELD(rk_render_options, light.ratio), NULL,
     "ratio estimator: unshadowed light in closed form, times the sampled ratio; for a "
     "parallelogram of one colour with --falloff physical and Lambert's law"},
    {"early-out", RK_FIELD(rk_render_options, light.early_out), "N",
     "trace few more than this many shadow rays if all or none of them are occluded; 0: trace all",
     0, RK_SAMPLES_MAX, 0, .alias = "settle"},
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

static bool prepare(rk_rendering *r, rk_error *error)
{
    (void)error;
    r->joint_runs = rk_joint_runs_of();
    return true;
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
                                                   .samples = samples,
                                                   .prepare = prepare};
