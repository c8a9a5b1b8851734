#include "difference.h"

#include "base/triangle.h"
#include "features/watertight.h"

#include <string.h>

RK_NAMES(peers_cause_names, peers_cause, PEERS_UNKNOWN, "same", "shared", "coincident", "neighbour",
         "leak", "beyond", "ends", "box", "values", "unknown");
RK_NAMES(peers_value_names, peers_value, PEERS_NORMAL, "t", "u and v", "normal");

static const char *const meanings[PEERS_CAUSES] = {
    [PEERS_SAME] = "the same answer",
    [PEERS_SHARED] = "a tie: the ray crosses both triangles where they touch",
    [PEERS_COINCIDENT] = "a tie: the triangles intersect, and the ray crosses both there",
    [PEERS_NEIGHBOUR] = "the other hit is on a neighbour, which the ray misses by rounding",
    [PEERS_LEAK] = "the engine misses a triangle: the ray passes within rounding of its edge",
    [PEERS_BEYOND] = "the engine hits a triangle that the ray misses by rounding",
    [PEERS_ENDS] = "the hit is within rounding of the ray's origin or end",
    [PEERS_BOX] = "the engine misses a triangle that the ray crosses well inside its edges",
    [PEERS_VALUES] = "the same triangle, but t, u, v or the normal differ by more than rounding",
    [PEERS_UNKNOWN] = "none of these",
};

const char *peers_cause_meaning(peers_cause cause)
{
    return meanings[cause];
}

static rk_triangle triangle_of(const rk_mesh *mesh, uint32_t index)
{
    const uint32_t *corners = mesh->triangles[index];
    return (rk_triangle){mesh->positions[corners[0]], mesh->positions[corners[1]],
                         mesh->positions[corners[2]], index};
}

/* --- How near is a ray to a triangle's edges? ------------------------------------------------- */

/* The determinants of features/watertight.h, oriented so that det >= 0, and the rounding errors
 * that they may have in float: those of rk_watertight_may_hit. Embree's determinants have the same
 * factors, in another order, and as few roundings. */
typedef struct passage {
    double u, v, w, t, det; /* u, v, w >= 0 inside; the distance is t / det */
    double bound, t_bound;  /* of u, v, w and det; of t */
    double normal_bound;    /* of a component of the normal */
} passage;

static passage passage_of(const rk_triangle *triangle, const rk_ray *ray)
{
    const rk_dvec3 a = rk_widen(triangle->a), d = rk_widen(ray->direction);
    const rk_dvec3 ab = rk_dmadd(rk_widen(triangle->b), a, -1);
    const rk_dvec3 ac = rk_dmadd(rk_widen(triangle->c), a, -1);
    const rk_dvec3 s = rk_dmadd(rk_widen(ray->origin), a, -1);
    const rk_dvec3 p = rk_dcross(d, ac), q = rk_dcross(s, ab);
    const double det = rk_ddot(ab, p), sign = det < 0 ? -1 : 1;
    const double u = rk_ddot(s, p) * sign, v = rk_ddot(d, q) * sign;
    const double edge = fmax(rk_dvec3_size(ab), rk_dvec3_size(ac));
    const double area = edge * (rk_dvec3_size(s) + edge);
    return (passage){.u = u,
                     .v = v,
                     .w = det * sign - u - v,
                     .t = rk_ddot(ac, q) * sign,
                     .det = det * sign,
                     .bound = 0x1p-19 * area * rk_dvec3_size(d),
                     .t_bound = 0x1p-19 * area * edge,
                     .normal_bound = 0x1p-19 * area};
}

static double smallest_of(const passage *p)
{
    return fmin(p->u, fmin(p->v, p->w));
}

/* Could rounding change on which side of an edge the ray passes? */
static bool is_at_edge(const passage *p)
{
    return fabs(smallest_of(p)) <= p->bound;
}

/* Could rounding change whether t is between 0 and t_max? */
static bool is_at_ends(const passage *p, float t_max)
{
    const bool at_start = fabs(p->t) <= p->t_bound;
    const double end = (double)t_max * p->det;
    return at_start ||
           (isfinite(t_max) && fabs(p->t - end) <= p->t_bound + (double)t_max * p->bound);
}

/* The largest error of t in float. Infinite where the ray lies in the plane as far as float can
 * tell. */
static double t_error_of(const passage *p)
{
    return p->det > p->bound ? (p->t_bound + fabs(p->t / p->det) * p->bound) / (p->det - p->bound)
                             : (double)INFINITY;
}

/* --- Closest hits ----------------------------------------------------------------------------- */

static bool is_within(double a, double b, double error)
{
    return fabs(a - b) <= error;
}

/* The larger one; infinite for NaN, which must not go unnoticed. */
static double fraction(double difference, double bound, double before)
{
    const double here = difference == 0 ? 0 : fabs(difference) / bound;
    return isnan(here) ? (double)INFINITY : fmax(here, before);
}

