#include "accel/ray_group.h"

#include "accel/stand_in_tree.h"
#include "base/dvec3.h"

/* A group with more candidate triangles is wide for its scene, so its rays are traced one by one;
 * with fewer rays, finding candidates costs more than it saves. */
enum { candidates_max = 16, fewest_rays = 4 };

/* All directions are between low and high on each axis, with a margin of 2^-16: far more than the
 * rounding errors of the triangle test, so that a ray between two triangles misses neither; far
 * less than the reflections of a rough mirror differ. */
typedef struct group {
    double origin[3], low[3], high[3], inverse_low[3], inverse_high[3];
    bool low_is_positive[3], high_is_positive[3];
} group;

/* In the order in which a ray may hit them first. */
typedef struct candidate_list {
    uint32_t count;
    const rk_triangle *triangles[candidates_max];
    double enter[candidates_max]; /* a t before which no ray hits the triangle */
} candidate_list;

static group group_of(const rk_ray_batch *rays, uint32_t first, uint32_t end)
{
    const float *directions[3] = {rays->direction_x, rays->direction_y, rays->direction_z};
    const float *origins[3] = {rays->origin_x, rays->origin_y, rays->origin_z};
    group g;
    for (int axis = 0; axis < 3; axis++) {
        float low = INFINITY, high = -INFINITY;
        for (uint32_t i = first; i < end; i++) {
            low = rk_min(low, directions[axis][i]);
            high = rk_max(high, directions[axis][i]);
        }
        double wide_low = (double)low - 0x1p-16, wide_high = (double)high + 0x1p-16;
        g.origin[axis] = (double)origins[axis][first];
        g.low[axis] = wide_low;
        g.high[axis] = wide_high;
        g.inverse_low[axis] = 1 / wide_low;
        g.inverse_high[axis] = 1 / wide_high;
        g.low_is_positive[axis] = wide_low > 0;
        g.high_is_positive[axis] = wide_high > 0;
    }
    return g;
}

/* Returns a t before which no ray of the group is in the box, infinity if none ever is. At t, the
 * rays are between low t and high t on each axis: inside the box, low t is below its upper end, and
 * high t above its lower one. NaN, from 0 / 0, bounds nothing. */
static double enter_box(const group *g, const rk_box *box)
{
    const double lower[3] = {(double)box->corner[0].x, (double)box->corner[0].y,
                             (double)box->corner[0].z};
    const double upper[3] = {(double)box->corner[1].x, (double)box->corner[1].y,
                             (double)box->corner[1].z};
    double enter = 0, leave = INFINITY;
    for (int axis = 0; axis < 3; axis++) {
        double by_low = (upper[axis] - g->origin[axis]) * g->inverse_low[axis];
        double by_high = (lower[axis] - g->origin[axis]) * g->inverse_high[axis];
        if (g->low_is_positive[axis])
            leave = by_low < leave ? by_low : leave;
        else
            enter = by_low > enter ? by_low : enter;
        if (g->high_is_positive[axis])
            enter = by_high > enter ? by_high : enter;
        else
            leave = by_high < leave ? by_high : leave;
    }
    return enter <= leave ? enter : INFINITY;
}

static rk_box box_of(const rk_triangle *triangle)
{
    return rk_box_add(rk_box_add(rk_box_add(rk_box_empty(), triangle->a), triangle->b),
                      triangle->c);
}

static rk_dvec3 from_origin(const group *g, rk_vec3 point)
{
    return (rk_dvec3){(double)point.x - g->origin[0], (double)point.y - g->origin[1],
                      (double)point.z - g->origin[2]};
}

/* The largest n.d over all directions d. */
static double largest_along(const group *g, rk_dvec3 n)
{
    return fmax(n.x * g->low[0], n.x * g->high[0]) + fmax(n.y * g->low[1], n.y * g->high[1]) +
           fmax(n.z * g->low[2], n.z * g->high[2]);
}

/* False if all rays are outside the plane through the origin and one edge. */
static bool may_intersect(const group *g, const rk_triangle *triangle)
{
    const rk_dvec3 corner[3] = {from_origin(g, triangle->a), from_origin(g, triangle->b),
                                from_origin(g, triangle->c)};
    double volume = rk_ddot(corner[0], rk_dcross(corner[1], corner[2]));
    for (int i = 0; i < 3 && volume != 0; i++) {
        rk_dvec3 across = rk_dcross(corner[i], corner[(i + 1) % 3]);
        if (largest_along(g, rk_dscale(across, volume > 0 ? 1 : -1)) < 0)
            return false;
    }
    return true;
}

/* False if the list is full. */
static bool add_triangle(candidate_list *list, const rk_triangle *triangle, double enter)
{
    if (list->count == candidates_max)
        return false;
    uint32_t place = list->count++;
    for (; place > 0 && list->enter[place - 1] > enter; place--) {
        list->triangles[place] = list->triangles[place - 1];
        list->enter[place] = list->enter[place - 1];
    }
    list->triangles[place] = triangle;
    list->enter[place] = enter;
    return true;
}

static bool add_leaf(candidate_list *list, const group *g, const rk_bvh *bvh,
                     const rk_bvh_node *leaf)
{
    for (uint32_t i = leaf->first; i < leaf->first + leaf->count; i++) {
        rk_box box = box_of(&bvh->triangles[i]);
        double enter = enter_box(g, &box);
        if (enter < INFINITY && may_intersect(g, &bvh->triangles[i]) &&
            !add_triangle(list, &bvh->triangles[i], enter))
            return false;
    }
    return true;
}

/* False if there are more than fit the list. */
static bool add_below(candidate_list *list, const group *g, const rk_bvh *bvh,
                      const rk_bvh_node *node, rk_counters *counters)
{
    counters->box_tests += 1 + node->count;
    if (enter_box(g, &node->box) == INFINITY)
        return true;
    if (node->count > 0)
        return add_leaf(list, g, bvh, node);
    const rk_bvh_node *inside = &bvh->nodes[node->first];
    return add_below(list, g, bvh, &inside[1], counters) &&
           add_below(list, g, bvh, &inside[0], counters);
}

static rk_hit closest_in(const candidate_list *list, const rk_ray *ray, rk_counters *counters)
{
    rk_hit hit = {ray->t_max, 0, 0, RK_MISS};
    uint32_t k = 0;
    for (; k < list->count && list->enter[k] <= (double)hit.t; k++)
        rk_triangle_closest(list->triangles[k], ray, &hit);
    counters->triangle_tests += k;
    return hit;
}

static bool same_origin(const rk_ray_batch *rays, uint32_t i, uint32_t k)
{
    return rays->origin_x[i] == rays->origin_x[k] && rays->origin_y[i] == rays->origin_y[k] &&
           rays->origin_z[i] == rays->origin_z[k];
}

void rk_ray_group_closest(const rk_bvh *bvh, const rk_ray_batch *rays, rk_hit_batch *hits,
                          rk_counters *counters)
{
    uint32_t end;
    for (uint32_t first = 0; first < rays->count; first = end) {
        for (end = first + 1; end < rays->count && same_origin(rays, first, end);)
            end++;
        candidate_list list = {.count = 0};
        group g = group_of(rays, first, end);
        bool together = end - first >= fewest_rays && bvh->node_count > 0 &&
                        add_below(&list, &g, bvh, bvh->nodes, counters);
        for (uint32_t i = first; i < end; i++) {
            rk_ray ray = rk_batch_ray(rays, i);
            rk_hit hit =
                together ? closest_in(&list, &ray, counters) : rk_tree_closest(bvh, &ray, counters);
            rk_batch_put_hit(hits, i, &hit);
        }
    }
}
