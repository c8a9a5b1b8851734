/* Gathers a ray's crossings from spheres and trees; which triangles it crosses, once each, is
 * decided in features/watertight.h. */
#include "accel/query/crossings.h"

#include "accel/query/trace_moving.h"
#include "accel/query/tree.h"
#include "features/watertight.h"

/* --- Gathering -------------------------------------------------------------------------------- */

typedef struct gathering {
    rk_leaf_visitor visitor; /* crossings beyond its end do not count */
    const rk_scene *scene;
    const rk_ray *ray; /* the scene's */
    rk_ray relative;   /* the same, relative to the object whose tree is visited */
    rk_crossing_list *list;
    rk_crossings_wanted wanted;
    rk_counters *counters;
} gathering;

static bool is_done(const gathering *g)
{
    const rk_crossing_list *list = g->list;
    return g->wanted.until_opaque && list->count && list->crossings[list->count - 1].alpha >= 1;
}

/* No leaf is entered before 0. */
static void set_end(gathering *g)
{
    g->visitor.end = is_done(g) ? -1 : rk_transparency_end(g->list, g->ray->t_max);
}

static rk_vec3 kd_at(const rk_scene *scene, const rk_crossing *crossing,
                     const rk_material *material)
{
    bool is_sphere = crossing->primitive >= scene->mesh.triangle_count;
    rk_surface surface = {
        .material = material,
        .barycentric = rk_vec(1 - crossing->u - crossing->v, crossing->u, crossing->v),
        .triangle = {.index = is_sphere ? RK_MISS : crossing->primitive},
    };
    return rk_surface_kd(&surface, &scene->mesh);
}

/* What is drawn as opaque is cut out by the picture alone: all of a faint material would be below
 * one half. */
static bool is_below_cutoff(const gathering *g, const rk_material *material, float alpha)
{
    const float cutoff = material->alpha_cutoff;
    return cutoff > 0               ? alpha < cutoff
           : g->wanted.cutouts_only ? alpha < 0.5f * material->alpha
                                    : !(alpha > 0);
}

/* Sets the crossing's opacity. False if the surface is cut out there. */
static bool set_alpha(const gathering *g, rk_crossing *crossing, const rk_material *material)
{
    crossing->alpha = g->wanted.cutouts_only ? 1 : material->alpha;
    if (!material->alpha_texture)
        return true;
    const rk_vec3 weights = {1 - crossing->u - crossing->v, crossing->u, crossing->v};
    const float alpha = rk_surface_alpha(material, &g->scene->mesh, crossing->primitive, weights);
    crossing->alpha = material->alpha_cutoff > 0 || g->wanted.cutouts_only ? 1 : alpha;
    return !is_below_cutoff(g, material, alpha);
}

/* Fills in the crossing's material, and inserts it into the list if it lies on the ray; NaN does
 * not. */
static void add_crossing(gathering *g, rk_crossing *crossing, uint32_t medium,
                         const rk_material *material)
{
    if (!(crossing->t > 0 && crossing->t < g->ray->t_max && crossing->t <= g->visitor.end))
        return;
    if (!set_alpha(g, crossing, material))
        return;
    crossing->medium = medium;
    crossing->kd = material->kd_texture || g->scene->mesh.colours
                       ? kd_at(g->scene, crossing, material)
                       : material->kd;
    crossing->absorption = material->absorption;
    rk_transparency_insert(g->list, crossing);
    set_end(g);
}

static void gather_leaf(rk_leaf_visitor *visitor, const rk_triangle *triangles, uint32_t count)
{
    gathering *g = (gathering *)visitor;
    const rk_mesh *mesh = &g->scene->mesh;
    g->counters->triangle_tests += count;
    for (uint32_t i = 0; i < count; i++) {
        rk_hit hit;
        int side = rk_watertight_cross(&triangles[i], &g->relative, &hit);
        if (side == 0)
            continue;
        rk_crossing crossing = {
            .t = hit.t, .u = hit.u, .v = hit.v, .primitive = hit.triangle, .entering = side > 0};
        uint32_t medium = mesh->triangle_materials[hit.triangle];
        add_crossing(g, &crossing, medium, &mesh->materials[medium]);
    }
}

