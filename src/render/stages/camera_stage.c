/* Pixels are taken in squares of 4 x 4, whose rays traverse the tree as packets. Rays through pixel
 * centres are made four at a time, each as by rk_view_ray to the bit. */
#include "render/stages/camera_stage.h"

#include "base/simd4.h"
#include "render/stages/depth_of_field_stage.h"

#include <string.h>

/* All camera rays of a sample start with the same path, copied in doubling blocks. */
static void start_paths(const rk_rendering *r, const rk_sample_pass *pass, rk_path_batch *paths)
{
    paths->path[0] = rk_path_start(pass->sample, r->options->max_depth);
    for (uint32_t filled = 1; filled < RK_BATCH_MAX; filled *= 2)
        memcpy(paths->path + filled, paths->path, filled * sizeof *paths->path);
}

static rk_ray centre_ray(const rk_view *view, uint32_t x, uint32_t y)
{
    return rk_view_ray(view, (float)x + 0.5f, (float)y + 0.5f);
}

/* Numbers of consecutive samples of a pixel are drawn together. */
enum { RUN_MAX = 32 };
typedef struct run_numbers {
    rk_vec2 within[RUN_MAX], on_lens[RUN_MAX]; /* the pixel; with pass->out_of_focus */
} run_numbers;

static void draw(const rk_rendering *r, const rk_sample_pass *pass, uint32_t pixel, uint32_t sample,
                 uint32_t count, run_numbers *numbers)
{
    const rk_render_options *options = r->options;
    const rk_sampler sampler = rk_render_sampler(
        options, pass->out_of_focus ? options->lens_sampling : options->sampling, pass->samples);
    rk_joint_2d_run(&sampler, pixel, sample, count, RK_DIMENSION_PIXEL, numbers->within);
    if (pass->out_of_focus)
        rk_joint_2d_run(&sampler, pixel, sample, count, RK_DIMENSION_LENS, numbers->on_lens);
}

static rk_ray sampled_ray(const rk_rendering *r, const rk_sample_pass *pass, uint32_t x, uint32_t y,
                          const run_numbers *numbers, uint32_t k)
{
    const float film_x = (float)x + numbers->within[k].x, film_y = (float)y + numbers->within[k].y;
    return pass->out_of_focus
               ? rk_lens_ray(&r->options->lens, &r->view, film_x, film_y, numbers->on_lens[k])
               : rk_view_ray(&r->view, film_x, film_y);
}

/* One sample of a pixel, or, if samples are wanted, `count` of them from the `first` on. Further
 * time passes take only the samples that need a time, along the same camera ray: with another ray,
 * whether there are further passes would depend on the first one, a bias. */
static void push_run(const rk_rendering *r, const rk_sample_pass *pass, uint32_t first,
                     uint32_t count, rk_path_batch *paths)
{
    const rk_tile *tile = &pass->tile;
    const rk_wanted_sample at = rk_sample_at(pass, first);
    const uint32_t x = tile->x + at.pixel % tile->width, y = tile->y + at.pixel / tile->width;
    const bool at_random = r->plan.pixel_samples || pass->out_of_focus;
    run_numbers numbers;
    if (pass->time_pass > 0 && !pass->needs_time[first])
        return;
    if (at_random)
        draw(r, pass, y * r->options->width + x, at.sample, count, &numbers);
    for (uint32_t k = 0; k < count; k++) {
        const rk_ray ray =
            at_random ? sampled_ray(r, pass, x, y, &numbers, k) : centre_ray(&r->view, x, y);
        if (pass->time_pass > 0 || pass->wanted_count > 0)
            paths->path[paths->rays.count] =
                rk_path_start(rk_sample_index_of(pass, first + k).sample, r->options->max_depth);
        rk_path_push_ray(paths, &ray, first + k);
    }
}

static void push_wanted(const rk_rendering *r, const rk_sample_pass *pass, rk_path_batch *paths)
{
    for (uint32_t first = 0, end = 1; first < pass->wanted_count; first = end++) {
        while (end < pass->wanted_count && end < first + RUN_MAX &&
               pass->wanted[end].pixel == pass->wanted[first].pixel)
            end++;
        push_run(r, pass, first, end - first, paths);
    }
}

/* Squares of 4 x 4 pixels follow each other, because their rays are closer together than a row's:
 * sixteen rays traverse the tree as a packet. */
enum { SQUARE = 4 };

