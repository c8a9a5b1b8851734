/* The cost of features that a scene does not need: a renderer with nothing but the work for Lambert
 * surfaces and point lights, which is camera rays, closest hits and shadow rays. `check` compares
 * its number of instructions with that of rk_render for the same picture. */
#include "render/render.h"

#include "accel/query/trace.h"
#include "scene/surface.h"
#include "scenes/builtin.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct lean_point {
    rk_surface surface;
    uint16_t pixel;
} lean_point;

typedef struct lean_tile {
    const rk_scene *scene;
    const rk_accel *accel;
    const rk_render_options *options;
    rk_view view;
    rk_counters counters;
    uint32_t x, y, width, height;
    rk_ray_batch camera;
    uint16_t camera_pixel[RK_BATCH_MAX];
    rk_hit_batch hits;
    uint32_t point_count;
    lean_point points[RK_BATCH_MAX];
    uint32_t contribution_count;
    uint16_t contribution_pixel[RK_BATCH_MAX];
    rk_vec3 contributions[RK_BATCH_MAX];
    rk_ray_batch shadow;
    rk_occlusion_batch occlusion;
    rk_vec3 sum[RK_BATCH_MAX];
} lean_tile;

static void trace_and_shade(lean_tile *t)
{
    t->camera.count = t->point_count = 0;
    for (uint32_t square = 0; square < RK_BATCH_MAX; square += 16)
        for (uint32_t k = 0; k < 16; k++) { /* 4 x 4 pixels follow each other, as in rk_render */
            uint32_t x = square / 16 % 4 * 4 + k % 4, y = square / 64 * 4 + k / 4;
            if (x >= t->width || y >= t->height)
                continue;
            rk_ray ray = rk_view_ray(&t->view, (float)(t->x + x) + 0.5f, (float)(t->y + y) + 0.5f);
            t->camera_pixel[t->camera.count] = (uint16_t)(y * t->width + x);
            rk_batch_push(&t->camera, &ray);
        }
    t->counters.primary_rays += t->camera.count;
    rk_accel_closest(t->accel, &t->camera, &t->hits, &t->counters);
    for (uint32_t i = 0; i < t->camera.count; i++) {
        if (t->hits.triangle[i] == RK_MISS)
            continue;
        rk_ray ray = rk_batch_ray(&t->camera, i);
        rk_hit hit = rk_batch_hit(&t->hits, i);
        t->points[t->point_count].pixel = t->camera_pixel[i];
        rk_scene_surface(&t->points[t->point_count++].surface, t->scene, &ray, &hit);
    }
}

static void queue_shadow_rays(lean_tile *t, const rk_light *light)
{
    t->contribution_count = t->shadow.count = 0;
    for (uint32_t i = 0; i < t->point_count; i++) {
        const rk_surface *surface = &t->points[i].surface;
        rk_vec3 to_light = rk_sub(light->position, surface->point);
        float cos_i = rk_dot(surface->normal, rk_normalize(to_light));
        rk_vec3 kd = surface->material->kd;
        if (!(cos_i > 0) || (kd.x == 0 && kd.y == 0 && kd.z == 0))
            continue;
        t->contribution_pixel[t->contribution_count] = t->points[i].pixel;
        t->contributions[t->contribution_count++] = rk_mul(light->colours[0], rk_scale(kd, cos_i));
        if (!t->options->shadows)
            continue;
        rk_vec3 start = rk_surface_spawn_to_light(surface, to_light);
        rk_ray ray = {start, rk_sub(light->position, start), 1};
        rk_batch_push(&t->shadow, &ray);
    }
}

static void add_unoccluded(lean_tile *t)
{
    if (t->options->shadows)
        rk_accel_occluded(t->accel, &t->shadow, &t->occlusion, &t->counters);
    t->counters.shadow_rays += t->shadow.count;
    for (uint32_t i = 0; i < t->contribution_count; i++) {
        rk_vec3 *sum = &t->sum[t->contribution_pixel[i]];
        if (!t->options->shadows || !t->occlusion.occluded[i])
            *sum = rk_add(*sum, t->contributions[i]);
    }
}

static void render_tile(lean_tile *t, rk_image *image)
{
    memset(t->sum, 0, sizeof t->sum);
    trace_and_shade(t);
    for (uint32_t i = 0; i < t->scene->light_count; i++) {
        queue_shadow_rays(t, &t->scene->lights[i]);
        add_unoccluded(t);
    }
    const rk_vec3 *sum = t->sum;
    for (uint32_t y = 0; y < t->height; y++)
        for (uint32_t x = 0; x < t->width; x++)
            *rk_image_at(image, t->x + x, t->y + y) = *sum++;
}

__attribute__((noinline)) static void render_lean(rk_image *image, const rk_scene *scene,
                                                  const rk_accel *accel,
                                                  const rk_render_options *options)
{
    static lean_tile t;
    t = (lean_tile){.scene = scene, .accel = accel, .options = options};
    t.view = rk_view_of(&scene->camera, options->width, options->height);
    for (t.y = 0; t.y < options->height; t.y += RK_TILE_SIDE)
        for (t.x = 0; t.x < options->width; t.x += RK_TILE_SIDE) {
            t.width = options->width - t.x < RK_TILE_SIDE ? options->width - t.x : RK_TILE_SIDE;
            t.height = options->height - t.y < RK_TILE_SIDE ? options->height - t.y : RK_TILE_SIDE;
            render_tile(&t, image);
        }
}

static bool run(const char *name, bool shadows, rk_error *error)
{
    rk_render_options options = rk_render_options_default();
    rk_scene scene;
    rk_accel accel;
    rk_image lean, whole;
    rk_counters counters;
    options.width = options.height = 200;
    options.shadows = shadows;
    rk_pool *pool = rk_pool_start(1, error);
    if (!pool || !rk_builtin_scene(&scene, name, error) ||
        !rk_accel_build(&accel, RK_ACCEL_WIDE, &scene, error) ||
        !rk_image_init(&lean, options.width, options.height, error) ||
        !rk_image_init(&whole, options.width, options.height, error) ||
        !rk_render(&whole, &scene, &accel, &options, pool, &counters, NULL, error))
        return false;
    render_lean(&lean, &scene, &accel, &options);
    bool same =
        memcmp(lean.pixels, whole.pixels, sizeof(rk_vec3) * options.width * options.height) == 0;
    rk_image_free(&lean);
    rk_image_free(&whole);
    rk_accel_free(&accel);
    rk_scene_free(&scene);
    rk_pool_stop(pool);
    return same || rk_fail(error, "%s: the two pictures differ", name);
}

int main(int count, char **arguments)
{
    rk_error error;
    if (count < 2 || count > 3 || (count == 3 && strcmp(arguments[2], "shadows") != 0)) {
        fprintf(stderr, "usage: lean SCENE [shadows]\n");
        return 2;
    }
    if (run(arguments[1], count == 3, &error))
        return 0;
    fprintf(stderr, "lean: %s\n", error.text);
    return 1;
}
