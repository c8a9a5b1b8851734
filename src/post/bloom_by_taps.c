/* The light of a picture, filtered by weights: rows first, then columns. Columns are filtered strip
 * by strip, a band of a few rows at a time: neighbours in a column share most of what they read,
 * which then is in the nearest cache, and a band of the picture is read and written from left to
 * right, as memory likes it best. */
#include "post/bloom_passes.h"

#include <stdlib.h>

/* Three blocks are nine lines of a cache. Rows of a band are far apart in memory, and processors
 * follow only so many places ahead of their use. */
enum { strip_floats = 3 * RK_BLOOM_BLOCK, strip_pixels = strip_floats / 3, band_rows = 8 };

_Static_assert(sizeof(rk_vec3) == 3 * sizeof(float) && RK_BLOOM_BLOCK % 3 == 0,
               "a row of pixels is a row of floats, a block a whole number of pixels");

typedef struct by_taps {
    rk_bloom_work *g;
    size_t width;       /* floats: the target columns, in whole blocks */
    size_t strips;      /* side by side they cover the width; the last may be narrower */
    rk_bloom_span *wet; /* of each row of `rows`: the strips that its light reaches */
    float *across;      /* the rows, filtered along themselves */
    size_t pitch;       /* floats from one of them to the next */
    size_t room;        /* floats of a thread's own row, which is masked */
    float *masked;
    size_t line_room;
    const float **lines; /* a thread's own, line_room each */
} by_taps;

static float *strip_at(const by_taps *b, size_t strip, size_t y)
{
    return b->across + (y - b->g->rows.first) * b->pitch + strip * strip_floats;
}

/* Floats from the beginning of one strip to the end of another, or of the same. */
static size_t floats_between(const by_taps *b, size_t first, size_t end)
{
    size_t to = end * strip_floats;
    return (to < b->width ? to : b->width) - first * strip_floats;
}

/* --- Rows ------------------------------------------------------------------------------------- */

/* The strips that the light of a row reaches; none (0, 0) if there is no light. */
static rk_bloom_span strips_of(const by_taps *b, rk_bloom_span lit)
{
    const rk_bloom_work *g = b->g;
    size_t left = g->target_columns.first, reach = g->filter.reach;
    if (lit.first == lit.end)
        return (rk_bloom_span){0, 0};
    size_t from = lit.first > left + reach ? lit.first - reach - left : 0;
    size_t to = lit.end + reach - left, end = (to + strip_pixels - 1) / strip_pixels;
    return (rk_bloom_span){from / strip_pixels, end < b->strips ? end : b->strips};
}

static void filter_row(uint32_t index, uint32_t thread, void *context)
{
    by_taps *b = context;
    rk_bloom_work *g = b->g;
    size_t y = g->rows.first + index, reach = g->filter.reach;
    rk_bloom_span lit = g->lit[y], wet = strips_of(b, lit);
    b->wet[index] = wet;
    if (wet.first == wet.end)
        return;
    size_t from = g->target_columns.first + wet.first * strip_pixels;
    size_t count = floats_between(b, wet.first, wet.end) / 3;
    size_t inside = g->target_columns.end - from;
    float *masked = b->masked + thread * b->room, *filtered = strip_at(b, wet.first, y);
    const float **lines = b->lines + thread * b->line_room;
    rk_bloom_bright_pass(&g->filter, rk_image_at(g->image, 0, y), g->image->width,
                         g->options->threshold, lit, from, count < inside ? count : inside,
                         (rk_vec3 *)masked);
    for (size_t k = 0; k <= 2 * reach; k++)
        lines[k] = masked + 3 * k;
    uint32_t taps = rk_bloom_blur_lines(&g->filter, lines, 3 * count, filtered);
    if (g->gains_across)
        for (size_t i = 0; i < count && i < inside; i++)
            for (size_t c = 0; c < 3; c++)
                filtered[3 * i + c] *= g->gains_across[from + i];
    g->counters[thread].bloom_pixels_read += lit.end - lit.first;
    g->counters[thread].bloom_taps += taps * count;
}

/* --- Columns ---------------------------------------------------------------------------------- */

