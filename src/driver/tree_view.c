/* A visit of the tree counts boxes of the wanted level, or leaves, and draws those that are asked
 * for. */
#include "driver/tree_view.h"

#include <stdio.h>

/* Drawn while visiting the tree: the boxes of one level with their triangles, or one leaf. */
typedef struct drawing {
    rk_overlay overlay;
    const rk_driver *driver;
    rk_tree_view wanted;
    uint32_t boxes, leaves; /* visited so far */
} drawing;

/* Triangle i in the tree's order. */
static void paint(drawing *d, uint32_t i, rk_vec3 colour, float alpha)
{
    const rk_mesh *mesh = &d->driver->scene.mesh;
    const uint32_t *corner = mesh->triangles[rk_driver_tree(d->driver)->triangles[i].index];
    rk_overlay_triangle(&d->overlay, mesh->positions[corner[0]], mesh->positions[corner[1]],
                        mesh->positions[corner[2]], colour, alpha);
}

/* Nodes are visited from the root down, so a leaf is below the box of the level that came last. */
static void paint_level(const rk_bvh_node *node, uint32_t level, void *context)
{
    drawing *d = context;
    d->boxes += level == d->wanted.level;
    for (uint32_t i = 0; level >= d->wanted.level && i < node->count; i++)
        paint(d, node->first + i, rk_overlay_colour(d->boxes - 1), 0.6f);
}

static void draw_level(const rk_bvh_node *node, uint32_t level, void *context)
{
    drawing *d = context;
    if (level == d->wanted.level)
        rk_overlay_wireframe(&d->overlay, &node->box, rk_overlay_colour(d->boxes++), 2);
}

static void draw_leaf(const rk_bvh_node *node, uint32_t level, void *context)
{
    drawing *d = context;
    (void)level;
    if (node->count == 0 || d->leaves++ != d->wanted.leaf)
        return;
    for (uint32_t i = 0; i < node->count; i++)
        paint(d, node->first + i, rk_overlay_colour(i), 1);
    rk_overlay_wireframe(&d->overlay, &node->box, rk_vec(1, 1, 1), 1.5f);
}

void rk_tree_view_dim(const rk_image *image)
{
    for (size_t i = 0; i < image->width * image->height; i++)
        image->pixels[i] = rk_scale(image->pixels[i], 0.2f);
}

bool rk_tree_view_choose(rk_tree_view *view, const rk_driver *driver, rk_error *error)
{
    rk_bvh_measures tree = rk_bvh_measure(rk_driver_tree(driver));
    if (tree.levels == 0) /* moving objects have trees of their own */
        return !driver->debug ||
               rk_fail(error,
                       "--debug %s: everything moves, and the tree of static triangles is "
                       "empty; leave --move out",
                       driver->debug);
    if (view->level == RK_TREE_VIEW_NOT_GIVEN)
        view->level = tree.levels > 4 ? 4 : tree.levels - 1;
    if (view->leaf == RK_TREE_VIEW_NOT_GIVEN)
        view->leaf = 0;
    if (view->level > 0 && tree.levels == 1)
        return rk_fail(error,
                       "--level %u: this tree is one leaf, as a starter's is; only level 0 "
                       "can be drawn",
                       view->level);
    if (view->level >= tree.levels)
        return rk_fail(error, "--level %u: this tree's levels are 0 to %u; choose one of them",
                       view->level, tree.levels - 1);
    if (view->leaf >= tree.leaves)
        return rk_fail(error, "--leaf %u: this tree's leaves are 0 to %u; choose one of them",
                       view->leaf, tree.leaves - 1);
    return true;
}

bool rk_tree_view_draw(const rk_tree_view *view, rk_driver *driver, rk_error *error)
{
    bool is_level = rk_driver_debug(driver, "level");
    drawing d = {.driver = driver, .wanted = *view};
    if (!rk_driver_render_overlay(driver, &d.overlay, error))
        return false;
    if (!is_level)
        rk_tree_view_dim(&driver->image);
    rk_bvh_visit(rk_driver_tree(driver), is_level ? paint_level : draw_leaf, &d);
    d.boxes = 0;
    if (is_level)
        rk_bvh_visit(rk_driver_tree(driver), draw_level, &d);
    rk_overlay_free(&d.overlay);
    return true;
}

bool rk_tree_view_save(const rk_tree_view *view, rk_driver *driver, rk_error *error)
{
    char label[32];
    bool is_level = rk_driver_debug(driver, "level");
    if (!driver->debug)
        return rk_driver_save(driver, NULL, error);
    snprintf(label, sizeof label, "%s%u", driver->debug, is_level ? view->level : view->leaf);
    return rk_driver_save(driver, label, error);
}

bool rk_tree_view_rows(rk_driver *driver, rk_error *error)
{
    if (driver->render.shadows)
        return rk_driver_row(driver, "render_with_shadows", "ms", driver->render_ms, error);
    rk_bvh_measures tree = rk_bvh_measure(rk_driver_tree(driver));
    double rays = (double)driver->counters.primary_rays;
    rk_timing boxes = rk_timing_once((double)driver->counters.box_tests / rays);
    rk_timing triangles = rk_timing_once((double)driver->counters.triangle_tests / rays);
    return rk_driver_row(driver, "build", "ms", driver->build_ms, error) &&
           rk_driver_row(driver, "render", "ms", driver->render_ms, error) &&
           rk_driver_row(driver, "levels", "1", rk_timing_once(tree.levels), error) &&
           rk_driver_row(driver, "leaves", "1", rk_timing_once(tree.leaves), error) &&
           rk_driver_row(driver, "SAH_cost", "1", rk_timing_once(tree.sah_cost), error) &&
           rk_driver_row(driver, "boxes_per_ray", "1", boxes, error) &&
           rk_driver_row(driver, "triangles_per_ray", "1", triangles, error);
}
