/* Draws the figures and measures the table of sah_binning: a scene, a level or a leaf of its tree,
 * and for one node the cut that was chosen, a rejected one, or all of them with their costs. */
#include "driver.h"
#include "features/sah_binning.h"

static const char summary[] =
    "Builds a bounding volume hierarchy by the surface area heuristic and renders with it.\n"
    "--debug level draws the boxes of a level, --debug leaf the triangles of a leaf.\n"
    "--debug split draws the cheapest cut of a node, --debug bad-split another one.\n"
    "--debug candidates draws all cuts of a node: blue where they are cheap, orange where they "
    "are dear, and the cheapest white.";

static bool check_options(const choices *c, const rk_driver *driver, rk_error *error)
{
    if (wants_cuts(driver) && driver->split == RK_ACCEL_MEDIAN)
        return rk_fail(error, "--debug %s goes with --split sah or sah3", driver->debug);
    if (c->candidate != RK_TREE_VIEW_NOT_GIVEN && !rk_driver_debug(driver, "bad-split"))
        return rk_fail(error, "--candidate goes with --debug bad-split");
    return true;
}

int main(int argc, char **argv)
{
    choices c = {.tree = {RK_TREE_VIEW_NOT_GIVEN, RK_TREE_VIEW_NOT_GIVEN},
                 .candidate = RK_TREE_VIEW_NOT_GIVEN};
    const rk_option options[] = {
        RK_TREE_VIEW_OPTIONS(c.tree),
        {"node", RK_OPTION_UINT, &c.node, "N",
         "whose cuts are drawn: 0 is the root, parents come before children, left before right", 0,
         UINT32_MAX - 1},
        {"candidate", RK_OPTION_UINT, &c.candidate, "K",
         "cut drawn by --debug bad-split, as --debug candidates numbers them; by default "
         "the dearest",
         0, RK_SAH_CANDIDATES_MAX - 1},
        {0},
    };
    const char *const views[] = {"level", "leaf", "split", "bad-split", "candidates", NULL};
    rk_driver driver = rk_driver_default("sah_binning", summary);
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool ok = check_options(&c, &driver, &error) && rk_driver_build(&driver, &error) &&
              rk_tree_view_choose(&c.tree, &driver, &error);
    if (ok && driver.debug)
        ok = draw_view(&driver, &c, &error);
    else if (ok)
        ok = rk_driver_render(&driver, &error) &&
             (driver.timing ? rk_tree_view_rows(&driver, &error)
                            : rk_driver_save(&driver, NULL, &error));
    return rk_driver_finish(&driver, ok, &error);
}
