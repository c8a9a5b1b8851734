/* A split copies references from one buffer to the other, so that each side stays contiguous and in
 * order. Large parts are cut into chunks, which threads bin and copy independently: a tree is the
 * same for any number of threads. */
#include "accel/build/bvh_parts.h"

#include "accel/build/bvh_bins.h"
#include "accel/build/bvh_morton.h"
#include "scene/bvh.h"

#include <stdlib.h>

enum {
    chunk_size = 1 << 12, /* references that one thread takes at a time */
};

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
    binning grid;  /* of RK_BUILD_MORTON, of RK_MORTON_CELLS cells on each axis */
};

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

/* --- Large parts, by all threads -------------------------------------------------------------- */

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
    rk_bins_fill(&job->parts->chunks[index].bins, job->binning,
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
        rk_bins_merge(set, &parts->chunks[i].bins, b->bins);
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

/* --- Splitting -------------------------------------------------------------------------------- */

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
    const reference *from = parts->references[part->buffer] + part->begin;
    if (parts->quality == RK_BUILD_MORTON) {
        cut(parts, part, rk_morton_boundary(from, part->count, &parts->grid), halves);
        return true;
    }
    const bool together = parts->chunks && part->count >= RK_PART_LARGE;
    const binning b = split_binning(part);
    bin_set set;
    if (together)
        fill_bins_together(&set, &b, parts, part);
    else
        rk_bins_fill(&set, &b, from, part->count);
    const split at = rk_bins_cheapest_split(&set, &b, parts->unit);
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

/* --- Start and end ---------------------------------------------------------------------------- */

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
        parts->grid = binning_of(root, RK_MORTON_CELLS);
        rk_morton_sort(parts->references, count, &parts->grid);
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

/* --- A part's properties ---------------------------------------------------------------------- */

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
