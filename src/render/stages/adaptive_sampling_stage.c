#include "render/stages/adaptive_sampling_stage.h"

#include "features/shading.h"
#include "render/render_sample.h"
#include "render/stages/depth_of_field_stage.h"
#include "render/tiles.h"

#include <stdlib.h>
#include <string.h>

/* A generation has at most this many times the samples of all before. */
static const double most_growth = 4;

/* After a round, of the pixels of one colour of a chessboard. */
typedef struct half_picture {
    double samples, variance, squares;   /* sums; see rk_adaptive_error */
    rk_adaptive_differences differences; /* sums */
} half_picture;

typedef struct adaptive_job {
    rk_rendering rendering; /* with its own options: each generation has another seed */
    rk_render_options options;
    rk_path_workspace *workspaces; /* one per thread */
    rk_counters *counters;         /* one per thread */
    size_t pixels;
    rk_pixel_samples *samples;       /* of the present generation */
    rk_adaptive_estimate *estimates; /* by the generation before */
    float *own_variances;
    float lambda[2]; /* of each half */
    half_picture halves[2];
    uint32_t generation;
    double thrown_away; /* samples of earlier generations */
} adaptive_job;

/* --- A round ---------------------------------------------------------------------------------- */

typedef struct sample_range {
    uint32_t first, end;
} sample_range;

static int half_of(const adaptive_job *job, size_t pixel)
{
    return (int)((pixel % job->options.width + pixel / job->options.width) % 2);
}

static size_t picture_pixel(const adaptive_job *job, const rk_sample_pass *pass, uint32_t pixel)
{
    return rk_picture_pixel(pass, job->options.width, pixel);
}

/* Makes room for the pixels' new samples, from the first to the end. */
static sample_range extend_pixels(const adaptive_job *job, const rk_sample_pass *pass,
                                  sample_range *ranges)
{
    sample_range all = {UINT32_MAX, 0};
    for (uint32_t i = 0; i < pass->tile.width * pass->tile.height; i++) {
        size_t at = picture_pixel(job, pass, i);
        uint32_t count =
            rk_adaptive_count(job->estimates[at].variance, job->lambda[half_of(job, at)],
                              job->options.adaptive_sampling.max_samples);
        ranges[i].first = job->samples[at].count;
        ranges[i].end = count;
        rk_adaptive_extend(&job->samples[at], count);
        if (all.first > ranges[i].first)
            all.first = ranges[i].first;
        if (all.end < count)
            all.end = count;
    }
    return all;
}

static void find_wanted(const adaptive_job *job, const sample_range *ranges, rk_sample_pass *pass)
{
    pass->wanted_count = 0;
    for (uint32_t i = 0; i < pass->tile.width * pass->tile.height; i++)
        if (ranges[i].first <= pass->sample && pass->sample < ranges[i].end &&
            rk_is_in_pass(&job->rendering, pass, pass->tile.x + i % pass->tile.width,
                          pass->tile.y + i / pass->tile.width))
            pass->wanted[pass->wanted_count++] = (uint16_t)i;
}

static void add_sample(const adaptive_job *job, const rk_sample_pass *pass, rk_film *film)
{
    for (uint32_t i = 0; i < pass->wanted_count; i++) {
        rk_vec3 *radiance = &film->sum[pass->wanted[i]];
        rk_adaptive_add(&job->samples[picture_pixel(job, pass, pass->wanted[i])], pass->sample,
                        *radiance);
        *radiance = rk_vec(0, 0, 0);
    }
}

static void render_tile(uint32_t index, uint32_t thread, void *context)
{
    const adaptive_job *job = context;
    sample_range ranges[RK_BATCH_MAX];
    rk_film film;
    rk_sample_pass pass = {.tile = rk_tile_at(&job->options, index),
                           .samples = job->options.samples,
                           .time_passes = 1,
                           .counters = &job->counters[thread]};
    const sample_range all = extend_pixels(job, &pass, ranges);
    memset(&film, 0, sizeof film);
    for (int out_of_focus = 0; out_of_focus <= job->rendering.plan.depth_of_field; out_of_focus++) {
        pass.out_of_focus = out_of_focus;
        for (pass.sample = all.first; pass.sample < all.end; pass.sample++) {
            if (pass.sample == all.first || (pass.sample & (pass.sample - 1)) == 0)
                find_wanted(job, ranges, &pass);
            if (pass.wanted_count == 0)
                continue;
            rk_render_sample(&job->rendering, &pass, &job->workspaces[thread], &film);
            add_sample(job, &pass, &film);
        }
    }
}

