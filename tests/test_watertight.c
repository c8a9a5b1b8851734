/* No ray slips between triangles: decisions are compared with integers, which know exactly on which
 * side of an edge a ray passes. */
#include "test.h"

#include "closed_mesh.h"

#include <float.h>

enum { cases = 5000 }; /* the rarest known mistake shows in one of 30 */

/* Corners and origins up to 2^22: differences and their products fit the integers, and the floats.
 */
static const int64_t extent = 1 << 22;

typedef struct pair_of {
    whole3 corner[3], origin, direction;
    whole_determinants want;
} pair_of;

static rk_ray ray_of(const pair_of *p, int exponent)
{
    return (rk_ray){float_of(p->origin, exponent), float_of(p->direction, 0), INFINITY};
}

/* A random triangle, and a ray to a point around it. */
static pair_of random_pair(uint32_t key)
{
    pair_of p;
    for (uint32_t k = 0; k < 3; k++)
        p.corner[k] = random_point(key, 3 * k, extent);
    p.origin = random_point(key, 9, extent);
    whole3 to = whole_madd(whole_madd(p.corner[0], p.corner[1], 1), p.corner[2], 1);
    to = whole_of(to.x / 3, to.y / 3, to.z / 3);
    p.direction = whole_madd(whole_madd(to, p.origin, -1), random_point(key, 12, extent / 4), 1);
    p.want = whole_determinants_of(p.corner, p.origin, p.direction);
    return p;
}

/* A triangle whose edge ab has eight equal parts, and a ray through one of their ends; coordinates
 * up to `below`. */
static pair_of edge_pair_within(uint32_t key, int64_t below)
{
    pair_of p;
    whole3 part = random_point(key, 0, below / 16);
    p.corner[0] = random_point(key, 3, below / 2);
    p.corner[1] = whole_madd(p.corner[0], part, 8);
    p.corner[2] = random_point(key, 6, below);
    p.origin = random_point(key, 9, below);
    whole3 at = whole_madd(p.corner[0], part, 1 + (int64_t)(rk_case(key, 1, 2, 3) % 7));
    p.direction = whole_madd(at, p.origin, -1);
    p.want = whole_determinants_of(p.corner, p.origin, p.direction);
    return p;
}

static pair_of edge_pair(uint32_t key)
{
    return edge_pair_within(key, extent);
}

static rk_hit intersect(const pair_of *p, int exponent)
{
    rk_triangle triangle = float_triangle(p->corner, exponent, 7);
    rk_ray ray = ray_of(p, exponent);
    return rk_watertight_intersect(&triangle, &ray);
}

static const char *hits_or_misses(bool hits)
{
    return hits ? "a hit" : "a miss";
}

/* Whose mistake it is. */
static const char *decided_by(const rk_triangle *triangle, const rk_ray *ray)
{
    return rk_watertight_is_certain(triangle, ray)
               ? "double decided, because is_certain returned true: is its bound, 2^-48 edge reach "
                 "longest, as large as the rounding errors?"
               : "exact_determinants decided, because is_certain returned false";
}

static void check_decision(const pair_of *p, uint32_t i, const char *hint)
{
    bool want = whole_hits(&p->want), got = intersect(p, 0).triangle != RK_MISS;
    rk_triangle triangle = float_triangle(p->corner, 0, 7);
    rk_ray ray = ray_of(p, 0);
    rk_check(got == want, "ray %u: got %s, want %s: %s; %s", i, hits_or_misses(got),
             hits_or_misses(want), hint, decided_by(&triangle, &ray));
}

/* --- In double -------------------------------------------------------------------------------- */

/* A ray back and one beside the triangle tell which sign is wrong. */
static const char *mistake_of_miss(const pair_of *p)
{
    rk_triangle triangle = float_triangle(p->corner, 0, 7);
    rk_ray ray = ray_of(p, 0), back = {ray.origin, rk_negate(ray.direction), INFINITY};
    if (rk_watertight_intersect(&triangle, &back).triangle != RK_MISS)
        return "; the ray in the opposite direction hits, behind which the triangle is: t has the "
               "other sign";
    for (int k = 0; k < 3; k++) { /* across the edge opposite to corner k */
        rk_vec3 a = float_of(p->corner[k], 0), b = float_of(p->corner[(k + 1) % 3], 0);
        rk_vec3 c = float_of(p->corner[(k + 2) % 3], 0);
        rk_vec3 beyond = rk_madd(rk_scale(rk_add(b, c), 0.625f), a, -0.25f);
        rk_ray aside = {ray.origin, rk_sub(beyond, ray.origin), INFINITY};
        if (rk_watertight_intersect(&triangle, &aside).triangle != RK_MISS)
            return k == 0   ? "; rays beside edge bc hit, where w is below 0: w has the other sign"
                   : k == 1 ? "; rays beside edge ca hit, where u is below 0: u has the other sign"
                            : "; rays beside edge ab hit, where v is below 0: v has the other sign";
    }
    return "";
}

