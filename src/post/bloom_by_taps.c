/* rk_bloom_by_taps of post/bloom_passes.h: a separable blur by weights, rows before columns.
 * Columns are filtered strip by strip, in bands of a few rows: neighbours in a column read nearly
 * the same pixels, which are then in the first-level cache, and each band is read and written from
 * left to right, in the order of memory.
 */
#include "post/bloom_passes.h"

#include <stdlib.h>

/* Three blocks are nine cache lines. Rows of a band are far apart in memory, and a processor
 * prefetches only a limited number of streams. */
enum { strip_floats = 3 * RK_BLOOM_BLOCK, strip_pixels = strip_floats / 3, band_rows = 8 };

_Static_assert(sizeof(rk_vec3) == 3 * sizeof(float) && RK_BLOOM_BLOCK % 3 == 0,
               "a row of pixels is a row of floats, a block a whole number of pixels");

typedef struct by_taps {
    rk_bloom_work *work;
    size_t width;           /* floats: the target columns, in whole blocks */
    size_t strips;          /* side by side they cover the width; the last may be narrower */
    rk_bloom_span *reached; /* of each row of `rows`: the strips that its blur changes */
    float *across;          /* the blurred rows */
    size_t pitch;           /* floats from one of them to the next */
    size_t room;            /* floats of a thread's row after the bright pass */
    float *masked;
    size_t line_room;
    const float **lines; /* a thread's own, line_room each */
} by_taps;

static float *strip_at(const by_taps *b, size_t strip, size_t y)
{
    return b->across + (y - b->work->rows.first) * b->pitch + strip * strip_floats;
}

/* Floats from the beginning of one strip to the end of another, or of the same. */
static size_t floats_between(const by_taps *b, size_t first, size_t end)
{
    size_t to = end * strip_floats;
    return (to < b->width ? to : b->width) - first * strip_floats;
}

/* --- Rows ------------------------------------------------------------------------------------- */

/* The strips that a row's blur changes; (0, 0) if the row has no bright pixel. */
static rk_bloom_span strips_of(const by_taps *b, rk_bloom_span bright)
{
    const rk_bloom_work *work = b->work;
    size_t left = work->target_columns.first, reach = work->filter.reach;
    if (bright.first == bright.end)
        return (rk_bloom_span){0, 0};
    size_t from = bright.first > left + reach ? bright.first - reach - left : 0;
    size_t to = bright.end + reach - left, end = (to + strip_pixels - 1) / strip_pixels;
    return (rk_bloom_span){from / strip_pixels, end < b->strips ? end : b->strips};
}

static void filter_row(uint32_t index, uint32_t thread, void *context)
{
    by_taps *b = context;
    rk_bloom_work *work = b->work;
    size_t y = work->rows.first + index, reach = work->filter.reach;
    rk_bloom_span bright = work->bright[y], reached = strips_of(b, bright);
    b->reached[index] = reached;
    if (reached.first == reached.end)
        return;
    size_t from = work->target_columns.first + reached.first * strip_pixels;
    size_t count = floats_between(b, reached.first, reached.end) / 3;
    size_t inside = work->target_columns.end - from;
    float *masked = b->masked + thread * b->room, *filtered = strip_at(b, reached.first, y);
    const float **lines = b->lines + thread * b->line_room;
    rk_bloom_bright_pass(&work->filter, rk_image_at(work->image, 0, y), work->image->width,
                         work->options->threshold, bright, from, count < inside ? count : inside,
                         (rk_vec3 *)masked);
    for (size_t k = 0; k <= 2 * reach; k++)
        lines[k] = masked + 3 * k;
    uint32_t taps = rk_bloom_blur_lines(&work->filter, lines, 3 * count, filtered);
    if (work->gains_across)
        for (size_t i = 0; i < count && i < inside; i++)
            for (size_t c = 0; c < 3; c++)
                filtered[3 * i + c] *= work->gains_across[from + i];
    work->counters[thread].bloom_pixels_read += bright.end - bright.first;
    work->counters[thread].bloom_taps += taps * count;
}

/* --- Columns ---------------------------------------------------------------------------------- */

