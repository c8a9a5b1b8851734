/* The bounding volume hierarchy split by the median: its shape, its soundness, and that rays find
 * the same hits in it as by brute force, with no more work than it takes. */
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */
#include "guarded_tree.h"
#include "little_stack.h"
#include "short_memory.h"
#include "test.h"
#include "test_soup.h"

#include "base/table.h"
#include "features/bvh_median.h"
#include "scene/bvh_build.h"

#include <signal.h>

/* --- Meshes and rays to try ----------------------------------------------------------------- */

/* Equal small triangles, one at each of the given positions. */
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
    uint32_t checksum = mesh_checksum(mesh);
    rk_check_ok(rk_bvh_build_median(&bvh, mesh, &error), error);
    check_mesh_unchanged(mesh, checksum);
    rk_check(rk_bvh_validate(&bvh, mesh, &error), "the tree over %u triangle%s is not sound: %s",
             mesh->triangle_count, mesh->triangle_count == 1 ? "" : "s", error.text);
    return bvh;
}

static uint32_t add_words(uint32_t sum, const void *words, size_t size)
{
    for (size_t i = 0; i < size; i += sizeof sum) {
        uint32_t word;
        memcpy(&word, (const char *)words + i, sizeof word);
        sum = (sum ^ word) * 0x9e3779b1u + 1;
    }
    return sum;
}

/* One number for all of a tree: rays only read it. */
static uint32_t tree_checksum(const rk_bvh *bvh)
{
    uint32_t sum = bvh->node_count;
    for (uint32_t i = 0; i < bvh->node_count; i += i ? 1 : 2) /* node 1 is unused */
        sum = add_words(sum, &bvh->nodes[i], sizeof *bvh->nodes);
    return add_words(sum, bvh->triangles, bvh->triangle_count * sizeof *bvh->triangles);
}

static const char *triangle_name(uint32_t triangle)
{
    static char names[2][24]; /* a message holds two */
    static int next;
    char *name = names[next++ % 2];
    snprintf(name, sizeof names[0], "triangle %u", triangle);
    return triangle == RK_MISS ? "nothing" : name;
}

/* The likely reason why one hit was found instead of the other. */
static const char *likely_mistake(rk_hit got, rk_hit want)
{
    if (got.triangle == RK_MISS && want.triangle == RK_MISS)
        return "a miss leaves t at t_max, where the search starts";
    if (got.triangle == RK_MISS)
        return "a leaf was not visited, or not its own triangles, which begin at `first`: is every "
               "child that the ray enters visited or pushed, and does the search go on with a "
               "pushed "
               "one until none is left, the last one too?";
    if (want.triangle == RK_MISS)
        return "only 0 < t <= t_max counts";
    if (got.t > want.t)
        return "the search ended before all boxes nearer than the nearest hit were visited: the "
               "last "
               "node on the stack is one of them";
    return "among equal distances the smallest triangle index wins";
}

/* The same triangle test on the same numbers gives the same bits, however the triangle was found,
 * so hits must be equal. */
static void check_hit(rk_hit got, rk_hit want, const char *ray)
{
    rk_check(got.triangle == want.triangle && got.t == want.t,
             "%s: got %s at t = %.9g, want %s at t = %.9g: %s", ray, triangle_name(got.triangle),
             (double)got.t, triangle_name(want.triangle), (double)want.t,
             likely_mistake(got, want));
    rk_check(want.triangle == RK_MISS || (got.u == want.u && got.v == want.v),
             "%s: %s at t = %.9g: got u = %.9g and v = %.9g, want %.9g and %.9g: they are part of "
             "the hit, from which colours and normals between the corners are interpolated",
             ray, triangle_name(want.triangle), (double)want.t, (double)got.u, (double)got.v,
             (double)want.u, (double)want.v);
}

static void check_occluded(bool got, bool want, const char *ray)
{
    rk_check(got == want, "%s: occluded: got %s, want %s: %s", ray, got ? "true" : "false",
             want ? "true" : "false",
             want ? "it must try every triangle of every leaf that the ray enters, until one is hit"
                  : "only hits at 0 < t <= t_max count");
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

/* A mesh's box; where it is flat, as deep as it is wide, so that rays cross it. */
static rk_box deep_bounds(const rk_mesh *mesh)
{
    rk_box bounds = rk_mesh_bounds(mesh);
    rk_vec3 extent = rk_box_extent(bounds);
    float widest = rk_axis(extent, rk_box_longest_axis(bounds));
    rk_vec3 more =
        rk_vec(extent.x > 0 ? 0 : widest, extent.y > 0 ? 0 : widest, extent.z > 0 ? 0 : widest);
    return rk_box_add(bounds, rk_add(bounds.corner[0], more));
}

/* Returns the number of rays that hit something. */
static uint32_t check_against_brute_force(const rk_mesh *mesh, uint32_t rays, uint32_t seed,
                                          int queries)
{
    rk_bvh bvh = build(mesh);
    rk_box bounds = deep_bounds(mesh);
    rk_counters counters = {0};
    uint32_t before = tree_checksum(&bvh), hits = 0;
    for (uint32_t i = 0; i < rays; i++) {
        rk_ray ray = make_ray_of_any_length(i, seed, bounds);
        const rk_ray same = ray;
        rk_hit want = closest_by_brute_force(mesh, &ray);
        hits += want.triangle != RK_MISS;
        char name[64];
        snprintf(name, sizeof name, "%u triangles, ray %u", mesh->triangle_count, i);
        if (queries & CLOSEST)
            check_hit(rk_bvh_closest(&bvh, &ray, &counters), want, name);
        if (queries & OCCLUSION)
            check_occluded(rk_bvh_occluded(&bvh, &ray, &counters), want.triangle != RK_MISS, name);
        rk_check(memcmp(&ray, &same, sizeof ray) == 0,
                 "%s: the caller's ray was changed, its t_max from %g to %g: it is constant; the "
                 "distance of the nearest hit is in the hit",
                 name, (double)same.t_max, (double)ray.t_max);
    }
    rk_check(tree_checksum(&bvh) == before,
             "rays changed the tree over %u triangles, which is constant: threads share it",
             mesh->triangle_count);
    rk_ray ray = make_ray_of_any_length(0, seed, bounds);
    const rk_ray *constant = rk_read_only(&ray, sizeof ray, "ray");
    if (queries & CLOSEST)
        rk_bvh_closest(&bvh, constant, &counters);
    if (queries & OCCLUSION)
        rk_bvh_occluded(&bvh, constant, &counters);
    rk_read_only_free();
    rk_bvh_free(&bvh);
    return hits;
}

/* --- The tree -------------------------------------------------------------------------------- */

static void no_triangles_give_a_tree_without_nodes(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(0);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(bvh.node_count, 0, "without triangles there is no root either");
    rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0, 0, 1), INFINITY};
    rk_counters counters = {0};
    check_hit(rk_bvh_closest(&bvh, &ray, &counters), (rk_hit){INFINITY, 0, 0, RK_MISS},
              "a tree without nodes");
    check_occluded(rk_bvh_occluded(&bvh, &ray, &counters), false, "a tree without nodes");
    rk_check(counters.box_tests == 0 && counters.triangle_tests == 0,
             "a tree without nodes: got %llu box tests and %llu triangle tests, want 0: it has "
             "neither",
             (unsigned long long)counters.box_tests, (unsigned long long)counters.triangle_tests);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void check_box(uint32_t node, rk_box got_box, rk_box want_box)
{
    for (int i = 0; i < 2; i++) {
        rk_vec3 got = got_box.corner[i], want = want_box.corner[i];
        rk_check(got.x == want.x && got.y == want.y && got.z == want.z,
                 "node %u: the %s corner of its box: got (%.9g, %.9g, %.9g), want (%.9g, %.9g, "
                 "%.9g): the smallest box around all its triangles grows from rk_box_empty()",
                 node, i ? "highest" : "lowest", (double)got.x, (double)got.y, (double)got.z,
                 (double)want.x, (double)want.y, (double)want.z);
    }
}

