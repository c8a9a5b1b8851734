/* The wide tree: its shape and its cost, and that rays find the same hits in it as by brute force,
 * with no more work than it takes. */
#include "short_memory.h"
#include "test.h"
#include "test_soup.h"

#include "features/bvh_median.h"
#include "features/sah_binning.h"
#include "features/wide_bvh.h"
#include "scene/bvh_build.h"

#include <float.h>

/* --- Trees to try ----------------------------------------------------------------------------- */

static rk_bvh build_binary(const rk_mesh *mesh)
{
    const rk_sah_options options = {16, true};
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_build_sah(&bvh, mesh, &options, &error), error);
    return bvh;
}

/* Nodes and leaves, whatever the blocks hold. */
static rk_wide_bvh collapse(const rk_bvh *bvh)
{
    rk_wide_bvh wide;
    rk_error error;
    rk_check_ok(rk_wide_bvh_build(&wide, bvh, &error), error);
    return wide;
}

static rk_wide_bvh widen(const rk_bvh *bvh, const rk_mesh *mesh)
{
    rk_wide_bvh wide = collapse(bvh);
    rk_error error;
    rk_check(rk_wide_bvh_validate(&wide, mesh, &error),
             "the wide tree over %u triangle%s is not sound: %s", mesh->triangle_count,
             mesh->triangle_count == 1 ? "" : "s", error.text);
    return wide;
}

static rk_wide_bvh build(const rk_mesh *mesh)
{
    rk_bvh bvh = build_binary(mesh);
    rk_wide_bvh wide = widen(&bvh, mesh);
    rk_bvh_free(&bvh);
    return wide;
}

/* The number of children of a node. */
static uint32_t children_of(const rk_wide_node *node)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++)
        count += node->child[i] != rk_wide_leaf(0, 0);
    return count;
}

/* Squares of 0.5 x 0.5 across the z axis at z = 0, 1, 2 ..., one in front of the other; each is two
 * triangles. */
static rk_mesh make_walls(uint32_t walls)
{
    rk_mesh mesh = make_mesh(2 * walls);
    for (uint32_t i = 0; i < walls; i++)
        for (uint32_t k = 0; k < 6; k++) {
            uint32_t corner = k < 3 ? k : 6 - k; /* 0 1 2, 3 2 1 */
            mesh.positions[6 * i + k] =
                rk_vec(corner & 1 ? 0.25f : -0.25f, corner & 2 ? 0.25f : -0.25f, (float)i);
        }
    return mesh;
}

/* Of the mesh's triangles in their order. */
static rk_bvh build_by(rk_bvh_split split, rk_mesh *mesh)
{
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_init(&bvh, mesh->triangle_count, mesh->triangle_count, &error), error);
    for (uint32_t i = 0; i < mesh->triangle_count; i++)
        bvh.triangles[i] = rk_bvh_triangle_of(mesh, i);
    rk_bvh_build_nodes(&bvh, split, mesh);
    return bvh;
}

static rk_box box_of(const rk_mesh *mesh, uint32_t begin, uint32_t count)
{
    rk_box box = rk_box_empty();
    for (uint32_t i = 3 * begin; i < 3 * (begin + count); i++)
        box = rk_box_add(box, mesh->positions[i]);
    return box;
}

/* `triangles` of the mesh, from the first one on, in the same place. */
static void place_in_one(rk_mesh *mesh, uint32_t first, uint32_t triangles, rk_vec3 place)
{
    for (uint32_t i = 3 * first; i < 3 * (first + triangles); i++)
        mesh->positions[i] = rk_add(place, rk_vec(i % 3 == 1, i % 3 == 2, 0));
}

static rk_mesh make_coincident(uint32_t triangles)
{
    rk_mesh mesh = make_mesh(triangles);
    place_in_one(&mesh, 0, triangles, rk_vec(0, 0, 0));
    return mesh;
}

/* --- The tree --------------------------------------------------------------------------------- */

static void a_node_is_four_cache_lines_and_a_block_less_than_three(void **state)
{
    (void)state;
    rk_check_equal(sizeof(rk_wide_node), 256, "eight boxes, eight children, eight orders");
    rk_check_equal(sizeof(rk_wide_block), 176, "nine times four coordinates, four indices, edge");
}

static void no_triangles_give_a_tree_without_nodes(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(0);
    rk_wide_bvh wide = build(&mesh);
    rk_check(wide.node_count == 0 && wide.block_count == 0, "got %u nodes and %u blocks, want none",
             wide.node_count, wide.block_count);
    rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0, 0, 1), 2};
    rk_counters counters = {0};
    rk_hit hit = rk_wide_bvh_closest(&wide, &ray, &counters);
    rk_check(hit.triangle == RK_MISS && hit.t == 2, "a tree without nodes was hit at t = %g",
             (double)hit.t);
    rk_check(!rk_wide_bvh_occluded(&wide, &ray, &counters), "a tree without nodes occludes");
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

