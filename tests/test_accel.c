/* Trees of all kinds: the same hits, and trees that find nothing, as starters build them, are told.
 */
#include "test_scene.h"
#include "test_soup.h"

#include "accel/query/trace.h"
#include "accel/query/tree.h"
#include "features/watertight.h"
#include "scene/bvh_build.h"

static const char *const names[] = {"triangle", "cornell", "statue:967", "moving", "spheres"};
enum { name_count = sizeof names / sizeof *names };

static rk_accel accel_of(const rk_scene *scene, rk_accel_kind kind)
{
    rk_accel accel;
    rk_error error;
    rk_check_ok(rk_accel_build(&accel, kind, scene, &error), error);
    return accel;
}

static rk_mesh part_of(const rk_scene *scene, uint32_t first, uint32_t count)
{
    rk_mesh part = scene->mesh;
    part.triangles += first;
    part.triangle_materials += first;
    part.triangle_count = count;
    return part;
}

/* --- The wide tree in binary ------------------------------------------------------------------ */

static void binary_trees_of_moving_objects_are_sound(void **state)
{
    (void)state;
    const char *const moving[] = {"moving", "cover:500"};
    for (int i = 0; i < 2; i++) {
        rk_scene scene = test_scene_builtin(moving[i]);
        rk_accel accel = accel_of(&scene, RK_ACCEL_WIDE);
        rk_check(scene.moving_count > 0, "%s: nothing moves", moving[i]);
        for (uint32_t k = 0; k < scene.moving_count; k++) {
            rk_bvh *bvh = &accel.moving[k];
            rk_error error;
            rk_mesh part = part_of(&scene, scene.moving[k].first, bvh->triangle_count);
            for (uint32_t t = 0; t < bvh->triangle_count; t++)
                bvh->triangles[t].index -= scene.moving[k].first;
            rk_check(rk_bvh_validate(bvh, &part, &error), "%s, object %u: %s", moving[i], k,
                     error.text);
        }
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
}

static void binary_trees_of_every_small_size_are_sound(void **state)
{
    (void)state;
    for (uint32_t count = 0; count < 70; count++) {
        rk_scene scene = test_scene_make(count);
        for (uint32_t i = 0; i < count; i++)
            test_scene_triangle(&scene, i, noise3(1, i), noise3(2, i), noise3(3, i));
        rk_accel accel = accel_of(&scene, RK_ACCEL_WIDE);
        rk_bvh bvh;
        rk_error error;
        rk_check_ok(rk_bvh_of_wide(&bvh, &accel.wide, &error), error);
        rk_check(rk_bvh_validate(&bvh, &scene.mesh, &error), "%u triangles: %s", count, error.text);
        rk_bvh_free(&bvh);
        rk_accel_free(&accel);
        rk_scene_free(&scene);
    }
}

/* A chain of nodes, one within the other, each with a leaf beside it. */
static void a_binary_tree_is_never_too_deep(void **state)
{
    (void)state;
    enum { levels = RK_BVH_LEVELS_MAX };
    rk_scene scene = test_scene_make(levels);
    for (uint32_t i = 0; i < levels; i++)
        test_scene_triangle(&scene, i, noise3(1, i), noise3(2, i), noise3(3, i));
    rk_wide_bvh wide;
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_wide_bvh_init(&wide, levels, levels, levels, &error), error);
    const rk_box all = {{{-9, -9, -9}, {9, 9, 9}}};
    for (uint32_t i = 0; i < levels; i++) {
        rk_wide_node *node = &wide.nodes[i];
        const uint32_t child[3] = {rk_wide_leaf(i, 1), i + 1 < levels ? i + 1 : rk_wide_leaf(0, 0),
                                   rk_wide_leaf(0, 0)};
        for (uint32_t k = 0; k < RK_WIDE_CHILDREN; k++) {
            node->child[k] = child[k < 2 ? k : 2];
            const rk_box box = k < 2 && (k == 0 || i + 1 < levels) ? all : rk_box_empty();
            for (int side = 0; side < 2; side++)
                for (int axis = 0; axis < 3; axis++)
                    node->side[side][axis][k] = rk_axis(box.corner[side], axis);
        }
        rk_triangle triangle = rk_bvh_triangle_of(&scene.mesh, i);
        for (int k = 0; k < RK_WIDE_BLOCK; k++) {
            for (int axis = 0; axis < 3; axis++) {
                wide.blocks[i].corner[0][axis][k] = rk_axis(triangle.a, axis);
                wide.blocks[i].corner[1][axis][k] = rk_axis(triangle.b, axis);
                wide.blocks[i].corner[2][axis][k] = rk_axis(triangle.c, axis);
            }
            wide.blocks[i].index[k] = i;
        }
    }
    wide.node_count = wide.block_count = levels;
    rk_check_ok(rk_bvh_of_wide(&bvh, &wide, &error), error);
    rk_check(rk_bvh_measure(&bvh).levels <= RK_BVH_LEVELS_MAX, "%u levels",
             rk_bvh_measure(&bvh).levels);
    rk_check_equal(bvh.triangle_count, levels, "triangles");
    rk_bvh_free(&bvh);
    rk_wide_bvh_free(&wide);
    rk_scene_free(&scene);
}

