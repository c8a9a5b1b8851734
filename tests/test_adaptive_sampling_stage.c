/* Adaptive sampling in the renderer: the error that was asked for, pictures that are right on
 * average, with every kind of sample; the same to the bit for any number of threads; and nothing of
 * it without --error. */
#include "test_scene.h"

#include "features/shading.h"
#include "render/stages/adaptive_sampling_stage.h"

enum { side = 32 };

static rk_render_options options_of(float error)
{
    rk_render_options options = rk_render_options_default();
    options.width = options.height = side;
    options.shadows = true;
    options.light.samples = 1;
    options.adaptive_sampling.error = error;
    return options;
}

/* The same samples without adaptive sampling. */
static rk_render_options uniform(rk_render_options options, uint32_t samples)
{
    options.adaptive_sampling.error = 0;
    options.samples = samples;
    options.lens_samples = options.lens_samples > 0 ? samples : 0;
    options.motion.samples = options.motion.samples > 0 ? samples : 0;
    return options;
}

static double square(rk_vec3 v)
{
    return (double)rk_dot(v, v) / 3;
}

/* The error of a picture, relative to the root mean square of the other. */
static double relative_error(const rk_image *got, const rk_image *want)
{
    double error = 0, squares = 0;
    for (size_t i = 0; i < want->width * want->height; i++) {
        error += square(rk_sub(got->pixels[i], want->pixels[i]));
        squares += square(want->pixels[i]);
    }
    return sqrt(error / squares);
}

/* --- Off -------------------------------------------------------------------------------------- */

static void adaptive_sampling_is_planned_where_it_is_wanted(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = rk_render_options_default();
    rk_check(!rk_plan_of(&scene, &options).adaptive_sampling, "planned by default");
    options.adaptive_sampling.error = 0.01f;
    rk_check(rk_plan_of(&scene, &options).adaptive_sampling, "not planned at an error of 0.01");
    rk_scene_free(&scene);
}

static void without_an_error_no_bit_changes(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = uniform(options_of(0), 4);
    test_picture usual = test_render(&scene, options, 2);
    options.adaptive_sampling.max_samples = 64;
    options.adaptive_sampling.shown = RK_ADAPTIVE_SAMPLES;
    test_picture off = test_render(&scene, options, 2);
    rk_check(test_same_pixels(&usual.image, &off.image), "other pixels");
    rk_check(memcmp(&usual.counters, &off.counters, sizeof off.counters) == 0, "other counters");
    rk_check_equal(off.counters.rounds, 0, "no rounds");
    rk_image_free(&usual.image);
    rk_image_free(&off.image);
    rk_scene_free(&scene);
}

/* --- On --------------------------------------------------------------------------------------- */

static void the_picture_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    test_picture one = test_render(&scene, options_of(0.03f), 1);
    for (uint32_t threads = 2; threads <= 7; threads += 5) {
        test_picture several = test_render(&scene, options_of(0.03f), threads);
        rk_check(test_same_pixels(&one.image, &several.image), "%u threads: other pixels", threads);
        rk_check_equal(several.counters.primary_rays, one.counters.primary_rays, "rays");
        rk_image_free(&several.image);
    }
    rk_image_free(&one.image);
    rk_scene_free(&scene);
}

