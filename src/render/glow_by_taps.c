/* The light of a picture, filtered by weights: rows first, then columns. What comes of the rows is
 * kept in strips a block wide, one row of it below the other, so that the columns of a strip are
 * filtered from memory that lies together; for small filters it stays in the nearest cache. */
#include "render/glow_passes.h"

#include <stdlib.h>
#include <string.h>

enum { strip_pixels = RK_BLOOM_BLOCK / 3 };

_Static_assert(sizeof(rk_vec3) == 3 * sizeof(float) && RK_BLOOM_BLOCK % 3 == 0,
               "a row of pixels is a row of floats, a block a whole number of pixels");

typedef struct by_taps {
    rk_glowing *g;
    size_t strips;      /* side by side they cover the target columns */
    rk_bloom_span *wet; /* of each row of `rows`: the strips that its light reaches */
    float *across; /* rows filtered along themselves: strip by strip, row by row, a block each */
    size_t room;   /* floats of a thread's own row, which is masked, then filtered */
    float *masked, *filtered;
    size_t line_room;
    const float **lines; /* a thread's own, line_room each */
} by_taps;

static float *block_at(const by_taps *b, size_t strip, size_t y)
{
    size_t rows = b->g->rows.end - b->g->rows.first;
    return b->across + (strip * rows + (y - b->g->rows.first)) * RK_BLOOM_BLOCK;
}

/* --- Rows ------------------------------------------------------------------------------------- */

/* The strips that the light of a row reaches; none (0, 0) if there is no light. */
static rk_bloom_span strips_of(const by_taps *b, rk_bloom_span lit)
{
    const rk_glowing *g = b->g;
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
    rk_glowing *g = b->g;
    size_t y = g->rows.first + index, reach = g->filter.reach;
    rk_bloom_span lit = g->lit[y], wet = strips_of(b, lit);
    b->wet[index] = wet;
    if (wet.first == wet.end)
        return;
    size_t from = g->target_columns.first + wet.first * strip_pixels;
    size_t count = (wet.end - wet.first) * strip_pixels, inside = g->target_columns.end - from;
    float *masked = b->masked + thread * b->room, *filtered = b->filtered + thread * b->room;
    const float **lines = b->lines + thread * b->line_room;
    rk_bloom_mask(&g->filter, rk_image_at(g->image, 0, y), g->image->width, g->options->threshold,
                  lit, from, count < inside ? count : inside, (rk_vec3 *)masked);
    for (size_t k = 0; k <= 2 * reach; k++)
        lines[k] = masked + 3 * k;
    uint32_t taps = rk_bloom_weigh(&g->filter, lines, 3 * count, filtered);
    if (g->gains_across)
        for (size_t i = 0; i < count && i < inside; i++)
            for (size_t c = 0; c < 3; c++)
                filtered[3 * i + c] *= g->gains_across[from + i];
    for (size_t s = wet.first; s < wet.end; s++)
        memcpy(block_at(b, s, y), filtered + (s - wet.first) * RK_BLOOM_BLOCK,
               RK_BLOOM_BLOCK * sizeof *filtered);
    g->counters[thread].bloom_pixels_read += lit.end - lit.first;
    g->counters[thread].bloom_taps += taps * count;
}

/* --- Columns ---------------------------------------------------------------------------------- */

/* The block of row y in the strip, or NULL where it is dark; y may be beyond the border. */
static const float *line_at(const by_taps *b, size_t strip, ptrdiff_t y)
{
    const rk_glowing *g = b->g;
    if (g->filter.border == RK_BLOOM_CLAMP) {
        ptrdiff_t bottom = (ptrdiff_t)g->image->height - 1;
        y = y < 0 ? 0 : y > bottom ? bottom : y;
    }
    if (y < (ptrdiff_t)g->rows.first || y >= (ptrdiff_t)g->rows.end)
        return NULL;
    rk_bloom_span wet = b->wet[(size_t)y - g->rows.first];
    return strip >= wet.first && strip < wet.end ? block_at(b, strip, (size_t)y) : NULL;
}

static void filter_strip(uint32_t strip, uint32_t thread, void *context)
{
    by_taps *b = context;
    rk_glowing *g = b->g;
    size_t reach = g->filter.reach, from = g->target_columns.first + strip * strip_pixels;
    size_t inside = g->target_columns.end - from;
    size_t count = inside < strip_pixels ? inside : strip_pixels;
    size_t first = g->target_rows.first, rows = g->target_rows.end - first;
    const float **lines = b->lines + thread * b->line_room; /* of row first + i, from lines[i] on */
    for (size_t k = 0; k < rows + 2 * reach; k++)
        lines[k] = line_at(b, strip, (ptrdiff_t)(first + k) - (ptrdiff_t)reach);
    for (size_t i = 0; i < rows; i++) {
        float sum[RK_BLOOM_BLOCK];
        size_t y = first + i;
        uint32_t taps = rk_bloom_weigh(&g->filter, lines + i, RK_BLOOM_BLOCK, sum);
        if (taps == 0)
            continue;
        rk_bloom_add(&rk_image_at(g->to, from, y)->x, sum, 3 * count,
                     g->options->intensity * (g->gains_down ? g->gains_down[y] : 1));
        g->counters[thread].bloom_taps += taps * (size_t)strip_pixels;
    }
}

/* --- Both ------------------------------------------------------------------------------------- */

bool rk_glow_by_taps(rk_glowing *g, rk_pool *pool, rk_error *error)
{
    size_t threads = rk_pool_threads(pool), rows = g->rows.end - g->rows.first;
    size_t width = g->target_columns.end - g->target_columns.first, reach = g->filter.reach;
    by_taps b = {.g = g, .strips = (width + strip_pixels - 1) / strip_pixels};
    b.room = 3 * (b.strips * strip_pixels + 2 * reach);
    b.wet = rk_allocate_unset(rows, sizeof *b.wet, "bloom", error);
    b.across =
        rk_allocate_unset(b.strips * rows, RK_BLOOM_BLOCK * sizeof *b.across, "bloom", error);
    b.masked = rk_allocate(threads * b.room, sizeof *b.masked, "bloom", error);
    b.filtered = rk_allocate_unset(threads * b.room, sizeof *b.filtered, "bloom", error);
    b.line_room = g->target_rows.end - g->target_rows.first + 2 * reach + 1;
    b.lines = rk_allocate_unset(threads * b.line_room, sizeof *b.lines, "bloom", error);
    bool ok = b.wet && b.across && b.masked && b.filtered && b.lines;
    if (ok) {
        rk_pool_run(pool, (uint32_t)rows, filter_row, &b);
        rk_pool_run(pool, (uint32_t)b.strips, filter_strip, &b);
    }
    free(b.wet);
    free(b.across);
    free(b.masked);
    free(b.filtered);
    free(b.lines);
    return ok;
}
