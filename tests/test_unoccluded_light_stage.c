/* Points that see a whole light: the same light as by samples and shadow rays, within the error of
 * the quadrature, and to the bit where there is none; counters as proof of work not done. */
#include "test_scene.h"

#include "base/random.h"
#include "features/parallelogram_light.h"

static rk_render_options options_of(uint32_t samples, rk_light_visibility_method visibility)
{
    rk_render_options options = rk_render_options_default();
    options.width = 24;
    options.height = 18;
    options.shadows = true;
    options.light.samples = samples;
    options.light.visibility = visibility;
    return options;
}

/* A wall at z = 1 and a light of sides 1 and 0.8 at a distance from it, towards the viewer. */
static rk_scene make_wall(uint32_t more_triangles, float distance)
{
    rk_scene scene = test_scene_of(2 + more_triangles, 2);
    test_scene_wall(&scene, 0, 1, 0);
    scene.mesh.materials[0].kd = rk_vec(0.5f, 0.5f, 0.5f);
    scene.lights[scene.light_count++] =
        (rk_light){.kind = RK_LIGHT_PARALLELOGRAM,
                   .position = rk_vec(-0.2f, -0.3f, 1 - distance),
                   .edge01 = rk_vec(1, 0, 0.1f),
                   .edge02 = rk_vec(0.2f, 0.8f, 0),
                   .colours = {{1, 0, 0}, {1, 1, 0}, {0, 1, 1}, {1, 1, 1}}};
    return scene;
}

/* Two nodes of Gauss and Legendre in each cell of size 1. */
static double gauss_node(int i)
{
    return i / 2 + 0.5 + (i % 2 ? 0.5 : -0.5) / sqrt(3);
}

/* The light's contribution at a point of the wall, over a grid, in double. */
static void mean_of(const rk_light *light, bool physical, double x, double y, double mean[3])
{
    enum { cells = 50, side = 2 * cells };
    const rk_dvec3 corner = rk_widen(light->position);
    const rk_vec3 edge02 = light->kind == RK_LIGHT_SEGMENT ? rk_vec(0, 0, 0) : light->edge02;
    const rk_dvec3 a = rk_widen(light->edge01), b = rk_widen(edge02);
    const double area = rk_dlength(rk_dcross(a, b));
    const rk_dvec3 across = rk_dcross(a, b);
    mean[0] = mean[1] = mean[2] = 0;
    for (int j = 0; j < side; j++)
        for (int i = 0; i < side; i++) {
            const double u = gauss_node(i) / cells, v = gauss_node(j) / cells;
            const rk_dvec3 at = rk_dmadd(rk_dmadd(corner, a, u), b, v);
            const rk_dvec3 d = rk_dmadd(at, (rk_dvec3){x, y, 1}, -1);
            const double r = rk_dlength(d), cosine = -d.z / r;
            const double weight =
                0.5 * cosine * (physical ? fabs(rk_ddot(d, across)) / area / r * area / r / r : 1);
            const rk_vec3 *c = light->colours;
            const rk_vec3 colour =
                rk_mix(rk_mix(c[0], c[1], (float)u), rk_mix(c[2], c[3], (float)u), (float)v);
            mean[0] += weight * (double)colour.x / side / side;
            mean[1] += weight * (double)colour.y / side / side;
            mean[2] += weight * (double)colour.z / side / side;
        }
}

/* Compares the picture of the wall with the light's mean over its area. The grid errs by less than
 * 1e-8: so closely it agrees with one of four times as many cells. */
