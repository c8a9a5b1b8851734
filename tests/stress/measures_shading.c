/* Highlights, the gradient, ambient occlusion's closed forms. */
#include "measure.h"

#include "features/ambient_occlusion.h"
#include "features/shading.h"

/* --- Highlights ------------------------------------------------------------------------------- */

/* 1 - cosine of the angle between two vectors of any length. */
static wide short_of_one(wide3 a, wide3 b)
{
    wide3 apart = wide_sub(wide_unit(a), wide_unit(b));
    return wide_dot(apart, apart) / 2;
}

/* A lobe (1 - x)^s: vectors that are wrong by eps change x by sqrt(2x) eps, and the power by s / (1
 * - x) times that; the exponent s log(1 - x) is itself rounded. */
static double error_of_lobe(float s, wide x, float got)
{
    if (!(x < 1 - 0x1p-18L)) /* nearer to a right angle, x is not known well enough to divide by */
        return (double)NAN;
    wide exponent = (wide)s * log1pl(-x), want = expl(exponent);
    if (want < 0x1p-126L) /* denormal */
        return got <= 0x1p-125f ? 0 : (double)INFINITY;
    wide unit = 1 + (wide)s * (sqrtl(2 * x) + x) / (1 - x) - exponent;
    return error_in((wide)got, want, eps * unit * want);
}

/* Inputs: normal, light, viewer, the exponent of s. Viewers are near the mirror direction. */
static double error_of_highlight(const float *in, rk_shading_model model)
{
    const rk_shading shading = {.model = model};
    rk_vec3 n = direction_of(in), l = direction_of(in + 3), around = direction_of(in + 6);
    wide3 wn = widen3(n), wl = widen3(l);
    if (!(rk_dot(n, l) > 0) || around.x != around.x)
        return (double)NAN;
    wide3 mirrored = wide_madd(wide_scale(wl, -1), wn, 2 * wide_dot(wn, wl));
    wide3 wv = wide_unit(wide_madd(mirrored, widen3(around), (wide)in[9]));
    rk_vec3 v = rk_vec((float)wv.x, (float)wv.y, (float)wv.z);
    wide3 exact = widen3(v), half = {wl.x + exact.x, wl.y + exact.y, wl.z + exact.z};
    wide x = model == RK_SHADING_PHONG ? short_of_one(mirrored, exact) : short_of_one(wn, half);
    /* The half vector of nearly opposite directions is known less well. */
    if (model == RK_SHADING_BLINN_PHONG && wide_length(half) < 0.5L)
        return (double)NAN;
    float s = in[10];
    rk_vec3 got = rk_shade(&shading, rk_vec(0, 0, 0), rk_vec(1, 1, 1), s, n, l, v, rk_vec(1, 1, 1));
    return error_of_lobe(s, x, got.x);
}

static double error_of_phong(const float *in)
{
    return error_of_highlight(in, RK_SHADING_PHONG);
}

static double error_of_blinn_phong(const float *in)
{
    return error_of_highlight(in, RK_SHADING_BLINN_PHONG);
}

/* In the mirror direction along the normal the lobe and both cosines are 1. */
static double error_of_normalizer(float s, rk_shading_model model)
{
    const rk_shading shading = {.model = model, .normalized = true};
    const rk_vec3 up = {0, 0, 1}, black = {0, 0, 0}, white = {1, 1, 1};
    const wide pi = 3.14159265358979323846264338L;
    wide want = model == RK_SHADING_PHONG
                    ? ((wide)s + 2) / (2 * pi)
                    : ((wide)s + 2) * ((wide)s + 4) / (8 * pi * (exp2l(-(wide)s / 2) + (wide)s));
    rk_vec3 got = rk_shade(&shading, black, white, s, up, up, up, white);
    return error_in((wide)got.x, want, eps * want);
}

static double error_of_phong_normalizer(const float *in)
{
    return error_of_normalizer(in[0], RK_SHADING_PHONG);
}

static double error_of_blinn_phong_normalizer(const float *in)
{
    return error_of_normalizer(in[0], RK_SHADING_BLINN_PHONG);
}

static double error_of_lambert(const float *in)
{
    const rk_shading shading = {.model = RK_SHADING_LAMBERT, .normalized = true};
    rk_vec3 n = direction_of(in), l = direction_of(in + 3);
    wide cosine = wide_dot(widen3(n), widen3(l)), kd = (wide)in[6], light = (wide)in[7];
    wide size = wide_dot_size(widen3(n), widen3(l));
    if (n.x != n.x || l.x != l.x)
        return (double)NAN;
    rk_vec3 colour = rk_vec(in[6], in[6], in[6]);
    rk_vec3 got =
        rk_shade(&shading, colour, rk_vec(0, 0, 0), 1, n, l, n, rk_vec(in[7], in[7], in[7]));
    const wide pi = 3.14159265358979323846264338L;
    return error_in((wide)got.x, fmaxl(cosine, 0) * kd * light / pi, eps * size * kd * light / pi);
}

/* --- The gradient ----------------------------------------------------------------------------- */

