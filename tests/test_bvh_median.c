/* The bounding volume hierarchy split by the median: its shape, its soundness, and that rays find
 * in it just what they find by trying every triangle. */
#include "test.h"

#include "base/random.h"
#include "features/bvh_median.h"

/* --- Meshes and rays to try ----------------------------------------------------------------- */

static rk_mesh make_mesh(uint32_t triangles)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 3 * triangles, triangles, 1, 0, &error), error);
    for (uint32_t i = 0; i < triangles; i++)
        for (uint32_t k = 0; k < 3; k++)
            mesh.triangles[i][k] = 3 * i + k;
    return mesh;
}

/* A number in [-1, 1), the same for the same three keys. */
static float noise(uint32_t a, uint32_t b, uint32_t c)
{
    return 2 * rk_unit_float(rk_hash(a, b, c, 1)) - 1;
}

static rk_vec3 noise3(uint32_t a, uint32_t b)
{
    return rk_vec(noise(a, b, 0), noise(a, b, 1), noise(a, b, 2));
}

/* Triangles of about `size` scattered in the cube [-1, 1]^3. */
static rk_mesh make_soup(uint32_t triangles, float size, uint32_t seed)
{
    rk_mesh mesh = make_mesh(triangles);
    for (uint32_t i = 0; i < triangles; i++) {
        rk_vec3 centre = noise3(seed, 4 * i);
        for (uint32_t k = 0; k < 3; k++)
            mesh.positions[3 * i + k] = rk_madd(centre, noise3(seed, 4 * i + 1 + k), size);
    }
    return mesh;
}

/* Small triangles, all alike, one at each of the given places. */
static rk_mesh make_copies_at(const rk_vec3 *places, uint32_t count)
{
    rk_mesh mesh = make_mesh(count);
    for (uint32_t i = 0; i < count; i++) {
        mesh.positions[3 * i] = places[i];
        mesh.positions[3 * i + 1] = rk_add(places[i], rk_vec(0.125f, 0, 0.0625f));
        mesh.positions[3 * i + 2] = rk_add(places[i], rk_vec(0, 0.125f, 0.0625f));
    }
    return mesh;
}

static rk_bvh build(const rk_mesh *mesh)
{
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_build_median(&bvh, mesh, &error), error);
    rk_check_ok(rk_bvh_validate(&bvh, mesh, &error), error);
    return bvh;
}

static rk_hit closest_by_trying_all(const rk_mesh *mesh, const rk_ray *ray)
{
    rk_hit hit = {ray->t_max, 0, 0, RK_MISS};
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        const uint32_t *corner = mesh->triangles[i];
        rk_vec3 a = mesh->positions[corner[0]];
        rk_triangle triangle = {a, rk_sub(mesh->positions[corner[1]], a),
                                rk_sub(mesh->positions[corner[2]], a), i};
        rk_triangle_closest(&triangle, ray, &hit);
    }
    return hit;
}

/* Rays from around the mesh through it, every eighth along an axis, some with a bounded t_max. */
static rk_ray make_ray(uint32_t i, uint32_t seed, rk_box bounds)
{
    rk_vec3 half = rk_scale(rk_box_extent(bounds), 0.5f);
    rk_vec3 centre = rk_add(bounds.corner[0], half);
    rk_vec3 from = rk_add(centre, rk_mul(rk_scale(noise3(seed, 2 * i), 2), half));
    rk_vec3 to = rk_add(centre, rk_mul(noise3(seed, 2 * i + 1), half));
    rk_vec3 direction = rk_sub(to, from);
    if (i % 8 == 0)
        direction =
            rk_vec(i % 24 == 0 ? 1.0f : 0, i % 24 == 8 ? -1.0f : 0, i % 24 == 16 ? 1.0f : 0);
    return (rk_ray){from, direction, i % 5 == 0 ? 0.75f : INFINITY};
}

/* The same triangle test on the same numbers gives the same bits, whichever way the triangle was
 * found, so nothing less than equality will do. */
