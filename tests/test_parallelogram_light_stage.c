/* The light stage: lights with an extent against closed forms and grids in double, shading models
 * and glass as the renderer applies them, and counters as proof of work not done. */
#include "test_scene.h"

static const double pi = 3.14159265358979323846;

static rk_render_options small(void)
{
    rk_render_options options = rk_render_options_default();
    options.width = 14;
    options.height = 11;
    options.shadows = true;
    options.light.visibility = RK_LIGHT_RAYS; /* pyramids: test_unoccluded_light_stage.c */
    return options;
}

/* A wall at z = 1, and a light of sides 1 and .8 at z = -1 that is parallel to it. */
static rk_scene make_wall(uint32_t more_triangles)
{
    rk_scene scene = test_scene_of(2 + more_triangles, 2);
    test_scene_wall(&scene, 0, 1, 0);
    scene.mesh.materials[0].kd = rk_vec(0.5f, 0.5f, 0.5f);
    rk_vec3 white = rk_vec(1, 1, 1);
    scene.lights[scene.light_count++] = (rk_light){.kind = RK_LIGHT_PARALLELOGRAM,
                                                   .position = rk_vec(-0.2f, -0.3f, -1),
                                                   .edge01 = rk_vec(1, 0, 0),
                                                   .edge02 = rk_vec(0, 0.8f, 0),
                                                   .colours = {white, white, white, white}};
    return scene;
}

typedef struct wall_point {
    double x, y;
} wall_point;

static wall_point seen_on_wall(const rk_render_options *options, size_t x, size_t y)
{
    double half = tan(25 * pi / 180) * 4;
    double across = 2 * ((double)x + 0.5) / options->width - 1;
    double up = 1 - 2 * ((double)y + 0.5) / options->height;
    return (wall_point){-across * half * options->width / options->height, up * half};
}

/* The mean of cos^power / r^(2 falloff) over the light's points that the predicate lets pass. */
static double mean_over_light(wall_point p, bool physical, bool (*passes)(double x, double y))
{
    enum { side = 400 };
    double sum = 0;
    for (int j = 0; j < side; j++)
        for (int i = 0; i < side; i++) {
            double lx = -0.2 + (i + 0.5) / side - p.x, ly = -0.3 + 0.8 * (j + 0.5) / side - p.y;
            double square = lx * lx + ly * ly + 4, cosine = 2 / sqrt(square);
            /* Half-way, at z = 0, is where occluders are. */
            if (!passes || passes(p.x + lx / 2, p.y + ly / 2))
                sum += physical ? cosine * cosine / square * 0.8 : cosine;
        }
    return sum / side / side;
}

static void check_wall(const test_picture *picture, const rk_render_options *options, bool physical,
                       bool (*passes)(double x, double y), double tolerance, const char *hint)
{
    for (size_t y = 0; y < options->height; y++)
        for (size_t x = 0; x < options->width; x++) {
            double got = (double)rk_image_at(&picture->image, x, y)->x;
            double want = 0.5 * mean_over_light(seen_on_wall(options, x, y), physical, passes);
            rk_check(fabs(got - want) <= tolerance,
                     "pixel (%zu, %zu): got %.7g, want %.7g within %.2g: %s", x, y, got, want,
                     tolerance, hint);
        }
}

/* --- Lights with an extent ------------------------------------------------------------------- */

static void an_unshadowed_light_is_its_mean_or_its_irradiance(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0);
    rk_render_options options = small();
    options.light.samples = 4096;
    for (int physical = 0; physical < 2; physical++)
        for (int map = 0; map < 2; map++) {
            options.light.falloff = physical ? RK_FALLOFF_PHYSICAL : RK_FALLOFF_NONE;
            options.light.domain = map ? RK_LIGHT_DOMAIN_SOLID_ANGLE : RK_LIGHT_DOMAIN_AREA;
            test_picture picture = test_render(&scene, options, 2);
            /* In 64 x 64 strata a smooth integrand errs by its change within one, at most 1/64,
             * over the root of their number: 2.4e-4; the grid of 400 x 400 by much less. */
            check_wall(&picture, &options, physical, NULL, 2.5e-4, "there is no occluder");
            rk_image_free(&picture.image);
        }
    rk_scene_free(&scene);
}

/* A half-plane at z = 0 occludes rays to its left. */
static bool passes_right_half(double x, double y)
{
    (void)y;
    return x < 0.1;
}

