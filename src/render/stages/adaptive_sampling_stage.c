/* A round is a job for all threads, tile by tile; between rounds one thread plans the next
 * (render/stages/adaptive_plan.h). Each generation has a seed of its own. */
#include "render/stages/adaptive_sampling_stage.h"

#include "features/shading.h"
#include "render/render_sample.h"
#include "render/stages/adaptive_plan.h"
#include "render/stages/depth_of_field_stage.h"
#include "render/tile_run.h"
#include "render/tiles.h"

#include <string.h>

typedef struct adaptive_job {
    rk_rendering rendering; /* with its own options: each generation has another seed */
    rk_render_options options;
    rk_path_workspace *workspaces; /* one per thread */
    rk_counters *counters;         /* one per thread */
    rk_adaptive_plan plan;
} adaptive_job;

/* --- A round ---------------------------------------------------------------------------------- */

/* Renders the samples that the pass has gathered, and adds each to its pixel. */
static void take_samples(const adaptive_job *job, rk_sample_pass *pass,
                         rk_path_workspace *workspace, rk_film *film)
{
    if (pass->wanted_count == 0)
        return;
    rk_render_sample(&job->rendering, pass, workspace, film);
    for (uint32_t i = 0; i < pass->wanted_count; i++) {
        const size_t pixel = rk_picture_pixel(pass, job->options.width, i);
        rk_adaptive_add(&job->plan.samples[pixel], pass->wanted[i].sample, film->sum[i]);
        film->sum[i] = rk_vec(0, 0, 0);
    }
    pass->wanted_count = 0;
}

/* A pixel's new samples follow each other, so that their rays traverse the tree as packets however
 * few pixels take many. */
static void render_pixel(const adaptive_job *job, rk_sample_pass *pass, uint32_t pixel,
                         rk_path_workspace *workspace, rk_film *film)
{
    const rk_tile *tile = &pass->tile;
    const uint32_t x = tile->x + pixel % tile->width, y = tile->y + pixel / tile->width;
    const size_t at = (size_t)y * job->options.width + x;
    const uint32_t first = job->plan.samples[at].count, end = job->plan.counts[at];
    if (!rk_is_in_pass(&job->rendering, pass, x, y))
        return;
    rk_adaptive_extend(&job->plan.samples[at], end);
    for (uint32_t sample = first; sample < end; sample++) {
        pass->wanted[pass->wanted_count++] = (rk_wanted_sample){pixel, sample};
        if (pass->wanted_count == RK_BATCH_MAX)
            take_samples(job, pass, workspace, film);
    }
}

static void render_tile(uint32_t index, uint32_t thread, void *context)
{
    const adaptive_job *job = context;
    rk_film film;
    rk_sample_pass pass = {.tile = rk_tile_at(&job->options, index),
                           .samples = job->options.samples,
                           .time_passes = 1,
                           .counters = &job->counters[thread]};
    memset(&film, 0, sizeof film);
    for (int out_of_focus = 0; out_of_focus <= job->rendering.plan.depth_of_field; out_of_focus++) {
        pass.out_of_focus = out_of_focus;
        for (uint32_t pixel = 0; pixel < pass.tile.width * pass.tile.height; pixel++)
            render_pixel(job, &pass, pixel, &job->workspaces[thread], &film);
        take_samples(job, &pass, &job->workspaces[thread], &film);
    }
}

/* Every process of a team then has all samples, and plans the same next round. */
static bool render_round(adaptive_job *job, rk_pool *pool, rk_error *error)
{
    const rk_tile_run run = {&job->options, job->plan.samples, sizeof *job->plan.samples,
                             job->counters, NULL};
    if (!rk_tile_run_all(&run, pool, render_tile, job, error))
        return false;
    rk_adaptive_plan_measure(&job->plan);
    job->counters[0].rounds++;
    return true;
}

static bool render_rounds(adaptive_job *job, rk_pool *pool, rk_error *error)
{
    rk_adaptive_generation next = RK_ADAPTIVE_EARLIER_GENERATION;
    bool ok = render_round(job, pool, error);
    for (uint32_t generation = 1; ok && next != RK_ADAPTIVE_LAST_GENERATION; generation++) {
        next = rk_adaptive_plan_generation(&job->plan);
        if (next == RK_ADAPTIVE_NO_GENERATION)
            return true;
        job->options.seed = rk_hash(job->options.seed, generation, 0, 0);
        ok = render_round(job, pool, error);
    }
    if (ok)
        rk_adaptive_plan_second_round(&job->plan);
    return ok && render_round(job, pool, error);
}

/* --- The picture ------------------------------------------------------------------------------ */

