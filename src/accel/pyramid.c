#include "accel/pyramid.h"

#include "accel/tree.h"

static double size_of(rk_vec3 a)
{
    return rk_dvec3_size(rk_widen(a));
}

static rk_vec3 narrow(rk_dvec3 a)
{
    return rk_vec((float)a.x, (float)a.y, (float)a.z);
}

/* The direction across a and b, of size 1, which takes no square root; 0 where they are so nearly
 * parallel that rounding, of 2^-52 or so of the product of their sizes, would turn it by more than
 * 2^-24. */
static rk_dvec3 across_or_zero(rk_dvec3 a, rk_dvec3 b)
{
    const rk_dvec3 across = rk_dcross(a, b);
    const double size = rk_dvec3_size(across);
    const bool is_certain = size > 0x1p-28 * rk_dvec3_size(a) * rk_dvec3_size(b);
    return is_certain ? rk_dscale(across, 1 / size) : (rk_dvec3){0, 0, 0};
}

/* A sample's position, and the ray's direction to it, are rounded a few times, by at most 2^-24 of
 * these sizes each. */
static double slack_of(const rk_pyramid *pyramid, const rk_light *light, rk_vec3 edge02)
{
    double farthest = size_of(pyramid->apex);
    for (uint32_t k = 0; k < pyramid->other_count; k++)
        farthest = fmax(farthest, size_of(pyramid->others[k]));
    return 0x1p-20 *
           (farthest + size_of(light->position) + size_of(light->edge01) + size_of(edge02));
}

/* Of the sums below, for points at most as far from the apex as the scene reaches: fewer than 16
 * roundings of 2^-53. */
static const double rounding = 0x1p-48;

/* With several apexes, the limit is moved so that all of them are within, whatever the normal. */
static void put_plane(rk_pyramid *pyramid, int i, rk_dvec3 normal, double limit)
{
    for (uint32_t k = 0; k < pyramid->other_count; k++) {
        const rk_dvec3 from = rk_dmadd(rk_widen(pyramid->others[k]), rk_widen(pyramid->apex), -1);
        limit = fmax(limit, rk_ddot(normal, from) + rounding * rk_dvec3_size(from));
    }
    pyramid->normals[i] = normal;
    pyramid->limits[i] = limit + pyramid->slack;
}

/* Of the plane through the apex and an edge of the light, turned away from the light's middle. */
static rk_dvec3 side_normal(const rk_pyramid *pyramid, rk_vec3 at, int i)
{
    const rk_dvec3 apex = rk_widen(at);
    const rk_dvec3 from = rk_dmadd(pyramid->corners[i], apex, -1);
    const rk_dvec3 edge = rk_dmadd(pyramid->corners[(i + 1) % 4], pyramid->corners[i], -1);
    const rk_dvec3 across = rk_dmadd(pyramid->corners[(i + 2) % 4], apex, -1);
    const rk_dvec3 normal = across_or_zero(from, edge);
    return rk_ddot(normal, across) > 0 ? rk_dscale(normal, -1) : normal;
}

/* Each through the apex that is farthest out. */
static void put_sides(rk_pyramid *pyramid)
{
    for (int i = 0; i < 4; i++) {
        rk_dvec3 normal = side_normal(pyramid, pyramid->apex, i);
        for (uint32_t k = 0; k < pyramid->other_count; k++) {
            const rk_vec3 other = pyramid->others[k];
            if (rk_ddot(normal, rk_dmadd(rk_widen(other), pyramid->corners[i], -1)) > 0)
                normal = side_normal(pyramid, other, i);
        }
        put_plane(pyramid, i, normal, 0);
    }
}

static void put_base(rk_pyramid *pyramid)
{
    const rk_dvec3 *c = pyramid->corners;
    const rk_dvec3 from = rk_dmadd(c[0], rk_widen(pyramid->apex), -1);
    rk_dvec3 normal = across_or_zero(rk_dmadd(c[1], c[0], -1), rk_dmadd(c[3], c[0], -1));
    double distance = rk_ddot(normal, from);
    put_plane(pyramid, 4, distance < 0 ? rk_dscale(normal, -1) : normal, fabs(distance));
}