static void a_soft_shadow_is_the_unoccluded_fraction_of_the_light(void **state)
{
    (void)state;
    rk_scene scene = make_wall(2);
    test_scene_quad(&scene, 2, rk_vec(0.1f, -9, 0), rk_vec(18, 0, 0), rk_vec(0, 18, 0));
    /* The occluder is beside the camera's cone, so that the wall is visible. */
    scene.camera.rotation = rk_vec(0, 0, 0);
    rk_render_options options = small();
    options.light.samples = 4096;
    options.light.early_out = 0;
    options.light.falloff = RK_FALLOFF_PHYSICAL;
    test_picture picture = test_render(&scene, options, 2);
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++) {
            wall_point p = seen_on_wall(&options, x, y);
            /* From the camera, the occluder hides the wall where 3 / 4 of the distance is at x >
             * .1.
             */
            if (p.x * 0.75 > 0.1 - 1e-3)
                continue;
            double got = (double)rk_image_at(&picture.image, x, y)->x;
            double want = 0.5 * mean_over_light(p, true, passes_right_half);
            /* An edge crosses 64 of 4096 strata, each of which errs by half at most. */
            rk_check_close(got, want, 64 * 0.5 / 4096 * 0.5 * 0.2,
                           "the visible fraction of the light");
        }
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void points_with_all_or_no_rays_occluded_stop_early(void **state)
{
    (void)state;
    rk_render_options options = small();
    options.light.samples = 256;
    const uint64_t pixels = 14 * 11;
    for (int occluded = 0; occluded < 2; occluded++) {
        rk_scene scene = make_wall(2);
        /* Near the light: out of the camera's view, which is ahead of z = -3. */
        scene.lights[0].position.z = -4;
        if (occluded)
            test_scene_wall(&scene, 2, -3.5f, 0);
        options.light.early_out = 16;
        test_picture early = test_render(&scene, options, 2);
        options.light.early_out = 0;
        test_picture traced = test_render(&scene, options, 2);
        rk_check(test_same_pixels(&early.image, &traced.image),
                 "where all rays agree, the rest changes nothing");
        rk_check_equal(early.counters.shadow_rays, (16 + 240 / 8) * pixels,
                       "with early out 16 per pixel, then one of 8");
        rk_check_equal(traced.counters.shadow_rays, 256 * pixels, "early_out = 0 traces them all");
        rk_check((rk_length(*rk_image_at(&early.image, 3, 3)) == 0) == occluded,
                 "occluded is black, unoccluded is not");
        rk_image_free(&early.image);
        rk_image_free(&traced.image);
        rk_scene_free(&scene);
    }
}

static double mean_of(const rk_image *image)
{
    double sum = 0;
    for (size_t i = 0; i < image->width * image->height; i++)
        sum += (double)image->pixels[i].x;
    return sum / (double)(image->width * image->height);
}

/* Of the mean over pictures of 64 seeds, against those with all rays traced. */
static void check_bias(const rk_scene *scene, double most, const char *hint)
{
    enum { seeds = 64 };
    rk_render_options options = small();
    options.width = options.height = 16;
    options.light.sampling = RK_SAMPLER_UNIFORM;
    options.light.samples = 64;
    double mean = 0, squares = 0;
    for (uint32_t seed = 0; seed < seeds; seed++) {
        options.seed = seed;
        options.light.early_out = 4;
        test_picture early = test_render(scene, options, 2);
        options.light.early_out = 0;
        test_picture traced = test_render(scene, options, 2);
        const double difference = mean_of(&early.image) / mean_of(&traced.image) - 1;
        mean += difference / seeds;
        squares += difference * difference / seeds;
        rk_image_free(&early.image);
        rk_image_free(&traced.image);
    }
    const double standard_error = sqrt((squares - mean * mean) / (seeds - 1));
    rk_check(fabs(mean) <= 4 * standard_error, "bias %g, standard error %g: %s", mean,
             standard_error, hint);
    rk_check(fabs(mean) < most, "bias %g, at most %g: %s", mean, most, hint);
}

