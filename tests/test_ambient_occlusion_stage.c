/* Ambient occlusion in the renderer: radiance against closed forms, with motion, glass and mirrors;
 * the number of rays; and at intensity 0 no ray and the same picture to the bit. */
#include "test_scene.h"

#include "base/dvec3.h"

static const double pi = RK_PI_DOUBLE;

/* Nothing but ambient light of the intensity 1. */
static rk_render_options ambient_only(uint32_t samples)
{
    rk_render_options options = rk_render_options_default();
    options.width = 14;
    options.height = 11;
    options.ambient_occlusion.intensity = 1;
    options.ambient_occlusion.samples = samples;
    return options;
}

/* A white floor at y = -0.5, as the triangles 0 and 1. */
static rk_scene make_floor(uint32_t triangles, uint32_t materials)
{
    rk_scene scene = test_scene_of(triangles, materials);
    test_scene_quad(&scene, 0, rk_vec(-1000, -0.5f, -1000), rk_vec(2000, 0, 0), rk_vec(0, 0, 2000));
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    return scene;
}

/* The camera's direction through the middle of a pixel. */
static rk_dvec3 pixel_direction(const rk_render_options *options, size_t x, size_t y)
{
    double half = tan(25 * pi / 180);
    double across = 2 * ((double)x + 0.5) / options->width - 1;
    double up = 1 - 2 * ((double)y + 0.5) / options->height;
    rk_dvec3 d = {-across * half * options->width / options->height, up * half, 1};
    return rk_dscale(d, 1 / rk_dlength(d));
}

/* Intersects the floor with a direction from the camera; false above the horizon. */
static bool on_floor(rk_dvec3 d, rk_dvec3 *point)
{
    *point = rk_dmadd((rk_dvec3){0, 0, -3}, d, -0.5 / d.y);
    return d.y < 0;
}

static double red_at(const test_picture *picture, size_t x, size_t y)
{
    return (double)rk_image_at(&picture->image, x, y)->x;
}

static void check_pixels(const test_picture *picture, double want, double tolerance,
                         const char *hint)
{
    for (size_t y = 0; y < picture->image.height; y++)
        for (size_t x = 0; x < picture->image.width; x++)
            rk_check_near(red_at(picture, x, y), want, tolerance, "pixel (%zu, %zu): %s", x, y,
                          hint);
}

/* 5 standard errors of independent samples, an upper bound for the other samplers. The mean square
 * of a weight is 4/3 for the uniform map; for the cosine map a sample is 0 or 1. */
static double five_standard_errors(const rk_render_options *options)
{
    double square = options->ambient_occlusion.map == RK_AMBIENT_UNIFORM ? 4.0 / 3 : 0.25;
    return 5 * sqrt(square / options->ambient_occlusion.samples);
}

/* --- Intensity 0, and other lights ------------------------------------------------------------ */

static void ambient_occlusion_is_planned_if_wanted(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell"), nothing = test_scene_make(0);
    rk_render_options options = rk_render_options_default();
    rk_check(!rk_plan_of(&scene, &options).ambient_occlusion, "planned by default");
    options.ambient_occlusion.intensity = 0.1f;
    rk_check(rk_plan_of(&scene, &options).ambient_occlusion, "not planned at intensity 0.1");
    rk_check(!rk_plan_of(&nothing, &options).rays, "rays planned without a surface");
    scene.light_count = 0;
    rk_check(rk_plan_of(&scene, &options).rays, "no rays planned for ambient light alone");
    options.ambient_occlusion.intensity = 0;
    rk_check(!rk_plan_of(&scene, &options).rays, "rays planned without any light");
    rk_scene_free(&scene);
    rk_scene_free(&nothing);
}

