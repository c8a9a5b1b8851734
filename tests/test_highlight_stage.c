/* Sharp highlights of lights with an extent in the renderer: without bias against an integral over
 * the lobe in double, how much less noisy than by samples on the light alone, and nothing drawn
 * where nothing is sharp. */
#include "test_scene.h"

static const double pi = RK_PI_DOUBLE;

enum { width = 12, height = 10, pixels = width * height };

/* A light at z = -1 of the sides `size` and 0.8 `size`, its middle a little beside the axis, and a
 * wall at z = 1 that shows nothing but highlights. */
static rk_scene make_wall(float shininess, float size)
{
    rk_scene scene = test_scene_of(4, 1);
    scene.camera.fov = 24;
    test_scene_wall(&scene, 0, 1, 0);
    scene.mesh.materials[0].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[0].ks = rk_vec(0.5f, 0.5f, 0.5f);
    scene.mesh.materials[0].shininess = shininess;
    rk_vec3 white = rk_vec(1, 1, 1);
    scene.lights[scene.light_count++] =
        (rk_light){.kind = RK_LIGHT_PARALLELOGRAM,
                   .position = rk_vec(0.1f - 0.5f * size, 0.05f - 0.4f * size, -1),
                   .edge01 = rk_vec(size, 0, 0),
                   .edge02 = rk_vec(0, 0.8f * size, 0),
                   .colours = {white, white, white, white}};
    return scene;
}

/* A half-plane shortly before the light, on 0.95 of the way to it, which occludes x below `left`.
 */
static void occlude(rk_scene *scene, float left)
{
    test_scene_quad(scene, 2, rk_vec(left, -9, -0.9f), rk_vec(-18, 0, 0), rk_vec(0, 18, 0));
}

static rk_render_options small(rk_shading_model model)
{
    rk_render_options options = rk_render_options_default();
    options.width = width;
    options.height = height;
    options.reflections = false;
    options.shadows = true;
    options.shading.model = model;
    options.light.falloff = RK_FALLOFF_PHYSICAL;
    options.light.samples = 16;
    options.light.highlights = RK_HIGHLIGHT_BALANCE;
    return options;
}

static const char *model_name(const rk_render_options *options)
{
    return options->shading.model == RK_SHADING_PHONG ? "Phong" : "Blinn-Phong";
}

/* --- The integral over the lobe -------------------------------------------------------------- */

static rk_dvec3 unit(rk_dvec3 a)
{
    return rk_dscale(a, 1 / rk_dlength(a));
}

/* The point of the wall that the middle of a pixel shows. */
static rk_dvec3 seen(size_t x, size_t y)
{
    double half = tan(12 * pi / 180) * 4;
    double across = 2 * ((double)x + 0.5) / width - 1, up = 1 - 2 * ((double)y + 0.5) / height;
    return (rk_dvec3){-across * half * width / height, up * half, 1};
}

/* The light along l, unit, from p: 1 where it is visible, times the density of its points if
 * colours do not fall off; left: of the occluder, or below -9. */
static double light_along(const rk_scene *scene, rk_dvec3 p, rk_dvec3 l, bool physical, double left)
{
    const rk_light *light = &scene->lights[0];
    double t = -2 / l.z, x = p.x + t * l.x - (double)light->position.x;
    double y = p.y + t * l.y - (double)light->position.y;
    double wide = (double)light->edge01.x, high = (double)light->edge02.y;
    if (l.z >= 0 || x < 0 || x > wide || y < 0 || y > high || p.x + 0.95 * t * l.x < left)
        return 0;
    return physical ? 1 : t * t / (wide * high * -l.z);
}

/* The highlight at p, by the midpoint rule over u^(s + 1) and the angle around the lobe's axis, so
 * that the lobe itself is 1 in each cell. */
static double highlight_at(const rk_scene *scene, const rk_render_options *options, rk_dvec3 p,
                           double left)
{
    enum { rings = 200, sectors = 80 };
    rk_dvec3 around[2 * sectors]; /* every second ring is turned by half a sector */
    const rk_material *material = &scene->mesh.materials[0];
    double s = (double)material->shininess, sum = 0;
    bool phong = options->shading.model == RK_SHADING_PHONG;
    rk_dvec3 n = {0, 0, -1}, v = unit((rk_dvec3){-p.x, -p.y, -3 - p.z});
    rk_dvec3 axis = phong ? rk_dmadd(rk_dscale(n, 2 * rk_ddot(n, v)), v, -1) : n;
    rk_dvec3 side = unit((rk_dvec3){axis.z, 0, -axis.x});
    rk_dvec3 other = rk_dcross(axis, side);
    for (int i = 0; i < 2 * sectors; i++)
        around[i] = rk_dmadd(rk_dscale(side, cos(pi * i / sectors)), other, sin(pi * i / sectors));
    for (int ring = 0; ring < rings; ring++) {
        double exponent = log((ring + 0.5) / rings) / (s + 1), cosine = exp(exponent);
        double sine = sqrt(-expm1(2 * exponent));
        for (int sector = 0; sector < sectors; sector++) {
            rk_dvec3 l = rk_dmadd(rk_dscale(axis, cosine), around[2 * sector + ring % 2], sine);
            double jacobian = 1;
            if (!phong) {
                jacobian = 4 * rk_ddot(v, l);
                l = rk_dmadd(rk_dscale(l, 2 * rk_ddot(v, l)), v, -1);
            }
            if (jacobian > 0)
                sum += jacobian * light_along(scene, p, l,
                                              options->light.falloff == RK_FALLOFF_PHYSICAL, left);
        }
    }
    return (double)material->ks.x * sum / rings / sectors * 2 * pi / (s + 1);
}

