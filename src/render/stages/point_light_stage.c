#include "render/stages/point_light_stage.h"

static inline void add_unoccluded(const rk_shading_point *point, rk_vec3 contribution,
                                  rk_film *film)
{
    rk_film_add(film, point->pixel, rk_mul(point->path.throughput, contribution));
}

static void add_all(const rk_rendering *r, const rk_shading_points *points, rk_light_sample light,
                    rk_film *film)
{
    const rk_shading *shading = &r->options->shading;
    const rk_shading_point *end = points->points + points->count;
    for (const rk_shading_point *point = points->points; point < end; point++) {
        rk_vec3 to_light = rk_sub(light.position, point->surface.point);
        rk_vec3 contribution = rk_reflected_radiance(shading, point, to_light, light.colour);
        add_unoccluded(point, contribution, film);
    }
}

static void queue_shadow_rays(const rk_rendering *r, const rk_shading_points *points,
                              rk_light_sample light, rk_shadow_queue *queue)
{
    queue->rays.count = 0;
    for (uint32_t i = 0; i < points->count; i++) {
        const rk_shading_point *point = &points->points[i];
        rk_vec3 to_light = rk_sub(light.position, point->surface.point);
        rk_vec3 contribution =
            rk_reflected_radiance(&r->options->shading, point, to_light, light.colour);
        if (!rk_is_black(contribution))
            rk_queue_shadow_ray(queue, points, i, to_light, light.position, contribution);
    }
}

void rk_point_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                          const rk_shading_points *points, const rk_light *light,
                          rk_shadow_queue *queue, rk_shadow_answers *answers, rk_film *film)
{
    const rk_light_options *options = &r->options->light;
    const rk_light_sample everywhere = rk_light_sample_at(light, options->falloff, options->domain,
                                                          light->position, (rk_vec2){0, 0});
    if (!r->plan.shadow_rays) {
        add_all(r, points, everywhere, film);
        return;
    }
    queue_shadow_rays(r, points, everywhere, queue);
    if (queue->rays.count == 0)
        return;
    rk_shadow_stage(r, pass, queue, answers);
    for (uint32_t k = 0; k < queue->rays.count; k++)
        if (!answers->occlusion.occluded[k])
            add_unoccluded(&points->points[queue->point[k]], rk_unoccluded(r, queue, answers, k),
                           film);
}
