/* Bloom in three passes over the picture: find the bright span of each row; blur the rows that have
 * one; blur the columns, a band of rows at a time, and add them. Rows without a bright pixel, and
 * strips out of the filter's reach, are neither filtered nor stored. Threads wait for each other
 * between passes; within a pass they share only the index of the next item. */
#include "post/bloom_stage.h"

#include "post/bloom_passes.h"
#include "post/blur.h"

#include <stdlib.h>
#include <string.h>

/* --- Bright spans ----------------------------------------------------------------------------- */

static void find_bright_span(uint32_t y, uint32_t thread, void *context)
{
    rk_bloom_work *work = context;
    size_t width = work->image->width;
    rk_bloom_span bright =
        rk_bloom_bright_span(rk_image_at(work->image, 0, y), width, work->options->threshold);
    size_t inside = bright.end - bright.first, ends = inside < 2 ? inside : 2;
    work->bright[y] = bright;
    work->counters[thread].bloom_pixels_read += width - inside + ends;
}

static void widen(rk_bloom_span *span, size_t first, size_t end)
{
    span->first = span->first < first ? span->first : first;
    span->end = span->end > end ? span->end : end;
}

/* Returns false if no pixel is bright. */
static bool find_bright_spans(rk_bloom_work *work, rk_pool *pool)
{
    rk_pool_run(pool, (uint32_t)work->image->height, find_bright_span, work);
    work->rows = (rk_bloom_span){work->image->height, 0};
    work->columns = (rk_bloom_span){work->image->width, 0};
    for (size_t y = 0; y < work->image->height; y++)
        if (work->bright[y].first < work->bright[y].end) {
            widen(&work->rows, y, y + 1);
            widen(&work->columns, work->bright[y].first, work->bright[y].end);
        }
    return work->rows.first < work->rows.end;
}

/* --- Filter and target ------------------------------------------------------------------------ */

/* The span of pixels that a filter of this reach changes. */
static rk_bloom_span dilate(rk_bloom_span bright, size_t reach, size_t length)
{
    return (rk_bloom_span){bright.first > reach ? bright.first - reach : 0,
                           bright.end + reach < length ? bright.end + reach : length};
}

static float *make_gains(const rk_bloom_filter *filter, size_t length, rk_error *error)
{
    float *gains = rk_allocate_unset(length, sizeof *gains, "bloom", error);
    for (size_t i = 0; gains && i < length; i++)
        gains[i] = 1 / rk_bloom_weight_inside(filter, i, length);
    return gains;
}

static bool prepare(rk_bloom_work *work, rk_error *error)
{
    const rk_bloom_options *options = work->options;
    work->weights = rk_allocate(options->radius + RK_BLUR_GAUSSIAN_MORE + 1, sizeof *work->weights,
                                "bloom", error);
    if (!work->weights)
        return false;
    rk_bloom_weights(options->radius, work->weights);
    work->filter = (rk_bloom_filter){rk_bloom_reach(options->radius, work->weights), work->weights,
                                     options->border};
    if (options->method == RK_BLOOM_GAUSSIAN)
        work->filter.reach = rk_blur_gaussian(0.5 * options->radius, work->weights);
    work->target_rows = dilate(work->rows, work->filter.reach, work->image->height);
    work->target_columns = dilate(work->columns, work->filter.reach, work->image->width);
    if (options->border != RK_BLOOM_RENORMALIZE)
        return true;
    work->gains_across = make_gains(&work->filter, work->image->width, error);
    work->gains_down = make_gains(&work->filter, work->image->height, error);
    return work->gains_across && work->gains_down;
}

bool rk_bloom_stage(rk_image *image, const rk_bloom_options *options, rk_pool *pool,
                    rk_counters *counters, rk_error *error)
{
    if (!rk_bloom_check(options, error))
        return false;
    if (!rk_bloom_wanted(options))
        return true;
    uint32_t threads = rk_pool_threads(pool);
    rk_bloom_work work = {.image = image, .to = image, .options = options};
    work.counters = rk_allocate(threads, sizeof *work.counters, "counters", error);
    work.bright = rk_allocate_unset(image->height, sizeof *work.bright, "bloom", error);
    bool ok = work.counters && work.bright;
    if (ok && find_bright_spans(&work, pool))
        ok = prepare(&work, error) &&
             (options->method == RK_BLOOM_RECURSIVE || options->method == RK_BLOOM_PYRAMID
                  ? rk_bloom_whole(&work, pool, error)
                  : rk_bloom_by_taps(&work, pool, error));
    for (uint32_t i = 0; ok && i < threads; i++)
        rk_counters_add(counters, &work.counters[i]);
    free(work.counters);
    free(work.bright);
    free(work.weights);
    free(work.gains_across);
    free(work.gains_down);
    return ok;
}

/* --- The feature ----------------------------------------------------------------------------- */

RK_NAMES(rk_bloom_border_names, rk_bloom_border, RK_BLOOM_RENORMALIZE, "zero", "clamp",
         "renormalize");
RK_NAMES(rk_bloom_method_names, rk_bloom_method, RK_BLOOM_PYRAMID, "exact", "gaussian", "recursive",
         "pyramid");

static const rk_option rows[] = {
    {"bloom", RK_FIELD(rk_render_options, bloom.on), NULL,
     "blur bright pixels and add them to the picture"},
    {"bloom-threshold", RK_FIELD(rk_render_options, bloom.threshold), "Y",
     "brightness from which on a pixel blooms", -1e6, 1e6, 0.5},
    {"bloom-intensity", RK_FIELD(rk_render_options, bloom.intensity), "I",
     "weight of the blurred pixels", 0, 1e6, 0.8},
    {"bloom-radius", RK_FIELD(rk_render_options, bloom.radius), "R",
     "radius of the filter, pixels: it has 2R + 1 taps", 0, RK_BLOOM_RADIUS_MAX, 15},
    {"bloom-border", RK_CHOICE(rk_render_options, bloom.border, rk_bloom_border_names),
     "beyond the picture, pixels are black; like the nearest one at the border; or left out, and "
     "the other weights sum to 1"},
    {"bloom-method", RK_CHOICE(rk_render_options, bloom.method, rk_bloom_method_names),
     "the exact filter, or a cheaper one that is close to it"},
    {0},
};

rk_bloom_options rk_bloom_options_default(void)
{
    rk_render_options options = {0};
    rk_options_set_defaults(rows, &options);
    return options.bloom;
}

bool rk_bloom_wanted(const rk_bloom_options *options)
{
    return options->on && options->intensity > 0;
}

bool rk_bloom_check(const rk_bloom_options *options, rk_error *error)
{
    const rk_render_options with = {.bloom = *options};
    return rk_options_check(rows, &with, error);
}

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    (void)scene;
    return rk_bloom_wanted(&options->bloom);
}

static bool post(rk_image *image, const rk_render_options *options, rk_pool *pool,
                 rk_counters *counters, rk_error *error)
{
    return rk_bloom_stage(image, &options->bloom, pool, counters, error);
}

const rk_feature rk_bloom_feature = {.stem = "bloom",
                                     .options = rows,
                                     .takes = "--bloom, light, and an intensity above 0",
                                     .wanted = wanted,
                                     .post = post};
