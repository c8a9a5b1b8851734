/* Draws the figures and measures the table of sah_binning: a scene, a level or a leaf of its tree,
 * and for one node the chosen split, a rejected one, or all candidates with their costs. */
#include "driver.h"

static const char summary[] =
    "Builds a bounding volume hierarchy by the surface area heuristic and renders with it.\n"
    "--debug level draws the boxes of a level, --debug leaf the triangles of a leaf.\n"
    "--debug split draws the cheapest split of a node, --debug bad-split another one.\n"
    "--debug candidates draws all possible splits of a node, from blue, cheap, to orange, "
    "expensive; the cheapest is white.\n"
    "--splits puts the numbers of all splits of a node, and its triangles, into the tables "
    "sah_binning_splits and sah_binning_triangles.";

static const rk_option options[] = {
    RK_TREE_VIEW_OPTIONS(choices, tree),
    {"node", RK_FIELD(choices, node), "N",
     "node whose splits are drawn: 0 is the root, parents come before children, left before right",
     0, UINT32_MAX - 1, 0},
    {"candidate", RK_FIELD(choices, candidate), "K",
     "split drawn by --debug bad-split, as --debug candidates numbers them; by default the most "
     "expensive",
     0, RK_SAH_CANDIDATES_MAX - 1, RK_TREE_VIEW_NOT_GIVEN, .views = "bad-split"},
    {"splits", RK_FIELD(choices, splits), NULL,
     "put the splits and the triangles of --node into tables instead of drawing a picture"},
    {0},
};

static bool choose(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    if (wants_splits(driver) && driver->split == RK_ACCEL_MEDIAN)
        return rk_fail(error, "--debug %s goes with --split sah or sah3", driver->debug);
    if (c->splits && driver->split == RK_ACCEL_MEDIAN)
        return rk_fail(error, "--splits goes with --split sah or sah3");
    return true;
}

static bool check_tree(rk_driver *driver, rk_error *error)
{
    choices *c = driver->choices;
    return rk_tree_view_choose(&c->tree, driver, error);
}

static bool draw_tree(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    return rk_tree_view_draw(&c->tree, driver, error);
}

static void set_defaults(rk_driver *driver)
{
    driver->split = RK_ACCEL_SAH;
}

static bool save(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    return wants_splits(driver) ? save_splits(driver, error)
                                : rk_tree_view_save(&c->tree, driver, error);
}

int main(int argc, char **argv)
{
    static const rk_driver_view views[] = {
        {"level", draw_tree, false},        {"leaf", draw_tree, false},
        {"split", draw_splits, false},      {"bad-split", draw_splits, false},
        {"candidates", draw_splits, false}, {0},
    };
    choices c;
    const rk_driver_spec spec = {
        .feature = "sah_binning",
        .summary = summary,
        .options = options,
        .choices = &c,
        .views = views,
        .studies = (rk_driver_study[]){{&c.splits, put_study, false}, {0}},
        .set_defaults = set_defaults,
        .is_of_binary_trees = true,
        .choose = choose,
        .check_tree = check_tree,
        .put_rows = rk_tree_view_rows,
        .save = save,
    };
    return rk_driver_main(&spec, argc, argv);
}