/* --- The same hits ---------------------------------------------------------------------------- */

static rk_ray_batch make_rays(uint32_t key)
{
    rk_ray_batch rays = {.count = 0};
    for (uint32_t i = 0; i < RK_BATCH_MAX; i++) {
        rk_vec3 from = rk_scale(noise3(key, 2 * i), 3), to = noise3(key, 2 * i + 1);
        rk_ray ray = {from, rk_sub(to, from), i % 3 == 0 ? 0.9f : INFINITY};
        rk_batch_push(&rays, &ray);
    }
    return rays;
}

static void all_kinds_find_the_same_hits(void **state)
{
    (void)state;
    for (int i = 0; i < name_count; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        rk_accel median = accel_of(&scene, RK_ACCEL_MEDIAN);
        rk_ray_batch rays = make_rays(40 + (uint32_t)i);
        rk_counters counters = {0};
        rk_hit_batch want, got;
        rk_occlusion_batch occluded, wanted;
        rk_accel_closest(&median, &rays, &want, &counters);
        rk_accel_occluded(&median, &rays, &wanted, &counters);
        for (int kind = RK_ACCEL_SAH; kind <= RK_ACCEL_WIDE; kind++) {
            rk_accel accel = accel_of(&scene, (rk_accel_kind)kind);
            rk_accel_closest(&accel, &rays, &got, &counters);
            rk_accel_occluded(&accel, &rays, &occluded, &counters);
            for (uint32_t k = 0; k < rays.count; k++)
                rk_check(got.t[k] == want.t[k] && got.triangle[k] == want.triangle[k] &&
                             occluded.occluded[k] == wanted.occluded[k],
                         "%s, kind %d, ray %u: hit %d at %g, occluded %d; want %d at %g, %d",
                         names[i], kind, k, (int)got.triangle[k], (double)got.t[k],
                         occluded.occluded[k], (int)want.triangle[k], (double)want.t[k],
                         wanted.occluded[k]);
            rk_accel_free(&accel);
        }
        rk_accel_free(&median);
        rk_scene_free(&scene);
    }
}

/* A visitor that looks at all leaves on the way, whatever it finds in them. */
typedef struct census {
    rk_leaf_visitor visitor;
    uint32_t triangles;
    uint32_t *seen; /* of each triangle */
} census;

static void count_leaf(rk_leaf_visitor *visitor, const rk_triangle *triangles, uint32_t count)
{
    census *c = (census *)visitor;
    c->triangles += count;
    for (uint32_t i = 0; i < count; i++)
        c->seen[triangles[i].index]++;
}

