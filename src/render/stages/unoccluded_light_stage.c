/* Where the pyramid between a point and the light is empty (accel/query/pyramid.h), a few nodes of
 * a Gaussian quadrature take the place of samples; neighbours share one search. */
#include "render/stages/unoccluded_light_stage.h"

#include "accel/query/pyramid.h"

/* Fewer shadow rays cost less than a search for surfaces between points and light: of the cover,
 * four samples took a quarter longer with it. As many as the quadrature's fewest nodes. */
enum { LEAST_SAMPLES = 9 };

/* Gauss and Legendre's quadrature on [0, 1] (Abramowitz and Stegun, "Handbook of Mathematical
 * Functions", table 25.4). For an integrand that is analytic within distance d of an edge of length
 * L, the error of n nodes falls as (y + sqrt(1 + y^2))^(-2 n), y = 2 d / L (Trefethen,
 * "Approximation Theory and Approximation Practice", chapter 19); so few are enough from afar. */
enum { NODES_MAX = 6 };
typedef struct rule {
    float least_distance; /* over the longest edge */
    uint32_t nodes;
    float at[NODES_MAX], weights[NODES_MAX];
} rule;

static const rule rules[] = {
    {2, 3, {0.1127016654f, 0.5f, 0.8872983346f}, {0.2777777778f, 0.4444444444f, 0.2777777778f}},
    {0.6f,
     4,
     {0.0694318442f, 0.3300094782f, 0.6699905218f, 0.9305681558f},
     {0.1739274226f, 0.3260725774f, 0.3260725774f, 0.1739274226f}},
    {0.25f,
     6,
     {0.0337652429f, 0.1693953068f, 0.3806904070f, 0.6193095930f, 0.8306046932f, 0.9662347571f},
     {0.0856622462f, 0.1803807865f, 0.2339569673f, 0.2339569673f, 0.1803807865f, 0.0856622462f}},
};
enum { RULES = sizeof rules / sizeof *rules };

/* The light, once for all points. */
typedef struct extent {
    rk_vec3 edge02, diagonal;
    float radius, longest; /* of a ball around it; of its edges */
} extent;

static extent extent_of(const rk_light *light)
{
    extent e = {.edge02 = rk_light_edge02(light)};
    e.diagonal = rk_add(light->edge01, e.edge02);
    e.radius = 0.5f * rk_max(rk_length(e.diagonal), rk_length(rk_sub(light->edge01, e.edge02)));
    e.longest = rk_max(rk_length(light->edge01), rk_length(e.edge02));
    return e;
}

/* The light as a point sees it. */
typedef struct view {
    rk_vec3 corners[4];    /* from the point */
    float lowest, highest; /* corner . normal: beside or above the horizon? */
    float distance;        /* to the light, at least */
} view;

static view view_of(const rk_shading_point *point, const rk_light *light, const extent *e)
{
    const rk_surface *surface = &point->surface;
    const rk_vec3 to_first = rk_sub(light->position, surface->point);
    view v = {.corners = {to_first, rk_add(to_first, light->edge01), rk_add(to_first, e->edge02),
                          rk_add(to_first, e->diagonal)},
              .lowest = INFINITY,
              .highest = -INFINITY};
    for (int i = 0; i < 4; i++) {
        const float height = rk_dot(surface->normal, v.corners[i]);
        v.lowest = rk_min(height, v.lowest);
        v.highest = rk_max(height, v.highest);
    }
    v.distance = rk_length(rk_madd(to_first, e->diagonal, 0.5f)) - e->radius;
    return v;
}

/* The rule by which the reflected light, as a function of the light's points, is integrated with a
 * relative error below 1e-4; NULL if there is none of at most so many nodes as there are samples:
 * across the horizon, close to the light, or in a highlight. */
static const rule *rule_for(const rk_rendering *r, const rk_shading_point *point, const view *v,
                            const extent *e)
{
    const rk_shading_model model = r->options->shading.model;
    const bool is_diffuse = model == RK_SHADING_LAMBERT || model == RK_SHADING_OFF ||
                            rk_is_black(point->surface.material->ks);
    for (int i = 0; i < RULES && is_diffuse && v->lowest > 0; i++)
        if (v->distance > rules[i].least_distance * e->longest)
            return rules[i].nodes * rules[i].nodes <= r->options->light.samples ? &rules[i] : NULL;
    return NULL;
}

/* Does the surface face away from all of the light? Shading that knows no horizon never does. */
static bool is_dark(const rk_rendering *r, const view *v)
{
    const rk_shading_model model = r->options->shading.model;
    return v->highest <= 0 && model != RK_SHADING_OFF && model != RK_SHADING_GRADIENT;
}

