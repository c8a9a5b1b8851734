/* Trees too large for make check, split at the median and by the surface area heuristic.
 * RAYKIT_STRESS is the factor over make check, which builds 100,000 triangles; make stress builds
 * 10 million. */
#include "../test.h"

#include "base/random.h"
#include "features/bvh_median.h"
#include "features/sah_binning.h"

static uint32_t triangle_count(void)
{
    const char *factor = getenv("RAYKIT_STRESS");
    return 100000 * (uint32_t)(factor ? strtoul(factor, NULL, 10) : 1);
}

static float noise(uint32_t i, uint32_t axis)
{
    return 2 * rk_unit_float(rk_hash(i, axis, 5, 5)) - 1;
}

/* Triangles of the given size, scattered in a cube; with size 0 all at one point. */
static rk_mesh make_soup(uint32_t triangles, float size)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 3 * triangles, triangles, 1, 0, &error), error);
    for (uint32_t i = 0; i < 3 * triangles; i++) {
        rk_vec3 centre =
            size > 0 ? rk_vec(noise(i / 3, 0), noise(i / 3, 1), noise(i / 3, 2)) : rk_vec(0, 0, 0);
        rk_vec3 corner = rk_vec(noise(i, 3), noise(i, 4), noise(i, 5));
        mesh.positions[i] = rk_madd(centre, corner, size);
        mesh.triangles[i / 3][i % 3] = i;
    }
    return mesh;
}

/* The expected counts of halving with the larger half to the left. */
static rk_bvh_measures halve(uint32_t count)
{
    if (count <= RK_BVH_LEAF_TARGET)
        return (rk_bvh_measures){count > 0, count > 0, 0};
    rk_bvh_measures left = halve(count - count / 2), right = halve(count / 2);
    return (rk_bvh_measures){1 + (left.levels > right.levels ? left.levels : right.levels),
                             left.leaves + right.leaves, 0};
}

/* By the heuristic: valid, and no more expensive than the median's tree. */
static void check_heuristic(const rk_mesh *mesh, double median_cost)
{
    for (int all_axes = 0; all_axes < 2; all_axes++) {
        const rk_sah_options options = {50, all_axes};
        rk_bvh bvh;
        rk_error error;
        rk_check_ok(rk_bvh_build_sah(&bvh, mesh, &options, &error), error);
        rk_check_ok(rk_bvh_validate(&bvh, mesh, &error), error);
        double cost = rk_bvh_measure(&bvh).sah_cost;
        rk_check(cost <= median_cost,
                 "%u triangles: got a cost of %.6g, want %.6g at most, the "
                 "median's",
                 mesh->triangle_count, cost, median_cost);
        rk_bvh_free(&bvh);
    }
}

static void check_size(uint32_t triangles, float size)
{
    rk_mesh mesh = make_soup(triangles, size);
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_build_median(&bvh, &mesh, &error), error);
    rk_check_ok(rk_bvh_validate(&bvh, &mesh, &error), error);
    rk_bvh_measures got = rk_bvh_measure(&bvh), want = halve(triangles);
    rk_check_equal(got.levels, want.levels, "levels of halving");
    rk_check_equal(got.leaves, want.leaves, "leaves of halving");
    rk_bvh_free(&bvh);
    check_heuristic(&mesh, got.sah_cost);
    rk_mesh_free(&mesh);
}

static void a_huge_soup_gives_a_valid_tree_as_deep_as_halving(void **state)
{
    (void)state;
    check_size(triangle_count(), 0.001f);
}

static void as_many_triangles_at_one_point_do_too(void **state)
{
    (void)state;
    check_size(triangle_count(), 0);
}

static void so_does_every_size_up_to_a_few_thousand(void **state)
{
    (void)state;
    for (uint32_t n = 0; n <= triangle_count() / 300; n += 1 + n / 50)
        check_size(n, 0.1f);
}

/* The triangles of each octave are half as large and half as far away as those before: the deepest
 * tree possible with floats would need more levels than allowed. */
static void a_progression_of_all_octaves_keeps_to_the_levels(void **state)
{
    (void)state;
    const uint32_t octaves = 250, each = triangle_count() / octaves;
    rk_mesh mesh = make_soup(octaves * each, 0.05f);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        mesh.positions[i] = rk_scale(rk_add(mesh.positions[i], rk_vec(3, 0, 0)),
                                     ldexpf(1, 124 - (int)(i / 3 / each)));
    for (uint32_t bins = 2; bins <= 256; bins *= 2) {
        const rk_sah_options options = {bins, false};
        rk_bvh bvh;
        rk_error error;
        rk_check_ok(rk_bvh_build_sah(&bvh, &mesh, &options, &error), error);
        rk_check_ok(rk_bvh_validate(&bvh, &mesh, &error), error);
        rk_bvh_free(&bvh);
    }
    rk_mesh_free(&mesh);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_huge_soup_gives_a_valid_tree_as_deep_as_halving),
    cmocka_unit_test(as_many_triangles_at_one_point_do_too),
    cmocka_unit_test(so_does_every_size_up_to_a_few_thousand),
    cmocka_unit_test(a_progression_of_all_octaves_keeps_to_the_levels),
};

RK_SUITE("stress bvh_median", tests)
