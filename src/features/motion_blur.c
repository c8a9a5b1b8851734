/* Distributed ray tracing over time (Cook, Porter, Carpenter, "Distributed ray tracing", SIGGRAPH
 * 1984): each ray sees the scene at a time of its own, and the mean over times is the blur. Instead
 * of the object the ray is moved, in the opposite direction; a box swept over the whole path tells
 * early which rays need no time. */
#include "features/motion_blur.h"

#include "base/sampler.h"

typedef struct range {
    double low, high;
} range;

/* Contents, in the order of the chapter. */
static double height_at(const rk_motion *motion, double x);
static float time_at(const rk_shutter *shutter, double fraction);
static void sweep_axis(float *low, float *high, range offset);
static range range_with(range r, double y);
static int turning_points(const rk_motion *motion, double x[2]);
static range heights(const rk_motion *motion, const rk_shutter *shutter);
static rk_box widened(const rk_box *box, const rk_box *by);
static rk_box rounding_margin(const rk_slabs *ray);
static bool may_enter(const rk_box *box, rk_box_sides by, const rk_slabs *ray, float t_max);

rk_motion rk_motion_default(void)
{
    return (rk_motion){-4, 0.5f, 1.5f};
}

/* --- The path --------------------------------------------------------------------------------- */

static double height_at(const rk_motion *motion, double x)
{
    /* solution */
    return (((double)motion->a * x + (double)motion->b) * x + (double)motion->c) * x;
    /* starter
    // First step: a x^3 + b x^2 + c x.
    return 0;
    end */
}

rk_vec3 rk_motion_offset(const rk_motion *motion, float x)
{
    /* solution */
    return rk_vec(x, (float)height_at(motion, (double)x), 0);
    /* starter
    // First step: (x, y(x), 0).
    return rk_vec(0, 0, 0);
    end */
}

/* Seen from an object that moves to the left, the world moves to the right. */
rk_ray rk_motion_ray(rk_vec3 offset, const rk_ray *ray)
{
    /* solution */
    return (rk_ray){rk_sub(ray->origin, offset), ray->direction, ray->t_max};
    /* starter
    // Second step: move the ray instead of the object.
    return *ray;
    end */
}

/* --- Times ------------------------------------------------------------------------------------ */

/* The time at a fraction of the shutter interval: 0 is where it opens, 1 where it closes. */
static float time_at(const rk_shutter *shutter, double fraction)
{
    double open = (double)shutter->open, close = (double)shutter->close;
    return (float)(open + fraction * (close - open));
}

float rk_shutter_equidistant(const rk_shutter *shutter, float k, uint32_t samples)
{
    /* solution */
    return time_at(shutter, ((double)k - 0.5) / samples);
    /* starter
    // Third step: the middle of part k of `samples`, counted from 1.
    return shutter->open;
    end */
}

float rk_shutter_time(const rk_shutter *shutter, rk_time_sampling sampling, uint32_t seed,
                      uint32_t pixel, uint32_t sample, uint32_t samples)
{
    /* solution */
    if (sampling == RK_TIME_EQUIDISTANT)
        return rk_shutter_equidistant(shutter, (float)(sample + 1), samples);
    const rk_sampler sampler = {.kind = sampling == RK_TIME_STRATIFIED ? RK_SAMPLER_UNIFORM
                                                                       : RK_SAMPLER_LOW_DISCREPANCY,
                                .seed = seed,
                                .samples = samples};
    double xi = (double)rk_sample_1d(&sampler, pixel, sample, RK_DIMENSION_TIME);
    return time_at(shutter, sampling == RK_TIME_STRATIFIED ? (sample + xi) / samples : xi);
    /* starter
    // Fourth step: rk_sample_1d of RK_DIMENSION_TIME is the fraction of the shutter or, where
    // sample i lies in part i, the fraction of that part.
    return shutter->open;
    end */
}

/* --- Swept boxes ------------------------------------------------------------------------------ */

/* Bounds the rounding error of a moved ray on one axis, relative to the terms of the sum: origin,
 * offset, corner. 1 eps, 2^-24, for the moved origin, 10 for the test of the box at rest (its
 * reciprocals are widened by 6, and it rounds three times, on either side); the sums that use this
 * bound round a few times more. Then doubled: a box that is too large by a few roundings costs
 * nothing. */
static const double rounding = 32 * 0x1p-24;

static void sweep_axis(float *low, float *high, range offset)
{
    double size =
        fmax(fabs((double)*low), fabs((double)*high)) + fmax(fabs(offset.low), fabs(offset.high));
    *low = (float)((double)*low + offset.low - rounding * size);
    *high = (float)((double)*high + offset.high + rounding * size);
}

rk_box rk_motion_sweep(const rk_motion *motion, const rk_shutter *shutter, const rk_box *rest)
{
    rk_box box = *rest;
    rk_vec3 *low = &box.corner[0], *high = &box.corner[1];
    /* solution */
    sweep_axis(&low->x, &high->x, (range){(double)shutter->open, (double)shutter->close});
    sweep_axis(&low->y, &high->y, heights(motion, shutter));
    sweep_axis(&low->z, &high->z, (range){0, 0});
    /* starter
    // Fifth step: sweep_axis widens each axis by the range of its offset.
    end */
    return box;
}