/* Of all pixels; black where the occluder is in front of the wall. */
static void integrate(const rk_scene *scene, const rk_render_options *options, double left,
                      double *want)
{
    for (size_t i = 0; i < pixels; i++) {
        rk_dvec3 p = seen(i % width, i / width);
        want[i] = p.x * 2.1 / 4 < left + 1e-3 ? 0 : highlight_at(scene, options, p, left);
    }
}

/* --- No bias --------------------------------------------------------------------------------- */

/* Means of pictures with `seeds` seeds, and of their squares, of the sums of `blocks` parts of the
 * picture. */
enum { blocks = 4, seeds = 40 };

static int block_of(size_t i)
{
    return (i % width < width / 2) + 2 * (i / width < height / 2);
}

static void check_unbiased(const rk_scene *scene, rk_render_options options, double left,
                           const char *what)
{
    double want[pixels], sums[blocks] = {0}, mean[blocks] = {0}, square[blocks] = {0};
    integrate(scene, &options, left, want);
    for (size_t i = 0; i < pixels; i++)
        sums[block_of(i)] += want[i];
    for (uint32_t seed = 1; seed <= seeds; seed++) {
        double got[blocks] = {0};
        options.seed = seed;
        test_picture picture = test_render(scene, options, 1);
        for (size_t i = 0; i < pixels; i++)
            got[block_of(i)] += want[i] > 0 ? (double)picture.image.pixels[i].x : 0;
        rk_check(picture.counters.lobe_samples > 0, "no directions were drawn");
        for (int k = 0; k < blocks; k++) {
            mean[k] += got[k] / seeds;
            square[k] += got[k] * got[k] / seeds;
        }
        rk_image_free(&picture.image);
    }
    for (int k = 0; k < blocks; k++) {
        if (sums[k] == 0) /* behind the occluder */
            continue;
        double error = sqrt(fmax(square[k] - mean[k] * mean[k], 0) / (seeds - 1));
        /* Five standard errors; and the integral's: an edge crosses a ring's cells, 1 of 80, in
         * 200 rings and 30 pixels, at random: 2e-4 and less. */
        double tolerance = 5 * error + 4e-4 * sums[k];
        rk_check(
            fabs(mean[k] - sums[k]) <= tolerance,
            "%s, shininess %g, quarter %d of the picture: got %.7g on average, want %.7g within "
            "%.2g",
            what, (double)scene->mesh.materials[0].shininess, k, mean[k], sums[k], tolerance);
        rk_check(error < 0.03 * sums[k], "%s: too noisy to tell: %g of %g", what, error, sums[k]);
    }
}

static void weighted_highlights_have_no_bias(void **state)
{
    (void)state;
    const float shininess[] = {300, 1e4f, 1e5f};
    for (int k = 0; k < 2 * 3 * 3; k++) {
        rk_render_options options = small(k % 2 ? RK_SHADING_BLINN_PHONG : RK_SHADING_PHONG);
        rk_scene scene = make_wall(shininess[k / 2 % 3], 1.5f);
        options.light.falloff = k / 6 ? RK_FALLOFF_PHYSICAL : RK_FALLOFF_NONE;
        options.light.domain = k / 6 == 2 ? RK_LIGHT_DOMAIN_SOLID_ANGLE : RK_LIGHT_DOMAIN_AREA;
        check_unbiased(&scene, options, -9, model_name(&options));
        rk_scene_free(&scene);
    }
}

static void a_highlight_ends_at_the_shadow(void **state)
{
    (void)state;
    for (float shininess = 300; shininess < 4e4f; shininess *= 100) {
        rk_render_options options = small(RK_SHADING_PHONG);
        rk_scene scene = make_wall(shininess, 1.5f);
        occlude(&scene, -0.2f);
        check_unbiased(&scene, options, -0.2, "behind half of a plane");
        rk_scene_free(&scene);
    }
}

