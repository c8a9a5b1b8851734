/* Bounding volume hierarchy, split by the surface area heuristic over bins of centroids. The tree
 * is walked by bvh_median's rk_bvh_closest and rk_bvh_occluded. */
#ifndef RK_FEATURES_SAH_BINNING_H
#define RK_FEATURES_SAH_BINNING_H

#include "scene/bvh_build.h"

enum {
    RK_SAH_BINS_MAX = 256,
    RK_SAH_CANDIDATES_MAX = 3 * (RK_SAH_BINS_MAX - 1),
};

typedef struct rk_sah_options {
    uint32_t bins; /* on an axis, 2 to RK_SAH_BINS_MAX; no more than a node has triangles */
    bool all_axes; /* look for borders on all axes, not only where the centroids reach farthest */
} rk_sah_options;

/* 50 bins on the longest axis of the centroids' box (among equals x before y before z). The node's
 * own box would be the wrong judge: one triangle that is longer than all others may leave an axis
 * as the longest on which there is nothing to cut. */
rk_sah_options rk_sah_options_default(void);

/* A way to cut a node. The bins are equal parts of the centroids' extent [low, high] on the axis:
 * a centroid c is in bin (c - low) * (bins / (high - low)), rounded down, computed in double; high
 * is in the last bin. */
typedef struct rk_sah_split {
    int axis;          /* 0, 1 or 2 */
    uint32_t border;   /* bins below it go left */
    uint32_t count[2]; /* triangles to the left and to the right, none of them 0 */
    rk_box box[2];
    double cost; /* 1.5 + (area_left count_left + area_right count_right) / area of the node */
} rk_sah_split;

/* Lists the cuts of a node over these triangles, by axis, then border, and returns how many there
 * are, RK_SAH_CANDIDATES_MAX at most: 0 if all centroids coincide. An empty bin has no border above
 * it, which would be the same cut again. O(count + bins) time. */
uint32_t rk_sah_candidates(const rk_bvh_reference *references, uint32_t count,
                           const rk_sah_options *options, rk_sah_split *candidates);

/* The cheapest of them, among equals the first; NULL if there is none. */
const rk_sah_split *rk_sah_cheapest(const rk_sah_split *candidates, uint32_t count);

/* Builds the tree over a valid mesh (rk_mesh_validate): a node becomes a leaf where its cheapest
 * cut costs no less than testing all of its triangles. Two limits come before that: a leaf has no
 * more than RK_BVH_LEAF_MAX triangles, and there are no more than RK_BVH_LEVELS_MAX levels. A
 * mesh without triangles gives a tree without nodes. False when memory is short. Release with
 * rk_bvh_free. */
bool rk_bvh_build_sah(rk_bvh *bvh, const rk_mesh *mesh, const rk_sah_options *options,
                      rk_error *error);

#endif