/* Far from the edges, where float is enough. */
static void check_clear_hit(const pair_of *p, uint32_t i, bool got)
{
    const whole_determinants *m = &p->want;
    long double det = (long double)m->det, least = det / 1000;
    bool clear = det > 1e-4L * 0x1p69L && (long double)m->u > least && (long double)m->v > least &&
                 (long double)m->w > least && m->t > 0;
    rk_check(
        !clear || got,
        "ray %u: got a miss, want a hit at t = %.3Lg, u = %.3Lg, v = %.3Lg, far from the edges: "
        "do u, v, w and t have the right signs?%s",
        i, (long double)m->t / det, (long double)m->u / det, (long double)m->v / det,
        mistake_of_miss(p));
}

/* Triangles and rays are read by several threads at once. */
static void check_constant_triangle(void)
{
    const rk_triangle corners = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0};
    const rk_ray down = {{0.25f, 0.25f, 1}, {0, 0, -1}, INFINITY};
    const rk_triangle *triangle = rk_read_only(&corners, sizeof corners, "triangle");
    const rk_ray *ray = rk_read_only(&down, sizeof down, "ray");
    rk_watertight_intersect(triangle, ray);
    rk_watertight_is_certain(triangle, ray);
    rk_read_only_free();
}

static void t_u_and_v_are_rounded_from_double(void **state)
{
    (void)state;
    check_constant_triangle();
    unsigned hits = 0;
    for (uint32_t i = 0; i < cases; i++) {
        pair_of p = random_pair(i);
        rk_hit hit = intersect(&p, 0);
        /* Determinants below 1e-4 of the largest lose digits in double, too. */
        long double det = (long double)p.want.det;
        check_clear_hit(&p, i, hit.triangle != RK_MISS);
        if (!whole_hits(&p.want) || hit.triangle == RK_MISS || det < 1e-4L * 0x1p69L)
            continue;
        const double t = (double)((long double)p.want.t / det);
        const double u = (double)((long double)p.want.u / det);
        const double v = (double)((long double)p.want.v / det), w = 1 - u - v;
        rk_check_near_or(
            hit.t, t, (double)hit.t * 0x1p-23,
            RK_MISTAKES({t / (u + v), "det is u + v, without w"},
                        {t / (2 * u + v), "w is taken as u"}, {t / (u + 2 * v), "w is taken as v"},
                        {t / (1 + v), "w is the determinant less u alone"},
                        {t / (1 + u), "w is the determinant less v alone"},
                        {-t, "t has the other sign"}),
            "ray %u: t, rounded once to a float, with u = %.9g, v = %.9g, w = %.9g", i, u, v, w);
        rk_check_near_or(hit.u, u, 0x1p-24,
                         RK_MISTAKES({v, "u and v are exchanged"}, {w, "u and w are exchanged"}),
                         "ray %u: u", i);
        rk_check_near_or(hit.v, v, 0x1p-24,
                         RK_MISTAKES({u, "u and v are exchanged"}, {w, "v and w are exchanged"}),
                         "ray %u: v", i);
        hits++;
    }
    rk_check(hits > cases / 20, "%u hits were compared: too few", hits);
}

static void rays_beside_the_edges_are_decided_as_by_integers(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < cases; i++) {
        pair_of p = random_pair(i);
        check_decision(&p, i, "the three determinants u, v and w decide, and t");
    }
}

static void tiny_and_huge_scenes_have_the_same_hits(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < cases; i++) {
        pair_of p = random_pair(i);
        check_decision(&p, i, "at its own size: do u, v, w and t have the right signs?");
        rk_hit want = intersect(&p, 0);
        int exponent = (int)(rk_case(i, 4, 4, 4) % 141) - 100;
        rk_hit got = intersect(&p, exponent);
        rk_check(got.triangle == want.triangle,
                 "ray %u, everything times 2^%d: got %s, want %s: products of three floats fit a "
                 "double at every scale",
                 i, exponent, hits_or_misses(got.triangle != RK_MISS),
                 hits_or_misses(want.triangle != RK_MISS));
    }
}

/* --- Exactly ---------------------------------------------------------------------------------- */