/* The part of blurred row y in the strip, or NULL if it is black; y may lie outside the picture. */
static const float *line_at(const by_taps *b, size_t strip, ptrdiff_t y)
{
    const rk_bloom_work *work = b->work;
    if (work->filter.border == RK_BLOOM_CLAMP) {
        ptrdiff_t bottom = (ptrdiff_t)work->image->height - 1;
        y = y < 0 ? 0 : y > bottom ? bottom : y;
    }
    if (y < (ptrdiff_t)work->rows.first || y >= (ptrdiff_t)work->rows.end)
        return NULL;
    rk_bloom_span reached = b->reached[(size_t)y - work->rows.first];
    return strip >= reached.first && strip < reached.end ? strip_at(b, strip, (size_t)y) : NULL;
}

static void filter_strip(const by_taps *b, size_t strip, rk_bloom_span rows, uint32_t thread)
{
    rk_bloom_work *work = b->work;
    size_t reach = work->filter.reach, from = work->target_columns.first + strip * strip_pixels;
    size_t inside = 3 * (work->target_columns.end - from);
    size_t count = floats_between(b, strip, strip + 1);
    const float **lines = b->lines + thread * b->line_room; /* of row first + i, from lines[i] on */
    for (size_t k = 0; k < rows.end - rows.first + 2 * reach; k++)
        lines[k] = line_at(b, strip, (ptrdiff_t)(rows.first + k) - (ptrdiff_t)reach);
    for (size_t y = rows.first; y < rows.end; y++) {
        float sum[strip_floats];
        uint32_t taps = rk_bloom_blur_lines(&work->filter, lines + (y - rows.first), count, sum);
        if (taps == 0)
            continue;
        rk_bloom_composite(&rk_image_at(work->to, from, y)->x, sum, count < inside ? count : inside,
                           work->options->intensity * (work->gains_down ? work->gains_down[y] : 1));
        work->counters[thread].bloom_taps += taps * (count / 3);
    }
}

static void filter_band(uint32_t band, uint32_t thread, void *context)
{
    const by_taps *b = context;
    size_t first = b->work->target_rows.first + band * band_rows, end = b->work->target_rows.end;
    rk_bloom_span rows = {first, first + band_rows < end ? first + band_rows : end};
    for (size_t strip = 0; strip < b->strips; strip++)
        filter_strip(b, strip, rows, thread);
}

/* --- Rows, then columns ----------------------------------------------------------------------- */

bool rk_bloom_by_taps(rk_bloom_work *work, rk_pool *pool, rk_error *error)
{
    size_t threads = rk_pool_threads(pool), rows = work->rows.end - work->rows.first;
    size_t width = 3 * (work->target_columns.end - work->target_columns.first),
           reach = work->filter.reach;
    size_t bands = (work->target_rows.end - work->target_rows.first + band_rows - 1) / band_rows;
    size_t blocks = (width + RK_BLOOM_BLOCK - 1) / RK_BLOOM_BLOCK;
    by_taps b = {.work = work, .width = blocks * RK_BLOOM_BLOCK};
    b.strips = (b.width + strip_floats - 1) / strip_floats;
    /* Rows an even number of cache lines apart would map to the same cache sets. */
    b.pitch = (blocks | 1) * RK_BLOOM_BLOCK;
    b.room = b.width + 2 * 3 * reach;
    b.line_room = band_rows + 2 * reach;
    b.reached = rk_allocate_unset(rows, sizeof *b.reached, "bloom", error);
    b.across = rk_allocate_unset(rows, b.pitch * sizeof *b.across, "bloom", error);
    b.masked = rk_allocate(threads * b.room, sizeof *b.masked, "bloom", error);
    b.lines = rk_allocate_unset(threads * b.line_room, sizeof *b.lines, "bloom", error);
    bool ok = b.reached && b.across && b.masked && b.lines;
    if (ok) {
        rk_pool_run(pool, (uint32_t)rows, filter_row, &b);
        rk_pool_run(pool, (uint32_t)bands, filter_band, &b);
    }
    free(b.reached);
    free(b.across);
    free(b.masked);
    free(b.lines);
    return ok;
}