/* --- Less noise ------------------------------------------------------------------------------ */

static double error_of(const rk_scene *scene, rk_render_options options, const double *want)
{
    double sum = 0;
    for (options.seed = 1; options.seed <= 8; options.seed++) {
        test_picture picture = test_render(scene, options, 1);
        for (size_t i = 0; i < pixels; i++) {
            double off = (double)picture.image.pixels[i].x - want[i];
            sum += off * off;
        }
        rk_image_free(&picture.image);
    }
    return sqrt(sum / pixels / 8);
}

/* The error with samples on the light alone over the error with directions, too, if there are any;
 * then there are as many of the former as otherwise of both. */
static double gain(const rk_scene *scene, rk_render_options options)
{
    double want[pixels];
    integrate(scene, &options, -9, want);
    double balanced = error_of(scene, options, want);
    test_picture picture = test_render(scene, options, 1);
    if (picture.counters.lobe_samples > 0)
        options.light.samples += options.light.samples / 2;
    rk_image_free(&picture.image);
    options.light.highlights = RK_HIGHLIGHT_LIGHT;
    return error_of(scene, options, want) / balanced;
}

/* Along the normal a lobe of Blinn-Phong is as wide as one of Phong with a quarter of its
 * shininess. */
static void sharp_highlights_have_far_less_noise(void **state)
{
    (void)state;
    const double shininess[] = {1e3, 1e4, 1e5}, least[] = {4, 20, 80};
    for (int k = 0; k < 2 * 3; k++) {
        rk_render_options options = small(k % 2 ? RK_SHADING_BLINN_PHONG : RK_SHADING_PHONG);
        double s = shininess[k / 2] * (k % 2 ? 4 : 1);
        rk_scene scene = make_wall((float)s, 1.5f);
        double got = gain(&scene, options);
        rk_check(got > least[k / 2],
                 "%s, shininess %g: %.3g times less error than by the light's samples alone, want "
                 "at least %g times",
                 model_name(&options), s, got, least[k / 2]);
        rk_scene_free(&scene);
    }
}

static void broad_highlights_do_not_get_noisier(void **state)
{
    (void)state;
    const float shininess[] = {1, 10, 30, 100}, sizes[] = {0.2f, 1, 1.3f, 4};
    for (int k = 0; k < 2 * 4 * 4; k++) {
        rk_render_options options = small(k % 2 ? RK_SHADING_BLINN_PHONG : RK_SHADING_PHONG);
        rk_scene scene = make_wall(shininess[k / 2 % 4], sizes[k / 8]);
        double got = gain(&scene, options);
        rk_check(got > 1 / 1.1, "model %d, shininess %g, light of size %g: error over %.3g", k % 2,
                 (double)shininess[k / 2 % 4], (double)sizes[k / 8], got);
        rk_scene_free(&scene);
    }
}

/* --- Work that is not done ------------------------------------------------------------------- */

static void check_nothing_drawn(const rk_scene *scene, rk_render_options options, const char *why)
{
    test_picture balance = test_render(scene, options, 1);
    options.light.highlights = RK_HIGHLIGHT_LIGHT;
    test_picture light = test_render(scene, options, 1);
    rk_check_equal(balance.counters.lobe_samples, 0, why);
    rk_check_equal(balance.counters.shadow_rays, light.counters.shadow_rays, why);
    rk_check(test_same_pixels(&balance.image, &light.image), "%s", why);
    rk_image_free(&balance.image);
    rk_image_free(&light.image);
}

static void no_directions_are_drawn_where_nothing_is_sharp(void **state)
{
    (void)state;
    rk_render_options options = small(RK_SHADING_PHONG);
    rk_scene scene = make_wall(1e4f, 1.5f);
    rk_check(rk_plan_of(&scene, &options).sharp_highlights, "this is a sharp highlight");
    check_nothing_drawn(&scene, small(RK_SHADING_LAMBERT), "Lambert's law has no highlight");
    scene.mesh.materials[0].ks = rk_vec(0, 0, 0);
    check_nothing_drawn(&scene, options, "ks is black");
    scene.mesh.materials[0].ks = rk_vec(1, 1, 1);
    scene.mesh.materials[0].shininess = 20;
    check_nothing_drawn(&scene, options, "the lobe is broader than the light");
    scene.mesh.materials[0].shininess = 2;
    rk_check(!rk_plan_of(&scene, &options).sharp_highlights,
             "no light is large enough for so broad a lobe");
    scene.mesh.materials[0].shininess = 1e4f;
    scene.lights[0].position.x += 3;
    check_nothing_drawn(&scene, options, "no pixel shows the light's mirror image");
    scene.lights[0].position.x -= 3;
    scene.lights[0].kind = RK_LIGHT_SEGMENT;
    check_nothing_drawn(&scene, options, "no direction hits a segment");
    scene.lights[0].kind = RK_LIGHT_POINT;
    check_nothing_drawn(&scene, options, "no direction hits a point");
    rk_scene_free(&scene);
}

