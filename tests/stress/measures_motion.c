/* Paths, times and swept boxes of moving objects. */
#include "measure.h"

#include "features/motion_blur.h"

static wide height(const rk_motion *motion, wide x)
{
    return x * ((wide)motion->c + x * ((wide)motion->b + x * (wide)motion->a));
}

/* Inputs: the path, a time. Double rounds five terms that may cancel. */
static double error_of_offset(const float *in)
{
    const rk_motion motion = {in[0], in[1], in[2]};
    wide x = (wide)in[3], want = height(&motion, x);
    const rk_motion sizes = {fabsf(in[0]), fabsf(in[1]), fabsf(in[2])};
    rk_vec3 got = rk_motion_offset(&motion, in[3]);
    return error_in((wide)got.y, want, eps * fabsl(want) + 0x1p-50L * height(&sizes, fabsl(x)));
}

static double error_of_equidistant_time(const float *in)
{
    const rk_shutter shutter = {in[0], in[1]};
    wide open = (wide)in[0], close = (wide)in[1];
    unsigned samples = (unsigned)in[2], k = 1 + (unsigned)((float)samples * in[3]);
    wide want = open + ((wide)k - 0.5L) / samples * (close - open);
    return open <= close ? error_in((wide)rk_shutter_equidistant(&shutter, (float)k, samples), want,
                                    eps * fabsl(want) + 0x1p-50L * (fabsl(open) + fabsl(close)))
                         : (double)NAN;
}

/* Random times of every kind stay within the shutter. */
static double outside_of_shutter(const float *in)
{
    const rk_shutter shutter = {in[0], in[1]};
    unsigned samples = (unsigned)in[2], sample = (unsigned)((float)samples * in[3]);
    if (!(in[0] <= in[1]) || sample >= samples)
        return (double)NAN;
    double worst = (double)-INFINITY;
    for (int sampling = RK_TIME_EQUIDISTANT; sampling <= RK_TIME_LOW_DISCREPANCY; sampling++) {
        float x = rk_shutter_time(&shutter, (rk_time_sampling)sampling, 7, (uint32_t)in[4], sample,
                                  samples);
        double beyond = fmax((double)in[0] - (double)x, (double)x - (double)in[1]);
        worst = fmax(worst, x == x ? beyond : (double)INFINITY);
    }
    return worst;
}

typedef struct moving {
    rk_motion motion;
    rk_shutter shutter;
    rk_box rest;
    float time; /* while the shutter is open */
} moving;

static bool move(const float *in, moving *m)
{
    *m = (moving){{in[0], in[1], in[2]}, {in[3], in[4]}, rk_box_empty(), 0};
    m->rest = rk_box_add(rk_box_add(m->rest, vector_of(in + 5)), vector_of(in + 8));
    m->time = in[3] + (in[4] - in[3]) * in[11];
    return in[3] <= in[4] && m->time >= in[3] && m->time <= in[4];
}

/* How far beyond the swept box is the box at that time, in units of the box's size? */
static double outside_of_sweep(const float *in)
{
    moving m;
    if (!move(in, &m))
        return (double)NAN;
    const rk_box swept = rk_motion_sweep(&m.motion, &m.shutter, &m.rest);
    rk_vec3 offset = rk_motion_offset(&m.motion, m.time);
    wide worst = -(wide)INFINITY;
    for (int k = 0; k < 3; k++) {
        wide low = (wide)rk_axis(m.rest.corner[0], k) + (wide)rk_axis(offset, k);
        wide high = (wide)rk_axis(m.rest.corner[1], k) + (wide)rk_axis(offset, k);
        wide size = fabsl(low) + fabsl(high) + 0x1p-100L;
        worst = fmaxl(worst, ((wide)rk_axis(swept.corner[0], k) - low) / size);
        worst = fmaxl(worst, (high - (wide)rk_axis(swept.corner[1], k)) / size);
    }
    return worst == worst ? (double)worst : (double)INFINITY;
}

/* Inputs from 12 on: a ray's origin, and the place in the moved box that it aims at. */
static double lost_by_sweep(const float *in)
{
    moving m;
    if (!move(in, &m))
        return (double)NAN;
    const rk_box swept = rk_motion_sweep(&m.motion, &m.shutter, &m.rest);
    rk_vec3 offset = rk_motion_offset(&m.motion, m.time), origin = vector_of(in + 12);
    rk_vec3 place = rk_add(m.rest.corner[0], rk_mul(rk_box_extent(m.rest), vector_of(in + 15)));
    rk_ray ray = {origin, rk_sub(rk_add(place, offset), origin), INFINITY};
    rk_ray moved = rk_motion_ray(offset, &ray);
    rk_slabs slabs = rk_slabs_of(&ray), moved_slabs = rk_slabs_of(&moved);
    if (!(rk_box_enter(&m.rest, &moved_slabs, INFINITY) < INFINITY))
        return (double)NAN;
    if (!rk_motion_may_intersect(&swept, &slabs, INFINITY))
        return (double)INFINITY;
    /* The less time a ray has in the swept box, the nearer to being lost. */
    float enter = rk_box_enter(&swept, &slabs, INFINITY),
          leave = rk_box_leave(&swept, &slabs, INFINITY);
    return -1e-30 - ((double)leave - (double)enter) / (double)leave;
}

#define MOVING_INPUTS                                                                              \
    {SIGNED, 3, -10, 10}, {SIGNED, 2, -8, 4}, {SIGNED, 6, -10, 10},                                \
    {                                                                                              \
        BETWEEN, 1, 0, 1                                                                           \
    }

static const measure list[] = {
    {.routine = "rk_motion_offset",
     .what = "error, eps of it and 2^-50 of the sum of its terms",
     .error = error_of_offset,
     .domains = {{SIGNED, 4, -20, 20}},
     .bound = 1,
     .because = "rounded once, from double",
     .reference = "long double"},
    {.routine = "rk_shutter_equidistant",
     .what = "error, eps of it and 2^-50 of the shutter's times",
     .error = error_of_equidistant_time,
     .domains = {{SIGNED, 2, -40, 40}, {BETWEEN, 1, 1, 100000}, {FRACTION, 1, 0, 1}},
     .bound = 1,
     .because = "rounded once, from double",
     .reference = "long double"},
    {.routine = "rk_shutter_time",
     .what = "times before the shutter opens or after it closes",
     .error = outside_of_shutter,
     .domains = {{SIGNED, 2, -40, 40},
                 {BETWEEN, 1, 1, 100000},
                 {FRACTION, 1, 0, 1},
                 {BETWEEN, 1, 0, 100000}},
     .bound = 0,
     .because = "a fraction in [0, 1) of the shutter, rounded",
     .reference = "the shutter"},
    {.routine = "rk_motion_sweep",
     .what = "how far a moved box sticks out of the swept one",
     .error = outside_of_sweep,
     .domains = {MOVING_INPUTS},
     .bound = 0,
     .because = "the extremes of the path, and 2^-19 of its size more",
     .reference = "long double, at times while the shutter is open"},
    {.routine = "rk_motion_may_intersect",
     .what = "rays lost that enter the moved box",
     .error = lost_by_sweep,
     .domains = {MOVING_INPUTS, {SIGNED, 3, -10, 10}, {BETWEEN, 3, 0, 1}},
     .bound = 0,
     .because = "the swept box is larger by all roundings of both tests",
     .reference = "rk_box_enter of the moved ray"},
};

const measures measures_of_motion = {list, sizeof list / sizeof *list};
