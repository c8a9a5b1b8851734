/* Positions are summed in double and rounded once, so that the error bound is small; a spawned ray
 * starts beyond it, on the side to which it goes. */
#include "scene/surface.h"

#include "base/interpolate.h"
#include "base/simd4.h"

/* gamma_n = n eps / (1 - n eps) bounds the relative error of n roundings (Higham, "Accuracy and
 * Stability of Numerical Algorithms", 2002, section 3.1). */
static float gamma_bound(int n)
{
    const float eps = 0x1p-24f;
    return (float)n * eps / (1 - (float)n * eps);
}

/* --- Vectors in registers ----------------------------------------------------------------------
 * A surface is computed per ray, and its vectors are what it costs. So the components of a vector
 * share an instruction: three floats and a lane left over, or two doubles. Each lane is rounded as
 * by itself, so the results are those of plain arithmetic to the bit (tests/test_surface.c has
 * both). */

typedef rk_simd4_pair pair;

/* A vector of doubles: x and y; z twice. */
typedef struct wide_vector {
    pair xy, zz;
} wide_vector;

static inline pair both(double x)
{
    return (pair){x, x};
}

static inline wide_vector widened(rk_simd4 a)
{
    return (wide_vector){{(double)a[0], (double)a[1]}, both((double)a[2])};
}

static inline rk_simd4 narrowed(wide_vector a)
{
    return (rk_simd4){(float)a.xy[0], (float)a.xy[1], (float)a.zz[0], (float)a.zz[0]};
}

static inline wide_vector apart(wide_vector a, wide_vector b)
{
    return (wide_vector){a.xy - b.xy, a.zz - b.zz};
}

static inline wide_vector scaled(wide_vector a, double s)
{
    return (wide_vector){a.xy * both(s), a.zz * both(s)};
}

static inline wide_vector sum(wide_vector a, wide_vector b)
{
    return (wide_vector){a.xy + b.xy, a.zz + b.zz};
}

static inline wide_vector crossed(wide_vector a, wide_vector b)
{
    const pair a_yz = {a.xy[1], a.zz[0]}, a_zx = {a.zz[0], a.xy[0]};
    const pair b_yz = {b.xy[1], b.zz[0]}, b_zx = {b.zz[0], b.xy[0]};
    return (wide_vector){a_yz * b_zx - a_zx * b_yz, both(a.xy[0] * b.xy[1] - a.xy[1] * b.xy[0])};
}

static inline float dot4(rk_simd4 a, rk_simd4 b)
{
    const rk_simd4 product = a * b;
    return product[0] + product[1] + product[2];
}

static inline rk_simd4 facing4(rk_simd4 normal, rk_simd4 side)
{
    return dot4(normal, side) < 0 ? -normal : normal;
}

static inline rk_simd4 normalized4(rk_simd4 a)
{
    const float length = sqrtf(dot4(a, a));
    return length > 0 ? a * rk_simd4_all(1 / length) : a;
}

static inline rk_simd4 interpolated4(const rk_simd4 corners[3], rk_simd4 weights)
{
    return corners[0] * RK_SIMD4_SHUFFLE(weights, weights, 0, 0, 0, 0) +
           corners[1] * RK_SIMD4_SHUFFLE(weights, weights, 1, 1, 1, 1) +
           corners[2] * RK_SIMD4_SHUFFLE(weights, weights, 2, 2, 2, 2);
}

/* --- The surface at a hit --------------------------------------------------------------------- */

/* Summed in double and rounded once: in float, 1 - u - v loses its digits near the edge opposite a,
 * and a distant corner would then move the point off the plane. */
static rk_simd4 point_at(wide_vector a, wide_vector b, wide_vector c, const rk_hit *hit)
{
    const double u = (double)hit->u, v = (double)hit->v;
    return narrowed(sum(sum(scaled(a, 1 - u - v), scaled(b, u)), scaled(c, v)));
}

/* In double, where neither the differences of a sliver nor the squares of a tiny triangle vanish. A
 * triangle without area has no normal: the result is 0. */
static rk_simd4 unit_normal(wide_vector a, wide_vector b, wide_vector c)
{
    const wide_vector n = crossed(apart(b, a), apart(c, a));
    const pair squares = n.xy * n.xy;
    const double length = sqrt(squares[0] + squares[1] + n.zz[0] * n.zz[0]);
    return narrowed(scaled(n, length > 0 ? 1 / length : 0));
}

