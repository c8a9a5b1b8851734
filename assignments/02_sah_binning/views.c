/* The debug views of a node's splits, whose numbers are printed as well. */
#include "driver.h"

#include <stdio.h>
#include <stdlib.h>

static void find_node(const rk_bvh_node *node, uint32_t level, void *context)
{
    splits *c = context;
    (void)level;
    if (c->visited++ == c->node)
        c->found = node;
}

bool list_splits(splits *c, const rk_driver *driver, rk_error *error)
{
    const choices *chosen = driver->choices;
    const rk_bvh *bvh = rk_driver_tree(driver);
    *c = (splits){.node = chosen->node, .candidate = chosen->candidate};
    rk_bvh_visit(bvh, find_node, c);
    if (!c->found)
        return rk_fail(error, "--node %u: this tree's nodes are 0 to %u; choose one of them",
                       c->node, c->visited - 1);
    rk_bvh_range range = rk_bvh_range_of(bvh, (uint32_t)(c->found - bvh->nodes));
    c->triangles = range.count;
    c->references = rk_allocate(range.count, sizeof *c->references, "candidates", error);
    if (!c->references)
        return false;
    for (uint32_t i = 0; i < range.count; i++)
        c->references[i] =
            rk_bvh_reference_of(&driver->scene.mesh, bvh->triangles[range.begin + i].index);
    const rk_sah_options options = {driver->bins, driver->split == RK_ACCEL_SAH_3};
    c->count = rk_sah_candidates(c->references, range.count, &options, c->list);
    if (c->count == 0 && range.count == 1)
        return rk_fail(error, "--node %u: its one triangle cannot be split; choose another node",
                       c->node);
    if (c->count == 0)
        return rk_fail(error,
                       "--node %u: rk_sah_candidates finds no split of its %u triangles: write "
                       "steps 1 to 3 of sah_binning first, or choose another node",
                       c->node, c->triangles);
    if (!rk_sah_cheapest(c->list, c->count))
        return rk_fail(error,
                       "rk_sah_cheapest finds none of the node's %u candidates: write step 3 of "
                       "sah_binning first",
                       c->count);
    if (c->candidate != RK_TREE_VIEW_NOT_GIVEN && c->candidate >= c->count)
        return rk_fail(error, "--candidate %u: this node's candidates are 0 to %u; choose one",
                       c->candidate, c->count - 1);
    return true;
}

static const rk_sah_split *most_expensive(const splits *c)
{
    const rk_sah_split *worst = &c->list[0];
    for (uint32_t k = 1; k < c->count; k++)
        if (c->list[k].cost > worst->cost)
            worst = &c->list[k];
    return worst;
}

/* The left part blue, the right part green, half transparent. */
static void draw_split(rk_overlay *overlay, const rk_sah_split *split)
{
    const rk_vec3 blue = rk_vec(0.02f, 0.15f, 0.9f), green = rk_vec(0.02f, 0.5f, 0.1f);
    rk_overlay_box(overlay, &split->box[0], blue, 0.3f);
    rk_overlay_box(overlay, &split->box[1], green, 0.3f);
    rk_overlay_wireframe(overlay, &split->box[0], blue, 1.5f);
    rk_overlay_wireframe(overlay, &split->box[1], green, 1.5f);
}

/* From cheap to expensive. */
static rk_vec3 colour_of_cost(float fraction)
{
    return rk_mix(rk_vec(0.09f, 0.46f, 0.81f), rk_vec(0.79f, 0.35f, 0), fraction);
}

static void draw_all(rk_overlay *overlay, const splits *c)
{
    const rk_sah_split *best = rk_sah_cheapest(c->list, c->count), *worst = most_expensive(c);
    double range = worst->cost > best->cost ? worst->cost - best->cost : 1;
    for (uint32_t k = 0; k < 2 * c->count; k++) {
        const rk_sah_split *split = &c->list[k / 2];
        float fraction = (float)((split->cost - best->cost) / range);
        rk_overlay_wireframe(overlay, &split->box[k % 2], colour_of_cost(fraction), 1);
    }
    for (int side = 0; side < 2; side++)
        rk_overlay_wireframe(overlay, &best->box[side], rk_vec(1, 1, 1), 2);
}

