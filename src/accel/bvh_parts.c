#include "accel/bvh_parts.h"

#include "scene/bvh.h"

#include <stdlib.h>

enum {
    bins_max = 16,
    chunk_size = 1 << 12, /* references that one thread takes at a time */
};

/* The box around a triangle. The fourth numbers are the lower and the upper half of its index:
 * whole numbers, because its bits would be a denormal float, which is slow to compute with. */
typedef struct reference {
    rk_simd4 low, high;
} reference;

typedef struct axis_bins {
    rk_simd4 low[bins_max], high[bins_max];
} axis_bins;

/* How a part's triangles lie in the bins of all axes. */
typedef struct bin_set {
    axis_bins axes[3];
    rk_simd4_mask count[bins_max]; /* on x, y and z */
} bin_set;

/* From a centre to its bins. */
typedef struct binning {
    int bins;
    rk_simd4 low, scale;
    rk_simd4_mask usable; /* axes on which centres differ */
} binning;

typedef struct split {
    int axis, boundary; /* bins from the boundary on go right */
    float cost;         /* in units of `area`, see areas_of; infinite if there is none */
} split;

typedef struct bounds {
    rk_simd4 low, high;
} bounds;

/* A thread's share of a large part. */
typedef struct chunk {
    bin_set bins;
    uint32_t first[2]; /* where its references go, left and right */
    bounds centres[2];
    bounds box; /* at the start */
} chunk;

struct rk_bvh_parts {
    rk_build_quality quality;
    reference *references[2]; /* a split copies from one to the other */
    chunk *chunks;            /* NULL without a pool */
    rk_pool *pool;
    rk_simd4 unit; /* 1 / the longest extent, so that areas neither overflow nor underflow */
    binning grid;  /* of RK_BUILD_MORTON */
};

static const bounds nothing = {{INFINITY, INFINITY, INFINITY, INFINITY},
                               {-INFINITY, -INFINITY, -INFINITY, -INFINITY}};

static inline bounds merge(bounds a, bounds b)
{
    return (bounds){rk_simd4_min(a.low, b.low), rk_simd4_max(a.high, b.high)};
}

static inline bounds add_point(bounds a, rk_simd4 x)
{
    return merge(a, (bounds){x, x});
}

/* A quarter of the corners' sum, so that no sum or extent overflows. */
static inline rk_simd4 centre_of(const reference *r)
{
    const rk_simd4 quarter = rk_simd4_all(0.25f);
    return r->low * quarter + r->high * quarter;
}

/* --- Bins ------------------------------------------------------------------------------------- */

static binning binning_of(const rk_bvh_part *part, int bins)
{
    const rk_simd4 extent = part->centres_high - part->centres_low;
    /* A little less than all bins, so that the last centre is in the last bin. */
    const rk_simd4 scale = rk_simd4_all((float)bins * 0.99999f) / extent;
    const rk_simd4_mask usable = (extent > rk_simd4_all(0)) & (scale <= rk_simd4_all(FLT_MAX)) &
                                 (rk_simd4_mask){-1, -1, -1, 0};
    return (binning){bins, part->centres_low, rk_simd4_select(usable, scale, rk_simd4_all(0)),
                     usable};
}

/* A small part needs few bins: each costs as much as two triangles. */
static binning split_binning(const rk_bvh_part *part)
{
    return binning_of(part, part->count < 16 ? 4 : part->count < 200 ? 8 : bins_max);
}

static inline rk_simd4_mask bins_of(const binning *b, rk_simd4 centre)
{
    return __builtin_convertvector((centre - b->low) * b->scale, rk_simd4_mask);
}

static void fill_bins(bin_set *set, const binning *b, const reference *references, uint32_t count)
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

static inline bounds bin_bounds(const bin_set *set, int axis, int k)
{
    return (bounds){set->axes[axis].low[k], set->axes[axis].high[k]};
}

static void merge_bins(bin_set *into, const bin_set *from, int bins)
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

/* --- The cheapest split ------------------------------------------------------------------------
 */

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
static split cheapest_split(const bin_set *set, const binning *b, rk_simd4 unit)
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