/* Of one value per corner, of which a hit has three. */
static inline void load_corners(rk_simd4 loaded[3], const rk_vec3 *values, const uint32_t *corner)
{
    loaded[0] = rk_simd4_load3(&values[corner[0]]);
    loaded[1] = rk_simd4_load3(&values[corner[1]]);
    loaded[2] = rk_simd4_load3(&values[corner[2]]);
}

void rk_surface_at(rk_surface *surface, const rk_mesh *mesh, const rk_ray *ray, const rk_hit *hit)
{
    const uint32_t *corner = mesh->triangles[hit->triangle];
    rk_simd4 corners[3], sizes[3], normals[3];
    load_corners(corners, mesh->positions, corner);
    const wide_vector a = widened(corners[0]), b = widened(corners[1]), c = widened(corners[2]);
    const rk_simd4 weights = {1 - hit->u - hit->v, hit->u, hit->v, 0};
    const rk_simd4 backward = -rk_simd4_load3(&ray->direction);
    const rk_simd4 point = point_at(a, b, c, hit);
    rk_simd4 face_normal = facing4(unit_normal(a, b, c), backward);
    if (!(dot4(face_normal, face_normal) > 0))
        face_normal = normalized4(backward);
    rk_simd4 normal = face_normal;
    surface->smooth = NULL;
    if (mesh->normals) {
        load_corners(normals, mesh->normals, corner);
        const rk_simd4 smooth = normalized4(interpolated4(normals, weights));
        if (dot4(smooth, smooth) > 0) {
            normal = facing4(smooth, face_normal);
            surface->smooth = mesh;
        }
    }
    /* Two roundings: to float, and of this sum, which also covers the errors in double. */
    for (int i = 0; i < 3; i++)
        sizes[i] = rk_simd4_abs(corners[i]);
    const rk_simd4 size =
        rk_simd4_max(rk_simd4_abs(point), interpolated4(sizes, rk_simd4_abs(weights)));
    rk_simd4_store3(&surface->point, point);
    rk_simd4_store3(&surface->point_error, size * rk_simd4_all(gamma_bound(2)));
    rk_simd4_store3(&surface->face_normal, face_normal);
    rk_simd4_store3(&surface->normal, normal);
    rk_simd4_store3(&surface->barycentric, weights);
    rk_simd4_store3(&surface->triangle.a, corners[0]);
    rk_simd4_store3(&surface->triangle.b, corners[1]);
    rk_simd4_store3(&surface->triangle.c, corners[2]);
    surface->triangle.index = hit->triangle;
    surface->material = &mesh->materials[mesh->triangle_materials[hit->triangle]];
    surface->offset = rk_vec(0, 0, 0);
}

static rk_vec3 facing(rk_vec3 normal, rk_vec3 side)
{
    return rk_dot(normal, side) < 0 ? rk_negate(normal) : normal;
}

void rk_surface_at_sphere(rk_surface *surface, const rk_sphere *sphere, const rk_material *material,
                          const rk_ray *ray, const rk_hit *hit)
{
    /* The hit gives the direction from the centre; the point is moved back onto the sphere along
     * it. */
    rk_vec3 along = rk_madd(ray->origin, ray->direction, hit->t);
    rk_vec3 outward = rk_normalize(rk_sub(along, sphere->centre));
    /* There is no plane to leave: a triangle without edges is never ahead. */
    *surface = (rk_surface){.point = rk_madd(sphere->centre, outward, sphere->radius),
                            .material = material,
                            .triangle = {.index = RK_MISS}};
    /* Five roundings: of the unit vector (a sum of squares, a root, a quotient), of its product
     * with the radius, and of the sum; and as many again in the sphere test of the spawned ray. */
    rk_vec3 radius = rk_vec(sphere->radius, sphere->radius, sphere->radius);
    surface->point_error = rk_scale(rk_add(rk_abs3(sphere->centre), radius), gamma_bound(10));
    surface->face_normal = facing(outward, rk_negate(ray->direction));
    surface->normal = surface->face_normal;
}

