/* Joint samples in the renderer: they are the default, the older kinds are options, and a picture's
 * error is smaller than with pairs that know nothing of each other. */
#include "test_scene.h"

static void joint_samples_are_the_default_and_pairs_an_option(void **state)
{
    (void)state;
    rk_render_options o = rk_render_options_default();
    rk_check(o.sampling == RK_SAMPLER_SOBOL && o.lens_sampling == RK_SAMPLER_SOBOL &&
                 o.light.sampling == RK_SAMPLER_SOBOL && o.glossy.sampling == RK_SAMPLER_SOBOL,
             "pixel, lens, light and mirror: want the kind sobol by default");
    rk_check(o.motion.sampling == RK_TIME_STRATIFIED, "times: want stratified ones by default");
}

static bool is_planned(const char *name, rk_render_options options)
{
    rk_scene scene = test_scene_builtin(name);
    bool planned = rk_plan_of(&scene, &options).sampling;
    rk_scene_free(&scene);
    return planned;
}

static void sampling_is_planned_where_joint_samples_are_drawn(void **state)
{
    (void)state;
    rk_render_options o = rk_render_options_default();
    rk_check(!is_planned("cornell", o),
             "one sample per pixel and a point light: no sample is drawn");
    rk_check(is_planned("cornell-light", o), "an area light takes samples");
    o.light.sampling = RK_SAMPLER_LOW_DISCREPANCY;
    rk_check(!is_planned("cornell-light", o), "low-discrepancy samples of the light are pairs");
    o.samples = 2;
    rk_check(is_planned("cornell", o), "two samples per pixel");
    o.sampling = RK_SAMPLER_UNIFORM;
    rk_check(!is_planned("cornell", o), "two uniform samples per pixel");
    o.lens_samples = 2;
    rk_check(is_planned("cornell", o), "a lens takes samples");
}

static void set_kind(rk_render_options *o, rk_sampler_kind kind)
{
    o->sampling = o->lens_sampling = o->light.sampling = o->glossy.sampling = kind;
}

/* The mean squared difference from the picture `want`. */
static double error_of(const rk_scene *scene, const rk_render_options *options,
                       const test_picture *want)
{
    test_picture got = test_render(scene, *options, 1);
    double squares = 0;
    for (size_t i = 0; i < want->image.width * want->image.height; i++) {
        double d = (double)got.image.pixels[i].y - (double)want->image.pixels[i].y;
        squares += d * d;
    }
    rk_image_free(&got.image);
    return squares;
}

/* Mean squared errors with 64 samples, of pairs over joint ones, by 3 seeds. The reference has 16
 * times as many samples and another seed. */
static double gain(const rk_scene *scene, rk_render_options few, rk_render_options many,
                   rk_time_sampling times)
{
    double joint = 0, pairs = 0;
    many.seed = 99;
    test_picture want = test_render(scene, many, 1);
    for (few.seed = 0; few.seed < 3; few.seed++) {
        set_kind(&few, RK_SAMPLER_SOBOL);
        few.motion.sampling = times;
        joint += error_of(scene, &few, &want);
        set_kind(&few, RK_SAMPLER_LOW_DISCREPANCY);
        few.motion.sampling = RK_TIME_LOW_DISCREPANCY;
        pairs += error_of(scene, &few, &want);
    }
    rk_image_free(&want.image);
    return pairs / joint;
}

static rk_render_options small(uint32_t samples)
{
    rk_render_options o = rk_render_options_default();
    o.width = o.height = 24;
    o.samples = samples;
    return o;
}

static rk_render_options with_lens(uint32_t samples)
{
    rk_render_options o = small(samples);
    o.lens_samples = samples;
    o.lens.focal_distance = 2.5f;
    o.lens.aperture = 150;
    return o;
}

static rk_render_options with_times(uint32_t samples)
{
    rk_render_options o = small(samples);
    o.motion.samples = samples;
    return o;
}

/* 1.5: the variance of pairs falls as 1 / N, of joint samples as N^-1.3, and with N = 64 it is two
 * to three times smaller. */
static void pixel_and_lens_are_joint(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    double got = gain(&scene, with_lens(64), with_lens(1024), RK_TIME_STRATIFIED);
    rk_check(got >= 1.5,
             "a lens with 64 samples: the squared error of pairs is %.2f times that of "
             "joint samples, want 1.5 at least",
             got);
    rk_scene_free(&scene);
}

static void pixel_and_time_are_joint(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("moving");
    for (int times = RK_TIME_STRATIFIED; times <= RK_TIME_SOBOL; times += 2) {
        double got = gain(&scene, with_times(64), with_times(1024), (rk_time_sampling)times);
        rk_check(got >= 1.5,
                 "motion with 64 samples, %s times: the squared error of pairs is %.2f "
                 "times that of joint samples, want 1.5 at least",
                 times == RK_TIME_SOBOL ? "sobol" : "stratified", got);
    }
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(joint_samples_are_the_default_and_pairs_an_option),
    cmocka_unit_test(sampling_is_planned_where_joint_samples_are_drawn),
    cmocka_unit_test(pixel_and_lens_are_joint),
    cmocka_unit_test(pixel_and_time_are_joint),
};

RK_SUITE("sampling_stage", tests)
