/* Each tile is rendered in passes, one per sample: first its pixels in focus, then the others. A
 * pass (render_sample.c) makes camera rays, traces the paths that start with them (paths.c), and
 * adds their radiance to the tile's film. Each tile has a film of its own, so threads share nothing
 * but the next tile's number. */
#include "render/render.h"

#include "render/feature_hooks.h"
#include "render/lens_passes.h"
#include "render/ray_record.h"
#include "render/render_sample.h"
#include "render/stages/adaptive_sampling_stage.h"
#include "render/stages/camera_stage.h"
#include "render/stages/film_stage.h"
#include "render/tile_run.h"
#include "render/tiles.h"
#include "render/time_passes.h"

#include <stdlib.h>
#include <string.h>

typedef struct render_job {
    rk_rendering rendering;
    rk_path_workspace *workspaces; /* one per thread */
    rk_counters *counters;         /* one per thread */
    rk_image *image;
    rk_progress *progress;
} render_job;

/* Of a tile, over its pixels in focus or over the others. */
static void start_passes(const rk_rendering *r, bool out_of_focus, rk_sample_pass *pass,
                         rk_lens_pixels *lens)
{
    const rk_render_options *options = r->options;
    uint32_t samples = options->samples;
    if (out_of_focus && samples < options->lens_samples)
        samples = options->lens_samples;
    pass->out_of_focus = out_of_focus;
    pass->samples = samples;
    pass->time_passes = rk_time_passes(&r->plan, options, samples);
    pass->lens = out_of_focus && r->lens_rays_agree ? lens : NULL;
    if (pass->lens)
        rk_camera_lens_pixels(r, pass, lens);
}

static void render_tile(uint32_t index, uint32_t thread, void *context)
{
    const render_job *job = context;
    const rk_rendering *r = &job->rendering;
    rk_sample_pass pass;
    rk_lens_pixels lens;
    rk_film film;
    pass.tile = rk_tile_at(r->options, index);
    pass.counters = &job->counters[thread];
    pass.wanted_count = 0;
    memset(&film, 0, sizeof film);
    for (int out_of_focus = 0; out_of_focus <= r->plan.depth_of_field; out_of_focus++) {
        start_passes(r, out_of_focus, &pass, &lens);
        if (pass.lens && lens.count > 0)
            rk_lens_passes(r, &pass, &job->workspaces[thread], &film);
        for (pass.sample = 0; !pass.lens && r->plan.rays && pass.sample < pass.samples;
             pass.sample++)
            if (!rk_render_sample(r, &pass, &job->workspaces[thread], &film))
                break;
        rk_film_mean(r, &pass, &film);
    }
    rk_film_stage(&pass.tile, &film, job->image);
}

/* --- The picture ------------------------------------------------------------------------------ */

static void free_job(render_job *job, uint32_t threads)
{
    for (uint32_t i = 0; job->workspaces && i < threads; i++)
        rk_path_queue_free(&job->workspaces[i].queue);
    free(job->workspaces);
    free(job->counters);
    rk_features_release(&job->rendering);
}

/* Memory, and the features' own preparations. */
static bool prepare_job(render_job *job, rk_pool *pool, rk_error *error)
{
    rk_rendering *r = &job->rendering;
    uint32_t threads = rk_pool_threads(pool);
    job->counters = rk_allocate(threads, sizeof *job->counters, "counters", error);
    job->workspaces = rk_allocate_unset(threads, sizeof *job->workspaces, "paths", error);
    bool ok = job->counters && job->workspaces;
    for (uint32_t i = 0; job->workspaces && i < threads; i++)
        job->workspaces[i].queue = (rk_path_queue){0};
    for (uint32_t i = 0; ok && i < threads; i++)
        ok = rk_path_queue_init(&job->workspaces[i].queue, r, error);
    return ok && rk_features_prepare(r, error) &&
           rk_features_prepass(r, pool, job->counters, error);
}

static bool render_picture(render_job *job, rk_pool *pool, rk_counters *counters, rk_error *error)
{
    bool ok = true;
    rk_image *image = job->image;
    const rk_tile_run run = {job->rendering.options, image->pixels, sizeof *image->pixels,
                             job->counters, job->progress};
    *counters = (rk_counters){0};
    if (job->rendering.plan.adaptive_sampling)
        ok = rk_adaptive_sampling_stage(&job->rendering, job->workspaces, job->counters, image,
                                        pool, error);
    else
        ok = rk_tile_run_all(&run, pool, render_tile, job, error);
    for (uint32_t i = 0; i < rk_pool_threads(pool); i++)
        rk_counters_add(counters, &job->counters[i]);
    return ok;
}

/* --- One pixel -------------------------------------------------------------------------------- */

static bool render_pixel(render_job *job, const rk_ray_record *record, rk_pool *pool,
                         rk_error *error)
{
    const rk_render_options *options = job->rendering.options;
    const uint32_t x = record->pixel % options->width, y = record->pixel / options->width;
    if (record->through_lens && job->rendering.coc_count)
        job->rendering.coc_count[(size_t)y * (options->width + 1) + x] = 1;
    if (job->rendering.plan.adaptive_sampling)
        return rk_adaptive_sampling_stage(&job->rendering, job->workspaces, job->counters,
                                          job->image, pool, error);
    render_tile(y / RK_TILE_SIDE * rk_tiles_along(options->width) + x / RK_TILE_SIDE, 0, job);
    return true;
}

bool rk_ray_record_pixel(rk_ray_record *record, const rk_scene *scene, const rk_accel *accel,
                         const rk_render_options *options, rk_pool *pool, rk_error *error)
{
    rk_image image = {0};
    if (!rk_render_check(scene, options, error) ||
        !rk_image_init(&image, options->width, options->height, error))
        return false;
    const rk_render_options adapted = rk_adaptive_sampling_options_of(options);
    render_job job = {.rendering = rk_rendering_of(scene, accel, &adapted), .image = &image};
    job.rendering.record = record;
    const bool ok = prepare_job(&job, pool, error) && render_pixel(&job, record, pool, error);
    free_job(&job, rk_pool_threads(pool));
    rk_image_free(&image);
    return ok && (!record->is_short ||
                  rk_fail(error, "no memory for the rays of a pixel: take fewer samples, or close "
                                 "other programs"));
}

/* --- Tiles ------------------------------------------------------------------------------------ */

uint32_t rk_render_tiles(const rk_render_options *options)
{
    return rk_tile_count(options);
}

bool rk_render(rk_image *image, const rk_scene *scene, const rk_accel *accel,
               const rk_render_options *options, rk_pool *pool, rk_counters *counters,
               rk_progress *progress, rk_error *error)
{
    if (!pool || image->width != options->width || image->height != options->height)
        return rk_fail(error,
                       "the renderer needs threads, and an image of the options' size, %u x %u",
                       options->width, options->height);
    if (!rk_team_agree(rk_pool_team(pool), rk_render_check(scene, options, error), error))
        return false;
    const rk_render_options adapted = rk_adaptive_sampling_options_of(options);
    options = &adapted;
    render_job job = {
        .rendering = rk_rendering_of(scene, accel, options),
        .image = image,
        .progress = progress,
    };
    bool ok = rk_team_agree(rk_pool_team(pool), prepare_job(&job, pool, error), error);
    ok = ok && render_picture(&job, pool, counters, error);
    free_job(&job, rk_pool_threads(pool));
    return ok && rk_features_post(image, &job.rendering, pool, counters, error);
}
