/* A Gaussian's weights; a recursive filter, whose work does not depend on the radius; and a
 * pyramid, which blurs a coarse picture instead of a fine one. Sources: see post/blur.h. */
#include "post/blur.h"

#include "post/bloom_passes.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { strip_pixels = RK_BLOOM_BLOCK / 3 };

/* --- Gaussian weights ------------------------------------------------------------------------- */

uint32_t rk_blur_gaussian(double variance, float *weights)
{
    if (!(variance > 0)) {
        weights[0] = 1;
        return 0;
    }
    uint32_t reach = (uint32_t)ceil(3 * sqrt(variance));
    double sum = 1;
    for (uint32_t k = 1; k <= reach; k++)
        sum += 2 * exp(-0.5 * k * k / variance);
    for (uint32_t k = 0; k <= reach; k++)
        weights[k] = (float)(exp(-0.5 * k * k / variance) / sum);
    return reach;
}

/* --- Recursive filter ------------------------------------------------------------------------- */

typedef struct recursive_filter {
    rk_image *image;
    float own, before[3]; /* weights of the pixel itself, and of the results 1, 2 and 3 before it */
} recursive_filter;

/* The paper's equations 11b and 8c. */
static recursive_filter recursive_filter_of(rk_image *image, double sigma)
{
    double q =
        sigma >= 2.5 ? 0.98711 * sigma - 0.96330 : 3.97156 - 4.14554 * sqrt(1 - 0.26891 * sigma);
    double b0 = 1.57825 + 2.44413 * q + 1.4281 * q * q + 0.422205 * q * q * q;
    double b1 = 2.44413 * q + 2.85619 * q * q + 1.26661 * q * q * q;
    double b2 = -1.4281 * q * q - 1.26661 * q * q * q;
    double b3 = 0.422205 * q * q * q;
    return (recursive_filter){image,
                              (float)(1 - (b1 + b2 + b3) / b0),
                              {(float)(b1 / b0), (float)(b2 / b0), (float)(b3 / b0)}};
}

/* Added to all that is filtered, so that no tail gets to denormal numbers, with which processors
 * are slow. No pixel shows it. */
static const float tiny = 0x1p-100f;

/* Filters `side` lines at once, from `at` on in steps of `stride` floats. */
static inline void filter_lines(const recursive_filter *r, float *at, size_t steps,
                                ptrdiff_t stride, int side)
{
    float one[RK_BLOOM_BLOCK] = {0}, two[RK_BLOOM_BLOCK] = {0}, three[RK_BLOOM_BLOCK] = {0};
    for (size_t step = 0; step < steps; step++, at += stride)
        for (int i = 0; i < side; i++) {
            float result =
                r->own * at[i] + tiny +
                (r->before[0] * one[i] + r->before[1] * two[i] + r->before[2] * three[i]);
            three[i] = two[i];
            two[i] = one[i];
            one[i] = at[i] = result;
        }
}

static void filter_row_both_ways(uint32_t y, uint32_t thread, void *context)
{
    (void)thread;
    const recursive_filter *r = context;
    size_t width = r->image->width;
    filter_lines(r, &rk_image_at(r->image, 0, y)->x, width, 3, 3);
    filter_lines(r, &rk_image_at(r->image, width - 1, y)->x, width, -3, 3);
}

static void filter_strip_both_ways(uint32_t strip, uint32_t thread, void *context)
{
    (void)thread;
    const recursive_filter *r = context;
    size_t x = strip * strip_pixels, height = r->image->height;
    ptrdiff_t stride = 3 * (ptrdiff_t)r->image->width;
    filter_lines(r, &rk_image_at(r->image, x, 0)->x, height, stride, RK_BLOOM_BLOCK);
    filter_lines(r, &rk_image_at(r->image, x, height - 1)->x, height, -stride, RK_BLOOM_BLOCK);
}

void rk_blur_recursive(rk_image *image, double variance, rk_pool *pool)
{
    assert(image->width % strip_pixels == 0 && "columns are filtered in whole strips");
    recursive_filter r = recursive_filter_of(image, sqrt(variance));
    rk_pool_run(pool, (uint32_t)image->height, filter_row_both_ways, &r);
    rk_pool_run(pool, (uint32_t)(image->width / strip_pixels), filter_strip_both_ways, &r);
}

/* --- Pyramid ---------------------------------------------------------------------------------- */

/* Halving and doubling have the weights 1 3 3 1: each has a variance of 3/4 pixels. */
typedef struct step {
    rk_image *from, *to;
} step;

static rk_vec3 pixel_or_black(const rk_image *image, ptrdiff_t x, ptrdiff_t y)
{
    bool inside = x >= 0 && y >= 0 && x < (ptrdiff_t)image->width && y < (ptrdiff_t)image->height;
    return inside ? image->pixels[(size_t)y * image->width + (size_t)x] : rk_vec(0, 0, 0);
}

static rk_vec3 weighted_sum(rk_vec3 a, rk_vec3 b, rk_vec3 c, rk_vec3 d)
{
    return rk_madd(rk_scale(rk_add(a, d), 0.125f), rk_add(b, c), 0.375f);
}