/* The block of row y in the strip, or NULL where it is dark; y may be beyond the border. */
static const float *line_at(const by_taps *b, size_t strip, ptrdiff_t y)
{
    const rk_bloom_work *g = b->g;
    if (g->filter.border == RK_BLOOM_CLAMP) {
        ptrdiff_t bottom = (ptrdiff_t)g->image->height - 1;
        y = y < 0 ? 0 : y > bottom ? bottom : y;
    }
    if (y < (ptrdiff_t)g->rows.first || y >= (ptrdiff_t)g->rows.end)
        return NULL;
    rk_bloom_span wet = b->wet[(size_t)y - g->rows.first];
    return strip >= wet.first && strip < wet.end ? strip_at(b, strip, (size_t)y) : NULL;
}

static void filter_strip(const by_taps *b, size_t strip, rk_bloom_span rows, uint32_t thread)
{
    rk_bloom_work *g = b->g;
    size_t reach = g->filter.reach, from = g->target_columns.first + strip * strip_pixels;
    size_t inside = 3 * (g->target_columns.end - from);
    size_t count = floats_between(b, strip, strip + 1);
    const float **lines = b->lines + thread * b->line_room; /* of row first + i, from lines[i] on */
    for (size_t k = 0; k < rows.end - rows.first + 2 * reach; k++)
        lines[k] = line_at(b, strip, (ptrdiff_t)(rows.first + k) - (ptrdiff_t)reach);
    for (size_t y = rows.first; y < rows.end; y++) {
        float sum[strip_floats];
        uint32_t taps = rk_bloom_blur_lines(&g->filter, lines + (y - rows.first), count, sum);
        if (taps == 0)
            continue;
        rk_bloom_composite(&rk_image_at(g->to, from, y)->x, sum, count < inside ? count : inside,
                           g->options->intensity * (g->gains_down ? g->gains_down[y] : 1));
        g->counters[thread].bloom_taps += taps * (count / 3);
    }
}

static void filter_band(uint32_t band, uint32_t thread, void *context)
{
    const by_taps *b = context;
    size_t first = b->g->target_rows.first + band * band_rows, end = b->g->target_rows.end;
    rk_bloom_span rows = {first, first + band_rows < end ? first + band_rows : end};
    for (size_t strip = 0; strip < b->strips; strip++)
        filter_strip(b, strip, rows, thread);
}

/* --- Both ------------------------------------------------------------------------------------- */

bool rk_bloom_by_taps(rk_bloom_work *g, rk_pool *pool, rk_error *error)
{
    size_t threads = rk_pool_threads(pool), rows = g->rows.end - g->rows.first;
    size_t width = 3 * (g->target_columns.end - g->target_columns.first), reach = g->filter.reach;
    size_t bands = (g->target_rows.end - g->target_rows.first + band_rows - 1) / band_rows;
    size_t blocks = (width + RK_BLOOM_BLOCK - 1) / RK_BLOOM_BLOCK;
    by_taps b = {.g = g, .width = blocks * RK_BLOOM_BLOCK};
    b.strips = (b.width + strip_floats - 1) / strip_floats;
    /* Rows an even number of cache lines apart would compete for the same places in the cache. */
    b.pitch = (blocks | 1) * RK_BLOOM_BLOCK;
    b.room = b.width + 2 * 3 * reach;
    b.line_room = band_rows + 2 * reach;
    b.wet = rk_allocate_unset(rows, sizeof *b.wet, "bloom", error);
    b.across = rk_allocate_unset(rows, b.pitch * sizeof *b.across, "bloom", error);
    b.masked = rk_allocate(threads * b.room, sizeof *b.masked, "bloom", error);
    b.lines = rk_allocate_unset(threads * b.line_room, sizeof *b.lines, "bloom", error);
    bool ok = b.wet && b.across && b.masked && b.lines;
    if (ok) {
        rk_pool_run(pool, (uint32_t)rows, filter_row, &b);
        rk_pool_run(pool, (uint32_t)bands, filter_band, &b);
    }
    free(b.wet);
    free(b.across);
    free(b.masked);
    free(b.lines);
    return ok;
}
