/* A triangle test that no ray slips past. The determinants of Moeller and Trumbore are computed up
 * to three times: in float, four triangles at once, to reject those that the ray certainly misses;
 * in double, to decide; and exactly, where rounding could change a sign. All three start from the
 * corners as they are in the mesh, so neighbours decide about the same edge.
 * Shewchuk, "Adaptive precision floating-point arithmetic and fast robust geometric predicates",
 * Discrete & Computational Geometry 18, 1997; bounds: Higham, "Accuracy and Stability of Numerical
 * Algorithms", 2002, section 3.1; ties: Edelsbrunner and Muecke, "Simulation of simplicity", ACM
 * Transactions on Graphics 9(1), 1990. */
#include "features/watertight.h"

#include "base/dvec3.h"

#include <float.h>

/* The vectors of which the determinants are products. */
typedef struct vectors {
    rk_dvec3 s, ab, ac, direction;
} vectors;

/* The ray's line passes through the triangle if u, v and w have the same sign. */
typedef struct determinants {
    double u, v,
        w;    /* the sides of the edges ac, ab and bc on which it passes; weights of b, c, a */
    double t; /* the side of the plane on which the ray starts */
} determinants;

/* A number that is not rounded: the sum of two doubles. */
typedef struct pair {
    double high, low;
} pair;

typedef struct pair3 {
    pair x, y, z;
} pair3;

/* Enough for a triple product: six products of three pairs, of eight times four parts each. */
enum { parts_max = 192 };

/* A number that is not rounded: the sum of its parts, none of which is 0. They do not overlap, so
 * the last one, the largest, has the sign of all. */
typedef struct exact_sum {
    int count;
    double parts[parts_max];
} exact_sum;

/* Contents, in the order of the chapter. */
static inline vectors vectors_of(const rk_triangle *triangle, const rk_ray *ray);
static inline determinants determinants_of(const vectors *x);
static inline rk_hit hit_of(const determinants *m, uint32_t triangle);
static pair two_sum(double a, double b);
static void add(exact_sum *sum, double x);
static double triple_product(pair3 a, pair3 b, pair3 c);
static pair3 difference(rk_vec3 a, rk_vec3 b);
static determinants exact_determinants(const rk_triangle *triangle, const rk_ray *ray);
static pair two_product(double a, double b);
static void add_product(exact_sum *sum, pair a, pair b, pair c, double sign);
static inline double larger(double a, double b);
static inline double smaller(double a, double b);
static inline double size_of(rk_dvec3 a);
static inline double longest_of(rk_dvec3 a);
static inline bool is_certain(const determinants *m, const vectors *x);
static double side_when_displaced(double side, rk_vec3 from, rk_vec3 to, rk_vec3 direction);
static int sign_of(double x);
static inline uint32_t may_hit(const rk_ray *ray, float t_max, const rk_triangle *triangles,
                               uint32_t count);

/* --- In double -------------------------------------------------------------------------------- */

static inline vectors vectors_of(const rk_triangle *triangle, const rk_ray *ray)
{
    rk_dvec3 a = rk_widen(triangle->a);
    return (vectors){.s = rk_dmadd(rk_widen(ray->origin), a, -1),
                     .ab = rk_dmadd(rk_widen(triangle->b), a, -1),
                     .ac = rk_dmadd(rk_widen(triangle->c), a, -1),
                     .direction = rk_widen(ray->direction)};
}