/* The halves as the bins tell them, without the bounds of their centres. */
static void start_halves(const rk_bvh_part *part, const bin_set *set, const binning *b,
                         const split *at, rk_bvh_part halves[2])
{
    bounds box[2] = {nothing, nothing};
    uint32_t count[2] = {0, 0};
    for (int k = 0; k < b->bins; k++) {
        const int side = k >= at->boundary;
        box[side] = merge(box[side], bin_bounds(set, at->axis, k));
        count[side] += (uint32_t)set->count[k][at->axis];
    }
    for (int side = 0; side < 2; side++)
        halves[side] = (rk_bvh_part){.low = box[side].low,
                                     .high = box[side].high,
                                     .begin = part->begin + (side ? count[0] : 0),
                                     .count = count[side],
                                     .buffer = !part->buffer,
                                     .depth_left = part->depth_left - 1};
}

/* Copies references to their sides, in their order, and bounds the centres on each. No branch
 * depends on a side, because none could be predicted. */
static void copy_to_sides(const reference *from, uint32_t count, const binning *b, const split *at,
                          reference *to[2], bounds centres[2])
{
    static const rk_simd4_mask is_left[2] = {{-1, -1, -1, -1}, {0, 0, 0, 0}};
    rk_simd4_mask last_left = {INT32_MAX, INT32_MAX, INT32_MAX, INT32_MAX};
    last_left[at->axis] = at->boundary - 1;
    bounds left = nothing, right = nothing;
    for (uint32_t i = 0; i < count; i++) {
        const rk_simd4 x = centre_of(&from[i]);
        const uint32_t side = rk_simd4_movemask(bins_of(b, x) > last_left) != 0;
        *to[side]++ = from[i];
        const rk_simd4_mask here = is_left[side];
        left = merge(left, (bounds){rk_simd4_select(here, x, nothing.low),
                                    rk_simd4_select(here, x, nothing.high)});
        right = merge(right, (bounds){rk_simd4_select(~here, x, nothing.low),
                                      rk_simd4_select(~here, x, nothing.high)});
    }
    centres[0] = left;
    centres[1] = right;
}

static void set_centres(rk_bvh_part *part, bounds centres)
{
    part->centres_low = centres.low;
    part->centres_high = centres.high;
}

/* --- Large parts, by all threads ---------------------------------------------------------------
 */

typedef struct chunk_job {
    const rk_bvh_parts *parts;
    const rk_bvh_part *part;
    const binning *binning;
    const split *at;
} chunk_job;

static uint32_t chunks_in(uint32_t count)
{
    return (count + chunk_size - 1) / chunk_size;
}

static uint32_t chunk_length(uint32_t count, uint32_t index)
{
    const uint32_t left = count - index * chunk_size;
    return left < chunk_size ? left : chunk_size;
}

static void fill_chunk(uint32_t index, uint32_t thread, void *context)
{
    const chunk_job *job = context;
    const rk_bvh_part *part = job->part;
    (void)thread;
    fill_bins(&job->parts->chunks[index].bins, job->binning,
              job->parts->references[part->buffer] + part->begin + index * chunk_size,
              chunk_length(part->count, index));
}

static void copy_chunk(uint32_t index, uint32_t thread, void *context)
{
    const chunk_job *job = context;
    const rk_bvh_part *part = job->part;
    chunk *own = &job->parts->chunks[index];
    reference *into = job->parts->references[!part->buffer];
    reference *to[2] = {into + own->first[0], into + own->first[1]};
    (void)thread;
    copy_to_sides(job->parts->references[part->buffer] + part->begin + index * chunk_size,
                  chunk_length(part->count, index), job->binning, job->at, to, own->centres);
}

static void fill_bins_together(bin_set *set, const binning *b, const rk_bvh_parts *parts,
                               const rk_bvh_part *part)
{
    chunk_job job = {parts, part, b, NULL};
    const uint32_t chunks = chunks_in(part->count);
    rk_pool_run(parts->pool, chunks, fill_chunk, &job);
    *set = parts->chunks[0].bins;
    for (uint32_t i = 1; i < chunks; i++)
        merge_bins(set, &parts->chunks[i].bins, b->bins);
}