/* Differences are below 2^11, so determinants are below 6 times 2^33: nothing is rounded. */
static void small_whole_numbers_are_decided_by_their_determinants(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < cases; i++) {
        pair_of p = edge_pair_within(i, 1 << 10);
        for (uint32_t k = 0; k < i % 3; k++) { /* the edge is ab, then bc, then ca */
            whole3 a = p.corner[0];
            p.corner[0] = p.corner[1], p.corner[1] = p.corner[2], p.corner[2] = a;
        }
        if (i & 1) /* beside it */
            p.direction = whole_madd(p.direction, random_point(i, 80, 1), 1);
        p.want = whole_determinants_of(p.corner, p.origin, p.direction);
        const whole3 *c = p.corner, o = p.origin, d = p.direction;
        const whole_determinants *m = &p.want;
        char text[400];
        snprintf(text, sizeof text,
                 "from (%d, %d, %d) along (%d, %d, %d), corners (%d, %d, %d), (%d, %d, %d), "
                 "(%d, %d, %d): but for a common sign u, v, w and t are %lld, %lld, %lld and %lld. "
                 "Whole numbers as small as these are not rounded, so a factor or a sign is wrong",
                 (int)o.x, (int)o.y, (int)o.z, (int)d.x, (int)d.y, (int)d.z, (int)c[0].x,
                 (int)c[0].y, (int)c[0].z, (int)c[1].x, (int)c[1].y, (int)c[1].z, (int)c[2].x,
                 (int)c[2].y, (int)c[2].z, (long long)m->u, (long long)m->v, (long long)m->w,
                 (long long)m->t);
        check_decision(&p, i, text);
    }
}

/* A ray along z through the edge bc, or beside it. Seen from c, the two products of
 * its w are the same numbers, so they cancel even rounded; D - u - v leaves what rounding took. */
static void the_edge_bc_is_seen_from_its_own_corner(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < cases; i++) {
        pair_of p = {.direction = {0, 0, extent / 2 + random_whole(i, 20, extent / 4)}};
        whole3 part = random_point(i, 0, extent / 16), c = random_point(i, 3, extent / 2);
        p.corner[0] = random_point(i, 6, extent);
        p.corner[1] = whole_madd(c, part, 8);
        p.corner[2] = c;
        p.origin = whole_madd(c, part, 1 + i % 7);
        p.origin.x += random_whole(i, 21, 1), p.origin.z = -2 * extent;
        p.want = whole_determinants_of(p.corner, p.origin, p.direction);
        check_decision(
            &p, i,
            "the ray passes through the edge bc, or next to it: seen from c, with the "
            "edge from c to b, w is right even while sums and products are rounded, so if "
            "it was before, two_sum or add is wrong");
    }
}

/* A ray beside the diagonal of a square, nearer than what its size leaves of a double. Every
 * coordinate is a power of two, so no product is rounded, only sums are. */
static void sums_keep_the_smallest_part(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 1000; i++) {
        float size = ldexpf(1, 20 + (int)(rk_case(i, 0, 0, 9) % 30));
        float near = ldexpf(1, -40 - (int)(rk_case(i, 1, 0, 9) % 30));
        int beside = (int)(i / 3 % 3) - 1; /* the triangle's side, the diagonal, the other one */
        float across = ldexpf(near, beside);
        rk_triangle triangle = {{-size, -size, 1}, {size, size, 1}, {size, -size, 1}, 0};
        rk_ray ray = {{near, across, 0}, {0, 0, 1}, INFINITY};
        rk_vec3 *points[] = {&triangle.a, &triangle.b, &triangle.c, &ray.origin, &ray.direction};
        for (int k = 0; k < 5; k++) /* along z, x or y */
            for (uint32_t turn = 0; turn < i % 3; turn++)
                *points[k] = rk_vec(points[k]->z, points[k]->x, points[k]->y);
        bool got = rk_watertight_intersect(&triangle, &ray).triangle != RK_MISS;
        rk_check(
            got == (beside <= 0),
            "ray %u: got %s, want %s: all coordinates are powers of two, %g or %g, so products "
            "are not rounded, but sums are, unless two_sum and add keep all; %s",
            i, hits_or_misses(got), hits_or_misses(beside <= 0), (double)size, (double)near,
            decided_by(&triangle, &ray));
    }
}

/* Most of the products cancel, and the parts of the sum that are left are of similar size: the
 * determinants are all of them. t and u by fractions of whole numbers. */