/* In float; the slack is more than what is lost. */
static rk_box box_of(const rk_pyramid *pyramid)
{
    const float slack = (float)pyramid->slack;
    const rk_vec3 around = rk_vec(slack, slack, slack);
    rk_box box = rk_box_add(rk_box_empty(), pyramid->apex);
    for (uint32_t k = 0; k < pyramid->other_count; k++)
        box = rk_box_add(box, pyramid->others[k]);
    for (int i = 0; i < 4; i++) {
        const rk_vec3 corner = narrow(pyramid->corners[i]);
        box = rk_box_add(rk_box_add(box, rk_add(corner, around)), rk_sub(corner, around));
    }
    return box;
}

rk_pyramid rk_pyramid_around(const rk_vec3 *apexes, uint32_t count, const rk_light *light)
{
    const rk_vec3 edge02 = rk_light_edge02(light);
    const rk_dvec3 first = rk_widen(light->position);
    rk_pyramid pyramid = {.apex = apexes[0], .others = &apexes[1], .other_count = count - 1};
    pyramid.slack = slack_of(&pyramid, light, edge02);
    pyramid.corners[0] = first;
    pyramid.corners[1] = rk_dmadd(first, rk_widen(light->edge01), 1);
    pyramid.corners[2] = rk_dmadd(pyramid.corners[1], rk_widen(edge02), 1);
    pyramid.corners[3] = rk_dmadd(first, rk_widen(edge02), 1);
    put_sides(&pyramid);
    put_base(&pyramid);
    pyramid.box = box_of(&pyramid);
    return pyramid;
}

/* --- A triangle, a sphere ------------------------------------------------------------------------
 */

static bool is_beyond_box(const rk_box *box, rk_vec3 low, rk_vec3 high)
{
    const rk_vec3 from = box->corner[0], to = box->corner[1];
    return low.x > to.x || low.y > to.y || low.z > to.z || high.x < from.x || high.y < from.y ||
           high.z < from.z;
}

/* How far a point is beyond a plane, and at least how far in spite of rounding. */
static double beyond(const rk_pyramid *pyramid, int plane, rk_vec3 point)
{
    const rk_dvec3 from = rk_dmadd(rk_widen(point), rk_widen(pyramid->apex), -1);
    return rk_ddot(pyramid->normals[plane], from) - pyramid->limits[plane] -
           rounding * rk_dvec3_size(from);
}

/* Is the whole light on this side of a plane? */
static bool is_light_on_side(const rk_pyramid *pyramid, const rk_triangle_plane *plane, double side)
{
    const double slack = pyramid->slack * rk_dvec3_size(plane->normal);
    bool is_there = side != 0;
    for (int i = 0; i < 4 && is_there; i++) {
        const double dot =
            rk_triangle_plane_dot(plane, rk_dmadd(pyramid->corners[i], plane->a, -1));
        is_there = copysign(1, side) * dot > slack;
    }
    return is_there;
}

/* Are apexes and light on one side of the triangle's plane? An apex may be as close to it as a
 * spawned ray's origin is. */
static bool is_cut_off_by_plane(const rk_pyramid *pyramid, const rk_triangle *triangle)
{
    const rk_triangle_plane plane = rk_triangle_plane_of(triangle);
    const double side = rk_triangle_plane_side(&plane, pyramid->apex);
    bool is_off = is_light_on_side(pyramid, &plane, side);
    for (uint32_t k = 0; k < pyramid->other_count && is_off; k++)
        is_off = side * rk_triangle_plane_side(&plane, pyramid->others[k]) > 0;
    return is_off;
}

/* Does the plane through the apex and the triangle's edge from p to q separate the light from the
 * third corner? */