static range range_with(range r, double y)
{
    return (range){y < r.low ? y : r.low, y > r.high ? y : r.high};
}

/* Returns the number of the path's turning points, 0 or 2: the roots where 3 a x^2 + 2 b x + c
 * changes its sign. They are computed as q / 3a and c / q, which subtracts no numbers of one sign;
 * for a = 0 the first is at infinity. b^2 and 3 a c of floats are exact in double, so the sign of
 * the discriminant is right. Where it is 0 the path has a level point, but does not turn. */
static int turning_points(const rk_motion *motion, double x[2])
{
    /* solution */
    double a = (double)motion->a, b = (double)motion->b, c = (double)motion->c;
    double discriminant = b * b - 3 * a * c;
    if (!(discriminant > 0))
        return 0;
    double q = -(b + copysign(sqrt(discriminant), b));
    x[0] = q / (3 * a);
    x[1] = c / q;
    return 2;
    /* starter
    // Sixth step: the roots of y' = 3 a x^2 + 2 b x + c, also for a = 0.
    return 0;
    end */
}

/* Between two turning points a path only rises or only falls. */
static range heights(const rk_motion *motion, const rk_shutter *shutter)
{
    /* solution */
    double open = (double)shutter->open, close = (double)shutter->close, x[2];
    double first = height_at(motion, open);
    range y = range_with((range){first, first}, height_at(motion, close));
    int count = turning_points(motion, x);
    for (int i = 0; i < count; i++)
        if (x[i] > open && x[i] < close)
            y = range_with(y, height_at(motion, x[i]));
    /* Five roundings, of terms that may nearly cancel; and as many when the offset is computed. */
    double size = fmax(fabs(open), fabs(close));
    const rk_motion all = {fabsf(motion->a), fabsf(motion->b), fabsf(motion->c)};
    double error = 10 * 0x1p-53 * height_at(&all, size);
    return (range){y.low - error, y.high + error};
    /* starter
    // Fifth step: the lower and the higher end of the path. Sixth step: its turning points.
    return (range){0, 0};
    end */
}

/* --- Which rays need a time ------------------------------------------------------------------- */

/* The box with its corners moved by those of `by`. */
static rk_box widened(const rk_box *box, const rk_box *by)
{
    return (rk_box){{rk_add(box->corner[0], by->corner[0]), rk_add(box->corner[1], by->corner[1])}};
}

/* The margin for rounding errors that grow with the ray's own origin. */
static rk_box rounding_margin(const rk_slabs *ray)
{
    rk_vec3 margin = rk_scale(rk_abs3(ray->origin), (float)rounding);
    return (rk_box){{rk_negate(margin), margin}};
}

bool rk_motion_may_intersect(const rk_box *swept, const rk_slabs *ray, float t_max)
{
    /* solution */
    const rk_box margin = rounding_margin(ray), box = widened(swept, &margin);
    return rk_box_enter(&box, ray, t_max) < INFINITY;
    /* starter
    // Seventh step: does the ray enter (rk_box_enter) the box, widened by rounding_margin(ray)?
    return true;
    end */
}

/* Does the ray enter a box that is widened by these sides? In registers: to store the box and load
 * it again would take longer than the test. */
static bool may_enter(const rk_box *box, rk_box_sides by, const rk_slabs *ray, float t_max)
{
    const rk_box_sides sides = rk_box_sides_of(box, ray);
    const rk_box_sides wider = {sides.near + by.near, sides.far + by.far};
    return rk_box_sides_enter(wider, ray, t_max) < INFINITY;
}

/* All boxes of the tree move alike, so each grows by as much as the root's box did. */
bool rk_motion_may_intersect_leaf(const rk_bvh *bvh, const rk_box *swept, const rk_slabs *ray,
                                  float t_max)
{
    /* solution */
    const rk_box *root = &bvh->nodes[0].box;
    const rk_box sweep = {
        {rk_sub(swept->corner[0], root->corner[0]), rk_sub(swept->corner[1], root->corner[1])}};
    const rk_box margin = rounding_margin(ray), gain = widened(&sweep, &margin);
    const rk_box_sides by = rk_box_sides_of(&gain, ray);
    const rk_bvh_node *stack[RK_BVH_LEVELS_MAX];
    uint32_t size = 0;
    stack[size++] = &bvh->nodes[0];
    while (size) {
        const rk_bvh_node *node = stack[--size];
        if (!may_enter(&node->box, by, ray, t_max))
            continue;
        if (node->count)
            return true;
        stack[size++] = &bvh->nodes[node->first + 1];
        stack[size++] = &bvh->nodes[node->first];
    }
    return false;
    /* starter
    // Eighth step: traverse boxes that are widened like the root's (may_enter), down to the first
    // leaf.
    return true;
    end */
}