static double error_of_gradient(const float *in)
{
    if (!(in[0] < in[1]) || !(in[2] >= in[0]) || !(in[2] < in[1]))
        return (double)NAN;
    const rk_gradient gradient = {2,
                                  {{in[0], {in[3], in[3], in[3]}}, {in[1], {in[4], in[4], in[4]}}}};
    wide t = ((wide)in[2] - (wide)in[0]) / ((wide)in[1] - (wide)in[0]);
    wide low = (wide)in[3] * (1 - t), high = (wide)in[4] * t;
    return error_in((wide)rk_gradient_at(&gradient, in[2]).x, low + high,
                    eps * (fabsl((wide)in[3]) + fabsl((wide)in[4])));
}

/* --- Ambient occlusion ------------------------------------------------------------------------ */

static double error_below_disk(const float *in)
{
    wide t = (wide)in[0] / (wide)in[1], want = 1 / (1 + t * t);
    return error_in((wide)rk_ambient_below_disk(in[0], in[1]), want, eps * want);
}

static double error_below_sphere(const float *in)
{
    if (!(in[1] > in[0]))
        return (double)NAN;
    wide sine = (wide)in[0] / (wide)in[1];
    return error_in((wide)rk_ambient_below_sphere(in[0], in[1], in[2]),
                    1 - (wide)in[2] * sine * sine, eps);
}

static double error_beside_wall(const float *in)
{
    wide t = (wide)in[0] / (wide)in[1], want = (1 + 1 / sqrtl(1 + t * t)) / 2;
    return error_in((wide)rk_ambient_beside_wall(in[0], in[1]), want, eps * want);
}

#define HIGHLIGHT_INPUTS                                                                           \
    {SIGNED, 9, -20, 1},                                                                           \
    {                                                                                              \
        BETWEEN, 1, -1, 1                                                                          \
    }
#define LOBE_REFERENCE "long double, the cosine by the distance of the exact directions"

static const measure list[] = {
    {.routine = "rk_shade: Phong",
     .what = "relative error of the lobe, eps (1 + s (sqrt(2x) + x) / (1 - x) + |s log(1 - x)|)",
     .error = error_of_phong,
     .domains = {HIGHLIGHT_INPUTS, {POSITIVE, 1, -10, 20}},
     .bound = 12,
     .because = "the mirror direction: 9 and the difference: 1; logarithm, product, power: 2",
     .reference = LOBE_REFERENCE},
    {.routine = "rk_shade: Blinn-Phong",
     .what = "relative error of the lobe, eps (1 + s (sqrt(2x) + x) / (1 - x) + |s log(1 - x)|)",
     .error = error_of_blinn_phong,
     .domains = {HIGHLIGHT_INPUTS, {POSITIVE, 1, -10, 20}},
     .bound = 12,
     .because = "the half vector: 1 and 4.5, over its length of 1/2 or more, and the difference: 1",
     .reference = LOBE_REFERENCE},
    {.routine = "rk_shade: Phong, normalized",
     .what = "relative error of N, eps",
     .error = error_of_phong_normalizer,
     .domains = {{POSITIVE, 1, -20, 120}},
     .bound = 3.5,
     .because = "a sum, pi, a quotient and a product with 1",
     .reference = "long double"},
    {.routine = "rk_shade: Blinn-Phong, normalized",
     .what = "relative error of N, eps",
     .error = error_of_blinn_phong_normalizer,
     .domains = {{POSITIVE, 1, -20, 120}},
     .bound = 8,
     .because = "three sums, pi, exp2f: 2, two quotients and a product",
     .reference = "long double"},
    {.routine = "rk_shade: Lambert",
     .what = "error, eps times the light and the sum of the cosine's terms",
     .error = error_of_lambert,
     .domains = {{SIGNED, 6, -20, 1}, {POSITIVE, 1, -20, 0}, {POSITIVE, 1, -20, 20}},
     .bound = 6.5,
     .because = "the cosine: 3, pi: 0.5, a quotient and two products",
     .reference = "long double"},
    {.routine = "rk_gradient_at",
     .what = "error, eps times the sum of the two colours",
     .error = error_of_gradient,
     .domains = {{SIGNED, 3, -120, 127}, {SIGNED, 2, -20, 20}},
     .bound = 3,
     .because = "the fraction, and rk_mix with products of at most the colours: a difference and "
                "two roundings",
     .reference = "long double"},
    {.routine = "rk_ambient_below_disk",
     .what = "relative error, eps",
     .error = error_below_disk,
     .domains = {{POSITIVE, 2, -30, 30}},
     .bound = 5,
     .because = "the tangent's square: 3, a sum and a quotient",
     .reference = "long double"},
    {.routine = "rk_ambient_below_sphere",
     .what = "error, eps",
     .error = error_below_sphere,
     .domains = {{POSITIVE, 2, -60, 60}, {BETWEEN, 1, 0, 1}},
     .bound = 4.5,
     .because = "a quotient, twice, two products, and the difference from 1: 0.5",
     .reference = "long double"},
    {.routine = "rk_ambient_beside_wall",
     .what = "relative error, eps",
     .error = error_beside_wall,
     .domains = {{POSITIVE, 2, -60, 60}},
     .bound = 3,
     .because = "the cosine: 2 and two roundings, of which half counts, and a sum",
     .reference = "long double"},
};

const measures measures_of_shading = {list, sizeof list / sizeof *list};
