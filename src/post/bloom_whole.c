/* The light of a picture, masked into one of its own with a margin as wide as the filter reaches,
 * blurred there by a method that knows no borders, and added. */
#include "post/bloom_passes.h"
#include "post/blur.h"

#include <string.h>

enum { strip_pixels = RK_BLOOM_BLOCK / 3 };

typedef struct whole {
    rk_bloom_work *g;
    rk_image mask; /* of the target, and the filter's reach all around it */
} whole;

static void mask_row(uint32_t index, uint32_t thread, void *context)
{
    whole *w = context;
    rk_bloom_work *g = w->g;
    ptrdiff_t y = (ptrdiff_t)(g->target_rows.first + index) - (ptrdiff_t)g->filter.reach;
    ptrdiff_t bottom = (ptrdiff_t)g->image->height - 1;
    if (g->filter.border == RK_BLOOM_CLAMP)
        y = y < 0 ? 0 : y > bottom ? bottom : y;
    if (y < 0 || y > bottom)
        return;
    rk_bloom_span lit = g->lit[y], columns = g->target_columns;
    rk_bloom_bright_pass(&g->filter, rk_image_at(g->image, 0, (size_t)y), g->image->width,
                         g->options->threshold, lit, columns.first, columns.end - columns.first,
                         rk_image_at(&w->mask, 0, index));
    g->counters[thread].bloom_pixels_read += lit.end - lit.first;
}

static void add_row(uint32_t index, uint32_t thread, void *context)
{
    (void)thread;
    whole *w = context;
    rk_bloom_work *g = w->g;
    size_t y = g->target_rows.first + index, x = g->target_columns.first, reach = g->filter.reach;
    size_t count = g->target_columns.end - x;
    rk_vec3 *glow = rk_image_at(&w->mask, reach, reach + index);
    for (size_t i = 0; g->gains_across && i < count; i++)
        glow[i] = rk_scale(glow[i], g->gains_across[x + i]);
    rk_bloom_composite(&rk_image_at(g->to, x, y)->x, &glow->x, 3 * count,
                       g->options->intensity * (g->gains_down ? g->gains_down[y] : 1));
}

bool rk_bloom_whole(rk_bloom_work *g, rk_pool *pool, rk_error *error)
{
    whole w = {.g = g};
    size_t height = g->target_rows.end - g->target_rows.first, reach = g->filter.reach;
    size_t width = g->target_columns.end - g->target_columns.first + 2 * reach;
    width = (width + strip_pixels - 1) / strip_pixels * strip_pixels;
    if (!rk_image_init(&w.mask, width, height + 2 * reach, error))
        return false;
    rk_pool_run(pool, (uint32_t)(height + 2 * reach), mask_row, &w);
    bool ok = true;
    if (g->options->method == RK_BLOOM_RECURSIVE && g->options->radius > 0)
        rk_blur_recursive(&w.mask, 0.5 * g->options->radius, pool);
    else if (g->options->method == RK_BLOOM_PYRAMID)
        ok = rk_blur_pyramid(&w.mask, g->options->radius, pool, error);
    if (ok)
        rk_pool_run(pool, (uint32_t)height, add_row, &w);
    rk_image_free(&w.mask);
    return ok;
}
