/* The models of shading as options (render/options.h); shade_stage.h evaluates them. */
#include "render/options.h"

RK_NAMES(rk_shading_model_names, rk_shading_model, RK_SHADING_GRADIENT, "off", "lambert", "phong",
         "blinn-phong", "gradient");

static const rk_option rows[] = {
    {"shading", RK_CHOICE(rk_render_options, shading.model, rk_shading_model_names),
     "how surfaces reflect light", .initial = RK_SHADING_LAMBERT},
    {"normalized", RK_FIELD(rk_render_options, shading.normalized), NULL,
     "scale the model so that no surface reflects more than kd + ks of the light",
     .of_scene = true},
    {0},
};

static bool wanted(const rk_scene *scene, const rk_render_options *options)
{
    return options->shading.model != RK_SHADING_OFF && rk_plan_has_light(scene);
}

static bool check(const rk_render_options *options, rk_error *error)
{
    return options->shading.gradient.count <= RK_GRADIENT_STOPS_MAX ||
           rk_fail(error, "a gradient has at most %d stops, not %u", RK_GRADIENT_STOPS_MAX,
                   options->shading.gradient.count);
}

const rk_feature rk_shading_feature = {.stem = "shading",
                                       .options = rows,
                                       .takes = "a light and a model other than off",
                                       .wanted = wanted,
                                       .check = check};
