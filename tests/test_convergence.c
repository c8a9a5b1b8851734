/* How far a picture is from the truth: against figures worked out by hand. */
#include "test.h"

#include "driver/convergence.h"
#include "scenes/builtin.h"

static rk_image make_image(const rk_vec3 *pixels, size_t count)
{
    rk_image image;
    rk_error error;
    rk_check_ok(rk_image_init(&image, count, 1, &error), error);
    memcpy(image.pixels, pixels, count * sizeof *pixels);
    return image;
}

static void a_picture_has_no_error_against_itself(void **state)
{
    (void)state;
    const rk_vec3 pixels[] = {{0.25f, 1, 7}, {0, -3, 0.1f}};
    rk_image image = make_image(pixels, 2);
    rk_picture_error off = rk_picture_compare(&image, &image);
    rk_check(off.rmse == 0 && off.max_error == 0 && off.bias == 0, "rmse %g, max %g, bias %g",
             off.rmse, off.max_error, off.bias);
    rk_image_free(&image);
}

static void errors_are_taken_over_all_channels(void **state)
{
    (void)state;
    const rk_vec3 want_pixels[] = {{1, 1, 1}, {0, 0, 0}};
    const rk_vec3 got_pixels[] = {{1, 1, 0}, {0, 0, 0.5f}};
    rk_image want = make_image(want_pixels, 2), got = make_image(got_pixels, 2);
    rk_picture_error off = rk_picture_compare(&got, &want);
    /* Six channels, off by -1 and .5; all of it exact in binary but the root's last rounding. */
    rk_check_close(off.rmse, sqrt(1.25 / 6), 1e-15, "root of the mean square");
    rk_check_close(off.bias, -0.5 / 6, 1e-15, "the mean of got - want");
    rk_check_close(off.max_error, 1, 0, "the largest, whatever its sign");
    rk_image_free(&want);
    rk_image_free(&got);
}

static void channels_without_a_truth_do_not_count(void **state)
{
    (void)state;
    const rk_vec3 want_pixels[] = {{1, 1, 1}, {NAN, NAN, NAN}};
    const rk_vec3 got_pixels[] = {{1, 1, 4}, {100, 0, -100}};
    rk_image want = make_image(want_pixels, 2), got = make_image(got_pixels, 2);
    rk_picture_error off = rk_picture_compare(&got, &want);
    rk_check_close(off.rmse, sqrt(3), 1e-15, "over three channels: the root of 9 / 3");
    rk_check_close(off.max_error, 3, 0, "the largest of these");
    rk_check_close(off.bias, 1, 0, "the mean of these");
    rk_image_free(&want);
    rk_image_free(&got);
}

/* A sphere in 8 x 8 pixels. */
static void start_driver(rk_driver *driver)
{
    rk_error error;
    *driver = rk_driver_default("test", "");
    driver->render.width = driver->render.height = 8;
    driver->render.samples = 4;
    driver->render.sampling = RK_SAMPLER_UNIFORM;
    driver->render.seed = 5;
    driver->quiet = true;
    rk_check_ok(rk_builtin_scene(&driver->scene, "sphere:80", &error), error);
    rk_check_ok(rk_image_init(&driver->image, 8, 8, &error), error);
    driver->pool = rk_pool_start(1, &error);
    rk_check_ok(driver->pool && rk_driver_build(driver, &error), error);
}

static void a_reference_has_samples_of_its_own_and_leaves_the_driver_as_it_was(void **state)
{
    (void)state;
    rk_error error;
    rk_driver driver;
    start_driver(&driver);
    rk_vec3 *pixels = driver.image.pixels;
    rk_image reference;
    rk_check_ok(rk_convergence_reference(&driver, &reference, &error), error);
    rk_check(driver.image.pixels == pixels && driver.render.seed == 5, "the driver has changed");
    rk_check_ok(rk_driver_render(&driver, &error), error);
    rk_picture_error off = rk_picture_compare(&driver.image, &reference);
    rk_check(off.rmse > 0, "at the sphere's rim, other samples cover another part of it");
    rk_image_free(&reference);
    rk_check_equal(rk_driver_finish(&driver, true, &error), 0, "all is freed");
}

static void errors_are_those_of_all_seeds(void **state)
{
    (void)state;
    enum { SEEDS = 3 };
    rk_error error;
    rk_driver driver;
    start_driver(&driver);
    rk_image truth;
    rk_check_ok(rk_convergence_reference(&driver, &truth, &error), error);
    double squares = 0, bias = 0, least = (double)INFINITY, largest = 0;
    for (uint32_t i = 0; i < SEEDS; i++) {
        driver.render.seed = 5 + i;
        rk_check_ok(rk_driver_render(&driver, &error), error);
        rk_picture_error off = rk_picture_compare(&driver.image, &truth);
        squares += off.rmse * off.rmse / SEEDS;
        bias += off.bias / SEEDS;
        least = fmin(least, off.rmse);
        largest = fmax(largest, off.rmse);
    }
    driver.render.seed = 5;
    rk_seed_errors off;
    rk_check_ok(rk_convergence_errors(&driver, &truth, SEEDS, &off, &error), error);
    rk_check(driver.render.seed == 5, "the driver's seed has changed to %u", driver.render.seed);
    rk_check(least < largest, "seeds differ in their samples, so in their errors");
    rk_check_close(off.rmse, sqrt(squares), 1e-15, "the root of the mean square of all pictures");
    rk_check_close(off.bias, bias, 1e-15, "the mean of their biases");
    rk_check_close(off.rmse_low, least, 0, "the least error of a picture");
    rk_check_close(off.rmse_high, largest, 0, "the largest error of a picture");
    rk_check_close(off.rays, 4, 0, "four samples, without shadows or reflections");
    rk_image_free(&truth);
    rk_check_equal(rk_driver_finish(&driver, true, &error), 0, "all is freed");
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_picture_has_no_error_against_itself),
    cmocka_unit_test(errors_are_taken_over_all_channels),
    cmocka_unit_test(channels_without_a_truth_do_not_count),
    cmocka_unit_test(a_reference_has_samples_of_its_own_and_leaves_the_driver_as_it_was),
    cmocka_unit_test(errors_are_those_of_all_seeds),
};

RK_SUITE("convergence", tests)
