/* The debug views: pieces of the wide tree, and the nodes that each camera ray visits. */
#include "driver.h"

#include "accel/query/trace.h"

#include <stdio.h>

const rk_wide_bvh *wide_tree(const rk_driver *driver)
{
    return rk_driver_has_stand_in(driver) ? &driver->unfinished.wide : &driver->accel.wide;
}

/* A leaf whose blocks are still to be written has a box. */
bool is_vacant(const rk_wide_node *node, uint32_t place)
{
    return !(node->side[0][0][place] <= node->side[1][0][place]);
}

/* --- Levels ----------------------------------------------------------------------------------- */

typedef void box_visitor(rk_box box, uint32_t level, void *context);

/* Nodes and leaves, parents first. No path is longer than a stack can hold. */
static void visit_boxes(const rk_wide_bvh *wide, uint32_t node, uint32_t level,
                        box_visitor *visitor, void *context)
{
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++) {
        if (is_vacant(&wide->nodes[node], i))
            continue;
        uint32_t child = wide->nodes[node].child[i];
        visitor(rk_wide_box(&wide->nodes[node], i), level + 1, context);
        if (!(child & RK_WIDE_LEAF))
            visit_boxes(wide, child, level + 1, visitor, context);
    }
}

static void find_deepest(rk_box box, uint32_t level, void *context)
{
    uint32_t *deepest = context;
    (void)box;
    *deepest = level > *deepest ? level : *deepest;
}

static uint32_t deepest_level(const rk_wide_bvh *wide)
{
    uint32_t deepest = 0;
    visit_boxes(wide, 0, 0, find_deepest, &deepest);
    return deepest;
}

/* --- Options ---------------------------------------------------------------------------------- */

static bool check_range(const rk_wide_bvh *wide, const choices *c, bool is_level, rk_error *error)
{
    if (is_level && c->level > deepest_level(wide))
        return rk_fail(error, "--level %u: this tree's levels are 0 to %u; choose one of them",
                       c->level, deepest_level(wide));
    if (!is_level && c->node >= wide->node_count)
        return rk_fail(error, "--node %u: this tree's nodes are 0 to %u; choose one of them",
                       c->node, wide->node_count - 1);
    return true;
}

bool check_view(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const bool is_view = driver->debug && !rk_driver_debug(driver, "visits");
    const char *asked = c->occupancy ? "--occupancy" : "--debug";
    if (!is_view && !c->occupancy)
        return true;
    if (driver->split < RK_ACCEL_COLLAPSED)
        return rk_fail(error, "%s goes with --split collapsed or wide", asked);
    if (wide_tree(driver)->node_count == 0)
        return rk_fail(error,
                       "%s: the tree of triangles at rest is empty; choose another scene, or leave "
                       "--move out",
                       asked);
    return c->occupancy || rk_driver_debug(driver, "blocks") ||
           check_range(wide_tree(driver), c, rk_driver_debug(driver, "level"), error);
}

/* --- Boxes and blocks ------------------------------------------------------------------------- */

/* The children of a node as coloured glass; the cycle of colours has seven. */
static void draw_children(rk_overlay *overlay, const rk_wide_node *node)
{
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++) {
        const rk_box box = rk_wide_box(node, i);
        if (is_vacant(node, i))
            continue;
        const rk_vec3 colour = i < 7 ? rk_overlay_colour(i) : rk_vec(0.5f, 0.5f, 0.5f);
        rk_overlay_box(overlay, &box, colour, 0.25f);
        rk_overlay_wireframe(overlay, &box, colour, 2);
    }
}

typedef struct level_drawing {
    rk_overlay *overlay;
    uint32_t level, boxes;
} level_drawing;

static void draw_level(rk_box box, uint32_t level, void *context)
{
    level_drawing *d = context;
    if (level == d->level)
        rk_overlay_wireframe(d->overlay, &box, rk_overlay_colour(d->boxes++), 1.5f);
}

/* Every block has one colour, on all of its triangles. */
static void draw_blocks(rk_overlay *overlay, const rk_wide_bvh *wide, const rk_mesh *mesh)
{
    for (uint32_t b = 0; b < wide->block_count; b++)
        for (uint32_t i = 0; i < RK_WIDE_BLOCK; i++) {
            const uint32_t index = wide->blocks[b].index[i];
            const bool repeats = i > 0 && index == wide->blocks[b].index[i - 1];
            if (repeats || index >= mesh->triangle_count)
                continue;
            const uint32_t *corner = mesh->triangles[index];
            rk_overlay_triangle(overlay, mesh->positions[corner[0]], mesh->positions[corner[1]],
                                mesh->positions[corner[2]], rk_overlay_colour(b), 0.7f);
        }
}

