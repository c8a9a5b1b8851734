/* Calls the unit where the renderer needs it: say here where, and what it costs. */
#include "render/stages/fog_stage.h"

#include "render/feature.h"

static const rk_option rows[] = {
    {"fog-strength", RK_FIELD(rk_render_options, fog.strength), "S", "of fog; 0: none", 0, 1, 0},
    {0},
};

bool rk_fog_wanted(const rk_fog_options *options)
{
    return options->strength > 0;
}

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    (void)scene;
    return rk_fog_wanted(&options->fog);
}

/* On the whole picture, when all tiles are rendered. rk_feature has other hooks: `shade` adds light
 * at shading points, as in ambient_occlusion_stage.c. */
static bool post(rk_image *image, const rk_render_options *options, rk_pool *pool,
                 rk_counters *counters, rk_error *error)
{
    (void)pool, (void)counters, (void)error;
    for (size_t i = 0; i < image->width * image->height; i++)
        image->pixels[i] = rk_fog_colour(image->pixels[i], options->fog.strength);
    return true;
}

const rk_feature rk_fog_feature = {.stem = "fog",
                                   .options = rows,
                                   .takes = "a --fog-strength above 0",
                                   .wanted = wanted,
                                   .post = post};
