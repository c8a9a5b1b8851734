/* The explanation of a pixel ends with the colour that the renderer gives it, and names the hits
 * and shadow rays that led to it. */
#include "test_scene.h"

#include "driver/explain_pixel.h"
#include "io/srgb8.h"
#include "scenes/sky.h"

/* A new string to free(). */
static char *explain_with(const rk_scene *scene, rk_render_options options, uint32_t x, uint32_t y,
                          bool with_code, bool with_rays)
{
    rk_accel accel;
    rk_error error;
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_MEDIAN, scene, &error), error);
    rk_explain_pixel(out, scene, &accel, &options, x, y, with_code, with_rays);
    rk_accel_free(&accel);
    fclose(out);
    return text;
}

static char *explain(const rk_scene *scene, rk_render_options options, uint32_t x, uint32_t y)
{
    return explain_with(scene, options, x, y, false, false);
}

static bool contains(const char *text, const char *part)
{
    return strstr(text, part) != NULL;
}

/* The vector after the last `label` in the text; zero if there is none. */
static rk_vec3 printed_vector(const char *text, const char *label)
{
    rk_vec3 v = {0, 0, 0};
    const char *last = NULL;
    for (const char *at = strstr(text, label); at; at = strstr(at + 1, label))
        last = at;
    if (last)
        sscanf(last + strlen(label), " (%f, %f, %f)", &v.x, &v.y, &v.z);
    return v;
}

/* Six digits after the point are printed. */
static void check_printed(const char *text, const char *label, rk_vec3 want)
{
    rk_vec3 printed = printed_vector(text, label);
    rk_vec3 off = rk_abs3(rk_sub(printed, want));
    rk_check(off.x <= 1e-6f && off.y <= 1e-6f && off.z <= 1e-6f,
             "%s should be (%g, %g, %g), but the text is:\n%s", label, (double)want.x,
             (double)want.y, (double)want.z, text);
}

static void check_stored(const char *text, rk_vec3 want)
{
    rk_srgb8 table;
    rk_srgb8_init(&table);
    rk_vec3 stored = rk_vec(rk_srgb8_encode(&table, want.x), rk_srgb8_encode(&table, want.y),
                            rk_srgb8_encode(&table, want.z));
    check_printed(text, "colour (sRGB, 8 bits)", stored);
}

static rk_render_options size_of(uint32_t width, uint32_t height, bool shadows)
{
    rk_render_options options = rk_render_options_default();
    options.width = width;
    options.height = height;
    options.shadows = shadows;
    return options;
}

/* Without its lines that begin with #. */
static void drop_code(char *text)
{
    char *to = text;
    for (char *line = text; *line;) {
        char *next = line + strcspn(line, "\n") + 1;
        size_t size = (size_t)(next - line);
        if (*line != '#') {
            memmove(to, line, size);
            to += size;
        }
        line = next;
    }
    *to = '\0';
}

static void the_code_of_each_step_is_named(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = size_of(19, 13, true);
    options.reflections = true;
    char *plain = explain(&scene, options, 9, 7),
         *named = explain_with(&scene, options, 9, 7, true, false);
    rk_check(contains(named, "# src/scene/camera.h, rk_view_ray: "), "%s", named);
    rk_check(contains(named, "# src/features/bvh_median.c, rk_bvh_closest: "), "%s", named);
    rk_check(contains(named, "# src/features/shading.c, rk_shade: "), "%s", named);
    drop_code(named);
    rk_check(strcmp(named, plain) == 0, "the rest is as without it: %s", named);
    free(plain);
    free(named);
    rk_scene_free(&scene);
}

/* The ends of the n-th ray of this kind; NaN if there are fewer. */
static void printed_ray(const char *text, const char *kind, int n, rk_vec2 ends[2])
{
    char label[32];
    snprintf(label, sizeof label, "\n@ %s", kind);
    for (; n > 0 && text; n--)
        text = strstr(text + 1, label);
    ends[0] = ends[1] = (rk_vec2){NAN, NAN};
    text = text ? strstr(text, label) : NULL;
    if (text)
        sscanf(text + strlen(label), " %f %f %f %f", &ends[0].x, &ends[0].y, &ends[1].x,
               &ends[1].y);
}

/* Both are printed: the point with six digits, the pixel with three. */
static void check_place(const char *text, const rk_scene *scene, rk_vec3 point, rk_vec2 got)
{
    const rk_view view = rk_view_of(&scene->camera, 190, 130);
    rk_vec2 want = {NAN, NAN};
    float depth;
    rk_view_project(&view, point, &want, &depth);
    rk_check(fabsf(got.x - want.x) < 2e-3f && fabsf(got.y - want.y) < 2e-3f,
             "(%g, %g, %g) is seen at (%g, %g), not (%g, %g):\n%s", (double)point.x,
             (double)point.y, (double)point.z, (double)want.x, (double)want.y, (double)got.x,
             (double)got.y, text);
}

