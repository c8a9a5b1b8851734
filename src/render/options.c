#include "render/options.h"

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
        {"recursion", RK_OPTION_UINT, &options->max_depth, "N",
         "surfaces behind the first that a ray may go on to, by mirrors and panes", 0,
         RK_MAX_DEPTH},
        {"light-samples", RK_OPTION_UINT, &options->light.samples, "N",
         "points on a light with an extent, for each point that it may shine on", 1, 16384},
        {"light-sampling", RK_OPTION_CHOICE, &options->light.sampling,
         "uniform|stratified|low-discrepancy", "how they are spread over the light", 0, 0},
        {"light-map", RK_OPTION_CHOICE, &options->light.domain, "area|solid-angle",
         "spread evenly over the light, or over the directions to it", 0, 0},
        {"falloff", RK_OPTION_CHOICE, &options->light.falloff, "none|physical",
         "does light get weaker with distance and slant?", 0, 0},
        {"ratio", RK_OPTION_FLAG, &options->light.ratio, NULL,
         "unshadowed light by its closed form, times the share that is seen; for a parallelogram "
         "of "
         "one colour with --falloff physical and Lambert's law",
         0, 0},
        {"settle", RK_OPTION_UINT, &options->light.early_out, "N",
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
        {"bloom", RK_OPTION_FLAG, &options->bloom.on, NULL,
         "what is bright glows into what is around it", 0, 0},
        {"bloom-threshold", RK_OPTION_FLOAT, &options->bloom.threshold, "Y",
         "brightness from which on a pixel glows", -1e6, 1e6},
        {"bloom-intensity", RK_OPTION_FLOAT, &options->bloom.intensity, "I",
         "of the glow that is added", 0, 1e6},
        {"bloom-radius", RK_OPTION_UINT, &options->bloom.radius, "R",
         "of the filter, pixels: it has 2R + 1 taps", 0, RK_BLOOM_RADIUS_MAX},
        {"bloom-border", RK_OPTION_CHOICE, &options->bloom.border, "zero|clamp|renormalize",
         "the filter sees beyond the picture: nothing; what is at the border; nothing, and the "
         "other weights count as all",
         0, 0},
        {"bloom-method", RK_OPTION_CHOICE, &options->bloom.method,
         "exact|gaussian|recursive|pyramid",
         "the filter itself, or one that is close to it and cheaper", 0, 0},
        {"environment-filter", RK_OPTION_CHOICE, &options->environment_filter,
         "nearest|bilinear|seamless", "between the texels of --environment", 0, 0},
        {"focal-distance", RK_OPTION_FLOAT, &options->lens.focal_distance, "D",
         "what is so far from the camera is sharp, world units", 1e-3, 1e6},
        {"focal", RK_OPTION_CHOICE, &options->lens.focal, "plane|sphere",
         "so far along the view, as in photographs, or in any direction", 0, 0},
        {"aperture", RK_OPTION_FLOAT, &options->lens.aperture, "A",
         "diameter of the lens, thousandths of a world unit; 0 is a pinhole", 0, 1e6},
        {"lens-samples", RK_OPTION_UINT, &options->lens_samples, "N",
         "rays through the lens for each pixel that is out of focus; 0: a pinhole", 0, 65536},
        {"lens-sampling", RK_OPTION_CHOICE, &options->lens_sampling,
         "uniform|stratified|low-discrepancy", "how they are spread over the lens and the pixel", 0,
         0},
        {"shutter-open", RK_OPTION_FLOAT, &options->motion.shutter.open, "X",
         "when the shutter opens; what moves is then at (X, y(X), 0) from where it rests", -1e3,
         1e3},
        {"shutter-close", RK_OPTION_FLOAT, &options->motion.shutter.close, "X", "when it closes",
         -1e3, 1e3},
        {"time-samples", RK_OPTION_UINT, &options->motion.samples, "N",
         "times that a pixel's --samples see together, where motion may change them; 0: everything "
         "rests",
         0, 65536},
        {"time-sampling", RK_OPTION_CHOICE, &options->motion.sampling,
         "equidistant|stratified|low-discrepancy",
         "how times are spread; equidistant ones are the same for all pixels", 0, 0},
        {"isolate", RK_OPTION_FLOAT, &options->motion.isolate, "K",
         "show the equidistant time K of --time-samples alone; below 1 or above N it lies before "
         "or "
         "after the shutter",
         -1e6, 1e6},
        {NULL, RK_OPTION_FLAG, NULL, NULL, NULL, 0, 0},
    }};
}

bool rk_render_options_check(const rk_render_options *options, rk_error *error)
{
    const rk_motion_options *motion = &options->motion;
    if (!isnan(motion->isolate) && motion->samples == 0)
        return rk_fail(error,
                       "--isolate %g: it is one of the --time-samples, and there are none; give "
                       "--time-samples N, 1 or more",
                       (double)motion->isolate);
    return true;
}
