/* The debug views of a node's splits, whose numbers are printed as well. */
#include "driver.h"

#include <stdio.h>
#include <stdlib.h>

/* A node, and the ways to cut it. */
typedef struct cuts {
    uint32_t node;      /* wanted: the --node-th from the root, parents first, left before right */
    uint32_t candidate; /* wanted of them, or RK_TREE_VIEW_NOT_GIVEN */
    uint32_t met;       /* nodes */
    const rk_bvh_node *found;
    uint32_t count;
    rk_sah_split list[RK_SAH_CANDIDATES_MAX];
} cuts;

static void find_node(const rk_bvh_node *node, uint32_t level, void *context)
{
    cuts *c = context;
    (void)level;
    if (c->met++ == c->node)
        c->found = node;
}

/* Lists the candidates of the node, as the builder saw them. */
static bool list_cuts(cuts *c, const rk_driver *driver, rk_error *error)
{
    const rk_bvh *bvh = &driver->accel.bvh;
    rk_bvh_visit(bvh, find_node, c);
    if (!c->found)
        return rk_fail(error, "--node %u: this tree's nodes are 0 to %u; choose one of them",
                       c->node, c->met - 1);
    rk_bvh_range stretch = rk_bvh_range_of(bvh, (uint32_t)(c->found - bvh->nodes));
    rk_bvh_reference *references =
        rk_allocate(stretch.count, sizeof *references, "candidates", error);
    if (!references)
        return false;
    for (uint32_t i = 0; i < stretch.count; i++)
        references[i] =
            rk_bvh_reference_of(&driver->scene.mesh, bvh->triangles[stretch.begin + i].index);
    const rk_sah_options options = {driver->bins, driver->split == RK_ACCEL_SAH_3};
    c->count = rk_sah_candidates(references, stretch.count, &options, c->list);
    free(references);
    if (c->count == 0)
        return rk_fail(error, "--node %u: there is no way to cut this node; choose another one",
                       c->node);
    if (c->candidate != RK_TREE_VIEW_NOT_GIVEN && c->candidate >= c->count)
        return rk_fail(error, "--candidate %u: this node's candidates are 0 to %u; choose one",
                       c->candidate, c->count - 1);
    return true;
}

static const rk_sah_split *dearest(const cuts *c)
{
    const rk_sah_split *worst = &c->list[0];
    for (uint32_t k = 1; k < c->count; k++)
        if (c->list[k].cost > worst->cost)
            worst = &c->list[k];
    return worst;
}

/* The left part blue, the right part red, half transparent. */
static void draw_cut(rk_overlay *overlay, const rk_sah_split *cut)
{
    const rk_vec3 blue = rk_vec(0.02f, 0.15f, 0.9f), red = rk_vec(0.9f, 0.04f, 0.02f);
    rk_overlay_box(overlay, &cut->box[0], blue, 0.3f);
    rk_overlay_box(overlay, &cut->box[1], red, 0.3f);
    rk_overlay_wireframe(overlay, &cut->box[0], blue, 1.5f);
    rk_overlay_wireframe(overlay, &cut->box[1], red, 1.5f);
}

static void draw_all(rk_overlay *overlay, const cuts *c)
{
    const rk_vec3 cheap = rk_vec(0.09f, 0.46f, 0.81f), dear = rk_vec(0.79f, 0.35f, 0);
    const rk_sah_split *best = rk_sah_cheapest(c->list, c->count), *worst = dearest(c);
    double range = worst->cost > best->cost ? worst->cost - best->cost : 1;
    for (uint32_t k = 0; k < 2 * c->count; k++) {
        const rk_sah_split *cut = &c->list[k / 2];
        float dearness = (float)((cut->cost - best->cost) / range);
        rk_overlay_wireframe(overlay, &cut->box[k % 2], rk_mix(cheap, dear, dearness), 1);
    }
    for (int side = 0; side < 2; side++)
        rk_overlay_wireframe(overlay, &best->box[side], rk_vec(1, 1, 1), 2);
}