void rk_surface_move(rk_surface *surface, rk_vec3 offset)
{
    rk_vec3 rest = surface->point;
    surface->point = rk_add(rest, offset);
    surface->offset = offset;
    /* The point is rounded here, and so is the origin of a spawned ray when the ray is moved back;
     * the third rounding is of this sum, and allows for the origin's distance from the point. */
    rk_vec3 sizes = rk_max3(rk_abs3(surface->point), rk_abs3(rest));
    surface->point_error = rk_madd(surface->point_error, sizes, gamma_bound(3));
}

static rk_vec3 texture_at(const rk_texture *texture, const rk_mesh *mesh, const uint32_t corner[3],
                          rk_vec3 weights)
{
    const rk_vec2 *uv = mesh->texcoords;
    return rk_texture_at(texture,
                         rk_interpolate2(uv[corner[0]], uv[corner[1]], uv[corner[2]], weights));
}

rk_vec3 rk_surface_varying_kd(const rk_surface *surface, const rk_mesh *mesh)
{
    const rk_material *material = surface->material;
    rk_vec3 kd = material->kd, weights = surface->barycentric;
    if (surface->triangle.index == RK_MISS)
        return kd;
    const uint32_t *corner = mesh->triangles[surface->triangle.index];
    if (material->kd_texture && mesh->texcoords)
        kd = rk_mul(kd, texture_at(material->kd_texture, mesh, corner, weights));
    if (mesh->colours)
        kd = rk_mul(kd, rk_interpolate3(mesh->colours[corner[0]], mesh->colours[corner[1]],
                                        mesh->colours[corner[2]], weights));
    return kd;
}

float rk_surface_alpha(const rk_material *material, const rk_mesh *mesh, uint32_t triangle,
                       rk_vec3 weights)
{
    if (!material->alpha_texture || !mesh->texcoords || triangle >= mesh->triangle_count)
        return material->alpha;
    const uint32_t *corner = mesh->triangles[triangle];
    return material->alpha * texture_at(material->alpha_texture, mesh, corner, weights).x;
}

/* --- Rays from a surface ---------------------------------------------------------------------- */

/* The next float in the direction of `step`, by counting its bits up or down. Infinity stays. */
static inline rk_simd4 round_outward(rk_simd4 value, rk_simd4 step)
{
    const rk_simd4_mask sign = {INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN};
    const rk_simd4_mask step_bits = (rk_simd4_mask)step, zero = value == rk_simd4_all(0);
    const rk_simd4_mask bits = ((rk_simd4_mask)value & ~zero) | (step_bits & sign & zero);
    const rk_simd4_mask by = ((bits ^ step_bits) >> 31) | 1; /* 1 away from zero, -1 towards it */
    const rk_simd4_mask moves =
        (rk_simd4_abs(step) > rk_simd4_all(0)) & (rk_simd4_abs(value) < rk_simd4_all(INFINITY));
    return rk_simd4_select(moves, (rk_simd4)(bits + by), value);
}

static inline rk_simd4 step_along(rk_simd4 point, rk_simd4 normal, float distance)
{
    const rk_simd4 step = normal * rk_simd4_all(distance);
    return round_outward(point + step, step);
}

/* The plane of a triangle, in double, as rk_triangle_plane. */
typedef struct plane {
    wide_vector a, normal;
    double edges;
} plane;

static inline double size_of(wide_vector a)
{
    return fabs(a.xy[0]) + fabs(a.xy[1]) + fabs(a.zz[0]);
}

/* As rk_triangle_plane_dot. */
static inline double plane_dot(const plane *p, wide_vector v)
{
    const pair products = v.xy * p->normal.xy;
    const double dot = products[0] + products[1] + v.zz[0] * p->normal.zz[0];
    return fabs(dot) > 0x1p-48 * size_of(v) * p->edges ? dot : 0;
}

/* So that the ray does not start beyond a neighbour. On each axis a start is rounded three times to
 * the nearest float and once outward: together by 2.5 error bounds at most, since a bound is two
 * roundings. So it is at most 3.5 |error| above the plane, and |error| times 6 - 2.5 from the edge:
 * inside of all neighbours that meet this triangle at 45 degrees or more.
 * Apart, because it is rare, and its registers would cost all other rays. */