static void copy_together(const binning *b, const split *at, const rk_bvh_parts *parts,
                          const rk_bvh_part *part, const rk_bvh_part halves[2], bounds centres[2])
{
    const uint32_t chunks = chunks_in(part->count);
    uint32_t first[2] = {halves[0].begin, halves[1].begin};
    for (uint32_t i = 0; i < chunks; i++) {
        chunk *c = &parts->chunks[i];
        c->first[0] = first[0];
        c->first[1] = first[1];
        for (int k = 0; k < b->bins; k++)
            first[k >= at->boundary] += (uint32_t)c->bins.count[k][at->axis];
    }
    rk_pool_run(parts->pool, chunks, copy_chunk, &(chunk_job){parts, part, b, at});
    centres[0] = centres[1] = nothing;
    for (uint32_t i = 0; i < chunks; i++)
        for (int side = 0; side < 2; side++)
            centres[side] = merge(centres[side], parts->chunks[i].centres[side]);
}

/* --- By Morton codes ----------------------------------------------------------------------------
 */

/* The ten bits of x, two places apart from each other. */
static inline uint32_t spread(uint32_t x)
{
    x = (x | x << 16) & 0x030000ff;
    x = (x | x << 8) & 0x0300f00f;
    x = (x | x << 4) & 0x030c30c3;
    return (x | x << 2) & 0x09249249;
}

/* The place of a centre on a curve through the cells of a grid, that stays in an eighth of the grid
 * before it goes on to the next, and likewise in each eighth. */
static inline uint32_t code_of(const rk_bvh_parts *parts, const reference *r)
{
    const rk_simd4_mask cell = bins_of(&parts->grid, centre_of(r));
    return spread((uint32_t)cell[0]) << 2 | spread((uint32_t)cell[1]) << 1 |
           spread((uint32_t)cell[2]);
}

/* By the codes, in three passes of ten bits, each of which keeps the order of the one before
 * (radix sort). Ends in the other buffer. */
static void sort_by_code(const rk_bvh_parts *parts, uint32_t count)
{
    uint32_t first[3][1 << 10] = {{0}};
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t code = code_of(parts, &parts->references[0][i]);
        for (int pass = 0; pass < 3; pass++)
            first[pass][code >> 10 * pass & 1023]++;
    }
    for (int pass = 0; pass < 3; pass++) {
        uint32_t sum = 0;
        for (int k = 0; k < 1 << 10; k++) {
            const uint32_t here = first[pass][k];
            first[pass][k] = sum;
            sum += here;
        }
        const reference *from = parts->references[pass % 2];
        reference *to = parts->references[(pass + 1) % 2];
        for (uint32_t i = 0; i < count; i++)
            to[first[pass][code_of(parts, &from[i]) >> 10 * pass & 1023]++] = from[i];
    }
}

/* Where the highest bit in which the codes differ becomes 1; half of equal ones. */
static uint32_t left_of_bit(const rk_bvh_parts *parts, const rk_bvh_part *part)
{
    const reference *r = parts->references[part->buffer] + part->begin;
    uint32_t low = 0, high = part->count - 1; /* of the one the bit is 0, of the other 1 */
    const uint32_t differ = code_of(parts, &r[low]) ^ code_of(parts, &r[high]);
    if (differ == 0)
        return part->count - part->count / 2;
    const uint32_t bit = 1u << (31 - __builtin_clz(differ));
    while (high - low > 1) {
        const uint32_t middle = low + (high - low) / 2;
        if (code_of(parts, &r[middle]) & bit)
            high = middle;
        else
            low = middle;
    }
    return high;
}

/* --- Splitting ---------------------------------------------------------------------------------
 */