static bool put_row(const cuts *c, const rk_driver *driver, const rk_sah_split *cut,
                    rk_error *error)
{
    static const char *const header[] = {"scene", "method", "node", "axis", "border",
                                         "left",  "right",  "cost", NULL};
    const rk_accel_title method = rk_accel_name(&driver->accel);
    char path[4096], node[16], border[16], left[16], right[16], cost[32];
    if (!rk_driver_table(driver, "sah_binning_candidates", path, error))
        return false;
    snprintf(node, sizeof node, "%u", c->node);
    snprintf(border, sizeof border, "%u", cut->border);
    snprintf(left, sizeof left, "%u", cut->count[0]);
    snprintf(right, sizeof right, "%u", cut->count[1]);
    snprintf(cost, sizeof cost, "%.6g", cut->cost);
    const char *axis = cut->axis == 0 ? "x" : cut->axis == 1 ? "y" : "z";
    const char *const cells[] = {
        driver->scene.name, method.text, node, axis, border, left, right, cost};
    return rk_table_put(path, header, cells, 8, 5, error);
}

/* Prints the cuts that are drawn and the cheapest; all of them become a table as well. */
static bool tell_cuts(const cuts *c, const rk_driver *driver, const rk_sah_split *shown,
                      rk_error *error)
{
    bool all = rk_driver_debug(driver, "candidates"), ok = true;
    const rk_sah_split *best = rk_sah_cheapest(c->list, c->count);
    for (uint32_t k = 0; ok && k < c->count; k++) {
        const rk_sah_split *cut = &c->list[k];
        if (all || cut == shown || cut == best)
            printf("candidate %u: axis %c, border %u: %u triangles left, %u right, cost %.6g%s\n",
                   k, "xyz"[cut->axis], cut -> border, cut -> count[0], cut -> count[1],
                   cut -> cost, cut == best ? ", the cheapest" : "");
        ok = !all || put_row(c, driver, cut, error);
    }
    return ok;
}

/* The split that --debug split or bad-split draws. */
static const rk_sah_split *shown_of(const cuts *c, const rk_driver *driver)
{
    if (!rk_driver_debug(driver, "bad-split"))
        return rk_sah_cheapest(c->list, c->count);
    return c->candidate == RK_TREE_VIEW_NOT_GIVEN ? dearest(c) : &c->list[c->candidate];
}

static bool list_chosen(cuts *c, const rk_driver *driver, rk_error *error)
{
    const choices *chosen = driver->choices;
    *c = (cuts){.node = chosen->node, .candidate = chosen->candidate};
    return list_cuts(c, driver, error);
}

bool wants_splits(const rk_driver *driver)
{
    return rk_driver_debug(driver, "split") || rk_driver_debug(driver, "bad-split") ||
           rk_driver_debug(driver, "candidates");
}

bool draw_splits(rk_driver *driver, rk_error *error)
{
    cuts c;
    rk_overlay overlay;
    if (!list_chosen(&c, driver, error) || !rk_driver_render(driver, error) ||
        !rk_overlay_init(&overlay, &driver->image, &driver->scene, &driver->accel, driver->pool,
                         error))
        return false;
    if (rk_driver_debug(driver, "candidates"))
        draw_all(&overlay, &c);
    else
        draw_cut(&overlay, shown_of(&c, driver));
    rk_overlay_free(&overlay);
    return true;
}

bool save_splits(rk_driver *driver, rk_error *error)
{
    cuts c;
    char label[48];
    if (!list_chosen(&c, driver, error))
        return false;
    const rk_sah_split *shown = shown_of(&c, driver);
    snprintf(label, sizeof label, "%s%u", driver->debug, c.node);
    if (rk_driver_debug(driver, "bad-split"))
        snprintf(label, sizeof label, "bad-split%u_%u", c.node, (uint32_t)(shown - c.list));
    return rk_driver_save(driver, label, error) && tell_cuts(&c, driver, shown, error);
}