static void early_outs_leave_the_mean_as_it_is(void **state)
{
    (void)state;
    rk_scene box = test_scene_builtin("cornell-light");
    check_bias(&box, 0.0004, "if agreed rays decided about all others, it would be 0.0013");
    rk_scene_free(&box);
    /* An occluder just before the light, and behind the camera. From the wall's middle it leaves
     * the left quarter of the light, or the left three quarters; four rays often agree. */
    for (int quarters = 1; quarters <= 3; quarters += 2) {
        rk_scene wall = make_wall(2);
        const float left = 0.9f * ((float)quarters / 4 - 0.2f);
        wall.lights[0].position.z = -4;
        test_scene_quad(&wall, 2, rk_vec(left, -9, -3.5f), rk_vec(18, 0, 0), rk_vec(0, 18, 0));
        check_bias(&wall, 0.006,
                   "if a ray that disagrees stood for itself alone, it would be 0.021");
        rk_scene_free(&wall);
    }
}

static void the_ratio_estimator_is_exact_where_nothing_occludes(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0);
    rk_render_options options = small();
    options.light.samples = 1;
    options.light.ratio = true;
    options.light.falloff = RK_FALLOFF_PHYSICAL;
    test_picture picture = test_render(&scene, options, 1);
    /* The reference is a midpoint rule: its error is the second derivative's, h^2 / 24 with
     * h = 1/400. */
    check_wall(&picture, &options, true, NULL, 2e-6, "one sample is enough");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void lights_without_extent_draw_no_samples(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0);
    scene.lights[0].kind = RK_LIGHT_POINT;
    rk_render_options options = small();
    test_picture point = test_render(&scene, options, 1);
    rk_check_equal(point.counters.light_samples, 0, "a point needs no random numbers");
    rk_check_equal(point.counters.shadow_rays, 14 * 11, "and one shadow ray per pixel");
    scene.lights[0].kind = RK_LIGHT_PARALLELOGRAM;
    scene.lights[0].edge01 = scene.lights[0].edge02 = rk_vec(0, 0, 0);
    test_picture small_light = test_render(&scene, options, 1);
    for (size_t i = 0; i < 14 * 11; i++)
        rk_check_close(small_light.image.pixels[i].x, (double)point.image.pixels[i].x, 1e-6,
                       "a parallelogram without size shines as a point");
    rk_image_free(&point.image);
    rk_image_free(&small_light.image);
    rk_scene_free(&scene);
}

static void each_pixel_and_each_light_has_samples_of_its_own(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0);
    rk_render_options options = small();
    options.light.samples = 1;
    options.light.falloff = RK_FALLOFF_PHYSICAL;
    test_picture one = test_render(&scene, options, 1);
    /* The same light twice is twice the light, but not twice the same error. */
    scene.lights[scene.light_count++] = scene.lights[0];
    test_picture two = test_render(&scene, options, 1);
    size_t different = 0;
    for (size_t i = 0; i < 14 * 11; i++)
        different += fabsf(two.image.pixels[i].x - 2 * one.image.pixels[i].x) > 1e-5f;
    rk_check(different > 100, "only %zu of 154 pixels differ", different);
    rk_image_free(&one.image);
    rk_image_free(&two.image);
    rk_scene_free(&scene);
}

/* --- Shading and glass ----------------------------------------------------------------------- */