static void check_quadrature(const rk_scene *scene, bool physical, const char *what)
{
    rk_render_options options = options_of(64, RK_LIGHT_PYRAMIDS);
    options.light.falloff = physical ? RK_FALLOFF_PHYSICAL : RK_FALLOFF_NONE;
    options.light.domain = RK_LIGHT_DOMAIN_SOLID_ANGLE; /* of samples, not of nodes */
    test_picture picture = test_render(scene, options, 2);
    rk_check_equal(picture.counters.light_samples, 0, "no random samples");
    rk_check_equal(picture.counters.shadow_rays, 0, "no shadow rays");
    const double half = tan(25 * 3.14159265358979323846 / 180) * 4;
    for (uint32_t j = 0; j < options.height; j += 3)
        for (uint32_t i = 0; i < options.width; i += 3) {
            const double x =
                -(2 * (i + 0.5) / options.width - 1) * half * options.width / options.height;
            const double y = (1 - 2 * (j + 0.5) / options.height) * half;
            const rk_vec3 got = *rk_image_at(&picture.image, i, j);
            double want[3];
            mean_of(&scene->lights[0], physical, x, y, want);
            for (int c = 0; c < 3; c++)
                rk_check(fabs((double)rk_axis(got, c) - want[c]) <= 1e-4 * want[c],
                         "%s, %s falloff, pixel (%u, %u), channel %d: got %.9g, want %.9g", what,
                         physical ? "with" : "without", i, j, c, (double)rk_axis(got, c), want[c]);
        }
    rk_image_free(&picture.image);
}

/* The light is within a ball of radius 0.73 around its middle, so from 1.04 on the wall is at least
 * a quarter of an edge away; farther away, ever fewer nodes do. */
static void the_quadrature_errs_by_less_than_a_ten_thousandth(void **state)
{
    (void)state;
    const float distances[] = {1.05f, 1.35f, 1.6f, 2, 2.1f, 2.8f, 3.8f, 6};
    for (size_t k = 0; k < sizeof distances / sizeof *distances; k++)
        for (int physical = 0; physical < 2; physical++) {
            rk_scene scene = make_wall(0, distances[k]);
            check_quadrature(&scene, physical, "a light across from the wall");
            scene.lights[0].edge01 = rk_vec(0, 0, -1);
            check_quadrature(&scene, physical, "one that stands upright on it");
            scene.lights[0].kind = RK_LIGHT_SEGMENT;
            scene.lights[0].edge02 = rk_vec(9, 9, 9); /* which it has not */
            scene.lights[0].colours[2] = scene.lights[0].colours[0];
            scene.lights[0].colours[3] = scene.lights[0].colours[1];
            if (!physical)
                check_quadrature(&scene, physical, "a segment");
            rk_scene_free(&scene);
        }
}

/* What is near is the end of the longer diagonal; what is large is the second edge. */
static void the_quadrature_knows_the_shape_of_the_light(void **state)
{
    (void)state;
    for (int physical = 0; physical < 2; physical++) {
        rk_scene scene = make_wall(0, 1.3f);
        scene.lights[0].edge01 = rk_vec(0.3f, 0, 1); /* 0.3 from the wall */
        scene.lights[0].edge02 = rk_vec(0.3f, 0.1f, -1);
        check_quadrature(&scene, physical, "a sheared light");
        scene.lights[0].edge01 = rk_vec(0.1f, 0, 0);
        scene.lights[0].edge02 = rk_vec(0, 1.5f, 0);
        check_quadrature(&scene, physical, "a long one");
        rk_scene_free(&scene);
    }
}

/* The ratio of shadowed and unshadowed sums is 1, so that the closed form remains. */
static void the_ratio_of_sums_without_samples_is_one(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0, 2.1f);
    rk_render_options options = options_of(64, RK_LIGHT_RAYS);
    options.light.ratio = true;
    options.light.falloff = RK_FALLOFF_PHYSICAL;
    for (int corner = 0; corner < 4; corner++)
        scene.lights[0].colours[corner] = rk_vec(1, 1, 1);
    test_picture rays = test_render(&scene, options, 2);
    options.light.visibility = RK_LIGHT_PYRAMIDS;
    test_picture pyramids = test_render(&scene, options, 2);
    /* The closed form is multiplied by one sum and divided by the other, and both are rounded. */
    for (size_t i = 0; i < 24 * 18; i++) {
        const float want = rays.image.pixels[i].x, got = pyramids.image.pixels[i].x;
        rk_check(fabsf(got - want) <= 0x1p-22f * want, "pixel %zu: got %.9g, want %.9g", i,
                 (double)got, (double)want);
    }
    rk_check_equal(pyramids.counters.light_samples, 0, "without samples");
    rk_image_free(&rays.image);
    rk_image_free(&pyramids.image);
    rk_scene_free(&scene);
}

