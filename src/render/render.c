/* Each tile goes through the stages once a sample, its pixels in focus first, then the others:
 * camera rays, what they see (follow.c), the light that it gets (light_stage.c). Light arrives on
 * the tile's own sums, so threads share nothing but the next tile's number. */
#include "render/render.h"

#include "post/bloom_stage.h"
#include "render/tile.h"

#include <stdlib.h>
#include <string.h>

static void forget_motion(rk_tile *t)
{
    memset(t->in_motion, 0, sizeof t->in_motion);
    memset(t->in_sight, 0, sizeof t->in_sight);
    memset(t->has_time, 0, sizeof t->has_time);
}

void rk_tile_start(const rk_rendering *r, rk_tile *t, uint32_t index, uint32_t thread)
{
    const rk_render_options *options = r->options;
    t->x = index % r->tiles_across * RK_TILE_SIDE;
    t->y = index / r->tiles_across * RK_TILE_SIDE;
    t->width = options->width - t->x < RK_TILE_SIDE ? options->width - t->x : RK_TILE_SIDE;
    t->height = options->height - t->y < RK_TILE_SIDE ? options->height - t->y : RK_TILE_SIDE;
    t->seen_count = 0;
    t->counters = &r->counters[thread];
    memset(t->sum, 0, sizeof t->sum);
    t->turn = 0;
    if (r->plan.motion)
        forget_motion(t);
}

/* The tile's pixels that a circle of confusion reaches, or all others, and how many samples they
 * take. */
static void choose_pixels(const rk_rendering *r, rk_tile *t, bool blurred)
{
    const rk_render_options *options = r->options;
    t->blurred = blurred;
    t->samples = options->samples;
    if (blurred && t->samples < options->lens_samples)
        t->samples = options->lens_samples;
    t->turns = rk_time_passes(&r->plan, options, t->samples);
}

static bool is_chosen(const rk_rendering *r, const rk_tile *t, uint32_t x, uint32_t y)
{
    return !r->coc_count ||
           (r->coc_count[(size_t)y * (r->options->width + 1) + x] > 0) == t->blurred;
}

/* What is the same for all camera rays of a sample. */
static void start_paths(rk_path_batch *camera, uint32_t left, uint32_t sample)
{
    camera->path[0] = rk_path_start(sample, left);
    for (uint32_t filled = 1; filled < RK_BATCH_MAX; filled *= 2)
        memcpy(camera->path + filled, camera->path, filled * sizeof *camera->path);
}

static rk_ray centre_ray(const rk_view *view, uint32_t x, uint32_t y)
{
    return rk_view_ray(view, (float)x + 0.5f, (float)y + 0.5f);
}

/* Through a random place of the pixel; from the camera's position, or a random place of the lens.
 */
static rk_ray sampled_ray(const rk_rendering *r, const rk_tile *t, uint32_t x, uint32_t y)
{
    const rk_render_options *options = r->options;
    const rk_sampler sampler = {t->blurred ? options->lens_sampling : options->sampling,
                                options->seed, t->samples};
    uint32_t pixel = y * options->width + x;
    rk_vec2 within = rk_sample_2d(&sampler, pixel, t->sample, RK_DIMENSION_PIXEL);
    if (!t->blurred)
        return rk_view_ray(&r->view, (float)x + within.x, (float)y + within.y);
    rk_vec2 xi = rk_sample_2d(&sampler, pixel, t->sample, RK_DIMENSION_LENS);
    return rk_lens_ray(&options->lens, &r->view, (float)x + within.x, (float)y + within.y, xi);
}

/* Rays for the chosen pixels; the turns beyond the first are for samples in motion alone, and look
 * along the same ray: were there others, whether there are any would hang on the first. */
static void push_chosen(const rk_rendering *r, const rk_tile *t, rk_path_batch *camera)
{
    bool sampled = r->plan.pixel_samples || t->blurred;
    uint32_t pixel = 0;
    for (uint32_t y = t->y; y < t->y + t->height; y++)
        for (uint32_t x = t->x; x < t->x + t->width; x++, pixel++)
            if (is_chosen(r, t, x, y) && (t->turn == 0 || t->in_motion[pixel])) {
                rk_ray ray = sampled ? sampled_ray(r, t, x, y) : centre_ray(&r->view, x, y);
                if (t->turn > 0)
                    camera->path[camera->rays.count] =
                        rk_path_start(rk_sample_index_of(t, pixel).sample, r->options->max_depth);
                rk_path_push_ray(camera, &ray, pixel);
            }
    t->counters->pixel_samples += sampled ? camera->rays.count : 0;
    t->counters->lens_samples += t->blurred ? camera->rays.count : 0;
}