/* Variance is summed for each number of samples alone, because the ratio differs. */
static void measure_half(adaptive_job *job, int half)
{
    rk_adaptive_differences levels[32] = {{0, 0}};
    half_picture sums = {0, 0, 0, {0, 0}};
    for (size_t i = 0; i < job->pixels; i++) {
        const rk_pixel_samples *pixel = &job->samples[i];
        if (half_of(job, i) != half)
            continue;
        const rk_adaptive_differences d = rk_adaptive_differences_of(pixel);
        const rk_vec3 mean = rk_adaptive_mean(pixel);
        const double square = (double)rk_dot(mean, mean) / 3;
        rk_adaptive_differences *level = &levels[ilogbf((float)pixel->count)];
        level->quarters += d.quarters;
        level->halves += d.halves;
        sums.samples += pixel->count;
        sums.squares += isfinite(square) ? square : 0;
    }
    for (int i = 0; i < 32; i++) {
        sums.differences.quarters += levels[i].quarters;
        sums.differences.halves += levels[i].halves;
        sums.variance += rk_adaptive_variance(levels[i]);
    }
    job->halves[half] = sums;
}

static half_picture whole_picture(const adaptive_job *job)
{
    const half_picture *a = &job->halves[0], *b = &job->halves[1];
    return (half_picture){a->samples + b->samples,
                          a->variance + b->variance,
                          a->squares + b->squares,
                          {a->differences.quarters + b->differences.quarters,
                           a->differences.halves + b->differences.halves}};
}

static void render_round(adaptive_job *job, rk_pool *pool)
{
    rk_pool_run(pool, rk_tile_count(&job->options), render_tile, job);
    measure_half(job, 0);
    measure_half(job, 1);
    job->counters[0].rounds++;
}

/* --- The next round --------------------------------------------------------------------------- */

/* Its allocation is by the samples so far, which are thrown away. */
static void start_generation(adaptive_job *job, double *predicted)
{
    const uint32_t width = job->options.width, height = job->options.height;
    double mean = 0;
    job->thrown_away += whole_picture(job).samples;
    for (size_t i = 0; i < job->pixels; i++) {
        const float before = (float)job->estimates[i].count, now = (float)job->samples[i].count;
        job->own_variances[i] =
            (before * job->own_variances[i] + now * rk_adaptive_own_variance(&job->samples[i])) /
            (before + now);
        job->estimates[i].count += job->samples[i].count;
        mean += (double)job->own_variances[i] / (double)job->pixels;
    }
    for (size_t i = 0; i < job->pixels; i++)
        job->estimates[i].variance = rk_adaptive_pooled_variance(
            job->own_variances, (float)mean, job->estimates[i].count, width, height,
            (uint32_t)(i % width), (uint32_t)(i / width));
    for (size_t i = 0; i < job->pixels; i++)
        *predicted += (double)job->estimates[i].variance / job->samples[i].count;
    memset(job->samples, 0, job->pixels * sizeof *job->samples);
    job->generation++;
    job->options.seed = rk_hash(job->options.seed, job->generation, 0, 0);
}

/* The largest variance, of as many pixels. */
static double wanted_variance(const adaptive_job *job, const half_picture *sums)
{
    const double error = (double)job->options.adaptive_sampling.error;
    return error * error * (sums->squares - sums->variance);
}

static float lambda_of(const adaptive_job *job, double ratio, double variance, double samples)
{
    return rk_adaptive_lambda(job->estimates, job->pixels,
                              job->options.adaptive_sampling.max_samples, ratio, variance, samples);
}

static rk_adaptive_prediction predict(const adaptive_job *job, double ratio, float lambda)
{
    return rk_adaptive_predict(job->estimates, job->pixels, lambda,
                               job->options.adaptive_sampling.max_samples, ratio);
}

/* Pixels with the least number of samples would keep it when lambda falls, until it reaches their
 * variance, and so would the error of those whose variance is underestimated. So they begin to grow
 * at once, one after the other. */
static void raise_estimates(adaptive_job *job, float lambda)
{
    const float least = RK_ADAPTIVE_BLOCKS * RK_ADAPTIVE_BLOCKS * lambda;
    for (size_t i = 0; i < job->pixels; i++) {
        float u = rk_unit_float(rk_hash(job->options.seed, (uint32_t)i, 0, 0));
        float variance = least * exp2f(2 * u - 1);
        if (!(job->estimates[i].variance > variance))
            job->estimates[i].variance = variance;
    }
}

/* Returns whether it is the last one: it then begins with half of the samples that are predicted to
 * suffice. */
