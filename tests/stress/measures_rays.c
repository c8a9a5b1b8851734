/* Rays against boxes, spheres and triangles, by public functions only. */
#include "measure.h"

#include "accel/kernel/wide_kernel.h"
#include "base/box.h"
#include "base/interpolate.h"
#include "base/random.h"
#include "base/sphere.h"
#include "features/bvh_median.h"
#include "features/wide_bvh.h"
#include "scene/bvh_build.h"

/* --- Boxes ------------------------------------------------------------------------------------ */

/* A slab of which the ray enters one plane, t = (corner - origin) / direction, and the other planes
 * are out of the way. */
static double error_of_box_face(const float *in, bool leaving)
{
    const float origin = in[0], direction = in[1], corner = in[2];
    wide t = ((wide)corner - (wide)origin) / (wide)direction;
    if (!(t > 0x1p-60L && t < 0x1p60L))
        return (double)NAN;
    bool forward = direction > 0;
    float low = forward != leaving ? corner : -FLT_MAX,
          high = forward != leaving ? FLT_MAX : corner;
    rk_box box = {{rk_vec(low, -1, -1), rk_vec(high, 1, 1)}};
    rk_ray ray = {rk_vec(origin, 0, 0), rk_vec(direction, 0, 0), INFINITY};
    rk_slabs slabs = rk_slabs_of(&ray);
    float got =
        leaving ? rk_box_leave(&box, &slabs, INFINITY) : rk_box_enter(&box, &slabs, INFINITY);
    wide early = leaving ? ((wide)got - t) / t : (t - (wide)got) / t;
    return got == got ? (double)fabsl(early / eps - 6) : (double)INFINITY;
}

static double error_of_enter(const float *in)
{
    return error_of_box_face(in, false);
}

static double error_of_leave(const float *in)
{
    return error_of_box_face(in, true);
}

/* A ray through a point of the box: how much too early does it leave, or too late does it enter?
 * Below 0 it is found; the point may be a corner, and the box a point. */
static double loss_of_box(const float *in)
{
    rk_box box = rk_box_add(rk_box_add(rk_box_empty(), vector_of(in)), vector_of(in + 3));
    wide3 low = widen3(box.corner[0]), high = widen3(box.corner[1]), o = widen3(vector_of(in + 6));
    wide3 at = {low.x + (high.x - low.x) * (wide)in[9], low.y + (high.y - low.y) * (wide)in[10],
                low.z + (high.z - low.z) * (wide)in[11]};
    /* The direction is rounded, so the exact ray decides what there is to be found. */
    rk_vec3 d = rk_vec((float)(at.x - o.x), (float)(at.y - o.y), (float)(at.z - o.z));
    const rk_ray ray = {vector_of(in + 6), d, INFINITY};
    wide enter = 0, leave = (wide)INFINITY;
    for (int k = 0; k < 3; k++) {
        wide from = (wide)rk_axis(ray.origin, k), way = (wide)rk_axis(d, k);
        wide near = (wide)rk_axis(box.corner[0], k) - from,
             far = (wide)rk_axis(box.corner[1], k) - from;
        if (way == 0) {
            if (near > 0 || far < 0)
                return (double)NAN;
            continue;
        }
        enter = fmaxl(enter, (way > 0 ? near : far) / way);
        leave = fminl(leave, (way > 0 ? far : near) / way);
    }
    if (!(enter <= leave) || !(leave < (wide)INFINITY) || (enter != 0 && enter < 0x1p-100L))
        return (double)NAN;
    rk_slabs slabs = rk_slabs_of(&ray);
    if (!(rk_box_enter(&box, &slabs, INFINITY) < INFINITY))
        return (double)INFINITY;
    float left = rk_box_leave(&box, &slabs, INFINITY);
    return leave > 0 ? (double)(-1 - ((wide)left - enter) / (eps * leave)) : -100;
}

/* --- Spheres ---------------------------------------------------------------------------------- */

/* The exact point at the given t: how far from the sphere is it? Where the test misses though the
 * line passes inside: how far inside? */
static double error_of_sphere(const float *in)
{
    const rk_sphere sphere = {vector_of(in), in[3]};
    const rk_ray ray = {vector_of(in + 4), direction_of(in + 7), INFINITY};
    if (!(ray.direction.x == ray.direction.x))
        return (double)NAN;
    wide3 f = wide_sub(widen3(ray.origin), widen3(sphere.centre)), d = widen3(ray.direction);
    wide r = (wide)sphere.radius, unit = eps * (wide_length(f) + r);
    float near, far;
    if (!rk_sphere_span(&sphere, &ray, &near, &far)) {
        wide closest = wide_length(wide_madd(f, d, -wide_dot(f, d) / wide_dot(d, d)));
        return (double)((r - closest) / unit);
    }
    double error_near = error_in(wide_length(wide_madd(f, d, (wide)near)), r, unit);
    double error_far = error_in(wide_length(wide_madd(f, d, (wide)far)), r, unit);
    return fmax(error_near, error_far);
}

/* --- Triangles -------------------------------------------------------------------------------- */

typedef struct corners {
    rk_vec3 position[3];
} corners;

