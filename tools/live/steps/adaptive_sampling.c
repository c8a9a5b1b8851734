/* What the figure of chapter 14 follows: the rounds of a picture of 8 x 8 pixels, planned by the
 * renderer with the unit's functions. */
#include "render/render.h"
#include "scenes/builtin.h"

#include <stdio.h>

int main(void)
{
    rk_scene scene = {0};
    rk_image image = {0};
    rk_accel accel = {0};
    rk_counters counters = {0};
    rk_error error;
    rk_render_options options = rk_render_options_default();
    options.width = options.height = 8;
    options.shadows = true;
    options.adaptive_sampling.error = .02f;
    rk_pool *pool = rk_pool_start(1, &error);
    bool ok = pool && rk_builtin_scene(&scene, "teapot", &error) &&
              rk_image_init(&image, options.width, options.height, &error) &&
              rk_accel_build(&accel, RK_ACCEL_WIDE, &scene, &error) &&
              rk_render(&image, &scene, &accel, &options, pool, &counters, NULL, &error);
    if (ok)
        printf("{\"kept\": %llu, \"taken\": %llu}\n", (unsigned long long)counters.kept_samples,
               (unsigned long long)counters.taken_samples);
    else
        fprintf(stderr, "%s\n", error.text);
    rk_accel_free(&accel);
    rk_image_free(&image);
    rk_scene_free(&scene);
    rk_pool_stop(pool);
    return !ok;
}