static void check_needle(void)
{
    const rk_triangle needle = {{0, 0, 0},
                                {-0x1.801a86p+6f, -0x1.fe0556p+9f, 0x1.f9300ap+10f},
                                {0x1.a80bfep-14f, 0x1.01d21cp-10f, -0x1.eb1332p-12f},
                                0};
    const rk_ray ray = {{-0x1.e7a1ccp+9f, -0x1.43be76p+13f, 0x1.40ad02p+14f},
                        {0x1.c21f36p+6f, 0x1.2ad734p+10f, -0x1.28022ap+11f},
                        INFINITY};
    const rk_hit hit = rk_watertight_intersect(&needle, &ray);
    const char hint[] = "of a needle, by its exact determinants: a sum is all of its parts";
    rk_check_near(hit.t, 8.06270809954953, 8 * 0x1p-23, "t %s", hint);
    rk_check_near(hit.u, 0.7077637437467705, 0x1p-23, "u %s", hint);
    rk_check_near(hit.v, 0.21385119906522732, 0x1p-23, "v %s", hint);
}

/* Some of the triangles are slivers: the edge is ac, and ab is much shorter. */
static void rays_through_an_edge_hit_the_triangle(void **state)
{
    (void)state;
    unsigned hits = 0;
    for (uint32_t i = 0; i < cases; i++) {
        pair_of p = edge_pair(i);
        if (i % 4 == 3) {
            p.corner[2] = p.corner[1];
            p.corner[1] = whole_madd(p.corner[0], random_point(i, 6, 16), 1);
            p.want = whole_determinants_of(p.corner, p.origin, p.direction);
        }
        check_decision(&p, i,
                       i % 4 == 3
                           ? "the ray passes exactly through ac, a long edge of a sliver, so u is "
                             "0; its bound has the longest edge, here not ab"
                           : "the ray passes exactly through the edge ab, so v is 0; its products "
                             "have up to 69 digits and are not rounded if two_product keeps the "
                             "rest");
        hits += whole_hits(&p.want);
    }
    rk_check(hits > cases / 2, "%u hits: too few", hits);
    check_needle();
}

static void the_neighbour_beyond_the_edge_is_hit_as_well(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < cases; i++) {
        pair_of p = edge_pair(i);
        whole3 a = p.corner[0];
        p.corner[0] = p.corner[1], p.corner[1] = a;
        p.corner[2] = random_point(i, 60, extent);
        p.want = whole_determinants_of(p.corner, p.origin, p.direction);
        check_decision(&p, i, "an edge belongs to both of its triangles");
    }
}

static void a_direction_next_to_the_edge_is_on_its_side(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < cases; i++) {
        pair_of p = edge_pair(i);
        p.direction = whole_madd(p.direction, random_point(i, 80, 1), 1);
        p.want = whole_determinants_of(p.corner, p.origin, p.direction);
        check_decision(&p, i, "the direction is one unit beside the edge");
    }
}

/* Some directions are much shorter than the edges, as unit ones are in a large scene. */
static void a_ray_that_starts_in_the_plane_misses(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < cases; i++) {
        const int64_t lengths[] = {extent, 3, 1 << 10, 1 << 16};
        pair_of p = edge_pair(i);
        whole3 ab = whole_madd(p.corner[1], p.corner[0], -1);
        /* Inside: between a point of ab and c. Distances are halved so that whole numbers do. */
        p.corner[2] = whole_madd(p.corner[0], random_point(i, 6, extent / 8), 2);
        whole3 to_c = whole_madd(p.corner[2], p.corner[0], -1);
        p.origin = whole_madd(p.corner[0], whole_of(ab.x / 8, ab.y / 8, ab.z / 8), 2);
        p.origin = whole_madd(p.origin, whole_of(to_c.x / 2, to_c.y / 2, to_c.z / 2), 1);
        p.direction = random_point(i, 30, lengths[i % 4]);
        p.want = whole_determinants_of(p.corner, p.origin, p.direction);
        rk_check(p.want.t == 0, "the case is wrong: the origin is not in the plane");
        check_decision(&p, i,
                       "the ray starts in the triangle's plane: t is 0, which is no hit; the bound "
                       "of t's error has "
                       "the unit of t: edge times edge times distance, without the direction");
        /* Powers of two change no digit: directions far longer, or shorter, than any edge. */
        const int exponents[] = {20, -20, 60, -60, 100, -100};
        for (int k = 0; k < 6 && i % 4 == 0; k++) {
            rk_triangle triangle = float_triangle(p.corner, 0, 7);
            rk_ray ray = ray_of(&p, 0);
            ray.direction = rk_scale(ray.direction, ldexpf(1, exponents[k]));
            rk_check(rk_watertight_intersect(&triangle, &ray).triangle == RK_MISS,
                     "ray %u: got a hit, want a miss: the ray starts in the triangle's plane, and "
                     "its direction is times 2^%d: the bound of t's error does not depend on it; "
                     "%s",
                     i, exponents[k], decided_by(&triangle, &ray));
        }
    }
}