static uint64_t random_samples(const rk_scene *scene, uint32_t samples)
{
    test_picture picture = test_render(scene, options_of(samples, RK_LIGHT_PYRAMIDS), 2);
    rk_image_free(&picture.image);
    return picture.counters.light_samples;
}

static void the_quadrature_takes_at_most_as_many_nodes_as_samples(void **state)
{
    (void)state;
    rk_scene far = make_wall(0, 6), near = make_wall(0, 1.8f);
    rk_check_equal(random_samples(&far, 8), 24 * 18 * 8, "8 samples, 9 nodes");
    rk_check_equal(random_samples(&far, 9), 0, "9 samples, 9 nodes");
    rk_check(random_samples(&near, 15) > 0, "15 samples, 16 nodes where the wall is near");
    rk_check_equal(random_samples(&near, 16), 0, "16 samples, 16 nodes");
    rk_scene_free(&far);
    rk_scene_free(&near);
}

/* --- To the bit ------------------------------------------------------------------------------- */

/* Highlights, which are sampled at any distance. */
static void make_glossy(rk_scene *scene, rk_render_options *options)
{
    options->shading.model = RK_SHADING_PHONG;
    for (uint32_t i = 0; i < scene->mesh.material_count; i++)
        scene->mesh.materials[i].ks = rk_vec(0.1f, 0.1f, 0.1f);
    for (uint32_t i = 0; i < scene->sphere_count; i++)
        scene->sphere_materials[i].ks = rk_vec(0.1f, 0.1f, 0.1f);
}

/* Renders twice; the pictures must be equal, with fewer rays. */
static void check_same(const rk_scene *scene, rk_render_options options, const char *what)
{
    options.light.visibility = RK_LIGHT_RAYS;
    test_picture rays = test_render(scene, options, 2);
    options.light.visibility = RK_LIGHT_PYRAMIDS;
    test_picture pyramids = test_render(scene, options, 2);
    rk_check(test_same_pixels(&rays.image, &pyramids.image), "%s: the same picture", what);
    rk_check(pyramids.counters.shadow_rays < rays.counters.shadow_rays,
             "%s: %llu shadow rays, but %llu without pyramids", what,
             (unsigned long long)pyramids.counters.shadow_rays,
             (unsigned long long)rays.counters.shadow_rays);
    rk_image_free(&rays.image);
    rk_image_free(&pyramids.image);
}

static void without_the_quadrature_only_rays_are_saved(void **state)
{
    (void)state;
    const char *const names[] = {"cornell-light", "cover:1000", "plates"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        rk_scene scene = test_scene_builtin(names[k]);
        rk_render_options options = options_of(12, RK_LIGHT_PYRAMIDS);
        make_glossy(&scene, &options);
        check_same(&scene, options, names[k]);
        options.reflections = true;
        check_same(&scene, options, names[k]);
        rk_scene_free(&scene);
    }
}

static void highlights_are_sampled(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0, 2);
    scene.mesh.materials[0].ks = rk_vec(0.5f, 0.5f, 0.5f);
    for (int k = 0; k < 2; k++) {
        scene.mesh.materials[0].shininess = k ? 1e4f : 10;
        rk_render_options options = options_of(32, RK_LIGHT_PYRAMIDS);
        options.shading.model = RK_SHADING_PHONG;
        check_same(&scene, options, k ? "a sharp highlight" : "a dull highlight");
        options.shading.model = RK_SHADING_BLINN_PHONG;
        check_same(&scene, options, k ? "a sharp highlight" : "a dull highlight");
    }
    scene.mesh.materials[0].ks = rk_vec(0, 0, 0);
    rk_render_options options = options_of(64, RK_LIGHT_PYRAMIDS);
    options.shading.model = RK_SHADING_PHONG;
    test_picture picture = test_render(&scene, options, 2);
    rk_check_equal(picture.counters.light_samples, 0, "a black highlight");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* By pyramids and by rays, the largest difference of a pixel. */
