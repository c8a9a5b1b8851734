/* Four lanes are the three axes and one left over: a triangle is counted on all axes at once, and
 * the sweeps over the boundaries compute the areas of all three boxes at once. */
#include "accel/build/bvh_bins.h"

#include "accel/build/bvh_parts.h"

void rk_bins_fill(bin_set *set, const binning *b, const reference *references, uint32_t count)
{
    for (int k = 0; k < b->bins; k++) {
#pragma GCC unroll 3
        for (int axis = 0; axis < 3; axis++) {
            set->axes[axis].low[k] = nothing.low;
            set->axes[axis].high[k] = nothing.high;
        }
        set->count[k] = (rk_simd4_mask){0, 0, 0, 0};
    }
    for (uint32_t i = 0; i < count; i++) {
        const reference *r = &references[i];
        const rk_simd4_mask bin = bins_of(b, centre_of(r));
#pragma GCC unroll 3
        for (int axis = 0; axis < 3; axis++) {
            const int k = bin[axis];
            set->axes[axis].low[k] = rk_simd4_min(set->axes[axis].low[k], r->low);
            set->axes[axis].high[k] = rk_simd4_max(set->axes[axis].high[k], r->high);
            set->count[k][axis]++;
        }
    }
}

void rk_bins_merge(bin_set *into, const bin_set *from, int bins)
{
    for (int k = 0; k < bins; k++) {
#pragma GCC unroll 3
        for (int axis = 0; axis < 3; axis++) {
            bounds both = merge(bin_bounds(into, axis, k), bin_bounds(from, axis, k));
            into->axes[axis].low[k] = both.low;
            into->axes[axis].high[k] = both.high;
        }
        into->count[k] += from->count[k];
    }
}

/* Half of the areas of three boxes, and of the last one again. */
static inline rk_simd4 areas_of(const bounds box[3], rk_simd4 unit)
{
    rk_simd4 extent[4];
#pragma GCC unroll 4
    for (int i = 0; i < 4; i++)
        extent[i] = box[i < 3 ? i : 2].high * unit - box[i < 3 ? i : 2].low * unit;
    rk_simd4_transpose(extent);
    return extent[0] * extent[1] + extent[1] * extent[2] + extent[2] * extent[0];
}

static inline rk_simd4 blocks_of(rk_simd4_mask count)
{
    const rk_simd4_mask blocks =
        (count + (RK_PART_BLOCK - 1)) >> 2; /* there is no vector division */
    return __builtin_convertvector(blocks, rk_simd4);
}

/* Two sweeps over the boundaries, on all three axes at once: down for the triangles on the
 * right of each, up for those on its left. */
split rk_bins_cheapest_split(const bin_set *set, const binning *b, rk_simd4 unit)
{
    rk_simd4 right_cost[bins_max];
    rk_simd4_mask right_count[bins_max], count = {0, 0, 0, 0}, boundary = count;
    bounds side[3] = {nothing, nothing, nothing};
    for (int k = b->bins - 1; k > 0; k--) {
#pragma GCC unroll 3
        for (int axis = 0; axis < 3; axis++)
            side[axis] = merge(side[axis], bin_bounds(set, axis, k));
        count += set->count[k];
        right_count[k] = count;
        right_cost[k] = areas_of(side, unit) * blocks_of(count);
    }
    rk_simd4 lowest = rk_simd4_all(INFINITY);
    count = (rk_simd4_mask){0, 0, 0, 0};
#pragma GCC unroll 3
    for (int axis = 0; axis < 3; axis++)
        side[axis] = nothing;
    for (int k = 1; k < b->bins; k++) {
#pragma GCC unroll 3
        for (int axis = 0; axis < 3; axis++)
            side[axis] = merge(side[axis], bin_bounds(set, axis, k - 1));
        count += set->count[k - 1];
        const rk_simd4 cost = areas_of(side, unit) * blocks_of(count) + right_cost[k];
        const rk_simd4_mask better =
            (cost < lowest) & (count > 0) & (right_count[k] > 0) & b->usable;
        lowest = rk_simd4_select(better, cost, lowest);
        boundary = (better & k) | (~better & boundary);
    }
    int axis = lowest[1] < lowest[0] ? 1 : 0;
    axis = lowest[2] < lowest[axis] ? 2 : axis;
    return (split){axis, boundary[axis], lowest[axis]};
}