/* Neighbouring tiles tell each other their variance, and the size need not be a multiple of one. */
static void any_size_of_picture_has_all_its_pixels(void **state)
{
    (void)state;
    const uint32_t sizes[][2] = {{1, 1}, {1, 40}, {37, 23}, {17, 33}};
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, 1, 0);
    test_scene_light(&scene, rk_vec(0, 0, -3), rk_vec(1, 1, 1));
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        rk_render_options options = options_of(0.001f);
        options.width = sizes[i][0];
        options.height = sizes[i][1];
        test_picture picture = test_render(&scene, options, 2);
        for (size_t k = 0; k < picture.image.width * picture.image.height; k++)
            rk_check(picture.image.pixels[k].x > 0.2f && picture.image.pixels[k].x <= 0.8001f,
                     "%u x %u: pixel %zu is %g, and a wall of 0.8 is everywhere", sizes[i][0],
                     sizes[i][1], k, (double)picture.image.pixels[k].x);
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void a_picture_without_noise_takes_the_first_samples(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, 1, 0);
    rk_render_options options = options_of(1e-6f);
    options.ambient_occlusion.intensity = 1;
    test_picture picture = test_render(&scene, options, 2);
    rk_check_equal(picture.counters.primary_rays, side * side * RK_ADAPTIVE_FIRST, "one round");
    rk_check_equal(picture.counters.rounds, 1, "one round");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void no_pixel_takes_more_samples_than_allowed(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = options_of(1e-5f);
    options.adaptive_sampling.max_samples = 32;
    test_picture picture = test_render(&scene, options, 2);
    rk_check(picture.counters.kept_samples <= side * side * 32, "%llu samples in %d pixels",
             (unsigned long long)picture.counters.kept_samples, side * side);
    rk_check(picture.counters.most_samples > 4 && picture.counters.most_samples <= 32,
             "%llu samples in a pixel", (unsigned long long)picture.counters.most_samples);
    rk_check(picture.counters.kept_samples > side * side * 4, "%llu samples",
             (unsigned long long)picture.counters.kept_samples);
    rk_check(picture.counters.estimated_error > 1e-5, "an error of 1e-5 is not claimed");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void samples_are_shown_where_the_noise_is(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = options_of(0.02f);
    options.adaptive_sampling.shown = RK_ADAPTIVE_SAMPLES;
    test_picture shown = test_render(&scene, options, 2);
    options.adaptive_sampling.shown = RK_ADAPTIVE_RADIANCE;
    test_picture usual = test_render(&scene, options, 2);
    rk_check_equal(shown.counters.primary_rays, usual.counters.primary_rays, "the same work");
    float least = 1, most = 0;
    for (size_t i = 0; i < side * side; i++) {
        least = rk_min(least, shown.image.pixels[i].x);
        most = rk_max(most, shown.image.pixels[i].x);
    }
    rk_check(least < 0.1f && most > 0.4f, "red from %g to %g: few samples and many", (double)least,
             (double)most);
    const rk_gradient gradient = rk_gradient_cool_to_warm();
    rk_check(shown.counters.most_samples < options.adaptive_sampling.max_samples,
             "no pixel needs the largest number");
    rk_check_near(most, rk_gradient_at(&gradient, 1).x, 1e-6,
                  "the warmest colour is that of the most samples in the picture");
    rk_image_free(&shown.image);
    rk_image_free(&usual.image);
    rk_scene_free(&scene);
}

/* --- Right on average, and the error ---------------------------------------------------------- */

typedef struct effect {
    const char *scene;
    bool lens, motion, mirrors;
    float error;
} effect;

static const effect effects[] = {{"cornell-light", false, false, false, 0.03f},
                                 {"teapot", false, false, false, 0.02f},
                                 {"cornell", true, false, false, 0.03f},
                                 {"moving", false, true, false, 0.02f},
                                 {"cornell", false, false, true, 0.03f}};

static rk_render_options options_for(const effect *e)
{
    rk_render_options options = options_of(e->error);
    if (e->lens) {
        options.lens_samples = 1;
        options.lens.focal_distance = 2.5f;
        options.lens.aperture = 150;
    }
    options.motion.samples = e->motion;
    if (e->mirrors) {
        options.reflections = true;
        options.glossy.samples = 1;
        options.glossy.radius = 0.1f;
    }
    return options;
}

enum { seeds = 24, converged = 512 };

static double mean_of(const rk_image *image)
{
    double sum = 0;
    for (size_t i = 0; i < image->width * image->height; i++)
        sum += (double)(image->pixels[i].x + image->pixels[i].y + image->pixels[i].z) / 3;
    return sum / (double)(image->width * image->height);
}

/* The mean of all pixels, over independent pictures, against a converged one. 5 standard errors are
 * those of the adaptive pictures; the reference has as many samples as all of them, more evenly
 * placed. */
static void check_effect(const effect *e)
{
    rk_scene scene = test_scene_builtin(e->scene);
    rk_render_options options = options_for(e);
    options.seed = 999;
    test_picture reference = test_render(&scene, uniform(options, converged), 2);
    double mean = 0, squares = 0, error = 0, estimated = 0;
    for (uint32_t seed = 0; seed < seeds; seed++) {
        options.seed = seed;
        test_picture picture = test_render(&scene, options, 2);
        double difference = mean_of(&picture.image) - mean_of(&reference.image);
        double relative = relative_error(&picture.image, &reference.image);
        mean += difference / seeds;
        squares += difference * difference / seeds;
        error += relative * relative / seeds;
        estimated += picture.counters.estimated_error * picture.counters.estimated_error / seeds;
        rk_image_free(&picture.image);
    }
    double standard_error = sqrt((squares - mean * mean) / (seeds - 1));
    rk_check(fabs(mean) <= 5 * standard_error, "%s: bias %g, standard error %g", e->scene, mean,
             standard_error);
    /* Within 20 % of the wanted error, over all pictures; better where 8 samples suffice. */
    rk_check(sqrt(error) < 1.2 * (double)e->error, "%s: error %g, asked for %g", e->scene,
             sqrt(error), (double)e->error);
    /* Estimated too large, rather: Sobol' samples of 8 are more even than their halves predict. */
    double ratio = sqrt(estimated / error);
    rk_check(ratio > 0.7 && ratio < 1.4, "%s: estimated error over error: %g", e->scene, ratio);
    rk_image_free(&reference.image);
    rk_scene_free(&scene);
}

static void pictures_are_right_on_average_and_reach_the_error(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof effects / sizeof *effects; i++)
        check_effect(&effects[i]);
}

