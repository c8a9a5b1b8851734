#include "driver/unsolved.h"

#include "driver/implementation_note.h"
#include "render/feature_list.h"

#include <stdio.h>
#include <string.h>

/* A feature that is never `wanted` is always there: trees and shading. */
static bool is_unsolved(const rk_plan *plan, uint32_t feature)
{
    char name[64];
    snprintf(name, sizeof name, " %s ", rk_features[feature]->stem);
    return (!rk_features[feature]->wanted || rk_plan_has(plan, feature)) &&
           strstr(rk_unsolved_features, name);
}

rk_unsolved rk_unsolved_features_of(const rk_plan *plan)
{
    rk_unsolved unsolved = {""};
    uint32_t all = 0, named = 0;
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        all += is_unsolved(plan, i);
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++) {
        if (!is_unsolved(plan, i))
            continue;
        named++;
        strcat(unsolved.text, named == 1 ? "" : named == all ? " and " : ", ");
        strcat(unsolved.text, rk_features[i]->stem);
    }
    if (all > 0)
        strcat(unsolved.text, all == 1 ? " is still the starter" : " are still the starters");
    return unsolved;
}

void rk_driver_note_unsolved(const rk_driver *driver)
{
    if (driver->quiet || driver->image.pixels == NULL)
        return;
    const rk_plan plan = rk_plan_of(&driver->scene, &driver->render);
    const rk_unsolved unsolved = rk_unsolved_features_of(&plan);
    if (*unsolved.text)
        fprintf(stderr, "%s: %s; the picture shows it\n", driver->feature, unsolved.text);
}