/* The index is the binary tree's, of 32 bits; the mesh is not looked at. */
static void check_large_indices(void)
{
    rk_mesh mesh = make_coincident(1);
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_build_median(&bvh, &mesh, &error), error);
    for (int bit = 0; bit < 32; bit++) {
        bvh.triangles[0].index = 1u << bit;
        rk_wide_bvh wide = collapse(&bvh);
        rk_check(wide.blocks[0].index[0] == 1u << bit,
                 "a triangle of index 2^%d: its block has the index %u: all 32 bits count", bit,
                 wide.blocks[0].index[0]);
        rk_wide_bvh_free(&wide);
    }
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void up_to_four_triangles_are_one_block(void **state)
{
    (void)state;
    check_large_indices();
    for (uint32_t n = 1; n <= 4; n++) {
        rk_mesh mesh = make_soup(n, 0.5f, 1);
        rk_bvh bvh;
        rk_error error;
        rk_check_ok(rk_bvh_build_median(&bvh, &mesh, &error), error);
        rk_wide_bvh wide = widen(&bvh, &mesh);
        rk_check_equal(wide.node_count, 1, "the root, whose only child is the leaf");
        rk_check_equal(wide.block_count, 1, "a block has room for four triangles");
        rk_check_equal(children_of(&wide.nodes[0]), 1, "one leaf");
        rk_wide_bvh_free(&wide);
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

static bool is_a_node_of(const rk_bvh *bvh, rk_box box)
{
    for (uint32_t i = 0; i < bvh->node_count; i++)
        if (i != 1 && memcmp(&bvh->nodes[i].box, &box, sizeof box) == 0) /* 1 is unused */
            return true;
    return false;
}

/* What can be said before the blocks are filled: each node and each block has one place in the
 * tree, and each of the root's boxes is a node's of the binary tree. */
static void check_places(const rk_wide_bvh *wide, const rk_bvh *bvh)
{
    uint32_t nodes = 1, blocks = 0;
    rk_check(wide->nodes && wide->blocks, "nodes and blocks are counted, but there are none");
    for (uint32_t i = 0; i < wide->node_count; i++)
        for (uint32_t k = 0; k < RK_WIDE_CHILDREN; k++) {
            uint32_t child = wide->nodes[i].child[k];
            if (child == rk_wide_leaf(0, 0))
                continue;
            rk_check(i > 0 || is_a_node_of(bvh, rk_wide_box(&wide->nodes[0], k)),
                     "the box of the root's child %u is no node's of the binary tree", k);
            if (!(child & RK_WIDE_LEAF)) {
                nodes++;
                continue;
            }
            rk_check_equal(rk_wide_leaf_first(child) + rk_wide_leaf_count(child) <=
                               wide->block_count,
                           true, "a leaf points past the blocks");
            blocks += rk_wide_leaf_count(child);
        }
    rk_check_equal(nodes, wide->node_count, "nodes that are the root or a child");
    rk_check_equal(blocks, wide->block_count, "blocks in leaves");
}

/* Clusters of four triangles, far from each other. */
static rk_mesh make_clusters(uint32_t clusters)
{
    rk_mesh mesh = make_soup(4 * clusters, 0.01f, 7);
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        uint32_t cluster = i / 12;
        rk_vec3 at = rk_vec((float)(cluster % 2), (float)(cluster / 2 % 2), (float)(cluster / 4));
        mesh.positions[i] = rk_madd(rk_scale(at, 10), mesh.positions[i], 0.1f);
    }
    return mesh;
}

static void eight_groups_of_four_triangles_are_one_node(void **state)
{
    (void)state;
    for (uint32_t clusters = 2; clusters <= 8; clusters++) {
        rk_mesh mesh = make_clusters(clusters);
        rk_bvh bvh = build_binary(&mesh);
        rk_wide_bvh wide = collapse(&bvh);
        check_places(&wide, &bvh);
        rk_check_equal(wide.node_count, 1, "up to eight leaves fit one node");
        rk_check_equal(children_of(&wide.nodes[0]), clusters, "each group is a child of the root");
        rk_check_equal(wide.block_count, clusters, "each group is one block");
        rk_wide_bvh_free(&wide);
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

static void check_leaves(rk_mesh mesh, bool by_median)
{
    uint32_t checksum = mesh_checksum(&mesh);
    rk_bvh bvh;
    rk_error error;
    if (by_median)
        rk_check_ok(rk_bvh_build_median(&bvh, &mesh, &error), error);
    else
        bvh = build_binary(&mesh);
    rk_triangle *triangles = malloc((size_t)bvh.triangle_count * sizeof *triangles);
    rk_check(triangles, "no memory for %u triangles", bvh.triangle_count);
    memcpy(triangles, bvh.triangles, (size_t)bvh.triangle_count * sizeof *triangles);
    rk_wide_bvh wide = widen(&bvh, &mesh);
    check_mesh_unchanged(&mesh, checksum);
    for (uint32_t i = 0; i < bvh.triangle_count; i++)
        rk_check(memcmp(&triangles[i], &bvh.triangles[i], sizeof *triangles) == 0,
                 "triangle %u of the binary tree was changed, which is only read", i);
    free(triangles);
    rk_check_equal(wide.triangle_count, mesh.triangle_count, "the tree's triangles");
    rk_wide_bvh_free(&wide);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void every_triangle_is_in_exactly_one_leaf(void **state)
{
    (void)state;
    for (uint32_t n = 1; n < 300; n++)
        check_leaves(make_soup(n, 0.3f, n), false);
    for (uint32_t n = 5; n <= 40; n += 5)
        check_leaves(make_soup(n, n % 2 ? 3 : 0.2f, n), true);
    for (uint32_t clusters = 2; clusters <= 8; clusters++)
        check_leaves(make_clusters(clusters), false);
    check_leaves(make_soup(20000, 0.02f, 5), false);
}

/* A leaf of 16 blocks, which a ray hits, or of which it enters the box alone. */
static void check_counts_in_a_leaf(void)
{
    rk_mesh mesh = make_coincident(RK_BVH_LEAF_MAX);
    rk_wide_bvh wide = build(&mesh);
    rk_check_equal(wide.block_count, 16, "64 triangles in one place are one leaf of 16 blocks");
    for (int hits = 0; hits < 2; hits++) {
        float x = hits ? 0.25f : 0.75f;
        rk_ray ray = {rk_vec(x, x, -1), rk_vec(0, 0, 1), INFINITY};
        rk_counters closest = {0}, occlusion = {0};
        rk_wide_bvh_closest(&wide, &ray, &closest);
        rk_wide_bvh_occluded(&wide, &ray, &occlusion);
        rk_check(closest.triangle_tests == 64,
                 "closest hit, a ray that %s all 64 triangles of a leaf: got %llu triangle tests, "
                 "want 64: four for each block that is looked at, hit or not",
                 hits ? "hits" : "misses", (unsigned long long)closest.triangle_tests);
        rk_check(
            occlusion.triangle_tests == (hits ? 4 : 64),
            "occlusion, a ray that %s all 64 triangles of a leaf: got %llu triangle tests, want "
            "%d: %s",
            hits ? "hits" : "misses", (unsigned long long)occlusion.triangle_tests, hits ? 4 : 64,
            hits ? "the first block has a hit, so the other 15 are not looked at"
                 : "four for each block");
    }
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

static void identical_triangles_share_leaves_of_many_blocks(void **state)
{
    (void)state;
    rk_mesh mesh = make_coincident(1000);
    rk_wide_bvh wide = build(&mesh);
    rk_ray ray = {rk_vec(0.25f, 0.25f, -1), rk_vec(0, 0, 1), INFINITY};
    rk_counters counters = {0};
    rk_check_equal(rk_wide_bvh_closest(&wide, &ray, &counters).triangle, 0,
                   "of equal distances the smallest index wins");
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
    check_counts_in_a_leaf();
}

/* --- Its cost --------------------------------------------------------------------------------- */

/* The cost that features/wide_bvh.c defines: the area of each node, and of each leaf times its
 * blocks. */
static double cost_of(const rk_wide_bvh *wide)
{
    double cost = rk_box_area(wide->box);
    for (uint32_t i = 0; i < wide->node_count; i++)
        for (uint32_t k = 0; k < RK_WIDE_CHILDREN; k++) {
            uint32_t child = wide->nodes[i].child[k];
            double area = rk_box_area(rk_wide_box(&wide->nodes[i], k));
            if (child != rk_wide_leaf(0, 0))
                cost += child & RK_WIDE_LEAF ? area * rk_wide_leaf_count(child) : area;
        }
    return cost;
}

static double cheapest_children(const rk_bvh *bvh, uint32_t node, uint32_t children);

/* By trying everything: a node as one child. */
static double cheapest_child(const rk_bvh *bvh, uint32_t node)
{
    uint32_t count = rk_bvh_range_of(bvh, node).count;
    double area = rk_box_area(bvh->nodes[node].box), leaf = area * ((count + 3) / 4);
    leaf = count <= RK_BVH_LEAF_MAX ? leaf : INFINITY;
    if (count <= RK_WIDE_BLOCK || bvh->nodes[node].count)
        return leaf;
    double kept = area + cheapest_children(bvh, node, 8);
    return kept < leaf ? kept : leaf;
}

/* The two halves of a node as exactly this many children, or fewer. */
static double cheapest_children(const rk_bvh *bvh, uint32_t node, uint32_t children)
{
    double best = INFINITY;
    uint32_t left = bvh->nodes[node].first;
    for (uint32_t k = 1; k < children; k++) {
        double cost = 0;
        for (uint32_t half = 0; half < 2; half++) {
            uint32_t share = half ? children - k : k, child = left + half;
            double single = cheapest_child(bvh, child), split = INFINITY;
            if (share > 1 && rk_bvh_range_of(bvh, child).count > RK_WIDE_BLOCK &&
                bvh->nodes[child].count == 0)
                split = cheapest_children(bvh, child, share);
            cost += single < split ? single : split;
        }
        best = cost < best ? cost : best;
    }
    return best;
}

static void check_box(const rk_wide_bvh *wide, const rk_bvh *bvh)
{
    for (int i = 0; i < 2 && bvh->node_count > 0; i++) {
        rk_vec3 got = wide->box.corner[i], want = bvh->nodes[0].box.corner[i];
        rk_check(got.x == want.x && got.y == want.y && got.z == want.z,
                 "the wide tree's box, wide->box: its %s corner is (%.9g, %.9g, %.9g), want (%.9g, "
                 "%.9g, %.9g), the one of the binary tree's root, around all of its triangles",
                 i ? "upper" : "lower", (double)got.x, (double)got.y, (double)got.z, (double)want.x,
                 (double)want.y, (double)want.z);
    }
}

/* `name` has a printf format for the number of triangles. */
static void check_cost(const rk_bvh *bvh, const char *name)
{
    rk_wide_bvh wide = collapse(bvh);
    check_box(&wide, bvh);
    double want = cheapest_child(bvh, 0), got = cost_of(&wide), area = rk_box_area(wide.box);
    if (children_of(&wide.nodes[0]) == 1) /* a leaf as the root's child costs the root, too */
        want += area;
    rk_check(fabs(got - want) <= 1e-12 * want,
             "%u triangles%s: a ray that enters the root is expected to visit %.9g nodes and "
             "blocks, want %.9g, the fewest of all choices: a node counts its area over the "
             "root's, a leaf this times its number of blocks; your root has %u children, and all "
             "leaves have %u blocks",
             bvh->triangle_count, name, got / area, want / area, children_of(&wide.nodes[0]),
             wide.block_count);
    rk_wide_bvh_free(&wide);
}

/* Split by median, after a scaling by a power of two, which changes no digit. */
static void check_cost_of_mesh(rk_mesh mesh, int exponent, const char *name)
{
    rk_bvh bvh;
    rk_error error;
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        mesh.positions[i] = rk_scale(mesh.positions[i], ldexpf(1, exponent));
    rk_check_ok(rk_bvh_build_median(&bvh, &mesh, &error), error);
    check_cost(&bvh, name);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* One leaf, of one or two blocks. */
static void check_costs_of_a_leaf(void)
{
    for (uint32_t n = 4; n <= 8; n++) {
        rk_mesh mesh = make_coincident(n);
        rk_bvh bvh;
        rk_error error;
        rk_check_ok(rk_bvh_build_median(&bvh, &mesh, &error), error);
        rk_wide_bvh wide = collapse(&bvh);
        uint32_t children = children_of(&wide.nodes[0]);
        rk_check(children == 1,
                 "%u triangles in one place are %u leaves, want one: it costs its area times the "
                 "number of its blocks, %u, and a node its area once more",
                 n, children, (n + 3) / 4);
        rk_wide_bvh_free(&wide);
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

/* The first four triangles are split off, or the last four. */
static uint32_t split_first_four_off(void *context, uint32_t begin, uint32_t count,
                                     uint32_t depth_left, rk_box *box)
{
    (void)depth_left;
    *box = box_of(context, begin, count);
    return count > 4 ? 4 : 0;
}

static uint32_t split_last_four_off(void *context, uint32_t begin, uint32_t count,
                                    uint32_t depth_left, rk_box *box)
{
    (void)depth_left;
    *box = box_of(context, begin, count);
    return count > 4 ? count - 4 : 0;
}

/* A chain: of the root's two halves one is a leaf, so the other one gets all further children. */
static void check_costs_of_shares(void)
{
    for (int last = 0; last < 2; last++)
        for (uint32_t clusters = 3; clusters <= 8; clusters++) {
            rk_mesh mesh = make_clusters(clusters);
            rk_bvh bvh = build_by(last ? split_last_four_off : split_first_four_off, &mesh);
            rk_wide_bvh wide = collapse(&bvh);
            uint32_t children = children_of(&wide.nodes[0]);
            rk_check(children == clusters && wide.node_count == 1,
                     "%u groups of four far apart, the %s one split off at each node: the root has "
                     "%u children, want %u: one half's share is 1, that of the other %u",
                     clusters, last ? "last" : "first", children, clusters, clusters - 1);
            rk_wide_bvh_free(&wide);
            rk_bvh_free(&bvh);
            rk_mesh_free(&mesh);
        }
}

/* Seven groups of four, and the rest, in one place, which is halved. */
enum { SPLIT_OFF = 7 * 4 };

static uint32_t split_groups_off(void *context, uint32_t begin, uint32_t count, uint32_t depth_left,
                                 rk_box *box)
{
    const rk_mesh *mesh = context;
    (void)depth_left;
    *box = box_of(context, begin, count);
    uint32_t rest = mesh->triangle_count - SPLIT_OFF;
    return count > rest                     ? SPLIT_OFF
           : count == rest                  ? rest / 2
           : begin < SPLIT_OFF && count > 4 ? count / 8 * 4
                                            : 0;
}

/* As one leaf it is the eighth child, if a leaf may be as large. */
static void check_cost_of_large_leaves(void)
{
    const uint32_t rests[] = {31, 32, 33, 63, 64, 65, 66};
    for (size_t k = 0; k < sizeof rests / sizeof *rests; k++) {
        rk_mesh mesh = make_mesh(SPLIT_OFF + rests[k]);
        for (uint32_t i = 0; i < SPLIT_OFF / 4; i++)
            place_in_one(&mesh, 4 * i, 4, rk_vec(3 * (float)(i + 1), 0, 0));
        place_in_one(&mesh, SPLIT_OFF, rests[k], rk_vec(0, 0, 0));
        rk_bvh bvh = build_by(split_groups_off, &mesh);
        check_cost(&bvh, ", all but 28 of them in one place, where at most 64 are a leaf");
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

static void no_other_choice_of_nodes_is_cheaper(void **state)
{
    (void)state;
    check_costs_of_a_leaf();
    check_costs_of_shares();
    /* Among large triangles, whose boxes overlap, leaves of several blocks are cheaper than nodes.
     */
    for (uint32_t n = 5; n <= 40; n += 5) {
        check_cost_of_mesh(make_soup(n, n % 2 ? 3 : 0.2f, n), 0, "");
        check_cost_of_mesh(make_soup(n, n % 2 ? 3 : 0.2f, n), -100, ", times 2^-100");
        check_cost_of_mesh(make_soup(n, n % 2 ? 3 : 0.2f, n), 50, ", times 2^50");
    }
    check_cost_of_large_leaves();
}

static void nodes_and_blocks_are_nearly_full(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(20000, 0.02f, 5);
    rk_bvh bvh = build_binary(&mesh);
    rk_wide_bvh wide = collapse(&bvh);
    check_places(&wide, &bvh);
    double children = 0;
    for (uint32_t i = 0; i < wide.node_count; i++)
        children += children_of(&wide.nodes[i]);
    rk_check(children / wide.node_count > 5,
             "a node has %.2f children on average, want more than 5", children / wide.node_count);
    rk_check(20000.0 / wide.block_count > 2.5,
             "a block has %.2f triangles on average, want more than 2.5",
             20000.0 / wide.block_count);
    double bytes = (double)wide.node_count * sizeof *wide.nodes +
                   (double)wide.block_count * sizeof *wide.blocks;
    rk_check(bytes / 20000 <= 80, "%.1f bytes per triangle, want at most 80", bytes / 20000);
    rk_bvh_free(&bvh);
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

/* --- Rays ------------------------------------------------------------------------------------- */

static void check_hit(rk_hit got, rk_hit want, const char *ray)
{
    rk_check(got.triangle == want.triangle && got.t == want.t,
             "%s: got triangle %d at t = %.9g, want %d at t = %.9g", ray, (int)got.triangle,
             (double)got.t, (int)want.triangle, (double)want.t);
    rk_check(want.triangle == RK_MISS || (got.u == want.u && got.v == want.v),
             "%s: got u = %.9g and v = %.9g, want %.9g and %.9g", ray, (double)got.u, (double)got.v,
             (double)want.u, (double)want.v);
}

enum { CLOSEST = 1, OCCLUSION = 2 };

/* Some directions are so short that distances are beyond 10^30, or so long that they are below
 * 10^-30: powers of two, which change no digit. */
static rk_ray make_ray_of_any_length(uint32_t i, uint32_t seed, rk_box bounds)
{
    rk_ray ray = make_ray(i, seed, bounds);
    int exponent = i % 7 == 2 ? -110 : i % 7 == 5 ? 100 : 0;
    ray.direction = rk_scale(ray.direction, ldexpf(1, exponent));
    ray.t_max = ldexpf(ray.t_max, -exponent);
    return ray;
}

static void check_occlusion(const rk_wide_bvh *wide, const rk_mesh *mesh, const rk_ray *ray,
                            const rk_hit *want, const char *name)
{
    rk_counters counters = {0};
    bool hits = want->triangle != RK_MISS;
    if (rk_wide_bvh_occluded(wide, ray, &counters) == hits)
        return;
    rk_ray endless = {ray->origin, ray->direction, INFINITY};
    rk_hit ahead = closest_by_brute_force(mesh, &endless);
    rk_check(hits,
             "%s: is it occluded? got yes, want no: the nearest hit is at t = %.9g, t_max %.9g%s",
             name, (double)ahead.t, (double)ray->t_max,
             ahead.triangle == RK_MISS ? "; what the filter lets through may still miss" : "");
    rk_check(false, "%s: is it occluded? got no, want yes: there is a hit at t = %.9g, t_max %.9g",
             name, (double)want->t, (double)ray->t_max);
}

static void check_rays_in(const rk_wide_bvh *wide, const rk_mesh *mesh, uint32_t rays, int queries)
{
    rk_box bounds = rk_mesh_bounds(mesh);
    rk_counters counters = {0};
    uint32_t hits = 0;
    for (uint32_t i = 0; i < rays; i++) {
        rk_ray ray = make_ray_of_any_length(i, mesh->triangle_count, bounds);
        rk_hit want = closest_by_brute_force(mesh, &ray);
        char name[64];
        snprintf(name, sizeof name, "a mesh of %u, ray %u", mesh->triangle_count, i);
        if (queries & CLOSEST)
            check_hit(rk_wide_bvh_closest(wide, &ray, &counters), want, name);
        if (queries & OCCLUSION)
            check_occlusion(wide, mesh, &ray, &want, name);
        hits += want.triangle != RK_MISS;
    }
    rk_check(hits > rays / 50, "only %u rays of %u hit: they show nothing", hits, rays);
}

/* Long thin triangles whose boxes overlap: a ray enters many of them and hits few. */
static rk_mesh make_slivers(uint32_t triangles)
{
    rk_mesh mesh = make_mesh(triangles);
    for (uint32_t i = 0; i < triangles; i++) {
        rk_vec3 centre = noise3(77, 3 * i), along = noise3(77, 3 * i + 1);
        mesh.positions[3 * i] = rk_sub(centre, along);
        mesh.positions[3 * i + 1] = rk_add(centre, along);
        mesh.positions[3 * i + 2] = rk_madd(centre, noise3(77, 3 * i + 2), 0.001f);
    }
    return mesh;
}

/* More boxes overlap than a search in depth keeps waiting. */
static void check_slivers(void)
{
    rk_mesh mesh = make_slivers(16000);
    rk_wide_bvh wide = build(&mesh);
    check_rays_in(&wide, &mesh, 50, CLOSEST);
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

static void check_rays(int queries)
{
    for (uint32_t n = 1; n <= 3000; n = 3 * n + 1) {
        rk_mesh mesh = make_soup(n, 1.5f / cbrtf((float)n), n);
        rk_wide_bvh wide = build(&mesh);
        check_rays_in(&wide, &mesh, 1000, queries);
        rk_wide_bvh_free(&wide);
        rk_mesh_free(&mesh);
    }
    rk_mesh large = make_soup(60, 3, 1); /* leaves of several blocks */
    rk_wide_bvh wide = build(&large);
    check_rays_in(&wide, &large, 1000, queries);
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&large);
}

/* Components are whole numbers. */
static rk_vec3 whole3(uint32_t a, uint32_t b, float size)
{
    rk_vec3 v = rk_scale(noise3(a, b), size);
    return rk_vec(rintf(v.x), rintf(v.y), rintf(v.z));
}

/* From 1 to `size` + 1, with these signs. */
static rk_vec3 whole_steps(uint32_t a, uint32_t b, float size, rk_vec3 signs)
{
    return rk_mul(rk_add(rk_abs3(whole3(a, b, size)), rk_vec(1, 1, 1)), signs);
}

/* The first corner is one of the box, which spreads from there with these signs. */
static rk_mesh make_corner(uint32_t i, rk_vec3 signs)
{
    rk_mesh mesh = make_mesh(1);
    mesh.positions[0] = whole3(81, i, 1000);
    for (uint32_t k = 1; k < 3; k++)
        mesh.positions[k] = rk_add(mesh.positions[0], whole_steps(81 + k, i, 50, signs));
    return mesh;
}

static const char *name_of_corner_ray(const rk_ray *ray, rk_vec3 corner)
{
    static char name[320];
    snprintf(
        name, sizeof name,
        "a ray from (%g, %g, %g) along (%g, %g, %g), which only touches the box, in its corner "
        "(%g, %g, %g): is a near side times inverse_near, and a far one times inverse_far?",
        (double)ray->origin.x, (double)ray->origin.y, (double)ray->origin.z,
        (double)ray->direction.x, (double)ray->direction.y, (double)ray->direction.z,
        (double)corner.x, (double)corner.y, (double)corner.z);
    return name;
}

/* Returns whether the ray hits the triangle. It enters the box along one axis where it leaves it
 * along another, so nothing but the widening of the slabs keeps it from being lost to rounding. */
static bool check_corner_ray(uint32_t i, int queries)
{
    const rk_vec3 spreads[] = {{1, -1, 0}, {0, 1, -1}, {-1, 0, 1}, {1, -1, 1}};
    const rk_vec3 signs = {i & 1 ? -1.0f : 1, i & 2 ? -1.0f : 1, i & 4 ? -1.0f : 1};
    rk_mesh mesh = make_corner(i, rk_mul(spreads[i / 8 % 4], signs));
    rk_vec3 corner = mesh.positions[0], along = whole_steps(84, i, 96, signs);
    float steps = (float)(1 + i % 7);
    rk_ray ray = {rk_madd(corner, along, -steps), along, i & 32 ? steps : INFINITY};
    rk_wide_bvh wide = build(&mesh);
    rk_hit want = closest_by_brute_force(&mesh, &ray);
    const char *name = name_of_corner_ray(&ray, corner);
    rk_counters counters = {0};
    if (queries & CLOSEST)
        check_hit(rk_wide_bvh_closest(&wide, &ray, &counters), want, name);
    if (queries & OCCLUSION)
        check_occlusion(&wide, &mesh, &ray, &want, name);
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
    return want.triangle == 0 && want.t == steps;
}

static void check_corner_rays(int queries)
{
    enum { rays = 500 };
    int hits = 0;
    for (uint32_t i = 0; i < rays; i++)
        hits += check_corner_ray(i, queries);
    rk_check(hits > rays * 9 / 10, "%d of %d rays hit a corner: this test cannot tell", hits, rays);
}

/* A tree is traversed by several threads at once. */
static void check_constant_trees(void)
{
    rk_mesh mesh = make_soup(40, 0.3f, 5);
    rk_bvh binary = build_binary(&mesh), copy = binary;
    copy.nodes = (rk_bvh_node *)rk_read_only(binary.nodes, binary.node_count * sizeof *copy.nodes,
                                             "binary tree's nodes");
    copy.triangles = (rk_triangle *)rk_read_only(
        binary.triangles, binary.triangle_count * sizeof *copy.triangles, "triangles");
    rk_wide_bvh own = widen(rk_read_only(&copy, sizeof copy, "binary tree"), &mesh), wide = own;
    wide.nodes =
        (rk_wide_node *)rk_read_only(own.nodes, own.node_count * sizeof *own.nodes, "nodes");
    wide.blocks =
        (rk_wide_block *)rk_read_only(own.blocks, own.block_count * sizeof *own.blocks, "blocks");
    const rk_wide_bvh *constant = rk_read_only(&wide, sizeof wide, "tree");
    rk_ray down = {rk_vec(0, 0, 5), rk_vec(0, 0, -1), INFINITY};
    const rk_ray *ray = rk_read_only(&down, sizeof down, "ray");
    rk_counters counters = {0};
    rk_wide_bvh_closest(constant, ray, &counters);
    rk_wide_bvh_occluded(constant, ray, &counters);
    rk_read_only_free();
    rk_wide_bvh_free(&own);
    rk_bvh_free(&binary);
    rk_mesh_free(&mesh);
}

static void rays_find_the_same_hits_as_brute_force(void **state)
{
    (void)state;
    check_constant_trees();
    check_corner_rays(CLOSEST);
    check_rays(CLOSEST);
    check_slivers();
}

static void check_scaled_rays(int queries)
{
    const float scales[] = {0x1p-100f, 0x1p-40f, 0x1p40f, 0x1p100f};
    for (size_t k = 0; k < sizeof scales / sizeof *scales; k++) {
        rk_mesh mesh = make_soup(200, 0.3f, 9);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            mesh.positions[i] = rk_scale(mesh.positions[i], scales[k]);
        rk_wide_bvh wide = build(&mesh);
        rk_counters counters = {0};
        for (uint32_t i = 0; i < 1000; i++) {
            rk_ray ray = make_ray(i, 4, rk_mesh_bounds(&mesh));
            rk_hit want = closest_by_brute_force(&mesh, &ray);
            if (queries & CLOSEST)
                check_hit(rk_wide_bvh_closest(&wide, &ray, &counters), want, "a scaled mesh");
            if (queries & OCCLUSION)
                rk_check(rk_wide_bvh_occluded(&wide, &ray, &counters) == (want.triangle != RK_MISS),
                         "a mesh times %g, ray %u: is it occluded?", (double)scales[k], i);
        }
        rk_wide_bvh_free(&wide);
        rk_mesh_free(&mesh);
    }
}

static void tiny_and_huge_meshes_have_the_same_hits(void **state)
{
    (void)state;
    check_scaled_rays(CLOSEST | OCCLUSION);
}

/* x, y and z exchanged in turn. */
static rk_vec3 turned(rk_vec3 a, int turns)
{
    return turns == 0 ? a : turns == 1 ? rk_vec(a.z, a.x, a.y) : rk_vec(a.y, a.z, a.x);
}

/* Squares of a grid across an axis: rays in the planes of boxes' faces, and through corners. */
static void check_grid(int turns, int queries)
{
    enum { side = 9, rays = 2 * side + 1 };
    rk_mesh mesh = make_mesh(2 * side * side);
    for (uint32_t i = 0; i < side * side; i++)
        for (uint32_t k = 0; k < 6; k++) {
            uint32_t corner = k < 3 ? k : 6 - k;
            mesh.positions[6 * i + k] = turned(
                rk_vec((float)(i % side + (corner & 1)), (float)(i / side + (corner >> 1)), 0),
                turns);
        }
    rk_wide_bvh wide = build(&mesh);
    rk_counters counters = {0};
    for (uint32_t i = 0; i < 2 * rays * rays; i++) {
        uint32_t place = i / 2;
        rk_vec3 from = rk_vec((float)(place % rays) / 2, (float)(place / rays) / 2, 1);
        rk_ray ray = {turned(from, turns), turned(rk_vec(0, i & 1 ? -0.0f : 0, -1), turns),
                      INFINITY};
        if (queries & CLOSEST)
            check_hit(rk_wide_bvh_closest(&wide, &ray, &counters),
                      closest_by_brute_force(&mesh, &ray), "a ray along an axis through a grid");
        if (queries & OCCLUSION)
            rk_check(rk_wide_bvh_occluded(&wide, &ray, &counters),
                     "ray %u along an axis: the grid occludes", i);
    }
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

static void rays_along_a_grid_find_the_same_hits(void **state)
{
    (void)state;
    for (int turns = 0; turns < 3; turns++)
        check_grid(turns, CLOSEST);
}

/* Eight groups of four triangles in the plane z = 0, two of which overlap at x = 0, so that a ray
 * there enters both boxes at the same t and intersects all eight triangles at that t. It is 2^-146,
 * 8 times the smallest float: there floats are so coarse that a box's entry cannot be moved towards
 * the ray against rounding. */
static rk_mesh make_tied_groups(bool second_first)
{
    rk_mesh mesh = make_mesh(4 * 8);
    for (uint32_t i = 0; i < mesh.triangle_count; i++) {
        uint32_t group = i / 4 < 2 ? (i / 4) ^ second_first : i / 4;
        float x = group < 2 ? 6 * (float)group - 3 : 20 * (float)group;
        mesh.positions[3 * i] = rk_vec(x - 4, -4, 0);
        mesh.positions[3 * i + 1] = rk_vec(x + 4, -4, 0);
        mesh.positions[3 * i + 2] = rk_vec(x, 4, 0);
    }
    return mesh;
}

static const rk_ray tied_ray = {{0, -3, -0x1p-26f}, {0, 0, 0x1p120f}, INFINITY};

static void a_box_that_begins_at_the_nearest_hit_is_visited(void **state)
{
    (void)state;
    for (int second_first = 0; second_first < 2; second_first++) {
        rk_mesh mesh = make_tied_groups(second_first);
        rk_wide_bvh wide = build(&mesh);
        rk_check_equal(children_of(&wide.nodes[0]), 8, "each group is a child of the root");
        rk_counters counters = {0};
        rk_hit want = closest_by_brute_force(&mesh, &tied_ray);
        rk_check(want.t == 0x1p-146f && want.triangle == 0,
                 "brute force got triangle %u at t = %g: this test cannot tell", want.triangle,
                 (double)want.t);
        check_hit(rk_wide_bvh_closest(&wide, &tied_ray, &counters), want,
                  "a ray that enters two boxes and intersects all of their triangles at one t, of "
                  "which the smallest index wins");
        rk_wide_bvh_free(&wide);
        rk_mesh_free(&mesh);
    }
}

/* All boxes that the ray enters begin at its end. */
static void check_boxes_at_t_max(void)
{
    rk_mesh mesh = make_tied_groups(false);
    rk_wide_bvh wide = build(&mesh);
    rk_ray ray = tied_ray;
    ray.t_max = 0x1p-146f;
    rk_counters counters = {0};
    const char *name = "a ray whose t_max is the t at which it enters the boxes";
    check_hit(rk_wide_bvh_closest(&wide, &ray, &counters), closest_by_brute_force(&mesh, &ray),
              name);
    rk_check(rk_wide_bvh_occluded(&wide, &ray, &counters),
             "%s: is it occluded? got no, want yes: a hit at t = t_max counts, 0 < t <= t_max",
             name);
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

static void rays_are_occluded_where_brute_force_hits(void **state)
{
    (void)state;
    check_corner_rays(OCCLUSION);
    check_rays(OCCLUSION);
    for (int turns = 0; turns < 3; turns++)
        check_grid(turns, OCCLUSION);
}

static void hits_count_up_to_t_max_and_not_behind_the_origin(void **state)
{
    (void)state;
    rk_mesh mesh = make_walls(20);
    rk_wide_bvh wide = build(&mesh);
    rk_counters counters = {0};
    for (int from = -1; from <= 20; from++)
        for (int reach = 0; reach < 3; reach++) {
            rk_ray ray = {rk_vec(0.1f, 0.05f, (float)from + 0.5f), rk_vec(0, 0, 1),
                          0.25f * (float)(reach + 1)};
            rk_hit want = closest_by_brute_force(&mesh, &ray);
            check_hit(rk_wide_bvh_closest(&wide, &ray, &counters), want, "a ray between walls");
            char name[80];
            snprintf(name, sizeof name, "a ray along z between walls, from z = %g",
                     (double)ray.origin.z);
            check_occlusion(&wide, &mesh, &ray, &want, name);
        }
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
    check_boxes_at_t_max();
}

static void rays_of_nan_and_infinity_miss(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(100, 0.5f, 3);
    rk_wide_bvh wide = build(&mesh);
    rk_counters counters = {0};
    const float odd[] = {NAN, INFINITY, -INFINITY};
    for (int k = 0; k < 3; k++)
        for (int i = 0; i < 7; i++) {
            float values[7] = {0, 0, -2, 0.1f, 0.1f, 1, INFINITY};
            values[i] = odd[k];
            rk_ray ray = {rk_vec(values[0], values[1], values[2]),
                          rk_vec(values[3], values[4], values[5]), values[6]};
            rk_hit want = closest_by_brute_force(&mesh, &ray);
            rk_hit got = rk_wide_bvh_closest(&wide, &ray, &counters);
            rk_check(got.triangle == want.triangle, "value %d is %g: hit triangle %d, want %d", i,
                     (double)odd[k], (int)got.triangle, (int)want.triangle);
            rk_check(rk_wide_bvh_occluded(&wide, &ray, &counters) == (want.triangle != RK_MISS),
                     "value %d is %g: is it occluded?", i, (double)odd[k]);
        }
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

/* --- No more work than needed ----------------------------------------------------------------- */

static rk_counters work_of_closest(const rk_wide_bvh *wide, const rk_ray *ray)
{
    rk_counters counters = {0};
    rk_wide_bvh_closest(wide, ray, &counters);
    return counters;
}

/* Counters are the unit's own word. So blocks that need no look get triangles that the ray along z
 * would hit at t, of which the boxes say nothing: not those with triangles from `first` to `last`.
 */
static void put_lures(rk_wide_bvh *wide, const rk_ray *ray, float t, uint32_t first, uint32_t last)
{
    rk_vec3 at = rk_madd(ray->origin, ray->direction, t);
    const float corners[3][3] = {
        {at.x - 9, at.y - 9, at.z}, {at.x + 9, at.y - 9, at.z}, {at.x, at.y + 9, at.z}};
    for (uint32_t b = 0; b < wide->block_count; b++) {
        rk_wide_block *block = &wide->blocks[b];
        bool is_spared = false;
        for (uint32_t i = 0; i < RK_WIDE_BLOCK; i++)
            is_spared = is_spared || (block->index[i] >= first && block->index[i] < last);
        for (int k = 0; k < 9 * RK_WIDE_BLOCK && !is_spared; k++)
            block->corner[k / RK_WIDE_BLOCK / 3][k / RK_WIDE_BLOCK % 3][k % RK_WIDE_BLOCK] =
                corners[k / RK_WIDE_BLOCK / 3][k / RK_WIDE_BLOCK % 3];
        block->edge = is_spared ? block->edge : 36;
    }
}

static void check_lured(const rk_wide_bvh *wide, const rk_ray *ray, float want, const char *what)
{
    rk_counters counters = {0};
    rk_hit hit = rk_wide_bvh_closest(wide, ray, &counters);
    rk_check(hit.t == want,
             "%s: with other triangles in blocks that need no look, the hit is at t = %g, want %g: "
             "they were looked at, whatever the counters say",
             what, (double)hit.t, (double)want);
}

static void walls_behind_the_nearest_hit_are_not_visited(void **state)
{
    (void)state;
    rk_mesh mesh = make_walls(500);
    rk_wide_bvh wide = build(&mesh);
    for (int back = 0; back < 2; back++) {
        rk_ray ray = {rk_vec(0.1f, 0.05f, back ? 600 : -100), rk_vec(0, 0, back ? -1.0f : 1),
                      INFINITY};
        rk_counters counters = work_of_closest(&wide, &ray);
        rk_check(counters.triangle_tests > 0 && counters.triangle_tests <= 2 * RK_WIDE_BLOCK,
                 "1,000 triangles one behind the other, from %s: %llu triangle tests, want at most "
                 "%d: the nearest child first, and none behind a hit",
                 back ? "behind" : "the front", (unsigned long long)counters.triangle_tests,
                 2 * RK_WIDE_BLOCK);
        rk_wide_bvh lured = build(&mesh);
        put_lures(&lured, &ray, 1, back ? 984 : 0, back ? 1000 : 16);
        check_lured(&lured, &ray, back ? 101 : 100, back ? "from behind" : "from the front");
        rk_wide_bvh_free(&lured);
    }
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

static void a_ray_that_misses_all_boxes_tests_eight(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(1000, 0.05f, 3);
    rk_wide_bvh wide = build(&mesh);
    rk_ray ray = {rk_vec(0, 5, -5), rk_vec(0, 0, 1), INFINITY};
    for (int behind = 0; behind < 2; behind++) {
        if (behind)
            ray.origin = rk_vec(0, 0, 2);
        rk_counters counters = work_of_closest(&wide, &ray);
        rk_check(counters.box_tests == 8 && counters.triangle_tests == 0,
                 "all boxes are %s: got %llu box and %llu triangle tests, want 8 and 0: only the "
                 "root's children",
                 behind ? "behind the ray" : "beside it", (unsigned long long)counters.box_tests,
                 (unsigned long long)counters.triangle_tests);
        put_lures(&wide, &ray, 1, 0, 0);
        check_lured(&wide, &ray, INFINITY, behind ? "boxes behind the ray" : "boxes beside it");
    }
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

static void a_bounded_ray_visits_no_box_beyond_its_end(void **state)
{
    (void)state;
    rk_mesh mesh = make_walls(500);
    rk_wide_bvh wide = build(&mesh);
    rk_ray ray = {rk_vec(0.1f, 0.05f, -1), rk_vec(0, 0, 1), 0.5f};
    rk_counters closest = work_of_closest(&wide, &ray), occluded = {0};
    rk_wide_bvh_occluded(&wide, &ray, &occluded);
    rk_check(closest.box_tests == 8 && closest.triangle_tests == 0,
             "closest hit: got %llu box and %llu triangle tests, want 8 and 0",
             (unsigned long long)closest.box_tests, (unsigned long long)closest.triangle_tests);
    rk_check(occluded.box_tests == 8 && occluded.triangle_tests == 0,
             "occlusion: got %llu box and %llu triangle tests, want 8 and 0",
             (unsigned long long)occluded.box_tests, (unsigned long long)occluded.triangle_tests);
    put_lures(&wide, &ray, 0.25f, 0, 0);
    check_lured(&wide, &ray, ray.t_max, "boxes beyond the ray's end");
    rk_check(!rk_wide_bvh_occluded(&wide, &ray, &occluded),
             "occlusion: other triangles in boxes beyond the ray's end were looked at");
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

static void occlusion_stops_at_the_first_hit(void **state)
{
    (void)state;
    rk_mesh mesh = make_walls(500);
    rk_wide_bvh wide = build(&mesh);
    rk_ray ray = {rk_vec(0.1f, 0.05f, -100), rk_vec(0, 0, 1), INFINITY};
    rk_counters counters = {0};
    rk_check(rk_wide_bvh_occluded(&wide, &ray, &counters), "500 walls do not occlude");
    rk_check(counters.triangle_tests == RK_WIDE_BLOCK,
             "got %llu triangle tests, want those of the first block, 4",
             (unsigned long long)counters.triangle_tests);
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

static void counts_of_several_rays_add_up(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(300, 0.2f, 3);
    rk_wide_bvh wide = build(&mesh);
    rk_counters total, sum = {0}, before;
    memset(&total, 5, sizeof total); /* all counters, also those of others */
    const uint64_t counted = (uint64_t)1 << 40;
    total.box_tests = counted + 7, total.triangle_tests = counted;
    before = total;
    for (uint32_t i = 0; i < 20; i++) {
        rk_ray ray = make_ray(i, 3, rk_mesh_bounds(&mesh));
        rk_counters one = work_of_closest(&wide, &ray);
        rk_check(one.box_tests >= 8 && one.box_tests % 8 == 0 && one.triangle_tests % 4 == 0,
                 "ray %u: %llu box and %llu triangle tests: a node counts 8, a block 4", i,
                 (unsigned long long)one.box_tests, (unsigned long long)one.triangle_tests);
        rk_counters_add(&sum, &one);
        rk_wide_bvh_closest(&wide, &ray, &total);
        rk_counters occluded = {0};
        rk_wide_bvh_occluded(&wide, &ray, &occluded);
        rk_counters_add(&sum, &occluded);
        rk_wide_bvh_occluded(&wide, &ray, &total);
    }
    rk_check(total.box_tests == sum.box_tests + counted + 7,
             "box tests: the counter was 2^40 + 7, and 40 calls with counters of their own counted "
             "%llu: "
             "got %llu, want the sum%s",
             (unsigned long long)sum.box_tests, (unsigned long long)total.box_tests,
             total.box_tests >> 40 ? "" : ": is it set, not added to? Or of 32 bits?");
    rk_check(
        total.triangle_tests == sum.triangle_tests + counted,
        "triangle tests: the counter was 2^40, and 40 calls with counters of their own counted "
        "%llu: got %llu, want the sum%s",
        (unsigned long long)sum.triangle_tests, (unsigned long long)total.triangle_tests,
        total.triangle_tests >> 40 ? "" : ": is it set, not added to? Or of 32 bits?");
    total.box_tests = before.box_tests, total.triangle_tests = before.triangle_tests;
    rk_check(memcmp(&total, &before, sizeof total) == 0,
             "a counter other than those of box and triangle tests has changed");
    rk_wide_bvh_free(&wide);
    rk_mesh_free(&mesh);
}

static void eight_at_once_take_a_third_of_the_steps(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(20000, 0.03f, 8);
    rk_bvh bvh = build_binary(&mesh);
    rk_wide_bvh wide = widen(&bvh, &mesh);
    rk_counters binary = {0}, eight = {0};
    for (uint32_t i = 0; i < 500; i++) {
        rk_ray ray = make_ray(i, 3, rk_mesh_bounds(&mesh));
        rk_bvh_closest(&bvh, &ray, &binary);
        rk_wide_bvh_closest(&wide, &ray, &eight);
    }
    double steps = (double)binary.box_tests / 2, fewer = (double)eight.box_tests / 8;
    rk_check(fewer < steps / 2.5 && fewer > steps / 10,
             "%.1f visits to nodes per ray, of %.1f in the binary tree: want less than 1 / 2.5",
             fewer / 500, steps / 500);
    rk_check(eight.box_tests < 2 * binary.box_tests,
             "%.1f box tests per ray, %.1f in the binary tree: want less than twice as many: the "
             "nearest child first",
             (double)eight.box_tests / 500, (double)binary.box_tests / 500);
    rk_wide_bvh_free(&wide);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* --- Limits ----------------------------------------------------------------------------------- */

enum { DEEP = RK_BVH_LEVELS_MAX + 40 };

/* One triangle is split off each node: as deep as a tree may be. */
static uint32_t split_one_off(void *context, uint32_t begin, uint32_t count, uint32_t depth_left,
                              rk_box *box)
{
    (void)depth_left;
    *box = box_of(context, begin, count);
    return count > 1 ? 1 : 0;
}

/* Each level has seven groups of four triangles behind the levels below, which are smaller. So a
 * node has eight children, seven of which wait while a ray visits the levels below: no more can
 * wait in a tree as deep as this. The ray passes all triangles closely. */
enum { GROUPS = 7, TALL = RK_BVH_LEVELS_MAX - 4 };

static rk_mesh make_tall_mesh(void)
{
    rk_mesh mesh = make_mesh(TALL * GROUPS * 4);
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        uint32_t group = i / 12;
        float size = powf(2.5f, (float)(group / GROUPS) - TALL / 2);
        mesh.positions[i] = rk_vec(i % 3 == 1 ? size : -size, i % 3 == 2 ? size : -size,
                                   size * (0.5f + 0.5f * (float)(group % GROUPS)));
    }
    return mesh;
}

/* The last level's groups are split off, and then halved. */
static uint32_t split_level_off(void *context, uint32_t begin, uint32_t count, uint32_t depth_left,
                                rk_box *box)
{
    (void)depth_left;
    *box = box_of(context, begin, count);
    return count > 4 * GROUPS ? count - 4 * GROUPS : count > 4 ? count / 8 * 4 : 0;
}

static void check_full_stack(void)
{
    rk_mesh mesh = make_tall_mesh();
    const float aside = 0.1f * mesh.positions[1].x;
    rk_bvh bvh = build_by(split_level_off, &mesh);
    rk_wide_bvh wide = widen(&bvh, &mesh);
    rk_check_equal(wide.node_count, TALL, "each level is a node: seven groups, and what is below");
    rk_ray ray = {rk_vec(aside, aside, 0), rk_vec(0, 0, 1), INFINITY};
    rk_counters counters = {0};
    rk_check_equal(rk_wide_bvh_closest(&wide, &ray, &counters).triangle, RK_MISS,
                   "the ray enters all boxes and hits nothing");
    rk_check(!rk_wide_bvh_occluded(&wide, &ray, &counters),
             "the ray hits nothing, but is occluded");
    rk_check(counters.box_tests == 2 * 8 * TALL &&
                 counters.triangle_tests == 2 * mesh.triangle_count,
             "a ray into all %d levels: got %llu box and %llu triangle tests, want %d and %u", TALL,
             (unsigned long long)counters.box_tests, (unsigned long long)counters.triangle_tests,
             2 * 8 * TALL, 2 * mesh.triangle_count);
    rk_wide_bvh_free(&wide);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void the_deepest_tree_has_all_hits(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(DEEP, 0.3f, 2);
    rk_bvh bvh = build_by(split_one_off, &mesh);
    rk_wide_bvh wide = widen(&bvh, &mesh);
    check_rays_in(&wide, &mesh, 2000, CLOSEST | OCCLUSION);
    rk_wide_bvh_free(&wide);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
    check_full_stack();
}

static void where_memory_runs_out_nothing_is_kept(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(500, 0.3f, 2);
    rk_bvh bvh = build_binary(&mesh);
    size_t before = rk_allocations_kept, granted = 0;
    bool built = false;
    for (; !built; granted++) {
        rk_wide_bvh wide;
        rk_error error = {""};
        rk_allocations_left = granted;
        built = rk_wide_bvh_build(&wide, &bvh, &error);
        rk_allocations_left = SIZE_MAX;
        rk_check(built || (error.text[0] && !wide.nodes && !wide.blocks && wide.node_count == 0),
                 "allocation %zu failed: want an error and an empty tree", granted + 1);
        rk_wide_bvh_free(&wide);
        rk_check(rk_allocations_kept == before, "allocation %zu failed: memory is kept",
                 granted + 1);
    }
    rk_check(granted > 1, "no allocation failed: this test cannot tell");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_node_is_four_cache_lines_and_a_block_less_than_three),
    cmocka_unit_test(no_triangles_give_a_tree_without_nodes),
    cmocka_unit_test(where_memory_runs_out_nothing_is_kept),
    cmocka_unit_test(eight_groups_of_four_triangles_are_one_node),
    cmocka_unit_test(no_other_choice_of_nodes_is_cheaper),
    cmocka_unit_test(nodes_and_blocks_are_nearly_full),
    cmocka_unit_test(up_to_four_triangles_are_one_block),
    cmocka_unit_test(every_triangle_is_in_exactly_one_leaf),
    cmocka_unit_test(rays_find_the_same_hits_as_brute_force),
    cmocka_unit_test(rays_along_a_grid_find_the_same_hits),
    cmocka_unit_test(a_box_that_begins_at_the_nearest_hit_is_visited),
    cmocka_unit_test(identical_triangles_share_leaves_of_many_blocks),
    cmocka_unit_test(walls_behind_the_nearest_hit_are_not_visited),
    cmocka_unit_test(a_ray_that_misses_all_boxes_tests_eight),
    cmocka_unit_test(eight_at_once_take_a_third_of_the_steps),
    cmocka_unit_test(rays_are_occluded_where_brute_force_hits),
    cmocka_unit_test(hits_count_up_to_t_max_and_not_behind_the_origin),
    cmocka_unit_test(tiny_and_huge_meshes_have_the_same_hits),
    cmocka_unit_test(a_bounded_ray_visits_no_box_beyond_its_end),
    cmocka_unit_test(occlusion_stops_at_the_first_hit),
    cmocka_unit_test(counts_of_several_rays_add_up),
    cmocka_unit_test(rays_of_nan_and_infinity_miss),
    cmocka_unit_test(the_deepest_tree_has_all_hits),
};

RK_SUITE("wide_bvh", tests)
