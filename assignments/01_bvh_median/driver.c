/* Draws the figures and measures the table of bvh_median: a scene, the boxes of one level of its
 * tree, or one leaf with its triangles. */
#include "driver/tree_view.h"

static const char summary[] =
    "Builds a bounding volume hierarchy by median splits and renders a scene with it.\n"
    "--debug level draws the boxes of a level, --debug leaf the triangles of a leaf.";

int main(int argc, char **argv)
{
    rk_tree_view view = {RK_TREE_VIEW_NOT_GIVEN, RK_TREE_VIEW_NOT_GIVEN};
    const rk_option options[] = {RK_TREE_VIEW_OPTIONS(view), {0}};
    const char *const views[] = {"level", "leaf", NULL};
    rk_driver driver = rk_driver_default("bvh_median", summary);
    driver.split = RK_ACCEL_MEDIAN;
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool ok = rk_driver_build(&driver, &error) && rk_tree_view_choose(&view, &driver, &error) &&
              rk_driver_render(&driver, &error);
    if (ok && driver.timing)
        ok = rk_tree_view_rows(&driver, &error);
    else if (ok && driver.debug)
        ok = rk_tree_view_draw(&view, &driver, &error);
    else if (ok)
        ok = rk_driver_save(&driver, NULL, &error);
    return rk_driver_finish(&driver, ok, &error);
}