/* On the tall block, which mirrors. */
static void rays_have_their_places_in_the_picture(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = size_of(190, 130, true);
    options.reflections = true;
    char *plain = explain(&scene, options, 71, 103),
         *text = explain_with(&scene, options, 71, 103, false, true);
    char *second = strstr(text, "reflected ray"), *first = strndup(text, (size_t)(second - text));
    rk_vec2 camera[2], shadow[2], reflected[2];
    printed_ray(text, "camera", 0, camera);
    printed_ray(text, "shadow", 0, shadow);
    printed_ray(text, "reflected", 0, reflected);
    rk_check(fabsf(camera[0].x - 71.5f) < 2e-3f && fabsf(camera[1].y - 103.5f) < 2e-3f,
             "the camera ray is seen as a point:\n%s", text);
    check_place(text, &scene, printed_vector(first, "shadow ray origin"), shadow[0]);
    check_place(text, &scene, scene.lights[0].position, shadow[1]);
    check_place(text, &scene, printed_vector(first, "  point"), reflected[0]);
    check_place(text, &scene, printed_vector(second, "  point"), reflected[1]);
    rk_check(strncmp(text, plain, strlen(plain)) == 0, "the rest is as without it: %s", text);
    free(plain);
    free(first);
    free(text);
    rk_scene_free(&scene);
}

static void the_printed_colour_is_the_rendered_one(void **state)
{
    (void)state;
    const char *const names[] = {"cornell", "sphere:320", "cube", "panes", "cornell-light"};
    for (int i = 0; i < 5; i++)
        for (int shadows = 0; shadows < 2; shadows++) {
            rk_scene scene = test_scene_builtin(names[i]);
            test_scene_light(&scene, rk_vec(-3, 0, -1), rk_vec(0.5f, 0, 0.25f));
            rk_render_options options = size_of(19, 13, shadows);
            options.reflections = options.transparency = shadows;
            options.ambient_occlusion.intensity = shadows ? 0.25f : 0;
            test_picture picture = test_render(&scene, options, 1);
            for (uint32_t y = 0; y < options.height; y++)
                for (uint32_t x = 0; x < options.width; x++) {
                    char *text = explain(&scene, options, x, y);
                    check_printed(text, "colour (linear)", *rk_image_at(&picture.image, x, y));
                    check_stored(text, *rk_image_at(&picture.image, x, y));
                    free(text);
                }
            rk_image_free(&picture.image);
            rk_scene_free(&scene);
        }
}

/* A wall at z = 1 over the picture's left half (x > 0), a small square before a part of it, and a
 * light before both. */
static rk_scene make_stage(void)
{
    rk_scene scene = test_scene_make(4);
    test_scene_quad(&scene, 0, rk_vec(0, -9, 1), rk_vec(9, 0, 0), rk_vec(0, 18, 0));
    test_scene_quad(&scene, 2, rk_vec(2.75f, -0.3f, 0), rk_vec(0.5f, 0, 0), rk_vec(0, 0.5f, 0));
    test_scene_light(&scene, rk_vec(5, 0, -1), rk_vec(1, 1, 1));
    return scene;
}

static void a_miss_is_explained(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    char *text = explain(&scene, size_of(20, 20, true), 15, 10);
    rk_check(contains(text, "no hit") && contains(text, "black"), "a miss is black:\n%s", text);
    rk_check(contains(text, "pixel (15, 10)"), "the text begins with its pixel:\n%s", text);
    rk_check(!contains(text, "light 0"), "no light shines on nothing:\n%s", text);
    free(text);
    rk_scene_free(&scene);
}