static bool plan_generation(adaptive_job *job)
{
    const half_picture now = whole_picture(job);
    const double ratio = rk_adaptive_ratio(now.differences);
    double predicted = 0; /* variance of the present round */
    start_generation(job, &predicted);
    double want = wanted_variance(job, &now) * (predicted > 0 ? predicted / now.variance : 1);
    float enough = lambda_of(job, ratio, want, (double)INFINITY);
    double need = predict(job, ratio, enough).samples, most = most_growth * job->thrown_away;
    float lambda = lambda_of(job, ratio, 0, need <= most ? need / 2 : fmin(most, need / 4));
    lambda = fminf(lambda, 4 * enough); /* n / 2, if no pixel has the least number */
    job->lambda[0] = job->lambda[1] = lambda;
    raise_estimates(job, lambda);
    return need <= most || predict(job, ratio, lambda).samples <= now.samples;
}

/* How many more samples a half takes is decided by the other half, so that no sample decides on
 * itself. */
static float lambda_by(const adaptive_job *job, const half_picture *other, float lambda)
{
    const double ratio = (rk_adaptive_ratio(other->differences) + 0.5) / 2; /* it rises */
    const double want = wanted_variance(job, other);
    if (other->variance <= want)
        return lambda;
    const rk_adaptive_prediction now = predict(job, ratio, lambda);
    return fminf(lambda, lambda_of(job, ratio, now.variance * want / other->variance,
                                   most_growth * now.samples));
}

static bool is_reached(const half_picture *sums, double error)
{
    return !(rk_adaptive_error(sums->variance, sums->squares) > error);
}

static void render_rounds(adaptive_job *job, rk_pool *pool)
{
    for (size_t i = 0; i < job->pixels; i++)
        job->estimates[i] = (rk_adaptive_estimate){RK_ADAPTIVE_FIRST * RK_ADAPTIVE_FIRST, 0};
    job->lambda[0] = job->lambda[1] = 1;
    render_round(job, pool);
    const half_picture first = whole_picture(job);
    if (is_reached(&first, (double)job->options.adaptive_sampling.error))
        return;
    bool is_last = false;
    while (!is_last) {
        is_last = plan_generation(job);
        render_round(job, pool);
    }
    const float lambda = job->lambda[0];
    job->lambda[0] = lambda_by(job, &job->halves[job->pixels > 1], lambda);
    job->lambda[1] = lambda_by(job, &job->halves[0], lambda);
    render_round(job, pool);
}

/* --- The picture ------------------------------------------------------------------------------ */

/* From few samples to many, by their logarithm. */
static rk_vec3 colour_of_count(const adaptive_job *job, uint32_t count)
{
    const rk_gradient gradient = rk_gradient_cool_to_warm();
    float most = log2f((float)job->options.adaptive_sampling.max_samples / RK_ADAPTIVE_BLOCKS);
    return rk_gradient_at(&gradient,
                          2 * log2f((float)count / RK_ADAPTIVE_BLOCKS) / fmaxf(most, 1) - 1);
}

static void put_image(const adaptive_job *job, rk_image *image)
{
    for (size_t i = 0; i < job->pixels; i++)
        image->pixels[i] = job->options.adaptive_sampling.shown == RK_ADAPTIVE_SAMPLES
                               ? colour_of_count(job, job->samples[i].count)
                               : rk_adaptive_mean(&job->samples[i]);
}

bool rk_adaptive_sampling_stage(const rk_rendering *r, rk_path_workspace *workspaces,
                                rk_counters *counters, rk_image *image, rk_pool *pool,
                                rk_error *error)
{
    adaptive_job job = {.rendering = *r,
                        .options = *r->options,
                        .workspaces = workspaces,
                        .counters = counters,
                        .pixels = image->width * image->height};
    job.rendering.options = &job.options;
    job.samples = rk_allocate(job.pixels, sizeof *job.samples, "samples", error);
    job.estimates = rk_allocate_unset(job.pixels, sizeof *job.estimates, "samples", error);
    job.own_variances = rk_allocate(job.pixels, sizeof *job.own_variances, "samples", error);
    bool ok = job.samples && job.estimates && job.own_variances;
    if (ok) {
        render_rounds(&job, pool);
        const half_picture whole = whole_picture(&job);
        counters[0].kept_samples = (uint64_t)whole.samples;
        counters[0].estimated_error = rk_adaptive_error(whole.variance, whole.squares);
        put_image(&job, image);
    }
    free(job.samples);
    free(job.estimates);
    free(job.own_variances);
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
    adapted.motion.sampling = RK_TIME_LOW_DISCREPANCY;
    return adapted;
}

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    (void)scene;
    return options->adaptive_sampling.error > 0;
}

static bool check(const rk_render_options *options, rk_error *error)
{
    uint32_t most = options->adaptive_sampling.max_samples;
    return (most & (most - 1)) == 0 ||
           rk_fail(error, "max-samples is %u, but it takes a power of two", most);
}

const rk_feature rk_adaptive_sampling_feature = {.stem = "adaptive_sampling",
                                                 .options = rows,
                                                 .takes = "an --error above 0",
                                                 .wanted = wanted,
                                                 .check = check};
