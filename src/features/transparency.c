/* A ray crosses transparent surfaces; in which order, and how do their colours combine? The list of
 * crossings is kept sorted, then reduced: by alpha blending for view rays (Porter and Duff,
 * "Compositing digital images", SIGGRAPH 1984), by one of three models for shadow rays
 * (Beer-Lambert: Glassner, "Principles of Digital Image Synthesis", 1995, volume 2). */
#include "features/transparency.h"

#include <math.h>

/* Contents, in the order of the chapter. */
static bool is_opaque(const rk_crossing *crossing);
static bool comes_before(const rk_crossing *a, const rk_crossing *b);
static rk_vec3 multiplicative(const rk_crossing *crossings, uint32_t count);
static rk_vec3 ordered(const rk_crossing *crossings, uint32_t count);
static rk_vec3 beer_lambert(const rk_crossing *crossings, uint32_t count, float length);
static bool is_first_of_its_medium(const rk_crossing *crossings, uint32_t k);
static int step_into(const rk_crossing *crossing, uint32_t medium);
static float fraction_inside(const rk_crossing *crossings, uint32_t count, uint32_t medium);
static int depth_at_start(const rk_crossing *crossings, uint32_t count, uint32_t medium);

/* --- The list --------------------------------------------------------------------------------- */

static bool is_opaque(const rk_crossing *crossing)
{
    return crossing->alpha >= 1;
}

static bool comes_before(const rk_crossing *a, const rk_crossing *b)
{
    return a->t < b->t || (a->t == b->t && a->primitive < b->primitive);
}

/* Lists are short: insertion from the far end moves only the crossings behind the new one. */
void rk_transparency_insert(rk_crossing_list *list, const rk_crossing *crossing)
{
    /* solution */
    uint32_t place = list->count;
    while (place > 0 && comes_before(crossing, &list->crossings[place - 1]))
        place--;
    if (place == list->limit || (place > 0 && is_opaque(&list->crossings[place - 1])))
        return;
    if (is_opaque(crossing))
        list->count = place;
    else if (list->count == list->limit)
        list->count--;
    for (uint32_t i = list->count; i > place; i--)
        list->crossings[i] = list->crossings[i - 1];
    list->crossings[place] = *crossing;
    list->count++;
    /* starter
    // First step: keep the nearest `limit` crossings, in order, and none behind an opaque one.
    // Until then only the nearest is kept, and is drawn as if it were opaque.
    if (list->count == 0 || crossing->t < list->crossings[0].t)
        list->crossings[0] = *crossing;
    list->count = 1;
    end */
}

float rk_transparency_end(const rk_crossing_list *list, float t_max)
{
    /* solution */
    if (list->count == 0)
        return t_max;
    const rk_crossing *last = &list->crossings[list->count - 1];
    return list->count == list->limit || is_opaque(last) ? last->t : t_max;
    /* starter
    // First step: crossings behind a full list, or behind an opaque one, need not be found.
    return t_max;
    end */
}

/* --- View rays -------------------------------------------------------------------------------- */

void rk_transparency_weights(const rk_crossing *crossings, uint32_t count, float *weights,
                             float *transmittance)
{
    /* solution */
    float transmitted = 1; /* prod (1 - alpha_j), j < k */
    for (uint32_t k = 0; k < count; k++) {
        weights[k] = crossings[k].alpha * transmitted;
        transmitted *= 1 - crossings[k].alpha;
    }
    *transmittance = transmitted;
    /* starter
    // Second step: a surface counts by its alpha, all behind it by 1 - alpha.
    // Until then each surface counts in full, and the background is seen only beside them.
    for (uint32_t k = 0; k < count; k++)
        weights[k] = 1;
    *transmittance = count == 0;
    end */
}

/* --- Shadow rays ------------------------------------------------------------------------------ */

rk_vec3 rk_transparency_transmit(rk_glass_model model, const rk_crossing *crossings, uint32_t count,
                                 float length)
{
    for (uint32_t k = 0; k < count; k++)
        if (is_opaque(&crossings[k]))
            return rk_vec(0, 0, 0);
    switch (model) {
    case RK_GLASS_MULTIPLICATIVE:
        return multiplicative(crossings, count);
    case RK_GLASS_ORDERED:
        return ordered(crossings, count);
    case RK_GLASS_BEER_LAMBERT:
        return beer_lambert(crossings, count, length);
    }
    return rk_vec(0, 0, 0);
}

