/* The tree of all builders: measured, visited, and refused if invalid. */
#include "test.h"

#include "features/bvh_median.h"

/* --- A row of twelve triangles --------------------------------------------------------------- */

/* Triangle i lies within x in [i, i + 1]: split 6 | 6, then 3 | 3 twice, so 4 leaves of 3. Nodes: 0
 * is the root, 2 and 3 its children, 4 to 7 the leaves. */
static rk_mesh make_row(void)
{
    rk_mesh mesh;
    rk_error error;
    rk_check_ok(rk_mesh_init(&mesh, 36, 12, 1, 0, &error), error);
    for (uint32_t i = 0; i < 12; i++) {
        float x = (float)i;
        mesh.positions[3 * i] = rk_vec(x, 0, 0);
        mesh.positions[3 * i + 1] = rk_vec(x + 1, 0, 0);
        mesh.positions[3 * i + 2] = rk_vec(x, 1, 1);
        for (uint32_t k = 0; k < 3; k++)
            mesh.triangles[i][k] = 3 * i + k;
    }
    return mesh;
}

typedef struct fixture {
    rk_mesh mesh;
    rk_bvh bvh;
} fixture;

static int set_up(void **state)
{
    fixture *f = calloc(1, sizeof *f);
    rk_error error;
    f->mesh = make_row();
    rk_check_ok(rk_bvh_build_median(&f->bvh, &f->mesh, &error), error);
    rk_check_equal(f->bvh.node_count, 8, "root, the unused one, 2 children, 4 leaves");
    *state = f;
    return 0;
}

static int tear_down(void **state)
{
    fixture *f = *state;
    rk_bvh_free(&f->bvh);
    rk_mesh_free(&f->mesh);
    free(f);
    return 0;
}

/* --- Measuring ------------------------------------------------------------------------------- */

static void a_tree_without_nodes_measures_zero(void **state)
{
    (void)state;
    rk_bvh bvh = {0};
    rk_bvh_measures measures = rk_bvh_measure(&bvh);
    rk_check_equal(measures.levels, 0, "no node, no level");
    rk_check_equal(measures.leaves, 0, "no leaf");
    rk_check_close(measures.sah_cost, 0, 0, "a ray has nothing to do");
}

static void a_single_leaf_costs_its_triangles(void **state)
{
    (void)state;
    rk_bvh_node node = {{{rk_vec(0, 0, 0), rk_vec(2, 3, 4)}}, 0, 3};
    rk_bvh bvh = {.node_count = 1, .nodes = &node};
    rk_bvh_measures measures = rk_bvh_measure(&bvh);
    rk_check_equal(measures.levels, 1, "the root");
    rk_check_equal(measures.leaves, 1, "the root");
    rk_check_close(measures.sah_cost, 3, 0, "a ray that hits the box tests 3 triangles");
}

static void the_sah_cost_is_the_one_computed_by_hand(void **state)
{
    (void)state;
    /* Root 2 x 2 x 2 (area 24), left 1 x 2 x 2 (16) is a leaf of 2, right 1 x 2 x 1 (10) is inner
     * with leaves 1 x 1 x 1 (6) of 3 and 1 x 1 x .5 (4) of 1. */
    rk_bvh_node nodes[6] = {
        {{{rk_vec(0, 0, 0), rk_vec(2, 2, 2)}}, 2, 0},
        {{{rk_vec(9, 9, 9), rk_vec(99, 99, 99)}}, 0, 0},
        {{{rk_vec(0, 0, 0), rk_vec(1, 2, 2)}}, 0, 2},
        {{{rk_vec(1, 0, 0), rk_vec(2, 2, 1)}}, 4, 0},
        {{{rk_vec(1, 0, 0), rk_vec(2, 1, 1)}}, 2, 3},
        {{{rk_vec(1, 1, 0), rk_vec(2, 2, 0.5f)}}, 5, 1},
    };
    rk_bvh bvh = {.node_count = 6, .nodes = nodes};
    rk_bvh_measures measures = rk_bvh_measure(&bvh);
    double want = (1.5 * 24 + 2 * 16 + 1.5 * 10 + 3 * 6 + 1 * 4) / 24;
    rk_check_close(measures.sah_cost, want, 1e-15, "one rounding of double");
    rk_check_equal(measures.levels, 3, "root, its children, their children");
    rk_check_equal(measures.leaves, 3, "nodes with triangles");
}

