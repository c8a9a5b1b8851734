/* A measure: how far a routine's result may be from the true one, as a function of its inputs.
 * search.c looks for the inputs with the largest error, which is then compared with a bound that
 * was derived beforehand, from the roundings of the routine (Higham, "Accuracy and Stability of
 * Numerical Algorithms", 2002, chapters 2 and 3; eps = 2^-24 is the unit roundoff of float). */
#ifndef RK_TESTS_STRESS_MEASURE_H
#define RK_TESTS_STRESS_MEASURE_H

#include "base/vec3.h"

#include <stdbool.h>
#include <stddef.h>

enum { INPUTS_MAX = 24, DOMAINS_MAX = 12 };

/* The values that `count` successive inputs may take. */
typedef struct domain {
    enum {
        SIGNED = 1, /* 0 and -0, or of either sign, of a size from 2^low to 2^high */
        POSITIVE,   /* from 2^low to 2^high */
        BETWEEN,    /* from low to high, mostly evenly distributed */
        FRACTION,   /* multiples of 2^-24 in [0, 1), as samplers give them */
    } kind;
    unsigned count;
    float low, high;
} domain;

typedef struct measure {
    const char *routine;
    const char *what; /* the error and its unit */
    /* Returns the error in this unit; infinity for an answer that must not be; NaN where the inputs
     * are none that the measure is about. Below 0 there is no error: the number only tells a search
     * how near one is. */
    double (*error)(const float *in);
    domain domains[DOMAINS_MAX]; /* of successive inputs; the rest is zeroed */
    double bound;
    const char *because;   /* of which roundings the bound consists */
    const char *reference; /* how the true result is computed */
    const char *slack;     /* why the bound may be far above the largest error found, or NULL */
    unsigned cost;         /* the search tries fewer inputs by this factor; 0 is 1 */
} measure;

/* A bound that is more often than that above the error found says nothing. */
#define SLACK_MAX 8.0

typedef struct measures {
    const measure *list;
    size_t count;
} measures;

extern const measures measures_of_vectors, measures_of_rays, measures_of_surfaces,
    measures_of_shading, measures_of_lights, measures_of_samples, measures_of_camera,
    measures_of_motion, measures_of_pictures, measures_of_transparency;

unsigned measure_input_count(const measure *m);

typedef struct finding {
    double error; /* the largest one found */
    float input[INPUTS_MAX];
    unsigned long tried;
} finding;

/* Searches with about this many trials; the same ones at each call. */
finding search_for_worst(const measure *m, unsigned long trials);

/* --- For measures: wide numbers --------------------------------------------------------------- */

typedef long double wide;

typedef struct wide3 {
    wide x, y, z;
} wide3;

static const wide eps = 0x1p-24L;

static inline wide3 widen3(rk_vec3 v)
{
    return (wide3){(wide)v.x, (wide)v.y, (wide)v.z};
}

static inline wide3 wide_madd(wide3 a, wide3 b, wide s)
{
    return (wide3){a.x + b.x * s, a.y + b.y * s, a.z + b.z * s};
}

static inline wide3 wide_sub(wide3 a, wide3 b)
{
    return wide_madd(a, b, -1);
}

static inline wide3 wide_scale(wide3 a, wide s)
{
    return (wide3){a.x * s, a.y * s, a.z * s};
}

static inline wide wide_dot(wide3 a, wide3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

/* The sum of the sizes of a dot product's terms. */
static inline wide wide_dot_size(wide3 a, wide3 b)
{
    return fabsl(a.x * b.x) + fabsl(a.y * b.y) + fabsl(a.z * b.z);
}

static inline wide3 wide_cross(wide3 a, wide3 b)
{
    return (wide3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline wide wide_length(wide3 a)
{
    return sqrtl(wide_dot(a, a));
}

static inline wide3 wide_unit(wide3 a)
{
    return wide_scale(a, 1 / wide_length(a));
}

static inline wide wide_max3(wide a, wide b, wide c)
{
    return fmaxl(a, fmaxl(b, c));
}

static inline rk_vec3 vector_of(const float *in)
{
    return rk_vec(in[0], in[1], in[2]);
}

/* The direction of three inputs as a unit vector, rounded once; NaN for zeros. */
static inline rk_vec3 direction_of(const float *in)
{
    wide3 unit = wide_unit(widen3(vector_of(in)));
    return rk_vec((float)unit.x, (float)unit.y, (float)unit.z);
}

/* |got - want| in units; infinity if got is NaN. No unit is smaller than the smallest float. */
static inline double error_in(wide got, wide want, wide unit)
{
    if (got != got)
        return (double)INFINITY;
    if (got == want)
        return 0;
    return (double)(fabsl(got - want) / fmaxl(unit, 0x1p-149L));
}

/* The largest of three components' errors, all in the same unit. */
static inline double error3_in(rk_vec3 got, wide3 want, wide unit)
{
    return fmax(error_in((wide)got.x, want.x, unit),
                fmax(error_in((wide)got.y, want.y, unit), error_in((wide)got.z, want.z, unit)));
}

/* The largest of three components' errors, each in its own unit. */
static inline double error3_each(rk_vec3 got, wide3 want, wide3 unit)
{
    return fmax(error_in((wide)got.x, want.x, unit.x),
                fmax(error_in((wide)got.y, want.y, unit.y), error_in((wide)got.z, want.z, unit.z)));
}

#endif
