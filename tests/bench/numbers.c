#include "numbers.h"

#include "base/random.h"
#include "base/reflect.h"
#include "features/parallelogram_light.h"
#include "features/shading.h"
#include "features/watertight.h"

#include <stdio.h>

enum { INPUTS = 200000 };

static float unit(uint32_t input, uint32_t dimension)
{
    return rk_unit_float(rk_hash(input, dimension, 0, 1));
}

/* A point of the cube from -1 to 1. */
static rk_vec3 point(uint32_t input, uint32_t dimension)
{
    return rk_vec(2 * unit(input, dimension) - 1, 2 * unit(input, dimension + 1) - 1,
                  2 * unit(input, dimension + 2) - 1);
}

/* The values of one input; NaN if the function doesn't apply to it. */
typedef struct values {
    double exact, ours, plain;
} values;

static const values none = {NAN, NAN, NAN};

/* --- the distance to a triangle -------------------------------------------------------------- */

static values distance_to_triangle(uint32_t input)
{
    rk_vec3 a = point(input, 0), b = point(input, 3), c = point(input, 6);
    rk_vec3 ab = rk_sub(b, a), ac = rk_sub(c, a);
    rk_vec3 origin = rk_scale(point(input, 9), 4);
    float u = unit(input, 12), v = (1 - u) * unit(input, 13);
    rk_vec3 target = rk_madd(rk_madd(a, ab, u), ac, v);
    const rk_triangle triangle = {a, b, c, 0};
    const rk_ray ray = {origin, rk_normalize(rk_sub(target, origin)), INFINITY};
    rk_hit hit = rk_watertight_intersect(&triangle, &ray);
    if (hit.triangle == RK_MISS)
        return none;
    rk_dvec3 d = rk_widen(ray.direction), corner = rk_widen(a);
    rk_dvec3 e = rk_dmadd(rk_widen(b), corner, -1), f = rk_dmadd(rk_widen(c), corner, -1);
    rk_dvec3 s = rk_dmadd(rk_widen(origin), corner, -1), q = rk_dcross(s, e);
    double exact = rk_ddot(f, q) / rk_ddot(e, rk_dcross(d, f));
    /* The other common way: the plane's normal first. */
    rk_vec3 n = rk_cross(ab, ac);
    float plain = rk_dot(rk_sub(a, origin), n) / rk_dot(ray.direction, n);
    return (values){exact, (double)hit.t, (double)plain};
}

/* --- irradiance ------------------------------------------------------------------------------ */

/* Lambert's sum over the edges of a polygon above the horizon. The macro's two expansions differ in
 * the type of numbers only. */
#define LAMBERT(name, number, vector, subtract, dot, cross, root, arc)                             \
    static number name(const vector corner[4], vector at, vector normal)                           \
    {                                                                                              \
        number sum = 0;                                                                            \
        for (int i = 0; i < 4; i++) {                                                              \
            vector r = subtract(corner[i], at), s = subtract(corner[(i + 1) % 4], at);             \
            vector n = cross(r, s);                                                                \
            number length = root(dot(n, n));                                                       \
            number cosine = dot(r, s) / root(dot(r, r) * dot(s, s));                               \
            sum += arc(cosine) * dot(normal, n) / length;                                          \
        }                                                                                          \
        return sum / 2;                                                                            \
    }

static rk_dvec3 dsub(rk_dvec3 a, rk_dvec3 b)
{
    return rk_dmadd(a, b, -1);
}

LAMBERT(lambert_float, float, rk_vec3, rk_sub, rk_dot, rk_cross, sqrtf, acosf)
LAMBERT(lambert_double, double, rk_dvec3, dsub, rk_ddot, rk_dcross, sqrt, acos)

/* A unit square, seen from 1 to 100 units below. */
static values irradiance(uint32_t input)
{
    rk_vec3 at = rk_vec(2 * unit(input, 0) - 1, -powf(100, unit(input, 1)), 2 * unit(input, 2) - 1);
    const rk_light light = {.kind = RK_LIGHT_PARALLELOGRAM,
                            .position = rk_vec(-0.5f, 0, -0.5f),
                            .edge01 = rk_vec(1, 0, 0),
                            .edge02 = rk_vec(0, 0, 1)};
    const rk_vec3 corners[4] = {
        {-0.5f, 0, -0.5f}, {0.5f, 0, -0.5f}, {0.5f, 0, 0.5f}, {-0.5f, 0, 0.5f}};
    rk_dvec3 wide[4];
    for (int i = 0; i < 4; i++)
        wide[i] = rk_widen(corners[i]);
    rk_vec3 up = rk_vec(0, 1, 0);
    return (values){fabs(lambert_double(wide, rk_widen(at), rk_widen(up))),
                    (double)rk_light_irradiance(&light, at, up),
                    (double)fabsf(lambert_float(corners, at, up))};
}

/* --- a highlight ----------------------------------------------------------------------------- */

/* Phong's lobe of shininess 10,000, where it is at least a thousandth of its maximum. */
static values highlight(uint32_t input)
{
    const float shininess = 1e4f;
    rk_vec3 n = rk_normalize(point(input, 0)), l = rk_normalize(point(input, 3));
    if (!(rk_dot(n, l) > 0.05f))
        return none;
    rk_vec3 r = rk_sub(rk_scale(n, 2 * rk_dot(n, l)), l);
    rk_vec3 v = rk_normalize(rk_madd(r, point(input, 6), 0.02f));
    const rk_shading shading = {.model = RK_SHADING_PHONG};
    rk_vec3 one = rk_vec(1, 1, 1), black = rk_vec(0, 0, 0);
    rk_dvec3 wn = rk_widen(n), wl = rk_widen(l), wv = rk_widen(v);
    wn = rk_dscale(wn, 1 / rk_dlength(wn));
    rk_dvec3 wr = rk_dmadd(rk_dscale(wl, -1), wn, 2 * rk_ddot(wn, wl));
    double exact = pow(rk_ddot(wr, wv) / (rk_dlength(wr) * rk_dlength(wv)), (double)shininess);
    if (!(exact > 1e-3))
        return none;
    return (values){exact, (double)rk_shade(&shading, black, one, shininess, n, l, v, one).x,
                    (double)powf(rk_dot(r, v), shininess)};
}

/* --- all ------------------------------------------------------------------------------------- */

static void print_one(const char *name, values (*at)(uint32_t input))
{
    double largest[2] = {0}, squares[2] = {0};
    uint32_t count = 0;
    for (uint32_t input = 0; input < INPUTS; input++) {
        values v = at(input);
        if (isnan(v.exact))
            continue;
        const double errors[2] = {fabs(v.ours / v.exact - 1), fabs(v.plain / v.exact - 1)};
        count++;
        for (int i = 0; i < 2; i++) {
            largest[i] = fmax(largest[i], errors[i]);
            squares[i] += errors[i] * errors[i];
        }
    }
    printf("%s,%u,%.4g,%.4g,%.4g,%.4g\n", name, count, largest[0], sqrt(squares[0] / count),
           largest[1], sqrt(squares[1] / count));
}

void numbers_print(void)
{
    print_one("distance to a triangle", distance_to_triangle);
    print_one("irradiance of a square", irradiance);
    print_one("highlight of shininess 10 000", highlight);
}
