/* From rays to what they see: surfaces, their light, and what mirrors and panes show of further
 * ones. A batch of rays makes a batch of seen surfaces, these make a batch of mirrored rays, and so
 * on; a level of mirrors is a level of recursion. */
#include "accel/ray_group.h"
#include "base/reflect.h"
#include "render/lighting.h"

static void light_and_mirror(const rk_rendering *r, rk_tile *t);

static rk_shading_point *room_for_one(const rk_rendering *r, rk_tile *t)
{
    if (t->seen_count == RK_BATCH_MAX)
        light_and_mirror(r, t);
    return &t->seen[t->seen_count++];
}

__attribute__((always_inline)) static inline void see(rk_shading_point *seen, const rk_rendering *r,
                                                      rk_tile *t, const rk_path_batch *paths,
                                                      uint32_t i, const rk_hit *hit)
{
    rk_ray ray = rk_batch_ray(&paths->rays, i);
    rk_scene_surface(&seen->surface, r->scene, &ray, hit);
    if (r->plan.motion)
        rk_moving_place(r, t, paths->pixel[i], hit->triangle, &seen->surface);
    seen->kd = seen->surface.material->kd;
    if (r->plan.textures)
        seen->kd = rk_surface_kd(&seen->surface, &r->scene->mesh);
    seen->to_viewer = rk_vec(0, 0, 0);
    if (r->plan.viewer)
        seen->to_viewer = rk_negate(rk_normalize(ray.direction));
    seen->path = paths->path[i];
    seen->pixel = paths->pixel[i];
}

void rk_shading_point_at(rk_shading_point *seen, const rk_rendering *r, rk_tile *t,
                         const rk_path_batch *paths, uint32_t i, const rk_hit *hit, uint32_t panes,
                         float share)
{
    see(seen, r, t, paths, i, hit);
    const rk_path *path = &paths->path[i];
    seen->path =
        rk_path_of(rk_scale(path->weight, share), path->sample, path->spread, path->left - panes);
}

rk_vec3 rk_environment_radiance(const rk_rendering *r, const rk_path_batch *paths, uint32_t i,
                                float share, rk_counters *counters)
{
    rk_vec3 colour = rk_cubemap_at(&r->scene->environment, rk_batch_ray(&paths->rays, i).direction,
                                   r->options->environment_filter);
    counters->environment_lookups++;
    return rk_mul(rk_scale(paths->path[i].weight, share), colour);
}

/* The rest of path i meets nothing. */
static void see_behind(const rk_rendering *r, rk_tile *t, const rk_path_batch *paths, uint32_t i,
                       float share)
{
    if (!r->plan.environment || !(share > 0))
        return;
    rk_vec3 *sum = &t->sum[paths->pixel[i]];
    *sum = rk_add(*sum, rk_environment_radiance(r, paths, i, share, t->counters));
}

void rk_trace_closest(const rk_rendering *r, rk_tile *t, const rk_path_batch *paths)
{
    if (!r->plan.motion) {
        rk_accel_closest(r->accel, &paths->rays, &t->hits, t->counters);
        return;
    }
    rk_asker asker = {r, t, paths->pixel, paths->path[0].left == r->options->max_depth};
    const rk_moments when = rk_moments_of(&asker);
    rk_accel_closest_at(r->accel, &paths->rays, &when, &t->hits, t->counters);
}

static void see_nearest(const rk_rendering *r, rk_tile *t, const rk_path_batch *paths)
{
    /* A bundle knows one tree. */
    if (paths->path[0].spread && r->scene->moving_count == 0)
        rk_ray_group_closest(r->accel, &paths->rays, &t->hits, t->counters);
    else
        rk_trace_closest(r, t, paths);
    const bool environment = r->plan.environment;
    rk_shading_point *seen = t->seen; /* nothing else is seen now, so there is room for all */
    for (uint32_t i = 0; i < paths->rays.count; i++) {
        if (t->hits.triangle[i] == RK_MISS) {
            if (environment)
                see_behind(r, t, paths, i, 1);
            continue;
        }
        rk_hit hit = rk_batch_hit(&t->hits, i);
        see(seen++, r, t, paths, i, &hit);
    }
    t->seen_count = (uint32_t)(seen - t->seen);
}