static inline determinants determinants_of(const vectors *x)
{
    /* solution */
    rk_dvec3 p = rk_dcross(x->direction, x->ac), q = rk_dcross(x->s, x->ab);
    double u = rk_ddot(x->s, p), v = rk_ddot(x->direction, q), det = rk_ddot(x->ab, p);
    return (determinants){.u = u, .v = v, .w = det - u - v, .t = rk_ddot(x->ac, q)};
    /* starter
    // The classic test, in float. First step: the same in double.
    rk_vec3 s = rk_vec((float)x->s.x, (float)x->s.y, (float)x->s.z);
    rk_vec3 ab = rk_vec((float)x->ab.x, (float)x->ab.y, (float)x->ab.z);
    rk_vec3 ac = rk_vec((float)x->ac.x, (float)x->ac.y, (float)x->ac.z);
    rk_vec3 d = rk_vec((float)x->direction.x, (float)x->direction.y, (float)x->direction.z);
    rk_vec3 p = rk_cross(d, ac), q = rk_cross(s, ab);
    float u = rk_dot(s, p), v = rk_dot(d, q), det = rk_dot(ab, p);
    return (determinants){(double)u, (double)v, (double)(det - u - v), (double)rk_dot(ac, q)};
    end */
}

/* Edges and corners belong to the triangle. A triangle without area has t / 0 or 0 / 0. */
static inline rk_hit hit_of(const determinants *m, uint32_t triangle)
{
    double det = m->u + m->v + m->w, sign = det < 0 ? -1 : 1, t = m->t / det;
    bool passes = m->u * sign >= 0 && m->v * sign >= 0 && m->w * sign >= 0 && det != 0;
    if (!(passes && t > 0 && t <= (double)FLT_MAX))
        return (rk_hit){INFINITY, 0, 0, RK_MISS};
    return (rk_hit){rk_max((float)t, FLT_TRUE_MIN), (float)(m->u / det), (float)(m->v / det),
                    triangle};
}

/* --- Sums ------------------------------------------------------------------------------------- */

/* a + b (Knuth): low is what rounding took from high. */
static pair two_sum(double a, double b)
{
    /* solution */
    double sum = a + b, b_in_sum = sum - a, a_in_sum = sum - b_in_sum;
    return (pair){sum, (a - a_in_sum) + (b - b_in_sum)};
    /* starter
    // Second step: what did rounding take from the sum?
    return (pair){a + b, 0};
    end */
}

/* Adds a number (Shewchuk's GROW-EXPANSION). */
static void add(exact_sum *sum, double x)
{
    /* solution */
    int kept = 0;
    for (int i = 0; i < sum->count; i++) {
        pair next = two_sum(x, sum->parts[i]);
        x = next.high;
        if (next.low != 0)
            sum->parts[kept++] = next.low;
    }
    if (x != 0)
        sum->parts[kept++] = x;
    sum->count = kept;
    /* starter
    // Second step. For now the sum is a single number, and rounded.
    sum->parts[0] = x + (sum->count ? sum->parts[0] : 0);
    sum->count = 1;
    end */
}

/* --- Exact determinants ----------------------------------------------------------------------- */

/* a . (b x c), rounded only in the end: sign and size are those of the exact number. */
static double triple_product(pair3 a, pair3 b, pair3 c)
{
    /* solution */
    exact_sum sum;
    sum.count = 0;
    add_product(&sum, a.x, b.y, c.z, 1);
    add_product(&sum, a.x, b.z, c.y, -1);
    add_product(&sum, a.y, b.z, c.x, 1);
    add_product(&sum, a.y, b.x, c.z, -1);
    add_product(&sum, a.z, b.x, c.y, 1);
    add_product(&sum, a.z, b.y, c.x, -1);
    double total = 0;
    for (int i = 0; i < sum.count; i++)
        total += sum.parts[i];
    return total;
    /* starter
    // Second step: six products, by add_product, and the sum of the sum's parts.
    return 0;
    end */
}

static pair3 difference(rk_vec3 a, rk_vec3 b)
{
    return (pair3){two_sum((double)a.x, -(double)b.x), two_sum((double)a.y, -(double)b.y),
                   two_sum((double)a.z, -(double)b.z)};
}