static rk_triangle triangle_of(corners *c)
{
    static uint32_t indices[1][3] = {{0, 1, 2}};
    rk_mesh mesh = {
        .vertex_count = 3, .triangle_count = 1, .positions = c->position, .triangles = indices};
    return rk_bvh_triangle_of(&mesh, 0);
}

/* Inputs: three corners, the weights of a point, the ray's origin. */
static bool aim(const float *in, corners *c, rk_ray *ray)
{
    *c = (corners){{vector_of(in), vector_of(in + 3), vector_of(in + 6)}};
    rk_vec3 target = rk_interpolate3(c->position[0], c->position[1], c->position[2],
                                     rk_vec(1 - in[9] - in[10], in[9], in[10]));
    *ray = (rk_ray){vector_of(in + 11), rk_sub(target, vector_of(in + 11)), INFINITY};
    return rk_length(ray->direction) > 0;
}

/* The point by t and the point by u and v, both exactly: their distance. Roundings move the ray or
 * the corners a little, by eps of the largest distance between them; where the ray grazes the plane
 * this is 1 / cosine as much along the ray, and in a needle, edges over height as much. */
static double error_of_triangle(const float *in)
{
    corners c;
    rk_ray ray;
    if (!aim(in, &c, &ray))
        return (double)NAN;
    wide3 o = widen3(ray.origin), d = widen3(ray.direction), a = widen3(c.position[0]);
    wide3 ab = wide_sub(widen3(c.position[1]), a), ac = wide_sub(widen3(c.position[2]), a);
    wide3 normal = wide_cross(ab, ac);
    wide long_side = fmaxl(wide_length(ab), wide_length(ac)), area = wide_length(normal);
    wide cosine = fabsl(wide_dot(d, normal)) / (wide_length(d) * area);
    wide needle = wide_length(ab) * wide_length(ac) / area;
    if (!(area > 0) || !(cosine > 0x1p-8L) || needle > 0x1p8L)
        return (double)NAN;
    rk_triangle triangle = triangle_of(&c);
    rk_hit hit = {INFINITY, 0, 0, RK_MISS};
    if (!rk_triangle_closest(&triangle, &ray, &hit))
        return (double)NAN;
    if (!(hit.u >= 0 && hit.v >= 0 && hit.u <= 1 && hit.v <= 1 && hit.t > 0))
        return (double)INFINITY;
    wide3 along = wide_madd(o, d, (wide)hit.t);
    wide3 across = wide_madd(wide_madd(a, ab, (wide)hit.u), ac, (wide)hit.v);
    wide size = wide_length(wide_sub(o, a)) + long_side;
    return error_in(wide_length(wide_sub(along, across)), 0, eps * size * needle / cosine);
}

/* A clear hit must be found: the weights are inside by more than the error above. */
static double loss_of_triangle(const float *in)
{
    corners c;
    rk_ray ray;
    if (!aim(in, &c, &ray))
        return (double)NAN;
    wide3 o = widen3(ray.origin), d = widen3(ray.direction), a = widen3(c.position[0]);
    wide3 ab = wide_sub(widen3(c.position[1]), a), ac = wide_sub(widen3(c.position[2]), a);
    wide3 s = wide_sub(o, a), p = wide_cross(d, ac), q = wide_cross(s, ab);
    wide det = wide_dot(ab, p);
    wide u = wide_dot(s, p) / det, v = wide_dot(d, q) / det, t = wide_dot(ac, q) / det;
    wide size = wide_length(s) + fmaxl(wide_length(ab), wide_length(ac));
    wide area = wide_length(wide_cross(ab, ac));
    wide height = area / fmaxl(wide_length(ab), wide_length(ac));
    wide cosine = fabsl(det) / (wide_length(d) * area);
    wide needle = wide_length(ab) * wide_length(ac) / area;
    if (!(det != 0) || !(t > 0) || cosine < 0x1p-8L || needle > 0x1p8L)
        return (double)NAN;
    /* The distance inside the triangle, in the same unit as the error. */
    wide inside = fminl(fminl(u, v), 1 - u - v) * height / (eps * size * needle / cosine);
    rk_triangle triangle = triangle_of(&c);
    rk_hit hit = {INFINITY, 0, 0, RK_MISS};
    bool found = rk_triangle_closest(&triangle, &ray, &hit);
    if (found != rk_triangle_occludes(&triangle, &ray))
        return (double)INFINITY;
    return found ? (double)-inside : (double)inside;
}

/* --- Batches ---------------------------------------------------------------------------------- */

/* Triangles of all sizes around 0, in one tree. */
static const rk_bvh *some_tree(void)
{
    enum { triangles = 40 };
    static rk_bvh bvh;
    static rk_vec3 positions[3 * triangles];
    static uint32_t indices[triangles][3];
    rk_mesh mesh = {.vertex_count = 3 * triangles,
                    .triangle_count = triangles,
                    .positions = positions,
                    .triangles = indices};
    rk_error error;
    for (uint32_t i = 0; i < 3 * triangles && !bvh.node_count; i++) {
        float x = rk_unit_float(rk_hash(1, i, 0, 0)), y = rk_unit_float(rk_hash(2, i, 0, 0));
        float z = rk_unit_float(rk_hash(3, i, 0, 0)), size = ldexpf(1, 1 - (int)(i / 3 % 8));
        positions[i] = rk_scale(rk_vec(x - 0.5f, y - 0.5f, z - 0.5f), size);
        indices[i / 3][i % 3] = i;
    }
    return bvh.node_count || rk_bvh_build_median(&bvh, &mesh, &error) ? &bvh : NULL;
}

