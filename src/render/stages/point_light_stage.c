/* Directions are normalized four at a time, and only contributions that are not black get a shadow
 * ray. */
#include "render/stages/point_light_stage.h"

#include "base/simd4.h"

/* Unit directions from shading points to a light. */
typedef struct light_directions {
    float x[RK_BATCH_MAX], y[RK_BATCH_MAX], z[RK_BATCH_MAX];
} light_directions;

static inline rk_vec3 direction_at(const light_directions *directions, uint32_t i)
{
    return rk_vec(directions->x[i], directions->y[i], directions->z[i]);
}

/* Four points at once, each as by rk_normalize to the bit. Lanes beyond the last point hold
 * anything. */
static void find_directions(const rk_shading_points *points, rk_vec3 light,
                            light_directions *directions)
{
    const rk_simd4x3 position = rk_simd4x3_all(light);
    const rk_shading_point *four = points->points;
    for (uint32_t i = 0; i < points->count; i += RK_SIMD4_WIDTH, four += RK_SIMD4_WIDTH) {
        const rk_simd4x3 at = rk_simd4x3_load(&four[0].surface.point, &four[1].surface.point,
                                              &four[2].surface.point, &four[3].surface.point);
        const rk_simd4x3 d = rk_simd4x3_normalize(rk_simd4x3_sub(position, at));
        rk_simd4_store(&directions->x[i], d.x);
        rk_simd4_store(&directions->y[i], d.y);
        rk_simd4_store(&directions->z[i], d.z);
    }
}

static inline void add_unoccluded(const rk_shading_point *point, rk_vec3 contribution,
                                  rk_film *film)
{
    rk_film_add(film, point->pixel, rk_mul(point->path.throughput, contribution));
}

static void add_all(const rk_rendering *r, const rk_shading_points *points, rk_light_sample light,
                    const light_directions *directions, rk_film *film)
{
    const rk_shading_point *point = points->points;
    for (uint32_t i = 0; i < points->count; i++, point++)
        add_unoccluded(point,
                       rk_reflected_radiance_from(&r->options->shading, point,
                                                  direction_at(directions, i), light.colour),
                       film);
}

static void queue_shadow_rays(const rk_rendering *r, const rk_shading_points *points,
                              rk_light_sample light, const light_directions *directions,
                              rk_shadow_queue *queue)
{
    const rk_shading_point *point = points->points;
    queue->rays.count = 0;
    for (uint32_t i = 0; i < points->count; i++, point++) {
        rk_vec3 contribution = rk_reflected_radiance_from(
            &r->options->shading, point, direction_at(directions, i), light.colour);
        if (rk_is_black(contribution))
            continue;
        rk_queue_contribution(queue, point, i, contribution);
        rk_vec3 to_light = rk_sub(light.position, point->surface.point);
        rk_queue_shadow_ray(queue, rk_surface_spawn_to_light(&point->surface, to_light),
                            light.position);
    }
}

void rk_point_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                          const rk_shading_points *points, const rk_light *light,
                          rk_shadow_queue *queue, rk_shadow_answers *answers, rk_film *film)
{
    const rk_light_options *options = &r->options->light;
    const rk_light_sample everywhere = rk_light_sample_at(light, options->falloff, options->domain,
                                                          light->position, (rk_vec2){0, 0});
    light_directions directions;
    find_directions(points, light->position, &directions);
    if (!r->plan.shadow_rays) {
        add_all(r, points, everywhere, &directions, film);
        return;
    }
    queue_shadow_rays(r, points, everywhere, &directions, queue);
    if (queue->rays.count == 0)
        return;
    rk_shadow_stage(r, pass, queue, answers);
    for (uint32_t k = 0; k < queue->rays.count; k++)
        if (!answers->occlusion.occluded[k])
            add_unoccluded(&points->points[queue->point[k]], rk_unoccluded(r, queue, answers, k),
                           film);
}
