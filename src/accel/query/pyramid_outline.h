/* Four boxes or triangles at once against a pyramid, in float: what is certainly outside is left
 * out, and what remains is tested in double. Internal to accel. */
#ifndef RK_ACCEL_QUERY_PYRAMID_OUTLINE_H
#define RK_ACCEL_QUERY_PYRAMID_OUTLINE_H

#include "accel/query/pyramid.h"
#include "base/simd4.h"
#include "scene/wide_tree.h"

/* The pyramid in float, relative to the apex and so much larger that nothing is outside of it that
 * is not outside in double. */
typedef struct outline {
    rk_simd4 apex[3], low[3], high[3];
    rk_simd4 normal[RK_PYRAMID_PLANES][3], limit[RK_PYRAMID_PLANES];
    bool is_negative[RK_PYRAMID_PLANES][3];
} outline;

/* `reach`: no corner of the tree is farther from the apex, as a sum of components. */
static inline outline outline_of(const rk_pyramid *pyramid, double reach)
{
    outline o;
    for (int k = 0; k < 3; k++) {
        o.apex[k] = rk_simd4_all(rk_axis(pyramid->apex, k));
        o.low[k] = rk_simd4_all(rk_axis(pyramid->box.corner[0], k));
        o.high[k] = rk_simd4_all(rk_axis(pyramid->box.corner[1], k));
        for (int i = 0; i < RK_PYRAMID_PLANES; i++) {
            const float normal = rk_axis(rk_narrow(pyramid->normals[i]), k);
            o.normal[i][k] = rk_simd4_all(normal);
            o.is_negative[i][k] = normal < 0;
        }
    }
    for (int i = 0; i < RK_PYRAMID_PLANES; i++)
        o.limit[i] = rk_simd4_all((float)(pyramid->limits[i] + 0x1p-20 * reach) * (1 + 0x1p-22f));
    return o;
}

static inline double reach_of(const rk_pyramid *pyramid, rk_box box)
{
    const rk_dvec3 apex = rk_widen(pyramid->apex);
    return rk_dvec3_size(rk_dmadd(rk_widen(box.corner[0]), apex, -1)) +
           rk_dvec3_size(rk_dmadd(rk_widen(box.corner[1]), apex, -1));
}

typedef struct four_boxes {
    rk_simd4 side[2][3]; /* lowest and highest; x, y, z */
} four_boxes;

/* The boxes that reach into the pyramid, a bit for each; maybe some that are close. */
static inline uint32_t boxes_inside(const outline *o, const four_boxes *boxes)
{
    rk_simd4 from[2][3];
    rk_simd4_mask outside = {0, 0, 0, 0};
    for (int k = 0; k < 3; k++) {
        outside |= (boxes->side[0][k] > o->high[k]) | (boxes->side[1][k] < o->low[k]);
        from[0][k] = boxes->side[0][k] - o->apex[k];
        from[1][k] = boxes->side[1][k] - o->apex[k];
    }
    for (int i = 0; i < RK_PYRAMID_PLANES; i++) {
        const bool *negative = o->is_negative[i];
        outside |= o->normal[i][0] * from[negative[0]][0] + o->normal[i][1] * from[negative[1]][1] +
                       o->normal[i][2] * from[negative[2]][2] >
                   o->limit[i];
    }
    return 15 & ~rk_simd4_movemask(outside);
}

/* The same for the triangles of a block. */
static inline uint32_t triangles_inside(const outline *o, const rk_wide_block *block)
{
    rk_simd4 from[3][3];
    rk_simd4_mask outside = {0, 0, 0, 0};
    for (int k = 0; k < 3; k++) {
        const rk_simd4 a = rk_simd4_load(block->corner[0][k]);
        const rk_simd4 b = rk_simd4_load(block->corner[1][k]);
        const rk_simd4 c = rk_simd4_load(block->corner[2][k]);
        outside |= (rk_simd4_min(a, rk_simd4_min(b, c)) > o->high[k]) |
                   (rk_simd4_max(a, rk_simd4_max(b, c)) < o->low[k]);
        from[0][k] = a - o->apex[k];
        from[1][k] = b - o->apex[k];
        from[2][k] = c - o->apex[k];
    }
    for (int i = 0; i < RK_PYRAMID_PLANES; i++) {
        rk_simd4_mask beyond_plane = ~(rk_simd4_mask){0, 0, 0, 0};
        for (int c = 0; c < 3; c++)
            beyond_plane &= o->normal[i][0] * from[c][0] + o->normal[i][1] * from[c][1] +
                                o->normal[i][2] * from[c][2] >
                            o->limit[i];
        outside |= beyond_plane;
    }
    return 15 & ~rk_simd4_movemask(outside);
}

#endif