static void gather_spheres(gathering *g)
{
    const rk_scene *scene = g->scene;
    for (uint32_t k = 0; k < scene->sphere_count && !is_done(g); k++) {
        float t[2];
        g->counters->sphere_tests++;
        if (!rk_sphere_span(&scene->spheres[k], g->ray, &t[0], &t[1]))
            continue;
        for (int i = 0; i < 2; i++) {
            rk_crossing crossing = {
                .t = t[i], .primitive = scene->mesh.triangle_count + k, .entering = i == 0};
            add_crossing(g, &crossing, scene->mesh.material_count + k, &scene->sphere_materials[k]);
        }
    }
}

static void gather_triangles(gathering *g, rk_tree tree, const rk_ray *relative)
{
    g->relative = *relative;
    if (!is_done(g))
        rk_tree_visit_leaves(&tree, relative, &g->visitor, g->counters);
}

/* A gathering that adds to the list. */
static gathering gathering_into(rk_crossing_list *list, const rk_accel *accel, const rk_ray *ray,
                                rk_crossings_wanted wanted, rk_counters *counters)
{
    gathering g = {.visitor = {.visit = gather_leaf},
                   .scene = accel->scene,
                   .ray = ray,
                   .list = list,
                   .wanted = wanted,
                   .counters = counters};
    set_end(&g);
    return g;
}

void rk_crossings_gather_static(const rk_accel *accel, const rk_ray *ray,
                                rk_crossings_wanted wanted, rk_crossing_list *list,
                                rk_counters *counters)
{
    gathering g = gathering_into(list, accel, ray, wanted, counters);
    gather_spheres(&g);
    gather_triangles(&g, rk_accel_static_tree(accel), ray);
}

void rk_crossings_gather_moving(const rk_accel *accel, const rk_ray *ray, const rk_ray_time *when,
                                rk_crossings_wanted wanted, rk_crossing_list *list,
                                rk_counters *counters)
{
    gathering g = gathering_into(list, accel, ray, wanted, counters);
    for (uint32_t k = 0; k < accel->scene->moving_count; k++)
        if (when->objects >> k & 1) {
            rk_ray moved = rk_accel_ray_at(accel, k, when->time, ray);
            gather_triangles(&g, rk_accel_moving_tree(accel, k), &moved);
        }
}

bool rk_crossings_are_opaque(const rk_crossing_list *list)
{
    return list->count == RK_CROSSINGS_MAX ||
           (list->count && list->crossings[list->count - 1].alpha >= 1);
}

rk_vec3 rk_crossings_transmittance(const rk_crossing_list *list, const rk_ray *ray,
                                   rk_glass_model model)
{
    if (rk_crossings_are_opaque(list))
        return rk_vec(0, 0, 0);
    return rk_transparency_transmit(model, list->crossings, list->count, rk_length(ray->direction));
}

void rk_crossings_gather_at_rest(const rk_accel *accel, const rk_ray *ray,
                                 rk_crossings_wanted wanted, rk_crossing_list *list,
                                 rk_counters *counters)
{
    gathering g = gathering_into(list, accel, ray, wanted, counters);
    for (uint32_t k = 0; k < accel->scene->moving_count; k++)
        gather_triangles(&g, rk_accel_moving_tree(accel, k), ray);
}

void rk_crossings_gather(const rk_accel *accel, const rk_ray *ray, uint32_t limit,
                         rk_crossing_list *list, rk_counters *counters)
{
    rk_transparency_start(list, limit);
    const rk_crossings_wanted all = {0};
    rk_crossings_gather_static(accel, ray, all, list, counters);
    rk_crossings_gather_at_rest(accel, ray, all, list, counters);
}

rk_vec3 rk_crossings_transmit(const rk_accel *accel, const rk_ray *ray, rk_glass_model model,
                              rk_counters *counters)
{
    rk_crossing_list list;
    rk_transparency_start(&list, RK_CROSSINGS_MAX);
    const rk_crossings_wanted wanted = {.until_opaque = true};
    rk_crossings_gather_static(accel, ray, wanted, &list, counters);
    rk_crossings_gather_at_rest(accel, ray, wanted, &list, counters);
    return rk_crossings_transmittance(&list, ray, model);
}