/* Coordinates from 2^-80 to 2^60. */
static rk_vec3 wild_point(uint32_t key, uint32_t dimension)
{
    float c[3];
    for (uint32_t k = 0; k < 3; k++) {
        int exponent = (int)(rk_case(key, dimension, k, 5) % 141) - 80;
        c[k] = ldexpf(2 * rk_unit_float(rk_case(key, dimension, k, 6)) - 1, exponent);
    }
    return rk_vec(c[0], c[1], c[2]);
}

static void the_order_of_the_corners_does_not_matter(void **state)
{
    (void)state;
    unsigned hits = 0;
    for (uint32_t i = 0; i < cases / 4; i++) {
        rk_vec3 a = wild_point(i, 0), b = wild_point(i, 1), c = wild_point(i, 2);
        rk_vec3 origin = wild_point(i, 3);
        /* Towards a corner or the middle of an edge, rounded: close by, whatever the sizes. */
        rk_vec3 to = i % 3 == 0 ? a : rk_scale(rk_add(a, b), 0.5f);
        rk_ray ray = {origin, rk_sub(to, origin), INFINITY};
        const rk_triangle orders[6] = {{a, b, c, 0}, {b, c, a, 0}, {c, a, b, 0},
                                       {a, c, b, 0}, {c, b, a, 0}, {b, a, c, 0}};
        bool first = rk_watertight_intersect(&orders[0], &ray).triangle != RK_MISS;
        for (int k = 1; k < 6; k++)
            rk_check((rk_watertight_intersect(&orders[k], &ray).triangle != RK_MISS) == first,
                     "ray %u: got %s with the corners in one order, and %s in another; differences "
                     "of very different numbers are rounded, too; %s, then %s",
                     i, hits_or_misses(first), hits_or_misses(!first), decided_by(&orders[0], &ray),
                     decided_by(&orders[k], &ray));
        hits += first;
    }
    rk_check(hits > cases / 100, "%u hits: too few", hits);
}

/* Powers of two change no digit, neither of a determinant nor of its bound. */
static void check_certainty(const pair_of *p, uint32_t i)
{
    int scene = (int)(rk_case(i, 5, 5, 5) % 121) - 80,
        along = (int)(rk_case(i, 6, 5, 5) % 121) - 80;
    rk_triangle triangle = float_triangle(p->corner, 0, 7);
    rk_ray ray = ray_of(p, 0);
    bool want = rk_watertight_is_certain(&triangle, &ray);
    triangle = float_triangle(p->corner, scene, 7);
    ray = (rk_ray){float_of(p->origin, scene), float_of(p->direction, along), INFINITY};
    bool got = rk_watertight_is_certain(&triangle, &ray);
    rk_check(
        got == want,
        "ray %u: is_certain is %s, but %s with the scene times 2^%d and the direction times 2^%d: "
        "both sides of each comparison must have the same unit",
        i, want ? "true" : "false", got ? "true" : "false", scene, along);
}

/* The example in the chapter. A ray through an edge has a determinant of 0, which no bound
 * excludes. */
static void check_certainty_by_hand(void)
{
    const rk_triangle triangle = {{0, 0, 1}, {4, 0, 1}, {0, 4, 1}, 0};
    static const struct {
        float y;
        bool is_certain;
        const char *why;
    } rays[] = {{1, true, "u, v and w are -4, -4 and -8: certainly a hit"},
                {-1, true, "u, v and w are -4, 4 and -16: certainly a miss"},
                {0, false, "the ray passes through the edge ab, so v is 0"}};
    for (int i = 0; i < 3; i++) {
        rk_ray ray = {rk_vec(1, rays[i].y, 0), rk_vec(0, 0, 1), INFINITY};
        bool got = rk_watertight_is_certain(&triangle, &ray);
        rk_check(got == rays[i].is_certain,
                 "from (1, %g, 0) along z, corners (0, 0, 1), (4, 0, 1) and (0, 4, 1): is_certain "
                 "is %s, want %s: %s",
                 (double)rays[i].y, got ? "true" : "false", rays[i].is_certain ? "true" : "false",
                 rays[i].why);
    }
}

/* Double is certain of all these rays even by a bound of 2^-24 in place of 2^-48; 1 % leaves room
 * for wider ones. */