float rk_trace_transparent(const rk_rendering *r, rk_tile *t, const rk_path_batch *paths,
                           uint32_t i, rk_crossing_list *list, float weights[RK_MAX_DEPTH + 1])
{
    rk_asker asker = {r, t, paths->pixel, paths->path[i].left == r->options->max_depth};
    const rk_moments when = rk_moments_of(&asker);
    rk_ray ray = rk_batch_ray(&paths->rays, i);
    float behind;
    rk_crossings_gather_at(r->accel, &ray, r->plan.motion ? &when : NULL, i,
                           paths->path[i].left + 1u, list, t->counters);
    rk_transparency_weights(list->crossings, list->count, weights, &behind);
    return list->count < list->limit ? behind : 0;
}

/* All panes that each ray passes, and the surface behind them. */
static void see_through(const rk_rendering *r, rk_tile *t, const rk_path_batch *paths)
{
    for (uint32_t i = 0; i < paths->rays.count; i++) {
        rk_crossing_list list;
        float weights[RK_MAX_DEPTH + 1];
        see_behind(r, t, paths, i, rk_trace_transparent(r, t, paths, i, &list, weights));
        for (uint32_t k = 0; k < list.count; k++)
            if (weights[k] > 0) {
                rk_hit hit = rk_crossing_hit(&list.crossings[k]);
                rk_shading_point_at(room_for_one(r, t), r, t, paths, i, &hit, k, weights[k]);
            }
    }
}

rk_vec3 rk_reflected_direction(const rk_shading_point *seen)
{
    rk_vec3 incoming = rk_negate(seen->to_viewer);
    rk_vec3 direction = rk_reflect(incoming, seen->surface.normal);
    return rk_dot(direction, seen->surface.face_normal) > 0
               ? direction
               : rk_reflect(incoming, seen->surface.face_normal);
}

bool rk_is_specular(const rk_shading_point *seen)
{
    return seen->path.left > 0 &&
           !rk_is_black(rk_mul(seen->path.weight, seen->surface.material->ks));
}

void rk_spawn_reflection(const rk_shading_point *seen, rk_path_batch *mirrored)
{
    if (!rk_is_specular(seen))
        return;
    rk_vec3 direction = rk_reflected_direction(seen);
    rk_ray ray = {rk_surface_spawn(&seen->surface, direction), direction, INFINITY};
    const rk_path *path = &seen->path;
    rk_path_push(mirrored, &ray, seen->pixel,
                 rk_path_of(rk_mul(path->weight, seen->surface.material->ks), path->sample,
                            path->spread, path->left - 1u));
}

static void mirror_all(const rk_rendering *r, rk_tile *t)
{
    rk_path_batch mirrored;
    mirrored.rays.count = 0;
    for (uint32_t i = 0; i < t->seen_count; i++)
        rk_spawn_reflection(&t->seen[i], &mirrored);
    t->seen_count = 0;
    t->counters->reflected_rays += mirrored.rays.count;
    if (mirrored.rays.count)
        rk_trace_paths(r, t, &mirrored);
}

/* Finishes with the seen surfaces, and makes room for others. */
static void light_and_mirror(const rk_rendering *r, rk_tile *t)
{
    bool physical = r->options->light.falloff == RK_FALLOFF_PHYSICAL;
    for (uint32_t i = 0; i < r->scene->light_count; i++) {
        const rk_light *light = &r->scene->lights[i];
        if (!rk_light_emits(light))
            continue;
        if (light->kind == RK_LIGHT_POINT && !physical)
            rk_point_light_stage(r, t, light);
        else
            rk_parallelogram_light_stage(r, t, i);
    }
    if (r->plan.glossy)
        rk_glossy_stage(r, t);
    else if (r->plan.reflections)
        mirror_all(r, t);
    t->seen_count = 0;
}

void rk_trace_paths(const rk_rendering *r, rk_tile *t, const rk_path_batch *paths)
{
    if (r->plan.transparency)
        see_through(r, t, paths);
    else
        see_nearest(r, t, paths);
    light_and_mirror(r, t);
}
