/* A tree of boxes is good if its boxes are small, as the share of rays that meet a box is its area
 * over that of the box around it. So of the ways to cut a node this builder takes the one that is
 * expected to cost least. It does not try all of them: triangles are counted into bins along an
 * axis, and only the borders between bins are tried.
 * Goldsmith and Salmon, "Automatic creation of object hierarchies for ray tracing", 1987 (the
 * heuristic); Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007 (bins).
 */
#include "features/sah_binning.h"

#include "features/bvh_median.h"

#include <stdlib.h>

/* Equal parts of the centroids' extent on an axis. */
typedef struct bin_axis {
    int axis;
    uint32_t bins; /* 1 if all centroids coincide on it */
    double low, bins_per_unit;
} bin_axis;

/* Some triangles: those of a bin, or of all bins on one side of a border. */
typedef struct group {
    rk_box box;
    uint32_t count;
} group;

/* What is measured of a node before it is cut. */
typedef struct bounds {
    rk_box box, centroids;
} bounds;

/* Contents, in the order of the chapter. */
static double cost_of(double area, const group *left, const group *right);
static bin_axis bin_axis_of(const rk_box *centroids, int axis, uint32_t bins);
static uint32_t bin_of(const bin_axis *along, rk_vec3 centroid);
static group merge(group a, const group *b);
static void fill_bins(group *bins, const bin_axis *along, const rk_bvh_reference *references,
                      uint32_t count);
static uint32_t sweep(const bin_axis *along, const group *bins, double area,
                      rk_sah_split *candidates);
static bounds bounds_of(const rk_bvh_reference *references, uint32_t count);
static uint32_t bins_for(const rk_sah_options *options, uint32_t count);
static uint32_t candidates_on(int axis, const bounds *b, const rk_bvh_reference *references,
                              uint32_t count, uint32_t bins, rk_sah_split *candidates);
static uint32_t candidates_within(const bounds *b, const rk_bvh_reference *references,
                                  uint32_t count, const rk_sah_options *options,
                                  rk_sah_split *candidates);
static uint32_t partition(rk_bvh_reference *references, uint32_t count, const bin_axis *along,
                          uint32_t border);
static uint32_t larger_part(const rk_sah_split *split);
static bool fits_depth(const rk_sah_split *split, uint32_t depth_left);
static const rk_sah_split *most_balanced(const rk_sah_split *candidates, uint32_t count);
static uint32_t cut(rk_bvh_reference *references, uint32_t count, uint32_t depth_left,
                    const rk_sah_options *options, rk_box *box);
static uint32_t split_by_cost(void *context, uint32_t begin, uint32_t count, uint32_t depth_left,
                              rk_box *box);

rk_sah_options rk_sah_options_default(void)
{
    return (rk_sah_options){.bins = 50, .all_axes = false};
}

/* --- What a cut costs ------------------------------------------------------------------------- */

/* A node without area is met by no ray; its parts then count as if they were as large. */
static double cost_of(double area, const group *left, const group *right)
{
    /* solution */
    double tests = (double)left->count + right->count;
    if (area > 0)
        tests =
            (rk_box_area(left->box) * left->count + rk_box_area(right->box) * right->count) / area;
    return RK_BVH_TRAVERSAL_COST + RK_BVH_INTERSECTION_COST * tests;
    /* starter
    // First step: what a ray that meets the node is expected to cost if the node is cut here.
    return 0;
    end */
}

/* --- Bins ------------------------------------------------------------------------------------- */

static bin_axis bin_axis_of(const rk_box *centroids, int axis, uint32_t bins)
{
    /* solution */
    /* In double, as the extent may overflow a float, and its reciprocal too. */
    double low = (double)rk_axis(centroids->corner[0], axis);
    double high = (double)rk_axis(centroids->corner[1], axis);
    if (!(low < high))
        return (bin_axis){axis, 1, low, 0};
    return (bin_axis){axis, bins, low, bins / (high - low)};
    /* starter
    // First step: how many bins lie in one unit of length? Think of an extent of 0.
    return (bin_axis){axis, 1, 0, 0};
    end */
}

static uint32_t bin_of(const bin_axis *along, rk_vec3 centroid)
{
    /* solution */
    double offset = (double)rk_axis(centroid, along->axis) - along->low;
    double place = offset * along->bins_per_unit;
    return place < along->bins ? (uint32_t)place : along->bins - 1;
    /* starter
    // First step: the highest centroid is in the last bin, not in one behind it.
    return 0;
    end */
}

static const group nothing = {{{{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}}},
                              0};