static void a_root_without_area_costs_nothing_rather_than_nan(void **state)
{
    (void)state;
    rk_bvh_node node = {{{rk_vec(1, 1, 1), rk_vec(1, 1, 1)}}, 0, 3};
    rk_bvh bvh = {.node_count = 1, .nodes = &node};
    rk_check_close(rk_bvh_measure(&bvh).sah_cost, 0, 0, "no area, no ray");
}

static void areas_of_huge_boxes_do_not_overflow(void **state)
{
    (void)state;
    rk_bvh_node node = {{{rk_vec(-3e38f, -3e38f, -3e38f), rk_vec(3e38f, 3e38f, 3e38f)}}, 0, 2};
    rk_bvh bvh = {.node_count = 1, .nodes = &node};
    rk_check_close(rk_bvh_measure(&bvh).sah_cost, 2, 0, "the ratio of equal areas");
}

/* --- Visiting -------------------------------------------------------------------------------- */

typedef struct diary {
    const rk_bvh *bvh;
    uint32_t count;
    uint32_t node[200], level[200];
} diary;

static void write_down(const rk_bvh_node *node, uint32_t level, void *context)
{
    diary *d = context;
    rk_check(d->count < 200, "the visit does not end");
    d->node[d->count] = (uint32_t)(node - d->bvh->nodes);
    d->level[d->count++] = level;
}

static void visits_go_parents_first_and_left_before_right(void **state)
{
    fixture *f = *state;
    diary d = {.bvh = &f->bvh};
    rk_bvh_visit(&f->bvh, write_down, &d);
    const uint32_t level[] = {0, 1, 2, 2, 1, 2, 2};
    rk_check_equal(d.count, 7, "all nodes but the unused one");
    uint32_t left = f->bvh.nodes[2].first, right = f->bvh.nodes[3].first;
    const uint32_t want[] = {0, 2, left, left + 1, 3, right, right + 1};
    for (int i = 0; i < 7; i++) {
        rk_check_equal(d.node[i], want[i], "depth first, left before right");
        rk_check_equal(d.level[i], level[i], "the root is level 0");
    }
}

static void visits_of_invalid_trees_end(void **state)
{
    (void)state;
    /* Every node inner, children anywhere: cycles, out of range, the largest numbers. */
    const uint32_t first[] = {0, 1, 2, 4, 6, 7, 8, 1000, UINT32_MAX - 1, UINT32_MAX};
    for (size_t i = 0; i < sizeof first / sizeof *first; i++) {
        rk_bvh_node nodes[8];
        for (int k = 0; k < 8; k++)
            nodes[k] = (rk_bvh_node){{{rk_vec(0, 0, 0), rk_vec(1, 1, 1)}}, first[i], 0};
        rk_bvh bvh = {.node_count = 8, .nodes = nodes};
        diary d = {.bvh = &bvh};
        rk_bvh_visit(&bvh, write_down, &d);
        rk_check(d.count >= 1 && d.count <= 8, "%u visits of 8 nodes", d.count);
        rk_bvh_measure(&bvh);
    }
}

/* --- Validating ------------------------------------------------------------------------------ */

static void check_fault(const fixture *f, const char *part, const char *place)
{
    rk_error error = {""};
    rk_check(!rk_bvh_validate(&f->bvh, &f->mesh, &error), "the fault was not found: %s", part);
    rk_check_error_names(error, part);
    rk_check_error_names(error, place);
}

static rk_bvh_node *first_leaf(fixture *f)
{
    rk_bvh_node *node = f->bvh.nodes;
    while (node->count == 0)
        node = &f->bvh.nodes[node->first];
    return node;
}

static void a_valid_tree_is_accepted(void **state)
{
    fixture *f = *state;
    rk_error error;
    rk_check_ok(rk_bvh_validate(&f->bvh, &f->mesh, &error), error);
}

static void a_triangle_in_two_leaves_is_found(void **state)
{
    fixture *f = *state;
    f->bvh.triangles[4] = f->bvh.triangles[3];
    char place[24];
    snprintf(place, sizeof place, "triangle %u)", f->bvh.triangles[3].index);
    check_fault(f, "twice", place);
}

static void a_missing_triangle_is_found(void **state)
{
    fixture *f = *state;
    rk_bvh_node *leaf = first_leaf(f);
    uint32_t lost = f->bvh.triangles[leaf->first + leaf->count - 1].index;
    leaf->count--;
    char place[24];
    snprintf(place, sizeof place, "triangle %u)", lost);
    check_fault(f, "no leaf", place);
}