static void intensity_0_traces_no_ray_and_changes_no_bit(void **state)
{
    (void)state;
    const char *const names[] = {"cornell", "spheres", "moving", "cornell-glass"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        rk_render_options options = rk_render_options_default();
        options.width = options.height = 40;
        options.samples = 2;
        options.reflections = options.transparency = i > 0;
        options.motion.samples = 4;
        test_picture usual = test_render(&scene, options, 2);
        options.ambient_occlusion.samples = 1000;
        options.ambient_occlusion.map = RK_AMBIENT_UNIFORM;
        test_picture off = test_render(&scene, options, 2);
        rk_check(test_same_pixels(&usual.image, &off.image), "%s: not the same to the bit",
                 names[i]);
        rk_check_equal(off.counters.shadow_rays, 0,
                       "shadow rays without shadows and ambient light");
        rk_check(memcmp(&usual.counters, &off.counters, sizeof off.counters) == 0,
                 "%s: counters differ, %llu box tests at intensity 0, %llu by default", names[i],
                 (unsigned long long)off.counters.box_tests,
                 (unsigned long long)usual.counters.box_tests);
        rk_image_free(&usual.image);
        rk_image_free(&off.image);
        rk_scene_free(&scene);
    }
}

static void ambient_light_does_not_change_light_samples(void **state)
{
    (void)state;
    /* Random numbers of features are independent, so the pictures of two lights add up. */
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = ambient_only(4);
    options.width = options.height = 40;
    options.shadows = true;
    options.reflections = true;
    options.glossy.samples = 2;
    test_picture both = test_render(&scene, options, 2);
    options.ambient_occlusion.intensity = 0;
    test_picture light = test_render(&scene, options, 2);
    options.ambient_occlusion.intensity = 1;
    scene.light_count = 0;
    test_picture ambient = test_render(&scene, options, 2);
    for (size_t i = 0; i < 1600; i++)
        rk_check_near(both.image.pixels[i].x,
                      (double)light.image.pixels[i].x + (double)ambient.image.pixels[i].x, 1e-4,
                      "pixel %zu: both lights together", i);
    rk_check_equal(both.counters.light_samples, light.counters.light_samples, "of the light");
    rk_check_equal(both.counters.shadow_rays,
                   light.counters.shadow_rays + ambient.counters.shadow_rays, "rays of both");
    rk_image_free(&both.image);
    rk_image_free(&light.image);
    rk_image_free(&ambient.image);
    rk_scene_free(&scene);
}

/* --- Radiance --------------------------------------------------------------------------------- */

static void one_unoccluded_sample_gives_the_diffuse_colour(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, 1, 0);
    rk_render_options options = ambient_only(1);
    options.ambient_occlusion.intensity = 0.5f;
    test_picture picture = test_render(&scene, options, 2);
    check_pixels(&picture, 0.4, 1e-7, "0.5 of 0.8, and no noise");
    rk_check_equal(picture.counters.shadow_rays, 14 * 11, "one ray per pixel");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void check_sphere(rk_sampler_kind sampling, rk_ambient_map map)
{
    rk_scene scene = make_floor(2, 1);
    scene.spheres[0] = (rk_sphere){rk_vec(0, 0, 0.5f), 0.4f};
    scene.sphere_materials[0] = scene.mesh.materials[0];
    scene.sphere_count = 1;
    rk_render_options options = ambient_only(4096);
    options.width = 28;
    options.height = 22;
    options.ambient_occlusion.sampling = sampling;
    options.ambient_occlusion.map = map;
    test_picture picture = test_render(&scene, options, 2);
    rk_dvec3 eye = {0, 0, -3.5}; /* from the sphere's centre */
    int dark = 0, ball = 0;
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++) {
            rk_dvec3 d = pixel_direction(&options, x, y), p;
            double half = rk_ddot(eye, d), discriminant = half * half - rk_ddot(eye, eye) + 0.16,
                   want = 0;
            if (discriminant > 0) { /* on the sphere, (1 + n_y) / 2 is unoccluded */
                want = (1 + rk_dmadd(eye, d, -half - sqrt(discriminant)).y / 0.4) / 2;
                ball++;
            } else if (on_floor(d, &p)) {
                double distance = hypot(hypot(p.x, p.z - 0.5), 0.5);
                want = 1 - 0.5 / distance * 0.16 / (distance * distance);
                dark += want < 0.9;
            }
            rk_check_near(red_at(&picture, x, y), want, five_standard_errors(&options),
                          "pixel (%zu, %zu), map %d, sampler %d: the closed form", x, y, (int)map,
                          (int)sampling);
        }
    rk_check(ball > 20 && dark > 8, "%d pixels show the sphere, %d dark floor", ball, dark);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void a_sphere_and_its_floor_agree_with_closed_forms(void **state)
{
    (void)state;
    for (int sampling = RK_SAMPLER_UNIFORM; sampling <= RK_SAMPLER_LOW_DISCREPANCY; sampling++)
        for (int map = RK_AMBIENT_UNIFORM; map <= RK_AMBIENT_COSINE; map++)
            check_sphere((rk_sampler_kind)sampling, (rk_ambient_map)map);
}