static group merge(group a, const group *b)
{
    return (group){rk_box_merge(a.box, b->box), a.count + b->count};
}

static void fill_bins(group *bins, const bin_axis *along, const rk_bvh_reference *references,
                      uint32_t count)
{
    /* solution */
    for (uint32_t k = 0; k < along->bins; k++)
        bins[k] = nothing;
    for (uint32_t i = 0; i < count; i++) {
        group *bin = &bins[bin_of(along, references[i].centroid)];
        bin->box = rk_box_merge(bin->box, references[i].box);
        bin->count++;
    }
    /* starter
    // First step: each bin counts its triangles and has the box around theirs.
    for (uint32_t k = 0; k < along->bins; k++)
        bins[k] = (group){nothing.box, count};
    end */
}

/* --- Candidates ------------------------------------------------------------------------------- */

/* Two sweeps: from the last bin down, what lies above each border; from the first bin up, what
 * lies below it. Neither is ever nothing, as the lowest centroid is in the first bin, the highest
 * in the last. */
static uint32_t sweep(const bin_axis *along, const group *bins, double area,
                      rk_sah_split *candidates)
{
    /* solution */
    group above[RK_SAH_BINS_MAX];
    above[along->bins - 1] = bins[along->bins - 1];
    for (uint32_t k = along->bins - 1; k-- > 1;)
        above[k] = merge(above[k + 1], &bins[k]);
    uint32_t found = 0;
    group below = nothing;
    for (uint32_t border = 1; border < along->bins; border++) {
        if (bins[border - 1].count == 0)
            continue;
        below = merge(below, &bins[border - 1]);
        candidates[found++] = (rk_sah_split){
            .axis = along->axis,
            .border = border,
            .count = {below.count, above[border].count},
            .box = {below.box, above[border].box},
            .cost = cost_of(area, &below, &above[border]),
        };
    }
    return found;
    /* starter
    // Second step: the first sweep stores what lies above each border, the second goes up with
    // what lies below it. A border above an empty bin is none.
    return 0;
    end */
}

static bounds bounds_of(const rk_bvh_reference *references, uint32_t count)
{
    bounds b = {rk_box_empty(), rk_box_empty()};
    for (uint32_t i = 0; i < count; i++) {
        b.box = rk_box_merge(b.box, references[i].box);
        b.centroids = rk_box_add(b.centroids, references[i].centroid);
    }
    return b;
}

static uint32_t bins_for(const rk_sah_options *options, uint32_t count)
{
    uint32_t bins = options->bins < RK_SAH_BINS_MAX ? options->bins : RK_SAH_BINS_MAX;
    return bins < count ? bins : count;
}

static uint32_t candidates_on(int axis, const bounds *b, const rk_bvh_reference *references,
                              uint32_t count, uint32_t bins, rk_sah_split *candidates)
{
    bin_axis along = bin_axis_of(&b->centroids, axis, bins);
    if (along.bins < 2)
        return 0;
    group filled[RK_SAH_BINS_MAX];
    fill_bins(filled, &along, references, count);
    return sweep(&along, filled, rk_box_area(b->box), candidates);
}

static uint32_t candidates_within(const bounds *b, const rk_bvh_reference *references,
                                  uint32_t count, const rk_sah_options *options,
                                  rk_sah_split *candidates)
{
    /* solution */
    uint32_t bins = bins_for(options, count), found = 0;
    int longest = rk_box_longest_axis(b->centroids);
    for (int axis = 0; axis < 3; axis++)
        if (options->all_axes || axis == longest)
            found += candidates_on(axis, b, references, count, bins, candidates + found);
    return found;
    /* starter
    // Third step: those on the centroids' longest axis, or on all three in turn.
    return 0;
    end */
}

uint32_t rk_sah_candidates(const rk_bvh_reference *references, uint32_t count,
                           const rk_sah_options *options, rk_sah_split *candidates)
{
    bounds b = bounds_of(references, count);
    return candidates_within(&b, references, count, options, candidates);
}

const rk_sah_split *rk_sah_cheapest(const rk_sah_split *candidates, uint32_t count)
{
    /* solution */
    const rk_sah_split *best = NULL;
    for (uint32_t k = 0; k < count; k++)
        if (!best || candidates[k].cost < best->cost)
            best = &candidates[k];
    return best;
    /* starter
    // Third step: among equals the first.
    return NULL;
    end */
}

/* --- Cutting ---------------------------------------------------------------------------------- */

