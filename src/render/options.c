/* The default and the range of each option stand in its row; this file joins the rows of the
 * renderer and of all features, and applies them. */
#include "render/options.h"

static const rk_option rows[] = {
    {"width", RK_FIELD(rk_render_options, width), "N", "width of the picture, pixels", 1,
     RK_IMAGE_SIDE_MAX, 800},
    {"height", RK_FIELD(rk_render_options, height), "N", "height of the picture, pixels", 1,
     RK_IMAGE_SIDE_MAX, 800},
    {"samples", RK_FIELD(rk_render_options, samples), "N", "rays per pixel; 1: through its centre",
     1, RK_SAMPLES_MAX, 1},
    {"sampling", RK_CHOICE(rk_render_options, sampling, rk_sampler_names),
     "distribution of the samples over the pixel", .initial = RK_SAMPLER_SOBOL},
    {"seed", RK_FIELD(rk_render_options, seed), "N",
     "seed of the random samples: another seed gives other noise", 0, UINT32_MAX, 0},
    {"shadows", RK_FIELD(rk_render_options, shadows), NULL, "test whether lights are occluded"},
    {"face-shadows", RK_FIELD(rk_render_options, face_shadows), NULL,
     "start shadow rays on the faces of smooth meshes, too: faces at the edge of a shadow are "
     "black"},
    {"reflections", RK_FIELD(rk_render_options, reflections), NULL,
     "trace reflected rays from surfaces with a specular colour"},
    {"max-depth", RK_FIELD(rk_render_options, max_depth), "N",
     "largest number of bounces of a path: reflections and transparent surfaces passed", 0,
     RK_MAX_DEPTH, 6, .alias = "recursion"},
    {0},
};

rk_render_option_tables rk_render_options_tables(rk_render_options *options)
{
    rk_render_option_tables all = {.tables = {{rows, options}}, .count = 1};
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        if (rk_features[i]->options)
            all.tables[all.count++] = (rk_option_table){rk_features[i]->options, options};
    return all;
}

rk_render_options rk_render_options_default(void)
{
    /* The gradient's stops have no row. */
    rk_render_options options = {.shading.gradient = rk_gradient_cool_to_warm()};
    const rk_render_option_tables all = rk_render_options_tables(&options);
    for (size_t i = 0; i < all.count; i++)
        rk_options_set_defaults(all.tables[i].rows, &options);
    return options;
}

static bool check_rows(const rk_render_options *options, rk_error *error)
{
    for (uint32_t i = 0; i < RK_FEATURE_COUNT; i++)
        if (rk_features[i]->options && !rk_options_check(rk_features[i]->options, options, error))
            return false;
    return rk_options_check(rows, options, error);
}

bool rk_render_options_check(const rk_render_options *options, rk_error *error)
{
    bool ok = check_rows(options, error);
    for (uint32_t i = 0; ok && i < RK_FEATURE_COUNT; i++)
        ok = !rk_features[i]->check || rk_features[i]->check(options, error);
    return ok;
}

bool rk_render_options_check_command(const rk_render_options *options, rk_error *error)
{
    bool ok = true;
    for (uint32_t i = 0; ok && i < RK_FEATURE_COUNT; i++)
        ok = !rk_features[i]->check_command || rk_features[i]->check_command(options, error);
    return ok;
}