static void an_environment_is_explained(void **state)
{
    (void)state;
    /* Misses, glass in front of nothing, and a mirror. */
    rk_scene scene = test_scene_of(4, 2);
    rk_error error;
    test_scene_quad(&scene, 0, rk_vec(0, -9, 1), rk_vec(9, 0, 0), rk_vec(0, 18, 0));
    test_scene_quad(&scene, 2, rk_vec(-1, -0.3f, 0), rk_vec(2, 0, 0), rk_vec(0, 0.5f, 0));
    scene.mesh.triangle_materials[2] = scene.mesh.triangle_materials[3] = 1;
    scene.mesh.materials[0].ks = rk_vec(0.5f, 0.5f, 0.5f);
    scene.mesh.materials[1].alpha = 0.25f;
    test_scene_light(&scene, rk_vec(5, 0, -1), rk_vec(1, 1, 1));
    rk_check_ok(rk_sky_make(&scene.environment, 8, &error), error);
    rk_render_options options = size_of(19, 13, true);
    options.reflections = options.transparency = true;
    test_picture picture = test_render(&scene, options, 1);
    int misses = 0, behind = 0;
    for (uint32_t y = 0; y < options.height; y++)
        for (uint32_t x = 0; x < options.width; x++) {
            char *text = explain(&scene, options, x, y);
            check_printed(text, "colour (linear)", *rk_image_at(&picture.image, x, y));
            misses += contains(text, "no hit: the environment");
            behind += contains(text, "behind all surfaces: the environment");
            free(text);
        }
    rk_check(misses > 10 && behind > 2, "%d misses, %d through glass", misses, behind);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void a_background_is_explained(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(0);
    scene.background = 0.5f;
    char *text = explain(&scene, size_of(9, 9, false), 4, 4);
    check_printed(text, "colour (linear)", rk_vec(0.5f, 0.5f, 0.5f));
    rk_check(contains(text, "no hit: the background"), "no background in:\n%s", text);
    free(text);
    rk_scene_free(&scene);
}

static void occluded_and_unoccluded_lights_are_explained(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    rk_render_options options = size_of(20, 20, true);
    /* Half-way from wall to light is z = 0; in the square if the wall's x is in 0.5 to 1.5. */
    char *dark = explain(&scene, options, 5, 10), *lit = explain(&scene, options, 1, 10);
    rk_check(contains(dark, "in shadow"), "the square occludes the light:\n%s", dark);
    check_printed(dark, "colour (linear)", rk_vec(0, 0, 0));
    rk_check(contains(lit, "    unoccluded"), "nothing occludes the light:\n%s", lit);
    free(dark);
    free(lit);
    options.shadows = false;
    char *without = explain(&scene, options, 5, 10);
    rk_check(!contains(without, "shadow ray"), "no shadow ray is traced:\n%s", without);
    rk_check(printed_vector(without, "colour (linear)").x > 0, "without shadows it is lit:\n%s",
             without);
    free(without);
    rk_scene_free(&scene);
}

static void the_hit_is_explained(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    char *text = explain(&scene, size_of(21, 21, false), 5, 10);
    /* Pixel 5 of 21 is 5 pixels left of the middle: x = 5 / 21 of 2 tan 25 degrees, times 4. */
    float x = 4 * 2 * 0.46630766f * 5 / 21;
    rk_check(contains(text, "hit triangle"), "the wall is hit:\n%s", text);
    check_printed(text, "    origin", rk_vec(0, 0, -3));
    check_printed(text, "    point", rk_vec(x, 0, 1));
    check_printed(text, "    face normal", rk_vec(0, 0, -1));
    check_printed(text, "    shading normal", rk_vec(0, 0, -1));
    check_printed(text, "    kd  ", rk_vec(0.8f, 0.8f, 0.8f));
    check_printed(text, "    position", rk_vec(5, 0, -1));
    free(text);
    rk_scene_free(&scene);
}

/* The light stands before the wall, and the square between them. */
static void an_occluded_ray_is_told_as_such(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    rk_render_options options = size_of(20, 20, true);
    for (uint32_t x = 0; x < 10; x++) {
        char *text = explain_with(&scene, options, x, 10, false, true);
        rk_check(contains(text, "\n@ occluded ") == contains(text, "occluded: in shadow"), "%s",
                 text);
        rk_check(contains(text, "\n@ shadow ") == contains(text, " unoccluded"), "%s", text);
        free(text);
    }
    rk_scene_free(&scene);
}

static void lights_that_add_nothing_are_explained(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    scene.light_count = 0;
    test_scene_light(&scene, rk_vec(1, 0, 3), rk_vec(1, 1, 1));
    test_scene_light(&scene, rk_vec(1, 0, -1), rk_vec(0, 0, 0));
    char *text = explain(&scene, size_of(20, 20, true), 5, 10);
    rk_check(contains(text, "faces away"), "light 0 is behind the wall:\n%s", text);
    rk_check(contains(text, "light is black"), "light 1 is black:\n%s", text);
    rk_check(!contains(text, "shadow ray"), "neither needs a shadow ray:\n%s", text);
    free(text);
    rk_scene_free(&scene);
}

static void more_samples_than_the_centre_are_mentioned(void **state)
{
    (void)state;
    rk_scene scene = make_stage();
    rk_render_options options = size_of(20, 20, false);
    char *one = explain(&scene, options, 5, 10);
    options.samples = 16;
    char *many = explain(&scene, options, 5, 10);
    rk_check(contains(many, "averages 16 rays") && !contains(one, "averages"),
             "one ray does not give the pixel's colour then:\n%s", many);
    free(one);
    free(many);
    rk_scene_free(&scene);
}

static void reflections_and_transparent_surfaces_are_explained(void **state)
{
    (void)state;
    rk_scene scene = test_scene_of(6, 3);
    test_scene_wall(&scene, 0, 0, 1);
    test_scene_wall(&scene, 2, 1, 2);
    test_scene_wall(&scene, 4, -6, 0);
    scene.mesh.materials[1].alpha = 0.25f;
    scene.mesh.materials[2].ks = rk_vec(1, 1, 1);
    test_scene_light(&scene, rk_vec(1, 2, -2), rk_vec(1, 1, 1));
    rk_render_options options = size_of(20, 20, true);
    options.reflections = options.transparency = true;
    options.max_depth = 1;
    char *text = explain(&scene, options, 5, 9);
    rk_check(contains(text, "alpha = 0.250000"), "the opacity of the transparent surface:\n%s",
             text);
    rk_check(contains(text, "attenuated by") || contains(text, "    unoccluded"),
             "the result of the shadow rays:\n%s", text);
    rk_check(!contains(text, "reflected ray"), "a max depth of 1 ends at the mirror:\n%s", text);
    free(text);
    options.max_depth = 3;
    text = explain(&scene, options, 5, 9);
    rk_check(contains(text, "reflected ray"), "a max depth of 3 permits a reflection:\n%s", text);
    rk_check(contains(text, "\n    hit triangle") && contains(text, "\n        light 0") &&
                 contains(text, "\n        reflected ray") && contains(text, "\n            hit"),
             "hits stand below their ray; lights and reflected rays, below their hit:\n%s", text);
    free(text);
    rk_scene_free(&scene);
}

static void shadow_rays_of_an_area_light_are_counted(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = size_of(40, 40, true);
    options.light.visibility = RK_LIGHT_RAYS;
    char *text = explain(&scene, options, 20, 12);
    rk_check(contains(text, "a parallelogram") && contains(text, "16 shadow rays, 16 unoccluded"),
             "the whole light is visible from the back wall:\n%s", text);
    free(text);
    options.light.visibility = RK_LIGHT_PYRAMIDS;
    text = explain(&scene, options, 20, 12);
    rk_check(contains(text, "no shadow rays: there is no surface between point and light") &&
                 contains(text, "    unoccluded\n") && !contains(text, "shadow rays, "),
             "and the pyramid to the light is empty:\n%s", text);
    free(text);
    rk_scene_free(&scene);
}

static void a_lens_is_mentioned_where_there_is_one(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cube");
    rk_render_options options = size_of(40, 40, false);
    for (options.lens_samples = 0; options.lens_samples <= 15; options.lens_samples += 15) {
        char *text = explain(&scene, options, 20, 20);
        rk_check(contains(text, "lens") == (options.lens_samples > 0), "the text is:\n%s", text);
        free(text);
    }
    rk_scene_free(&scene);
}

static void the_time_stands_in_the_first_ray_that_needs_it(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("moving");
    rk_render_options options = size_of(40, 40, true);
    options.motion.samples = 4;
    char *ball = explain(&scene, options, 30, 22), *sky = explain(&scene, options, 2, 2);
    const char *time = strstr(ball, "may hit a moving object"),
               *next = time ? strstr(time, "one of 4\n    tested ") : NULL;
    rk_check(next && !contains(next, "moving object") && strstr(ball, "tested ") > time,
             "once, before all that depends on it:\n%s", ball);
    rk_check(!contains(sky, "the time is x"), "no ray of this pixel needs a time:\n%s", sky);
    free(ball);
    free(sky);
    rk_scene_free(&scene);
}

static void bloom_is_mentioned_where_it_is_on(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cube");
    rk_render_options options = size_of(40, 40, false);
    for (int on = 0; on < 2; on++) {
        options.bloom.on = on;
        char *text = explain(&scene, options, 20, 20);
        rk_check(contains(text, "bloom") == on, "the text is:\n%s", text);
        free(text);
    }
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_printed_colour_is_the_rendered_one),
    cmocka_unit_test(the_code_of_each_step_is_named),
    cmocka_unit_test(rays_have_their_places_in_the_picture),
    cmocka_unit_test(an_occluded_ray_is_told_as_such),
    cmocka_unit_test(a_miss_is_explained),
    cmocka_unit_test(an_environment_is_explained),
    cmocka_unit_test(a_background_is_explained),
    cmocka_unit_test(occluded_and_unoccluded_lights_are_explained),
    cmocka_unit_test(the_hit_is_explained),
    cmocka_unit_test(lights_that_add_nothing_are_explained),
    cmocka_unit_test(reflections_and_transparent_surfaces_are_explained),
    cmocka_unit_test(shadow_rays_of_an_area_light_are_counted),
    cmocka_unit_test(more_samples_than_the_centre_are_mentioned),
    cmocka_unit_test(the_time_stands_in_the_first_ray_that_needs_it),
    cmocka_unit_test(bloom_is_mentioned_where_it_is_on),
    cmocka_unit_test(a_lens_is_mentioned_where_there_is_one),
};

RK_SUITE("explain_pixel", tests)
