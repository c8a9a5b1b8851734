#include "accel/stand_in_tree.h"

#include "scene/bvh_build.h"

/* --- Does a tree find anything? ------------------------------------------------------------------
 */

/* Rays that are tried; a tree that finds any triangle usually finds the first. */
enum { TRIED = 64 };

static bool finds_triangles(const rk_bvh *bvh, const rk_mesh *mesh, uint32_t first)
{
    if (bvh->triangle_count == 0)
        return true;
    if (bvh->node_count == 0 || bvh->nodes[0].count > RK_BVH_LEAF_MAX)
        return false;
    uint32_t step = bvh->triangle_count / TRIED + 1;
    for (uint32_t i = 0; i < bvh->triangle_count; i += step) {
        rk_triangle triangle = rk_bvh_triangle_of(mesh, first + i);
        rk_vec3 normal = rk_cross(rk_sub(triangle.b, triangle.a), rk_sub(triangle.c, triangle.a));
        float size = rk_length(normal);
        if (!(size > 0) || !(size < INFINITY))
            continue;
        rk_vec3 centroid = rk_bvh_reference_of(mesh, first + i).centroid;
        rk_vec3 above = rk_madd(centroid, normal, 1 / sqrtf(size));
        const rk_ray ray = {above, rk_scale(normal, -1 / size), INFINITY};
        if (rk_bvh_closest(bvh, &ray, &(rk_counters){0}).triangle != RK_MISS)
            return true;
    }
    return false;
}

bool rk_accel_finds_triangles(const rk_accel *accel)
{
    const rk_scene *scene = accel->scene;
    bool finds = finds_triangles(&accel->bvh, &scene->mesh, 0);
    for (uint32_t i = 0; finds && i < scene->moving_count; i++)
        finds = finds_triangles(&accel->moving[i], &scene->mesh, scene->moving[i].first);
    return finds;
}

/* --- The tree ------------------------------------------------------------------------------------
 */

static rk_box box_of_leaf(const rk_mesh *mesh, uint32_t first, uint32_t count)
{
    const uint32_t *corners = mesh->triangles[first];
    rk_vec3 low = mesh->positions[corners[0]], high = low;
    for (uint32_t i = 1; i < 3 * count; i++) {
        low = rk_min3(low, mesh->positions[corners[i]]);
        high = rk_max3(high, mesh->positions[corners[i]]);
    }
    return (rk_box){{low, high}};
}

/* Node h has the children 2h and 2h + 1; the last half of all are leaves. The root, h = 1, is
 * nodes[0], any other nodes[h]. */
static bool build_part(rk_bvh *bvh, const rk_mesh *mesh, uint32_t first, uint32_t count,
                       rk_error *error)
{
    uint32_t leaves = (count + RK_BVH_LEAF_TARGET - 1) / RK_BVH_LEAF_TARGET;
    if (!rk_bvh_init(bvh, count, count, error))
        return false;
    if (count == 0)
        return true;
    for (uint32_t i = 0; i < count; i++)
        bvh->triangles[i] = rk_bvh_triangle_of(mesh, first + i);
    for (uint32_t h = 2 * leaves - 1; h > 0; h--) {
        rk_bvh_node *node = &bvh->nodes[h == 1 ? 0 : h];
        if (h < leaves) {
            const rk_bvh_node *pair = &bvh->nodes[2 * h];
            *node = (rk_bvh_node){rk_box_merge(pair[0].box, pair[1].box), 2 * h, 0};
            continue;
        }
        uint32_t begin = (h - leaves) * RK_BVH_LEAF_TARGET;
        uint32_t size = count - begin < RK_BVH_LEAF_TARGET ? count - begin : RK_BVH_LEAF_TARGET;
        *node = (rk_bvh_node){box_of_leaf(mesh, first + begin, size), begin, size};
    }
    bvh->node_count = leaves > 1 ? 2 * leaves : 2;
    bvh->is_stand_in = true;
    return true;
}

bool rk_accel_build_stand_in(rk_accel *accel, const rk_scene *scene, rk_error *error)
{
    *accel = (rk_accel){.scene = scene};
    uint32_t still = scene->moving_count ? scene->moving[0].first : scene->mesh.triangle_count;
    bool ok = build_part(&accel->bvh, &scene->mesh, 0, still, error);
    for (uint32_t i = 0; ok && i < scene->moving_count; i++)
        ok = build_part(&accel->moving[i], &scene->mesh, scene->moving[i].first,
                        scene->moving[i].count, error);
    if (!ok)
        rk_accel_free(accel);
    return ok;
}