static bool is_cut_off_by_edge(const rk_pyramid *pyramid, rk_vec3 p, rk_vec3 q, rk_vec3 third)
{
    const rk_triangle seen = {pyramid->apex, p, q, 0};
    const rk_triangle_plane plane = rk_triangle_plane_of(&seen);
    return is_light_on_side(pyramid, &plane, -rk_triangle_plane_side(&plane, third));
}

static bool is_triangle_outside(const rk_pyramid *pyramid, const rk_triangle *triangle)
{
    const rk_vec3 a = triangle->a, b = triangle->b, c = triangle->c;
    if (is_beyond_box(&pyramid->box, rk_min3(a, rk_min3(b, c)), rk_max3(a, rk_max3(b, c))))
        return true;
    for (int i = 0; i < RK_PYRAMID_PLANES; i++)
        if (beyond(pyramid, i, a) > 0 && beyond(pyramid, i, b) > 0 && beyond(pyramid, i, c) > 0)
            return true;
    if (is_cut_off_by_plane(pyramid, triangle))
        return true;
    return pyramid->other_count == 0 &&
           (is_cut_off_by_edge(pyramid, a, b, c) || is_cut_off_by_edge(pyramid, b, c, a) ||
            is_cut_off_by_edge(pyramid, c, a, b));
}

/* Likewise, with the plane that touches the sphere below a single apex in place of the triangle's.
 */
static bool is_sphere_outside(const rk_pyramid *pyramid, const rk_sphere *sphere)
{
    const rk_dvec3 centre = rk_widen(sphere->centre);
    const rk_dvec3 up = rk_dmadd(rk_widen(pyramid->apex), centre, -1);
    const double radius = (double)sphere->radius * (1 + rounding), distance = rk_dlength(up);
    /* Rays are tested against spheres in float, by sums of this size. */
    const double rounded = radius + 0x1p-20 * (distance + radius);
    for (int i = 0; i < RK_PYRAMID_PLANES; i++)
        if (beyond(pyramid, i, sphere->centre) > rounded * rk_dlength(pyramid->normals[i]))
            return true;
    bool is_above = distance > radius && pyramid->other_count == 0;
    for (int i = 0; i < 4 && is_above; i++)
        is_above = rk_ddot(up, rk_dmadd(pyramid->corners[i], centre, -1)) >
                   distance * (rounded + pyramid->slack) * (1 + rounding);
    return is_above;
}

/* --- Four boxes or triangles at once, in float -------------------------------------------------
 */

/* The pyramid in float, relative to the apex and so much larger that nothing is outside of it that
 * is not outside in double. */
typedef struct outline {
    rk_simd4 apex[3], low[3], high[3];
    rk_simd4 normal[RK_PYRAMID_PLANES][3], limit[RK_PYRAMID_PLANES];
    bool is_negative[RK_PYRAMID_PLANES][3];
} outline;

/* `reach`: no corner of the tree is farther from the apex, as a sum of components. */
static outline outline_of(const rk_pyramid *pyramid, double reach)
{
    outline o;
    for (int k = 0; k < 3; k++) {
        o.apex[k] = rk_simd4_all(rk_axis(pyramid->apex, k));
        o.low[k] = rk_simd4_all(rk_axis(pyramid->box.corner[0], k));
        o.high[k] = rk_simd4_all(rk_axis(pyramid->box.corner[1], k));
        for (int i = 0; i < RK_PYRAMID_PLANES; i++) {
            const float normal = rk_axis(narrow(pyramid->normals[i]), k);
            o.normal[i][k] = rk_simd4_all(normal);
            o.is_negative[i][k] = normal < 0;
        }
    }
    for (int i = 0; i < RK_PYRAMID_PLANES; i++)
        o.limit[i] = rk_simd4_all((float)(pyramid->limits[i] + 0x1p-20 * reach) * (1 + 0x1p-22f));
    return o;
}

static double reach_of(const rk_pyramid *pyramid, rk_box box)
{
    const rk_dvec3 apex = rk_widen(pyramid->apex);
    return rk_dvec3_size(rk_dmadd(rk_widen(box.corner[0]), apex, -1)) +
           rk_dvec3_size(rk_dmadd(rk_widen(box.corner[1]), apex, -1));
}