/* Four rays from one point, a packet if their directions are near; infinity unless each has the
 * hit, to the bit, that it has alone in the binary tree. */
static double difference_of_batch(const float *in)
{
    enum { count = 4 };
    static rk_wide_bvh eight;
    const rk_bvh *bvh = some_tree();
    const rk_wide_kernel *kernel = rk_wide_kernel_best();
    rk_ray_batch rays;
    rk_hit_batch hits;
    rk_occlusion_batch answers;
    rk_counters counters = {0};
    unsigned hit_count = 0;
    rk_error error;
    if (!bvh || (!eight.node_count && !rk_wide_bvh_build(&eight, bvh, &error)))
        return (double)INFINITY;
    rays.count = 0;
    for (int k = 0; k < count; k++) {
        const rk_ray ray = {vector_of(in), vector_of(in + 3 + 3 * k), INFINITY};
        rk_batch_push(&rays, &ray);
    }
    kernel->closest(&eight, &rays, &hits, &counters);
    kernel->occluded(&eight, &rays, &answers, &counters);
    for (uint32_t k = 0; k < count; k++) {
        const rk_ray ray = rk_batch_ray(&rays, k);
        rk_hit alone = rk_bvh_closest(bvh, &ray, &counters);
        bool is_hit = alone.triangle != RK_MISS;
        bool same = hits.triangle[k] == alone.triangle && answers.occluded[k] == is_hit;
        if (is_hit)
            same = same && hits.t[k] == alone.t && hits.u[k] == alone.u && hits.v[k] == alone.v;
        if (!same)
            return (double)INFINITY;
        hit_count += is_hit;
    }
    return (double)hit_count - count; /* rays that hit have more to differ in */
}

static const measure list[] = {
    {.routine = "rk_box_enter",
     .what = "relative error of t, eps, apart from the 6 that it is early on purpose",
     .error = error_of_enter,
     .domains = {{SIGNED, 3, -30, 30}},
     .bound = 4,
     .because = "the reciprocal and its factor, a difference and a product",
     .reference = "long double"},
    {.routine = "rk_box_leave",
     .what = "relative error of t, eps, apart from the 6 that it is late on purpose",
     .error = error_of_leave,
     .domains = {{SIGNED, 3, -30, 30}},
     .bound = 4,
     .because = "the reciprocal and its factor, a difference and a product",
     .reference = "long double"},
    {.routine = "rk_box_enter",
     .what = "boxes lost that the exact ray touches",
     .error = loss_of_box,
     .domains = {{SIGNED, 6, -30, 30}, {SIGNED, 3, -30, 30}, {BETWEEN, 3, 0, 1}},
     .bound = 0,
     .because = "t is early and late by more than its errors",
     .reference = "long double"},
    {.routine = "rk_sphere_span",
     .what = "distance of the hit from the sphere, eps times its radius and distance",
     .error = error_of_sphere,
     .domains = {{SIGNED, 3, -10, 10}, {POSITIVE, 1, -10, 10}, {SIGNED, 6, -10, 10}},
     .bound = 16,
     .because = "t: 6, times a cosine of at most 1; the distance from the centre: 5, twice",
     .reference = "long double, the point put into the sphere's equation"},
    {.routine = "rk_triangle_closest",
     .what = "distance between the point by t and the point by u and v, eps times size, edges over "
             "height, 1 / cosine",
     .error = error_of_triangle,
     .domains = {{SIGNED, 9, -6, 6}, {BETWEEN, 2, 0, 1}, {SIGNED, 3, -6, 6}},
     .bound = 3,
     .because = "t, u and v are rounded once each, from double",
     .reference = "long double"},
    {.routine = "rk_triangle_closest",
     .what = "distance from the edges of a hit that is lost, in the same unit",
     .error = loss_of_triangle,
     .domains = {{SIGNED, 9, -6, 6}, {BETWEEN, 2, -0.01f, 1}, {SIGNED, 3, -6, 6}},
     .bound = 1e-11,
     .because =
         "none is lost; the reference places it with roundings of 2^-64, 2^-40 of eps each, six "
         "in each of two products",
     .reference = "long double"},
    {.routine = "rk_accel_closest",
     .what = "rays of a batch whose hit differs from that of the ray alone",
     .error = difference_of_batch,
     .domains = {{SIGNED, 3, -4, 2}, {SIGNED, 12, -30, 30}},
     .bound = 0,
     .because = "each lane is rounded like a single float",
     .reference = "rk_bvh_closest, to the bit",
     .cost = 8},
};

const measures measures_of_rays = {list, sizeof list / sizeof *list};
