/* All scenes are variations of the Cornell box with a parallelogram light. A region is found by
 * tracing each pixel's centre; pixels that the moving block covers at any of the shutter's times
 * are a region of their own. */
#include "driver/compared_scene.h"

#include "accel/query/trace_one.h"
#include "features/motion_blur.h"
#include "scenes/builtin.h"

#include <stdio.h>

RK_NAMES(rk_compared_names, rk_compared_kind, RK_COMPARED_COUNT - 1, "cornell", "lens", "motion");
RK_NAMES(rk_compared_region_names, rk_compared_region, RK_REGION_COUNT - 1, "nothing", "floor",
         "ceiling", "back wall", "left wall", "right wall", "low block", "tall block",
         "block in motion");

/* --- Scenes ---------------------------------------------------------------------------------- */

/* The first triangle of each region in cornell-light (scenes/cornell.c). */
static const struct {
    uint32_t first;
    rk_compared_region region;
} parts[] = {
    {20, RK_REGION_TALL_BLOCK}, {10, RK_REGION_LOW_BLOCK}, {8, RK_REGION_RIGHT_WALL},
    {6, RK_REGION_LEFT_WALL},   {4, RK_REGION_BACK_WALL},  {2, RK_REGION_CEILING},
    {0, RK_REGION_FLOOR},
};

enum { tall_block = 20, triangles = 30 };

/* White walls then reflect a radiance of about 0.5. */
static const float radiance = 30;

static void light_up(rk_scene *scene)
{
    for (int k = 0; k < 4; k++)
        scene->lights[0].colours[k] = rk_scale(scene->lights[0].colours[k], radiance);
}

static rk_render_options options_for(rk_compared_kind kind, uint32_t side, uint32_t samples)
{
    rk_render_options options = rk_render_options_default();
    options.width = options.height = side;
    options.samples = samples;
    options.shadows = true;
    options.shading.normalized = true;
    options.light.falloff = RK_FALLOFF_PHYSICAL;
    options.light.domain = RK_LIGHT_DOMAIN_SOLID_ANGLE;
    options.light.samples = 4;
    options.light.early_out = 0;
    if (kind == RK_COMPARED_LENS) {
        options.lens_samples = samples;
        options.lens.focal_distance = 2.5f;
        options.lens.aperture = 150;
    }
    if (kind == RK_COMPARED_MOTION) {
        options.motion.samples = samples;
        options.motion.sampling = RK_TIME_LOW_DISCREPANCY;
        options.motion.shutter = (rk_shutter){0, 0.15f};
    }
    return options;
}

bool rk_compared_scene_init(rk_compared_scene *compared, rk_compared_kind kind, uint32_t side,
                            uint32_t samples, rk_error *error)
{
    rk_scene *scene = &compared->scene;
    if (!rk_builtin_scene(scene, "cornell-light", error))
        return false;
    snprintf(scene->name, sizeof scene->name, "%s", rk_compared_names.items[kind]);
    light_up(scene);
    if (kind == RK_COMPARED_MOTION) {
        scene->moving[0] = (rk_moving){tall_block, triangles - tall_block, rk_motion_default()};
        scene->moving_count = 1;
    }
    compared->options = options_for(kind, side, samples);
    return true;
}

void rk_compared_scene_free(rk_compared_scene *compared)
{
    rk_scene_free(&compared->scene);
}

/* --- Regions --------------------------------------------------------------------------------- */

static rk_compared_region region_of(uint32_t triangle)
{
    for (size_t i = 0; triangle != RK_MISS && i < sizeof parts / sizeof *parts; i++)
        if (triangle >= parts[i].first)
            return parts[i].region;
    return RK_REGION_NONE;
}

/* A scene's trees, apart: of what never moves, and of one object at rest. */
typedef struct trees {
    rk_scene at_rest, moving; /* parts of the compared scene, which owns the arrays */
    rk_accel of_rest, of_moving;
    bool moves;
} trees;

static bool build(trees *t, const rk_scene *scene, rk_error *error)
{
    *t = (trees){.at_rest = *scene, .moving = *scene, .moves = scene->moving_count > 0};
    t->at_rest.moving_count = t->moving.moving_count = 0;
    if (t->moves) {
        const rk_moving *object = &scene->moving[0];
        t->at_rest.mesh.triangle_count = object->first;
        t->moving.mesh.triangles += object->first;
        t->moving.mesh.triangle_materials += object->first;
        t->moving.mesh.triangle_count = object->count;
    }
    return rk_accel_build(&t->of_rest, RK_ACCEL_MEDIAN, &t->at_rest, error) &&
           rk_accel_build(&t->of_moving, RK_ACCEL_MEDIAN, &t->moving, error);
}

static void release(trees *t)
{
    rk_accel_free(&t->of_rest);
    rk_accel_free(&t->of_moving);
}

/* Is the object in front at any time while the shutter is open? */
static bool sees_moving(const trees *t, const rk_compared_scene *compared, const rk_ray *ray,
                        float nearest)
{
    const uint32_t times = 64;
    for (uint32_t k = 1; k <= times; k++) {
        const rk_shutter *shutter = &compared->options.motion.shutter;
        const float time = rk_shutter_equidistant(shutter, (float)k, times);
        const rk_vec3 offset = rk_motion_offset(&compared->scene.moving[0].motion, time);
        const rk_ray shifted = rk_motion_ray(offset, ray);
        const rk_hit hit = rk_trace_one(&t->of_moving, &shifted);
        if (hit.triangle != RK_MISS && hit.t < nearest)
            return true;
    }
    return false;
}

bool rk_compared_regions(const rk_compared_scene *compared, uint8_t *regions, rk_error *error)
{
    const rk_render_options *options = &compared->options;
    const rk_view view = rk_view_of(&compared->scene.camera, options->width, options->height);
    trees t;
    const bool ok = build(&t, &compared->scene, error);
    for (uint32_t i = 0; ok && i < options->width * options->height; i++) {
        const uint32_t x = i % options->width, y = i / options->width;
        const rk_ray ray = rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f);
        const rk_hit hit = rk_trace_one(&t.of_rest, &ray);
        const float nearest = hit.triangle == RK_MISS ? INFINITY : hit.t;
        const bool moving = t.moves && sees_moving(&t, compared, &ray, nearest);
        regions[i] = (uint8_t)(moving ? RK_REGION_MOVING : region_of(hit.triangle));
    }
    release(&t);
    return ok;
}
