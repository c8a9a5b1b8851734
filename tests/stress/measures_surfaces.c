/* The point of a hit, its normal, and spawned rays. */
#include "measure.h"

#include "features/watertight.h"
#include "scene/bvh_build.h"
#include "scene/surface.h"

typedef struct place {
    rk_vec3 corners[3];
    rk_mesh mesh;
    rk_material material;
} place;

static uint32_t indices[1][3] = {{0, 1, 2}};
static uint16_t material_of[1] = {0};

static void make_place(place *p, const float *in)
{
    *p = (place){.corners = {vector_of(in), vector_of(in + 3), vector_of(in + 6)}};
    p->mesh = (rk_mesh){.vertex_count = 3,
                        .triangle_count = 1,
                        .material_count = 1,
                        .positions = p->corners,
                        .triangles = indices,
                        .triangle_materials = material_of,
                        .materials = &p->material};
}

/* Inputs: three corners, u, the fraction of v that is left, a direction. */
static rk_surface surface_at(place *p, const float *in, rk_hit *hit)
{
    rk_surface surface;
    make_place(p, in);
    const rk_ray ray = {rk_vec(0, 0, 0), vector_of(in + 11), INFINITY};
    *hit = (rk_hit){1, in[9], in[10] * (1 - in[9]), 0};
    rk_surface_at(&surface, &p->mesh, &ray, hit);
    return surface;
}

static double error_of_point(const float *in)
{
    place p;
    rk_hit hit;
    rk_surface surface = surface_at(&p, in, &hit);
    wide u = (wide)hit.u, v = (wide)hit.v;
    wide3 want = wide_scale(widen3(p.corners[0]), 1 - u - v);
    want = wide_madd(wide_madd(want, widen3(p.corners[1]), u), widen3(p.corners[2]), v);
    /* Where the result is nearly 0 on an axis, the roundings of double show. */
    wide3 a = widen3(rk_abs3(p.corners[0])), b = widen3(rk_abs3(p.corners[1]));
    wide3 sizes = wide_madd(wide_madd(a, b, 1), widen3(rk_abs3(p.corners[2])), 1);
    wide3 unit = wide_madd(widen3(surface.point_error), sizes, 0x1p-52L);
    return error3_each(surface.point, want, unit);
}

/* Slivers up to a height of 2^-26 of their edges: there the normal of the rounded corners is still
 * exact to a float, because differences and products are formed in double. */
static double error_of_face_normal(const float *in)
{
    place p;
    rk_hit hit;
    rk_surface surface = surface_at(&p, in, &hit);
    wide3 a = widen3(p.corners[0]);
    wide3 ab = wide_sub(widen3(p.corners[1]), a), ac = wide_sub(widen3(p.corners[2]), a);
    wide3 across = wide_cross(ab, ac);
    wide area = wide_length(across);
    if (!(area > wide_length(ab) * wide_length(ac) * 0x1p-26L))
        return (double)NAN;
    wide3 want = wide_unit(across);
    if (wide_dot(want, widen3(surface.face_normal)) < 0)
        want = wide_scale(want, -1);
    return error3_in(surface.face_normal, want, eps);
}

static double length_of_normal(const float *in)
{
    place p;
    rk_hit hit;
    if (!(rk_length(vector_of(in + 11)) > 0))
        return (double)NAN;
    rk_surface surface = surface_at(&p, in, &hit);
    return error_in(wide_length(widen3(surface.normal)), 1, eps);
}

static double self_hit(const float *in)
{
    place p;
    rk_hit hit;
    rk_surface surface = surface_at(&p, in, &hit);
    rk_vec3 direction = vector_of(in + 14);
    if (!(rk_length(direction) > 0))
        return (double)NAN;
    rk_triangle triangle = rk_bvh_triangle_of(&p.mesh, 0);
    const rk_ray spawned = {rk_surface_spawn(&surface, direction), direction, INFINITY};
    if (rk_triangle_occludes(&triangle, &spawned))
        return (double)INFINITY;
    /* The more grazing the direction, the nearer to a hit. */
    wide3 d = widen3(direction);
    wide graze = fabsl(wide_dot(d, widen3(surface.face_normal))) / wide_length(d);
    return (double)-graze;
}