static void double_decides_away_from_the_edges(void **state)
{
    (void)state;
    unsigned exact = 0;
    check_certainty_by_hand();
    for (uint32_t i = 0; i < cases; i++) {
        pair_of p = random_pair(i);
        rk_triangle triangle = float_triangle(p.corner, 0, 7);
        rk_ray ray = ray_of(&p, 0);
        exact += !rk_watertight_is_certain(&triangle, &ray);
        check_certainty(&p, i);
        p = edge_pair(i);
        check_certainty(&p, i);
    }
    rk_check(exact < cases / 100,
             "is_certain is false for %u of %u random rays: double is certain where all pass far "
             "from the edges, and exact numbers take longer",
             exact, (unsigned)cases);
}

/* --- Closed meshes ---------------------------------------------------------------------------- */

enum { rows = 6, triangles_max = 8 * rows * rows };

static void check_ball(int exponent, whole3 centre, double radius, uint32_t key)
{
    static whole3 ball[triangles_max][3];
    uint32_t count = make_ball(ball, rows, radius, centre);
    for (uint32_t i = 0; i < 100; i++) {
        uint32_t ray_key = key * 1000 + i;
        whole3 origin = whole_madd(centre, random_point(ray_key, 30, (int64_t)(radius / 4)), 1);
        whole3 direction = aimed(ray_key, ball[rk_case(ray_key, 0, 0, 8) % count], origin);
        rk_ray ray = {float_of(origin, exponent), float_of(direction, 0), INFINITY};
        unsigned hits = 0;
        for (uint32_t k = 0; k < count; k++) {
            rk_triangle triangle = float_triangle(ball[k], exponent, k);
            hits += rk_watertight_intersect(&triangle, &ray).triangle != RK_MISS;
        }
        rk_check(hits > 0,
                 "ray %u leaves a closed ball of radius %g without a hit, at 2^%d times its size: "
                 "it is aimed at an edge or a corner",
                 i, radius, exponent);
    }
}

static void no_ray_leaves_a_closed_ball(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 8; i++)
        check_ball(0, whole_of(0, 0, 0), 3e6 + 1e4 * (double)i, i);
}

static void no_ray_leaves_it_at_any_scale_or_place(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < 8; i++) {
        int exponent = (int)i * 16 - 84;
        check_ball(exponent, random_point(i, 0, 1 << 22), 3e4, 50 + i);
    }
}

/* A tetrahedron's corner through which the ray passes, and whose edges run nearly along it: their
 * differences have 25 digits, and the last one decides on which side the displaced ray passes. */
static void check_steep_corners(void)
{
    for (uint32_t i = 0; i < 2000; i++) {
        whole3 direction = random_point(i, 0, 1 << 18), corner[4];
        corner[0] = whole_madd(random_point(i, 3, 1 << 10), direction, -60);
        for (uint32_t k = 1; k < 4; k++)
            corner[k] = whole_madd(whole_madd(corner[0], direction, 80 + 10 * k),
                                   random_point(i, 3 + 3 * k, 2), 1);
        rk_ray ray = {float_of(whole_madd(corner[0], direction, -2), 0), float_of(direction, 0),
                      INFINITY};
        static const int faces[4][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 1}, {3, 2, 1}};
        int sum = 0;
        for (int k = 0; k < 4; k++) {
            const whole3 face[3] = {corner[faces[k][0]], corner[faces[k][1]], corner[faces[k][2]]};
            rk_triangle triangle = float_triangle(face, 0, 0);
            rk_hit hit = {0};
            sum += rk_watertight_cross(&triangle, &ray, &hit);
        }
        rk_check(
            sum == 0,
            "tetrahedron %u, through a corner whose edges run nearly along the ray: entered %d "
            "times more often than left; is the edge between two floats a pair of doubles?",
            i, sum);
    }
}