static void check_sampled(const rk_scene *scene, double most, const char *what)
{
    test_picture rays = test_render(scene, options_of(64, RK_LIGHT_RAYS), 2);
    test_picture pyramids = test_render(scene, options_of(64, RK_LIGHT_PYRAMIDS), 2);
    double found = 0;
    for (size_t i = 0; i < 24 * 18; i++) {
        const rk_vec3 difference = rk_sub(rays.image.pixels[i], pyramids.image.pixels[i]);
        found = fmax(found, (double)rk_length(difference));
    }
    rk_check(found < most, "%s: pixels differ by at most %g", what, found);
    rk_check(pyramids.counters.light_samples > 64 &&
                 pyramids.counters.light_samples < rays.counters.light_samples,
             "%s: %llu samples in place of %llu", what,
             (unsigned long long)pyramids.counters.light_samples,
             (unsigned long long)rays.counters.light_samples);
    rk_image_free(&rays.image);
    rk_image_free(&pyramids.image);
}

static void a_light_across_the_horizon_or_close_by_is_sampled(void **state)
{
    (void)state;
    rk_scene wall = make_wall(0, 0.95f), box = test_scene_builtin("cornell-light");
    check_sampled(&wall, 0.01, "close by");
    box.lights[0].edge02 = rk_vec(0, -0.5f, 0);
    box.lights[0].position = rk_vec(0.1f, 0.1f, 0);
    /* 64 stratified samples of a function with a kink. */
    check_sampled(&box, 0.03, "across the room");
    rk_scene_free(&wall);
    rk_scene_free(&box);
}

/* --- Occluders -------------------------------------------------------------------------------- */

static void an_occluder_is_not_overlooked(void **state)
{
    (void)state;
    const char *const names[] = {"cornell-light", "spheres", "cornell-glass"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        rk_scene scene = test_scene_builtin(names[k]);
        rk_light *light = &scene.lights[0];
        if (light->kind == RK_LIGHT_POINT)
            *light = (rk_light){.kind = RK_LIGHT_PARALLELOGRAM,
                                .position = light->position,
                                .edge01 = rk_vec(0.2f, 0, 0),
                                .edge02 = rk_vec(0, 0, 0.2f),
                                .colours = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
        rk_render_options options = options_of(256, RK_LIGHT_RAYS);
        options.transparency = k == 2;
        test_picture rays = test_render(&scene, options, 2);
        options.light.visibility = RK_LIGHT_PYRAMIDS;
        test_picture pyramids = test_render(&scene, options, 2);
        for (size_t i = 0; i < 24 * 18; i++)
            /* Sampled with 256 of Sobol', a smooth light errs by less than 1/256; in penumbra both
             * take the same samples. */
            rk_check(rk_length(rk_sub(rays.image.pixels[i], pyramids.image.pixels[i])) <= 0.004f,
                     "%s, pixel %zu: %g by rays, %g by pyramids", names[k], i,
                     (double)rays.image.pixels[i].x, (double)pyramids.image.pixels[i].x);
        rk_check(pyramids.counters.shadow_rays > 0 &&
                     pyramids.counters.shadow_rays < rays.counters.shadow_rays / 2,
                 "%s: %llu shadow rays, %llu without pyramids", names[k],
                 (unsigned long long)pyramids.counters.shadow_rays,
                 (unsigned long long)rays.counters.shadow_rays);
        rk_image_free(&rays.image);
        rk_image_free(&pyramids.image);
        rk_scene_free(&scene);
    }
}

/* The wall is found outside by triangle tests, two for each search. */
static void neighbours_are_searched_together(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0, 2);
    rk_render_options options = options_of(16, RK_LIGHT_PYRAMIDS);
    test_picture pyramids = test_render(&scene, options, 2);
    options.shadows = false;
    test_picture unshadowed = test_render(&scene, options, 2);
    const uint64_t points = (uint64_t)options.width * options.height;
    const uint64_t tests = pyramids.counters.triangle_tests - unshadowed.counters.triangle_tests;
    rk_check(tests > 0 && tests < points / 4, "%llu triangle tests for %llu points",
             (unsigned long long)tests, (unsigned long long)points);
    rk_image_free(&unshadowed.image);
    rk_image_free(&pyramids.image);
    options = options_of(16, RK_LIGHT_PYRAMIDS);
    options.width = 5;
    options.height = 3;
    pyramids = test_render(&scene, options, 1);
    rk_check_equal(pyramids.counters.shadow_rays, 0, "the rest of the points are searched, too");
    rk_image_free(&pyramids.image);
    rk_scene_free(&scene);
}

