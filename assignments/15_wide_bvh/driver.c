/* Draws the figures and measures the tables of wide_bvh: the children of a node, the boxes of a
 * level, the blocks of triangles, the visits per ray; and what each step towards the fastest tree
 * gains. */
#include "driver.h"

static const char summary[] =
    "Renders a scene by a tree of eight children per node.\n"
    "--debug node draws the children of a node, --debug level the boxes of a level.\n"
    "--debug blocks shows which triangles are tested together.\n"
    "--debug visits shows how many nodes each camera ray visits, from blue, none, to yellow, "
    "--most.\n"
    "--steps writes tables: time per ray from the binary tree to packets of rays, step by step, "
    "medians of --runs.\n"
    "--occupancy writes a table: nodes by their children, blocks by their triangles.";

enum { usual_level = 1, usual_most = 40 };

static const rk_option options[] = {
    {"node", RK_FIELD(choices, node), "N",
     "node drawn by --debug node: 0 is the root, parents come before children", 0, UINT32_MAX - 1,
     0, .views = "node"},
    {"level", RK_FIELD(choices, level), "N",
     "level drawn by --debug level: 0 is the root, 1 are its children", 0, RK_BVH_LEVELS_MAX - 1,
     usual_level, .views = "level"},
    {"most", RK_FIELD(choices, most), "N", "visits of the brightest pixels of --debug visits", 1,
     UINT32_MAX - 1, usual_most, .views = "visits"},
    {"steps", RK_FIELD(choices, steps), NULL,
     "write tables: time per ray and memory, step by step"},
    {"occupancy", RK_FIELD(choices, occupancy), NULL,
     "write a table: how full nodes and blocks are"},
    {0},
};

static void set_defaults(rk_driver *driver)
{
    driver->split = RK_ACCEL_COLLAPSED;
}

static bool put_shape(rk_driver *driver, rk_error *error)
{
    const rk_wide_bvh *wide = wide_tree(driver);
    const rk_bvh *binary = rk_driver_tree(driver);
    const bool is_wide = wide->node_count > 0;
    const tree_shape tree = is_wide ? shape_of_wide(wide) : shape_of_binary(binary);
    const double triangles = is_wide ? wide->triangle_count : binary->triangle_count;
    if (tree.nodes == 0) /* everything moves, or the root is a leaf */
        return true;
    const double children = tree.children / tree.nodes;
    const double filled = 100 * triangles / (RK_WIDE_BLOCK * tree.blocks);
    return rk_driver_row(driver, "nodes", "1", rk_timing_once(tree.nodes), error) &&
           rk_driver_row(driver, "blocks", "1", rk_timing_once(tree.blocks), error) &&
           rk_driver_row(driver, "children_per_node", "1", rk_timing_once(children), error) &&
           rk_driver_row(driver, "places_filled", "%", rk_timing_once(filled), error) &&
           rk_driver_row(driver, "bytes_per_triangle", "1", rk_timing_once(tree.bytes / triangles),
                         error) &&
           rk_driver_row(driver, "expected_steps", "1", rk_timing_once(tree.steps), error);
}

static bool put_rows(rk_driver *driver, rk_error *error)
{
    if (driver->render.shadows)
        return rk_driver_row(driver, "render_with_shadows", "ms", driver->render_ms, error);
    const double rays = (double)driver->counters.primary_rays;
    const bool is_wide = driver->accel.wide.node_count > 0; /* a binary root is tested alone */
    const double boxes = (double)driver->counters.box_tests / rays;
    const double visits = is_wide ? boxes / RK_WIDE_CHILDREN : (boxes - 1) / 2;
    const double triangles = (double)driver->counters.triangle_tests / rays;
    return rk_driver_row(driver, "build", "ms", driver->build_ms, error) &&
           rk_driver_row(driver, "render", "ms", driver->render_ms, error) &&
           rk_driver_row(driver, "visits_per_ray", "1", rk_timing_once(visits), error) &&
           rk_driver_row(driver, "triangles_per_ray", "1", rk_timing_once(triangles), error) &&
           put_shape(driver, error);
}

int main(int argc, char **argv)
{
    static const rk_driver_view views[] = {
        {"node", draw_tree, false},
        {"level", draw_tree, false},
        {"blocks", draw_tree, false},
        {"visits", draw_visits, false},
        {0},
    };
    choices c;
    const rk_driver_study studies[] = {
        {&c.steps, put_steps, true}, {&c.occupancy, put_occupancy, false}, {0}};
    const rk_driver_spec spec = {
        .feature = "wide_bvh",
        .summary = summary,
        .options = options,
        .choices = &c,
        .set_defaults = set_defaults,
        .views = views,
        .studies = studies,
        .check_tree = check_view,
        .put_rows = put_rows,
        .save = save_view,
    };
    return rk_driver_main(&spec, argc, argv);
}