static void a_closed_surface_is_entered_as_often_as_left(void **state)
{
    (void)state;
    static whole3 ball[triangles_max][3];
    const double radius = 1e6;
    uint32_t count = make_ball(ball, rows, radius, whole_of(0, 0, 0));
    unsigned tested = 0;
    for (uint32_t i = 0; i < 2000; i++) {
        const whole3 *target = ball[rk_case(i, 0, 0, 8) % count];
        whole3 origin = random_point(i, 30, 1 << 21), direction = aimed(i, target, origin);
        if (i % 4 == 0) { /* along an axis, through a corner */
            direction = whole_of(i % 3 == 0, i % 3 == 1, i % 3 == 2);
            origin = whole_madd(target[0], direction, -(1 << 20));
        }
        origin = whole_madd(origin, direction, i % 4 == 0 ? -(1 << 22) : -2);
        double d[3] = {(double)direction.x, (double)direction.y, (double)direction.z};
        double o[3] = {(double)origin.x, (double)origin.y, (double)origin.z}, od = 0, dd = 0,
               oo = 0;
        for (int k = 0; k < 3; k++)
            od += o[k] * d[k], dd += d[k] * d[k], oo += o[k] * o[k];
        if (oo < 1.1 * radius * radius || od > 0)
            continue; /* the ball is not ahead */
        tested++;
        rk_ray ray = {float_of(origin, 0), float_of(direction, 0), INFINITY};
        int entered = 0, left = 0;
        for (uint32_t k = 0; k < count; k++) {
            rk_triangle triangle = float_triangle(ball[k], 0, k);
            rk_hit hit = {0};
            int side = rk_watertight_cross(&triangle, &ray, &hit);
            entered += side > 0, left += side < 0;
        }
        /* If it passes outside by a hair it is neither entered nor left. */
        rk_check(entered == left && entered <= 1,
                 "ray %u enters a ball %d times and leaves it %d times: through an edge or a "
                 "corner, one triangle counts",
                 i, entered, left);
        /* The faces of the ball are nearer than its corners, but by less than a tenth. */
        bool deep = oo - od * od / dd < 0.8 * radius * radius;
        rk_check(
            !deep || entered == 1, "ray %u passes through the ball%s, but enters it %d times", i,
            i % 4 == 0 ? " along an axis and through a corner, where e and e^2 may not decide" : "",
            entered);
    }
    rk_check(tested > 1000, "%u rays: too few", tested);
    check_steep_corners();
}

/* --- Every input has an answer ---------------------------------------------------------------- */

static void check_miss(rk_triangle triangle, rk_ray ray, const char *hint)
{
    rk_hit hit = {0};
    rk_check(rk_watertight_intersect(&triangle, &ray).triangle == RK_MISS, "%s: a miss", hint);
    rk_check(rk_watertight_cross(&triangle, &ray, &hit) == 0, "%s: no crossing", hint);
}

static void triangles_without_area_and_rays_in_the_plane_miss(void **state)
{
    (void)state;
    rk_vec3 a = rk_vec(0, 0, 1), b = rk_vec(3, 0, 1), c = rk_vec(0, 3, 1);
    rk_ray ray = {rk_vec(1, 0, 0), rk_vec(0, 0, 1), INFINITY};
    check_miss((rk_triangle){a, b, a, 0}, ray, "an edge");
    check_miss((rk_triangle){a, a, a, 0}, ray, "a point");
    check_miss((rk_triangle){a, b, rk_vec(1.5f, 0, 1), 0}, ray, "three points of a line");
    ray = (rk_ray){rk_vec(-1, 1, 1), rk_vec(1, 0, 0), INFINITY};
    check_miss((rk_triangle){a, b, c, 0}, ray, "a ray in the plane");
    ray.direction = rk_vec(0, 0, 0);
    check_miss((rk_triangle){a, b, c, 0}, ray, "a ray without direction");
}

static void nan_and_infinity_miss(void **state)
{
    (void)state;
    const float broken[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 45; i++) {
        float n[15] = {-1, -1, 1, 3, -1, 1, -1, 3, 1, 0, 0, 0, 0, 0, 1};
        n[i / 3] = broken[i % 3];
        rk_triangle triangle = {rk_vec(n[0], n[1], n[2]), rk_vec(n[3], n[4], n[5]),
                                rk_vec(n[6], n[7], n[8]), 0};
        rk_ray ray = {rk_vec(n[9], n[10], n[11]), rk_vec(n[12], n[13], n[14]), INFINITY};
        check_miss(triangle, ray, "NaN or infinity");
    }
}

/* The determinants are exact: edges and direction are powers of two. */
static void check_largest_t(void)
{
    const float far[] = {0x1p100f, 0x1p127f, FLT_MAX};
    rk_hit one[3], all[3];
    uint32_t first[3], first_before[3];
    for (int i = 0; i < 3; i++) {
        const rk_triangle triangle = {{-1, -1, far[i]}, {3, -1, far[i]}, {-1, 3, far[i]}, 0};
        rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0, 0, 1), FLT_MAX};
        all[i] = (rk_hit){FLT_MAX, 0, 0, RK_MISS};
        one[i] = rk_watertight_intersect(&triangle, &ray);
        rk_triangles_closest(&triangle, 1, &ray, &all[i]);
        first[i] = rk_triangles_first_hit(&triangle, 1, &ray);
        ray.t_max = nextafterf(far[i], 0);
        first_before[i] = rk_triangles_first_hit(&triangle, 1, &ray);
    }
    for (int i = 0; i < 3; i++) {
        rk_check_near(one[i].t, far[i], 0, "a hit at %g", (double)far[i]);
        rk_check_near(all[i].t, far[i], 0, "the closest hit of a leaf at %g", (double)far[i]);
        rk_check(all[i].triangle == 0, "the closest hit of a leaf at %g: got a miss",
                 (double)far[i]);
        rk_check(first[i] == 0, "the first hit of a leaf at %g: got none", (double)far[i]);
        rk_check(first_before[i] == 1,
                 "the first hit of a leaf up to the float below %g: got one, want none",
                 (double)far[i]);
    }
}