/* Mean squares over several pictures; a single one may be lucky by a third. */
static void fewer_samples_are_taken_than_evenly_for_the_same_error(void **state)
{
    (void)state;
    enum { pictures = 8 };
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = options_of(0.012f);
    /* Of pixel and light on their own; their joint samples are better, and leave less to gain. */
    options.sampling = options.light.sampling = RK_SAMPLER_LOW_DISCREPANCY;
    options.seed = 999;
    test_picture reference = test_render(&scene, uniform(options, converged), 2);
    double samples = 0, of_adaptive = 0, of_even = 0;
    for (uint32_t seed = 0; seed < pictures; seed++) {
        options.seed = seed;
        test_picture adaptive = test_render(&scene, options, 2);
        const double taken = (double)adaptive.counters.primary_rays / (side * side);
        test_picture even = test_render(&scene, uniform(options, (uint32_t)(1.5 * taken)), 2);
        samples += taken / pictures;
        of_adaptive += pow(relative_error(&adaptive.image, &reference.image), 2) / pictures;
        of_even += pow(relative_error(&even.image, &reference.image), 2) / pictures;
        rk_image_free(&adaptive.image);
        rk_image_free(&even.image);
    }
    rk_check(of_adaptive < of_even,
             "the error of %g samples per pixel is %g, of 1.5 times as many even ones %g", samples,
             sqrt(of_adaptive), sqrt(of_even));
    rk_image_free(&reference.image);
    rk_scene_free(&scene);
}

static void a_number_of_samples_that_is_no_power_of_two_is_refused(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = options_of(0.01f);
    rk_error error;
    options.adaptive_sampling.max_samples = 100;
    rk_check(!rk_render_check(&scene, &options, &error), "100 samples are accepted");
    rk_check_error_names(error, "power of two");
    rk_scene_free(&scene);
}

static void samples_that_depend_on_other_pixels_are_refused(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_error error;
    for (int k = 0; k < 5; k++) {
        rk_render_options options = options_of(0.01f);
        rk_sampler_kind *const kinds[] = {&options.sampling, &options.lens_sampling,
                                          &options.light.sampling, &options.glossy.sampling,
                                          &options.ambient_occlusion.sampling};
        *kinds[k] = RK_SAMPLER_ZSOBOL;
        rk_check(!rk_render_check(&scene, &options, &error), "zsobol is accepted, option %d", k);
        rk_check_error_names(error, "take sobol");
        options.adaptive_sampling.error = 0;
        rk_check_ok(rk_render_check(&scene, &options, &error), error);
    }
    rk_scene_free(&scene);
}

/* Edges in motion depend on the time and on the place in the pixel. */
static void times_are_of_the_sequence_of_the_other_numbers(void **state)
{
    (void)state;
    for (int sampling = RK_TIME_EQUIDISTANT; sampling <= RK_TIME_UNIFORM; sampling++) {
        rk_render_options options = options_of(0.01f);
        options.motion.sampling = (rk_time_sampling)sampling;
        rk_check_equal(rk_adaptive_sampling_options_of(&options).motion.sampling, RK_TIME_SOBOL,
                       "times with an error");
        options.adaptive_sampling.error = 0;
        rk_check_equal(rk_adaptive_sampling_options_of(&options).motion.sampling, sampling,
                       "times without an error");
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(adaptive_sampling_is_planned_where_it_is_wanted),
    cmocka_unit_test(without_an_error_no_bit_changes),
    cmocka_unit_test(the_picture_is_the_same_for_any_number_of_threads),
    cmocka_unit_test(any_size_of_picture_has_all_its_pixels),
    cmocka_unit_test(a_picture_without_noise_takes_the_first_samples),
    cmocka_unit_test(no_pixel_takes_more_samples_than_allowed),
    cmocka_unit_test(samples_are_shown_where_the_noise_is),
    cmocka_unit_test(pictures_are_right_on_average_and_reach_the_error),
    cmocka_unit_test(fewer_samples_are_taken_than_evenly_for_the_same_error),
    cmocka_unit_test(a_number_of_samples_that_is_no_power_of_two_is_refused),
    cmocka_unit_test(samples_that_depend_on_other_pixels_are_refused),
    cmocka_unit_test(times_are_of_the_sequence_of_the_other_numbers),
};

RK_SUITE("adaptive_sampling_stage", tests)