/* Halves of the order as it stands, without a copy. */
static void cut(const rk_bvh_parts *parts, const rk_bvh_part *part, uint32_t left_count,
                rk_bvh_part halves[2])
{
    const uint32_t count[2] = {left_count, part->count - left_count};
    for (int side = 0; side < 2; side++) {
        const uint32_t begin = part->begin + (side ? count[0] : 0);
        const reference *from = parts->references[part->buffer] + begin;
        bounds box = nothing, centres = nothing;
        for (uint32_t i = 0; i < count[side]; i++) {
            box = merge(box, (bounds){from[i].low, from[i].high});
            centres = add_point(centres, centre_of(&from[i]));
        }
        halves[side] = (rk_bvh_part){box.low, box.high,    centres.low,  centres.high,
                                     begin,   count[side], part->buffer, part->depth_left - 1};
    }
}

/* Where bins find nothing, or the tree would get too deep. */
static void halve(const rk_bvh_parts *parts, const rk_bvh_part *part, rk_bvh_part halves[2])
{
    cut(parts, part, part->count - part->count / 2, halves);
}

static uint32_t blocks_in(const rk_bvh_part *part)
{
    return (part->count + RK_PART_BLOCK - 1) / RK_PART_BLOCK;
}

/* Can the larger half still be halved down to leaves? */
static bool fits_depth(const rk_bvh_part halves[2], uint32_t depth_left)
{
    const uint32_t count = halves[0].count > halves[1].count ? halves[0].count : halves[1].count;
    return depth_left > 32 ||
           (depth_left > 0 && count <= (uint64_t)RK_PART_LEAF_MAX << (depth_left - 1));
}

bool rk_bvh_part_split(const rk_bvh_parts *parts, const rk_bvh_part *part, rk_bvh_part halves[2])
{
    if (part->count <= RK_PART_BLOCK)
        return false;
    if (parts->quality == RK_BUILD_MORTON) {
        cut(parts, part, left_of_bit(parts, part), halves);
        return true;
    }
    const bool together = parts->chunks && part->count >= RK_PART_LARGE;
    const reference *from = parts->references[part->buffer] + part->begin;
    const binning b = split_binning(part);
    bin_set set;
    if (together)
        fill_bins_together(&set, &b, parts, part);
    else
        fill_bins(&set, &b, from, part->count);
    const split at = cheapest_split(&set, &b, parts->unit);
    if (at.cost < INFINITY)
        start_halves(part, &set, &b, &at, halves);
    if (!(at.cost < INFINITY && fits_depth(halves, part->depth_left))) {
        halve(parts, part, halves);
        return true;
    }
    bounds centres[2];
    if (together) {
        copy_together(&b, &at, parts, part, halves, centres);
    } else {
        reference *into = parts->references[!part->buffer];
        reference *to[2] = {into + halves[0].begin, into + halves[1].begin};
        copy_to_sides(from, part->count, &b, &at, to, centres);
    }
    set_centres(&halves[0], centres[0]);
    set_centres(&halves[1], centres[1]);
    return true;
}

/* --- Start and end -----------------------------------------------------------------------------
 */

typedef struct start_job {
    const rk_mesh *mesh;
    reference *references;
    uint32_t first, count;
    chunk *chunks;
} start_job;

static bounds make_references(const start_job *job, uint32_t begin, uint32_t count, bounds *centres)
{
    bounds box = nothing;
    *centres = nothing;
    for (uint32_t i = begin; i < begin + count; i++) {
        const uint32_t triangle = job->first + i, *corner = job->mesh->triangles[triangle];
        const rk_simd4 a = rk_simd4_of(job->mesh->positions[corner[0]]);
        const rk_simd4 b = rk_simd4_of(job->mesh->positions[corner[1]]);
        const rk_simd4 c = rk_simd4_of(job->mesh->positions[corner[2]]);
        reference r = {rk_simd4_min(a, rk_simd4_min(b, c)), rk_simd4_max(a, rk_simd4_max(b, c))};
        r.low[3] = (float)(triangle & 0xffff);
        r.high[3] = (float)(triangle >> 16);
        job->references[i] = r;
        box = merge(box, (bounds){r.low, r.high});
        *centres = add_point(*centres, centre_of(&r));
    }
    return box;
}

static void start_chunk(uint32_t index, uint32_t thread, void *context)
{
    const start_job *job = context;
    chunk *own = &job->chunks[index];
    (void)thread;
    own->box =
        make_references(job, index * chunk_size, chunk_length(job->count, index), &own->centres[0]);
}