/* Moves what is in bins below the border to the front; returns how many those are. */
static uint32_t partition(rk_bvh_reference *references, uint32_t count, const bin_axis *along,
                          uint32_t border)
{
    /* solution */
    uint32_t left = 0, right = count;
    for (;;) {
        while (left < right && bin_of(along, references[left].centroid) < border)
            left++;
        while (left < right && bin_of(along, references[right - 1].centroid) >= border)
            right--;
        if (left == right)
            return left;
        rk_bvh_reference swapped = references[left];
        references[left++] = references[--right];
        references[right] = swapped;
    }
    /* starter
    // Fourth step: both sides of the border, each in any order.
    return count;
    end */
}

static uint32_t larger_part(const rk_sah_split *split)
{
    return split->count[0] > split->count[1] ? split->count[0] : split->count[1];
}

/* Can both parts still be halved down to leaves, with so many levels below the node? */
static bool fits_depth(const rk_sah_split *split, uint32_t depth_left)
{
    /* solution */
    if (depth_left == 0)
        return false;
    uint32_t halvings = depth_left - 1;
    return halvings >= 32 || larger_part(split) <= (uint64_t)RK_BVH_LEAF_MAX << halvings;
    /* starter
    // Fifth step: how many triangles are too many for a leaf after so many halvings?
    return true;
    end */
}

static const rk_sah_split *most_balanced(const rk_sah_split *candidates, uint32_t count)
{
    const rk_sah_split *best = NULL;
    for (uint32_t k = 0; k < count; k++)
        if (!best || larger_part(&candidates[k]) < larger_part(best))
            best = &candidates[k];
    return best;
}

/* Cuts a node with so many levels below it, and returns the size of its left part, which comes
 * first; 0: it is to be a leaf. Fills in the node's box. Where no cut pays, but a leaf would be too
 * large, the most even one is taken: later ones may pay. Where even that does not leave room below,
 * or all centroids coincide, half of the triangles go left as they stand. So no node ever has more
 * than RK_BVH_LEAF_MAX << depth_left triangles, and those with no level below them are leaves.
 */
static uint32_t cut(rk_bvh_reference *references, uint32_t count, uint32_t depth_left,
                    const rk_sah_options *options, rk_box *box)
{
    bounds b = bounds_of(references, count);
    *box = b.box;
    /* solution */
    rk_sah_split candidates[RK_SAH_CANDIDATES_MAX];
    uint32_t found = candidates_within(&b, references, count, options, candidates);
    const rk_sah_split *split = rk_sah_cheapest(candidates, found);
    bool pays = split && split->cost < RK_BVH_INTERSECTION_COST * count;
    if (!pays || !fits_depth(split, depth_left)) {
        if (count <= RK_BVH_LEAF_MAX)
            return 0;
        split = most_balanced(candidates, found);
        if (!split || !fits_depth(split, depth_left))
            return count - count / 2;
    }
    bin_axis along = bin_axis_of(&b.centroids, split->axis, bins_for(options, count));
    return partition(references, count, &along, split->border);
    /* starter
    // For now all triangles are one leaf. Fourth step: cut where it costs least, if that is less
    // than a leaf costs. Fifth step: leaves too large, trees too deep.
    return 0;
    end */
}

/* --- The tree --------------------------------------------------------------------------------- */

/* What cuts nodes by the heuristic. */
typedef struct sah_builder {
    rk_bvh_reference *references;
    const rk_sah_options *options;
} sah_builder;

static uint32_t split_by_cost(void *context, uint32_t begin, uint32_t count, uint32_t depth_left,
                              rk_box *box)
{
    const sah_builder *builder = context;
    return cut(builder->references + begin, count, depth_left, builder->options, box);
}

bool rk_bvh_build_sah(rk_bvh *bvh, const rk_mesh *mesh, const rk_sah_options *options,
                      rk_error *error)
{
    uint32_t count = mesh->triangle_count;
    if (!rk_bvh_init(bvh, count, count, error) || count == 0)
        return count == 0 && bvh->nodes;
    rk_bvh_reference *references = rk_allocate_unset(count, sizeof *references, "tree", error);
    if (!references) {
        rk_bvh_free(bvh);
        return false;
    }
    for (uint32_t i = 0; i < count; i++)
        references[i] = rk_bvh_reference_of(mesh, i);
    rk_bvh_build_nodes(bvh, split_by_cost, &(sah_builder){references, options});
    for (uint32_t i = 0; i < count; i++)
        bvh->triangles[i] = rk_bvh_triangle_of(mesh, references[i].triangle);
    free(references);
    return true;
}