static bool put_row(const splits *c, const rk_driver *driver, const rk_sah_split *split,
                    rk_error *error)
{
    static const char *const header[] = {"scene", "method", "node", "axis", "boundary",
                                         "left",  "right",  "cost", NULL};
    const rk_accel_title method = rk_accel_name(&driver->accel);
    char path[4096], node[16], boundary[16], left[16], right[16], cost[32];
    if (!rk_driver_table(driver, "sah_binning_candidates", path, error))
        return false;
    snprintf(node, sizeof node, "%u", c->node);
    snprintf(boundary, sizeof boundary, "%u", split->boundary);
    snprintf(left, sizeof left, "%u", split->count[0]);
    snprintf(right, sizeof right, "%u", split->count[1]);
    snprintf(cost, sizeof cost, "%.6g", split->cost);
    const char *axis = split->axis == 0 ? "x" : split->axis == 1 ? "y" : "z";
    const char *const cells[] = {driver->scene.name, method.text, node,  axis,
                                 boundary,           left,        right, cost};
    return rk_table_put(path, header, cells, 8, 5, error);
}

/* Prints the splits that are drawn and the cheapest; --debug candidates puts all of them into a
 * table. */
static bool print_splits(const splits *c, const rk_driver *driver, const rk_sah_split *shown,
                         rk_error *error)
{
    bool all = rk_driver_debug(driver, "candidates"), ok = true;
    const rk_sah_split *best = rk_sah_cheapest(c->list, c->count);
    for (uint32_t k = 0; ok && k < c->count; k++) {
        const rk_sah_split *split = &c->list[k];
        const char axis = "xyz"[split->axis];
        if (!driver->quiet && (all || split == shown || split == best))
            printf("candidate %u: axis %c, boundary %u: %u triangles left, %u right, cost %.6g%s\n",
                   k, axis, split->boundary, split->count[0], split->count[1], split->cost,
                   split == best ? ", the cheapest" : "");
        ok = !all || put_row(c, driver, split, error);
    }
    return ok;
}

/* The split that --debug split or bad-split draws. */
static const rk_sah_split *shown_of(const splits *c, const rk_driver *driver)
{
    if (!rk_driver_debug(driver, "bad-split"))
        return rk_sah_cheapest(c->list, c->count);
    return c->candidate == RK_TREE_VIEW_NOT_GIVEN ? most_expensive(c) : &c->list[c->candidate];
}

/* The views need the candidates alone. */
static bool list_chosen(splits *c, const rk_driver *driver, rk_error *error)
{
    bool ok = list_splits(c, driver, error);
    free(c->references);
    return ok;
}

bool wants_splits(const rk_driver *driver)
{
    return rk_driver_debug(driver, "split") || rk_driver_debug(driver, "bad-split") ||
           rk_driver_debug(driver, "candidates");
}

bool draw_splits(rk_driver *driver, rk_error *error)
{
    splits c;
    rk_overlay overlay;
    if (!list_chosen(&c, driver, error) || !rk_driver_render_overlay(driver, &overlay, error))
        return false;
    if (rk_driver_debug(driver, "candidates")) {
        draw_all(&overlay, &c);
        driver->scale = rk_driver_scale_of("expected cost of a ray, by the split",
                                           rk_sah_cheapest(c.list, c.count)->cost,
                                           most_expensive(&c)->cost, colour_of_cost);
    } else
        draw_split(&overlay, shown_of(&c, driver));
    rk_overlay_free(&overlay);
    return true;
}

bool save_splits(rk_driver *driver, rk_error *error)
{
    splits c;
    char label[48];
    if (!list_chosen(&c, driver, error))
        return false;
    const rk_sah_split *shown = shown_of(&c, driver);
    snprintf(label, sizeof label, "%s%u", driver->debug, c.node);
    if (rk_driver_debug(driver, "bad-split"))
        snprintf(label, sizeof label, "bad-split%u_%u", c.node, (uint32_t)(shown - c.list));
    return rk_driver_save(driver, label, error) && print_splits(&c, driver, shown, error);
}
