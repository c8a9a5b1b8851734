/* Each tile goes through the stages once a sample: camera rays, their nearest hits, then for each
 * light what it would add and a shadow ray to ask whether it may. Light arrives on the tile's own
 * sums, so threads share nothing but the next tile's number. */
#include "render/render.h"

#include "base/sampler.h"
#include "scene/surface.h"

#include <stdlib.h>
#include <string.h>

typedef struct rendering {
    const rk_scene *scene;
    const rk_accel *accel;
    const rk_render_options *options;
    rk_plan plan;
    rk_view view;
    rk_sampler sampler;
    uint32_t tiles_across;
    rk_image *image;
    rk_counters *counters; /* one for each thread */
    rk_progress *progress;
} rendering;

/* What passes from stage to stage, on a thread's stack. */
typedef struct tile {
    uint32_t x, y, width, height; /* pixels */
    rk_ray_batch camera;          /* one ray a pixel, row by row */
    rk_hit_batch hits;
    uint32_t surface_count; /* the pixels that see something, and what they see */
    uint16_t surface_pixel[RK_BATCH_MAX];
    rk_surface surfaces[RK_BATCH_MAX];
    uint32_t arriving_count; /* light on its way to pixels, if nothing is in its way */
    uint16_t arriving_pixel[RK_BATCH_MAX];
    rk_vec3 arriving[RK_BATCH_MAX];
    rk_ray_batch shadow;       /* asks that, a ray each, where the plan wants shadows */
    rk_vec3 sum[RK_BATCH_MAX]; /* over the samples so far, one a pixel */
} tile;

static void start_tile(const rendering *r, tile *t, uint32_t index)
{
    const rk_render_options *options = r->options;
    t->x = index % r->tiles_across * RK_TILE_SIDE;
    t->y = index / r->tiles_across * RK_TILE_SIDE;
    t->width = options->width - t->x < RK_TILE_SIDE ? options->width - t->x : RK_TILE_SIDE;
    t->height = options->height - t->y < RK_TILE_SIDE ? options->height - t->y : RK_TILE_SIDE;
    memset(t->sum, 0, sizeof t->sum);
}

static void camera_stage(const rendering *r, tile *t, uint32_t sample, rk_counters *counters)
{
    t->camera.count = 0;
    for (uint32_t y = t->y; y < t->y + t->height; y++)
        for (uint32_t x = t->x; x < t->x + t->width; x++) {
            rk_vec2 within = {0.5f, 0.5f};
            if (r->plan.pixel_samples)
                within = rk_sample_2d(&r->sampler, y * r->options->width + x, sample,
                                      RK_DIMENSION_PIXEL);
            rk_ray ray = rk_view_ray(&r->view, (float)x + within.x, (float)y + within.y);
            rk_batch_push(&t->camera, &ray);
        }
    counters->primary_rays += t->camera.count;
    counters->pixel_samples += r->plan.pixel_samples ? t->camera.count : 0;
}

static void surface_stage(const rendering *r, tile *t)
{
    t->surface_count = 0;
    for (uint32_t i = 0; i < t->camera.count; i++) {
        if (t->hits.triangle[i] == RK_MISS)
            continue;
        rk_ray ray = rk_batch_ray(&t->camera, i);
        rk_hit hit = rk_batch_hit(&t->hits, i);
        t->surface_pixel[t->surface_count] = (uint16_t)i;
        rk_scene_surface(&t->surfaces[t->surface_count++], r->scene, &ray, &hit);
    }
}

/* Lambert's law. Surfaces that are turned away from the light, or reflect none of it, need no
 * shadow ray. */
static void light_stage(const rendering *r, tile *t, const rk_light *light)
{
    t->arriving_count = 0;
    t->shadow.count = 0;
    for (uint32_t i = 0; i < t->surface_count; i++) {
        const rk_surface *surface = &t->surfaces[i];
        rk_vec3 to_light = rk_sub(light->position, surface->point);
        float cos_i = rk_dot(surface->normal, rk_normalize(to_light));
        if (!(cos_i > 0))
            continue;
        rk_vec3 reflected = rk_mul(surface->material->kd, light->colours[0]);
        if (reflected.x == 0 && reflected.y == 0 && reflected.z == 0)
            continue;
        t->arriving_pixel[t->arriving_count] = t->surface_pixel[i];
        t->arriving[t->arriving_count++] = rk_scale(reflected, cos_i);
        if (r->plan.shadow_rays) {
            /* From the point, t = 0, to the light, t = 1. */
            rk_vec3 start = rk_surface_leave(surface, to_light);
            rk_ray ray = {start, rk_sub(light->position, start), 1};
            rk_batch_push(&t->shadow, &ray);
        }
    }
}

static void arrive_stage(const rendering *r, tile *t, rk_counters *counters)
{
    rk_any_batch blocked;
    if (r->plan.shadow_rays) {
        rk_accel_any(r->accel, &t->shadow, &blocked, counters);
        counters->shadow_rays += t->shadow.count;
    }
    for (uint32_t i = 0; i < t->arriving_count; i++) {
        if (r->plan.shadow_rays && blocked.found[i])
            continue;
        rk_vec3 *sum = &t->sum[t->arriving_pixel[i]];
        *sum = rk_add(*sum, t->arriving[i]);
    }
}

static void film_stage(const rendering *r, const tile *t)
{
    for (uint32_t y = 0; y < t->height; y++)
        for (uint32_t x = 0; x < t->width; x++)
            *rk_image_at(r->image, t->x + x, t->y + y) =
                rk_scale(t->sum[y * t->width + x], 1 / (float)r->options->samples);
}

static void render_tile(uint32_t index, uint32_t thread, void *context)
{
    rendering *r = context;
    rk_counters *counters = &r->counters[thread];
    tile t;
    start_tile(r, &t, index);
    for (uint32_t sample = 0; r->plan.rays && sample < r->options->samples; sample++) {
        camera_stage(r, &t, sample, counters);
        rk_accel_closest(r->accel, &t.camera, &t.hits, counters);
        surface_stage(r, &t);
        for (uint32_t light = 0; light < r->scene->light_count; light++) {
            if (!rk_light_shines(&r->scene->lights[light]))
                continue;
            light_stage(r, &t, &r->scene->lights[light]);
            arrive_stage(r, &t, counters);
        }
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
    if (options->width < 1 || options->height < 1 || options->samples < 1)
        return rk_fail(error, "a picture has at least one pixel, and a pixel at least one sample");
    uint32_t threads = rk_pool_threads(pool);
    rendering r = {
        .scene = scene,
        .accel = accel,
        .options = options,
        .plan = rk_plan_of(scene, options),
        .view = rk_view_of(&scene->camera, options->width, options->height),
        .sampler = {RK_SAMPLER_UNIFORM, options->seed},
        .tiles_across = tiles_along(options->width),
        .image = image,
        .counters = rk_allocate(threads, sizeof *r.counters, "counters", error),
        .progress = progress,
    };
    if (!r.counters)
        return false;
    rk_pool_run(pool, rk_render_tiles(options), render_tile, &r);
    *counters = (rk_counters){0};
    for (uint32_t i = 0; i < threads; i++)
        rk_counters_add(counters, &r.counters[i]);
    free(r.counters);
    return true;
}