static void up_to_four_triangles_are_one_leaf(void **state)
{
    (void)state;
    for (uint32_t n = 1; n <= 4; n++) {
        rk_mesh mesh = make_soup(n, 0.5f, 1);
        rk_bvh bvh = build(&mesh);
        rk_check_equal(bvh.nodes[0].count, n,
                       "up to RK_BVH_LEAF_TARGET triangles, the root is a leaf with all of them");
        rk_check_equal(rk_bvh_measure(&bvh).levels, 1, "a root that is a leaf is one level");
        check_box(0, bvh.nodes[0].box, rk_mesh_bounds(&mesh));
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

static void five_triangles_split_three_to_two(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(5, 0.5f, 1);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(bvh.nodes[0].count, 0,
                   "five are more than RK_BVH_LEAF_TARGET, so the root is an inner node");
    rk_check_equal(bvh.nodes[bvh.nodes[0].first].count, 3,
                   "of an odd number the left child gets the larger half, ceil(5 / 2)");
    rk_check_equal(bvh.nodes[bvh.nodes[0].first + 1].count, 2, "the right child gets the rest");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void levels_and_leaves_follow_from_halving(void **state)
{
    (void)state;
    /* Halving with the larger half to the left until 4 are left; the classic course's counts. */
    const uint32_t want[][3] = {
        {32, 4, 8}, {967, 9, 256}, {87130, 16, 32768}, {4, 1, 1}, {9, 3, 3}};
    for (size_t i = 0; i < sizeof want / sizeof *want; i++) {
        rk_mesh mesh = make_soup(want[i][0], 0.01f, 2);
        rk_bvh bvh = build(&mesh);
        rk_bvh_measures got = rk_bvh_measure(&bvh);
        rk_check_equal(
            got.leaves, want[i][2],
            "split while more than RK_BVH_LEAF_TARGET remain, the larger half to the left");
        rk_check_equal(got.levels, want[i][1],
                       "the halves differ by at most one, so the tree is as flat as possible");
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

/* Where a triangle stands in the order on an axis. */
typedef struct spot {
    float centroid;
    uint32_t triangle;
} spot;

static spot spot_of(const rk_mesh *mesh, uint32_t triangle, int axis)
{
    float sum = 0;
    for (int k = 0; k < 3; k++)
        sum += rk_axis(mesh->positions[mesh->triangles[triangle][k]], axis) * 0x1.555554p-2f;
    return (spot){sum, triangle};
}

static bool comes_before(spot a, spot b)
{
    return a.centroid < b.centroid || (a.centroid == b.centroid && a.triangle < b.triangle);
}

/* The triangles below a node, summed up. */
typedef struct below {
    uint32_t count;
    rk_box box;
    spot first[3], last[3]; /* on each axis */
} below;

static below below_triangle(const rk_mesh *mesh, uint32_t triangle)
{
    below b = {1, rk_box_empty(), {{0, 0}}, {{0, 0}}};
    for (int k = 0; k < 3; k++) {
        b.box = rk_box_add(b.box, mesh->positions[mesh->triangles[triangle][k]]);
        b.first[k] = b.last[k] = spot_of(mesh, triangle, k);
    }
    return b;
}

static below merge(below a, const below *b)
{
    a.count += b->count;
    a.box = rk_box_merge(a.box, b->box);
    for (int k = 0; k < 3; k++) {
        a.first[k] = comes_before(b->first[k], a.first[k]) ? b->first[k] : a.first[k];
        a.last[k] = comes_before(a.last[k], b->last[k]) ? b->last[k] : a.last[k];
    }
    return a;
}

/* Triangles whose keys are compared as whole numbers have negative ones in the other order. */
static bool are_bits_in_order(float a, float b)
{
    int32_t bits[2];
    memcpy(&bits[0], &a, sizeof a);
    memcpy(&bits[1], &b, sizeof b);
    return bits[0] <= bits[1];
}

/* Of two halves that the wanted axis does not separate. */
static const char *mistake_of_halves(const below *left, const below *right, int axis)
{
    static char said[200];
    int longest = 0;
    float extent = -1, low[3], high[3];
    for (int k = 0; k < 3; k++) {
        low[k] = rk_min(left->first[k].centroid, right->first[k].centroid);
        high[k] = rk_max(left->last[k].centroid, right->last[k].centroid);
        longest = high[k] - low[k] > extent ? k : longest;
        extent = rk_max(extent, high[k] - low[k]);
    }
    for (int k = 0; k < 3; k++)
        if (k != axis && left->last[k].centroid <= right->first[k].centroid) {
            snprintf(said, sizeof said,
                     "; %c separates the halves%s: take the axis on which the "
                     "box is longest",
                     "xyz"[k], k == longest ? ", on which the centroids' extent is longest" : "");
            return said;
        }
    float a = left->last[axis].centroid, b = right->first[axis].centroid;
    if (a - b < (high[axis] - low[axis]) * 0x1p-12f)
        return "; these two differ little: does a key keep all digits of the centroid?";
    if (b < 0 && are_bits_in_order(a, b))
        return "; as whole numbers their bits are in order: negative floats are in the opposite "
               "one";
    return ": are centroids compared, (a + b + c) / 3 on this axis, and are the smaller ones in "
           "front "
           "after the selection?";
}

/* Checks the subtree of a node against the definition; recursion is at most 31 deep here. */
static below check_median(const rk_bvh *bvh, const rk_mesh *mesh, uint32_t index)
{
    const rk_bvh_node *node = &bvh->nodes[index];
    below all;
    if (node->count) {
        rk_check(node->count <= RK_BVH_LEAF_TARGET,
                 "node %u is a leaf of %u triangles, want a split of more than RK_BVH_LEAF_TARGET, "
                 "wherever they are",
                 index, node->count);
        all = below_triangle(mesh, bvh->triangles[node->first].index);
        for (uint32_t i = 1; i < node->count; i++) {
            below one = below_triangle(mesh, bvh->triangles[node->first + i].index);
            all = merge(all, &one);
        }
    } else {
        below left = check_median(bvh, mesh, node->first);
        below right = check_median(bvh, mesh, node->first + 1);
        all = merge(left, &right);
        rk_check_equal(left.count, all.count - all.count / 2,
                       "the left child holds ceil(N / 2) of the node's N triangles");
        int axis = rk_box_longest_axis(all.box);
        spot low = left.last[axis], high = right.first[axis];
        rk_check(low.centroid <= high.centroid,
                 "node %u, %u triangles: on its box's longest axis, %c, want no centroid of the "
                 "left half above one of the right, got %.9g above %.9g%s",
                 index, all.count, "xyz"[axis], (double)low.centroid, (double)high.centroid,
                 mistake_of_halves(&left, &right, axis));
        rk_check(comes_before(low, high),
                 "node %u, %u triangles: the centroids of the triangles %u and %u are equal on "
                 "axis %c, %g and %g: got %u in the left half and %u in the right one, want the "
                 "smaller index left",
                 index, all.count, low.triangle, high.triangle, "xyz"[axis], (double)low.centroid,
                 (double)high.centroid, low.triangle, high.triangle);
    }
    check_box(index, node->box, all.box);
    return all;
}

/* Which of the two zeros goes left with triangles 2 and 3? */
static void check_both_zeros(int axis)
{
    const float places[6] = {0, -0.0f, -10, -10, 10, 10};
    rk_mesh mesh = make_mesh(6);
    for (uint32_t i = 0; i < mesh.vertex_count; i++) {
        float across[2] = {(float)(i % 3 == 1), (float)(i % 3 == 2)}, along = places[i / 3];
        mesh.positions[i] = axis == 0   ? rk_vec(along, across[0], across[1])
                            : axis == 1 ? rk_vec(across[0], along, across[1])
                                        : rk_vec(across[0], across[1], along);
    }
    rk_bvh bvh = build(&mesh);
    const rk_bvh_node *left = &bvh.nodes[bvh.nodes[0].first];
    bool goes_left[6] = {false};
    for (uint32_t i = 0; i < left->count; i++)
        goes_left[bvh.triangles[left->first + i].index] = true;
    rk_check(left->count == 3 && goes_left[1] && goes_left[2] && goes_left[3],
             "triangles 0 to 5 at %c = 0, -0, -10, -10, 10, 10: got %s in the left half, want 1, 2 "
             "and 3: the sign is part of the key, and -0 is lower than 0",
             "xyz"[axis], goes_left[0] ? "triangle 0" : "others");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void every_node_is_split_at_the_median_of_its_longest_axis(void **state)
{
    (void)state;
    /* At 2^20 a float's steps are 1/8, so many centroids are equal. */
    const struct {
        uint32_t count;
        float scale, offset;
    } soups[] = {{5, 1, 0},          {6, 1, 0},         {7, 1, 0},         {33, 1, 0},
                 {100, 1, 0},        {1000, 1, 0},      {20011, 1, 0},     {300, 0x1p-125f, 0},
                 {300, 0x1p120f, 0}, {300, 1, 0x1p20f}, {300, 1, -0x1p20f}};
    for (size_t i = 0; i < sizeof soups / sizeof *soups; i++) {
        rk_mesh mesh = make_soup(soups[i].count, 0.05f, 3);
        for (uint32_t k = 0; k < mesh.vertex_count; k++)
            mesh.positions[k] = rk_madd(rk_vec(0, soups[i].offset, soups[i].offset),
                                        mesh.positions[k], soups[i].scale);
        rk_bvh bvh = build(&mesh);
        check_median(&bvh, &mesh, 0);
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
    for (int axis = 0; axis < 3; axis++)
        check_both_zeros(axis);
}

static void centroids_are_ordered_though_one_is_far_from_the_others(void **state)
{
    (void)state;
    /* Tiny triangles at the origin and one 4 away. Seen from there, or from the middle, all tiny
     * ones are at the same distance, because a float has 24 bits. */
    for (int axis = 0; axis < 3; axis++)
        for (int side = -1; side <= 1; side += 2) {
            rk_mesh mesh = make_soup(33, 0.1f, 40);
            for (uint32_t i = 0; i < mesh.vertex_count; i++)
                mesh.positions[i] = rk_scale(mesh.positions[i], 0x1p-30f);
            float far = 4 * (float)side;
            for (uint32_t k = 0; k < 3; k++)
                mesh.positions[k] =
                    rk_add(mesh.positions[k],
                           rk_vec(axis == 0 ? far : 0, axis == 1 ? far : 0, axis == 2 ? far : 0));
            rk_bvh bvh = build(&mesh);
            check_median(&bvh, &mesh, 0);
            rk_bvh_free(&bvh);
            rk_mesh_free(&mesh);
        }
}

static void equal_extents_are_split_on_x_before_y_before_z(void **state)
{
    (void)state;
    /* Two groups on a diagonal of a cube, and of a square in y and z: the wrong axis would still
     * separate them, so the extents alone decide; a third corner breaks the symmetry. */
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
                       "of several longest axes the first is split (x before y before z), so the "
                       "left child is as thin on it as one triangle");
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
        rk_check(
            i == 1 || memcmp(&bvh.nodes[i], &reversed.nodes[i], sizeof *bvh.nodes) == 0,
            "node %u: got another box or count for the same triangles in reverse order, want the "
            "same: triangles must be ordered by their centroids, not by their place in the mesh",
            i);
    rk_bvh_free(&bvh);
    rk_bvh_free(&reversed);
    rk_mesh_free(&mesh);
}

static void a_node_is_32_bytes_and_a_pair_of_children_one_cache_line(void **state)
{
    (void)state;
    rk_check_equal(sizeof(rk_bvh_node), 32, "two children then fill a cache line of 64 bytes");
    rk_mesh mesh = make_soup(100, 0.1f, 5);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(
        (uintptr_t)&bvh.nodes[bvh.nodes[0].first] % 64, 0,
        "a pair of children starts on a cache line: pairs are nodes 2 and 3, 4 and 5 ...");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* --- The deepest tree ------------------------------------------------------------------------- */

enum { DEEP = RK_BVH_LEVELS_MAX + 16 }; /* triangles, of which the last leaf has 17 */

/* Splits one triangle off each node, at one end of it, however deep it is, and checks what it is
 * told. */
typedef struct deep_builder {
    rk_mesh mesh;
    bool one_goes_left;
    uint32_t count[DEEP], depth[DEEP]; /* of the node that begins there, as wanted */
} deep_builder;

static uint32_t split_one_off(void *context, uint32_t begin, uint32_t count, uint32_t depth_left,
                              rk_box *box)
{
    deep_builder *deep = context;
    rk_check(begin < DEEP && deep->count[begin] == count,
             "got a node of %u triangles from %u on, want %u: the left child has the first ones, "
             "as many as "
             "`split` returned, and the right child the rest",
             count, begin, begin < DEEP ? deep->count[begin] : 0);
    rk_check(depth_left == deep->depth[begin],
             "a node of %u triangles: got depth_left = %u, want %u: RK_BVH_LEVELS_MAX - 1 at the "
             "root, and one less "
             "for each level down",
             count, depth_left, deep->depth[begin]);
    *box = rk_box_empty();
    for (uint32_t i = 3 * begin; i < 3 * (begin + count); i++)
        *box = rk_box_add(*box, deep->mesh.positions[i]);
    if (count == 1)
        return 0;
    uint32_t left = deep->one_goes_left ? 1 : count - 1;
    deep->count[begin] = left;
    deep->count[begin + left] = count - left;
    deep->depth[begin] = deep->depth[begin + left] = depth_left - 1;
    return left;
}

/* Triangles that stand across the z axis, each twice as far and as large as the one before. All
 * have their tips up but the odd one, so a ray from the origin through a corner of all boxes hits
 * that one only. Where the larger ones are split off, the ray enters the smaller ones' box first,
 * and all the larger ones wait on the stack. */
static rk_bvh build_deepest(deep_builder *deep, bool one_goes_left, uint32_t odd)
{
    deep->mesh = make_mesh(DEEP);
    deep->one_goes_left = one_goes_left;
    for (uint32_t i = 0; i < DEEP; i++) {
        uint32_t place = one_goes_left ? DEEP - 1 - i : i; /* the largest is split off first */
        float size = ldexpf(1, (int)place - DEEP / 2), tip = place == odd ? -size : size;
        deep->mesh.positions[3 * i] = rk_vec(-size, -tip, size);
        deep->mesh.positions[3 * i + 1] = rk_vec(size, -tip, size);
        deep->mesh.positions[3 * i + 2] = rk_vec(0, tip, size);
    }
    deep->count[0] = DEEP;
    deep->depth[0] = RK_BVH_LEVELS_MAX - 1;
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_init(&bvh, DEEP, DEEP, &error), error);
    for (uint32_t i = 0; i < DEEP; i++)
        bvh.triangles[i] = rk_bvh_triangle_of(&deep->mesh, i);
    rk_bvh_build_nodes(&bvh, split_one_off, deep);
    rk_check_equal(
        bvh.node_count, 2 * RK_BVH_LEVELS_MAX,
        "the root, an unused node, and two children for each of the other levels: each node "
        "that is split takes the next two; with depth_left = 0 a node is a leaf, whatever "
        "`split` returns");
    rk_check_ok(rk_bvh_validate(&bvh, &deep->mesh, &error), error);
    rk_check_equal(rk_bvh_measure(&bvh).levels, RK_BVH_LEVELS_MAX, "as deep as a tree may be");
    return bvh;
}

/* Halves six levels of as many triangles as there may be, none of which is looked at. */
static uint32_t split_six_levels(void *context, uint32_t begin, uint32_t count, uint32_t depth_left,
                                 rk_box *box)
{
    (void)context, (void)begin;
    *box = rk_box_empty();
    return depth_left > RK_BVH_LEVELS_MAX - 1 - 6 ? count - count / 2 : 0;
}

static void check_range(const rk_bvh *bvh, uint32_t node, uint32_t begin, uint32_t count,
                        uint32_t levels)
{
    const rk_bvh_node *n = &bvh->nodes[node];
    if (levels == 0) {
        rk_check(
            n->first == begin && n->count == count,
            "2^32 - 1 triangles, halved six times: got a leaf of %u triangles from %u on, want "
            "%u from %u on: all numbers of triangles have 32 bits",
            n->count, n->first, count, begin);
        return;
    }
    rk_check(n->count == 0 && n->first >= 2 && n->first < 2 * 64,
             "2^32 - 1 triangles, halved six times: node %u is not an inner one", node);
    uint32_t left = count - count / 2;
    check_range(bvh, n->first, begin, left, levels - 1);
    check_range(bvh, n->first + 1, begin + left, count - left, levels - 1);
}

static void check_all_triangles_that_32_bits_count(void)
{
    rk_bvh_node nodes[2 * 64];
    rk_bvh bvh = {.triangle_count = UINT32_MAX, .nodes = nodes};
    rk_bvh_build_nodes(&bvh, split_six_levels, NULL);
    check_range(&bvh, 0, 0, UINT32_MAX, 6);
}

static void each_split_is_told_how_many_levels_may_follow(void **state)
{
    (void)state;
    for (int one_goes_left = 0; one_goes_left < 2; one_goes_left++) {
        deep_builder deep;
        rk_bvh bvh = build_deepest(&deep, one_goes_left, DEEP);
        rk_bvh_free(&bvh);
        rk_mesh_free(&deep.mesh);
    }
    check_all_triangles_that_32_bits_count();
}

/* Halves each node down to leaves of this many triangles at most, in the order of the mesh. */
typedef struct other_builder {
    const rk_mesh *mesh;
    uint32_t leaf;
} other_builder;

static uint32_t split_down_to_leaf(void *context, uint32_t begin, uint32_t count,
                                   uint32_t depth_left, rk_box *box)
{
    const other_builder *other = context;
    (void)depth_left;
    *box = rk_box_empty();
    for (uint32_t i = 3 * begin; i < 3 * (begin + count); i++)
        *box = rk_box_add(*box, other->mesh->positions[i]);
    return count > other->leaf ? count / 2 : 0;
}

static void a_node_is_a_leaf_only_where_split_returns_0(void **state)
{
    (void)state;
    /* Down to single triangles, or not at all; behind the nodes of as many leaves are two that are
     * not the tree's. */
    const uint32_t counts[] = {1, 2, 3, 4, 5, 8, RK_BVH_LEAF_MAX};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        for (int single = 0; single < 2; single++) {
            uint32_t n = counts[i], leaves = single ? n : 1;
            rk_mesh mesh = make_soup(n, 0.1f, 19);
            rk_bvh bvh;
            rk_error error;
            rk_check_ok(rk_bvh_init(&bvh, n, leaves + 1, &error), error);
            const rk_bvh_node other = {rk_box_empty(), 12345, 6789};
            bvh.nodes[2 * leaves] = bvh.nodes[2 * leaves + 1] = other;
            for (uint32_t k = 0; k < n; k++)
                bvh.triangles[k] = rk_bvh_triangle_of(&mesh, k);
            rk_bvh_build_nodes(&bvh, split_down_to_leaf,
                               &(other_builder){&mesh, single ? 1 : RK_BVH_LEAF_MAX});
            rk_check(bvh.node_count == 2 * leaves && rk_bvh_measure(&bvh).leaves == leaves,
                     "%u triangles, and a `split` that returns 0 for %s: got %u nodes, want %u: "
                     "only `split` decides whether a node is a leaf, for other builders too",
                     n, single ? "single triangles" : "all of them", bvh.node_count, 2 * leaves);
            for (uint32_t k = 2 * leaves; k < 2 * leaves + 2; k++)
                rk_check(memcmp(&bvh.nodes[k], &other, sizeof other) == 0,
                         "%u leaves: node %u was changed, which is behind the last: %u leaves have "
                         "memory for %u nodes",
                         leaves, k, leaves, 2 * leaves);
            rk_check_ok(rk_bvh_validate(&bvh, &mesh, &error), error);
            rk_bvh_free(&bvh);
            rk_mesh_free(&mesh);
        }
}

/* A ray from the origin that hits the odd one only, and one from beyond all of them. */
static void check_deepest(int queries)
{
    const rk_ray rays[] = {{{0, 0, 0}, {0.75f, 0.75f, 1}, INFINITY},
                           {{0, 0, 0x1p60f}, {0, 0, -1}, INFINITY}};
    for (uint32_t odd = 0; odd < DEEP; odd++)
        for (int k = 0; k < 4; k++) {
            deep_builder deep;
            rk_bvh bvh = build_deepest(&deep, k / 2, odd);
            const rk_ray *ray = &rays[k % 2];
            rk_counters counters = {0};
            rk_hit want = closest_by_brute_force(&deep.mesh, ray);
            rk_check(want.triangle != RK_MISS, "brute force hits nothing: this test cannot tell");
            const char *name =
                k % 2 ? "a ray from beyond a tree of 64 levels"
                      : "a ray from the inside of a tree of 64 levels, which leaves up to 63 "
                        "nodes on the stack";
            if (queries & CLOSEST)
                check_hit(rk_bvh_closest(&bvh, ray, &counters), want, name);
            if (queries & OCCLUSION)
                check_occluded(rk_bvh_occluded(&bvh, ray, &counters), true, name);
            rk_bvh_free(&bvh);
            rk_mesh_free(&deep.mesh);
        }
}

static void the_deepest_tree_has_all_hits(void **state)
{
    (void)state;
    check_deepest(CLOSEST);
}

static void the_deepest_tree_occludes_as_brute_force(void **state)
{
    (void)state;
    check_deepest(OCCLUSION);
}

/* --- Difficult meshes ------------------------------------------------------------------------ */

static void where_memory_runs_out_nothing_is_kept(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(50, 0.5f, 14);
    check_every_allocation_failing(&mesh, rk_bvh_build_median);
    rk_mesh_free(&mesh);
}

static void identical_triangles_build_a_tree_and_the_first_is_hit(void **state)
{
    (void)state;
    rk_mesh mesh = make_mesh(1000);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        mesh.positions[i] = rk_vec(i % 3 == 1, i % 3 == 2, 0);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(rk_bvh_measure(&bvh).levels, 9,
                   "where all centroids coincide, halve by the triangles' indices");
    rk_bvh_range left = rk_bvh_range_of(&bvh, bvh.nodes[0].first);
    for (uint32_t i = left.begin; i < left.begin + left.count; i++)
        rk_check(bvh.triangles[i].index < 500,
                 "triangle %u of 1,000 equal ones went left: of equal centroids the smaller "
                 "indices go left, so that every machine builds the same tree",
                 bvh.triangles[i].index);
    rk_ray ray = {rk_vec(0.25f, 0.25f, -1), rk_vec(0, 0, 1), INFINITY};
    rk_counters counters = {0};
    check_hit(rk_bvh_closest(&bvh, &ray, &counters), closest_by_brute_force(&mesh, &ray),
              "a ray through a thousand equal triangles");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void flat_long_and_huge_meshes_equal_brute_force(void **state)
{
    (void)state;
    const rk_vec3 scales[] = {{1, 1, 0},
                              {0, 1, 0},
                              {0, 0, 0},
                              {1e6f, 1, 1e-6f},
                              {1e11f, 1e11f, 1e11f},
                              {1e-11f, 1e-11f, 1e-11f}};
    for (uint32_t s = 0; s < sizeof scales / sizeof *scales; s++) {
        rk_mesh mesh = make_soup(200, 0.3f, 6 + s);
        for (uint32_t i = 0; i < mesh.vertex_count; i++)
            mesh.positions[i] = rk_add(rk_mul(mesh.positions[i], scales[s]), rk_vec(0, 0, 0));
        uint32_t hits = check_against_brute_force(&mesh, 24, s, CLOSEST | OCCLUSION);
        rk_bvh bvh = build(&mesh);
        check_median(&bvh, &mesh, 0);
        rk_bvh_free(&bvh);
        bool has_area = scales[s].x != 0;
        rk_check(hits > 0 || !has_area, "no ray hits mesh %u: this test cannot tell", s);
        rk_mesh_free(&mesh);
    }
}

static void building_a_large_tree_takes_no_more_stack(void **state)
{
    (void)state;
    rk_mesh small = make_soup(100, 0.1f, 41), large = make_soup(25000, 0.1f, 41);
    check_stack_does_not_grow(&small, &large, rk_bvh_build_median);
    rk_mesh_free(&small);
    rk_mesh_free(&large);
}

static void coordinates_near_the_largest_float_build_a_sound_tree(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(500, 0.1f, 7);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        mesh.positions[i] = rk_scale(mesh.positions[i], 3e38f);
    rk_bvh bvh = build(&mesh);
    rk_check_equal(
        rk_bvh_measure(&bvh).leaves, 128,
        "halving depends on the number of triangles, not on extents, which may overflow");
    check_median(&bvh, &mesh, 0);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* Processor time to build a tree of `count` triangles in an order at which pivots go wrong. */
static double seconds_to_build(uint32_t count, uint32_t order)
{
    rk_mesh mesh = make_mesh(count);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t x[] = {i, count - i, i < count / 2 ? i : count - i, 0};
        for (uint32_t k = 0; k < 3; k++)
            mesh.positions[3 * i + k] = rk_vec((float)x[order], (float)(k == 1), (float)(k == 2));
    }
    double start = rk_clock_thread();
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_build_median(&bvh, &mesh, &error), error);
    double seconds = rk_clock_thread() - start;
    rk_check(rk_bvh_validate(&bvh, &mesh, &error), "%u triangles: the tree is not sound: %s", count,
             error.text);
    rk_check_equal(rk_bvh_measure(&bvh).leaves, count == 16000 ? 4096 : 1024, "halving down to 4");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
    return seconds;
}

static void no_order_of_the_mesh_makes_building_slow(void **state)
{
    (void)state;
    /* Four times as many triangles take 4.8 times as long by a linear selection on each of twelve
     * levels instead of ten, 5.4 times by sorting there, and 16 times by a quadratic selection, on
     * any machine, with sanitizers or without. What disturbs one measurement does not disturb
     * all. Memory that is new to a process can take longer than building does; glibc keeps memory
     * once it has freed a large block. */
    const char *names[] = {"sorted", "reversed", "rising, then falling", "all equal"};
    const uint32_t few = 4000, many = 16000, times = 4, tries = 8;
    const double limit = 8;
    rk_mesh large_block = make_mesh(100000);
    rk_mesh_free(&large_block);
    for (uint32_t order = 0; order < sizeof names / sizeof *names; order++) {
        double seconds = INFINITY, want = 0;
        for (uint32_t k = 0; k < tries && seconds > want; k++) {
            double sum = 0;
            seconds = fmin(seconds, seconds_to_build(many, order));
            for (uint32_t i = 0; i < times; i++)
                sum += seconds_to_build(few, order);
            want = fmin(k == 0 ? INFINITY : want, limit * sum / times);
        }
        rk_check(seconds <= want,
                 "%u triangles, %s: building took %.3g s, want at most %.3g s, %g times as long as "
                 "for %u: is the selection quadratic?",
                 many, names[order], seconds, want, limit, few);
    }
}

/* --- Rays ------------------------------------------------------------------------------------ */

static void check_soups(int queries)
{
    const struct {
        uint32_t triangles;
        float size;
    } soups[] = {{1, 1}, {2, 1}, {5, 1}, {50, 0.5f}, {500, 0.2f}, {3000, 0.03f}};
    for (uint32_t i = 0; i < sizeof soups / sizeof *soups; i++) {
        rk_mesh mesh = make_soup(soups[i].triangles, soups[i].size, 20 + i);
        uint32_t rays = soups[i].triangles < 100 ? 1000 : 100;
        check_against_brute_force(&mesh, rays, 30 + i, queries);
        rk_mesh_free(&mesh);
    }
}

static void rays_find_the_same_hits_as_brute_force(void **state)
{
    (void)state;
    check_soups(CLOSEST);
}

static void rays_are_occluded_where_brute_force_hits(void **state)
{
    (void)state;
    check_soups(OCCLUSION);
}

static void rays_along_a_grid_find_the_same_hits_as_brute_force(void **state)
{
    (void)state;
    /* Squares of a floor on whole coordinates: rays from whole coordinates along the axes run in
     * box faces and through edges and corners. */
    const uint32_t side = 8;
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
                rk_hit want = closest_by_brute_force(&mesh, &ray);
                char name[64];
                snprintf(name, sizeof name, "ray from x = %g, z = %g along axis %c", i / 2.0,
                         j / 2.0, "xyz"[axis]);
                rk_hit got = rk_bvh_closest(&bvh, &ray, &counters);
                check_hit(got, want, name);
                rk_check(axis != 1 || got.triangle != RK_MISS,
                         "%s: got nothing, want the floor: there is a hole in it", name);
            }
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void a_box_that_begins_at_the_nearest_hit_is_visited(void **state)
{
    (void)state;
    /* Large triangles in one plane: 4 to 7 in the left leaf, which is visited first, 0 to 3 in the
     * right one; the ray intersects all of them at the same t. A box's entry is moved towards the
     * ray against rounding, but not where t is so small that floats are coarse: 2^-146 is 8 times
     * the smallest one. */
    rk_mesh mesh = make_mesh(8);
    for (uint32_t i = 0; i < 8; i++) {
        float x = i < 4 ? 1 : 0;
        mesh.positions[3 * i] = rk_vec(x - 4, -4, 0);
        mesh.positions[3 * i + 1] = rk_vec(x + 4, -4, 0);
        mesh.positions[3 * i + 2] = rk_vec(x, 4, 0);
    }
    rk_bvh bvh = build(&mesh);
    rk_counters counters = {0};
    rk_ray ray = {rk_vec(0, 0, -0x1p-26f), rk_vec(0, 0, 0x1p120f), INFINITY};
    rk_hit want = closest_by_brute_force(&mesh, &ray);
    rk_check(want.t == 0x1p-146f, "brute force got t = %g, want 2^-146: this test cannot tell",
             (double)want.t);
    check_hit(rk_bvh_closest(&bvh, &ray, &counters), want, "a ray through triangles in one plane");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void boxes_that_begin_at_t_max_are_visited(void **state)
{
    (void)state;
    /* As above, but the triangles of one leaf, or of both, have their tips down, and the ray at
     * (2, 3) misses those with their tips up. It ends on the plane of all of them. */
    for (int hits = 1; hits <= 3; hits++) {
        rk_mesh mesh = make_mesh(8);
        for (uint32_t i = 0; i < 8; i++) {
            float x = i < 4 ? 1 : 0, tip = (hits >> (i < 4) & 1) ? -4 : 4;
            mesh.positions[3 * i] = rk_vec(x - 4, -tip, 0);
            mesh.positions[3 * i + 1] = rk_vec(x + 4, -tip, 0);
            mesh.positions[3 * i + 2] = rk_vec(x, tip, 0);
        }
        rk_bvh bvh = build(&mesh);
        rk_counters counters = {0};
        rk_ray ray = {rk_vec(2, 3, -0x1p-26f), rk_vec(0, 0, 0x1p120f), 0x1p-146f};
        rk_hit want = closest_by_brute_force(&mesh, &ray);
        rk_check(want.t == ray.t_max && want.triangle == (hits == 1 ? 4u : 0u),
                 "brute force got triangle %u at t = %g: this test cannot tell", want.triangle,
                 (double)want.t);
        const char *name = hits == 1   ? "a ray that ends on triangles of the left leaf"
                           : hits == 2 ? "a ray that ends on triangles of the right leaf"
                                       : "a ray that ends on triangles of both leaves";
        check_hit(rk_bvh_closest(&bvh, &ray, &counters), want, name);
        check_occluded(rk_bvh_occluded(&bvh, &ray, &counters), true, name);
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

static void place_flat(rk_mesh *mesh, uint32_t triangle, rk_vec3 centre, float size)
{
    mesh->positions[3 * triangle] = rk_add(centre, rk_vec(-size, -size, 0));
    mesh->positions[3 * triangle + 1] = rk_add(centre, rk_vec(size, -size, 0));
    mesh->positions[3 * triangle + 2] = rk_add(centre, rk_vec(0, size, 0));
}

/* Large triangles across the z axis, and rays along it that are so slow that t is 2^127 and more:
 * only an infinite t is a miss. */
static void check_hits_near_the_largest_float(void)
{
    rk_mesh mesh = make_mesh(8);
    for (uint32_t i = 0; i < 8; i++)
        place_flat(&mesh, i, rk_vec(0, 0, 1 + (float)i / 16), 0x1p20f);
    rk_bvh bvh = build(&mesh);
    rk_counters counters = {0};
    for (int side = 0; side < 2; side++) {
        rk_ray ray = {rk_vec(0, 0, side ? 2.5f : 0), rk_vec(0, 0, side ? -0x1p-127f : 0x1p-127f),
                      INFINITY};
        rk_hit want = closest_by_brute_force(&mesh, &ray);
        rk_check(want.triangle == (side ? 7 : 0) && want.t >= 0x1p127f,
                 "brute force got %s at t = %g: this test cannot tell",
                 triangle_name(want.triangle), (double)want.t);
        check_hit(rk_bvh_closest(&bvh, &ray, &counters), want, "a ray that hits at t >= 2^127");
        check_occluded(rk_bvh_occluded(&bvh, &ray, &counters), true,
                       "a ray that hits at t >= 2^127");
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
        float from, t_max;
        uint32_t want;
        float t;
    } cases[] = {{0, 2, RK_MISS, 2},         {0, 2.03125f, 1, 2.03125f}, {0, 3, 1, 2.03125f},
                 {0, INFINITY, 1, 2.03125f}, {0, FLT_MAX, 1, 2.03125f},  {0, 0, RK_MISS, 0},
                 {0, -1, RK_MISS, -1},       {2.03125f, INFINITY, 2, 2}, {2.03125f, 1, RK_MISS, 1},
                 {2.03125f, 0, RK_MISS, 0}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        rk_ray ray = {rk_vec(0.03125f, 0.03125f, cases[i].from), rk_vec(0, 0, 1), cases[i].t_max};
        char name[100];
        snprintf(name, sizeof name,
                 "triangles at z = 2.03125, 4.03125 ..., from z = %g, t_max = %g",
                 (double)cases[i].from, (double)cases[i].t_max);
        rk_hit want = {cases[i].t, 0.25f, 0.25f, cases[i].want};
        check_hit(rk_bvh_closest(&bvh, &ray, &counters), want, name);
        check_occluded(rk_bvh_occluded(&bvh, &ray, &counters), want.triangle != RK_MISS, name);
    }
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
    check_hits_near_the_largest_float();
}

static void a_ray_of_nan_misses(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(100, 0.5f, 8);
    rk_bvh bvh = build(&mesh);
    rk_counters counters = {0};
    const struct {
        rk_ray ray;
        const char *name;
    } odd[] = {{{{0, 0, 0}, {NAN, NAN, NAN}, INFINITY}, "a direction of NaN"},
               {{{0, 0, 0}, {NAN, 0, 1}, INFINITY}, "a direction with one NaN"},
               {{{0, 0, 0}, {0, 1, NAN}, 10}, "a direction with one NaN, t_max = 10"},
               {{{NAN, NAN, NAN}, {0, 0, 1}, INFINITY}, "an origin of NaN"},
               {{{0, NAN, 0}, {1, 0, 0}, INFINITY}, "an origin with one NaN"},
               {{{0, 0, 0}, {0, 0, 0}, INFINITY}, "a direction of 0"}};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        const rk_ray *ray = &odd[i].ray;
        check_hit(rk_bvh_closest(&bvh, ray, &counters), (rk_hit){ray->t_max, 0, 0, RK_MISS},
                  odd[i].name);
        check_occluded(rk_bvh_occluded(&bvh, ray, &counters), false, odd[i].name);
    }
    /* A miss counts only if other rays hit. */
    check_against_brute_force(&mesh, 100, 8, CLOSEST | OCCLUSION);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* A solution that allocates per ray is correct but slow: its threads wait for each other in malloc.
 * */
static void a_ray_allocates_no_memory(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(1000, 0.1f, 12);
    size_t before = rk_allocations;
    rk_bvh bvh = build(&mesh);
    rk_check(!rk_allocations_are_counted || rk_allocations > before,
             "building allocates, but no call was counted: this test cannot tell");
    rk_box bounds = rk_mesh_bounds(&mesh);
    rk_counters counters = {0};
    uint32_t hits = 0;
    before = rk_allocations;
    for (uint32_t i = 0; i < 100; i++) {
        rk_ray ray = make_ray(i, 13, bounds);
        hits += rk_bvh_closest(&bvh, &ray, &counters).triangle != RK_MISS;
        hits += rk_bvh_occluded(&bvh, &ray, &counters);
    }
    rk_check_equal(rk_allocations - before, 0,
                   "200 queries: keep the stack in an array of RK_BVH_LEVELS_MAX entries");
    rk_check(hits > 0, "got 0 hits from 200 queries, want some: nothing is searched yet");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* --- No more work than needed ---------------------------------------------------------------- */

/* Counts are what the code says of itself. So each claim below asks twice: once for the counts, and
 * once in a copy of the tree in which all that needs no look is closed (guarded_tree.h). */
static const char *mistake_of_counts(rk_counters got, rk_counters want)
{
    if (got.box_tests == 0 && got.triangle_tests == 0)
        return "; nothing is counted";
    if (got.box_tests == want.box_tests)
        return "; the box tests are right: are the triangles of each leaf counted, as many as are "
               "tested?";
    if (got.triangle_tests == want.triangle_tests && got.box_tests + 1 == want.box_tests)
        return "; one box is missing: is the root's tested, and counted?";
    return got.triangle_tests == want.triangle_tests
               ? "; the triangle tests are right: which boxes are tested, and when?"
               : "";
}

static void check_counts(rk_counters got, rk_counters want, const char *ray, const char *hint)
{
    rk_counters others = got;
    others.box_tests = want.box_tests, others.triangle_tests = want.triangle_tests;
    rk_check(memcmp(&others, &want, sizeof want) == 0,
             "%s: another counter than box_tests and triangle_tests was changed", ray);
    rk_check(got.box_tests == want.box_tests && got.triangle_tests == want.triangle_tests,
             "%s: got %llu box tests and %llu triangle tests, want %llu and %llu: %s%s", ray,
             (unsigned long long)got.box_tests, (unsigned long long)got.triangle_tests,
             (unsigned long long)want.box_tests, (unsigned long long)want.triangle_tests, hint,
             mistake_of_counts(got, want));
}

static void ask(int query, const rk_bvh *bvh, const rk_ray *ray, rk_counters *counters)
{
    if (query == CLOSEST)
        rk_bvh_closest(bvh, ray, counters);
    else
        rk_bvh_occluded(bvh, ray, counters);
}

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

static void check_rays_that_miss_the_root(int query)
{
    const struct {
        rk_ray ray;
        const char *name;
    } rays[] = {{{{5, 5, 5}, {1, 0, 0}, INFINITY}, "a ray beside the mesh"},
                {{{0, 0, 5}, {0, 0, 1}, INFINITY}, "a ray away from the mesh"},
                {{{0, 0, -5}, {0, 0, 1}, 1}, "a ray that ends before the mesh"}};
    const uint32_t counts[] = {100, 5, 4, 1}; /* up to 4, the root is a leaf */
    for (int k = 0; k < 4 * 3; k++) {
        const rk_ray *ray = &rays[k % 3].ray;
        rk_mesh mesh = make_soup(counts[k / 3], 0.1f, 9);
        rk_bvh bvh = build(&mesh);
        guarded_tree guarded = guard_tree(&bvh);
        rk_counters counters = {0};
        char name[64];
        snprintf(name, sizeof name, "%s of %u triangle%s", rays[k % 3].name, mesh.triangle_count,
                 mesh.triangle_count == 1 ? "" : "s");
        ask(query, &bvh, ray, &counters);
        check_counts(
            counters, (rk_counters){.box_tests = 1}, name,
            "the root's box is the only test, also of a root that is a leaf, and is counted. If it "
            "was entered: rk_box_enter returns INFINITY for a miss, which is not greater than an "
            "infinite t_max");
        guarded_open_for(&guarded, ray, ray->t_max);
        ask(query, &guarded.copy, ray, &counters);
        guarded_free(&guarded);
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

static void a_ray_that_misses_the_root_tests_one_box(void **state)
{
    (void)state;
    check_rays_that_miss_the_root(CLOSEST);
}

/* Rays in a soup, some of them to a point within it. */
static rk_ray make_short_ray(uint32_t i, const rk_mesh *mesh)
{
    rk_ray ray = make_ray(i, 16, rk_mesh_bounds(mesh));
    ray.t_max = i % 3 ? 0.05f * (float)(i % 7) : INFINITY;
    return ray;
}

/* Two pages, of which one is open at a time; `turns` counts how often the other one is wanted. */
static struct {
    char *start;
    size_t page;
    int turns;
    struct sigaction before[2];
} book;
static const int page_faults[2] = {SIGSEGV, SIGBUS};

static void turn_page(int signal, siginfo_t *info, void *context)
{
    (void)context;
    size_t at = (size_t)((char *)info->si_addr - book.start), page = book.page;
    if (at >= 2 * page) { /* another fault, which comes again */
        rk_handle_fault(signal, &book.before[signal == SIGBUS], NULL);
        return;
    }
    /* One instruction that reads from both would turn them for ever. */
    bool too_often = ++book.turns > 100;
    mprotect(book.start, 2 * page, too_often ? PROT_READ : PROT_NONE);
    mprotect(book.start + at / page * page, page, PROT_READ);
}

static void open_book(void)
{
    struct sigaction turn = {.sa_sigaction = turn_page, .sa_flags = SA_SIGINFO};
    for (int i = 0; i < 2; i++)
        rk_handle_fault(page_faults[i], &turn, &book.before[i]);
    book.turns = 0;
    mprotect(book.start, 2 * book.page, PROT_NONE);
}

static void close_book(void)
{
    for (int i = 0; i < 2; i++)
        rk_handle_fault(page_faults[i], &book.before[i], NULL);
    mprotect(book.start, 2 * book.page, PROT_READ | PROT_WRITE);
}

/* A leaf of 64 triangles, half of them on each of two pages. A ray that passes beside all of them,
 * or hits only the last, tests each once, so that both pages are wanted once. */
static void check_leaves_are_tested_once(int query)
{
    book.page = (size_t)sysconf(_SC_PAGESIZE);
    book.start = guarded_pages(2 * book.page);
    const uint32_t half = RK_BVH_LEAF_MAX / 2;
    rk_triangle *triangles =
        (rk_triangle *)(void *)(book.start + book.page - half * sizeof(rk_triangle));
    for (int hit = 0; hit < 2; hit++) {
        for (uint32_t i = 0; i < RK_BVH_LEAF_MAX; i++)
            triangles[i] = (rk_triangle){{-1, -1, 1}, {1, -1, 1}, {-1, 1, 1}, i};
        if (hit)
            triangles[RK_BVH_LEAF_MAX - 1].b = rk_vec(1, 1, 1);
        rk_bvh_node root = {rk_box_empty(), 0, RK_BVH_LEAF_MAX};
        root.box = rk_box_add(rk_box_add(root.box, rk_vec(-1, -1, 1)), rk_vec(1, 1, 1));
        const rk_bvh bvh = {1, RK_BVH_LEAF_MAX, &root, triangles};
        const rk_ray ray = {rk_vec(-0.1f, 0.5f, 0), rk_vec(0, 0, 1), INFINITY};
        rk_counters counters = {0};
        open_book();
        ask(query, &bvh, &ray, &counters);
        close_book();
        rk_check(book.turns == 2,
                 "a leaf of 64 triangles on two pages, %s: a page was wanted %d times, want 2: "
                 "each triangle of a leaf is tested once",
                 hit ? "of which the ray hits the last" : "none of which the ray hits", book.turns);
    }
    munmap(book.start, 2 * book.page);
}

/* A ray that hits nothing tests all boxes whose parents it enters before t_max, in any order.
 * Returns the number of such rays. */
static uint32_t check_rays_without_a_hit_of(uint32_t triangles, float size, int query)
{
    rk_mesh mesh = make_soup(triangles, size, 15);
    rk_bvh bvh = build(&mesh);
    guarded_tree guarded = guard_tree(&bvh);
    uint32_t tried = 0;
    for (uint32_t i = 0; i < 60; i++) {
        rk_ray ray = make_short_ray(i, &mesh);
        if (closest_by_brute_force(&mesh, &ray).triangle != RK_MISS)
            continue;
        rk_counters want = guarded_open_for(&guarded, &ray, ray.t_max), got = {0};
        char name[80];
        snprintf(name, sizeof name, "ray %u, which hits none of %u triangles before t_max = %g", i,
                 triangles, (double)ray.t_max);
        ask(query, &bvh, &ray, &got);
        check_counts(got, want, name,
                     "the root's box, and both boxes below each node whose box the ray enters "
                     "before t_max; of the triangles those in such leaves. A miss is INFINITY, no "
                     "greater than a t_max of INFINITY");
        ask(query, &guarded.copy, &ray, &got);
        tried++;
    }
    guarded_free(&guarded);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
    return tried;
}

static void check_rays_without_a_hit(int query)
{
    uint32_t tried = check_rays_without_a_hit_of(3000, 0.01f, query);
    rk_check(tried >= 20, "only %u of 60 rays hit nothing: too few for this test", tried);
    for (uint32_t triangles = 1; triangles <= 10; triangles++)
        check_rays_without_a_hit_of(triangles, 0.5f, query);
}

static void a_ray_without_a_hit_tests_only_boxes_before_t_max(void **state)
{
    (void)state;
    check_rays_without_a_hit(CLOSEST);
    check_leaves_are_tested_once(CLOSEST);
}

static void an_occlusion_test_looks_no_farther_than_t_max(void **state)
{
    (void)state;
    check_rays_that_miss_the_root(OCCLUSION);
    check_rays_without_a_hit(OCCLUSION);
    check_leaves_are_tested_once(OCCLUSION);
}

/* A ray along the curtains, from in front of the first or from behind the last. */
static rk_ray ray_at_curtains(int side)
{
    return (rk_ray){rk_vec(0.25f, 0.5f, side ? 6000 : -10), rk_vec(0, 0, side ? -1 : 1), INFINITY};
}

/* What the search for the closest hit looks at, by the definition. `tie` becomes true where a ray
 * enters two siblings at the same t, and either may be the first. */
typedef struct search {
    const rk_bvh *bvh;
    const rk_ray *ray;
    rk_slabs slabs;
    rk_hit hit;
    rk_counters tests;
    bool tie;
} search;

static void search_below(search *s, const rk_bvh_node *node)
{
    for (uint32_t i = 0; i < node->count; i++)
        rk_triangle_closest(&s->bvh->triangles[node->first + i], s->ray, &s->hit);
    s->tests.triangle_tests += node->count;
    if (node->count)
        return;
    const rk_bvh_node *child = &s->bvh->nodes[node->first];
    float enter[] = {rk_box_enter(&child[0].box, &s->slabs, s->hit.t),
                     rk_box_enter(&child[1].box, &s->slabs, s->hit.t)};
    int nearer = enter[1] < enter[0];
    s->tests.box_tests += 2;
    s->tie |= enter[0] == enter[1] && enter[0] < INFINITY;
    for (int k = 0; k < 2; k++) {
        int at = k ? 1 - nearer : nearer;
        if (enter[at] < INFINITY && enter[at] <= s->hit.t)
            search_below(s, &child[at]);
    }
}

/* Rays from outside of a soup, whose hits are among many boxes. */
static void check_counts_of_rays_with_a_hit(void)
{
    rk_mesh mesh = make_soup(2000, 0.15f, 17);
    rk_bvh bvh = build(&mesh);
    uint32_t tried = 0;
    for (uint32_t i = 0; i < 1000; i++) {
        rk_ray ray = make_ray(i, 18, rk_mesh_bounds(&mesh));
        search s = {&bvh, &ray, rk_slabs_of(&ray), {ray.t_max, 0, 0, RK_MISS}, {0}, false};
        s.tests.box_tests = 1;
        if (rk_box_enter(&bvh.nodes[0].box, &s.slabs, ray.t_max) < INFINITY)
            search_below(&s, &bvh.nodes[0]);
        if (s.tie || s.hit.triangle == RK_MISS)
            continue;
        rk_counters counters = {0};
        char name[64];
        snprintf(name, sizeof name, "ray %u, which hits triangle %u of 2,000", i, s.hit.triangle);
        check_hit(rk_bvh_closest(&bvh, &ray, &counters), s.hit, name);
        check_counts(counters, s.tests, name,
                     "where the ray enters both children, the one that it enters first comes "
                     "first, and the other one only if no hit so far is nearer than its box");
        tried++;
    }
    rk_check(tried >= 200, "only %u of 1,000 rays hit: too few for this test", tried);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void nodes_behind_the_nearest_hit_are_skipped_from_either_side(void **state)
{
    (void)state;
    rk_mesh mesh = make_curtains(512);
    rk_bvh bvh = build(&mesh);
    guarded_tree guarded = guard_tree(&bvh);
    for (int side = 0; side < 2; side++) {
        rk_ray ray = ray_at_curtains(side);
        rk_counters counters = {0};
        rk_hit hit = rk_bvh_closest(&bvh, &ray, &counters);
        uint32_t first = side ? 1022 : 0; /* of its curtain's two triangles; the ray may hit both */
        rk_check(hit.triangle - first < 2,
                 "got %s, want triangle %u or %u: the first of 512 curtains",
                 triangle_name(hit.triangle), first, first + 1);
        /* 1,024 triangles make 256 leaves and 9 levels: down to one leaf, two boxes per level. */
        check_counts(counters, (rk_counters){.box_tests = 1 + 2 * 8, .triangle_tests = 4},
                     "512 curtains",
                     "the root's box, then two children's on each of 8 levels, and one leaf: visit "
                     "the nearer child "
                     "first, and no box that the ray enters behind the nearest hit so far");
        guarded_open_for(&guarded, &ray, hit.t);
        check_hit(rk_bvh_closest(&guarded.copy, &ray, &counters), hit, "the same ray again");
    }
    guarded_free(&guarded);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
    check_counts_of_rays_with_a_hit();
}

static void children_behind_the_nearest_hit_are_not_visited(void **state)
{
    (void)state;
    /* A ray along z at x = y = 0. The right leaf is entered first, at t = 5, and hit at 10. The
     * left node is entered at 7, in a corner without triangles: of its leaves the lower one is
     * beside the ray, the upper one begins at 15. */
    const struct {
        rk_vec3 centre;
        float size;
    } flat[] = {{{-1, -40, -3}, 1}, {{-1, -30, -3}, 1}, {{-1, -20, -3}, 1},
                {{-0.5f, 0, 5}, 2}, {{-0.5f, 0, 7}, 2}, {{0.5f, 0, 0}, 2},
                {{50, 0, -5}, 1},   {{60, 0, -5}, 1},   {{100, 0, -5}, 1}};
    rk_mesh mesh = make_mesh(9);
    for (uint32_t i = 0; i < 9; i++)
        place_flat(&mesh, i, flat[i].centre, flat[i].size);
    rk_bvh bvh = build(&mesh);
    guarded_tree guarded = guard_tree(&bvh);
    rk_ray ray = {rk_vec(0, 0, -10), rk_vec(0, 0, 1), INFINITY};
    rk_hit want = closest_by_brute_force(&mesh, &ray);
    rk_counters counters = {0};
    check_hit(rk_bvh_closest(&bvh, &ray, &counters), want, "a ray past a node's empty corner");
    check_counts(counters, (rk_counters){.box_tests = 5, .triangle_tests = 4},
                 "a ray past a node's empty corner",
                 "the root's box, its children's, those of the left node, and the triangles of the "
                 "leaf that is hit: a child counts as missed if the ray enters it behind the "
                 "nearest hit so far, not behind ray->t_max");
    guarded_open_for(&guarded, &ray, want.t);
    check_hit(rk_bvh_closest(&guarded.copy, &ray, &counters), want, "the same ray again");
    guarded_free(&guarded);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* A ray through all triangles of a tree that is one leaf. */
static void check_occlusion_in_one_leaf(void)
{
    for (uint32_t count = 1; count <= RK_BVH_LEAF_TARGET; count++) {
        rk_mesh mesh = make_mesh(count);
        for (uint32_t i = 0; i < count; i++)
            place_flat(&mesh, i, rk_vec(0, 0, (float)i), 1);
        rk_bvh bvh = build(&mesh);
        rk_ray ray = {rk_vec(0, 0, -1), rk_vec(0, 0, 1), INFINITY};
        rk_counters counters = {0};
        check_occluded(rk_bvh_occluded(&bvh, &ray, &counters), true, "a ray through all triangles");
        check_counts(counters, (rk_counters){.box_tests = 1, .triangle_tests = 1},
                     "an occlusion test through all triangles of a single leaf",
                     "the root's box, and the first triangle, which is hit");
        rk_bvh_free(&bvh);
        rk_mesh_free(&mesh);
    }
}

/* A leaf as large as may be, of which a builder's own split decides. The first triangle is hit, so
 * nothing is looked at behind the first four, which may be tested at once. */
static void check_occlusion_in_a_large_leaf(void)
{
    const size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *pages = guarded_pages(2 * page);
    rk_triangle *triangles = (rk_triangle *)(void *)(pages + page - 4 * sizeof(rk_triangle));
    for (uint32_t i = 0; i < RK_BVH_LEAF_MAX; i++)
        triangles[i] = (rk_triangle){{-1, -1, 1}, {1, -1, 1}, {0, 1, 1}, i};
    rk_bvh_node root = {rk_box_empty(), 0, RK_BVH_LEAF_MAX};
    root.box = rk_box_add(rk_box_add(root.box, rk_vec(-1, -1, 1)), rk_vec(1, 1, 1));
    const rk_bvh bvh = {1, RK_BVH_LEAF_MAX, &root, triangles};
    rk_ray ray = {rk_vec(0, 0, 0), rk_vec(0, 0, 1), INFINITY};
    rk_counters counters = {0};
    guard_close(pages + page, page);
    check_occluded(rk_bvh_occluded(&bvh, &ray, &counters), true,
                   "a leaf of 64 triangles, all of which the ray hits");
    check_counts(counters, (rk_counters){.box_tests = 1, .triangle_tests = 1},
                 "an occlusion test through all 64 triangles of a leaf",
                 "the root's box, and the first triangle, which is hit");
    guard_open(pages + page, page);
    munmap(pages, 2 * page);
}

static void occlusion_tests_stop_at_the_first_hit(void **state)
{
    (void)state;
    rk_mesh mesh = make_curtains(512);
    rk_bvh bvh = build(&mesh);
    guarded_tree guarded = guard_tree(&bvh);
    for (int side = 0; side < 2; side++) {
        rk_ray ray = ray_at_curtains(side);
        rk_counters counters = {0};
        check_occluded(rk_bvh_occluded(&bvh, &ray, &counters), true, "512 curtains occlude it");
        rk_counters once = counters;
        /* It hits one triangle of each curtain, so two of a leaf's four: the third test at the
         * latest. */
        rk_check(counters.triangle_tests >= 1 && counters.triangle_tests <= 3,
                 "got %llu triangle tests, want 1 to 3: the first hit ends the search, even in the "
                 "middle of a leaf",
                 (unsigned long long)counters.triangle_tests);
        rk_check(
            counters.box_tests >= 1 && counters.box_tests <= 1 + 2 * 8,
            "got %llu box tests, want %d at most, the root's and two on each of 8 levels: go down "
            "to the nearer child first",
            (unsigned long long)counters.box_tests, 1 + 2 * 8);
        guarded_open_for(&guarded, &ray, rk_bvh_closest(&bvh, &ray, &(rk_counters){0}).t);
        check_occluded(rk_bvh_occluded(&guarded.copy, &ray, &counters), true,
                       "512 curtains occlude it");
        once.box_tests *= 2, once.triangle_tests *= 2;
        check_counts(counters, once, "the same ray twice", "counters are added to, not set");
    }
    guarded_free(&guarded);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
    check_occlusion_in_one_leaf();
    check_occlusion_in_a_large_leaf();
}

static void counts_of_several_rays_add_up(void **state)
{
    (void)state;
    rk_mesh mesh = make_curtains(512);
    rk_bvh bvh = build(&mesh);
    rk_ray ray = ray_at_curtains(0);
    rk_counters one = {0}, three = {0};
    rk_bvh_closest(&bvh, &ray, &one);
    for (int i = 0; i < 3; i++)
        rk_bvh_closest(&bvh, &ray, &three);
    rk_check(one.box_tests > 0 && one.triangle_tests > 0,
             "got %llu box tests and %llu triangle tests of a ray that hits, want some of each: "
             "nothing is counted yet",
             (unsigned long long)one.box_tests, (unsigned long long)one.triangle_tests);
    one.box_tests *= 3, one.triangle_tests *= 3;
    check_counts(three, one, "three times the same ray", "counters are added to, not set");
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

/* Halves the node down to two triangles; all boxes are the same, {0, 0, 0} to {1, 1, 0}. By hand,
 * so that no builder is asked. */
static void halve_by_hand(rk_bvh *bvh, uint32_t node, uint32_t begin, uint32_t count)
{
    const rk_box box = {{rk_vec(0, 0, 0), rk_vec(1, 1, 0)}};
    if (count <= 2) {
        bvh->nodes[node] = (rk_bvh_node){box, begin, count};
        return;
    }
    const uint32_t left = bvh->node_count;
    bvh->node_count += 2;
    bvh->nodes[node] = (rk_bvh_node){box, left, 0};
    halve_by_hand(bvh, left, begin, count / 2);
    halve_by_hand(bvh, left + 1, begin + count / 2, count - count / 2);
}

static void large_counts_do_not_wrap_around(void **state)
{
    (void)state;
    /* The ray enters the box that all triangles share, and passes beside them. */
    const uint32_t n = (1 << 16) + 4;
    rk_mesh mesh = make_mesh(n);
    for (uint32_t i = 0; i < mesh.vertex_count; i++)
        mesh.positions[i] = rk_vec(i % 3 == 1, i % 3 == 2, 0);
    rk_bvh bvh;
    rk_error error;
    rk_check_ok(rk_bvh_init(&bvh, n, n, &error), error);
    for (uint32_t i = 0; i < n; i++)
        bvh.triangles[i] = rk_bvh_triangle_of(&mesh, i);
    bvh.nodes[1] = (rk_bvh_node){0};
    bvh.node_count = 2;
    halve_by_hand(&bvh, 0, 0, n);
    rk_check_ok(rk_bvh_validate(&bvh, &mesh, &error), error);
    rk_check(bvh.node_count - 1 > 1 << 16, "only %u nodes: this test cannot tell", bvh.node_count);
    rk_ray ray = {rk_vec(0.75f, 0.75f, -1), rk_vec(0, 0, 1), INFINITY};
    for (int occlusion = 0; occlusion < 2; occlusion++) {
        const uint64_t before = UINT32_MAX;
        rk_counters counters, want;
        memset(&counters, 5, sizeof counters); /* all others, too, which are kept */
        counters.box_tests = counters.triangle_tests = before;
        want = counters;
        want.box_tests += bvh.node_count - 1, want.triangle_tests += mesh.triangle_count;
        if (occlusion)
            rk_bvh_occluded(&bvh, &ray, &counters);
        else
            rk_bvh_closest(&bvh, &ray, &counters);
        check_counts(counters, want,
                     occlusion ? "an occlusion test that looks at everything, after others"
                               : "a ray that looks at everything, after others",
                     "counters have 64 bits; 16 or 32 are too few, for one ray or for many");
    }
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static void most_boxes_of_a_large_mesh_are_never_tested(void **state)
{
    (void)state;
    rk_mesh mesh = make_soup(20000, 0.01f, 10);
    rk_bvh bvh = build(&mesh);
    rk_counters counters = {0};
    const rk_box bounds = rk_mesh_bounds(&mesh);
    const uint32_t rays = 1000;
    for (uint32_t i = 0; i < rays; i++) {
        rk_ray ray = make_ray(i, 11, bounds);
        rk_bvh_closest(&bvh, &ray, &counters);
    }
    /* Measured: about 250 boxes and 100 triangles per ray in this thin soup, of 16,383 and 20,000.
     * Ten times as many mean that whole subtrees are traversed in vain. */
    rk_check(counters.box_tests > rays && counters.box_tests < rays * 2500ull,
             "got %llu box tests per ray, want between 1 and 2500: count them, and visit only "
             "children whose boxes the ray enters; a miss is INFINITY, no greater than a t_max of "
             "INFINITY",
             (unsigned long long)(counters.box_tests / rays));
    rk_check(counters.triangle_tests > 0 && counters.triangle_tests < rays * 1000ull,
             "got %llu triangle tests per ray, want some, and less than 1000: count them, and "
             "visit only leaves whose boxes the ray enters",
             (unsigned long long)(counters.triangle_tests / rays));
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
    /* A smaller soup: each triangle has five pages, 400 MB for 20,000. */
    mesh = make_soup(2000, 0.01f, 10);
    bvh = build(&mesh);
    guarded_tree guarded = guard_tree(&bvh);
    for (uint32_t i = 0; i < 10; i++) {
        rk_ray ray = make_ray(i, 11, bounds);
        guarded_open_for(&guarded, &ray, ray.t_max);
        check_hit(rk_bvh_closest(&guarded.copy, &ray, &counters),
                  rk_bvh_closest(&bvh, &ray, &counters), "the same ray again");
    }
    guarded_free(&guarded);
    rk_bvh_free(&bvh);
    rk_mesh_free(&mesh);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(no_triangles_give_a_tree_without_nodes),
    cmocka_unit_test(where_memory_runs_out_nothing_is_kept),
    cmocka_unit_test(up_to_four_triangles_are_one_leaf),
    cmocka_unit_test(five_triangles_split_three_to_two),
    cmocka_unit_test(levels_and_leaves_follow_from_halving),
    cmocka_unit_test(a_node_is_a_leaf_only_where_split_returns_0),
    cmocka_unit_test(each_split_is_told_how_many_levels_may_follow),
    cmocka_unit_test(every_node_is_split_at_the_median_of_its_longest_axis),
    cmocka_unit_test(centroids_are_ordered_though_one_is_far_from_the_others),
    cmocka_unit_test(equal_extents_are_split_on_x_before_y_before_z),
    cmocka_unit_test(the_order_of_the_mesh_does_not_change_the_boxes),
    cmocka_unit_test(a_node_is_32_bytes_and_a_pair_of_children_one_cache_line),
    cmocka_unit_test(identical_triangles_build_a_tree_and_the_first_is_hit),
    cmocka_unit_test(building_a_large_tree_takes_no_more_stack),
    cmocka_unit_test(coordinates_near_the_largest_float_build_a_sound_tree),
    cmocka_unit_test(no_order_of_the_mesh_makes_building_slow),
    cmocka_unit_test(rays_find_the_same_hits_as_brute_force),
    cmocka_unit_test(rays_along_a_grid_find_the_same_hits_as_brute_force),
    cmocka_unit_test(the_deepest_tree_has_all_hits),
    cmocka_unit_test(rays_are_occluded_where_brute_force_hits),
    cmocka_unit_test(the_deepest_tree_occludes_as_brute_force),
    cmocka_unit_test(flat_long_and_huge_meshes_equal_brute_force),
    cmocka_unit_test(a_box_that_begins_at_the_nearest_hit_is_visited),
    cmocka_unit_test(boxes_that_begin_at_t_max_are_visited),
    cmocka_unit_test(hits_count_up_to_t_max_and_not_behind_the_origin),
    cmocka_unit_test(a_ray_of_nan_misses),
    cmocka_unit_test(a_ray_allocates_no_memory),
    cmocka_unit_test(a_ray_that_misses_the_root_tests_one_box),
    cmocka_unit_test(a_ray_without_a_hit_tests_only_boxes_before_t_max),
    cmocka_unit_test(an_occlusion_test_looks_no_farther_than_t_max),
    cmocka_unit_test(nodes_behind_the_nearest_hit_are_skipped_from_either_side),
    cmocka_unit_test(children_behind_the_nearest_hit_are_not_visited),
    cmocka_unit_test(occlusion_tests_stop_at_the_first_hit),
    cmocka_unit_test(counts_of_several_rays_add_up),
    cmocka_unit_test(large_counts_do_not_wrap_around),
    cmocka_unit_test(most_boxes_of_a_large_mesh_are_never_tested),
};

RK_SUITE("bvh_median", tests)
