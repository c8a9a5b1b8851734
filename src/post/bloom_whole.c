/* rk_bloom_whole of post/bloom_passes.h: bright pixels are copied into an image with a margin as
 * wide as the filter's reach, blurred there by a method without border modes, and added. */
#include "post/bloom_passes.h"
#include "post/blur.h"

#include <string.h>

enum { strip_pixels = RK_BLOOM_BLOCK / 3 };

typedef struct whole {
    rk_bloom_work *work;
    rk_image mask; /* the target, with a margin of the filter's reach on all sides */
} whole;

static void bright_pass_row(uint32_t index, uint32_t thread, void *context)
{
    whole *w = context;
    rk_bloom_work *work = w->work;
    ptrdiff_t y = (ptrdiff_t)(work->target_rows.first + index) - (ptrdiff_t)work->filter.reach;
    ptrdiff_t bottom = (ptrdiff_t)work->image->height - 1;
    if (work->filter.border == RK_BLOOM_CLAMP)
        y = y < 0 ? 0 : y > bottom ? bottom : y;
    if (y < 0 || y > bottom)
        return;
    rk_bloom_span bright = work->bright[y], columns = work->target_columns;
    rk_bloom_bright_pass(&work->filter, rk_image_at(work->image, 0, (size_t)y), work->image->width,
                         work->options->threshold, bright, columns.first,
                         columns.end - columns.first, rk_image_at(&w->mask, 0, index));
    work->counters[thread].bloom_pixels_read += bright.end - bright.first;
}

static void composite_row(uint32_t index, uint32_t thread, void *context)
{
    (void)thread;
    whole *w = context;
    rk_bloom_work *work = w->work;
    size_t y = work->target_rows.first + index, x = work->target_columns.first,
           reach = work->filter.reach;
    size_t count = work->target_columns.end - x;
    rk_vec3 *blurred = rk_image_at(&w->mask, reach, reach + index);
    for (size_t i = 0; work->gains_across && i < count; i++)
        blurred[i] = rk_scale(blurred[i], work->gains_across[x + i]);
    rk_bloom_composite(&rk_image_at(work->to, x, y)->x, &blurred->x, 3 * count,
                       work->options->intensity * (work->gains_down ? work->gains_down[y] : 1));
}

bool rk_bloom_whole(rk_bloom_work *work, rk_pool *pool, rk_error *error)
{
    whole w = {.work = work};
    size_t height = work->target_rows.end - work->target_rows.first, reach = work->filter.reach;
    size_t width = work->target_columns.end - work->target_columns.first + 2 * reach;
    width = (width + strip_pixels - 1) / strip_pixels * strip_pixels;
    if (!rk_image_init(&w.mask, width, height + 2 * reach, error))
        return false;
    rk_pool_run(pool, (uint32_t)(height + 2 * reach), bright_pass_row, &w);
    bool ok = true;
    if (work->options->method == RK_BLOOM_RECURSIVE && work->options->radius > 0)
        rk_blur_recursive(&w.mask, 0.5 * work->options->radius, pool);
    else if (work->options->method == RK_BLOOM_PYRAMID)
        ok = rk_blur_pyramid(&w.mask, work->options->radius, pool, error);
    if (ok)
        rk_pool_run(pool, (uint32_t)height, composite_row, &w);
    rk_image_free(&w.mask);
    return ok;
}
