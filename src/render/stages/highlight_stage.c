/* First it is decided whether directions of the lobe pay: where the lobe is narrow, compared with
 * the light, and may hit it. Then both kinds of samples get their weights. */
#include "render/stages/highlight_stage.h"

#include "base/reflect.h"
#include "render/lobe.h"

/* From here on directions pay: with 16 samples on the light and 8 directions, measured for squares
 * of 0.02 to 1.6 steradians and both models, the error gets smaller from 3 on than with 16 on the
 * light, and from 4 on than with 24. */
static const double sharp = 4;

/* The lobe's largest density, along the normal, times a solid angle: how much narrower is the lobe?
 */
static double sharpness(const rk_render_options *options, float shininess, double solid_angle)
{
    double peak = ((double)shininess + 1) / (2 * RK_PI_DOUBLE);
    return (options->shading.model == RK_SHADING_PHONG ? peak : peak / 4) * solid_angle;
}

static bool has_area(const rk_light *light)
{
    return light->kind == RK_LIGHT_PARALLELOGRAM && rk_light_emits(light);
}

/* No light subtends more than half of the sphere. */
static bool may_be_sharp(const rk_render_options *options, const rk_material *material)
{
    return !rk_is_black(material->ks) &&
           sharpness(options, material->shininess, 2 * RK_PI_DOUBLE) > sharp;
}

static bool any_may_be_sharp(const rk_scene *scene, const rk_render_options *options)
{
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        if (may_be_sharp(options, &scene->mesh.materials[i]))
            return true;
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        if (may_be_sharp(options, &scene->sphere_materials[i]))
            return true;
    return false;
}

bool rk_highlights_may_be_sharp(const rk_scene *scene, const rk_render_options *options)
{
    rk_shading_model model = options->shading.model;
    if (options->light.highlights != RK_HIGHLIGHT_BALANCE ||
        (model != RK_SHADING_PHONG && model != RK_SHADING_BLINN_PHONG) ||
        !any_may_be_sharp(scene, options))
        return false;
    for (uint32_t i = 0; i < scene->light_count; i++)
        if (has_area(&scene->lights[i]))
            return true;
    return false;
}

/* --- Which points take directions ------------------------------------------------------------ */

static uint32_t directions_of(const rk_rendering *r)
{
    return (r->options->light.samples + 1) / 2;
}

/* May a direction of the lobe hit the light? The light is within a ball around its middle, and the
 * directions within a cone around the mirror direction of the viewer, because random numbers end at
 * 1 - 2^-24; a half vector's angle counts twice. */
static bool may_hit(const rk_rendering *r, const rk_shading_point *point, const rk_light *light)
{
    rk_vec3 diagonal = rk_add(light->edge01, light->edge02);
    rk_vec3 other = rk_sub(light->edge01, light->edge02);
    double radius = 0.5 * (double)rk_max(rk_length(diagonal), rk_length(other));
    rk_vec3 middle = rk_madd(light->position, diagonal, 0.5f);
    rk_vec3 to_middle = rk_sub(middle, point->surface.point);
    double distance = (double)rk_length(to_middle);
    if (!(distance > radius))
        return true;
    rk_vec3 mirror = rk_reflect(rk_negate(point->to_viewer), point->surface.normal);
    double cosine = (double)rk_dot(mirror, to_middle) / distance;
    double cone = acos(exp2(-24 / ((double)point->surface.material->shininess + 1)));
    if (r->options->shading.model == RK_SHADING_BLINN_PHONG)
        cone *= 2;
    return acos(fmin(fmax(cosine, -1), 1)) <= cone + asin(radius / distance);
}

static double solid_angle_if_sharp(const rk_rendering *r, const rk_shading_point *point,
                                   const rk_light *light)
{
    const rk_material *material = point->surface.material;
    if (!has_area(light) || !may_be_sharp(r->options, material) || !may_hit(r, point, light))
        return 0;
    double solid_angle = rk_light_solid_angle(light, point->surface.point);
    return sharpness(r->options, material->shininess, solid_angle) > sharp ? solid_angle : 0;
}

uint32_t rk_highlight_start(const rk_rendering *r, const rk_shading_points *points,
                            const rk_light *light, rk_light_sums *sums)
{
    bool any = false;
    for (uint32_t i = 0; i < points->count; i++) {
        sums->solid_angle[i] = solid_angle_if_sharp(r, &points->points[i], light);
        any = any || sums->solid_angle[i] > 0;
    }
    return any ? directions_of(r) : 0;
}

/* --- The balance heuristic ------------------------------------------------------------------- */

static rk_lobe lobe_of(const rk_rendering *r, const rk_shading_point *point)
{
    return rk_lobe_of(r->options->shading.model, point->surface.material->shininess,
                      point->surface.normal, point->to_viewer);
}