typedef struct four_boxes {
    rk_simd4 side[2][3]; /* lowest and highest; x, y, z */
} four_boxes;

/* The boxes that reach into the pyramid, a bit for each; maybe some that are close. */
static uint32_t boxes_inside(const outline *o, const four_boxes *boxes)
{
    rk_simd4 from[2][3];
    rk_simd4_mask outside = {0, 0, 0, 0};
    for (int k = 0; k < 3; k++) {
        outside |= (boxes->side[0][k] > o->high[k]) | (boxes->side[1][k] < o->low[k]);
        from[0][k] = boxes->side[0][k] - o->apex[k];
        from[1][k] = boxes->side[1][k] - o->apex[k];
    }
    for (int i = 0; i < RK_PYRAMID_PLANES; i++) {
        const bool *negative = o->is_negative[i];
        outside |= o->normal[i][0] * from[negative[0]][0] + o->normal[i][1] * from[negative[1]][1] +
                       o->normal[i][2] * from[negative[2]][2] >
                   o->limit[i];
    }
    return 15 & ~rk_simd4_movemask(outside);
}

/* The same for the triangles of a block. */
static uint32_t triangles_inside(const outline *o, const rk_wide_block *block)
{
    rk_simd4 from[3][3];
    rk_simd4_mask outside = {0, 0, 0, 0};
    for (int k = 0; k < 3; k++) {
        const rk_simd4 a = rk_simd4_load(block->corner[0][k]);
        const rk_simd4 b = rk_simd4_load(block->corner[1][k]);
        const rk_simd4 c = rk_simd4_load(block->corner[2][k]);
        outside |= (rk_simd4_min(a, rk_simd4_min(b, c)) > o->high[k]) |
                   (rk_simd4_max(a, rk_simd4_max(b, c)) < o->low[k]);
        from[0][k] = a - o->apex[k];
        from[1][k] = b - o->apex[k];
        from[2][k] = c - o->apex[k];
    }
    for (int i = 0; i < RK_PYRAMID_PLANES; i++) {
        rk_simd4_mask beyond_plane = ~(rk_simd4_mask){0, 0, 0, 0};
        for (int c = 0; c < 3; c++)
            beyond_plane &= o->normal[i][0] * from[c][0] + o->normal[i][1] * from[c][1] +
                                o->normal[i][2] * from[c][2] >
                            o->limit[i];
        outside |= beyond_plane;
    }
    return 15 & ~rk_simd4_movemask(outside);
}

/* --- Trees --------------------------------------------------------------------------------------
 */

/* What is done, and for which pyramid. */
typedef struct search {
    const rk_pyramid *pyramid;
    rk_pyramid_obstacle *obstacle;
    rk_counters *counters;
} search;

static bool is_obstacle(const search *s, const rk_triangle *triangle)
{
    s->counters->triangle_tests++;
    if (is_triangle_outside(s->pyramid, triangle))
        return false;
    *s->obstacle = (rk_pyramid_obstacle){true, *triangle};
    return true;
}

static bool has_obstacle(const search *s, const outline *o, const rk_wide_block *block)
{
    for (uint32_t inside = triangles_inside(o, block); inside; inside &= inside - 1) {
        const uint32_t i = (uint32_t)__builtin_ctz(inside);
        const rk_triangle triangle = rk_wide_triangle(block, i);
        if (is_obstacle(s, &triangle))
            return true;
    }
    return false;
}

static uint32_t children_inside(const outline *o, const rk_wide_node *node)
{
    uint32_t inside = 0;
    for (int half = 0; half < 2; half++) {
        four_boxes boxes;
        for (int k = 0; k < 3; k++) {
            boxes.side[0][k] = rk_simd4_load(&node->side[0][k][4 * half]);
            boxes.side[1][k] = rk_simd4_load(&node->side[1][k][4 * half]);
        }
        inside |= boxes_inside(o, &boxes) << 4 * half;
    }
    return inside;
}