/* From few samples to the most of a pixel, by their logarithm. */
static rk_vec3 colour_of_count(const adaptive_job *job, uint32_t count)
{
    const rk_gradient gradient = rk_gradient_cool_to_warm();
    float most = log2f((float)job->counters[0].most_samples / RK_ADAPTIVE_BLOCKS);
    return rk_gradient_at(&gradient,
                          2 * log2f((float)count / RK_ADAPTIVE_BLOCKS) / fmaxf(most, 1) - 1);
}

static void put_image(const adaptive_job *job, rk_image *image)
{
    for (size_t i = 0; i < job->plan.pixels; i++)
        image->pixels[i] = job->options.adaptive_sampling.shown == RK_ADAPTIVE_SAMPLES
                               ? colour_of_count(job, job->plan.samples[i].count)
                               : rk_adaptive_mean(&job->plan.samples[i]);
}

/* The numbers of the whole picture, and its pixels. */
static void finish(adaptive_job *job, rk_image *image)
{
    rk_counters *of_picture = &job->counters[0];
    const rk_adaptive_sums sums = rk_adaptive_plan_sums(&job->plan);
    of_picture->kept_samples = (uint64_t)sums.samples;
    of_picture->taken_samples = (uint64_t)(sums.samples + job->plan.thrown_away);
    of_picture->estimated_error = rk_adaptive_error(sums.variance, sums.squares);
    for (size_t i = 0; i < job->plan.pixels; i++)
        if (of_picture->most_samples < job->plan.samples[i].count)
            of_picture->most_samples = job->plan.samples[i].count;
    put_image(job, image);
}

bool rk_adaptive_sampling_stage(const rk_rendering *r, rk_path_workspace *workspaces,
                                rk_counters *counters, rk_image *image, rk_pool *pool,
                                rk_error *error)
{
    adaptive_job job = {
        .rendering = *r, .options = *r->options, .workspaces = workspaces, .counters = counters};
    job.rendering.options = &job.options;
    bool ok = rk_adaptive_plan_init(&job.plan, &job.options.adaptive_sampling, job.options.width,
                                    job.options.height, error);
    ok = rk_team_agree(rk_pool_team(pool), ok, error) && render_rounds(&job, pool, error);
    if (ok)
        finish(&job, image);
    rk_adaptive_plan_free(&job.plan);
    return ok;
}

/* --- The feature ----------------------------------------------------------------------------- */

RK_NAMES(rk_adaptive_shown_names, rk_adaptive_shown, RK_ADAPTIVE_SAMPLES, "radiance", "samples");

static const rk_option rows[] = {
    {"error", RK_FIELD(rk_render_options, adaptive_sampling.error), "E",
     "take as many samples as this error of the picture needs, many in pixels that are noisy and "
     "few elsewhere; relative: 0.01 is 1 % of the picture's root mean square; 0: take --samples",
     0, 1, 0},
    {"max-samples", RK_FIELD(rk_render_options, adaptive_sampling.max_samples), "N",
     "with --error, the largest number of samples per pixel, a power of two", 8, 65536, 4096},
    {"show", RK_CHOICE(rk_render_options, adaptive_sampling.shown, rk_adaptive_shown_names),
     "with --error, a picture of the radiance, or of the number of samples per pixel"},
    {0},
};

rk_render_options rk_adaptive_sampling_options_of(const rk_render_options *options)
{
    rk_render_options adapted = *options;
    if (!(options->adaptive_sampling.error > 0))
        return adapted;
    adapted.samples = options->adaptive_sampling.max_samples;
    adapted.lens_samples = options->lens_samples > 0 ? adapted.samples : 0;
    adapted.motion.samples = options->motion.samples > 0;
    adapted.motion.sampling = RK_TIME_SOBOL;
    return adapted;
}

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    (void)scene;
    return options->adaptive_sampling.error > 0;
}

/* Half of the pixels decide on the samples of the others, which must not be related to theirs. */
static bool check(const rk_render_options *o, rk_error *error)
{
    const uint32_t most = o->adaptive_sampling.max_samples;
    const rk_sampler_kind kinds[] = {o->sampling, o->lens_sampling, o->light.sampling,
                                     o->glossy.sampling, o->ambient_occlusion.sampling};
    for (size_t i = 0; o->adaptive_sampling.error > 0 && i < sizeof kinds / sizeof *kinds; i++)
        if (kinds[i] == RK_SAMPLER_ZSOBOL)
            return rk_fail(error, "an error is asked for, which takes samples that do not depend "
                                  "on other pixels; take sobol in place of zsobol");
    return (most & (most - 1)) == 0 ||
           rk_fail(error, "max-samples is %u, but it takes a power of two", most);
}

const rk_feature rk_adaptive_sampling_feature = {.stem = "adaptive_sampling",
                                                 .options = rows,
                                                 .takes = "an --error above 0",
                                                 .wanted = wanted,
                                                 .check = check};
