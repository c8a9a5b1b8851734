/* A feature is named if its unit is a starter and the picture's plan uses it; a tree's builder only
 * by views of the tree, because hits are the same in all trees. */
#include "driver/unsolved.h"

#include "driver/implementation_note.h"
#include "render/feature_list.h"

#include <stdio.h>
#include <string.h>

bool rk_is_starter(const char *stem)
{
    char name[64];
    snprintf(name, sizeof name, " %s ", stem);
    return strstr(rk_unsolved_features, name) != NULL;
}

static bool is_driver_of_trees(const char *stem)
{
    return strcmp(stem, "bvh_median") == 0 || strcmp(stem, "sah_binning") == 0 ||
           strcmp(stem, "wide_bvh") == 0;
}

/* Rays find the same hits in every tree: only a view of the tree itself shows how it was built. */
static bool shows_tree_of(const rk_driver *driver, uint32_t feature)
{
    const rk_accel_kind split = driver->split;
    if (!driver->debug || !is_driver_of_trees(driver->feature))
        return false;
    return (feature == RK_FEATURE_bvh_median && split <= RK_ACCEL_SAH_3) ||
           (feature == RK_FEATURE_sah_binning && split >= RK_ACCEL_SAH &&
            split <= RK_ACCEL_COLLAPSED) ||
           (feature == RK_FEATURE_wide_bvh && split == RK_ACCEL_COLLAPSED);
}

/* `driver`: NULL if the picture is no view of a tree. */
static bool is_unsolved(const rk_plan *plan, const rk_driver *driver, uint32_t feature)
{
    return rk_is_starter(rk_features[feature]->stem) &&
           (rk_plan_has(plan, feature) || (driver && shows_tree_of(driver, feature)));
}

static rk_unsolved unsolved_of(const rk_plan *plan, const rk_driver *driver)
{
    rk_unsolved unsolved = {""};
    uint32_t all = 0, named = 0;
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        all += is_unsolved(plan, driver, i);
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++) {
        if (!is_unsolved(plan, driver, i))
            continue;
        named++;
        strcat(unsolved.text, named == 1 ? "" : named == all ? " and " : ", ");
        strcat(unsolved.text, rk_features[i]->stem);
    }
    if (all > 0)
        strcat(unsolved.text, all == 1 ? " is still the starter" : " are still the starters");
    return unsolved;
}

rk_unsolved rk_unsolved_features_of(const rk_plan *plan)
{
    return unsolved_of(plan, NULL);
}

rk_unsolved rk_driver_unsolved(const rk_driver *driver)
{
    const rk_plan plan = rk_plan_of(&driver->scene, &driver->render);
    return unsolved_of(&plan, driver);
}

/* Of a driver whose picture has the plan. */
static bool uses(const rk_driver *driver, const rk_plan *plan, const char *stem)
{
    const rk_accel_kind split = driver->split;
    const bool has_tree = driver->build_ms.runs > 0;
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++) {
        if (strcmp(rk_features[i]->stem, stem) != 0)
            continue;
        return rk_plan_has(plan, i) || strcmp(stem, driver->feature) == 0 ||
               (has_tree && i == RK_FEATURE_watertight) ||
               (has_tree && i == RK_FEATURE_bvh_median && split <= RK_ACCEL_COLLAPSED) ||
               (has_tree && i == RK_FEATURE_sah_binning && split >= RK_ACCEL_SAH &&
                split <= RK_ACCEL_COLLAPSED) ||
               (has_tree && i == RK_FEATURE_wide_bvh && split == RK_ACCEL_COLLAPSED);
    }
    return false;
}

rk_unsolved rk_driver_units(const rk_driver *driver)
{
    const rk_plan plan = rk_plan_of(&driver->scene, &driver->render);
    const size_t size = sizeof(rk_unsolved);
    const char *last = NULL; /* authors stand together */
    rk_unsolved units = {""};
    size_t length = 0;
    for (const rk_implementation_author *unit = rk_implementation_authors;
         unit->stem && length < size; unit++)
        if (uses(driver, &plan, unit->stem)) {
            const bool same = last && strcmp(last, unit->author) == 0;
            length += (size_t)snprintf(units.text + length, size - length, "%s%s%s%s",
                                       same   ? ", "
                                       : last ? "), "
                                              : "units: ",
                                       same ? "" : unit->author, same ? "" : " (", unit->stem);
            last = unit->author;
        }
    if (rk_implementation_authors->stem && length < size)
        snprintf(units.text + length, size - length, "%s%s%s",
                 last ? ")" : "units: ", last && *rk_implementation_others ? ", others: " : "",
                 rk_implementation_others);
    return units;
}

void rk_driver_note_unsolved(const rk_driver *driver)
{
    if (driver->quiet || driver->image.pixels == NULL)
        return;
    const rk_unsolved unsolved = rk_driver_unsolved(driver);
    if (*unsolved.text)
        fprintf(stderr, "%s: %s; the picture shows it\n", driver->feature, unsolved.text);
}
