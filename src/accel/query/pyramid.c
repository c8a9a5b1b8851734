/* The pyramid as planes, in double, each moved outwards by a bound of all rounding. A triangle is
 * outside if a plane separates it from the pyramid: one of the pyramid's, its own, or one through
 * the apex and an edge. */
#include "accel/query/pyramid.h"

static double size_of(rk_vec3 a)
{
    return rk_dvec3_size(rk_widen(a));
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
        const rk_vec3 corner = rk_narrow(pyramid->corners[i]);
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

/* --- A triangle, a sphere --------------------------------------------------------------------- */

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

bool rk_pyramid_excludes_triangle(const rk_pyramid *pyramid, const rk_triangle *triangle)
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

/* As for a triangle, with the plane that touches the sphere below a single apex in place of the
 * triangle's. */
bool rk_pyramid_excludes_sphere(const rk_pyramid *pyramid, const rk_sphere *sphere)
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
