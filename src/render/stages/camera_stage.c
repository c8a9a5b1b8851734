#include "render/stages/camera_stage.h"

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

static rk_ray sampled_ray(const rk_rendering *r, const rk_sample_pass *pass, uint32_t x, uint32_t y)
{
    const rk_render_options *options = r->options;
    const rk_sampler sampler = {pass->out_of_focus ? options->lens_sampling : options->sampling,
                                options->seed, pass->samples};
    uint32_t pixel = y * options->width + x;
    rk_vec2 within = rk_joint_2d(&sampler, pixel, pass->sample, RK_DIMENSION_PIXEL);
    if (!pass->out_of_focus)
        return rk_view_ray(&r->view, (float)x + within.x, (float)y + within.y);
    rk_vec2 xi = rk_joint_2d(&sampler, pixel, pass->sample, RK_DIMENSION_LENS);
    return rk_lens_ray(&options->lens, &r->view, (float)x + within.x, (float)y + within.y, xi);
}

/* Further time passes take only the samples that need a time, along the same camera ray: with
 * another ray, whether there are further passes would depend on the first one, a bias. */
static void push_pixel(const rk_rendering *r, const rk_sample_pass *pass, uint32_t pixel,
                       rk_path_batch *paths)
{
    const rk_tile *tile = &pass->tile;
    const uint32_t x = tile->x + pixel % tile->width, y = tile->y + pixel / tile->width;
    if (pass->time_pass > 0 && !pass->needs_time[pixel])
        return;
    rk_ray ray = r->plan.pixel_samples || pass->out_of_focus ? sampled_ray(r, pass, x, y)
                                                             : centre_ray(&r->view, x, y);
    if (pass->time_pass > 0)
        paths->path[paths->rays.count] =
            rk_path_start(rk_sample_index_of(pass, pixel).sample, r->options->max_depth);
    rk_path_push_ray(paths, &ray, pixel);
}

static void push_sampled(const rk_rendering *r, const rk_sample_pass *pass, rk_path_batch *paths)
{
    const rk_tile *tile = &pass->tile;
    uint32_t pixel = 0;
    if (r->plan.adaptive_sampling) {
        for (uint32_t i = 0; i < pass->wanted_count; i++)
            push_pixel(r, pass, pass->wanted[i], paths);
    } else {
        for (uint32_t y = tile->y; y < tile->y + tile->height; y++)
            for (uint32_t x = tile->x; x < tile->x + tile->width; x++, pixel++)
                if (rk_is_in_pass(r, pass, x, y))
                    push_pixel(r, pass, pixel, paths);
    }
    bool at_random = r->plan.pixel_samples || pass->out_of_focus;
    pass->counters->pixel_samples += at_random ? paths->rays.count : 0;
    pass->counters->lens_samples += pass->out_of_focus ? paths->rays.count : 0;
}

static void push_centres(rk_view view, rk_tile tile, rk_path_batch *paths)
{
    uint32_t pixel = 0;
    for (uint32_t y = tile.y; y < tile.y + tile.height; y++)
        for (uint32_t x = tile.x; x < tile.x + tile.width; x++, pixel++) {
            rk_ray ray = centre_ray(&view, x, y);
            rk_path_push_ray(paths, &ray, pixel);
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
        push_centres(r->view, pass->tile, paths);
    pass->counters->primary_rays += paths->rays.count;
}
