/* Draws the figures and measures the table of bvh_median: a scene, the boxes of one level of its
 * tree, one leaf with its triangles, or the boxes that a ray tests. */
#include "driver.h"

static const char summary[] =
    "Builds a bounding volume hierarchy by median splits and renders a scene with it.\n"
    "--debug level draws the boxes of a level, --debug leaf the triangles of a leaf.\n"
    "--debug traversal draws the boxes that the ray of --pixel tests, one after the other.";

static const rk_option options[] = {
    RK_TREE_VIEW_OPTIONS(choices, tree),
    {"steps", RK_FIELD(choices, steps), "N",
     "how many steps of --debug traversal are drawn: boxes tested and leaves visited; by default "
     "all",
     1, UINT32_MAX - 1, RK_TREE_VIEW_NOT_GIVEN, .views = "traversal"},
    {0},
};

static void set_defaults(rk_driver *driver)
{
    driver->split = RK_ACCEL_MEDIAN;
}

static bool check_tree(rk_driver *driver, rk_error *error)
{
    choices *c = driver->choices;
    return rk_tree_view_choose(&c->tree, driver, error);
}

static bool choose(rk_driver *driver, rk_error *error)
{
    if (rk_driver_debug(driver, "traversal") && driver->split >= RK_ACCEL_COLLAPSED)
        return rk_fail(error, "--debug traversal goes with a binary tree: --split median or sah");
    return true;
}

static bool draw_view(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    return rk_tree_view_draw(&c->tree, driver, error);
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    return rk_driver_debug(driver, "traversal") ? save_traversal(driver, error)
                                                : rk_tree_view_save(&c->tree, driver, error);
}

int main(int argc, char **argv)
{
    choices c;
    const rk_driver_spec spec = {
        .feature = "bvh_median",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .is_of_binary_trees = true,
        .views = (rk_driver_view[]){{"level", draw_view, false},
                                    {"leaf", draw_view, false},
                                    {"traversal", draw_traversal, false},
                                    {0}},
        .choose = choose,
        .check_tree = check_tree,
        .put_rows = rk_tree_view_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
