/* The fast builder of wide trees: sound trees of any mesh, the same for any number of threads. */
#include "short_memory.h"
#include "test_scene.h"
#include "test_soup.h"

#include "accel/build/wide_build.h"

static rk_wide_bvh build(const rk_mesh *mesh, rk_build_quality quality, rk_pool *pool)
{
    rk_wide_bvh wide;
    rk_error error = {""};
    rk_check_ok(
        rk_wide_bvh_build_parts(&wide, mesh, 0, mesh->triangle_count, quality, pool, &error),
        error);
    return wide;
}

static const char *const qualities[] = {"SAH", "Morton"};

static void check_sound(const rk_mesh *mesh, const char *name)
{
    for (int quality = RK_BUILD_SAH; quality <= RK_BUILD_MORTON; quality++) {
        rk_error error = {""};
        rk_wide_bvh wide = build(mesh, (rk_build_quality)quality, NULL);
        rk_check(rk_wide_bvh_validate(&wide, mesh, &error), "%s, %s: %s", name, qualities[quality],
                 error.text);
        rk_wide_bvh_free(&wide);
    }
}

static void trees_of_scenes_are_sound(void **state)
{
    /* Of the fine teapot some subtrees outgrow their part of the memory, and all still fit. */
    static const char *const names[] = {"triangle",   "cornell",      "teapot",
                                        "statue:967", "statue:20000", "teapot:40"};
    (void)state;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        check_sound(&scene.mesh, names[i]);
        rk_scene_free(&scene);
    }
}

static void trees_of_every_small_size_are_sound(void **state)
{
    (void)state;
    for (uint32_t count = 0; count < 300; count++) {
        rk_mesh mesh = make_soup(count, 0.1f, count);
        char name[32];
        snprintf(name, sizeof name, "%u triangles", count);
        check_sound(&mesh, name);
        rk_mesh_free(&mesh);
    }
}

/* Each of these leaves bins without use: centroids that coincide, that differ on one axis only, or
 * that get denser and denser, so that each split takes off one triangle. */
static void trees_of_difficult_meshes_are_sound(void **state)
{
    enum { count = 3000, shapes = 6 };
    static const char *const names[shapes] = {"coinciding",        "on a line",
                                              "denser and denser", "the largest",
                                              "denormal",          "one huge, the rest tiny"};
    (void)state;
    for (int shape = 0; shape < shapes; shape++) {
        rk_mesh mesh = make_mesh(count);
        for (uint32_t i = 0; i < 3 * count; i++) {
            const rk_vec3 corner = noise3(7, i), one = noise3(8, i % 3);
            const float place = (float)(i / 3) / count;
            const rk_vec3 points[shapes] = {
                one,
                rk_vec(place, 0, 0),
                rk_madd(rk_vec(ldexpf(1, -(int)(i / 3) % 140), 0, 0), one, 1e-30f),
                rk_scale(corner, FLT_MAX),
                rk_scale(corner, 100 * FLT_TRUE_MIN),
                i < 3 ? rk_scale(one, 1e30f) : rk_scale(corner, 1e-30f),
            };
            mesh.positions[i] = points[shape];
        }
        check_sound(&mesh, names[shape]);
        rk_mesh_free(&mesh);
    }
}

