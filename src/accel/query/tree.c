/* Wide trees are traversed by a kernel (accel/kernel/wide_kernel.h), whole batches at once; binary
 * trees by the functions of bvh_median, ray by ray. */
#include "accel/query/tree.h"

#include "features/bvh_median.h"
#include "scene/bvh_build.h"

/* --- Batches ---------------------------------------------------------------------------------- */

void rk_tree_closest(const rk_tree *tree, const rk_ray_batch *rays, rk_hit_batch *hits,
                     rk_counters *counters)
{
    if (tree->kernel)
        tree->kernel->closest(tree->wide, rays, hits, counters);
    for (uint32_t i = 0; !tree->kernel && i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        rk_hit hit = rk_bvh_closest(tree->bvh, &ray, counters);
        rk_batch_put_hit(hits, i, &hit);
    }
}

void rk_tree_occluded(const rk_tree *tree, const rk_ray_batch *rays, rk_occlusion_batch *answers,
                      rk_counters *counters)
{
    if (tree->kernel)
        tree->kernel->occluded(tree->wide, rays, answers, counters);
    for (uint32_t i = 0; !tree->kernel && i < rays->count; i++) {
        rk_ray ray = rk_batch_ray(rays, i);
        answers->occluded[i] = rk_bvh_occluded(tree->bvh, &ray, counters);
    }
}

/* --- Leaves ----------------------------------------------------------------------------------- */

/* A node that the ray enters, and where. */
typedef struct entered_node {
    const rk_bvh_node *node;
    float at;
} entered_node;

static void visit_binary_leaves(const rk_bvh *bvh, const rk_ray *ray, rk_leaf_visitor *visitor,
                                rk_counters *counters)
{
    const rk_slabs slabs = rk_slabs_of(ray);
    entered_node stack[RK_BVH_LEVELS_MAX + 1]; /* the last comes next */
    const float at_root = rk_box_enter(&bvh->nodes[0].box, &slabs, visitor->end);
    uint32_t left = at_root < INFINITY;
    stack[0] = (entered_node){bvh->nodes, at_root};
    counters->box_tests++;
    while (left > 0) {
        const rk_bvh_node *node = stack[--left].node;
        if (stack[left].at > visitor->end)
            continue;
        if (node->count > 0) {
            visitor->visit(visitor, &bvh->triangles[node->first], node->count);
            continue;
        }
        /* The nearer half comes next: its triangles may end the ray before the other. */
        const rk_bvh_node *half = &bvh->nodes[node->first];
        const float at[2] = {rk_box_enter(&half[0].box, &slabs, visitor->end),
                             rk_box_enter(&half[1].box, &slabs, visitor->end)};
        const int nearer = at[1] < at[0];
        stack[left] = (entered_node){&half[1 - nearer], at[1 - nearer]};
        left += at[1 - nearer] < INFINITY;
        stack[left] = (entered_node){&half[nearer], at[nearer]};
        left += at[nearer] < INFINITY;
        counters->box_tests += 2;
    }
}

void rk_tree_visit_leaves(const rk_tree *tree, const rk_ray *ray, rk_leaf_visitor *visitor,
                          rk_counters *counters)
{
    if (tree->kernel)
        tree->kernel->visit_leaves(tree->wide, ray, visitor, counters);
    else if (tree->bvh->node_count > 0)
        visit_binary_leaves(tree->bvh, ray, visitor, counters);
}

/* --- Does a tree find anything? --------------------------------------------------------------- */

enum { TRIED = 64 }; /* rays; a tree that finds any triangle usually finds the first */

static bool finds(const rk_tree *tree, const rk_ray *ray)
{
    rk_counters counters = {0};
    rk_ray_batch rays;
    rk_hit_batch hits;
    rays.count = 0;
    rk_batch_push(&rays, ray);
    rk_tree_closest(tree, &rays, &hits, &counters);
    return hits.triangle[0] != RK_MISS;
}

/* A ray towards the middle of a triangle; false if it has no area, or one beyond the largest float.
 */
static bool aim(rk_ray *ray, const rk_mesh *mesh, uint32_t triangle)
{
    rk_triangle corners = rk_bvh_triangle_of(mesh, triangle);
    rk_vec3 normal = rk_cross(rk_sub(corners.b, corners.a), rk_sub(corners.c, corners.a));
    float size = rk_length(normal);
    if (!(size > 0) || !(size < INFINITY))
        return false;
    rk_vec3 centroid = rk_bvh_reference_of(mesh, triangle).centroid;
    rk_vec3 above = rk_madd(centroid, normal, 1 / sqrtf(size));
    *ray = (rk_ray){above, rk_scale(normal, -1 / size), INFINITY};
    return true;
}

/* Of the triangles first .. first + count - 1. */
static bool finds_triangles(rk_tree tree, const rk_mesh *mesh, uint32_t first, uint32_t count)
{
    if (count == 0)
        return true;
    if (!tree.kernel && (tree.bvh->node_count == 0 || tree.bvh->nodes[0].count > RK_BVH_LEAF_MAX))
        return false;
    const uint32_t step = count / TRIED + 1;
    bool is_tried = false;
    for (uint32_t i = 0; i < count; i++) {
        rk_ray ray;
        if (!aim(&ray, mesh, first + i))
            continue;
        if (finds(&tree, &ray))
            return true;
        is_tried = true;
        i += step - 1;
    }
    return !is_tried; /* there is nothing to find */
}

bool rk_accel_finds_triangles(const rk_accel *accel)
{
    const rk_scene *scene = accel->scene;
    const uint32_t still =
        scene->moving_count ? scene->moving[0].first : scene->mesh.triangle_count;
    bool all = finds_triangles(rk_accel_static_tree(accel), &scene->mesh, 0, still);
    for (uint32_t i = 0; all && i < scene->moving_count; i++)
        all = finds_triangles(rk_accel_moving_tree(accel, i), &scene->mesh, scene->moving[i].first,
                              scene->moving[i].count);
    return all;
}