static peers_cause compare_values(const rk_triangle *triangle, const rk_ray *ray,
                                  const peers_hit *ours, const peers_hit *theirs,
                                  peers_largest *largest)
{
    const passage p = passage_of(triangle, ray);
    /* A weight is at most 1, so its error is that of its determinant and of det. */
    const double weight = p.det > p.bound ? 2 * p.bound / (p.det - p.bound) : (double)INFINITY;
    const rk_vec3 normal = rk_sub(ours->normal, theirs->normal);
    const double found[PEERS_VALUE_KINDS] = {
        [PEERS_T] = fraction((double)(ours->t - theirs->t), t_error_of(&p), 0),
        [PEERS_WEIGHTS] = fraction((double)(ours->u - theirs->u), weight,
                                   fraction((double)(ours->v - theirs->v), weight, 0)),
        [PEERS_NORMAL] = fraction((double)normal.x, p.normal_bound,
                                  fraction((double)normal.y, p.normal_bound,
                                           fraction((double)normal.z, p.normal_bound, 0)))};
    bool same = true;
    for (int k = 0; k < PEERS_VALUE_KINDS; k++) {
        same = same && found[k] <= 1;
        largest->of_bound[k] = fmax(largest->of_bound[k], found[k]);
    }
    return same ? PEERS_SAME : PEERS_VALUES;
}

static bool is_point(rk_vec3 a, rk_vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static bool have_common_corner(const rk_triangle *a, const rk_triangle *b)
{
    const rk_vec3 of_b[] = {b->a, b->b, b->c};
    bool found = false;
    for (int k = 0; k < 3; k++)
        found =
            found || is_point(a->a, of_b[k]) || is_point(a->b, of_b[k]) || is_point(a->c, of_b[k]);
    return found;
}

/* Why the engine misses the triangle that raykit hits, or that nothing explains it. */
static peers_cause cause_of_miss(const rk_triangle *triangle, const rk_ray *ray)
{
    const passage p = passage_of(triangle, ray);
    return is_at_edge(&p) ? PEERS_LEAK : is_at_ends(&p, ray->t_max) ? PEERS_ENDS : PEERS_BOX;
}

/* Why the engine hits a triangle that raykit misses. */
static peers_cause cause_of_hit(const rk_triangle *triangle, const rk_ray *ray)
{
    const passage p = passage_of(triangle, ray);
    return is_at_edge(&p) ? PEERS_BEYOND : is_at_ends(&p, ray->t_max) ? PEERS_ENDS : PEERS_UNKNOWN;
}

static peers_cause compare_triangles(const rk_mesh *mesh, const rk_ray *ray, const peers_hit *ours,
                                     const peers_hit *theirs)
{
    const rk_triangle a = triangle_of(mesh, ours->triangle),
                      b = triangle_of(mesh, theirs->triangle);
    const passage of_a = passage_of(&a, ray), of_b = passage_of(&b, ray);
    const bool crosses_b = rk_watertight_intersect(&b, ray).triangle != RK_MISS;
    if (is_within((double)ours->t, (double)theirs->t, t_error_of(&of_a) + t_error_of(&of_b))) {
        if (have_common_corner(&a, &b))
            return crosses_b ? PEERS_SHARED : PEERS_NEIGHBOUR;
        return crosses_b ? PEERS_COINCIDENT : cause_of_hit(&b, ray);
    }
    return theirs->t > ours->t ? cause_of_miss(&a, ray) : cause_of_hit(&b, ray);
}

peers_cause peers_difference(const rk_mesh *mesh, const rk_ray *ray, const peers_hit *ours,
                             const peers_hit *theirs, peers_largest *largest)
{
    if (ours->triangle == RK_MISS && theirs->triangle == RK_MISS)
        return PEERS_SAME;
    if (theirs->triangle != RK_MISS && theirs->triangle >= mesh->triangle_count)
        return PEERS_UNKNOWN;
    if (ours->triangle != RK_MISS && theirs->triangle != RK_MISS &&
        ours->triangle != theirs->triangle)
        return compare_triangles(mesh, ray, ours, theirs);
    const uint32_t hit = ours->triangle != RK_MISS ? ours->triangle : theirs->triangle;
    const rk_triangle triangle = triangle_of(mesh, hit);
    if (ours->triangle == theirs->triangle)
        return compare_values(&triangle, ray, ours, theirs, largest);
    return hit == ours->triangle ? cause_of_miss(&triangle, ray) : cause_of_hit(&triangle, ray);
}

/* --- Occlusion -------------------------------------------------------------------------------- */

/* Does the ray, as far as float can tell, cross the triangle? */
static bool may_cross(const passage *p, float t_max)
{
    return smallest_of(p) >= -p->bound && p->t >= -p->t_bound &&
           (!isfinite(t_max) || p->t <= (double)t_max * (p->det + p->bound) + p->t_bound);
}

/* The engine does not tell which triangle occludes, so a triangle is searched that explains the
 * difference: a missed one if raykit says "occluded", one beyond its edges if not. */
peers_cause peers_occlusion_difference(const rk_mesh *mesh, const rk_ray *ray, bool ours,
                                       bool theirs)
{
    if (ours == theirs)
        return PEERS_SAME;
    peers_cause found = PEERS_UNKNOWN;
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const rk_triangle triangle = triangle_of(mesh, i);
        const passage p = passage_of(&triangle, ray);
        if (!may_cross(&p, ray->t_max))
            continue;
        const bool crosses = rk_triangle_occludes(&triangle, ray);
        const peers_cause cause =
            crosses ? cause_of_miss(&triangle, ray) : cause_of_hit(&triangle, ray);
        /* All triangles that the ray crosses are missed; one that is hit well inside tells more
         * than one at its edge. */
        if (crosses == ours && (found == PEERS_UNKNOWN || cause == PEERS_BOX))
            found = cause;
    }
    return found;
}