static uint32_t at_most(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/* The pixels of the pass, in this order. Returns their number. */
static uint32_t find_pixels(const rk_rendering *r, const rk_sample_pass *pass, uint16_t *pixels)
{
    const rk_tile *tile = &pass->tile;
    uint32_t count = 0;
    for (uint32_t y0 = 0; y0 < tile->height; y0 += SQUARE)
        for (uint32_t x0 = 0; x0 < tile->width; x0 += SQUARE)
            for (uint32_t y = y0; y < at_most(y0 + SQUARE, tile->height); y++)
                for (uint32_t x = x0; x < at_most(x0 + SQUARE, tile->width); x++)
                    if (rk_is_in_pass(r, pass, tile->x + x, tile->y + y))
                        pixels[count++] = (uint16_t)(y * tile->width + x);
    return count;
}

static void push_pixels(const rk_rendering *r, const rk_sample_pass *pass, const uint16_t *pixels,
                        uint32_t count, rk_path_batch *paths)
{
    for (uint32_t i = 0; i < count; i++)
        push_run(r, pass, pixels[i], 1, paths);
}

static void push_lens(const rk_rendering *r, const rk_sample_pass *pass, rk_path_batch *paths)
{
    const rk_lens_pixels *lens = pass->lens;
    const rk_lens_group *group = pass->lens_group;
    rk_lens_rays(r, lens, group, pass->lens_round, &paths->rays);
    memcpy(paths->pixel, lens->pixel, lens->count * sizeof *paths->pixel);
    for (uint32_t i = 0; i < lens->count; i++)
        paths->path[i] =
            rk_path_start(group->first + group->order[pass->lens_round][i], r->options->max_depth);
}

static void push_sampled(const rk_rendering *r, const rk_sample_pass *pass, rk_path_batch *paths)
{
    uint16_t pixels[RK_BATCH_MAX];
    if (r->plan.adaptive_sampling)
        push_wanted(r, pass, paths);
    else if (pass->lens && pass->time_pass == 0)
        push_lens(r, pass, paths);
    else
        push_pixels(r, pass, pixels, find_pixels(r, pass, pixels), paths);
    bool at_random = r->plan.pixel_samples || pass->out_of_focus;
    pass->counters->pixel_samples += at_random ? paths->rays.count : 0;
    pass->counters->lens_samples += pass->out_of_focus ? paths->rays.count : 0;
}

void rk_camera_lens_pixels(const rk_rendering *r, const rk_sample_pass *pass, rk_lens_pixels *lens)
{
    const rk_tile *tile = &pass->tile;
    uint16_t pixels[RK_BATCH_MAX];
    const uint32_t count = find_pixels(r, pass, pixels);
    lens->count = 0;
    for (uint32_t i = 0; i < count; i++)
        rk_lens_pixels_add(lens, r->options, pixels[i], tile->x + pixels[i] % tile->width,
                           tile->y + pixels[i] / tile->width);
}

/* What all rays of a pinhole have in common. */
static void fill_batch(rk_vec3 origin, rk_path_batch *paths)
{
    rk_ray_batch *rays = &paths->rays;
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        rays->origin_x[i] = origin.x;
        rays->origin_y[i] = origin.y;
        rays->origin_z[i] = origin.z;
        rays->t_max[i] = INFINITY;
    }
}

/* How far a row of the tile lies above the picture's middle. */
static rk_vec3 raised_row(const rk_view *view, uint32_t y)
{
    return rk_scale(view->up, (0.5f * view->height - ((float)y + 0.5f)) * view->pixel);
}

/* The directions of up to four pixels of a row, each as by rk_view_ray to the bit: the picture
 * plane is at distance 1, so that no direction is too short to be normalized. Lanes beyond the last
 * pixel are overwritten by the next ones, or lie beyond the batch's count. */
static inline void push_four(const rk_view *view, const rk_tile *tile, uint32_t x, uint32_t y,
                             rk_vec3 raised, rk_path_batch *paths)
{
    const rk_simd4 lanes = {0.5f, 1.5f, 2.5f, 3.5f}, one = rk_simd4_all(1);
    const rk_simd4 column = rk_simd4_all((float)(tile->x + x)) + lanes;
    const rk_simd4 across = (column - 0.5f * view->width) * view->pixel;
    const rk_simd4x3 d = {view->forward.x + view->right.x * across + raised.x,
                          view->forward.y + view->right.y * across + raised.y,
                          view->forward.z + view->right.z * across + raised.z};
    const rk_simd4x3 unit = rk_simd4x3_scale(d, one / rk_simd4_sqrt(rk_simd4x3_dot(d, d)));
    rk_ray_batch *rays = &paths->rays;
    const uint32_t first = rays->count, width = at_most(SQUARE, tile->width - x);
    rk_simd4_store(&rays->direction_x[first], unit.x);
    rk_simd4_store(&rays->direction_y[first], unit.y);
    rk_simd4_store(&rays->direction_z[first], unit.z);
    for (uint32_t i = 0; i < SQUARE; i++) /* beyond the width, likewise */
        paths->pixel[first + i] = (uint16_t)(y * tile->width + x + i);
    rays->count += width;
}

_Static_assert(SQUARE == (int)RK_SIMD4_WIDTH && (int)RK_TILE_SIDE % SQUARE == 0,
               "a whole row leaves no lane over");

static void push_centres(const rk_view *view, rk_tile tile, rk_path_batch *paths)
{
    const rk_view own = *view; /* which the batch's stores cannot change */
    fill_batch(view->position, paths);
    for (uint32_t y0 = 0; y0 < tile.height; y0 += SQUARE) {
        const uint32_t rows = at_most(SQUARE, tile.height - y0);
        rk_vec3 raised[SQUARE];
        for (uint32_t k = 0; k < rows; k++)
            raised[k] = raised_row(&own, tile.y + y0 + k);
        for (uint32_t x = 0; x < tile.width; x += SQUARE)
            for (uint32_t k = 0; k < rows; k++)
                push_four(&own, &tile, x, y0 + k, raised[k], paths);
    }
}

void rk_camera_stage(const rk_rendering *r, const rk_sample_pass *pass, rk_path_batch *paths)
{
    paths->rays.count = 0;
    if (pass->time_pass == 0)
        start_paths(r, pass, paths);
    if (r->plan.pixel_samples || r->plan.depth_of_field || r->plan.motion_blur)
        push_sampled(r, pass, paths);
    else
        push_centres(&r->view, pass->tile, paths);
    pass->counters->primary_rays += paths->rays.count;
}