static __attribute__((noinline)) rk_vec3
spawn_near_edge(const rk_surface *surface, rk_vec3 direction, rk_simd4 error, double twice_area)
{
    const double inset = 6 * rk_dlength(rk_widen(rk_simd4_vec(error)));
    rk_surface inner = *surface;
    if (twice_area > 0 && inset < INFINITY)
        inner.point = rk_narrow(
            rk_dmadd(rk_widen(surface->point),
                     rk_surface_inset(&surface->triangle, surface->barycentric, inset), 1));
    inner.barycentric = rk_vec(INFINITY, INFINITY, INFINITY); /* near no edge */
    return rk_surface_spawn(&inner, direction);
}

/* May some edge be closer than the inset? Cheap, for points in the middle of their triangles: the
 * smallest weight times twice the area is at most the longest edge times the smallest distance. */
static inline bool is_near_edge(rk_vec3 weights, rk_simd4 error, wide_vector ab, wide_vector ac,
                                double twice_area)
{
    const double least = (double)rk_min(weights.x, rk_min(weights.y, weights.z));
    const double reach = 6 * (double)(error[0] + error[1] + error[2]);
    return twice_area * least < reach * (size_of(ab) + size_of(ac));
}

/* May the plane be ahead of the ray from `start`? Rays are moved back by the offset of a moving
 * object, with the same rounding; without an offset nothing is rounded. */
static inline bool plane_may_be_ahead(const plane *p, rk_simd4 point, double heading)
{
    const double side = plane_dot(p, apart(widened(point), p->a));
    return (heading > 0 && side <= 0) || (heading < 0 && side >= 0);
}

rk_vec3 rk_surface_spawn(const rk_surface *surface, rk_vec3 direction)
{
    const rk_simd4 a = rk_simd4_load3(&surface->triangle.a),
                   b = rk_simd4_load3(&surface->triangle.b),
                   c = rk_simd4_load3(&surface->triangle.c);
    const rk_simd4 point = rk_simd4_load3(&surface->point);
    const rk_simd4 offset = rk_simd4_load3(&surface->offset), d = rk_simd4_of(direction);
    const wide_vector a2 = widened(a), ab = apart(widened(b), a2), ac = apart(widened(c), a2);
    const plane p = {a2, crossed(ab, ac), size_of(ab) * size_of(ac)};
    const rk_simd4 face = rk_simd4_load3(&surface->face_normal);
    /* Which side of the corners' plane: the normal is rounded, and so is its product with d. */
    const double heading = plane_dot(&p, widened(d)), toward = plane_dot(&p, widened(face));
    rk_simd4 normal = (heading > 0) == (toward > 0) ? face : -face;
    if (heading == 0 || toward == 0)
        normal = facing4(face, d);
    /* Past the point's error, and past two roundings of the edges: u and v are rounded, so close to
     * an edge the point may lie behind the neighbour's plane. */
    const rk_simd4 edges = rk_simd4_abs(b - a) + rk_simd4_abs(c - a);
    const rk_simd4 error =
        rk_simd4_load3(&surface->point_error) + edges * rk_simd4_all(gamma_bound(2));
    if (is_near_edge(surface->barycentric, error, ab, ac, fabs(toward)))
        return spawn_near_edge(surface, direction, error, fabs(toward));
    float distance = dot4(rk_simd4_abs(normal), error);
    rk_simd4 start = step_along(point, normal, distance);
    /* In slivers the normal's error grows with the ratio of length to width. A step of 2^-24 of the
     * triangle's size reaches that size after 24 doublings. */
    for (int i = 0; i < 24 && plane_may_be_ahead(&p, start - offset, heading); i++) {
        distance *= 2;
        start = step_along(point, normal, distance);
    }
    return rk_simd4_vec(start);
}

/* --- Away from the edges ---------------------------------------------------------------------- */

/* A triangle's corners, and the lengths of the edges opposite to them. */
typedef struct outline {
    rk_dvec3 corners[3];
    double lengths[3], inradius, twice_area;
} outline;

static outline outline_of(const rk_triangle *t)
{
    outline o = {.corners = {rk_widen(t->a), rk_widen(t->b), rk_widen(t->c)}};
    double perimeter = 0;
    for (int i = 0; i < 3; i++) {
        o.lengths[i] = rk_dlength(rk_dmadd(o.corners[(i + 1) % 3], o.corners[(i + 2) % 3], -1));
        perimeter += o.lengths[i];
    }
    o.twice_area = rk_dlength(rk_triangle_plane_of(t).normal);
    o.inradius = o.twice_area / perimeter;
    return o;
}

