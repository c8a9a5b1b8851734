/* Where does each row glow? Those that do are masked and filtered; then columns are, a band of rows
 * at a time, and added to the picture. Rows that do not glow, and strips out of their reach, are
 * neither filtered nor stored. Between these passes threads wait for each other; within one they
 * share nothing but the next item's number. */
#include "post/bloom_stage.h"

#include "post/bloom_passes.h"
#include "post/blur.h"

#include <stdlib.h>
#include <string.h>

rk_bloom_options rk_bloom_options_default(void)
{
    return (rk_bloom_options){.threshold = 0.5f, .intensity = 0.8f, .radius = 15};
}

bool rk_bloom_wanted(const rk_bloom_options *options)
{
    return options->on && options->intensity > 0;
}

bool rk_bloom_check(const rk_bloom_options *options, rk_error *error)
{
    if (options->radius > RK_BLOOM_RADIUS_MAX)
        return rk_fail(error, "a bloom's radius is at most %d pixels, not %u", RK_BLOOM_RADIUS_MAX,
                       options->radius);
    if (isnan(options->threshold))
        return rk_fail(error, "a bloom's threshold is a number, not NaN");
    if (!(options->intensity >= 0 && options->intensity < INFINITY))
        return rk_fail(error, "a bloom's intensity is finite, and 0 or more, not %g",
                       (double)options->intensity);
    if (options->border > RK_BLOOM_RENORMALIZE)
        return rk_fail(error,
                       "the option bloom.border is %u, but rk_bloom_border goes from 0 to %u",
                       options->border, RK_BLOOM_RENORMALIZE);
    if (options->method > RK_BLOOM_PYRAMID)
        return rk_fail(error,
                       "the option bloom.method is %u, but rk_bloom_method goes from 0 to %u",
                       options->method, RK_BLOOM_PYRAMID);
    return true;
}

/* --- Where is light? -------------------------------------------------------------------------- */

static void find_light_in_row(uint32_t y, uint32_t thread, void *context)
{
    rk_bloom_work *g = context;
    size_t width = g->image->width;
    rk_bloom_span lit =
        rk_bloom_bright_span(rk_image_at(g->image, 0, y), width, g->options->threshold);
    size_t inside = lit.end - lit.first, ends = inside < 2 ? inside : 2;
    g->lit[y] = lit;
    g->counters[thread].bloom_pixels_read += width - inside + ends;
}

static void widen(rk_bloom_span *span, size_t first, size_t end)
{
    span->first = span->first < first ? span->first : first;
    span->end = span->end > end ? span->end : end;
}

/* Returns false where there is none. */
static bool find_light(rk_bloom_work *g, rk_pool *pool)
{
    rk_pool_run(pool, (uint32_t)g->image->height, find_light_in_row, g);
    g->rows = (rk_bloom_span){g->image->height, 0};
    g->columns = (rk_bloom_span){g->image->width, 0};
    for (size_t y = 0; y < g->image->height; y++)
        if (g->lit[y].first < g->lit[y].end) {
            widen(&g->rows, y, y + 1);
            widen(&g->columns, g->lit[y].first, g->lit[y].end);
        }
    return g->rows.first < g->rows.end;
}

/* --- What is needed --------------------------------------------------------------------------- */

/* As far as a filter of this reach spreads the light. */
static rk_bloom_span spread(rk_bloom_span lit, size_t reach, size_t length)
{
    return (rk_bloom_span){lit.first > reach ? lit.first - reach : 0,
                           lit.end + reach < length ? lit.end + reach : length};
}

static float *make_gains(const rk_bloom_filter *filter, size_t length, rk_error *error)
{
    float *gains = rk_allocate_unset(length, sizeof *gains, "bloom", error);
    for (size_t i = 0; gains && i < length; i++)
        gains[i] = 1 / rk_bloom_weight_inside(filter, i, length);
    return gains;
}

static bool prepare(rk_bloom_work *g, rk_error *error)
{
    const rk_bloom_options *options = g->options;
    g->weights = rk_allocate(options->radius + RK_BLUR_GAUSSIAN_MORE + 1, sizeof *g->weights,
                             "bloom", error);
    if (!g->weights)
        return false;
    rk_bloom_weights(options->radius, g->weights);
    g->filter =
        (rk_bloom_filter){rk_bloom_reach(options->radius, g->weights), g->weights, options->border};
    if (options->method == RK_BLOOM_GAUSSIAN)
        g->filter.reach = rk_blur_gaussian(0.5 * options->radius, g->weights);
    g->target_rows = spread(g->rows, g->filter.reach, g->image->height);
    g->target_columns = spread(g->columns, g->filter.reach, g->image->width);
    if (options->border != RK_BLOOM_RENORMALIZE)
        return true;
    g->gains_across = make_gains(&g->filter, g->image->width, error);
    g->gains_down = make_gains(&g->filter, g->image->height, error);
    return g->gains_across && g->gains_down;
}

bool rk_bloom_stage(rk_image *image, const rk_bloom_options *options, rk_pool *pool,
                    rk_counters *counters, rk_error *error)
{
    if (!rk_bloom_check(options, error))
        return false;
    if (!rk_bloom_wanted(options))
        return true;
    uint32_t threads = rk_pool_threads(pool);
    rk_bloom_work g = {.image = image, .to = image, .options = options};
    g.counters = rk_allocate(threads, sizeof *g.counters, "counters", error);
    g.lit = rk_allocate_unset(image->height, sizeof *g.lit, "bloom", error);
    bool ok = g.counters && g.lit;
    if (ok && find_light(&g, pool))
        ok = prepare(&g, error) &&
             (options->method == RK_BLOOM_RECURSIVE || options->method == RK_BLOOM_PYRAMID
                  ? rk_bloom_whole(&g, pool, error)
                  : rk_bloom_by_taps(&g, pool, error));
    for (uint32_t i = 0; ok && i < threads; i++)
        rk_counters_add(counters, &g.counters[i]);
    free(g.counters);
    free(g.lit);
    free(g.weights);
    free(g.gains_across);
    free(g.gains_down);
    return ok;
}