static void only_directions_that_hit_the_light_send_shadow_rays(void **state)
{
    (void)state;
    rk_render_options options = small(RK_SHADING_PHONG);
    rk_scene scene = make_wall(1e4f, 1.5f);
    test_picture picture = test_render(&scene, options, 1);
    uint64_t points = picture.counters.lobe_samples / 8;
    rk_check_equal(picture.counters.lobe_samples % 8, 0, "half as many as on the light");
    rk_check(points > pixels / 5 && points < pixels / 2,
             "directions at %u of 120 points: only near the mirror image", (uint32_t)points);
    uint64_t more = picture.counters.shadow_rays;
    options.light.highlights = RK_HIGHLIGHT_LIGHT;
    test_picture light = test_render(&scene, options, 1);
    more -= light.counters.shadow_rays;
    rk_check(more > pixels / 2 && more < 3 * pixels,
             "%u more shadow rays: the light's mirror image fills a seventh of the picture",
             (uint32_t)more);
    options.shadows = false;
    test_picture none = test_render(&scene, options, 1);
    rk_check_equal(none.counters.shadow_rays, 0, "none without shadows");
    rk_check(more < picture.counters.lobe_samples, "some directions miss the light");
    rk_image_free(&picture.image);
    rk_image_free(&light.image);
    rk_image_free(&none.image);
    rk_scene_free(&scene);
}

/* Blinn-Phong's half vectors turn half as far as the direction to the light. */
static void both_models_draw_directions_around_the_mirror_image_alike(void **state)
{
    (void)state;
    uint64_t points[2];
    for (int k = 0; k < 2; k++) {
        rk_render_options options = small(k ? RK_SHADING_BLINN_PHONG : RK_SHADING_PHONG);
        rk_scene scene = make_wall(k ? 4003 : 1000, 0.5f);
        test_picture picture = test_render(&scene, options, 1);
        points[k] = picture.counters.lobe_samples / 8;
        rk_image_free(&picture.image);
        rk_scene_free(&scene);
    }
    rk_check(points[0] > 0 && points[0] < pixels / 2, "Phong: at %u points", (uint32_t)points[0]);
    rk_check_equal(points[1], points[0], "lobes of the same width");
}

static void without_occluders_shadow_rays_change_nothing(void **state)
{
    (void)state;
    rk_render_options options = small(RK_SHADING_BLINN_PHONG);
    rk_scene scene = make_wall(1e3f, 1.5f);
    test_picture shadows = test_render(&scene, options, 1);
    options.shadows = false;
    test_picture none = test_render(&scene, options, 3);
    rk_check(test_same_pixels(&shadows.image, &none.image),
             "the same samples, in the same order, for any number of threads");
    rk_image_free(&shadows.image);
    rk_image_free(&none.image);
    rk_scene_free(&scene);
}

static void diffuse_light_takes_the_light_s_samples_alone(void **state)
{
    (void)state;
    rk_render_options options = small(RK_SHADING_PHONG);
    options.light.visibility = RK_LIGHT_RAYS; /* without highlights, others take no samples */
    rk_scene scene = make_wall(1e4f, 1.5f);
    test_picture highlight = test_render(&scene, options, 1);
    scene.mesh.materials[0].kd = rk_vec(0.5f, 0.5f, 0.5f);
    test_picture both = test_render(&scene, options, 1);
    options.shading.model = RK_SHADING_LAMBERT;
    test_picture diffuse = test_render(&scene, options, 1);
    for (size_t i = 0; i < pixels; i++) {
        double want = (double)diffuse.image.pixels[i].x + (double)highlight.image.pixels[i].x;
        rk_check_close(both.image.pixels[i].x, want, 24 * 0x1p-23 * want, "the sum of both parts");
    }
    rk_image_free(&highlight.image);
    rk_image_free(&both.image);
    rk_image_free(&diffuse.image);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(weighted_highlights_have_no_bias),
    cmocka_unit_test(a_highlight_ends_at_the_shadow),
    cmocka_unit_test(sharp_highlights_have_far_less_noise),
    cmocka_unit_test(broad_highlights_do_not_get_noisier),
    cmocka_unit_test(no_directions_are_drawn_where_nothing_is_sharp),
    cmocka_unit_test(only_directions_that_hit_the_light_send_shadow_rays),
    cmocka_unit_test(both_models_draw_directions_around_the_mirror_image_alike),
    cmocka_unit_test(without_occluders_shadow_rays_change_nothing),
    cmocka_unit_test(diffuse_light_takes_the_light_s_samples_alone),
};

RK_SUITE("highlight_stage", tests)
