/* A sample's bits are computed once per tile, and scrambled by each pixel's keys; rays are made in
 * four lanes. Used only if examples give the rays of the feature's own functions to the bit. */
#include "render/lens_rays.h"

#include "base/scramble_run.h"
#include "base/simd4.h"
#include "render/disk_run.h"
#include "render/joint_run.h"

#include <string.h>

/* The sequence's dimensions, in the order of rk_lens_pixels.key. */
static const uint32_t dimensions[4] = {RK_DIMENSION_PIXEL, RK_DIMENSION_PIXEL, RK_DIMENSION_LENS,
                                       RK_DIMENSION_LENS};

static uint32_t joint_dimension(int k)
{
    const int joint = rk_joint_dimension(dimensions[k]);
    return joint < 0 ? RK_SOBOL_DIMENSIONS : (uint32_t)joint + (uint32_t)(k & 1);
}

void rk_lens_pixels_add(rk_lens_pixels *pixels, const rk_render_options *options, uint32_t index,
                        uint32_t x, uint32_t y)
{
    const uint32_t i = pixels->count++;
    pixels->pixel[i] = (uint16_t)index;
    pixels->x[i] = (float)x;
    pixels->y[i] = (float)y;
    for (int k = 0; k < 4; k++)
        pixels->key[k][i] = rk_joint_key(options->seed, y * options->width + x, joint_dimension(k));
}

rk_ray rk_lens_ray_of_pixel(const rk_rendering *r, uint32_t x, uint32_t y, uint32_t sample,
                            uint32_t samples)
{
    const rk_render_options *options = r->options;
    const rk_sampler sampler = rk_render_sampler(options, options->lens_sampling, samples);
    const uint32_t pixel = y * options->width + x;
    rk_vec2 within = rk_joint_2d(&sampler, pixel, sample, RK_DIMENSION_PIXEL);
    rk_vec2 xi = rk_joint_2d(&sampler, pixel, sample, RK_DIMENSION_LENS);
    return rk_lens_ray(&options->lens, &r->view, (float)x + within.x, (float)y + within.y, xi);
}

/* --- Samples of a tile ------------------------------------------------------------------------ */

void rk_lens_group_start(rk_lens_group *group, const rk_lens_pixels *pixels, uint32_t first,
                         uint32_t count)
{
    group->first = first;
    group->count = count;
    for (uint32_t s = 0; s < count; s++) {
        for (int k = 0; k < 4; k++)
            group->bits[k][s] = rk_sobol_bits(rk_sobol_columns[joint_dimension(k)], first + s);
        memset(group->order[s], (int)s, pixels->count);
    }
}

/* The numbers that each pixel takes in a round in one dimension. */
static void draw(const rk_lens_pixels *pixels, const rk_lens_group *group, uint32_t round, int k,
                 float *numbers)
{
    uint32_t bits[RK_BATCH_MAX];
    for (uint32_t i = 0; i < pixels->count; i++)
        bits[i] = group->bits[k][group->order[round][i]];
    rk_scramble_run(pixels->count, bits, pixels->key[k], numbers);
}

/* --- An order for neighbours ------------------------------------------------------------------ */

/* Cells of the unit square that becomes the lens: columns, up and down in turn, so that consecutive
 * cells are neighbours. */
enum { CELLS = 32 };
typedef struct grid {
    uint32_t columns, rows;
} grid;

static grid grid_for(uint32_t count)
{
    const uint32_t columns = (uint32_t)sqrtf((float)count);
    return (grid){columns, CELLS / columns};
}

static inline uint8_t cell_of(grid g, float x, float y)
{
    const uint32_t column = (uint32_t)(x * (float)g.columns), row = (uint32_t)(y * (float)g.rows);
    return (uint8_t)(column * g.rows + (column & 1 ? g.rows - 1 - row : row));
}

/* By counting: comparisons would be too hard to predict. */
static void sort_pixel(rk_lens_group *group, uint8_t cell[][RK_BATCH_MAX], uint32_t pixel)
{
    uint32_t next[CELLS + 1] = {0}; /* the round of a cell's next sample */
    for (uint32_t s = 0; s < group->count; s++)
        next[cell[s][pixel] + 1]++;
    for (uint32_t c = 1; c <= CELLS; c++)
        next[c] += next[c - 1];
    for (uint32_t s = 0; s < group->count; s++)
        group->order[next[cell[s][pixel]]++][pixel] = (uint8_t)s;
}

void rk_lens_group_sort(rk_lens_group *group, const rk_lens_pixels *pixels)
{
    const grid g = grid_for(group->count);
    uint8_t cell[RK_LENS_GROUP_MAX][RK_BATCH_MAX];
    float x[RK_BATCH_MAX], y[RK_BATCH_MAX];
    for (uint32_t s = 0; s < group->count; s++) {
        draw(pixels, group, s, 2, x);
        draw(pixels, group, s, 3, y);
        for (uint32_t i = 0; i < pixels->count; i++)
            cell[s][i] = cell_of(g, x[i], y[i]);
    }
    for (uint32_t i = 0; i < pixels->count; i++)
        sort_pixel(group, cell, i);
}

/* --- Four rays at a time ---------------------------------------------------------------------- */