/* Of the light's samples, per solid angle: those over the solid angle have its reciprocal. (Where
 * it is so small that they are over the area after all, that is nearly their density. The two
 * weights of a direction add up to one in any case.) */
static double light_density(const rk_rendering *r, const rk_shading_point *point,
                            const rk_light *light, double solid_angle, rk_vec3 position)
{
    const rk_light_options *options = &r->options->light;
    return options->domain == RK_LIGHT_DOMAIN_SOLID_ANGLE && options->falloff == RK_FALLOFF_PHYSICAL
               ? 1 / solid_angle
               : rk_light_area_density(light, point->surface.point, position);
}

/* n p / (n p + m q), for n samples of density p on the light, and m directions of density q. */
static double balance(const rk_rendering *r, double p, double q)
{
    double n = r->options->light.samples, m = directions_of(r);
    return n / (n + m * (q / p));
}

rk_vec3 rk_highlight_of_light_sample(const rk_rendering *r, const rk_shading_point *point,
                                     const rk_light *light, double solid_angle,
                                     const rk_light_sample *sample)
{
    const rk_material *material = point->surface.material;
    const rk_lobe lobe = lobe_of(r, point);
    rk_vec3 to_light = rk_normalize(rk_sub(sample->position, point->surface.point));
    double p = light_density(r, point, light, solid_angle, sample->position);
    double weight = balance(r, p, rk_lobe_density(&lobe, to_light));
    return rk_shade(&r->options->shading, point->kd, rk_scale(material->ks, (float)weight),
                    material->shininess, point->surface.normal, to_light, point->to_viewer,
                    sample->colour);
}

/* A direction's highlight f counts f / (n p + m q), and n times that here, because the mean is over
 * n. With physical falloff f is the radiance times the lobe. Without, the light's colour is per
 * area: per solid angle it is multiplied by p. */
static rk_vec3 highlight(const rk_rendering *r, const rk_shading_point *point, const rk_lobe *lobe,
                         const rk_light *light, double solid_angle, const rk_light_sample *hit)
{
    rk_vec3 to_light = rk_normalize(rk_sub(hit->position, point->surface.point));
    double p = light_density(r, point, light, solid_angle, hit->position);
    double weight = balance(r, p, rk_lobe_density(lobe, to_light));
    if (r->options->light.falloff == RK_FALLOFF_PHYSICAL)
        weight /= p;
    rk_vec3 ks = rk_scale(point->surface.material->ks, (float)weight);
    return rk_shade(&r->options->shading, rk_vec(0, 0, 0), ks, lobe->shininess, lobe->normal,
                    to_light, lobe->to_viewer, hit->colour);
}

/* --- Directions of the lobe ------------------------------------------------------------------ */

/* Draws a direction; false if it misses the light. */
static bool hit_light(const rk_rendering *r, const rk_sample_pass *pass,
                      const rk_shading_point *point, const rk_lobe *lobe, uint32_t index,
                      uint32_t sample, rk_light_sample *hit)
{
    const rk_light *light = &r->scene->lights[index];
    rk_vec2 at, xi;
    rk_light_random(r, pass, point, index, RK_DIMENSION_LOBE, directions_of(r), sample, 1, &xi);
    rk_vec3 direction, from = point->surface.point;
    pass->counters->lobe_samples++;
    if (!rk_lobe_direction(lobe, xi, &direction) || !rk_light_hit(light, from, direction, &at))
        return false;
    *hit = rk_light_sample_at(light, RK_FALLOFF_NONE, RK_LIGHT_DOMAIN_AREA, from, at);
    return true;
}

void rk_highlight_stage(const rk_rendering *r, const rk_sample_pass *pass,
                        const rk_shading_points *points, uint32_t index, uint32_t sample,
                        rk_light_sums *sums, rk_shadow_queue *queue)
{
    for (uint32_t i = 0; i < points->count; i++) {
        if (!(sums->solid_angle[i] > 0))
            continue;
        const rk_shading_point *point = &points->points[i];
        const rk_lobe lobe = lobe_of(r, point);
        rk_light_sample hit;
        if (!hit_light(r, pass, point, &lobe, index, sample, &hit))
            continue;
        rk_vec3 contribution =
            highlight(r, point, &lobe, &r->scene->lights[index], sums->solid_angle[i], &hit);
        if (rk_is_black(contribution))
            continue;
        sums->unshadowed[i] = rk_add(sums->unshadowed[i], contribution);
        if (!r->plan.shadow_rays || sums->visibility[i] == RK_LIGHT_CLEAR) {
            sums->shadowed[i] = rk_add(sums->shadowed[i], contribution);
            continue;
        }
        rk_queue_contribution(queue, point, i, contribution);
        rk_vec3 to_light = rk_sub(hit.position, point->surface.point);
        rk_queue_shadow_ray(queue, rk_surface_spawn_to_light(&point->surface, to_light),
                            hit.position);
    }
}