bool draw_tree(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const rk_wide_bvh *wide = wide_tree(driver);
    rk_overlay overlay;
    if (!rk_driver_render_overlay(driver, &overlay, error))
        return false;
    level_drawing level = {&overlay, c->level, 0};
    if (rk_driver_debug(driver, "blocks")) {
        draw_blocks(&overlay, wide, &driver->scene.mesh);
    } else if (rk_driver_debug(driver, "node")) {
        draw_children(&overlay, &wide->nodes[c->node]);
    } else {
        draw_level(wide->box, 0, &level);
        visit_boxes(wide, 0, 0, draw_level, &level);
    }
    rk_overlay_free(&overlay);
    return true;
}

/* --- Visits ----------------------------------------------------------------------------------- */

/* Dark blue for none, then orange, then yellow. */
static rk_vec3 colour_of_visits(float fraction)
{
    const rk_vec3 none = rk_vec(0.01f, 0.03f, 0.12f), half = rk_vec(0.75f, 0.2f, 0.01f);
    const rk_vec3 most = rk_vec(1, 0.95f, 0.45f);
    return fraction < 0.5f ? rk_mix(none, half, 2 * fraction)
                           : rk_mix(half, most, 2 * rk_min(fraction, 1) - 1);
}

/* Nodes, by the boxes that a visit tests. The ray is alone, so that the visits are its own. */
static uint32_t visits_of(const rk_driver *driver, rk_ray ray)
{
    rk_ray_batch batch = {.count = 0};
    rk_hit_batch hits;
    rk_counters counters = {0};
    rk_batch_push(&batch, &ray);
    rk_accel_closest(&driver->accel, &batch, &hits, &counters);
    return (uint32_t)counters.box_tests / (driver->accel.wide.node_count ? RK_WIDE_CHILDREN : 2);
}

bool draw_visits(rk_driver *driver, rk_error *error)
{
    choices *c = driver->choices;
    const uint32_t width = driver->render.width, height = driver->render.height;
    const rk_view view = rk_view_of(&driver->scene.camera, width, height);
    double sum = 0;
    (void)error;
    c->most_visits = 0;
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            const uint32_t visits =
                visits_of(driver, rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f));
            *rk_image_at(&driver->image, x, y) = colour_of_visits((float)visits / (float)c->most);
            sum += visits;
            c->most_visits = visits > c->most_visits ? visits : c->most_visits;
        }
    driver->scale =
        rk_driver_scale_of("nodes visited per camera ray", 0, c->most, colour_of_visits);
    driver->scale.clipped = c->most_visits > c->most;
    c->mean_visits = sum / ((double)width * height);
    return true;
}

/* --- Saving ----------------------------------------------------------------------------------- */

/* What each child is. */
static void print_children(const rk_wide_bvh *wide, const rk_wide_node *node)
{
    for (uint32_t i = 0; i < RK_WIDE_CHILDREN; i++) {
        const uint32_t child = node->child[i];
        const double share = rk_box_area(rk_wide_box(node, i)) / rk_box_area(wide->box);
        if (is_vacant(node, i))
            printf("child %u: none\n", i);
        else if (child & RK_WIDE_LEAF)
            printf("child %u: a leaf, blocks from %u on: %u, %.3g %% of the root's area\n", i,
                   rk_wide_leaf_first(child), rk_wide_leaf_count(child), 100 * share);
        else
            printf("child %u: node %u, %.3g %% of the root's area\n", i, child, 100 * share);
    }
}

/* The label says which tree, as it was asked for. */
bool save_view(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    const bool is_node = rk_driver_debug(driver, "node");
    const rk_accel asked = {.kind = driver->split, .bins = driver->bins};
    const rk_accel_title tree = rk_accel_name(&asked);
    char label[64];
    if (is_node || rk_driver_debug(driver, "level"))
        snprintf(label, sizeof label, "%s%u_%s", driver->debug, is_node ? c->node : c->level,
                 tree.text);
    else if (driver->debug)
        snprintf(label, sizeof label, "%s_%s", driver->debug, tree.text);
    else
        snprintf(label, sizeof label, "%s", tree.text);
    if (!rk_driver_save(driver, label, error))
        return false;
    if (is_node && !driver->quiet)
        print_children(wide_tree(driver), &wide_tree(driver)->nodes[c->node]);
    if (rk_driver_debug(driver, "visits") && !driver->quiet)
        printf("visits to nodes per camera ray: %.1f on average, %u at most\n", c->mean_visits,
               c->most_visits);
    return true;
}