/* A ray through the centre of every pixel. */
static void push_all(rk_view view, const rk_tile *t, rk_path_batch *camera)
{
    uint32_t pixel = 0;
    for (uint32_t y = t->y; y < t->y + t->height; y++)
        for (uint32_t x = t->x; x < t->x + t->width; x++, pixel++) {
            rk_ray ray = centre_ray(&view, x, y);
            rk_path_push_ray(camera, &ray, pixel);
        }
}

static void camera_stage(const rk_rendering *r, rk_tile *t, rk_path_batch *camera)
{
    camera->rays.count = 0;
    if (r->plan.time_samples)
        memset(t->has_time, 0, sizeof t->has_time);
    if (t->turn == 0)
        start_paths(camera, r->options->max_depth, t->sample);
    if (r->plan.pixel_samples || r->plan.lens || r->plan.motion)
        push_chosen(r, t, camera);
    else
        push_all(r->view, t, camera);
    t->counters->primary_rays += camera->rays.count;
}

/* The next sample of each chosen pixel; where it is in motion, the mean over its turns. False if no
 * pixel is chosen. */
static bool take_sample(const rk_rendering *r, rk_tile *t, rk_path_batch *camera)
{
    rk_vec3 before[RK_BATCH_MAX];
    if (r->plan.time_samples) {
        memcpy(before, t->sum, sizeof before);
        forget_motion(t);
    }
    for (t->turn = 0; t->turn < t->turns; t->turn++) {
        camera_stage(r, t, camera);
        if (camera->rays.count == 0)
            break;
        rk_trace_paths(r, t, camera);
    }
    for (uint32_t i = 0; i < t->width * t->height && t->turns > 1; i++)
        if (t->in_motion[i])
            t->sum[i] = rk_madd(before[i], rk_sub(t->sum[i], before[i]), 1 / (float)t->turns);
    return t->turn > 0;
}

/* The chosen pixels' sums become means. */
static void mean_stage(const rk_rendering *r, rk_tile *t)
{
    if (t->samples == 1)
        return;
    uint32_t pixel = 0;
    for (uint32_t y = t->y; y < t->y + t->height; y++)
        for (uint32_t x = t->x; x < t->x + t->width; x++, pixel++)
            if (is_chosen(r, t, x, y))
                t->sum[pixel] = rk_scale(t->sum[pixel], 1 / (float)t->samples);
}

static void film_stage(const rk_rendering *r, const rk_tile *t)
{
    for (uint32_t y = 0; y < t->height; y++)
        memcpy(rk_image_at(r->image, t->x, t->y + y), t->sum + y * t->width,
               t->width * sizeof *t->sum);
}

static void render_tile(uint32_t index, uint32_t thread, void *context)
{
    rk_rendering *r = context;
    rk_tile t;
    rk_path_batch camera;
    rk_tile_start(r, &t, index, thread);
    for (int blurred = 0; blurred <= r->plan.lens; blurred++) {
        choose_pixels(r, &t, blurred);
        for (t.sample = 0; r->plan.rays && t.sample < t.samples; t.sample++)
            if (!take_sample(r, &t, &camera))
                break;
        mean_stage(r, &t);
    }
    film_stage(r, &t);
    if (r->progress)
        rk_progress_step(r->progress);
}

static uint32_t tiles_along(uint32_t pixels)
{
    return (pixels + RK_TILE_SIDE - 1) / RK_TILE_SIDE;
}

uint32_t rk_render_tiles(const rk_render_options *options)
{
    return tiles_along(options->width) * tiles_along(options->height);
}

bool rk_render(rk_image *image, const rk_scene *scene, const rk_accel *accel,
               const rk_render_options *options, rk_pool *pool, rk_counters *counters,
               rk_progress *progress, rk_error *error)
{
    if (!pool || image->width != options->width || image->height != options->height)
        return rk_fail(error,
                       "the renderer needs threads, and an image of the options' size, %u x %u",
                       options->width, options->height);
    if (!rk_render_check(scene, options, error))
        return false;
    uint32_t threads = rk_pool_threads(pool);
    rk_rendering r = {
        .scene = scene,
        .accel = accel,
        .options = options,
        .plan = rk_plan_of(scene, options),
        .view = rk_view_of(&scene->camera, options->width, options->height),
        .tiles_across = tiles_along(options->width),
        .image = image,
        .counters = rk_allocate(threads, sizeof *r.counters, "counters", error),
        .progress = progress,
    };
    rk_moving_prepare(&r);
    if (!r.counters || !rk_focus_find(&r, pool, error)) {
        free(r.counters);
        return false;
    }
    rk_pool_run(pool, rk_render_tiles(options), render_tile, &r);
    *counters = (rk_counters){0};
    for (uint32_t i = 0; i < threads; i++)
        rk_counters_add(counters, &r.counters[i]);
    free(r.counters);
    free(r.coc_count);
    return !r.plan.bloom || rk_bloom_stage(image, &options->bloom, pool, counters, error);
}