static determinants exact_determinants(const rk_triangle *triangle, const rk_ray *ray)
{
    /* solution */
    rk_vec3 a = triangle->a, b = triangle->b, c = triangle->c, origin = ray->origin;
    pair3 d = difference(ray->direction, rk_vec(0, 0, 0)), s = difference(origin, a);
    pair3 ab = difference(b, a), ac = difference(c, a);
    return (determinants){.u = triple_product(s, d, ac),
                          .v = triple_product(s, ab, d),
                          .w = triple_product(difference(origin, c), d, difference(b, c)),
                          .t = triple_product(ac, s, ab)};
    /* starter
    // Second step, by triple_product. w is the determinant of the edge from c to b as u is that of
    // the edge from a to c. For now those in double.
    const vectors x = vectors_of(triangle, ray);
    return determinants_of(&x);
    end */
}

/* --- Products --------------------------------------------------------------------------------- */

/* a b: a fused multiply-add rounds once, so it finds the error of a product. */
static pair two_product(double a, double b)
{
    /* solution */
    double product = a * b;
    return (pair){product, fma(a, b, -product)};
    /* starter
    // Third step: what did rounding take from the product?
    return (pair){a * b, 0};
    end */
}

/* Adds a b c times 1 or -1. */
static void add_product(exact_sum *sum, pair a, pair b, pair c, double sign)
{
    const double of_a[2] = {a.low, a.high}, of_b[2] = {b.low, b.high}, of_c[2] = {c.low, c.high};
    for (int i = 0; i < 8; i++) {
        double x = of_a[i & 1], y = of_b[i >> 1 & 1], z = sign * of_c[i >> 2];
        if (x == 0 || y == 0 || z == 0)
            continue;
        pair product = two_product(x, y);
        pair low = two_product(product.low, z), high = two_product(product.high, z);
        add(sum, low.low);
        add(sum, low.high);
        add(sum, high.low);
        add(sum, high.high);
    }
}

/* --- Is the sign certain? --------------------------------------------------------------------- */

static inline double larger(double a, double b)
{
    return a > b ? a : b;
}

static inline double smaller(double a, double b)
{
    return a < b ? a : b;
}

static inline double size_of(rk_dvec3 a)
{
    return fabs(a.x) + fabs(a.y) + fabs(a.z);
}

static inline double longest_of(rk_dvec3 a)
{
    return larger(fabs(a.x), larger(fabs(a.y), fabs(a.z)));
}

/* Is it certain that the exact ray hits, or that it misses? It is a miss if two determinants have
 * different signs beyond the bound of their errors; a hit or, behind the origin, a miss if all
 * three have the same sign, and t is not 0 within its own bound. */
static inline bool is_certain(const determinants *m, const vectors *x)
{
    /* solution */
    double edge = larger(size_of(x->ab), size_of(x->ac)), reach = size_of(x->s) + edge;
    double bound = 0x1p-48 * edge * reach * longest_of(x->direction);
    double lowest = smaller(m->u, smaller(m->v, m->w)), highest = larger(m->u, larger(m->v, m->w));
    if (lowest < -bound && highest > bound)
        return true;
    bool passes = lowest > bound || highest < -bound;
    return passes && fabs(m->t) > 0x1p-48 * edge * edge * reach;
    /* starter
    // Third step, when the exact numbers are right: until then they decide every time, slowly.
    // larger, smaller, size_of and longest_of are above.
    return false;
    end */
}

/* --- The decision ----------------------------------------------------------------------------- */

rk_hit rk_watertight_intersect(const rk_triangle *triangle, const rk_ray *ray)
{
    const vectors x = vectors_of(triangle, ray);
    determinants m = determinants_of(&x);
    if (!is_certain(&m, &x))
        m = exact_determinants(triangle, ray);
    return hit_of(&m, triangle->index);
}

bool rk_watertight_is_certain(const rk_triangle *triangle, const rk_ray *ray)
{
    const vectors x = vectors_of(triangle, ray);
    const determinants m = determinants_of(&x);
    return is_certain(&m, &x);
}

/* --- Crossings -------------------------------------------------------------------------------- */

/* The side of an edge on which a ray passes that is displaced by (e, e^2, e^3), for an e above 0
 * and below any number: if the ray passes through the edge, e decides, then e^2, then e^3. Their
 * factors are the components of direction x edge. */