static void a_tree_without_nodes_over_triangles_is_found(void **state)
{
    fixture *f = *state;
    f->bvh.node_count = 0;
    check_fault(f, "no leaf", "triangle 0)");
}

static void nodes_that_are_only_counted_are_found(void **state)
{
    fixture *f = *state;
    rk_bvh_node *nodes = f->bvh.nodes;
    f->bvh.node_count = 0xfffffff0u;
    check_fault(f, "more nodes than triangles need", "(nodes 4294967280)");
    f->bvh.nodes = NULL;
    check_fault(f, "there are none", "(nodes 4294967280)");
    f->bvh.nodes = nodes;
}

static void a_leaf_box_that_is_too_small_is_found(void **state)
{
    fixture *f = *state;
    for (int side = 0; side < 2; side++)
        for (int axis = 0; axis < 3; axis++) {
            rk_bvh_node *leaf = first_leaf(f);
            rk_box valid = leaf->box;
            float *bound = &leaf->box.corner[side].x + axis;
            *bound = nextafterf(*bound, side ? -INFINITY : INFINITY);
            check_fault(f, "triangle sticks out", "(triangle ");
            leaf->box = valid;
        }
}

static void a_box_with_nan_is_found(void **state)
{
    fixture *f = *state;
    f->bvh.nodes[0].box.corner[1].y = NAN;
    check_fault(f, "child's box sticks out", "(node 2)");
}

static void a_child_that_sticks_out_of_its_parent_is_found(void **state)
{
    fixture *f = *state;
    f->bvh.nodes[3].box.corner[1].x = nextafterf(12, 13);
    check_fault(f, "child's box sticks out", "(node 3)");
}

static void children_out_of_range_are_found(void **state)
{
    fixture *f = *state;
    const uint32_t first[] = {8, 7, 1000, UINT32_MAX, UINT32_MAX - 1, 0, 1, 5};
    for (size_t i = 0; i < sizeof first / sizeof *first; i++) {
        char place[24];
        snprintf(place, sizeof place, "(first %u)", first[i]);
        f->bvh.nodes[3].first = first[i];
        check_fault(f, "are beyond node_count", place);
    }
}

static void a_cycle_is_found(void **state)
{
    fixture *f = *state;
    f->bvh.nodes[3].first = 2;
    f->bvh.nodes[3].box = f->bvh.nodes[2].box = f->bvh.nodes[0].box;
    check_fault(f, "cycle", "(node 2)");
}

static void two_parents_of_a_node_are_found(void **state)
{
    fixture *f = *state;
    uint32_t common_child = f->bvh.nodes[2].first;
    f->bvh.nodes[3].first = common_child;
    f->bvh.nodes[3].box = f->bvh.nodes[0].box;
    char place[24];
    snprintf(place, sizeof place, "(node %u)", common_child);
    check_fault(f, "two parents", place);
}

static void leaves_past_the_triangles_are_found(void **state)
{
    fixture *f = *state;
    const uint32_t first[] = {10, 12, 13, UINT32_MAX};
    for (size_t i = 0; i < sizeof first / sizeof *first; i++) {
        first_leaf(f)->first = first[i];
        check_fault(f, "past the triangles", "(first ");
    }
}

static void an_over_full_leaf_is_found(void **state)
{
    (void)state;
    fixture f = {.mesh = make_row()};
    rk_error error;
    f.mesh.triangle_count = 5;
    rk_check_ok(rk_bvh_init(&f.bvh, 5, 1, &error), error);
    f.bvh.node_count = 1;
    f.bvh.nodes[0] = (rk_bvh_node){rk_mesh_bounds(&f.mesh), 0, RK_BVH_LEAF_MAX + 1};
    for (uint32_t i = 0; i < 5; i++) {
        const rk_vec3 *p = &f.mesh.positions[3 * i];
        f.bvh.triangles[i] = (rk_triangle){p[0], p[1], p[2], i};
    }
    check_fault(&f, "too many", "(it has 65)");
    rk_bvh_free(&f.bvh);
    rk_mesh_free(&f.mesh);
}

static void a_triangle_that_the_mesh_lacks_is_found(void **state)
{
    fixture *f = *state;
    f->bvh.triangles[1].index = 12;
    check_fault(f, "does not have", "(triangle 12)");
}