static void a_part_of_a_mesh_keeps_its_indices(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(500, 0.1f, 3);
    rk_wide_bvh wide;
    rk_error error = {""};
    rk_check_ok(rk_wide_bvh_build_parts(&wide, &mesh, 200, 100, RK_BUILD_SAH, NULL, &error), error);
    uint32_t seen[500] = {0};
    for (uint32_t i = 0; i < wide.block_count; i++)
        for (uint32_t k = 0; k < RK_WIDE_BLOCK; k++)
            seen[wide.blocks[i].index[k]] = 1;
    for (uint32_t i = 0; i < 500; i++)
        rk_check(seen[i] == (i >= 200 && i < 300), "triangle %u is %s the tree over 200 to 299", i,
                 seen[i] ? "in" : "not in");
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

static void check_same(const rk_wide_bvh *got, const rk_wide_bvh *want, const char *when)
{
    rk_check(got->node_count == want->node_count && got->block_count == want->block_count,
             "%s: %u nodes and %u blocks, want %u and %u", when, got->node_count, got->block_count,
             want->node_count, want->block_count);
    for (uint32_t i = 0; i < got->node_count; i++)
        rk_check(memcmp(got->nodes[i].child, want->nodes[i].child, sizeof got->nodes[i].child) == 0,
                 "%s: node %u has other children", when, i);
    for (uint32_t i = 0; i < got->block_count; i++)
        rk_check(memcmp(got->blocks[i].index, want->blocks[i].index, sizeof got->blocks[i].index) ==
                     0,
                 "%s: block %u has other triangles", when, i);
}

/* Large enough that threads share the first splits. */
static void the_tree_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(150000, 0.01f, 5);
    for (int quality = RK_BUILD_SAH; quality <= RK_BUILD_MORTON; quality++) {
        rk_wide_bvh want = build(&mesh, (rk_build_quality)quality, NULL);
        for (uint32_t threads = 1; threads <= 5; threads += 2) {
            char when[32];
            rk_error error = {""};
            rk_pool *pool = rk_pool_start(threads, &error);
            rk_check_ok(pool != NULL, error);
            rk_wide_bvh got = build(&mesh, (rk_build_quality)quality, pool);
            snprintf(when, sizeof when, "%s, %u threads", qualities[quality], threads);
            rk_check(rk_wide_bvh_validate(&got, &mesh, &error), "%s: %s", when, error.text);
            check_same(&got, &want, when);
            rk_wide_bvh_free(&got);
            rk_pool_stop(pool);
        }
        rk_wide_bvh_free(&want);
    }
    rk_mesh_free(&mesh);
}

/* A thread that builds a subtree cannot call for the others' help. Each cluster of coinciding
 * triangles becomes a subtree, so large that threads would share it if it were at the top. */
static void subtrees_of_a_huge_mesh_are_built_by_one_thread_each(void **state)
{
    enum { clusters = 64, copies = RK_PART_LARGE + 8 };
    (void)state;
    rk_mesh mesh;
    rk_error error = {""};
    rk_check_ok(rk_mesh_init(&mesh, 3 * clusters, clusters * copies, 1, 0, &error), error);
    for (uint32_t i = 0; i < clusters; i++) {
        mesh.positions[3 * i] = rk_vec((float)i, 0, 0);
        mesh.positions[3 * i + 1] = rk_vec((float)i + 0.5f, 0, 0);
        mesh.positions[3 * i + 2] = rk_vec((float)i, 0.5f, 0);
        for (uint32_t k = 0; k < copies; k++)
            for (uint32_t corner = 0; corner < 3; corner++)
                mesh.triangles[i * copies + k][corner] = 3 * i + corner;
    }
    rk_pool *pool = rk_pool_start(2, &error);
    rk_check_ok(pool != NULL, error);
    rk_wide_bvh wide = build(&mesh, RK_BUILD_SAH, pool);
    rk_check(rk_wide_bvh_validate(&wide, &mesh, &error), "%s", error.text);
    rk_wide_bvh_free(&wide);
    rk_pool_stop(pool);
    rk_mesh_free(&mesh);
}

/* Scaled by a power of two, all roundings stay the same. Areas of such sizes would be 0 or infinite
 * in float, if they were not taken relative to the whole mesh's. */
static void the_tree_is_the_same_at_any_scale(void **state)
{
    static const int powers[] = {-100, -60, 60, 100};
    (void)state;
    rk_mesh mesh = make_soup(3000, 0.05f, 9);
    for (int i = 0; i < 8; i++) {
        const rk_build_quality quality = i < 4 ? RK_BUILD_SAH : RK_BUILD_MORTON;
        rk_wide_bvh want = build(&mesh, quality, NULL);
        rk_mesh scaled = make_soup(3000, 0.05f, 9);
        char when[32];
        for (uint32_t k = 0; k < scaled.vertex_count; k++)
            scaled.positions[k] = rk_scale(scaled.positions[k], ldexpf(1, powers[i % 4]));
        rk_wide_bvh got = build(&scaled, quality, NULL);
        snprintf(when, sizeof when, "%s, scaled by 2^%d", qualities[quality], powers[i % 4]);
        check_same(&got, &want, when);
        rk_wide_bvh_free(&want);
        rk_wide_bvh_free(&got);
        rk_mesh_free(&scaled);
    }
    rk_mesh_free(&mesh);
}

