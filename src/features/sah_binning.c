/* A tree is good if its boxes are small: of the rays that hit a node's box, the fraction that hits
 * a child's box is the ratio of their areas. So of all splits of a node this builder takes the one
 * with the lowest expected cost. It does not try all of them: triangles are counted into bins along
 * an axis, and only the boundaries between bins are tried.
 * Goldsmith and Salmon, "Automatic creation of object hierarchies for ray tracing", 1987
 * (SAH); Wald, "On fast construction of SAH-based bounding volume hierarchies", 2007 (bins). */
#include "features/sah_binning.h"

#include "features/bvh_median.h"

#include <stdlib.h>

/* Equal parts of the centroids' extent on an axis. */
typedef struct bin_axis {
    int axis;
    uint32_t bins; /* 1 if all centroids coincide on it */
    double low, bins_per_unit;
} bin_axis;

/* The triangles of one bin, or of all bins on one side of a boundary. */
typedef struct group {
    rk_box box;
    uint32_t count;
} group;

/* The bounds of a node's triangles, and of their centroids. */
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
                          uint32_t boundary);
static uint32_t larger_part(const rk_sah_split *split);
static bool fits_depth(const rk_sah_split *split, uint32_t depth_left);
static const rk_sah_split *most_balanced(const rk_sah_split *candidates, uint32_t count);
static uint32_t split_node(rk_bvh_reference *references, uint32_t count, uint32_t depth_left,
                           const rk_sah_options *options, rk_box *box);
static uint32_t split_by_cost(void *context, uint32_t begin, uint32_t count, uint32_t depth_left,
                              rk_box *box);

rk_sah_options rk_sah_options_default(void)
{
    return (rk_sah_options){.bins = 50, .all_axes = false};
}

/* --- The cost of a split ---------------------------------------------------------------------- */

/* No ray hits a node without area; its children then count as if they had the same area. */
static double cost_of(double area, const group *left, const group *right)
{
    /* solution */
    double tests = (double)left->count + right->count;
    if (area > 0)
        tests =
            (rk_box_area(left->box) * left->count + rk_box_area(right->box) * right->count) / area;
    return RK_BVH_TRAVERSAL_COST + RK_BVH_INTERSECTION_COST * tests;
    /* starter
    // First step: the expected cost of a ray that hits the node, if the node is split here.
    return 0;
    end */
}

/* --- Bins ------------------------------------------------------------------------------------- */

static bin_axis bin_axis_of(const rk_box *centroids, int axis, uint32_t bins)
{
    /* solution */
    /* In double, because the extent may overflow a float, and its reciprocal too. */
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
    // First step: the highest centroid is in the last bin, not in one beyond it.
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
    // First step: each bin has the number of its triangles and the box around their boxes.
    for (uint32_t k = 0; k < along->bins; k++)
        bins[k] = (group){nothing.box, count};
    end */
}

/* --- Candidates ------------------------------------------------------------------------------- */

/* Two sweeps: from the last bin down, the group above each boundary; from the first bin up, the
 * group below it. Neither is ever empty, because the lowest centroid is in the first bin and the
 * highest in the last. */
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
    for (uint32_t boundary = 1; boundary < along->bins; boundary++) {
        if (bins[boundary - 1].count == 0)
            continue;
        below = merge(below, &bins[boundary - 1]);
        candidates[found++] = (rk_sah_split){
            .axis = along->axis,
            .boundary = boundary,
            .count = {below.count, above[boundary].count},
            .box = {below.box, above[boundary].box},
            .cost = cost_of(area, &below, &above[boundary]),
        };
    }
    return found;
    /* starter
    // Second step: the first sweep stores the group above each boundary, the second goes up
    // with the group below it. The boundary above an empty bin is no candidate. So far there
    // are two bins, and this is right.
    double cost = cost_of(area, &bins[0], &bins[1]);
    candidates[0] = (rk_sah_split){
        along->axis, 1, {bins[0].count, bins[1].count}, {bins[0].box, bins[1].box}, cost};
    return 1;
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
    // Third step: those on the centroids' longest axis, or on all three in turn. So far the
    // longest is x.
    return candidates_on(0, b, references, count, bins_for(options, count), candidates);
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

/* --- Splitting -------------------------------------------------------------------------------- */

/* Moves the triangles in bins below the boundary to the front; returns their number. */
static uint32_t partition(rk_bvh_reference *references, uint32_t count, const bin_axis *along,
                          uint32_t boundary)
{
    /* solution */
    uint32_t left = 0, right = count;
    for (;;) {
        while (left < right && bin_of(along, references[left].centroid) < boundary)
            left++;
        while (left < right && bin_of(along, references[right - 1].centroid) >= boundary)
            right--;
        if (left == right)
            return left;
        rk_bvh_reference swapped = references[left];
        references[left++] = references[--right];
        references[right] = swapped;
    }
    /* starter
    // Fourth step: both sides of the boundary, each in any order.
    return count;
    end */
}

static uint32_t larger_part(const rk_sah_split *split)
{
    return split->count[0] > split->count[1] ? split->count[0] : split->count[1];
}

/* Can both children still be halved down to leaves, if depth_left levels may follow below the
 * node? */
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

/* Fills in the node's box, moves the left child's triangles to the front, and returns their number;
 * 0 makes the node a leaf. Where no split pays, but a leaf would be too large, the most balanced
 * split is taken: later ones may pay. If even that one does not fit the depth, or all centroids
 * coincide, half of the triangles go left as they stand. So no node ever has more than
 * RK_BVH_LEAF_MAX << depth_left triangles, and nodes with depth_left = 0 are leaves. */
static uint32_t split_node(rk_bvh_reference *references, uint32_t count, uint32_t depth_left,
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
    return partition(references, count, &along, split->boundary);
    /* starter
    // For now all triangles are one leaf. Fourth step: split where it costs least, if that is
    // less than a leaf costs. Fifth step: leaves too large, trees too deep.
    return 0;
    end */
}

/* --- The tree --------------------------------------------------------------------------------- */

/* The context of split_by_cost. */
typedef struct sah_builder {
    rk_bvh_reference *references;
    const rk_sah_options *options;
} sah_builder;

static uint32_t split_by_cost(void *context, uint32_t begin, uint32_t count, uint32_t depth_left,
                              rk_box *box)
{
    const sah_builder *builder = context;
    return split_node(builder->references + begin, count, depth_left, builder->options, box);
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
