/* Computes position, normals and material where each ray hits. Paths through transparent surfaces
 * have several such points, and go on in the next batch if this one is full. */
#include "render/stages/shade_stage.h"

#include "features/motion_blur.h"
#include "render/stages/cubemap_stage.h"

/* Moves a hit surface from its object's rest position to that at this time. */
static void move_surface(const rk_scene *scene, float time, uint32_t triangle, rk_surface *surface)
{
    uint32_t object = rk_scene_moving_object(scene, triangle);
    if (object != RK_MISS)
        rk_surface_move(surface, rk_motion_offset(&scene->moving[object].motion, time));
}

/* Inlined into both callers, because it runs per hit. `time` is read only with plan.motion_blur. */
__attribute__((always_inline)) static inline void
shading_point_at(rk_shading_point *point, const rk_rendering *r, const rk_path_batch *paths,
                 uint32_t i, const rk_hit *hit, const float *time)
{
    rk_ray ray = rk_batch_ray(&paths->rays, i);
    rk_scene_surface(&point->surface, r->scene, &ray, hit);
    if (r->options->face_shadows)
        point->surface.smooth = NULL;
    if (r->plan.motion_blur)
        move_surface(r->scene, *time, hit->triangle, &point->surface);
    point->kd = point->surface.material->kd;
    if (r->plan.varying_kd)
        point->kd = rk_surface_kd(&point->surface, &r->scene->mesh);
    point->to_viewer = rk_vec(0, 0, 0);
    if (r->plan.viewer)
        point->to_viewer = rk_negate(rk_normalize(ray.direction));
    point->path = paths->path[i];
    point->pixel = paths->pixel[i];
}

void rk_shading_point_at(rk_shading_point *point, const rk_rendering *r, const rk_path_batch *paths,
                         uint32_t i, const rk_hit *hit, float time)
{
    shading_point_at(point, r, paths, i, hit, &time);
}

void rk_shading_point_behind(rk_shading_point *point, const rk_rendering *r,
                             const rk_path_batch *paths, uint32_t i, const rk_visible_hits *visible,
                             uint32_t k)
{
    const rk_path *path = &paths->path[i];
    rk_shading_point_at(point, r, paths, i, &visible->hits[k], visible->time);
    point->path = rk_path_of(rk_scale(path->throughput, visible->weights[k]), path->sample,
                             path->split, path->bounces_left - k);
}

void rk_shade_stage(const rk_rendering *r, const rk_path_batch *paths, const rk_hit_batch *hits,
                    const rk_ray_times *times, rk_shading_points *points)
{
    rk_shading_point *point = points->points;
    for (uint32_t i = 0; i < paths->rays.count; i++)
        if (hits->triangle[i] != RK_MISS) {
            rk_hit hit = rk_batch_hit(hits, i);
            shading_point_at(point++, r, paths, i, &hit, &times->time[i]);
        }
    points->count = (uint32_t)(point - points->points);
}

/* Shades the visible hits of the path traced last. False if the batch is full before the last. */
static bool shade_visible(const rk_rendering *r, const rk_path_batch *paths,
                          rk_shading_cursor *cursor, rk_shading_points *points)
{
    const rk_visible_hits *visible = &cursor->visible;
    for (; cursor->hit < visible->count; cursor->hit++) {
        if (!(visible->weights[cursor->hit] > 0))
            continue;
        if (points->count == RK_BATCH_MAX)
            return false;
        rk_shading_point_behind(&points->points[points->count++], r, paths, cursor->path - 1,
                                visible, cursor->hit);
    }
    return true;
}

void rk_shade_transparent_stage(const rk_rendering *r, rk_sample_pass *pass,
                                const rk_path_batch *paths, rk_shading_cursor *cursor,
                                rk_shading_points *points, rk_film *film)
{
    points->count = 0;
    while (shade_visible(r, paths, cursor, points) && cursor->path < paths->rays.count) {
        rk_transparency_stage(r, pass, paths, cursor->path, &cursor->visible);
        if (r->plan.background && cursor->visible.behind > 0)
            rk_film_add(film, paths->pixel[cursor->path],
                        rk_environment_radiance(r, paths, cursor->path, cursor->visible.behind,
                                                pass->counters));
        cursor->path++;
        cursor->hit = 0;
    }
}
