#include "trees.h"

#include "features/bvh_median.h"
#include "scene/bvh_build.h"

#include <stdlib.h>

typedef struct resizing {
    const rk_bvh *from;
    rk_bvh *to;
    const rk_mesh *mesh;
    uint32_t most;
} resizing;

static rk_box box_of(const resizing *r, uint32_t begin, uint32_t count)
{
    rk_box box = rk_box_empty();
    for (uint32_t i = begin; i < begin + count; i++)
        box = rk_box_merge(box, rk_bvh_reference_of(r->mesh, r->to->triangles[i].index).box);
    return box;
}

/* Moves the lower half of these triangles, by their centroids on the box's longest axis, to the
 * front. Insertion is fast enough for leaves, which are small. */
static void sort_along(const resizing *r, rk_box box, uint32_t begin, uint32_t count)
{
    int axis = rk_box_longest_axis(box);
    rk_triangle *triangles = r->to->triangles;
    for (uint32_t i = begin + 1; i < begin + count; i++)
        for (uint32_t k = i; k > begin; k--) {
            rk_vec3 a = rk_bvh_reference_of(r->mesh, triangles[k - 1].index).centroid;
            rk_vec3 b = rk_bvh_reference_of(r->mesh, triangles[k].index).centroid;
            if (rk_axis(a, axis) <= rk_axis(b, axis))
                break;
            rk_triangle swapped = triangles[k];
            triangles[k] = triangles[k - 1];
            triangles[k - 1] = swapped;
        }
}

/* `old`: the node of the older tree over these triangles; 0 below its leaves, and for its root. */
static void place(resizing *r, uint32_t slot, uint32_t old, uint32_t begin, uint32_t count,
                  uint32_t level)
{
    rk_bvh_node *node = &r->to->nodes[slot];
    const rk_bvh_node *older = old || slot == 0 ? &r->from->nodes[old] : NULL;
    *node = (rk_bvh_node){older ? older->box : box_of(r, begin, count), begin, count};
    if (count <= r->most || level + 1 == RK_BVH_LEVELS_MAX)
        return;
    uint32_t halves[2][2] = {{0, count / 2}, {0, count - count / 2}}; /* older node, triangles */
    if (older && older->count == 0)
        for (uint32_t side = 0; side < 2; side++) {
            halves[side][0] = older->first + side;
            halves[side][1] = rk_bvh_range_of(r->from, older->first + side).count;
        }
    else
        sort_along(r, node->box, begin, count);
    uint32_t first = r->to->node_count;
    r->to->node_count += 2;
    node->first = first;
    node->count = 0;
    place(r, first, halves[0][0], begin, halves[0][1], level + 1);
    place(r, first + 1, halves[1][0], begin + halves[0][1], halves[1][1], level + 1);
}

bool trees_resize_leaves(rk_accel *accel, uint32_t most, rk_error *error)
{
    rk_bvh resized;
    uint32_t count = accel->bvh.triangle_count;
    if (count == 0 || !rk_bvh_init(&resized, count, count, error))
        return count == 0;
    for (uint32_t i = 0; i < count; i++)
        resized.triangles[i] = accel->bvh.triangles[i];
    resized.node_count = 2;
    resizing r = {&accel->bvh, &resized, &accel->scene->mesh, most};
    place(&r, 0, 0, 0, count, 0);
    rk_bvh_free(&accel->bvh);
    accel->bvh = resized;
    return true;
}