/* The expected number of nodes and blocks that a ray through the root's box visits. */
static double wide_cost(const rk_wide_bvh *wide)
{
    double area = 0;
    rk_box root = rk_box_empty();
    for (uint32_t k = 0; k < RK_WIDE_CHILDREN; k++)
        root = rk_box_merge(root, rk_wide_box(&wide->nodes[0], k));
    for (uint32_t i = 0; i < wide->node_count; i++)
        for (uint32_t k = 0; k < RK_WIDE_CHILDREN; k++) {
            const uint32_t child = wide->nodes[i].child[k];
            area += rk_box_area(rk_wide_box(&wide->nodes[i], k)) *
                    (child & RK_WIDE_LEAF ? rk_wide_leaf_count(child) : 1);
        }
    return 1 + area / rk_box_area(root);
}

static void the_cost_is_low(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("statue:20000");
    rk_wide_bvh sah = build(&scene.mesh, RK_BUILD_SAH, NULL);
    rk_wide_bvh morton = build(&scene.mesh, RK_BUILD_MORTON, NULL);
    double cost[2] = {wide_cost(&sah), wide_cost(&morton)};
    rk_check(cost[0] < 0.9 * cost[1], "a ray takes %.2f steps by SAH, %.2f by Morton codes",
             cost[0], cost[1]);
    rk_check(cost[1] < 20, "a ray takes %.2f steps by Morton codes, want less than 20", cost[1]);
    rk_wide_bvh_free(&sah);
    rk_wide_bvh_free(&morton);
    rk_scene_free(&scene);
}

static void a_triangle_takes_no_more_than_80_bytes(void **state)
{
    (void)state;
    for (uint32_t count = 1000; count <= 16000; count *= 4) {
        char name[32];
        snprintf(name, sizeof name, "statue:%u", count);
        rk_scene scene = test_scene_builtin(name);
        rk_wide_bvh wide = build(&scene.mesh, RK_BUILD_SAH, NULL);
        size_t bytes =
            wide.node_count * sizeof *wide.nodes + wide.block_count * sizeof *wide.blocks;
        rk_check(bytes <= 80 * (size_t)count, "%s: %zu bytes for a triangle, want at most 80", name,
                 bytes / count);
        rk_wide_bvh_free(&wide);
        rk_scene_free(&scene);
    }
}

static void no_memory_is_an_error_and_keeps_none(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(6000, 0.05f, 11);
    bool built = false;
    for (size_t granted = 0; !built; granted++) {
        rk_wide_bvh wide;
        rk_error error = {""};
        size_t before = rk_allocations_kept;
        rk_allocations_left = granted;
        built = rk_wide_bvh_build_parts(&wide, &mesh, 0, 6000, RK_BUILD_SAH, NULL, &error);
        rk_allocations_left = SIZE_MAX;
        if (built)
            rk_wide_bvh_free(&wide);
        else
            rk_check(error.text[0] && !wide.nodes && !wide.blocks && wide.node_count == 0,
                     "allocation %zu failed: got no sentence or a part of a tree", granted + 1);
        rk_check(rk_allocations_kept == before, "allocation %zu failed: %zu earlier ones are kept",
                 granted + 1, rk_allocations_kept - before);
        rk_check(!built || granted > 4, "%zu allocations were enough, want more than 4", granted);
    }
    rk_mesh_free(&mesh);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(trees_of_scenes_are_sound),
    cmocka_unit_test(trees_of_every_small_size_are_sound),
    cmocka_unit_test(trees_of_difficult_meshes_are_sound),
    cmocka_unit_test(a_part_of_a_mesh_keeps_its_indices),
    cmocka_unit_test(the_tree_is_the_same_for_any_number_of_threads),
    cmocka_unit_test(subtrees_of_a_huge_mesh_are_built_by_one_thread_each),
    cmocka_unit_test(the_tree_is_the_same_at_any_scale),
    cmocka_unit_test(the_cost_is_low),
    cmocka_unit_test(a_triangle_takes_no_more_than_80_bytes),
    cmocka_unit_test(no_memory_is_an_error_and_keeps_none),
};

RK_SUITE("wide_build", tests)