/* Raises weight i to its least, by moving at a right angle to the edge opposite to corner i. */
static void leave_edge(const outline *o, int i, const double least[3], double weights[3])
{
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const rk_dvec3 edge = rk_dmadd(o->corners[k], o->corners[j], -1);
    const rk_dvec3 to_i = rk_dmadd(o->corners[i], o->corners[j], -1);
    const double foot = rk_ddot(to_i, edge) / rk_ddot(edge, edge), by = least[i] - weights[i];
    weights[i] = least[i];
    weights[j] -= (1 - foot) * by;
    weights[k] -= foot * by;
}

/* The edge that is closest. */
static int nearest_edge(const outline *o, const double weights[3])
{
    int nearest = 0;
    for (int i = 1; i < 3; i++)
        if (weights[i] * o->lengths[nearest] < weights[nearest] * o->lengths[i])
            nearest = i;
    return nearest;
}

/* A weight is the distance from the opposite edge over the height, and the least ones together are
 * at most 1, as the inradius's are 1. So at most two weights are too small. */
rk_dvec3 rk_surface_inset(const rk_triangle *triangle, rk_vec3 barycentric, double distance)
{
    const outline o = outline_of(triangle);
    const double given[3] = {(double)barycentric.x, (double)barycentric.y, (double)barycentric.z};
    double weights[3] = {given[0], given[1], given[2]}, least[3];
    for (int i = 0; i < 3; i++)
        least[i] = fmin(distance, o.inradius) * o.lengths[i] / o.twice_area;
    const int i = nearest_edge(&o, weights), j = (i + 1) % 3, k = (i + 2) % 3;
    if (!(weights[i] < least[i]))
        return (rk_dvec3){0, 0, 0};
    leave_edge(&o, i, least, weights);
    if (weights[j] < least[j])
        weights[j] = least[j], weights[k] = 1 - least[i] - least[j];
    else if (weights[k] < least[k])
        weights[k] = least[k], weights[j] = 1 - least[i] - least[k];
    const rk_dvec3 along_ij = rk_dmadd(o.corners[j], o.corners[i], -1);
    const rk_dvec3 along_ik = rk_dmadd(o.corners[k], o.corners[i], -1);
    return rk_dmadd(rk_dscale(along_ij, weights[j] - given[j]), along_ik, weights[k] - given[k]);
}

/* --- Rays to lights --------------------------------------------------------------------------- */

/* The way from the point to the smooth surface: the point is projected onto the planes through the
 * corners, at right angles to their normals, and the places are weighted as the corners are. A
 * plane that it lies above already counts as if it lay in it, so there is no way where the surface
 * is concave. */
static rk_vec3 way_to_smooth(const rk_surface *surface)
{
    const rk_mesh *mesh = surface->smooth;
    const uint32_t *corner = mesh->triangles[surface->triangle.index];
    const rk_vec3 point = rk_sub(surface->point, surface->offset);
    rk_vec3 way = {0, 0, 0};
    for (int i = 0; i < 3; i++) {
        const rk_vec3 normal = facing(mesh->normals[corner[i]], surface->normal);
        const float height = rk_dot(rk_sub(point, mesh->positions[corner[i]]), normal);
        if (height < 0)
            way = rk_madd(way, normal, -height * rk_axis(surface->barycentric, i));
    }
    return way;
}

/* The start is above the face, and the ray may intersect it; so there is no plane to leave. Ways as
 * short as the point's error are those of flat faces. */
rk_vec3 rk_surface_spawn_above(const rk_surface *surface, rk_vec3 direction)
{
    const rk_vec3 way = way_to_smooth(surface);
    const float error = rk_dot(rk_abs3(surface->face_normal), surface->point_error);
    if (!(rk_dot(way, surface->face_normal) > 4 * error))
        return rk_surface_spawn(surface, direction);
    rk_surface bulging = *surface;
    bulging.point = rk_add(surface->point, way);
    bulging.face_normal = surface->normal;
    bulging.triangle = (rk_triangle){.index = RK_MISS};
    return rk_surface_spawn(&bulging, direction);
}
