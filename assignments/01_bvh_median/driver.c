/* Draws the figures and measures the table of bvh_median: a scene, the boxes of one level of its
 * tree, or one leaf with its triangles. */
#include "render/driver.h"

#include <stdio.h>

static const char summary[] =
    "Builds a bounding volume hierarchy by median splits and renders a scene with it.\n"
    "--debug level draws the boxes of one level, --debug leaf one leaf and its triangles.";

/* What a visit of the tree draws: the boxes of one level, or one leaf. */
typedef struct drawing {
    rk_overlay overlay;
    const rk_driver *driver;
    uint32_t level, leaf;   /* wanted */
    uint32_t boxes, leaves; /* met so far */
} drawing;

static void draw_level(const rk_bvh_node *node, uint32_t level, void *context)
{
    drawing *d = context;
    if (level == d->level)
        rk_overlay_wireframe(&d->overlay, &node->box, rk_overlay_colour(d->boxes++), 1.5f);
}

static void draw_leaf(const rk_bvh_node *node, uint32_t level, void *context)
{
    drawing *d = context;
    (void)level;
    if (node->count == 0 || d->leaves++ != d->leaf)
        return;
    const rk_mesh *mesh = &d->driver->scene.mesh;
    for (uint32_t i = 0; i < node->count; i++) {
        const uint32_t *corner =
            mesh->triangles[d->driver->accel.bvh.triangles[node->first + i].index];
        rk_overlay_triangle(&d->overlay, mesh->positions[corner[0]], mesh->positions[corner[1]],
                            mesh->positions[corner[2]], rk_overlay_colour(i), 1);
    }
    rk_overlay_wireframe(&d->overlay, &node->box, rk_vec(1, 1, 1), 1.5f);
}

/* A leaf is small: the rest of the picture steps back. */
static void dim(const rk_image *image)
{
    for (size_t i = 0; i < image->width * image->height; i++)
        image->pixels[i] = rk_scale(image->pixels[i], 0.2f);
}

static const uint32_t not_given = UINT32_MAX;

/* Settles which level and leaf to draw; an error names what the tree has. */
static bool choose_view(const rk_driver *driver, uint32_t *level, uint32_t *leaf, rk_error *error)
{
    rk_bvh_measures tree = rk_bvh_measure(&driver->accel.bvh);
    if ((*level != not_given && !rk_driver_debug(driver, "level")) ||
        (*leaf != not_given && !rk_driver_debug(driver, "leaf")))
        return rk_fail(error, "--level goes with --debug level, --leaf with --debug leaf");
    if (*level == not_given)
        *level = tree.levels > 4 ? 4 : tree.levels - 1;
    if (*leaf == not_given)
        *leaf = 0;
    if (*level >= tree.levels)
        return rk_fail(error, "--level %u: this tree's levels are 0 to %u; choose one of them",
                       *level, tree.levels - 1);
    if (*leaf >= tree.leaves)
        return rk_fail(error, "--leaf %u: this tree's leaves are 0 to %u; choose one of them",
                       *leaf, tree.leaves - 1);
    return true;
}

static bool draw(rk_driver *driver, uint32_t level, uint32_t leaf, rk_error *error)
{
    bool is_level = rk_driver_debug(driver, "level");
    drawing d = {.driver = driver, .level = level, .leaf = leaf};
    if (!rk_overlay_init(&d.overlay, &driver->image, &driver->scene, &driver->accel, driver->pool,
                         error))
        return false;
    if (!is_level)
        dim(&driver->image);
    rk_bvh_visit(&driver->accel.bvh, is_level ? draw_level : draw_leaf, &d);
    rk_overlay_free(&d.overlay);
    char label[32];
    snprintf(label, sizeof label, "%s%u", driver->debug, is_level ? level : leaf);
    return rk_driver_save(driver, label, error);
}

/* One row a figure: build, render, the tree's shape, the work of a camera ray. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    if (driver->render.shadows)
        return rk_driver_row(driver, "render_with_shadows", "ms", driver->render_ms, error);
    rk_bvh_measures tree = rk_bvh_measure(&driver->accel.bvh);
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

int main(int argc, char **argv)
{
    uint32_t level = not_given, leaf = not_given;
    const rk_option options[] = {
        {"level", RK_OPTION_UINT, &level, "N",
         "level drawn by --debug level; 0 is the root (default: 4, or the deepest)", 0,
         RK_BVH_LEVELS_MAX - 1},
        {"leaf", RK_OPTION_UINT, &leaf, "N",
         "leaf drawn by --debug leaf, from the left (default: 0)", 0, UINT32_MAX - 1},
        {0},
    };
    const char *const views[] = {"level", "leaf", NULL};
    rk_driver driver = rk_driver_default("bvh_median", summary);
    driver.split = "median";
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool ok = rk_driver_build(&driver, &error) && choose_view(&driver, &level, &leaf, &error) &&
              rk_driver_render(&driver, &error);
    if (ok && driver.timing)
        ok = put_rows(&driver, &error);
    else if (ok && driver.debug)
        ok = draw(&driver, level, leaf, &error);
    else if (ok)
        ok = rk_driver_save(&driver, NULL, &error);
    return rk_driver_finish(&driver, ok, &error);
}