static double side_when_displaced(double side, rk_vec3 from, rk_vec3 to, rk_vec3 direction)
{
    const rk_vec3 zero = {0, 0, 0}, axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    /* solution */
    for (int i = 0; i < 3 && side == 0; i++)
        side = triple_product(difference(axes[i], zero), difference(direction, zero),
                              difference(to, from));
    return side;
    /* starter
    // Fourth step: for now a ray through an edge crosses neither of its triangles.
    return side;
    end */
}

static int sign_of(double x)
{
    return (x > 0) - (x < 0);
}

int rk_watertight_cross(const rk_triangle *triangle, const rk_ray *ray, rk_hit *hit)
{
    const vectors x = vectors_of(triangle, ray);
    determinants m = determinants_of(&x);
    bool certain = is_certain(&m, &x);
    if (!certain)
        m = exact_determinants(triangle, ray);
    *hit = hit_of(&m, triangle->index);
    if (hit->triangle == RK_MISS || certain)
        return hit->triangle == RK_MISS ? 0 : sign_of(m.u);
    rk_vec3 a = triangle->a, b = triangle->b, c = triangle->c;
    int side = sign_of(side_when_displaced(m.u, a, c, ray->direction));
    bool crosses = sign_of(side_when_displaced(m.v, b, a, ray->direction)) == side &&
                   sign_of(side_when_displaced(m.w, c, b, ray->direction)) == side;
    return crosses ? side : 0;
}

/* --- A leaf's triangles, four at once --------------------------------------------------------- */

/* A bit for each triangle that the ray may hit up to t_max. Lanes without a triangle repeat the
 * last one. */
static inline uint32_t may_hit(const rk_ray *ray, float t_max, const rk_triangle *triangles,
                               uint32_t count)
{
    uint32_t last = count < 4 ? count - 1 : 3;
    rk_simd4 first[4], second[4], third[4];
    for (uint32_t i = 0; i < 4; i++) {
        const rk_triangle *triangle = &triangles[i < last ? i : last];
        first[i] = rk_simd4_load(&triangle->a.x);  /* a.x a.y a.z b.x */
        second[i] = rk_simd4_load(&triangle->b.y); /* b.y b.z c.x c.y */
        third[i] = rk_simd4_load(&triangle->b.z);  /* b.z c.x c.y c.z */
    }
    rk_simd4_transpose(first);
    rk_simd4_transpose(second);
    rk_simd4_transpose(third);
    rk_simd4x3 a = {first[0], first[1], first[2]};
    rk_simd4x3 ab = rk_simd4x3_sub((rk_simd4x3){first[3], second[0], second[1]}, a);
    rk_simd4x3 ac = rk_simd4x3_sub((rk_simd4x3){third[1], third[2], third[3]}, a);
    return rk_watertight_may_hit(
               rk_simd4x3_sub(rk_simd4x3_all(ray->origin), a), rk_simd4x3_all(ray->direction),
               rk_simd4_all(rk_watertight_longest(ray)), rk_simd4_all(t_max), ab, ac) &
           15u >> (3 - last);
}

void rk_triangles_closest(const rk_triangle *triangles, uint32_t count, const rk_ray *ray,
                          rk_hit *hit)
{
    for (uint32_t i = 0; i < count; i += 4) {
        uint32_t may = may_hit(ray, hit->t, &triangles[i], count - i);
        for (uint32_t k = i; may; k++, may >>= 1)
            if (may & 1)
                rk_triangle_closest(&triangles[k], ray, hit);
    }
}

uint32_t rk_triangles_first_hit(const rk_triangle *triangles, uint32_t count, const rk_ray *ray)
{
    for (uint32_t i = 0; i < count; i += 4) {
        uint32_t may = may_hit(ray, ray->t_max, &triangles[i], count - i);
        for (uint32_t k = i; may; k++, may >>= 1)
            if ((may & 1) && rk_triangle_occludes(&triangles[k], ray))
                return k;
    }
    return count;
}
