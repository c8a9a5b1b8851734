/* How a part's triangles lie in the bins of all axes, and where it is cheapest to split them
 * there (accel/build/bvh_parts.h). Not installed. */
#ifndef RK_ACCEL_BUILD_BVH_BINS_H
#define RK_ACCEL_BUILD_BVH_BINS_H

#include "accel/build/bvh_reference.h"

enum { bins_max = 16 };

typedef struct axis_bins {
    rk_simd4 low[bins_max], high[bins_max];
} axis_bins;

typedef struct bin_set {
    axis_bins axes[3];
    rk_simd4_mask count[bins_max]; /* on x, y and z */
} bin_set;

typedef struct split {
    int axis, boundary; /* bins from the boundary on go right */
    float cost;         /* see rk_bins_cheapest_split; infinite if there is none */
} split;

static inline bounds bin_bounds(const bin_set *set, int axis, int k)
{
    return (bounds){set->axes[axis].low[k], set->axes[axis].high[k]};
}

/* Counts the references in the bins, and bounds those in each. */
void rk_bins_fill(bin_set *set, const binning *b, const reference *references, uint32_t count);

/* Adds those of `from`, of the same binning. */
void rk_bins_merge(bin_set *into, const bin_set *from, int bins);

/* The boundary with the lowest SAH cost, a leaf's counted in blocks of RK_PART_BLOCK. Areas are
 * half of the boxes', times the square of `unit`. */
split rk_bins_cheapest_split(const bin_set *set, const binning *b, rk_simd4 unit);

#endif