/* A wall at x = 1, in the left of the picture, one unit high. */
static rk_scene make_wall(void)
{
    rk_scene scene = make_floor(4, 1);
    test_scene_quad(&scene, 2, rk_vec(1, -0.5f, -1000), rk_vec(0, 1, 0), rk_vec(0, 0, 2000));
    return scene;
}

static void a_wall_darkens_the_floor_beside_it(void **state)
{
    (void)state;
    rk_scene scene = make_wall();
    rk_render_options options = ambient_only(4096);
    test_picture picture = test_render(&scene, options, 2);
    int seen = 0;
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++) {
            rk_dvec3 p;
            if (!on_floor(pixel_direction(&options, x, y), &p) || p.x >= 1)
                continue;
            double want = (1 + (1 - p.x) / hypot(1 - p.x, 1)) / 2;
            rk_check_near(red_at(&picture, x, y), want, five_standard_errors(&options),
                          "pixel (%zu, %zu), %g from the wall", x, y, 1 - p.x);
            seen++;
        }
    rk_check(seen > 40, "only %d pixels show the floor beside the wall", seen);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void rays_end_at_the_ambient_distance(void **state)
{
    (void)state;
    /* A wall, and another one behind the camera, 4 units away: a ray of length D intersects it if
     * its cosine is above 4 / D, so A is (4 / D)^2. Without the square it were off by 0.1 and
     * more, twice the tolerance. */
    rk_scene scene = test_scene_make(4);
    test_scene_quad(&scene, 0, rk_vec(-1000, -1000, 0), rk_vec(2000, 0, 0), rk_vec(0, 2000, 0));
    test_scene_quad(&scene, 2, rk_vec(-1000, -1000, -4), rk_vec(2000, 0, 0), rk_vec(0, 2000, 0));
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    rk_render_options options = ambient_only(1024);
    const float distances[] = {3.99f, 4.5f, 5, 8, 80};
    for (int i = 0; i < 5; i++) {
        options.ambient_occlusion.distance = distances[i];
        test_picture picture = test_render(&scene, options, 2);
        double reach = (double)distances[i];
        check_pixels(&picture, reach < 4 ? 1 : 16 / (reach * reach),
                     reach < 4 ? 0 : five_standard_errors(&options),
                     "the fraction of the hemisphere that is farther away");
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void a_face_occludes_directions_below_it(void **state)
{
    (void)state;
    /* Shading normals at 60 degrees to the face, which occludes (1 - cos 60) / 2 without a ray. */
    rk_scene scene = {.name = "tilted", .camera = {.distance = 3, .fov = 50}};
    rk_error error;
    rk_check_ok(rk_mesh_init(&scene.mesh, 6, 2, 1, RK_MESH_NORMALS, &error), error);
    test_scene_quad(&scene, 0, rk_vec(-10, -10, 1), rk_vec(20, 0, 0), rk_vec(0, 20, 0));
    for (uint32_t i = 0; i < 6; i++) {
        scene.mesh.triangles[i / 3][i % 3] = i;
        scene.mesh.normals[i] = rk_vec(0, sinf(RK_PI / 3), -cosf(RK_PI / 3));
    }
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    rk_render_options options = ambient_only(4096);
    test_picture picture = test_render(&scene, options, 2);
    check_pixels(&picture, 0.75, five_standard_errors(&options), "(1 + cos 60) / 2");
    /* 5 standard errors of the independent samples of all pixels. */
    double rays = 14 * 11 * 4096;
    rk_check_close((double)picture.counters.shadow_rays / rays, 0.75, 5 * 0.5 / sqrt(rays),
                   "rays into the surface are not traced");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* --- Motion, glass, mirrors ------------------------------------------------------------------- */

static void a_moving_wall_occludes_for_a_fraction_of_the_time(void **state)
{
    (void)state;
    rk_scene scene = make_wall();
    scene.moving[0] = (rk_moving){2, 2, {0, 0, 0}}; /* at x along the x axis at time x */
    scene.moving_count = 1;
    rk_render_options options = ambient_only(64);
    options.motion.samples = 64;
    options.motion.shutter = (rk_shutter){0, 2};
    test_picture picture = test_render(&scene, options, 2);
    int seen = 0;
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++) {
            rk_dvec3 p;
            if (!on_floor(pixel_direction(&options, x, y), &p) || p.x >= 1)
                continue;
            double from = 1 - p.x, want = (1 + (hypot(from + 2, 1) - hypot(from, 1)) / 2) / 2;
            /* 64 x 64 samples of 0 or 1. */
            rk_check_near(red_at(&picture, x, y), want, 5 * 0.5 / 64,
                          "pixel (%zu, %zu): the mean of the closed form, %g to %g from the wall",
                          x, y, from, from + 2);
            seen++;
        }
    rk_check(seen > 40 && picture.counters.time_samples > 0, "%d pixels, %llu times", seen,
             (unsigned long long)picture.counters.time_samples);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* A floor below an endless slab of glass, from y = 1 to y = 1.5. */
static rk_scene make_glass_slab(void)
{
    rk_scene scene = make_floor(6, 2);
    test_scene_quad(&scene, 2, rk_vec(-1e5f, 1, -1e5f), rk_vec(2e5f, 0, 0), rk_vec(0, 0, 2e5f));
    test_scene_quad(&scene, 4, rk_vec(-1e5f, 1.5f, -1e5f), rk_vec(0, 0, 2e5f), rk_vec(2e5f, 0, 0));
    for (uint32_t i = 2; i < 6; i++)
        scene.mesh.triangle_materials[i] = 1;
    scene.mesh.materials[1] =
        (rk_material){.kd = rk_vec(1, 0.5f, 0), .alpha = 0.25f, .absorption = rk_vec(1, 2, 0)};
    return scene;
}

static void check_floor(const test_picture *picture, const rk_render_options *options,
                        rk_dvec3 want, double tolerance, const char *hint)
{
    for (size_t y = 0; y < options->height; y++)
        for (size_t x = 0; x < options->width; x++) {
            rk_vec3 got = *rk_image_at(&picture->image, x, y);
            if (pixel_direction(options, x, y).y >= -0.05)
                continue;
            rk_check_near(got.x, want.x, tolerance, "red of pixel (%zu, %zu): %s", x, y, hint);
            rk_check_near(got.y, want.y, tolerance, "green of pixel (%zu, %zu): %s", x, y, hint);
            rk_check_near(got.z, want.z, tolerance, "blue of pixel (%zu, %zu): %s", x, y, hint);
        }
}

/* 2 integral of exp(-sigma thickness / mu) mu dmu over [0, 1]. */
static double slab_transmittance(double depth)
{
    enum { steps = 20000 };
    double sum = 0;
    for (int i = 0; i < steps; i++) {
        double mu = (i + 0.5) / steps;
        sum += 2 * mu * exp(-depth / mu) / steps;
    }
    return sum;
}

static void glass_attenuates_ambient_light(void **state)
{
    (void)state;
    rk_scene scene = make_glass_slab();
    rk_render_options options = ambient_only(1024);
    test_picture opaque = test_render(&scene, options, 2);
    check_floor(&opaque, &options, (rk_dvec3){0, 0, 0}, 1e-3,
                "without --transparency the glass occludes");
    options.transparency = true;
    options.glass = RK_GLASS_MULTIPLICATIVE;
    test_picture tinted = test_render(&scene, options, 2);
    check_floor(&tinted, &options, (rk_dvec3){0.5625, 0.140625, 0}, 1e-3,
                "two faces, (0.75 kd)^2 in every direction");
    options.glass = RK_GLASS_BEER_LAMBERT;
    test_picture absorbed = test_render(&scene, options, 2);
    check_floor(&absorbed, &options, (rk_dvec3){slab_transmittance(0.5), slab_transmittance(1), 1},
                five_standard_errors(&options), "slanting rays have longer paths in the glass");
    rk_image_free(&opaque.image);
    rk_image_free(&tinted.image);
    rk_image_free(&absorbed.image);
    rk_scene_free(&scene);
}

static void mirrors_reflect_it_and_black_surfaces_trace_no_rays(void **state)
{
    (void)state;
    rk_scene scene = test_scene_of(4, 2);
    test_scene_wall(&scene, 0, 1, 0);
    test_scene_quad(&scene, 2, rk_vec(-99, -99, -6), rk_vec(198, 0, 0), rk_vec(0, 198, 0));
    scene.mesh.triangle_materials[2] = scene.mesh.triangle_materials[3] = 1;
    scene.mesh.materials[0].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[0].ks = rk_vec(0.5f, 0.5f, 0.5f);
    rk_render_options options = ambient_only(4);
    options.ambient_occlusion.distance = 1; /* shorter than the distance of the mirror */
    options.reflections = true;
    test_picture picture = test_render(&scene, options, 2);
    check_pixels(&picture, 0.4, 1e-6, "half of the wall behind the camera, 0.8");
    rk_check_equal(picture.counters.shadow_rays, 14 * 11 * 4,
                   "from the wall alone: the mirror's diffuse colour is black");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* --- Order, samples --------------------------------------------------------------------------- */

static void threads_do_not_change_a_bit(void **state)
{
    (void)state;
    const char *const names[] = {"cornell", "moving", "cornell-glass"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        rk_render_options options = ambient_only(7); /* batches end within a point's samples */
        options.width = 50;
        options.height = 37;
        options.samples = 2;
        options.reflections = options.transparency = true;
        options.glossy.samples = 3;
        options.motion.samples = 4;
        test_picture one = test_render(&scene, options, 1);
        test_picture five = test_render(&scene, options, 5);
        rk_check(test_same_pixels(&one.image, &five.image), "%s: 1 and 5 threads differ", names[i]);
        rk_check_equal(one.counters.shadow_rays, five.counters.shadow_rays, names[i]);
        rk_image_free(&one.image);
        rk_image_free(&five.image);
        rk_scene_free(&scene);
    }
}

static void pixel_samples_and_ambient_samples_multiply(void **state)
{
    (void)state;
    /* A pixel with a narrow field of view: its 64 x 64 samples agree with the form at its centre.
     */
    rk_scene scene = make_wall();
    rk_render_options options = ambient_only(64);
    options.width = options.height = 1;
    options.samples = 64;
    scene.camera.rotation = rk_vec(30, 0, 0);
    scene.camera.look_at = rk_vec(0, -0.5f, 0);
    scene.camera.fov = 0.01f;
    test_picture picture = test_render(&scene, options, 1);
    rk_check_equal(picture.counters.shadow_rays, 4096,
                   "64 directions for each of 64 pixel samples");
    rk_check_close(red_at(&picture, 0, 0), (1 + sqrt(0.5)) / 2, 5 * 0.5 / 64,
                   "one unit from a wall that is one unit high");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void ambient_samples_and_light_samples_do_not_multiply(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = ambient_only(1 << 20);
    rk_error error;
    options.light.samples = 1 << 20;
    options.samples = 16;
    rk_check_ok(rk_render_check(&scene, &options, &error), error);
    options.samples = 17;
    rk_check(!rk_render_check(&scene, &options, &error), "17 x 2^20 samples accepted");
    rk_check_error_names(error, "16777216 samples");
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(ambient_occlusion_is_planned_if_wanted),
    cmocka_unit_test(intensity_0_traces_no_ray_and_changes_no_bit),
    cmocka_unit_test(ambient_light_does_not_change_light_samples),
    cmocka_unit_test(one_unoccluded_sample_gives_the_diffuse_colour),
    cmocka_unit_test(a_sphere_and_its_floor_agree_with_closed_forms),
    cmocka_unit_test(a_wall_darkens_the_floor_beside_it),
    cmocka_unit_test(rays_end_at_the_ambient_distance),
    cmocka_unit_test(a_face_occludes_directions_below_it),
    cmocka_unit_test(a_moving_wall_occludes_for_a_fraction_of_the_time),
    cmocka_unit_test(glass_attenuates_ambient_light),
    cmocka_unit_test(mirrors_reflect_it_and_black_surfaces_trace_no_rays),
    cmocka_unit_test(threads_do_not_change_a_bit),
    cmocka_unit_test(pixel_samples_and_ambient_samples_multiply),
    cmocka_unit_test(ambient_samples_and_light_samples_do_not_multiply),
};

RK_SUITE("ambient_occlusion_stage", tests)
