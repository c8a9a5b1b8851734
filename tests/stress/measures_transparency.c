/* Transmittance of shadow rays, and weights of view rays. */
#include "measure.h"

#include "features/transparency.h"

#include <float.h>

enum { SURFACES = 4 };

/* Inputs: for each surface its t, alpha and colour; surfaces 0 and 1 belong to medium 0, the
 * others to medium 1. */
static bool crossings_of(const float *in, rk_crossing crossings[SURFACES])
{
    for (unsigned k = 0; k < SURFACES; k++) {
        float kd = in[2 * SURFACES + k];
        crossings[k] = (rk_crossing){.t = in[k],
                                     .primitive = k,
                                     .medium = k / 2,
                                     .entering = k % 2 == 0,
                                     .alpha = in[SURFACES + k],
                                     .kd = rk_vec(kd, kd, kd)};
        if (crossings[k].alpha >= 1 || (k > 0 && !(in[k] > in[k - 1])))
            return false;
    }
    return true;
}

static double error_of_multiplicative(const float *in)
{
    rk_crossing c[SURFACES];
    wide want = 1;
    if (!crossings_of(in, c))
        return (double)NAN;
    for (int k = 0; k < SURFACES; k++)
        want *= (wide)c[k].kd.x * (1 - (wide)c[k].alpha);
    rk_vec3 got = rk_transparency_transmit(RK_GLASS_MULTIPLICATIVE, c, SURFACES, 1);
    return want > 0x1p-100L ? error_in((wide)got.x, want, eps * want) : (double)NAN;
}

static double error_of_ordered(const float *in)
{
    rk_crossing c[SURFACES];
    wide want = 1;
    if (!crossings_of(in, c))
        return (double)NAN;
    /* From the light to the point: each surface over all behind it. */
    for (int k = SURFACES - 1; k >= 0; k--)
        want = (wide)c[k].kd.x * (wide)c[k].alpha + (1 - (wide)c[k].alpha) * want;
    rk_vec3 got = rk_transparency_transmit(RK_GLASS_ORDERED, c, SURFACES, 1);
    return error_in((wide)got.x, want, eps * want);
}

static double error_of_beer_lambert(const float *in)
{
    rk_crossing c[SURFACES];
    if (!crossings_of(in, c))
        return (double)NAN;
    const float length = in[3 * SURFACES + 2];
    wide depth = 0;
    for (unsigned k = 0; k < SURFACES; k++)
        c[k].absorption.x = in[3 * SURFACES + k / 2];
    for (unsigned k = 0; k < SURFACES; k += 2)
        depth += (wide)c[k].absorption.x * ((wide)c[k + 1].t - (wide)c[k].t) * (wide)length;
    wide want = expl(-depth);
    rk_vec3 got = rk_transparency_transmit(RK_GLASS_BEER_LAMBERT, c, SURFACES, length);
    if (want < (wide)FLT_MIN)
        return got.x <= FLT_MIN * 1.0001f ? 0 : (double)INFINITY;
    return error_in((wide)got.x, want, eps * want * (1 + depth));
}

static double error_of_weights(const float *in)
{
    rk_crossing c[SURFACES];
    float weights[SURFACES], transmittance;
    if (!crossings_of(in, c))
        return (double)NAN;
    rk_transparency_weights(c, SURFACES, weights, &transmittance);
    wide sum = (wide)transmittance;
    for (int k = 0; k < SURFACES; k++)
        sum += (wide)weights[k];
    return error_in(sum, 1, eps);
}

#define SURFACE_INPUTS                                                                             \
    {BETWEEN, SURFACES, 0, 1}, {BETWEEN, SURFACES, 0, 1},                                          \
    {                                                                                              \
        BETWEEN, SURFACES, 0, 1                                                                    \
    }

static const measure list[] = {
    {.routine = "rk_transparency_transmit: multiplicative",
     .what = "relative error behind 4 surfaces, eps",
     .error = error_of_multiplicative,
     .domains = {SURFACE_INPUTS},
     .bound = 11,
     .because = "a difference and two products for each surface; the first product is exact",
     .reference = "long double"},
    {.routine = "rk_transparency_transmit: ordered",
     .what = "relative error behind 4 surfaces, eps",
     .error = error_of_ordered,
     .domains = {SURFACE_INPUTS},
     .bound = 9,
     .because = "a difference and a product for each surface, and a sum",
     .reference = "long double, from the light to the point"},
    {.routine = "rk_transparency_transmit: Beer-Lambert",
     .what = "relative error through 2 blocks, eps (1 + optical depth)",
     .error = error_of_beer_lambert,
     .domains = {SURFACE_INPUTS, {POSITIVE, 2, -20, 20}, {POSITIVE, 1, -20, 20}},
     .bound = 5,
     .because = "a difference, two products and two sums in the depth, less the power: 1",
     .reference = "long double"},
    {.routine = "rk_transparency_weights",
     .what = "sum of the weights of 4 surfaces, above or below 1, eps",
     .error = error_of_weights,
     .domains = {SURFACE_INPUTS},
     .bound = 8,
     .because = "a product and, for the next, a difference and a product of each surface",
     .reference = "long double"},
};

const measures measures_of_transparency = {list, sizeof list / sizeof *list};