static void halve_row(uint32_t row, uint32_t thread, void *context)
{
    (void)thread;
    const step *s = context;
    ptrdiff_t y = 2 * (ptrdiff_t)row;
    rk_vec3 column[4] = {{0, 0, 0}}; /* four columns of the finer image, each filtered */
    for (ptrdiff_t x = -1; x <= 2 * (ptrdiff_t)s->to->width; x++) {
        memmove(column, column + 1, 3 * sizeof *column);
        column[3] =
            weighted_sum(pixel_or_black(s->from, x, y - 1), pixel_or_black(s->from, x, y),
                         pixel_or_black(s->from, x, y + 1), pixel_or_black(s->from, x, y + 2));
        if (x >= 2 && x % 2 == 0)
            *rk_image_at(s->to, (size_t)x / 2 - 1, row) =
                weighted_sum(column[0], column[1], column[2], column[3]);
    }
}

/* Per axis, a pixel of the finer image is 3/4 of the coarse pixel that contains it, and 1/4 of the
 * next. */
static void double_row(uint32_t row, uint32_t thread, void *context)
{
    (void)thread;
    const step *s = context;
    ptrdiff_t y = (ptrdiff_t)(row / 2), beside_y = row % 2 ? y + 1 : y - 1;
    for (size_t i = 0; i < s->to->width; i++) {
        ptrdiff_t x = (ptrdiff_t)(i / 2), beside_x = i % 2 ? x + 1 : x - 1;
        rk_vec3 near =
            rk_mix(pixel_or_black(s->from, x, y), pixel_or_black(s->from, beside_x, y), 0.25f);
        rk_vec3 far = rk_mix(pixel_or_black(s->from, x, beside_y),
                             pixel_or_black(s->from, beside_x, beside_y), 0.25f);
        *rk_image_at(s->to, i, row) = rk_mix(near, far, 0.25f);
    }
}

/* Adds the filtered image to a black one of its size. */
static bool filter_all(const step *s, double variance, rk_pool *pool, rk_error *error)
{
    float weights[RK_BLOOM_RADIUS_MAX + RK_BLUR_GAUSSIAN_MORE + 1];
    const rk_bloom_options all = {.threshold = -INFINITY, .intensity = 1};
    rk_bloom_span rows = {0, s->from->height}, columns = {0, s->from->width};
    rk_bloom_work work = {
        .image = s->from,
        .to = s->to,
        .options = &all,
        .filter = {rk_blur_gaussian(variance, weights), weights, RK_BLOOM_ZERO},
        .rows = rows,
        .columns = columns,
        .target_rows = rows,
        .target_columns = columns,
        .bright = rk_allocate_unset(s->from->height, sizeof *work.bright, "bloom", error),
        .counters = rk_allocate(rk_pool_threads(pool), sizeof *work.counters, "counters", error),
    };
    for (size_t y = 0; work.bright && y < s->from->height; y++)
        work.bright[y] = columns;
    bool ok = work.bright && work.counters && rk_bloom_by_taps(&work, pool, error);
    free(work.bright);
    free(work.counters);
    return ok;
}

/* The n halvings and n doublings have the variance v = 3/4 each, in pixels of their own level, and
 * together 2 v (1 + 4 + ... + 4^(n - 1)) = (4^n - 1) / 2. The Gaussian on the coarsest level
 * provides the rest: its variance counts 4^n times, and from 1.5 on it keeps its shape. */
bool rk_blur_pyramid(rk_image *image, uint32_t radius, rk_pool *pool, rk_error *error)
{
    const double least = 1.5;
    double area = 1; /* of a pixel, 4^n */
    uint32_t n = 0;
    while ((0.5 * radius - 0.5 * (4 * area - 1)) / (4 * area) >= least)
        area *= 4, n++;
    rk_image levels[16] = {*image}, filtered = {0};
    bool ok = true;
    for (uint32_t l = 0; ok && l < n; l++) {
        const rk_image *fine = &levels[l];
        ok = rk_image_init(&levels[l + 1], (fine->width + 1) / 2, (fine->height + 1) / 2, error);
        if (ok)
            rk_pool_run(pool, (uint32_t)levels[l + 1].height, halve_row,
                        &(step){&levels[l], &levels[l + 1]});
    }
    ok = ok && rk_image_init(&filtered, levels[n].width, levels[n].height, error) &&
         filter_all(&(step){&levels[n], &filtered}, (0.5 * radius - 0.5 * (area - 1)) / area, pool,
                    error);
    if (ok)
        memcpy(levels[n].pixels, filtered.pixels,
               filtered.width * filtered.height * sizeof *filtered.pixels);
    for (uint32_t l = n; ok && l-- > 0;)
        rk_pool_run(pool, (uint32_t)levels[l].height, double_row,
                    &(step){&levels[l + 1], &levels[l]});
    rk_image_free(&filtered);
    for (uint32_t l = 1; l <= n; l++)
        rk_image_free(&levels[l]);
    return ok;
}