static bool is_wide_tree_outside(const search *s, const rk_wide_bvh *wide)
{
    const outline o = outline_of(s->pyramid, reach_of(s->pyramid, wide->box));
    uint32_t stack[RK_WIDE_STACK_MAX + RK_WIDE_CHILDREN], left = 0;
    stack[left++] = 0;
    while (left > 0) {
        const uint32_t child = stack[--left];
        const uint32_t blocks = child & RK_WIDE_LEAF ? rk_wide_leaf_count(child) : 0;
        for (uint32_t k = 0; k < blocks; k++)
            if (has_obstacle(s, &o, &wide->blocks[rk_wide_leaf_first(child) + k]))
                return false;
        if (child & RK_WIDE_LEAF)
            continue;
        const rk_wide_node *node = &wide->nodes[child];
        s->counters->box_tests += RK_WIDE_CHILDREN;
        for (uint32_t inside = children_inside(&o, node); inside; inside &= inside - 1)
            stack[left++] = node->child[__builtin_ctz(inside)];
    }
    return true;
}

/* The boxes of two nodes, each twice. */
static four_boxes boxes_of(const rk_bvh_node *pair)
{
    four_boxes boxes;
    for (int side = 0; side < 2; side++)
        for (int k = 0; k < 3; k++) {
            const float a = rk_axis(pair[0].box.corner[side], k);
            const float b = rk_axis(pair[1].box.corner[side], k);
            boxes.side[side][k] = (rk_simd4){a, b, a, b};
        }
    return boxes;
}

static bool is_binary_tree_outside(const search *s, const rk_bvh *bvh)
{
    const outline o = outline_of(s->pyramid, reach_of(s->pyramid, bvh->nodes[0].box));
    const rk_bvh_node *stack[RK_BVH_LEVELS_MAX + 2];
    uint32_t left = 0;
    stack[left++] = &bvh->nodes[0];
    while (left > 0) {
        const rk_bvh_node *node = stack[--left];
        for (uint32_t k = 0; k < node->count; k++)
            if (is_obstacle(s, &bvh->triangles[node->first + k]))
                return false;
        if (node->count > 0)
            continue;
        const rk_bvh_node *pair = &bvh->nodes[node->first];
        const four_boxes boxes = boxes_of(pair);
        const uint32_t inside = boxes_inside(&o, &boxes);
        s->counters->box_tests += 2;
        stack[left] = &pair[0];
        left += inside & 1;
        stack[left] = &pair[1];
        left += inside >> 1 & 1;
    }
    return true;
}

static bool is_tree_outside(const search *s, rk_tree tree)
{
    if (tree.kernel)
        return tree.wide->node_count == 0 || is_wide_tree_outside(s, tree.wide);
    return tree.bvh->node_count == 0 || is_binary_tree_outside(s, tree.bvh);
}

bool rk_pyramid_is_empty(const rk_pyramid *pyramid, const rk_accel *accel,
                         rk_pyramid_obstacle *obstacle, rk_counters *counters)
{
    const search s = {pyramid, obstacle, counters};
    const rk_scene *scene = accel->scene;
    /* Where float could overflow or lose digits; not so with NaN, either. */
    if (!(pyramid->slack > 0x1p-120 && pyramid->slack < 0x1p80))
        return false;
    if (obstacle->known && is_obstacle(&s, &obstacle->triangle))
        return false;
    for (uint32_t i = 0; i < scene->sphere_count; i++) {
        counters->sphere_tests++;
        if (!is_sphere_outside(pyramid, &scene->spheres[i]))
            return false;
    }
    bool is_empty = is_tree_outside(&s, rk_accel_static_tree(accel));
    for (uint32_t i = 0; i < scene->moving_count && is_empty; i++)
        is_empty = is_tree_outside(&s, rk_accel_moving_tree(accel, i));
    return is_empty;
}