static rk_bvh_part start_root(rk_bvh_parts *parts, const start_job *job)
{
    bounds centres = nothing, box = nothing;
    if (parts->chunks) {
        rk_pool_run(parts->pool, chunks_in(job->count), start_chunk, (void *)job);
        for (uint32_t i = 0; i < chunks_in(job->count); i++) {
            box = merge(box, parts->chunks[i].box);
            centres = merge(centres, parts->chunks[i].centres[0]);
        }
    } else {
        box = make_references(job, 0, job->count, &centres);
    }
    const rk_simd4 quarter = rk_simd4_all(0.25f);
    const rk_simd4 extent = box.high * quarter - box.low * quarter;
    const float longest = rk_max(extent[0], rk_max(extent[1], extent[2]));
    parts->unit = rk_simd4_all(longest > FLT_MIN ? 0.25f / longest : 1);
    return (rk_bvh_part){box.low, box.high,   centres.low, centres.high,
                         0,       job->count, 0,           RK_BVH_LEVELS_MAX - 1};
}

rk_bvh_parts *rk_bvh_parts_start(const rk_mesh *mesh, uint32_t first, uint32_t count,
                                 rk_build_quality quality, rk_pool *pool, rk_bvh_part *root,
                                 rk_error *error)
{
    rk_bvh_parts *parts = rk_allocate(1, sizeof *parts, "tree", error);
    if (!parts)
        return NULL;
    const bool together = pool && rk_pool_threads(pool) > 1 && count >= RK_PART_LARGE;
    for (int i = 0; i < 2; i++)
        parts->references[i] = rk_allocate_unset(count, sizeof(reference), "tree", error);
    if (together)
        parts->chunks = rk_allocate_unset(chunks_in(count), sizeof(chunk), "tree", error);
    if (!parts->references[0] || !parts->references[1] || (together && !parts->chunks)) {
        rk_bvh_parts_free(parts);
        return NULL;
    }
    parts->pool = pool;
    parts->quality = quality;
    *root =
        start_root(parts, &(start_job){mesh, parts->references[0], first, count, parts->chunks});
    if (quality == RK_BUILD_MORTON) {
        parts->grid = binning_of(root, 1 << 10);
        sort_by_code(parts, count);
        root->buffer = 1;
    }
    return parts;
}

void rk_bvh_parts_free(rk_bvh_parts *parts)
{
    if (!parts)
        return;
    free(parts->references[0]);
    free(parts->references[1]);
    free(parts->chunks);
    free(parts);
}

/* --- A part's properties -----------------------------------------------------------------------
 */

/* Counted in blocks: a leaf costs one for each, a split one for the node and those of its halves.
 */
bool rk_bvh_part_should_split(const rk_bvh_parts *parts, const rk_bvh_part *part,
                              const rk_bvh_part halves[2])
{
    if (part->count > RK_PART_LEAF_MAX)
        return true;
    const float area = rk_bvh_part_area(parts, part);
    const float cost = rk_bvh_part_area(parts, &halves[0]) * (float)blocks_in(&halves[0]) +
                       rk_bvh_part_area(parts, &halves[1]) * (float)blocks_in(&halves[1]);
    return area + cost < area * (float)blocks_in(part);
}

uint32_t rk_bvh_part_triangle(const rk_bvh_parts *parts, const rk_bvh_part *part, uint32_t i)
{
    const reference *r = &parts->references[part->buffer][part->begin + i];
    return (uint32_t)r->low[3] | (uint32_t)r->high[3] << 16;
}

rk_box rk_bvh_part_box(const rk_bvh_part *part)
{
    return (rk_box){{rk_simd4_vec(part->low), rk_simd4_vec(part->high)}};
}

float rk_bvh_part_area(const rk_bvh_parts *parts, const rk_bvh_part *part)
{
    const rk_simd4 extent = part->high * parts->unit - part->low * parts->unit;
    return extent[0] * extent[1] + extent[1] * extent[2] + extent[2] * extent[0];
}
