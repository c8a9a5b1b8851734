#include "render/options.h"

static const rk_option rows[] = {
    {"width", RK_FIELD(rk_render_options, width), "N", "of the picture, pixels", 1,
     RK_IMAGE_SIDE_MAX, 800},
    {"height", RK_FIELD(rk_render_options, height), "N", "of the picture, pixels", 1,
     RK_IMAGE_SIDE_MAX, 800},
    {"samples", RK_FIELD(rk_render_options, samples), "N",
     "rays through each pixel; 1 looks through its centre", 1, RK_SAMPLES_MAX, 1},
    {"sampling", RK_CHOICE(rk_render_options, sampling, rk_sampler_names),
     "how they are spread over the pixel", .initial = RK_SAMPLER_STRATIFIED},
    {"seed", RK_FIELD(rk_render_options, seed), "N",
     "of the random samples: another seed, other noise", 0, UINT32_MAX, 0},
    {"shadows", RK_FIELD(rk_render_options, shadows), NULL,
     "ask for each light whether something is in its way"},
    {"reflections", RK_FIELD(rk_render_options, reflections), NULL,
     "surfaces with a specular colour mirror what is around them"},
    {"max-depth", RK_FIELD(rk_render_options, max_depth), "N",
     "surfaces behind the first that a ray may go on to, by mirrors and panes", 0, RK_MAX_DEPTH, 6,
     .alias = "recursion"},
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
    /* The gradient's stops are the one thing that no row can hold. */
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