static void check_against_trying_all(const rk_mesh *mesh, uint32_t rays, uint32_t seed)
{
    rk_bvh bvh = build(mesh);
    rk_box bounds = rk_mesh_bounds(mesh);
    rk_counters counters = {0};
    for (uint32_t i = 0; i < rays; i++) {
        rk_ray ray = make_ray(i, seed, bounds);
        rk_hit want = closest_by_trying_all(mesh, &ray);
        rk_hit got = rk_bvh_closest(&bvh, &ray, &counters);
        rk_check(
            got.triangle == want.triangle && got.t == want.t,
            "ray %u: got triangle %u at t = %.9g, want %u at %.9g: a box was lost, or the nearest "
            "hit was not kept",
            i, got.triangle, (double)got.t, want.triangle, (double)want.t);
        bool any = rk_bvh_any(&bvh, &ray, &counters);
        rk_check(any == (want.triangle != RK_MISS), "ray %u: any-hit says %d, trying all says %d",
                 i, any, !any);
    }
    rk_bvh_free(&bvh);
}

/* --- The tree -------------------------------------------------------------------------------- */

static void no_triangles_give_a_tree_without_nodes(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(0);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(bvh.node_count, 0, "nothing to enclose");
    rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0, 0, 1), INFINITY};
    rk_counters counters = {0};
    rk_check_equal(rk_bvh_closest(&bvh, &ray, &counters).triangle, RK_MISS, "nothing to hit");
    rk_check(!rk_bvh_any(&bvh, &ray, &counters), "nothing to hit");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void up_to_four_triangles_are_one_leaf(void **state)
{
    (void)state;
    for (uint32_t n = 1; n <= 4; n++) {
        rk_mesh mesh = make_soup(n, 0.5f, 1);
        rk_bvh bvh = build(&mesh);
        rk_check_equal(bvh.nodes[0].count, n, "the root is a leaf with all triangles");
        rk_check_equal(rk_bvh_measure(&bvh).levels, 1, "one node, one level");
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

static void five_triangles_split_three_to_two(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(5, 0.5f, 1);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(bvh.nodes[0].count, 0, "five are too many for a leaf");
    rk_check_equal(bvh.nodes[bvh.nodes[0].first].count, 3, "left gets ceil(5 / 2)");
    rk_check_equal(bvh.nodes[bvh.nodes[0].first + 1].count, 2, "right gets the rest");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void levels_and_leaves_are_those_of_halving(void **state)
{
    (void)state;
    /* Halving with the larger half to the left until 4 are left; the classic course's counts. */
    const uint32_t want[][3] = {
        {32, 4, 8}, {967, 9, 256}, {87130, 16, 32768}, {4, 1, 1}, {9, 3, 3}};
    for (size_t i = 0; i < sizeof want / sizeof *want; i++) {
        rk_mesh mesh = make_soup(want[i][0], 0.01f, 2);
        rk_bvh bvh = build(&mesh);
        rk_bvh_measures got = rk_bvh_measure(&bvh);
        rk_check_equal(got.levels, want[i][1], "levels, the root's included");
        rk_check_equal(got.leaves, want[i][2], "leaves");
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

/* Sums up what is below a node. */
typedef struct below {
    uint32_t count;
    rk_box box;
    float lowest[3], highest[3]; /* of the centroids, for each axis */
} below;

static float centroid(const rk_mesh *mesh, uint32_t triangle, int axis)
{
    float sum = 0;
    for (int k = 0; k < 3; k++)
        sum += rk_axis(mesh->positions[mesh->triangles[triangle][k]], axis);
    return sum * (1.0f / 3);
}

static void add_triangle(below *b, const rk_mesh *mesh, uint32_t triangle)
{
    b->count++;
    for (int k = 0; k < 3; k++) {
        b->box = rk_box_add(b->box, mesh->positions[mesh->triangles[triangle][k]]);
        b->lowest[k] = rk_min(b->lowest[k], centroid(mesh, triangle, k));
        b->highest[k] = rk_max(b->highest[k], centroid(mesh, triangle, k));
    }
}

static below merge(below a, const below *b)
{
    a.count += b->count;
    a.box = rk_box_merge(a.box, b->box);
    for (int k = 0; k < 3; k++) {
        a.lowest[k] = rk_min(a.lowest[k], b->lowest[k]);
        a.highest[k] = rk_max(a.highest[k], b->highest[k]);
    }
    return a;
}

/* Checks the subtree of a node against the definition; recursion is at most 31 deep here. */
static below check_median(const rk_bvh *bvh, const rk_mesh *mesh, uint32_t index)
{
    const rk_bvh_node *node = &bvh->nodes[index];
    below all = {
        0, rk_box_empty(), {INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    if (node->count) {
        for (uint32_t i = 0; i < node->count; i++)
            add_triangle(&all, mesh, bvh->triangles[node->first + i].index);
    } else {
        below left = check_median(bvh, mesh, node->first);
        below right = check_median(bvh, mesh, node->first + 1);
        all = merge(left, &right);
        rk_check_equal(left.count, all.count - all.count / 2, "the left half is ceil(N / 2)");
        int axis = rk_box_longest_axis(all.box);
        rk_check(
            left.highest[axis] <= right.lowest[axis],
            "node %u: on the longest axis %d a centroid of the left half, %.9g, lies above one of "
            "the right, %.9g",
            index, axis, (double)left.highest[axis], (double)right.lowest[axis]);
    }
    rk_check(memcmp(&all.box, &node->box, sizeof all.box) == 0,
             "node %u: its box is not the smallest around its triangles", index);
    return all;
}

static void every_node_is_cut_at_the_median_of_its_longest_axis(void **state)
{
    (void)state;
    const uint32_t counts[] = {5, 6, 7, 33, 100, 1000, 20011};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        rk_mesh mesh = make_soup(counts[i], 0.05f, 3);
        rk_bvh bvh = build(&mesh);
        check_median(&bvh, &mesh, 0);
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

static void equal_extents_are_cut_on_x_before_y_before_z(void **state)
{
    (void)state;
    /* Two groups on a diagonal of a cube, and of a square in y and z: the wrong axis would still
     * tell them apart, so the extents alone decide; a third corner breaks the symmetry. */
    for (int flat_in_x = 0; flat_in_x < 2; flat_in_x++) {
        float x = flat_in_x ? 0 : 1;
        const rk_vec3 places[] = {{0, 1, 0}, {0, 0, 1}, {0, 1, 1}, {x, 0, 0},
                                  {x, 1, 0}, {x, 0, 1}, {x, 1, 1}, {0, 0, 0}};
        rk_mesh mesh = make_copies_at(places, 8);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            mesh.positions[i].z = places[i / 3].z + (i % 3 == 1 ? 0.125f : 0);
        rk_bvh bvh = build(&mesh);
        rk_box left = bvh.nodes[bvh.nodes[0].first].box;
        float extent = flat_in_x ? rk_box_extent(left).y : rk_box_extent(left).x;
        rk_check_close(extent, 0.125, 0,
                       "the left child holds the lower half on the first longest axis");
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

static void the_order_of_the_mesh_does_not_change_the_boxes(void **state)
{
    (void)state;
    const uint32_t n = 3000;
    rk_mesh mesh = make_soup(n, 0.05f, 4);
    rk_bvh bvh = build(&mesh);
    for (uint32_t i = 0; i < n / 2; i++)
        for (int k = 0; k < 3; k++) {
            uint32_t t = mesh.triangles[i][k];
            mesh.triangles[i][k] = mesh.triangles[n - 1 - i][k];
            mesh.triangles[n - 1 - i][k] = t;
        }
    rk_bvh reversed = build(&mesh);
    for (uint32_t i = 0; i < bvh.node_count; i++)
        rk_check(i == 1 || memcmp(&bvh.nodes[i], &reversed.nodes[i], sizeof *bvh.nodes) == 0,
                 "node %u differs for the same triangles in reverse", i);
    rk_bvh_free(&bvh);
    rk_bvh_free(&reversed);
    rk_mesh_free(&mesh);
}

static void a_node_is_32_bytes_and_a_pair_of_children_one_cache_line(void **state)
{
    (void)state;
    rk_check_equal(sizeof(rk_bvh_node), 32, "two children then fill 64 bytes");
    rk_mesh mesh = make_soup(100, 0.1f, 5);
    rk_bvh bvh = build(&mesh);
    rk_check_equal((uintptr_t)&bvh.nodes[bvh.nodes[0].first] % 64, 0, "pairs start on a line");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* --- Difficult meshes ------------------------------------------------------------------------ */

static void identical_triangles_build_and_the_first_is_hit(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(1000);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        mesh.positions[i] = rk_vec(i % 3 == 1, i % 3 == 2, 0);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(rk_bvh_measure(&bvh).levels, 9, "halving by index where centroids coincide");
    rk_ray ray = {rk_vec(0.25f, 0.25f, -1), rk_vec(0, 0, 1), INFINITY};
    rk_counters counters = {0};
    rk_check_equal(rk_bvh_closest(&bvh, &ray, &counters).triangle, 0,
                   "among equal distances the smallest index");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void flat_long_and_huge_meshes_equal_trying_all(void **state)
{
    (void)state;
    const rk_vec3 stretch[] = {{1, 1, 0},
                               {0, 1, 0},
                               {0, 0, 0},
                               {1e6f, 1, 1e-6f},
                               {1e15f, 1e15f, 1e15f},
                               {1e-6f, 1e-6f, 1e-6f}};
    for (uint32_t s = 0; s < sizeof stretch / sizeof *stretch; s++) {
        rk_mesh mesh = make_soup(200, 0.3f, 6 + s);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            mesh.positions[i] = rk_mul(mesh.positions[i], stretch[s]);
        check_against_trying_all(&mesh, 1000, s);
        rk_mesh_free(&mesh);
    }
}

static void coordinates_near_the_largest_float_build_a_sound_tree(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(500, 0.1f, 7);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        mesh.positions[i] = rk_scale(mesh.positions[i], 3e38f);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(rk_bvh_measure(&bvh).leaves, 128, "halving does not depend on the extents");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void a_mesh_in_any_order_is_no_slow_case(void **state)
{
    (void)state;
    /* Sorted, reversed, organ pipe, saw teeth and all equal: a selection that is quadratic on one
     * of them would work here for minutes. */
    const uint32_t n = 200000;
    for (int order = 0; order < 5; order++) {
        rk_mesh mesh = make_mesh(n);
        for (uint32_t i = 0; i < n; i++) {
            const uint32_t x[] = {i, n - i, i < n / 2 ? i : n - i, i % 1000, 0};
            for (uint32_t k = 0; k < 3; k++)
                mesh.positions[3 * i + k] =
                    rk_vec((float)x[order], (float)(k == 1), (float)(k == 2));
        }
        rk_bvh bvh = build(&mesh);
        rk_check_equal(rk_bvh_measure(&bvh).leaves, 65536, "halving 200,000 down to 4");
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

/* --- Rays ------------------------------------------------------------------------------------ */

static void rays_find_what_trying_all_finds(void **state)
{
    (void)state;
    const struct {
        uint32_t triangles;
        float size;
    } soups[] = {{1, 1}, {2, 1}, {5, 1}, {50, 0.5f}, {500, 0.2f}, {3000, 0.03f}};
    for (uint32_t i = 0; i < sizeof soups / sizeof *soups; i++) {
        rk_mesh mesh = make_soup(soups[i].triangles, soups[i].size, 20 + i);
        check_against_trying_all(&mesh, 3000, 30 + i);
        rk_mesh_free(&mesh);
    }
}

static void rays_along_a_grid_find_what_trying_all_finds(void **state)
{
    (void)state;
    /* Squares of a floor on whole coordinates: rays from whole coordinates along the axes run in
     * box faces and through edges and corners. */
    const uint32_t side = 16;
    rk_mesh mesh = make_mesh(2 * side * side);
    for (uint32_t i = 0; i < side * side; i++) {
        float x = (float)(i % side), z = (float)(i / side);
        const rk_vec3 corner[] = {{x, 0, z}, {x + 1, 0, z},     {x + 1, 0, z + 1},
                                  {x, 0, z}, {x + 1, 0, z + 1}, {x, 0, z + 1}};
        memcpy(&mesh.positions[6 * i], corner, sizeof corner);
    }
    rk_bvh bvh = build(&mesh);
    rk_counters counters = {0};
    for (uint32_t i = 0; i <= 2 * side; i++)
        for (uint32_t j = 0; j <= 2 * side; j++)
            for (int axis = 0; axis < 3; axis++) {
                rk_vec3 direction = rk_vec(axis == 0 ? 1 : -0.0f, axis == 1 ? -1 : 0, axis == 2);
                rk_ray ray = {rk_vec((float)i / 2, axis == 1 ? 1 : 0, (float)j / 2), direction,
                              INFINITY};
                rk_hit want = closest_by_trying_all(&mesh, &ray);
                rk_hit got = rk_bvh_closest(&bvh, &ray, &counters);
                rk_check(got.triangle == want.triangle && got.t == want.t,
                         "from (%g, %g) along axis %d: got triangle %u, want %u", i / 2.0, j / 2.0,
                         axis, got.triangle, want.triangle);
                rk_check(axis != 1 || got.triangle != RK_MISS, "(%g, %g): a hole in the floor",
                         i / 2.0, j / 2.0);
            }
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void hits_count_up_to_t_max_and_not_behind_the_origin(void **state)
{
    (void)state;
    const rk_vec3 places[] = {{0, 0, -2}, {0, 0, 2}, {0, 0, 4}, {0, 0, 6}, {0, 0, 8}, {0, 0, 10}};
    rk_mesh mesh = make_copies_at(places, 6);
    rk_bvh bvh = build(&mesh);
    rk_counters counters = {0};
    /* At (1/32, 1/32) the triangles lie 1/32 above their places. */
    const struct {
        float t_max;
        uint32_t want;
    } cases[] = {{2, RK_MISS}, {2.03125f, 1}, {3, 1}, {INFINITY, 1}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rk_ray ray = {rk_vec(0.03125f, 0.03125f, 0), rk_vec(0, 0, 1), cases[i].t_max};
        rk_check_equal(rk_bvh_closest(&bvh, &ray, &counters).triangle, cases[i].want,
                       "0 < t <= t_max");
        rk_check_equal(rk_bvh_any(&bvh, &ray, &counters), cases[i].want != RK_MISS,
                       "0 < t <= t_max");
    }
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void a_ray_of_nan_misses(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(100, 0.5f, 8);
    rk_bvh bvh = build(&mesh);
    rk_counters counters = {0};
    rk_ray ray = {rk_vec(0, 0, 0), rk_vec(NAN, NAN, NAN), INFINITY};
    rk_check_equal(rk_bvh_closest(&bvh, &ray, &counters).triangle, RK_MISS, "no hit, no hang");
    rk_check(!rk_bvh_any(&bvh, &ray, &counters), "no hit, no hang");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* --- No more work than needed ---------------------------------------------------------------- */

/* `count` large squares, one behind the other along z, as pairs of triangles. */
static rk_mesh make_curtains(uint32_t count)
{
    rk_mesh mesh = make_mesh(2 * count);
    for (uint32_t i = 0; i < count; i++) {
        float z = (float)i * 10;
        const rk_vec3 corner[] = {{-1, -1, z}, {1, -1, z}, {1, 1, z},
                                  {-1, -1, z}, {1, 1, z},  {-1, 1, z}};
        memcpy(&mesh.positions[6 * i], corner, sizeof corner);
    }
    return mesh;
}

static void a_ray_that_misses_the_root_tests_one_box(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(1000, 0.1f, 9);
    rk_bvh bvh = build(&mesh);
    rk_ray ray = {rk_vec(5, 5, 5), rk_vec(1, 0, 0), INFINITY};
    rk_counters counters = {0};
    rk_bvh_closest(&bvh, &ray, &counters);
    rk_check_equal(counters.box_tests, 1, "only the root's");
    rk_check_equal(counters.triangle_tests, 0, "none");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void what_lies_behind_the_nearest_hit_is_skipped_from_either_side(void **state)
{
    (void)state;
    rk_mesh mesh = make_curtains(512);
    rk_bvh bvh = build(&mesh);
    for (int side = 0; side < 2; side++) {
        rk_ray ray = {rk_vec(0.25f, 0.5f, side ? 6000 : -10), rk_vec(0, 0, side ? -1 : 1),
                      INFINITY};
        rk_counters counters = {0};
        rk_hit hit = rk_bvh_closest(&bvh, &ray, &counters);
        rk_check_equal(hit.triangle / 2, side ? 511 : 0, "the first curtain");
        /* 1,024 triangles are 256 leaves in 9 levels: down to one leaf, two boxes a level. */
        rk_check_equal(counters.triangle_tests, 4, "one leaf: the near child comes first");
        rk_check_equal(counters.box_tests, 1 + 2 * 8, "the root, and two children a level");
    }
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void any_hit_stops_at_the_first_triangle_found(void **state)
{
    (void)state;
    rk_mesh mesh = make_curtains(512);
    rk_bvh bvh = build(&mesh);
    rk_ray ray = {rk_vec(0.25f, 0.5f, -10), rk_vec(0, 0, 1), INFINITY};
    rk_counters counters = {0};
    rk_check(rk_bvh_any(&bvh, &ray, &counters), "512 curtains in the way");
    rk_check(counters.triangle_tests <= 4, "tested %llu triangles, one leaf would do",
             (unsigned long long)counters.triangle_tests);
    rk_check(counters.box_tests <= 1 + 2 * 8, "tested %llu boxes, two on each level would do",
             (unsigned long long)counters.box_tests);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void counts_of_several_rays_add_up(void **state)
{
    (void)state;
    rk_mesh mesh = make_curtains(512);
    rk_bvh bvh = build(&mesh);
    rk_ray ray = {rk_vec(0.25f, 0.5f, -10), rk_vec(0, 0, 1), INFINITY};
    rk_counters one = {0}, three = {0}, any_one = {0}, any_three = {0};
    rk_bvh_closest(&bvh, &ray, &one);
    rk_bvh_any(&bvh, &ray, &any_one);
    for (int i = 0; i < 3; i++) {
        rk_bvh_closest(&bvh, &ray, &three);
        rk_bvh_any(&bvh, &ray, &any_three);
    }
    rk_check_equal(three.box_tests, 3 * one.box_tests, "counters are added to, not set");
    rk_check_equal(three.triangle_tests, 3 * one.triangle_tests, "added to, not set");
    rk_check_equal(any_three.box_tests, 3 * any_one.box_tests, "added to, not set");
    rk_check_equal(any_three.triangle_tests, 3 * any_one.triangle_tests, "added to, not set");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void most_boxes_of_a_large_mesh_are_never_tested(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(20000, 0.01f, 10);
    rk_bvh bvh = build(&mesh);
    rk_counters counters = {0};
    const uint32_t rays = 1000;
    for (uint32_t i = 0; i < rays; i++) {
        rk_ray ray = make_ray(i, 11, rk_mesh_bounds(&mesh));
        rk_bvh_closest(&bvh, &ray, &counters);
    }
    /* Measured: about 250 boxes and 100 triangles a ray in this thin soup, of 16,383 and 20,000.
     * Ten times that means that whole subtrees are walked in vain. */
    rk_check(counters.box_tests < rays * 2500ull, "%llu boxes a ray",
             (unsigned long long)(counters.box_tests / rays));
    rk_check(counters.triangle_tests < rays * 1000ull, "%llu triangles a ray",
             (unsigned long long)(counters.triangle_tests / rays));
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(no_triangles_give_a_tree_without_nodes),
    cmocka_unit_test(up_to_four_triangles_are_one_leaf),
    cmocka_unit_test(five_triangles_split_three_to_two),
    cmocka_unit_test(levels_and_leaves_are_those_of_halving),
    cmocka_unit_test(every_node_is_cut_at_the_median_of_its_longest_axis),
    cmocka_unit_test(equal_extents_are_cut_on_x_before_y_before_z),
    cmocka_unit_test(the_order_of_the_mesh_does_not_change_the_boxes),
    cmocka_unit_test(a_node_is_32_bytes_and_a_pair_of_children_one_cache_line),
    cmocka_unit_test(identical_triangles_build_and_the_first_is_hit),
    cmocka_unit_test(coordinates_near_the_largest_float_build_a_sound_tree),
    cmocka_unit_test(a_mesh_in_any_order_is_no_slow_case),
    cmocka_unit_test(rays_find_what_trying_all_finds),
    cmocka_unit_test(rays_along_a_grid_find_what_trying_all_finds),
    cmocka_unit_test(flat_long_and_huge_meshes_equal_trying_all),
    cmocka_unit_test(hits_count_up_to_t_max_and_not_behind_the_origin),
    cmocka_unit_test(a_ray_of_nan_misses),
    cmocka_unit_test(a_ray_that_misses_the_root_tests_one_box),
    cmocka_unit_test(what_lies_behind_the_nearest_hit_is_skipped_from_either_side),
    cmocka_unit_test(any_hit_stops_at_the_first_triangle_found),
    cmocka_unit_test(counts_of_several_rays_add_up),
    cmocka_unit_test(most_boxes_of_a_large_mesh_are_never_tested),
};

RK_SUITE("bvh_median", tests)