static void the_shading_model_is_the_options(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0);
    rk_render_options options = small();
    scene.light_count = 0;
    test_scene_light(&scene, rk_vec(0.3f, 0.2f, -2), rk_vec(1, 1, 1));
    scene.mesh.materials[0].ks = rk_vec(0.25f, 0.25f, 0.25f);
    scene.mesh.materials[0].shininess = 9;
    const char *const names[] = {"off", "Lambert", "Phong", "Blinn-Phong"};
    for (int model = RK_SHADING_OFF; model <= RK_SHADING_BLINN_PHONG; model++) {
        options.shading.model = (rk_shading_model)model;
        test_picture picture = test_render(&scene, options, 1);
        for (size_t y = 0; y < options.height; y++)
            for (size_t x = 0; x < options.width; x++) {
                wall_point p = seen_on_wall(&options, x, y);
                double l[3] = {(double)0.3f - p.x, (double)0.2f - p.y, -3}, v[3] = {-p.x, -p.y, -4};
                double ll = sqrt(l[0] * l[0] + l[1] * l[1] + l[2] * l[2]);
                double vv = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
                double h[3], hh = 0, rv = 0, cosine = -l[2] / ll;
                for (int c = 0; c < 3; c++) {
                    double n = c == 2 ? -1 : 0;
                    h[c] = l[c] / ll + v[c] / vv;
                    hh += h[c] * h[c];
                    rv += (2 * cosine * n - l[c] / ll) * v[c] / vv;
                }
                double want = model == RK_SHADING_OFF ? 0.5 : 0.5 * cosine;
                if (model == RK_SHADING_PHONG)
                    want += 0.25 * pow(fmax(0, rv), 9);
                if (model == RK_SHADING_BLINN_PHONG)
                    want += 0.25 * pow(-h[2] / sqrt(hh), 9);
                /* The exponent multiplies the roundings of its base by 9. */
                rk_check_close(rk_image_at(&picture.image, x, y)->x, want, 1e-5, names[model]);
            }
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void glass_attenuates_the_shadow_by_the_chosen_model(void **state)
{
    (void)state;
    rk_scene scene = make_wall(2);
    rk_render_options options = small();
    scene.light_count = 0;
    test_scene_light(&scene, rk_vec(0.3f, 0.2f, -8), rk_vec(1, 1, 1));
    test_scene_wall(&scene, 2, -4, 1); /* behind the viewer */
    scene.mesh.materials[1].kd = rk_vec(1, 0.5f, 0);
    scene.mesh.materials[1].alpha = 0.5f;
    options.shadows = false;
    test_picture open = test_render(&scene, options, 1);
    options.shadows = true;
    test_picture solid = test_render(&scene, options, 1);
    options.transparency = true;
    /* kd (1 - alpha); alpha kd + (1 - alpha) of white. */
    const rk_vec3 transmittances[] = {{0.5f, 0.25f, 0}, {1, 0.75f, 0.5f}};
    for (int model = RK_GLASS_MULTIPLICATIVE; model <= RK_GLASS_ORDERED; model++) {
        options.glass = (rk_glass_model)model;
        test_picture attenuated = test_render(&scene, options, 1);
        for (size_t i = 0; i < 14 * 11; i++) {
            rk_vec3 want = rk_mul(open.image.pixels[i], transmittances[model]);
            rk_vec3 off = rk_abs3(rk_sub(attenuated.image.pixels[i], want));
            rk_check(off.x <= 1e-6f && off.y <= 1e-6f && off.z <= 1e-6f, "model %d, pixel %zu",
                     model, i);
            rk_check(rk_length(solid.image.pixels[i]) == 0, "without the option it is solid");
        }
        rk_image_free(&attenuated.image);
    }
    rk_image_free(&open.image);
    rk_image_free(&solid.image);
    rk_scene_free(&scene);
}

static void attenuated_light_never_stops_early_as_unoccluded(void **state)
{
    (void)state;
    /* Glass in front of half of the light: some samples are attenuated, the others are not. */
    rk_scene scene = make_wall(2);
    rk_render_options options = small();
    options.transparency = true;
    options.light.samples = 64;
    test_scene_quad(&scene, 2, rk_vec(-9, -9, -0.999f), rk_vec(9.3f, 0, 0), rk_vec(0, 18, 0));
    scene.mesh.triangle_materials[2] = scene.mesh.triangle_materials[3] = 1;
    scene.mesh.materials[1].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[1].alpha = 0.5f;
    scene.camera.distance = 0.5f; /* between light and wall */
    test_picture early = test_render(&scene, options, 1);
    options.light.early_out = 0;
    test_picture traced = test_render(&scene, options, 1);
    rk_check(test_same_pixels(&early.image, &traced.image),
             "attenuated light was taken for unoccluded");
    rk_image_free(&early.image);
    rk_image_free(&traced.image);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(an_unshadowed_light_is_its_mean_or_its_irradiance),
    cmocka_unit_test(a_soft_shadow_is_the_unoccluded_fraction_of_the_light),
    cmocka_unit_test(points_with_all_or_no_rays_occluded_stop_early),
    cmocka_unit_test(early_outs_leave_the_mean_as_it_is),
    cmocka_unit_test(the_ratio_estimator_is_exact_where_nothing_occludes),
    cmocka_unit_test(lights_without_extent_draw_no_samples),
    cmocka_unit_test(each_pixel_and_each_light_has_samples_of_its_own),
    cmocka_unit_test(the_shading_model_is_the_options),
    cmocka_unit_test(glass_attenuates_the_shadow_by_the_chosen_model),
    cmocka_unit_test(attenuated_light_never_stops_early_as_unoccluded),
};

RK_SUITE("parallelogram_light_stage", tests)