static rk_vec3 multiplicative(const rk_crossing *crossings, uint32_t count)
{
    /* solution */
    rk_vec3 transmittance = rk_vec(1, 1, 1);
    for (uint32_t k = 0; k < count; k++)
        transmittance = rk_mul(transmittance, rk_scale(crossings[k].kd, 1 - crossings[k].alpha));
    return transmittance;
    /* starter
    // Third step: prod kd (1 - alpha).
    // Until then all light passes, as if glass were clear.
    return rk_vec(1, 1, 1);
    end */
}

/* The colour of a white light, seen from the point through the surfaces. */
static rk_vec3 ordered(const rk_crossing *crossings, uint32_t count)
{
    /* solution */
    rk_vec3 colour = rk_vec(0, 0, 0);
    float transmitted = 1;
    for (uint32_t k = 0; k < count; k++) {
        colour = rk_madd(colour, crossings[k].kd, crossings[k].alpha * transmitted);
        transmitted *= 1 - crossings[k].alpha;
    }
    return rk_madd(colour, rk_vec(1, 1, 1), transmitted);
    /* starter
    // Fourth step: blend the surfaces, the nearest to the point in front, over white.
    // Until then all light passes, as if glass were clear.
    return rk_vec(1, 1, 1);
    end */
}

static rk_vec3 beer_lambert(const rk_crossing *crossings, uint32_t count, float length)
{
    /* solution */
    rk_vec3 depth = rk_vec(0, 0, 0); /* optical depth: the sum of sigma thickness */
    for (uint32_t k = 0; k < count; k++)
        if (is_first_of_its_medium(crossings, k)) {
            float thickness = fraction_inside(crossings, count, crossings[k].medium) * length;
            depth = rk_madd(depth, crossings[k].absorption, thickness);
        }
    return rk_vec(expf(-depth.x), expf(-depth.y), expf(-depth.z));
    /* starter
    // Fifth step: exp(-sigma thickness), each medium once.
    // Until then all light passes, as if glass were clear.
    return rk_vec(1, 1, 1);
    end */
}

static bool is_first_of_its_medium(const rk_crossing *crossings, uint32_t k)
{
    for (uint32_t j = 0; j < k; j++)
        if (crossings[j].medium == crossings[k].medium)
            return false;
    return true;
}

/* The change of depth in the medium at a crossing: 1 if it is entered, -1 if it is left, 0 if it
 * belongs to another. */
static int step_into(const rk_crossing *crossing, uint32_t medium)
{
    return crossing->medium != medium ? 0 : crossing->entering ? 1 : -1;
}

/* The fraction of the ray from t = 0 to t = 1 that lies inside the medium. */
static float fraction_inside(const rk_crossing *crossings, uint32_t count, uint32_t medium)
{
    /* solution */
    int depth = depth_at_start(crossings, count, medium);
    float inside = 0, from = 0;
    for (uint32_t k = 0; k < count; k++) {
        if (depth > 0)
            inside += crossings[k].t - from;
        from = crossings[k].t;
        depth += step_into(&crossings[k], medium);
    }
    return depth > 0 ? inside + (1 - from) : inside;
    /* starter
    // Fifth step: add up the intervals between crossings in which the depth is above 0.
    return 0;
    end */
}

/* The number of blocks of the medium around the ray's start: the smallest with which it never
 * leaves a block that it is not in. All steps at one t count together, because rounding may have
 * swapped them. */
static int depth_at_start(const rk_crossing *crossings, uint32_t count, uint32_t medium)
{
    /* solution */
    int depth = 0, lowest = 0;
    for (uint32_t k = 0; k < count; k++) {
        depth += step_into(&crossings[k], medium);
        bool last_at_t = k + 1 == count || crossings[k + 1].t > crossings[k].t;
        if (last_at_t && depth < lowest)
            lowest = depth;
    }
    return -lowest;
    /* starter
    // Fifth step: 0 outside; a block that is left without having been entered surrounds the start.
    return 0;
    end */
}
