/* The table of --models: the light through a few panes and blocks, by each model of shadows. */
#include "driver.h"

#include <stdio.h>

/* The two crossings between a point and a light: of two panes of half opacity, or of a block of
 * blue glass. */
typedef struct path {
    const char *name;
    float t[2];
    float alpha;
    rk_vec3 kd[2], absorption;
} path;

static const path paths[] = {
    {"red, then yellow glass", {0.25f, 0.5f}, 0.5f, {{1, 0, 0}, {1, 1, 0}}, {0, 0, 0}},
    {"yellow, then red glass", {0.25f, 0.5f}, 0.5f, {{1, 1, 0}, {1, 0, 0}}, {0, 0, 0}},
    {"a block 0.125 thick",
     {0.25f, 0.375f},
     0.25f,
     {{0.5f, 0.75f, 1}, {0.5f, 0.75f, 1}},
     {2, 1, 0}},
    {"a block 0.5 thick", {0.25f, 0.75f}, 0.25f, {{0.5f, 0.75f, 1}, {0.5f, 0.75f, 1}}, {2, 1, 0}},
};

static rk_vec3 light_along(const path *p, rk_glass_model model)
{
    rk_crossing crossings[2];
    for (int i = 0; i < 2; i++)
        crossings[i] = (rk_crossing){.t = p->t[i],
                                     .entering = i == 0,
                                     .alpha = p->alpha,
                                     .kd = p->kd[i],
                                     .absorption = p->absorption};
    return rk_transparency_transmit(model, crossings, 2, 1);
}

bool put_study(rk_driver *driver, rk_error *error)
{
    static const char *const header[] = {"path", "model", "red", "green", "blue", NULL};
    char file[4096], cells[3][32];
    if (!rk_driver_table(driver, "transparency_models", file, error))
        return false;
    for (size_t i = 0; i < sizeof paths / sizeof *paths; i++)
        for (uint32_t model = 0; model < rk_glass_model_names.count; model++) {
            rk_vec3 light = light_along(&paths[i], (rk_glass_model)model);
            for (int axis = 0; axis < 3; axis++)
                snprintf(cells[axis], sizeof cells[axis], "%.4f", (double)rk_axis(light, axis));
            const char *row[] = {paths[i].name, rk_glass_model_names.items[model], cells[0],
                                 cells[1], cells[2]};
            if (!rk_table_put(file, header, row, 5, 2, error))
                return false;
        }
    return true;
}
