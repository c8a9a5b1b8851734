#include "render/option_table.h"

#include "base/image.h"

rk_option_table rk_render_option_table(rk_render_options *options)
{
    return (rk_option_table){{
        {"width", RK_OPTION_UINT, &options->width, "N", "of the picture, pixels", 1,
         RK_IMAGE_SIDE_MAX},
        {"height", RK_OPTION_UINT, &options->height, "N", "of the picture, pixels", 1,
         RK_IMAGE_SIDE_MAX},
        {"samples", RK_OPTION_UINT, &options->samples, "N",
         "rays through each pixel; 1 looks through its centre", 1, 65536},
        {"sampling", RK_OPTION_CHOICE, &options->sampling, "uniform|stratified|low-discrepancy",
         "how they are spread over the pixel", 0, 0},
        {"seed", RK_OPTION_UINT, &options->seed, "N",
         "of the random samples: another seed, other noise", 0, UINT32_MAX},
        {"shadows", RK_OPTION_FLAG, &options->shadows, NULL,
         "ask for each light whether something is in its way", 0, 0},
        {"shading", RK_OPTION_CHOICE, &options->shading.model,
         "off|lambert|phong|blinn-phong|gradient", "how surfaces answer light", 0, 0},
        {"normalized", RK_OPTION_FLAG, &options->shading.normalized, NULL,
         "no surface sends back more light than it gets", 0, 0},
        {"reflections", RK_OPTION_FLAG, &options->reflections, NULL,
         "surfaces with a specular colour mirror what is around them", 0, 0},
        {"transparency", RK_OPTION_FLAG, &options->transparency, NULL,
         "glass shows what is behind it, and tints its shadows", 0, 0},
        {"glass", RK_OPTION_CHOICE, &options->glass, "multiplicative|ordered|beer-lambert",
         "how glass tints its shadows", 0, 0},
        {"recursion", RK_OPTION_UINT, &options->recursion, "N",
         "surfaces behind the first that a ray may go on to, by mirrors and panes", 0,
         RK_RECURSION_MAX},
        {"light-samples", RK_OPTION_UINT, &options->light.samples, "N",
         "points on a light with an extent, for each point that it may shine on", 1, 16384},
        {"light-sampling", RK_OPTION_CHOICE, &options->light.sampling,
         "uniform|stratified|low-discrepancy", "how they are spread over the light", 0, 0},
        {"light-map", RK_OPTION_CHOICE, &options->light.map, "area|solid-angle",
         "spread evenly over the light, or over the directions to it", 0, 0},
        {"falloff", RK_OPTION_CHOICE, &options->light.falloff, "none|physical",
         "does light get weaker with distance and slant?", 0, 0},
        {"ratio", RK_OPTION_FLAG, &options->light.ratio, NULL,
         "unshadowed light by its closed form, times the share that is seen; for a parallelogram "
         "of "
         "one colour with --falloff physical and Lambert's law",
         0, 0},
        {"settle", RK_OPTION_UINT, &options->light.settle, "N",
         "so many shadow rays that agree settle a point; 0: all are traced", 0, 16384},
        {"glossy", RK_OPTION_UINT, &options->glossy.samples, "N",
         "directions that the first rough mirror on a way sends a ray into; 0: mirrors are perfect",
         0, 16384},
        {"glossy-radius", RK_OPTION_FLOAT, &options->glossy.radius, "R",
         "of the disk around mirrored directions, at distance 1; negative, and by default, 0.5 "
         "over "
         "the material's shininess",
         -1, 1000},
        {"glossy-weights", RK_OPTION_CHOICE, &options->glossy.weights, "classic|renormalized",
         "directions that lead into the surface count as black, or not at all", 0, 0},
        {"glossy-map", RK_OPTION_CHOICE, &options->glossy.map, "polar|concentric",
         "how the disk is filled", 0, 0},
        {"glossy-sampling", RK_OPTION_CHOICE, &options->glossy.sampling,
         "uniform|stratified|low-discrepancy", "how directions are spread over it", 0, 0},
        {NULL, RK_OPTION_FLAG, NULL, NULL, NULL, 0, 0},
    }};
}
