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

/* --- Pixels that share a sequence ------------------------------------------------------------- */

static rk_render_options shared(rk_render_options o)
{
    set_kind(&o, RK_SAMPLER_ZSOBOL);
    o.ambient_occlusion.sampling = RK_SAMPLER_ZSOBOL;
    o.motion.sampling = RK_TIME_ZSOBOL;
    return o;
}

/* All effects at once: lights, a lens, mirrors, motion and ambient light. */
static rk_render_options with_all(uint32_t samples)
{
    rk_render_options o = with_lens(samples);
    o.shadows = o.reflections = true;
    o.light.samples = 2;
    o.glossy.samples = 2;
    o.glossy.radius = 0.1f;
    o.ambient_occlusion.intensity = 0.5f;
    o.ambient_occlusion.samples = 2;
    o.motion.samples = 2 * samples;
    return o;
}

static void shared_samples_are_planned_and_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    rk_render_options o = shared(rk_render_options_default());
    rk_check(is_planned("cornell-light", o), "an area light takes samples");
    rk_scene scene = test_scene_builtin("moving");
    for (uint32_t samples = 1; samples <= 3; samples++) {
        test_picture want = test_render(&scene, shared(with_all(samples)), 1);
        for (unsigned threads = 2; threads <= 4; threads++) {
            test_picture got = test_render(&scene, shared(with_all(samples)), threads);
            rk_check(memcmp(got.image.pixels, want.image.pixels,
                            24 * 24 * sizeof *want.image.pixels) == 0,
                     "%u samples: another picture with %u threads", samples, threads);
            rk_image_free(&got.image);
        }
        rk_image_free(&want.image);
    }
    rk_scene_free(&scene);
}

/* Over seeds, because the errors of a picture's pixels are related. 5 standard errors: once in 1.7
 * million times. */
static void pictures_of_shared_samples_are_unbiased(void **state)
{
    (void)state;
    enum { seeds = 40 };
    const char *const scenes[] = {"cornell-light", "moving"};
    for (int k = 0; k < 2; k++) {
        rk_scene scene = test_scene_builtin(scenes[k]);
        rk_render_options many = with_all(256);
        many.seed = 999;
        test_picture truth = test_render(&scene, many, 2);
        double want = 0;
        for (size_t i = 0; i < 24 * 24; i++)
            want += (double)truth.image.pixels[i].y / (24 * 24);
        for (uint32_t samples = 2; samples <= 3; samples++) {
            double sum = 0, squares = 0;
            rk_render_options few = shared(with_all(samples));
            for (few.seed = 0; few.seed < seeds; few.seed++) {
                double mean = 0;
                test_picture got = test_render(&scene, few, 2);
                for (size_t i = 0; i < 24 * 24; i++)
                    mean += (double)got.image.pixels[i].y / (24 * 24);
                sum += mean;
                squares += mean * mean;
                rk_image_free(&got.image);
            }
            double mean = sum / seeds, variance = (squares / seeds - mean * mean) / (seeds - 1);
            /* The truth's own error is far smaller: its samples are 100 times as many. */
            rk_check_near(mean, want, 5 * sqrt(1.1 * variance) + 1e-4 * want,
                          "%s, %u samples: the mean of the pictures", scenes[k], samples);
        }
        rk_image_free(&truth.image);
        rk_scene_free(&scene);
    }
}

/* The squared error of the means over squares of 4 x 4 pixels, by 8 seeds. */
static double blurred_error(const rk_scene *scene, rk_render_options few, const rk_image *want)
{
    double total = 0;
    for (few.seed = 0; few.seed < 8; few.seed++) {
        test_picture got = test_render(scene, few, 2);
        for (size_t y = 0; y + 4 <= want->height; y++)
            for (size_t x = 0; x + 4 <= want->width; x++) {
                double sum = 0;
                for (size_t i = 0; i < 16; i++) {
                    size_t at = (y + i / 4) * want->width + x + i % 4;
                    sum += (double)got.image.pixels[at].y - (double)want->pixels[at].y;
                }
                total += sum * sum;
            }
        rk_image_free(&got.image);
    }
    return total;
}

/* The reference, with 1024 samples, has a thousandth of the squared error or less.
 * 1.2: the standard error of a ratio of sums over 8 pictures of 36 squares is 8 %, and the gains
 * are 1.5 and more. */
static void few_shared_samples_have_less_error_after_a_blur(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options few = small(1);
    few.shadows = true;
    few.light.early_out = 0;
    few.ambient_occlusion.intensity = 2;
    few.light.samples = few.ambient_occlusion.samples = 1024;
    test_picture want = test_render(&scene, few, 2);
    for (uint32_t samples = 1; samples <= 4; samples++) {
        few.light.samples = few.ambient_occlusion.samples = samples;
        double own = blurred_error(&scene, few, &want.image);
        double got = blurred_error(&scene, shared(few), &want.image);
        rk_check(got * 1.2 <= own,
                 "%u samples of the light and of ambient light: after a blur the squared error is "
                 "%.3g, want at most 1/1.2 of that of sobol, %.3g",
                 samples, got, own);
    }
    rk_image_free(&want.image);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(joint_samples_are_the_default_and_pairs_an_option),
    cmocka_unit_test(sampling_is_planned_where_joint_samples_are_drawn),
    cmocka_unit_test(pixel_and_lens_are_joint),
    cmocka_unit_test(pixel_and_time_are_joint),
    cmocka_unit_test(shared_samples_are_planned_and_the_same_for_any_number_of_threads),
    cmocka_unit_test(pictures_of_shared_samples_are_unbiased),
    cmocka_unit_test(few_shared_samples_have_less_error_after_a_blur),
};

RK_SUITE("sampling_stage", tests)
