/* The rays of --steps: the same in both orders, so that all steps can be compared. */
#include "driver.h"

#include "accel/query/trace.h"
#include "base/random.h"
#include "features/ambient_occlusion.h"

#include <stdlib.h>

static void push(ray_set *set, uint32_t tile, const rk_ray *ray, uint32_t pixel)
{
    set->pixel[tile][set->batch[tile].count] = pixel;
    rk_batch_push(&set->batch[tile], ray);
}

/* Every second bit: a coordinate of place k in Z order. */
static uint32_t even_bits(uint32_t k)
{
    return (k & 1) | (k >> 1 & 2) | (k >> 2 & 4) | (k >> 3 & 8);
}

/* Through the centres of a tile's pixels: row by row, as in pictures, or in Z order. */
static void push_tile(ray_set *set, const rk_driver *driver, int order, uint32_t tile)
{
    const rk_render_options *o = &driver->render;
    const rk_view view = rk_view_of(&driver->scene.camera, o->width, o->height);
    const uint32_t columns = (o->width + RK_TILE_SIDE - 1) / RK_TILE_SIDE;
    for (uint32_t k = 0; k < RK_BATCH_MAX; k++) {
        const bool in_rows = order == ROWS;
        const uint32_t x =
            tile % columns * RK_TILE_SIDE + (in_rows ? k % RK_TILE_SIDE : even_bits(k));
        const uint32_t y =
            tile / columns * RK_TILE_SIDE + (in_rows ? k / RK_TILE_SIDE : even_bits(k >> 1));
        const rk_ray ray = rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f);
        if (x < o->width && y < o->height)
            push(set, tile, &ray, y * o->width + x);
    }
}

static void push_shadow_ray(ray_set *set, uint32_t tile, const rk_surface *surface, rk_vec3 light,
                            uint32_t pixel)
{
    const rk_vec3 to_light = rk_sub(light, surface->point);
    const rk_vec3 start = rk_surface_spawn(surface, to_light);
    const rk_ray ray = {start, rk_sub(light, start), 1};
    if (rk_dot(surface->normal, to_light) > 0)
        push(set, tile, &ray, pixel);
}

/* Distributed by the cosine, at random. */
static void push_diffuse_ray(ray_set *set, uint32_t tile, const rk_surface *surface, uint32_t pixel)
{
    const rk_vec2 xi = {rk_unit_float(rk_hash(pixel, 0, 0, 1)),
                        rk_unit_float(rk_hash(pixel, 0, 1, 1))};
    const rk_ambient_frame frame = rk_ambient_frame_of(surface->normal, surface->face_normal);
    rk_ray ray = {.t_max = INFINITY};
    if (!rk_ambient_direction(&frame, rk_ambient_hemisphere(RK_AMBIENT_COSINE, xi), &ray.direction))
        return;
    ray.origin = rk_surface_spawn(surface, ray.direction);
    push(set, tile, &ray, pixel);
}

/* From the hits of a tile's camera rays. */
static void push_from_hits(ray_set sets[WORKLOADS], const rk_accel *accel, uint32_t tile)
{
    const rk_ray_batch *primary = &sets[PRIMARY].batch[tile];
    const rk_scene *scene = accel->scene;
    rk_hit_batch hits;
    rk_counters counters = {0};
    rk_accel_closest(accel, primary, &hits, &counters);
    for (uint32_t i = 0; i < primary->count; i++) {
        const rk_ray ray = rk_batch_ray(primary, i);
        const rk_hit hit = rk_batch_hit(&hits, i);
        const uint32_t pixel = sets[PRIMARY].pixel[tile][i];
        rk_surface surface;
        if (hit.triangle == RK_MISS)
            continue;
        rk_scene_surface(&surface, scene, &ray, &hit);
        if (scene->light_count)
            push_shadow_ray(&sets[SHADOW], tile, &surface, scene->lights[0].position, pixel);
        push_diffuse_ray(&sets[DIFFUSE], tile, &surface, pixel);
    }
}

void free_rays(ray_set sets[WORKLOADS])
{
    for (int w = 0; w < WORKLOADS; w++) {
        free(sets[w].batch);
        free(sets[w].pixel);
    }
}

bool make_rays(ray_set sets[WORKLOADS], const rk_driver *driver, int order, const rk_accel *accel,
               rk_error *error)
{
    const uint32_t columns = (driver->render.width + RK_TILE_SIDE - 1) / RK_TILE_SIDE;
    const uint32_t rows = (driver->render.height + RK_TILE_SIDE - 1) / RK_TILE_SIDE;
    for (int w = 0; w < WORKLOADS; w++) {
        sets[w].batches = columns * rows;
        sets[w].batch = rk_allocate(columns * rows, sizeof *sets[w].batch, "rays", error);
        sets[w].pixel = rk_allocate(columns * rows, sizeof *sets[w].pixel, "rays", error);
        if (!sets[w].batch || !sets[w].pixel)
            return false;
    }
    for (uint32_t tile = 0; tile < columns * rows; tile++) {
        push_tile(&sets[PRIMARY], driver, order, tile);
        push_from_hits(sets, accel, tile);
        for (int w = 0; w < WORKLOADS; w++)
            sets[w].rays += sets[w].batch[tile].count;
    }
    return true;
}