static void a_visitor_sees_each_triangle_that_is_hit_once(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("statue:967");
    uint32_t *seen = test_malloc(scene.mesh.triangle_count * sizeof *seen);
    for (int kind = RK_ACCEL_MEDIAN; kind <= RK_ACCEL_WIDE; kind++) {
        rk_accel accel = accel_of(&scene, (rk_accel_kind)kind);
        const rk_tree tree = rk_accel_static_tree(&accel);
        uint32_t hits = 0, visited = 0;
        for (uint32_t key = 0; key < 300; key++) {
            rk_vec3 from = rk_scale(noise3(key, 0), 3), to = noise3(key, 1);
            rk_ray ray = {from, rk_sub(to, from), INFINITY};
            rk_counters counters = {0};
            census c = {{count_leaf, INFINITY}, 0, seen};
            memset(seen, 0, scene.mesh.triangle_count * sizeof *seen);
            rk_tree_visit_leaves(&tree, &ray, &c.visitor, &counters);
            for (uint32_t i = 0; i < scene.mesh.triangle_count; i++) {
                rk_triangle triangle = rk_bvh_triangle_of(&scene.mesh, i);
                bool is_hit = rk_watertight_intersect(&triangle, &ray).triangle != RK_MISS;
                rk_check(seen[i] <= 1 && seen[i] >= is_hit,
                         "kind %d, ray %u: triangle %u is seen %u times, hit %d", kind, key, i,
                         seen[i], is_hit);
                hits += is_hit;
            }
            visited += c.triangles;
            c = (census){{count_leaf, -1}, 0, seen};
            rk_tree_visit_leaves(&tree, &ray, &c.visitor, &counters);
            rk_check_equal(c.triangles, 0, "triangles beyond the end");
        }
        rk_check(hits > 100 && visited < 300 * scene.mesh.triangle_count / 4,
                 "kind %d: %u hits, %u triangles visited", kind, hits, visited);
        rk_accel_free(&accel);
    }
    test_free(seen);
    rk_scene_free(&scene);
}

/* --- Trees that find nothing ------------------------------------------------------------------ */

static void real_trees_find_triangles(void **state)
{
    (void)state;
    for (int i = 0; i < name_count; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        for (int kind = RK_ACCEL_MEDIAN; kind <= RK_ACCEL_WIDE; kind++) {
            rk_accel accel;
            rk_error error;
            rk_check_ok(rk_accel_build(&accel, (rk_accel_kind)kind, &scene, &error), error);
            rk_check(rk_accel_finds_triangles(&accel), "%s, kind %d: no triangle is found",
                     names[i], kind);
            rk_accel_free(&accel);
        }
        rk_scene_free(&scene);
    }
}

/* What the starters build. */
/* As in cones: of each square at the tip one half has no area. Or there is nothing to find. */
static void a_tree_is_not_blamed_for_triangles_without_area(void **state)
{
    (void)state;
    enum { count = 128 };
    for (uint32_t period = 1; period <= 4; period++)
        for (uint32_t thick = 0; thick < period; thick++) {
            rk_scene scene = test_scene_make(count);
            for (uint32_t i = 0; i < count; i++) {
                rk_vec3 a = noise3(1, i), b = noise3(2, i);
                const bool is_flat = period == 1 || i % period != thick;
                test_scene_triangle(&scene, i, a, b, is_flat ? b : noise3(3, i));
            }
            rk_accel accel = accel_of(&scene, RK_ACCEL_SAH);
            rk_check(rk_accel_finds_triangles(&accel),
                     "of each %u triangles number %u has an area: no triangle is found", period,
                     thick);
            rk_accel_free(&accel);
            rk_scene_free(&scene);
        }
}

static void a_tree_with_an_empty_root_or_a_huge_leaf_finds_none(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("statue:967");
    rk_accel accel;
    rk_error error;
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_MEDIAN, &scene, &error), error);
    rk_bvh_node root = accel.bvh.nodes[0];
    accel.bvh.nodes[0] = (rk_bvh_node){rk_box_empty(), 0, 4};
    rk_check(!rk_accel_finds_triangles(&accel), "triangles are found through an empty box");
    accel.bvh.nodes[0] = (rk_bvh_node){root.box, 0, accel.bvh.triangle_count};
    rk_check(!rk_accel_finds_triangles(&accel), "a leaf of all triangles passes for a tree");
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(binary_trees_of_moving_objects_are_sound),
    cmocka_unit_test(binary_trees_of_every_small_size_are_sound),
    cmocka_unit_test(a_binary_tree_is_never_too_deep),
    cmocka_unit_test(all_kinds_find_the_same_hits),
    cmocka_unit_test(a_visitor_sees_each_triangle_that_is_hit_once),
    cmocka_unit_test(real_trees_find_triangles),
    cmocka_unit_test(a_tree_is_not_blamed_for_triangles_without_area),
    cmocka_unit_test(a_tree_with_an_empty_root_or_a_huge_leaf_finds_none),
};

RK_SUITE("accel", tests)
