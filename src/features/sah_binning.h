/* Bounding volume hierarchy, split by the surface area heuristic over bins of centroids. Rays
 * traverse the tree by bvh_median's rk_bvh_closest and rk_bvh_occluded. */
#ifndef RK_FEATURES_SAH_BINNING_H
#define RK_FEATURES_SAH_BINNING_H

#include "scene/bvh_build.h"

enum {
    RK_SAH_BINS_MAX = 256,
    RK_SAH_CANDIDATES_MAX = 3 * (RK_SAH_BINS_MAX - 1),
};

typedef struct rk_sah_options {
    uint32_t bins; /* per axis, 2 to RK_SAH_BINS_MAX; a node has no more bins than triangles */
    bool all_axes; /* try all axes, not only the longest of the centroids' box */
} rk_sah_options;

/* 50 bins on the longest axis of the centroids' box (among equals x before y before z). The node's
 * own box would mislead: one long triangle may make an axis the longest on which all centroids
 * coincide. */
rk_sah_options rk_sah_options_default(void);

/* A split of a node. The bins are equal parts of the centroids' extent [low, high] on the axis: a
 * centroid c is in bin (c - low) * (bins / (high - low)), rounded down, computed in double; high is
 * in the last bin. */
typedef struct rk_sah_split {
    int axis;          /* 0, 1 or 2 */
    uint32_t boundary; /* bins below it go left */
    uint32_t count[2]; /* triangles to the left and to the right, neither 0 */
    rk_box box[2];
    double cost; /* 1.5 + (area_left count_left + area_right count_right) / area of the node;
                    without area, 1.5 + count_left + count_right */
} rk_sah_split;

/* Lists the possible splits of a node over these triangles, by axis, then boundary, and returns
 * their number, at most RK_SAH_CANDIDATES_MAX; 0 if all centroids coincide. The boundary above an
 * empty bin is left out: it would give the same split again. O(count + bins) time. */
uint32_t rk_sah_candidates(const rk_bvh_reference *references, uint32_t count,
                           const rk_sah_options *options, rk_sah_split *candidates);

/* Returns the cheapest candidate, the first among equals; NULL if there is none. */
const rk_sah_split *rk_sah_cheapest(const rk_sah_split *candidates, uint32_t count);

/* Builds the tree over a valid mesh (rk_mesh_validate): a node becomes a leaf where its cheapest
 * split costs no less than testing all of its triangles. Two limits take precedence: a leaf has at
 * most RK_BVH_LEAF_MAX triangles, and the tree at most RK_BVH_LEVELS_MAX levels. The stack that it
 * takes does not grow with the mesh. A mesh without triangles gives a tree without nodes. False if
 * memory runs out; the tree is then empty. Release with rk_bvh_free. */
bool rk_bvh_build_sah(rk_bvh *bvh, const rk_mesh *mesh, const rk_sah_options *options,
                      rk_error *error);

#endif