static void a_false_copy_of_a_triangle_is_found(void **state)
{
    fixture *f = *state;
    for (int i = 0; i < 9; i++) {
        rk_triangle valid = f->bvh.triangles[7];
        float *number = &f->bvh.triangles[7].a.x + i;
        *number = nextafterf(*number, INFINITY);
        check_fault(f, "copy of a triangle", "(triangle ");
        f->bvh.triangles[7] = valid;
    }
}

/* A chain with `inner` inner nodes: each left child is a leaf, each right child the rest. */
static fixture make_chain(uint32_t inner)
{
    fixture f = {0};
    rk_error error;
    rk_check_ok(rk_mesh_init(&f.mesh, 3, inner + 1, 1, 0, &error), error);
    f.mesh.positions[1] = rk_vec(1, 0, 0);
    f.mesh.positions[2] = rk_vec(0, 1, 0);
    rk_check_ok(rk_bvh_init(&f.bvh, inner + 1, inner + 1, &error), error);
    f.bvh.node_count = 2 * inner + 2;
    rk_box box = {{rk_vec(0, 0, 0), rk_vec(1, 1, 0)}};
    for (uint32_t i = 0; i <= inner; i++) {
        memcpy(f.mesh.triangles[i], (uint32_t[3]){0, 1, 2}, sizeof(uint32_t[3]));
        f.bvh.triangles[i] = (rk_triangle){rk_vec(0, 0, 0), rk_vec(1, 0, 0), rk_vec(0, 1, 0), i};
        uint32_t right = i ? 2 * i + 1 : 0; /* node 2 i is the leaf, 2 i + 1 goes on */
        f.bvh.nodes[right] = (rk_bvh_node){box, 2 * i + 2, 0};
        if (i)
            f.bvh.nodes[2 * i] = (rk_bvh_node){box, i - 1, 1};
    }
    f.bvh.nodes[2 * inner + 1] = (rk_bvh_node){box, inner, 1};
    return f;
}

static void the_deepest_allowed_path_is_accepted(void **state)
{
    (void)state;
    fixture f = make_chain(RK_BVH_LEVELS_MAX - 1);
    rk_error error;
    rk_check_ok(rk_bvh_validate(&f.bvh, &f.mesh, &error), error);
    rk_check_equal(rk_bvh_measure(&f.bvh).levels, RK_BVH_LEVELS_MAX, "one more than inner nodes");
    rk_bvh_free(&f.bvh);
    rk_mesh_free(&f.mesh);
}

static void a_path_that_is_too_deep_is_found(void **state)
{
    (void)state;
    fixture f = make_chain(RK_BVH_LEVELS_MAX);
    check_fault(&f, "deeper", "(level 64)");
    rk_bvh_free(&f.bvh);
    rk_mesh_free(&f.mesh);
}

#define on_the_row(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_tree_without_nodes_measures_zero),
    cmocka_unit_test(a_single_leaf_costs_its_triangles),
    cmocka_unit_test(the_sah_cost_is_the_one_computed_by_hand),
    cmocka_unit_test(a_root_without_area_costs_nothing_rather_than_nan),
    cmocka_unit_test(areas_of_huge_boxes_do_not_overflow),
    on_the_row(visits_go_parents_first_and_left_before_right),
    cmocka_unit_test(visits_of_invalid_trees_end),
    on_the_row(a_valid_tree_is_accepted),
    on_the_row(a_triangle_in_two_leaves_is_found),
    on_the_row(a_missing_triangle_is_found),
    on_the_row(a_tree_without_nodes_over_triangles_is_found),
    on_the_row(nodes_that_are_only_counted_are_found),
    on_the_row(a_leaf_box_that_is_too_small_is_found),
    on_the_row(a_box_with_nan_is_found),
    on_the_row(a_child_that_sticks_out_of_its_parent_is_found),
    on_the_row(children_out_of_range_are_found),
    on_the_row(a_cycle_is_found),
    on_the_row(two_parents_of_a_node_are_found),
    on_the_row(leaves_past_the_triangles_are_found),
    cmocka_unit_test(an_over_full_leaf_is_found),
    on_the_row(a_triangle_that_the_mesh_lacks_is_found),
    on_the_row(a_false_copy_of_a_triangle_is_found),
    cmocka_unit_test(the_deepest_allowed_path_is_accepted),
    cmocka_unit_test(a_path_that_is_too_deep_is_found),
};

RK_SUITE("bvh", tests)