/* Sums as if over samples. */
static void integrate(const rk_rendering *r, const rk_shading_point *point, const rk_light *light,
                      const rule *by, uint32_t i, rk_light_sums *sums)
{
    rk_light_sample samples[NODES_MAX * NODES_MAX];
    rk_vec3 contributions[NODES_MAX * NODES_MAX], sum = {0, 0, 0};
    const uint32_t count = by->nodes * by->nodes;
    uint32_t k = 0;
    do {
        const rk_vec2 at = {by->at[k / by->nodes], by->at[k % by->nodes]};
        samples[k] = rk_light_sample_at(light, r->options->light.falloff, RK_LIGHT_DOMAIN_AREA,
                                        point->surface.point, at);
    } while (++k < count);
    rk_light_contributions(r, point, light, 0, count, samples, contributions);
    for (k = 0; k < count; k++)
        sum =
            rk_madd(sum, contributions[k], by->weights[k / by->nodes] * by->weights[k % by->nodes]);
    sums->shadowed[i] = sums->unshadowed[i] = rk_scale(sum, (float)r->options->light.samples);
    sums->visibility[i] = RK_LIGHT_SUMMED;
}

/* Where all shadow rays of the point start; false if the light is on both sides of the surface, so
 * that there are several such places. */
static bool find_start(const rk_shading_point *point, const view *v, rk_vec3 *start)
{
    rk_spawner spawner;
    rk_spawner_start(&spawner, &point->surface);
    *start = rk_spawner_origin_to_light(&spawner, v->corners[0]);
    for (int i = 1; i < 4; i++) {
        const rk_vec3 other = rk_spawner_origin_to_light(&spawner, v->corners[i]);
        if (other.x != start->x || other.y != start->y || other.z != start->z)
            return false;
    }
    return true;
}

/* --- Groups ----------------------------------------------------------------------------------- */

/* Points that are neighbours in the picture often see the light through the same empty space: one
 * search finds it clear for all of them, or else for each quarter by itself. */
enum { GROUP = 16 };
typedef struct group {
    uint32_t count, index[GROUP]; /* of the points */
    rk_vec3 starts[GROUP];        /* of their shadow rays */
    view views[GROUP];
} group;

typedef struct search {
    const rk_rendering *r;
    const rk_shading_points *points;
    const rk_light *light;
    const extent *extent;
    rk_light_sums *sums;
    rk_counters *counters;
    rk_pyramid_obstacle obstacle;
} search;

static void sum_up(const search *s, uint32_t i, const view *v)
{
    const rk_shading_point *point = &s->points->points[i];
    const rule *by = rule_for(s->r, point, v, s->extent);
    if (by)
        integrate(s->r, point, s->light, by, i, s->sums);
    else
        s->sums->visibility[i] = RK_LIGHT_CLEAR;
}

static void search_part(search *s, const group *g, uint32_t first, uint32_t count)
{
    const rk_pyramid pyramid = rk_pyramid_around(&g->starts[first], count, s->light);
    const uint32_t part = count > 4 ? 4 : 1, end = first + count;
    if (rk_pyramid_is_empty(&pyramid, s->r->accel, &s->obstacle, s->counters)) {
        for (uint32_t k = first; k < end; k++)
            sum_up(s, g->index[k], &g->views[k]);
    } else if (count > 1) {
        for (uint32_t k = first; k < end; k += part)
            search_part(s, g, k, end - k < part ? end - k : part);
    }
}

static void search_group(search *s, group *g)
{
    if (g->count > 0)
        search_part(s, g, 0, g->count);
    g->count = 0;
}

void rk_unoccluded_light_stage(const rk_rendering *r, rk_sample_pass *pass,
                               const rk_shading_points *points, uint32_t index, rk_light_sums *sums)
{
    if (r->options->light.visibility != RK_LIGHT_PYRAMIDS ||
        r->options->light.samples < LEAST_SAMPLES)
        return;
    const rk_light *light = &r->scene->lights[index];
    const extent e = extent_of(light);
    search s = {r, points, light, &e, sums, pass->counters, {.known = false}};
    group g;
    g.count = 0;
    for (uint32_t i = 0; i < points->count; i++) {
        const rk_shading_point *point = &points->points[i];
        view *v = &g.views[g.count];
        *v = view_of(point, light, &e);
        if (is_dark(r, v))
            sums->visibility[i] = RK_LIGHT_SUMMED; /* they are 0 */
        else if (!r->plan.shadow_rays)
            sum_up(&s, i, v);
        else if (!(r->plan.motion_blur && r->scene->moving_count > 0) &&
                 find_start(point, v, &g.starts[g.count]))
            g.index[g.count++] = i;
        if (g.count == GROUP)
            search_group(&s, &g);
    }
    search_group(&s, &g);
}
