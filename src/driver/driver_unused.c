#include "driver/driver_unused.h"

#include "render/feature_list.h"

#include <stdio.h>

static const rk_option *first_given(const rk_driver *driver, const rk_feature *feature)
{
    const rk_option_table table = {feature->options, NULL};
    const rk_option *row = NULL;
    for (char **argument = driver->argv; feature->options && *argument && !row; argument++)
        row = rk_options_find(&table, 1, *argument);
    return row;
}

/* Options of a feature that the command line turns off have an effect, too: it is in the usual
 * plan. */
void rk_driver_note_unused(const rk_driver *driver)
{
    const rk_plan plan = rk_plan_of(&driver->scene, &driver->render);
    const rk_plan usual = rk_plan_of(&driver->scene, &driver->render_usual);
    for (uint32_t i = 0; i < RK_FEATURE_COUNT && !driver->quiet && !driver->timing; i++) {
        bool needed = rk_plan_has(&plan, i) || rk_plan_has(&usual, i);
        const rk_option *given = needed ? NULL : first_given(driver, rk_features[i]);
        if (given)
            fprintf(stderr, "%s: --%s changes nothing in this picture: it takes %s\n",
                    driver->feature, given->name, rk_features[i]->takes);
    }
}