static void without_shadows_all_points_see_the_light(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = options_of(16, RK_LIGHT_PYRAMIDS);
    options.shadows = false;
    test_picture picture = test_render(&scene, options, 2);
    rk_check_equal(picture.counters.shadow_rays, 0, "no shadow rays");
    rk_check(picture.counters.light_samples < 24 * 18 * 16 / 3,
             "and few random samples: %llu, close to the light and across horizons",
             (unsigned long long)picture.counters.light_samples);
    options.light.visibility = RK_LIGHT_RAYS;
    test_picture rays = test_render(&scene, options, 2);
    rk_check_equal(picture.counters.box_tests, rays.counters.box_tests, "and no pyramid");
    options.light.visibility = RK_LIGHT_PYRAMIDS;
    rk_image_free(&rays.image);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
    rk_scene wall = make_wall(0, 0.5f);
    wall.lights[0].edge01 = rk_vec(0, 0, 1); /* half of it is behind the wall */
    picture = test_render(&wall, options, 2);
    rk_check_equal(picture.counters.light_samples, 24 * 18 * 16,
                   "the horizon cuts the light, which is no smooth function then");
    rk_image_free(&picture.image);
    rk_scene_free(&wall);
}

/* Each corner in turn the only one in front of the wall, or the only one behind it. */
static void each_corner_of_the_light_counts(void **state)
{
    (void)state;
    for (int k = 0; k < 8; k++) {
        rk_scene scene = make_wall(0, 1);
        rk_light *light = &scene.lights[0];
        const float side = k < 4 ? 1 : -1, x = k & 1 ? -1 : 1, y = k & 2 ? -1 : 1;
        /* Corner k % 4 is at z = 1 - side, the one opposite to it at 1 + 3 side. */
        light->position = rk_vec(-x / 2, -y / 2, 1);
        light->position.z += side * (float)(-1 + (k & 1 ? 2 : 0) + (k & 2 ? 2 : 0));
        light->edge01 = rk_vec(x, 0, (k & 1 ? -2 : 2) * side);
        light->edge02 = rk_vec(0, y, (k & 2 ? -2 : 2) * side);
        rk_render_options options = options_of(16, RK_LIGHT_RAYS);
        test_picture rays = test_render(&scene, options, 2);
        options.light.visibility = RK_LIGHT_PYRAMIDS;
        test_picture pyramids = test_render(&scene, options, 2);
        rk_check(test_same_pixels(&rays.image, &pyramids.image), "corner %d, the only one %s",
                 k % 4, k < 4 ? "in front" : "behind");
        rk_image_free(&rays.image);
        rk_image_free(&pyramids.image);
        rk_scene_free(&scene);
    }
}

/* The light is above the wall, and a part of it below the horizon of its smooth normals. */
static void the_horizon_is_that_of_the_shading(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0, 2);
    rk_vec3 normals[6];
    for (int i = 0; i < 6; i++)
        normals[i] = rk_normalize(rk_vec(1, 0, -0.1f));
    scene.mesh.normals = normals;
    scene.lights[0].position = rk_vec(-4, 0, -9);
    scene.lights[0].edge01 = rk_vec(8, 0, 0);
    rk_render_options options = options_of(64, RK_LIGHT_RAYS);
    test_picture rays = test_render(&scene, options, 2);
    options.light.visibility = RK_LIGHT_PYRAMIDS;
    test_picture pyramids = test_render(&scene, options, 2);
    rk_check(test_same_pixels(&rays.image, &pyramids.image), "sampled, as the horizon cuts it");
    rk_check(pyramids.counters.shadow_rays == 0, "and clear");
    rk_image_free(&rays.image);
    rk_image_free(&pyramids.image);
    scene.mesh.normals = NULL;
    rk_scene_free(&scene);
}