static inline rk_simd4x3 sum_of(rk_simd4x3 a, rk_vec3 b, rk_simd4 s)
{
    return (rk_simd4x3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

/* As rk_view_through. */
static inline rk_simd4x3 through(const rk_view *view, rk_simd4 x, rk_simd4 y)
{
    const rk_simd4 right = (x - 0.5f * view->width) * view->pixel;
    const rk_simd4 up = (0.5f * view->height - y) * view->pixel;
    return sum_of(sum_of(rk_simd4x3_all(view->forward), view->right, right), view->up, up);
}

/* As the rays of rk_lens_ray through x and y, from this place on a lens of this radius. */
static inline void put_four(const rk_lens *lens, const rk_view *view, rk_simd4 x, rk_simd4 y,
                            rk_simd4 across, rk_simd4 upward, rk_ray_batch *rays, uint32_t first)
{
    const rk_vec3 right = view->right, position = view->position;
    const rk_simd4x3 offset = sum_of(
        (rk_simd4x3){right.x * across, right.y * across, right.z * across}, view->up, upward);
    const rk_simd4x3 to = through(view, x, y);
    rk_simd4 focus = rk_simd4_all(lens->focal_distance);
    if (lens->focal == RK_FOCAL_SPHERE)
        focus /= rk_simd4_sqrt(rk_simd4x3_dot(to, to));
    const rk_simd4 s = -1 / focus;
    const rk_simd4x3 d = rk_simd4x3_normalize(
        (rk_simd4x3){to.x + offset.x * s, to.y + offset.y * s, to.z + offset.z * s});
    rk_simd4_store(&rays->origin_x[first], position.x + offset.x);
    rk_simd4_store(&rays->origin_y[first], position.y + offset.y);
    rk_simd4_store(&rays->origin_z[first], position.z + offset.z);
    rk_simd4_store(&rays->direction_x[first], d.x);
    rk_simd4_store(&rays->direction_y[first], d.y);
    rk_simd4_store(&rays->direction_z[first], d.z);
    rk_simd4_store(&rays->t_max[first], rk_simd4_all(INFINITY));
}

void rk_lens_rays(const rk_rendering *r, const rk_lens_pixels *pixels, const rk_lens_group *group,
                  uint32_t round, rk_ray_batch *rays)
{
    const rk_lens lens = r->options->lens; /* which the batch's stores cannot change */
    const rk_view view = r->view;
    const float radius = 0.5f * (0.001f * lens.aperture);
    float numbers[4][RK_BATCH_MAX];
    for (int k = 0; k < 4; k++)
        draw(pixels, group, round, k, numbers[k]);
    rk_disk_run(pixels->count, numbers[2], numbers[3]);
    for (uint32_t i = 0; i < pixels->count; i += RK_SIMD4_WIDTH)
        put_four(&lens, &view, rk_simd4_load(&pixels->x[i]) + rk_simd4_load(&numbers[0][i]),
                 rk_simd4_load(&pixels->y[i]) + rk_simd4_load(&numbers[1][i]),
                 radius * rk_simd4_load(&numbers[2][i]), radius * rk_simd4_load(&numbers[3][i]),
                 rays, i);
    rays->count = pixels->count;
}

/* --- Are they the features' rays? ------------------------------------------------------------- */

enum { TRIALS = 16, TRIED = 16 }; /* samples, and pixels of each */

static bool is_same(const rk_ray *a, const rk_ray *b)
{
    return memcmp(a, b, sizeof *a) == 0;
}

static bool sample_agrees(const rk_rendering *r, uint32_t sample, uint32_t samples)
{
    const rk_render_options *options = r->options;
    uint32_t x[TRIED], y[TRIED];
    rk_lens_pixels pixels;
    rk_lens_group group;
    rk_ray_batch rays;
    pixels.count = 0;
    for (uint32_t i = 0; i < TRIED; i++) {
        x[i] = rk_hash(sample, i, 0, 0) % options->width;
        y[i] = rk_hash(sample, i, 1, 0) % options->height;
        rk_lens_pixels_add(&pixels, options, 0, x[i], y[i]);
    }
    rk_lens_group_start(&group, &pixels, sample, 1);
    rk_lens_rays(r, &pixels, &group, 0, &rays);
    for (uint32_t i = 0; i < TRIED; i++) {
        const rk_ray four = rk_batch_ray(&rays, i);
        const rk_ray one = rk_lens_ray_of_pixel(r, x[i], y[i], sample, samples);
        if (!is_same(&one, &four))
            return false;
    }
    return true;
}

/* A student's table may name others. */
static bool are_dimensions(void)
{
    for (int k = 0; k < 4; k++)
        if (joint_dimension(k) >= RK_SOBOL_DIMENSIONS)
            return false;
    return true;
}

bool rk_lens_rays_agree(const rk_rendering *r, uint32_t samples)
{
    if (r->options->lens_sampling != RK_SAMPLER_SOBOL || !are_dimensions())
        return false;
    for (uint32_t i = 0; i < TRIALS; i++)
        if (!sample_agrees(r, (uint32_t)((uint64_t)i * samples / TRIALS), samples))
            return false;
    return true;
}
