/* Vectors, reflection, interpolation. */
#include "measure.h"

#include "base/interpolate.h"
#include "base/reflect.h"
#include "features/normals.h"

static double error_of_dot(const float *in)
{
    rk_vec3 a = vector_of(in), b = vector_of(in + 3);
    wide3 wa = widen3(a), wb = widen3(b);
    return error_in((wide)rk_dot(a, b), wide_dot(wa, wb), eps * wide_dot_size(wa, wb));
}

static double error_of_cross(const float *in)
{
    wide3 a = widen3(vector_of(in)), b = widen3(vector_of(in + 3));
    wide3 sizes = {fabsl(a.y * b.z) + fabsl(a.z * b.y), fabsl(a.z * b.x) + fabsl(a.x * b.z),
                   fabsl(a.x * b.y) + fabsl(a.y * b.x)};
    return error3_each(rk_cross(vector_of(in), vector_of(in + 3)), wide_cross(a, b),
                       wide_scale(sizes, eps));
}

static double error_of_length(const float *in)
{
    wide length = wide_length(widen3(vector_of(in)));
    return length > 0 ? error_in((wide)rk_length(vector_of(in)), length, eps * length)
                      : (double)NAN;
}

static double error_of_normalize(const float *in)
{
    wide3 v = widen3(vector_of(in));
    wide length = wide_length(v);
    if (!(length > 0))
        return (double)NAN;
    wide3 unit = wide_unit(v);
    wide3 sizes = {fabsl(unit.x), fabsl(unit.y), fabsl(unit.z)};
    return error3_each(rk_normalize(vector_of(in)), unit, wide_scale(sizes, eps));
}

static double error_of_mix(const float *in)
{
    wide a = (wide)in[0], b = (wide)in[1], t = (wide)in[2];
    rk_vec3 got = rk_mix(rk_vec(in[0], in[0], in[0]), rk_vec(in[1], in[1], in[1]), in[2]);
    return error_in((wide)got.x, a * (1 - t) + b * t, eps * (fabsl(a * (1 - t)) + fabsl(b * t)));
}

static double error_of_interpolation(const float *in)
{
    wide3 values = widen3(vector_of(in)), weights = widen3(vector_of(in + 3));
    rk_vec3 got = rk_interpolate3(rk_vec(in[0], in[0], in[0]), rk_vec(in[1], in[1], in[1]),
                                  rk_vec(in[2], in[2], in[2]), rk_vec(in[3], in[4], in[5]));
    return error_in((wide)got.x, wide_dot(values, weights), eps * wide_dot_size(values, weights));
}

static double error_of_reflection(const float *in)
{
    rk_vec3 n = direction_of(in + 3);
    if (n.x != n.x)
        return (double)NAN;
    wide3 d = widen3(vector_of(in)), wn = widen3(n);
    wide3 want = wide_madd(d, wn, -2 * wide_dot(d, wn));
    wide size = 2 * wide_dot_size(d, wn);
    wide3 sizes = {fabsl(d.x) + fabsl(wn.x) * size, fabsl(d.y) + fabsl(wn.y) * size,
                   fabsl(d.z) + fabsl(wn.z) * size};
    return error3_each(rk_reflect(vector_of(in), n), want, wide_scale(sizes, eps));
}

static double error_of_normals_colour(const float *in)
{
    rk_vec3 n = direction_of(in);
    wide3 want = {(1 + (wide)n.x) / 2, (1 + (wide)n.y) / 2, (1 + (wide)n.z) / 2};
    return n.x == n.x ? error3_in(rk_normals_colour(n), want, eps) : (double)NAN;
}

/* The differences of corners round once, which tilts a sliver; so the unit has its two edges over
 * the height between them. */
static double error_of_triangle_normal(const float *in)
{
    rk_vec3 a = vector_of(in), b = vector_of(in + 3), c = vector_of(in + 6);
    wide3 ab = wide_sub(widen3(b), widen3(a)), ac = wide_sub(widen3(c), widen3(a));
    wide3 across = wide_cross(ab, ac);
    wide area = wide_length(across);
    if (!(area > 0x1p-60L && area < 0x1p60L))
        return (double)NAN;
    wide size = wide_length(ab) * wide_length(ac);
    wide tilt = size / area;
    if (tilt > 0x1p20L)
        return (double)NAN;
    return error3_in(rk_normals_of_triangle(a, b, c), wide_unit(across), eps * tilt);
}

static const measure list[] = {
    {.routine = "rk_dot",
     .what = "error, eps times the sum of the terms' sizes",
     .error = error_of_dot,
     .domains = {{SIGNED, 6, -40, 40}},
     .bound = 3,
     .because = "a product and two sums",
     .reference = "long double"},
    {.routine = "rk_cross",
     .what = "error of a component, eps times the sum of its terms' sizes",
     .error = error_of_cross,
     .domains = {{SIGNED, 6, -40, 40}},
     .bound = 2,
     .because = "a product and a difference",
     .reference = "long double"},
    {.routine = "rk_length",
     .what = "relative error, eps",
     .error = error_of_length,
     .domains = {{SIGNED, 3, -60, 60}},
     .bound = 2.5,
     .because = "half of the squares' 3, and the root",
     .reference = "long double"},
    {.routine = "rk_normalize",
     .what = "relative error of a component, eps",
     .error = error_of_normalize,
     .domains = {{SIGNED, 3, -60, 60}},
     .bound = 4.5,
     .because = "the length's 2.5, the reciprocal and a product",
     .reference = "long double"},
    {.routine = "rk_mix",
     .what = "error, eps times the sum of the terms' sizes",
     .error = error_of_mix,
     .domains = {{SIGNED, 2, -40, 40}, {BETWEEN, 1, 0, 1}},
     .bound = 3,
     .because = "a difference, a product and a sum",
     .reference = "long double"},
    {.routine = "rk_interpolate3",
     .what = "error, eps times the sum of the terms' sizes",
     .error = error_of_interpolation,
     .domains = {{SIGNED, 3, -40, 40}, {BETWEEN, 3, 0, 1}},
     .bound = 3,
     .because = "a product and two sums",
     .reference = "long double"},
    {.routine = "rk_reflect",
     .what = "error of a component, eps times the sum of its terms' sizes",
     .error = error_of_reflection,
     .domains = {{SIGNED, 3, -20, 20}, {SIGNED, 3, -20, 1}},
     .bound = 5,
     .because = "the dot product's 3, a product and a sum",
     .reference = "long double"},
    {.routine = "rk_normals_colour",
     .what = "error of a channel, eps",
     .error = error_of_normals_colour,
     .domains = {{SIGNED, 3, -20, 1}},
     .bound = 0.5,
     .because = "halving is exact, the sum is at most 1",
     .reference = "long double"},
    {.routine = "rk_normals_of_triangle",
     .what = "error of a component, eps times edges over height",
     .error = error_of_triangle_normal,
     .domains = {{SIGNED, 9, -20, 20}},
     .bound = 8.5,
     .because = "two differences and 2 of the cross product, and 4.5 of the unit vector",
     .reference = "long double"},
};

const measures measures_of_vectors = {list, sizeof list / sizeof *list};