static void surfaces_that_face_away_take_no_samples(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0, -2); /* behind the wall */
    test_picture picture = test_render(&scene, options_of(16, RK_LIGHT_PYRAMIDS), 2);
    rk_check_equal(picture.counters.shadow_rays, 0, "no shadow rays");
    rk_check_equal(picture.counters.light_samples, 0, "no samples");
    rk_check(rk_length(*rk_image_at(&picture.image, 9, 9)) == 0, "and no light");
    rk_image_free(&picture.image);
    rk_render_options off = options_of(16, RK_LIGHT_PYRAMIDS);
    off.shadows = false;
    for (int gradient = 0; gradient < 2; gradient++) {
        off.shading.model = gradient ? RK_SHADING_GRADIENT : RK_SHADING_OFF;
        off.shading.gradient = (rk_gradient){1, {{0, {1, 1, 1}}}};
        picture = test_render(&scene, off, 2);
        rk_check(rk_length(*rk_image_at(&picture.image, 9, 9)) > 0,
                 "%s there is no side that faces away",
                 gradient ? "with a gradient" : "without shading");
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void a_moving_object_may_come_between(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("moving");
    rk_light *light = &scene.lights[0];
    *light = (rk_light){.kind = RK_LIGHT_PARALLELOGRAM,
                        .position = light->position,
                        .edge01 = rk_vec(0.3f, 0, 0),
                        .edge02 = rk_vec(0, 0, 0.3f),
                        .colours = {{1, 1, 1}, {1, 1, 1}, {1, 1, 1}, {1, 1, 1}}};
    rk_render_options options = options_of(12, RK_LIGHT_PYRAMIDS);
    make_glossy(&scene, &options);
    check_same(&scene, options, "at rest");
    options.motion.samples = 4;
    options.motion.shutter = (rk_shutter){0, 1};
    options.light.visibility = RK_LIGHT_RAYS;
    test_picture rays = test_render(&scene, options, 2);
    options.light.visibility = RK_LIGHT_PYRAMIDS;
    test_picture pyramids = test_render(&scene, options, 2);
    rk_check(test_same_pixels(&rays.image, &pyramids.image), "in motion: the same picture");
    rk_check_equal(pyramids.counters.shadow_rays, rays.counters.shadow_rays,
                   "pyramids, which know objects only at rest, save no ray");
    rk_image_free(&rays.image);
    rk_image_free(&pyramids.image);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_quadrature_errs_by_less_than_a_ten_thousandth),
    cmocka_unit_test(the_quadrature_knows_the_shape_of_the_light),
    cmocka_unit_test(the_ratio_of_sums_without_samples_is_one),
    cmocka_unit_test(the_quadrature_takes_at_most_as_many_nodes_as_samples),
    cmocka_unit_test(without_the_quadrature_only_rays_are_saved),
    cmocka_unit_test(highlights_are_sampled),
    cmocka_unit_test(a_light_across_the_horizon_or_close_by_is_sampled),
    cmocka_unit_test(an_occluder_is_not_overlooked),
    cmocka_unit_test(neighbours_are_searched_together),
    cmocka_unit_test(without_shadows_all_points_see_the_light),
    cmocka_unit_test(each_corner_of_the_light_counts),
    cmocka_unit_test(the_horizon_is_that_of_the_shading),
    cmocka_unit_test(surfaces_that_face_away_take_no_samples),
    cmocka_unit_test(a_moving_object_may_come_between),
};

RK_SUITE("unoccluded_light_stage", tests)