static void a_t_out_of_range_is_defined(void **state)
{
    (void)state;
    rk_triangle triangle = {{-1, -1, 1}, {3, -1, 1}, {-1, 3, 1}, 0};
    rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0, 0, FLT_TRUE_MIN), INFINITY};
    check_miss(triangle, ray, "t would be above FLT_MAX");
    check_largest_t();
    triangle.a.z = triangle.b.z = triangle.c.z = FLT_TRUE_MIN;
    ray.direction.z = FLT_MAX;
    rk_check_close(rk_watertight_intersect(&triangle, &ray).t, FLT_TRUE_MIN, 0,
                   "above 0, though below the smallest float");
}

/* --- Four at once ----------------------------------------------------------------------------- */

static void check_leaf(uint32_t key, int exponent, int direction_exponent)
{
    rk_triangle leaf[9];
    uint32_t count = 1 + key % 9;
    pair_of p = key % 2 ? edge_pair(key) : random_pair(key);
    for (uint32_t k = 0; k < count; k++) {
        pair_of other = random_pair(key * 16 + k);
        other.corner[0] = p.corner[0], other.corner[1] = p.corner[1];
        leaf[k] = float_triangle(other.corner, exponent, key & 2 ? 100 - k : 100 + k);
    }
    rk_ray ray = ray_of(&p, exponent);
    ray.direction = float_of(p.direction, direction_exponent);
    rk_hit want = {INFINITY, 0, 0, RK_MISS}, got = want;
    uint32_t first = count;
    for (uint32_t k = 0; k < count; k++) {
        rk_triangle_closest(&leaf[k], &ray, &want);
        bool occludes = rk_triangle_occludes(&leaf[k], &ray);
        if (first == count && occludes)
            first = k;
    }
    rk_triangles_closest(leaf, count, &ray, &got);
    rk_check(got.triangle == want.triangle && got.t == want.t && got.u == want.u && got.v == want.v,
             "leaf %u, times 2^%d: got triangle %u, want %u as one by one", key, exponent,
             got.triangle, want.triangle);
    rk_check_equal(rk_triangles_first_hit(leaf, count, &ray), first, "the first one that occludes");
}

static void four_at_once_are_decided_as_one_by_one(void **state)
{
    (void)state;
    for (uint32_t i = 0; i < cases / 2; i++) {
        check_leaf(i, 0, 0);
        check_leaf(i, (int)(rk_case(i, 1, 8, 8) % 227) - 140,
                   (int)(rk_case(i, 2, 8, 8) % 227) - 140);
    }
    for (uint32_t i = 0; i < cases / 8;
         i++) /* t has few digits left, and rounding it takes a half */
        check_leaf(i, -61, 85 + (int)(i % 4));
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(t_u_and_v_are_rounded_from_double),
    cmocka_unit_test(rays_beside_the_edges_are_decided_as_by_integers),
    cmocka_unit_test(tiny_and_huge_scenes_have_the_same_hits),
    cmocka_unit_test(small_whole_numbers_are_decided_by_their_determinants),
    cmocka_unit_test(the_edge_bc_is_seen_from_its_own_corner),
    cmocka_unit_test(sums_keep_the_smallest_part),
    cmocka_unit_test(rays_through_an_edge_hit_the_triangle),
    cmocka_unit_test(the_neighbour_beyond_the_edge_is_hit_as_well),
    cmocka_unit_test(a_direction_next_to_the_edge_is_on_its_side),
    cmocka_unit_test(a_ray_that_starts_in_the_plane_misses),
    cmocka_unit_test(the_order_of_the_corners_does_not_matter),
    cmocka_unit_test(double_decides_away_from_the_edges),
    cmocka_unit_test(no_ray_leaves_a_closed_ball),
    cmocka_unit_test(no_ray_leaves_it_at_any_scale_or_place),
    cmocka_unit_test(a_closed_surface_is_entered_as_often_as_left),
    cmocka_unit_test(triangles_without_area_and_rays_in_the_plane_miss),
    cmocka_unit_test(nan_and_infinity_miss),
    cmocka_unit_test(a_t_out_of_range_is_defined),
    cmocka_unit_test(four_at_once_are_decided_as_one_by_one),
};

RK_SUITE("watertight", tests)