/* Inputs: centre, radius, origin, direction of the ray; direction of the spawned ray. */
static bool on_sphere(const float *in, rk_sphere *sphere, rk_surface *surface)
{
    static const rk_material material;
    *sphere = (rk_sphere){vector_of(in), in[3]};
    const rk_ray ray = {vector_of(in + 4), vector_of(in + 7), INFINITY};
    rk_hit hit = {INFINITY, 0, 0, RK_MISS};
    if (!rk_sphere_closest(sphere, 0, &ray, &hit))
        return false;
    rk_surface_at_sphere(surface, sphere, &material, &ray, &hit);
    return true;
}

/* Along the normal, where spawned rays leave it. */
static double error_of_sphere_point(const float *in)
{
    rk_sphere sphere;
    rk_surface surface;
    if (!on_sphere(in, &sphere, &surface))
        return (double)NAN;
    wide3 outward = wide_sub(widen3(surface.point), widen3(sphere.centre));
    wide3 normal = widen3(rk_abs3(surface.face_normal));
    return error_in(wide_length(outward), (wide)sphere.radius,
                    wide_dot(normal, widen3(surface.point_error)));
}

/* Outwards is what the rounded normal says: exactly along the surface, either side is right. */
static double self_hit_of_sphere(const float *in)
{
    rk_sphere sphere;
    rk_surface surface;
    rk_vec3 direction = vector_of(in + 10);
    if (!on_sphere(in, &sphere, &surface))
        return (double)NAN;
    bool is_outside = rk_dot(surface.face_normal, rk_sub(surface.point, sphere.centre)) > 0;
    rk_vec3 outward = is_outside ? surface.face_normal : rk_negate(surface.face_normal);
    float rise = rk_dot(direction, outward);
    if (!(rise > 0))
        return (double)NAN;
    const rk_ray spawned = {rk_surface_spawn(&surface, direction), direction, INFINITY};
    return rk_sphere_intersect(&sphere, &spawned, INFINITY) < INFINITY
               ? (double)INFINITY
               : (double)(-rise / rk_length(direction));
}

#define HIT_INPUTS                                                                                 \
    {SIGNED, 9, -20, 20}, {BETWEEN, 2, 0, 1},                                                      \
    {                                                                                              \
        SIGNED, 3, -4, 4                                                                           \
    }

static const measure list[] = {
    {.routine = "rk_surface_at",
     .what = "distance of the point from that of u and v, in its own error bounds and 2^-52 of the "
             "corners",
     .error = error_of_point,
     .domains = {HIT_INPUTS},
     .bound = 1,
     .because = "it is rounded once, from double; the other rounding is that of the bound",
     .reference = "long double"},
    {.routine = "rk_surface_at",
     .what = "error of the face normal, eps",
     .error = error_of_face_normal,
     .domains = {HIT_INPUTS},
     .bound = 1,
     .because = "one rounding from double, in which slivers cancel by at most 2^26",
     .reference = "long double"},
    {.routine = "rk_surface_at",
     .what = "length of the normal, above or below 1, eps",
     .error = length_of_normal,
     .domains = {HIT_INPUTS},
     .bound = 2,
     .because = "three components, each rounded once, or the ray's direction by rk_normalize",
     .reference = "long double"},
    {.routine = "rk_surface_spawn",
     .what = "spawned rays that hit their own triangle",
     .error = self_hit,
     .domains = {HIT_INPUTS, {SIGNED, 3, -20, 4}},
     .bound = 0,
     .because = "the start is moved until the triangle test finds the plane behind it",
     .reference = "the triangle test"},
    {.routine = "rk_surface_at_sphere",
     .what = "distance of the point from the sphere, in its error bounds along the normal",
     .error = error_of_sphere_point,
     .domains = {{SIGNED, 3, -10, 10}, {POSITIVE, 1, -10, 10}, {SIGNED, 6, -10, 10}},
     .bound = 1,
     .because = "5 roundings of the 10 in the bound; the others are of the sphere test",
     .reference = "long double"},
    {.routine = "rk_surface_spawn",
     .what = "rays spawned outwards that hit their own sphere",
     .error = self_hit_of_sphere,
     .domains =
         {{SIGNED, 3, -10, 10}, {POSITIVE, 1, -10, 10}, {SIGNED, 6, -10, 10}, {SIGNED, 3, -10, 4}},
     .bound = 0,
     .because = "the start is farther out than the sphere test is wrong",
     .reference = "the sphere test"},
};

const measures measures_of_surfaces = {list, sizeof list / sizeof *list};
