/* The renderer: its light against formulas in double, its shadows against projection, its pictures
 * the same for any threads, and its counters as proof that nothing needless is done. */
#include "test_scene.h"

#include "accel/query/trace_one.h"
#include "render/rendering.h"
#include "render/stages/camera_stage.h"
#include "render/stages/shade_stage.h"
#include "render/tiles.h"

static rk_render_options size_of(uint32_t width, uint32_t height)
{
    rk_render_options options = rk_render_options_default();
    options.width = width;
    options.height = height;
    return options;
}

static void check_colour(const rk_image *image, size_t x, size_t y, const double want[3],
                         double tolerance, const char *hint)
{
    const rk_vec3 *got = rk_image_at(image, x, y);
    for (int c = 0; c < 3; c++)
        rk_check(fabs((double)rk_axis(*got, c) - want[c]) <= tolerance,
                 "pixel (%zu, %zu), channel %d: got %.9g, want %.9g within %.3g: %s", x, y, c,
                 (double)rk_axis(*got, c), want[c], tolerance, hint);
}

/* --- Light ----------------------------------------------------------------------------------- */

/* A pixel's point on the plane z = depth, from (0, 0, -3), in double. */
typedef struct plane_point {
    double x, y, z;
} plane_point;

static plane_point seen_on_plane(double depth, const rk_render_options *options, size_t x, size_t y)
{
    double half = tan(25 * 3.14159265358979323846 / 180), reach = depth + 3;
    double across = 2 * ((double)x + 0.5) / options->width - 1;
    double up = 1 - 2 * ((double)y + 0.5) / options->height;
    double aspect = (double)options->width / options->height;
    return (plane_point){-across * half * aspect * reach, up * half * reach, depth};
}

/* kd times the light's colour times the cosine, on a plane that faces -z. */
static void lambert(plane_point p, const rk_light *light, rk_vec3 kd, double colour[3])
{
    double l[3] = {(double)light->position.x - p.x, (double)light->position.y - p.y,
                   (double)light->position.z - p.z};
    double cosine = -l[2] / sqrt(l[0] * l[0] + l[1] * l[1] + l[2] * l[2]);
    for (int c = 0; c < 3; c++)
        colour[c] += cosine > 0
                         ? (double)rk_axis(kd, c) * (double)rk_axis(light->colours[0], c) * cosine
                         : 0;
}

/* A triangle in the plane z = 0: x + y <= 0.5 and x, y >= -0.5. */
static rk_scene make_facing_triangle(void)
{
    rk_scene scene = test_scene_make(1);
    test_scene_triangle(&scene, 0, rk_vec(-0.5f, -0.5f, 0), rk_vec(1, -0.5f, 0),
                        rk_vec(-0.5f, 1, 0));
    scene.mesh.materials[0].kd = rk_vec(0.9f, 0.5f, 0.1f);
    return scene;
}

/* The distance of a point of z = 0 from the triangle's edges, above 0 inside. */
static double inside_facing_triangle(plane_point p)
{
    return fmin(fmin(p.x + 0.5, p.y + 0.5), (0.5 - p.x - p.y) / sqrt(2));
}

static void a_facing_triangle_shines_by_lamberts_law(void **state)
{
    (void)state;
    rk_scene scene = make_facing_triangle();
    test_scene_light(&scene, rk_vec(0.7f, -0.3f, -1.5f), rk_vec(1, 0.5f, 2));
    rk_render_options options = size_of(67, 45);
    test_picture picture = test_render(&scene, options, 1);
    size_t lit = 0, black = 0;
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++) {
            plane_point p = seen_on_plane(0, &options, x, y);
            double colour[3] = {0}, inside = inside_facing_triangle(p);
            /* On the edge itself roundings decide. */
            if (fabs(inside) < 1e-5)
                continue;
            if (inside > 0)
                lambert(p, &scene.lights[0], scene.mesh.materials[0].kd, colour);
            *(inside > 0 ? &lit : &black) += 1;
            /* A dozen roundings of float, 2^-24 each, in numbers up to 1.8. */
            check_colour(&picture.image, x, y, colour, inside > 0 ? 2e-6 : 0,
                         inside > 0 ? "kd colour n.l" : "nothing is there: exactly black");
        }
    rk_check(lit > 100 && black > 100, "the triangle should cover a part: %zu lit, %zu not", lit,
             black);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* Directions to a light are found for several points at once; each as for one alone, wherever the
 * last group of a tile ends. A light on the surface itself has no direction. */
/* Red, green and blue at the corners; half transparent, the triangle has half of its light. */
static void colours_of_vertices_are_seen_also_through_transparency(void **state)
{
    (void)state;
    rk_scene scene = make_facing_triangle();
    rk_error error;
    scene.mesh.colours = rk_allocate(3, sizeof(rk_vec3), "colours", &error);
    for (int i = 0; i < 3; i++)
        scene.mesh.colours[i] = rk_vec(i == 0, i == 1, i == 2);
    test_scene_light(&scene, rk_vec(0.7f, -0.3f, -1.5f), rk_vec(1, 1, 1));
    rk_render_options options = size_of(67, 45);
    for (int half = 0; half < 2; half++) {
        options.transparency = half;
        scene.mesh.materials[0].alpha = half ? 0.5f : 1;
        test_picture picture = test_render(&scene, options, 1);
        for (size_t y = 0; y < options.height; y++)
            for (size_t x = 0; x < options.width; x++) {
                plane_point p = seen_on_plane(0, &options, x, y);
                double colour[3] = {0}, u = (p.x + 0.5) / 1.5, v = (p.y + 0.5) / 1.5;
                if (inside_facing_triangle(p) < 1e-5)
                    continue;
                lambert(p, &scene.lights[0], scene.mesh.materials[0].kd, colour);
                colour[0] *= 1 - u - v, colour[1] *= u, colour[2] *= v;
                for (int c = 0; c < 3; c++)
                    colour[c] *= half ? 0.5 : 1;
                /* A dozen roundings of float, 2^-24 each, in numbers up to 1. */
                check_colour(&picture.image, x, y, colour, 2e-6, "kd, colour, n.l");
            }
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

/* A square whose right half a picture cuts out, or its left half alone, before a wall. */
static rk_scene make_half_square(bool cut_out)
{
    rk_scene scene = test_scene_of(4, 2);
    rk_error error;
    test_scene_wall(&scene, 2, 1, 1);
    test_scene_quad(&scene, 0, rk_vec(-0.5f, -0.5f, 0), rk_vec(cut_out ? 1 : 0.5f, 0, 0),
                    rk_vec(0, 1, 0));
    test_scene_light(&scene, rk_vec(0.3f, 0.2f, -2), rk_vec(1, 1, 1));
    if (!cut_out)
        return scene;
    static const rk_vec2 texcoords[6] = {{0, 0}, {1, 0}, {1, 1}, {0, 0}, {1, 1}, {0, 1}};
    rk_mesh *mesh = &scene.mesh;
    mesh->texcoords = rk_allocate(12, sizeof(rk_vec2), "texture coordinates", &error);
    memcpy(mesh->texcoords, texcoords, sizeof texcoords);
    mesh->textures = rk_allocate(1, sizeof(rk_texture), "textures", &error);
    mesh->texture_count = 1;
    rk_check_ok(rk_image_init(&mesh->textures[0].image, 2, 1, &error), error);
    *rk_image_at(&mesh->textures[0].image, 0, 0) = rk_vec(1, 1, 1);
    mesh->materials[0].alpha_texture = &mesh->textures[0];
    return scene;
}

/* A camera ray through the hidden half sees the wall, and a shadow ray the light: the same picture
 * as without that half, whether by a cutoff, by one half, or as transparency. */
static void where_a_picture_cuts_a_surface_out_there_is_none(void **state)
{
    (void)state;
    rk_scene half = make_half_square(false), cut = make_half_square(true);
    rk_render_options options = size_of(64, 48);
    options.shadows = true;
    test_picture want = test_render(&half, options, 1);
    for (int way = 0; way < 3; way++) {
        cut.mesh.materials[0].alpha_cutoff = way == 0 ? 0.25f : 0;
        options.transparency = way == 2;
        test_picture got = test_render(&cut, options, 1);
        for (size_t y = 0; y < options.height; y++)
            for (size_t x = 0; x < options.width; x++) {
                const rk_vec3 *w = rk_image_at(&want.image, x, y);
                const double colour[3] = {(double)w->x, (double)w->y, (double)w->z};
                /* A dozen roundings of float, 2^-24 each, in numbers up to 1. */
                check_colour(&got.image, x, y, colour, 2e-6, "as if it were not there");
            }
        rk_image_free(&got.image);
    }
    rk_image_free(&want.image);
    rk_scene_free(&half);
    rk_scene_free(&cut);
}

/* A debug view's ray goes on where the renderer's does, whatever the kind of tree is. */
static void a_single_ray_passes_where_a_picture_cuts_out(void **state)
{
    (void)state;
    rk_scene half = make_half_square(false), cut = make_half_square(true);
    for (int kind = 0; kind <= RK_ACCEL_WIDE; kind++) {
        rk_accel of_half, of_cut;
        rk_error error;
        rk_check_ok(rk_accel_build(&of_half, (rk_accel_kind)kind, &half, &error), error);
        rk_check_ok(rk_accel_build(&of_cut, (rk_accel_kind)kind, &cut, &error), error);
        for (int i = 0; i < 200; i++) {
            const float x = ((float)i + 0.5f) / 100 - 1;
            const rk_ray ray = {rk_vec(x, 0.1f, -2), rk_vec(0, 0, 1), INFINITY};
            const rk_hit want = rk_trace_one(&of_half, &ray), got = rk_trace_one(&of_cut, &ray);
            rk_check_close(got.t, want.t, 0, "the square's left half at 2, the wall elsewhere");
        }
        rk_accel_free(&of_half);
        rk_accel_free(&of_cut);
    }
    rk_scene_free(&half);
    rk_scene_free(&cut);
}

/* Without the option, materials that are not opaque are drawn as if they were. */
static void a_cut_out_makes_nothing_else_transparent(void **state)
{
    (void)state;
    rk_scene cut = make_half_square(true);
    rk_render_options options = size_of(64, 48);
    options.shadows = true;
    test_picture want = test_render(&cut, options, 1);
    for (int i = 1; i >= 0; i--) {
        cut.mesh.materials[i].alpha = 0.25f;
        test_picture got = test_render(&cut, options, 1);
        rk_check(test_same_pixels(&want.image, &got.image), "%s is transparent",
                 i ? "the wall" : "the square");
        rk_image_free(&got.image);
    }
    rk_image_free(&want.image);
    rk_scene_free(&cut);
}

static void a_point_light_is_shaded_as_by_its_unit_directions_to_the_bit(void **state)
{
    (void)state;
    rk_scene scene = make_facing_triangle();
    rk_accel accel;
    rk_error error;
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_WIDE, &scene, &error), error);
    rk_render_options options = size_of(67, 45);
    const rk_view view = rk_view_of(&scene.camera, options.width, options.height);
    rk_surface centre;
    rk_ray ray = rk_view_ray(&view, 33.5f, 22.5f);
    rk_check(rk_trace_one_surface(&centre, &accel, &ray), "the triangle is in the middle");
    test_scene_light(&scene, rk_vec(0.7f, -0.3f, -1.5f), rk_vec(1, 0.5f, 2));
    for (int i = 0; i < 2; i++) {
        if (i == 1) { /* the gradient tells cosine 0 from no number */
            scene.lights[0].position = centre.point;
            options.shading = (rk_shading){RK_SHADING_GRADIENT, false, rk_gradient_cool_to_warm()};
        }
        test_picture picture = test_render(&scene, options, 1);
        for (uint32_t y = 0; y < options.height; y++)
            for (uint32_t x = 0; x < options.width; x++) {
                rk_surface s;
                rk_vec3 want = {0}, got = *rk_image_at(&picture.image, x, y);
                ray = rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f);
                if (rk_trace_one_surface(&s, &accel, &ray))
                    want = rk_shade(&options.shading, s.material->kd, s.material->ks,
                                    s.material->shininess, s.normal,
                                    rk_normalize(rk_sub(scene.lights[0].position, s.point)),
                                    rk_vec(0, 0, 0), scene.lights[0].colours[0]);
                rk_check(got.x == want.x && got.y == want.y && got.z == want.z,
                         "pixel (%u, %u): got %.9g %.9g %.9g, want %.9g %.9g %.9g", x, y,
                         (double)got.x, (double)got.y, (double)got.z, (double)want.x,
                         (double)want.y, (double)want.z);
            }
        rk_image_free(&picture.image);
    }
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

static void several_lights_add_up(void **state)
{
    (void)state;
    rk_scene scene = make_facing_triangle();
    test_scene_light(&scene, rk_vec(0.7f, -0.3f, -1.5f), rk_vec(1, 0, 0.25f));
    test_scene_light(&scene, rk_vec(-2, 1, -0.5f), rk_vec(0.5f, 0.75f, 0));
    test_scene_light(&scene, rk_vec(0, 0, 4), rk_vec(9, 9, 9)); /* behind: adds nothing */
    rk_render_options options = size_of(31, 31);
    options.shadows = true;
    test_picture picture = test_render(&scene, options, 1);
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++) {
            plane_point p = seen_on_plane(0, &options, x, y);
            double colour[3] = {0};
            if (inside_facing_triangle(p) < 1e-5)
                continue;
            for (uint32_t i = 0; i < scene.light_count; i++)
                lambert(p, &scene.lights[i], scene.mesh.materials[0].kd, colour);
            check_colour(&picture.image, x, y, colour, 4e-6, "the sum over two lights");
        }
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void a_surface_lit_from_behind_is_black(void **state)
{
    (void)state;
    rk_scene scene = make_facing_triangle();
    test_scene_light(&scene, rk_vec(0, 0, 2), rk_vec(1, 1, 1));
    rk_render_options options = size_of(16, 16);
    options.shadows = true;
    test_picture picture = test_render(&scene, options, 1);
    for (size_t i = 0; i < 256; i++)
        rk_check(rk_length(picture.image.pixels[i]) == 0, "pixel %zu got light from behind", i);
    rk_check_equal(picture.counters.shadow_rays, 0, "a cosine below 0 needs no shadow ray");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* --- Shadows --------------------------------------------------------------------------------- */

static void an_occluder_shadows_the_region_that_projects_onto_it(void **state)
{
    (void)state;
    /* A wall at z = 1, and a square beside the camera's cone of view that is between the light and
     * the wall: |x - 3| <= .25, |y + .06| <= .25 at z = 0, with the light at (6, 0, -1). Its
     * diagonal passes between the pixels. */
    rk_scene scene = test_scene_make(4);
    test_scene_quad(&scene, 0, rk_vec(-9, -9, 1), rk_vec(18, 0, 0), rk_vec(0, 18, 0));
    test_scene_quad(&scene, 2, rk_vec(2.75f, -0.31f, 0), rk_vec(0.5f, 0, 0), rk_vec(0, 0.5f, 0));
    test_scene_light(&scene, rk_vec(6, 0, -1), rk_vec(1, 1, 1));
    rk_render_options options = size_of(60, 60);
    options.shadows = true;
    test_picture picture = test_render(&scene, options, 2);
    size_t dark = 0;
    for (size_t y = 0; y < options.height; y++)
        for (size_t x = 0; x < options.width; x++) {
            plane_point p = seen_on_plane(1, &options, x, y);
            /* The ray to the light crosses z = 0 half-way. */
            double inside = fmin(0.25 - fabs((p.x + 6) / 2 - 3), 0.25 - fabs(p.y / 2 + 0.06));
            if (fabs(inside) < 1e-5)
                continue;
            double colour[3] = {0};
            if (inside < 0)
                lambert(p, &scene.lights[0], scene.mesh.materials[0].kd, colour);
            dark += inside > 0;
            check_colour(&picture.image, x, y, colour, inside > 0 ? 0 : 2e-6,
                         inside > 0 ? "it lies in the shadow" : "nothing occludes the light");
        }
    rk_check(dark > 50, "only %zu pixels lie in the shadow", dark);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void surfaces_beyond_the_light_cast_no_shadow(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(4);
    test_scene_quad(&scene, 0, rk_vec(-9, -9, 1), rk_vec(18, 0, 0), rk_vec(0, 18, 0));
    test_scene_quad(&scene, 2, rk_vec(-9, -9, -5), rk_vec(18, 0, 0), rk_vec(0, 18, 0));
    test_scene_light(&scene, rk_vec(0, 0, -4), rk_vec(1, 1, 1));
    rk_render_options options = size_of(40, 40);
    test_picture open = test_render(&scene, options, 1);
    options.shadows = true;
    test_picture shadowed = test_render(&scene, options, 1);
    rk_check(test_same_pixels(&open.image, &shadowed.image),
             "a shadow ray went on behind the light");
    rk_image_free(&open.image);
    rk_image_free(&shadowed.image);
    rk_scene_free(&scene);
}

/* A convex body lit by a light outside casts no shadow on surfaces that face the light, so with and
 * without shadows the picture is the same, to the bit. */
static void check_no_acne(const char *name, float size, rk_vec3 shift, rk_vec3 light)
{
    rk_scene scene = test_scene_builtin(name);
    for (uint32_t i = 0; i < scene.mesh.vertex_count; i++)
        scene.mesh.positions[i] = rk_madd(shift, scene.mesh.positions[i], size);
    free(scene.mesh.normals); /* flat: where n.l > 0 the face itself sees the light */
    scene.mesh.normals = NULL;
    scene.camera.look_at = shift;
    scene.camera.distance *= size;
    scene.light_count = 0;
    test_scene_light(&scene, rk_madd(shift, light, size), rk_vec(1, 1, 1));
    rk_render_options options = size_of(300, 300);
    test_picture open = test_render(&scene, options, 2);
    options.shadows = true;
    test_picture shadowed = test_render(&scene, options, 2);
    size_t specks = 0;
    for (size_t i = 0; i < 300 * 300; i++)
        specks += memcmp(&open.image.pixels[i], &shadowed.image.pixels[i], sizeof(rk_vec3)) != 0;
    rk_check(shadowed.counters.shadow_rays > 1000, "hardly anything is lit");
    rk_check(specks == 0,
             "%s, %g times as large, at (%g, %g, %g): %zu of %llu lit pixels are in the shadow of "
             "nothing: shadow rays hit the surface that they leave",
             name, (double)size, (double)shift.x, (double)shift.y, (double)shift.z, specks,
             (unsigned long long)shadowed.counters.shadow_rays);
    rk_image_free(&open.image);
    rk_image_free(&shadowed.image);
    rk_scene_free(&scene);
}

static void convex_bodies_cast_no_shadow_on_themselves(void **state)
{
    (void)state;
    const rk_vec3 lights[] = {{1.5f, 3, -2.5f}, {4, 0.5f, -1}, {0.1f, 1.2f, -1.3f}};
    for (int i = 0; i < 3; i++) {
        check_no_acne("sphere:1280", 1, rk_vec(0, 0, 0), lights[i]);
        check_no_acne("cube", 1, rk_vec(0, 0, 0), lights[i]);
    }
    check_no_acne("sphere:20000", 1e3f, rk_vec(0, 0, 0), lights[0]);
    check_no_acne("sphere:320", 1e-3f, rk_vec(0, 0, 0), lights[0]);
    check_no_acne("sphere:320", 1, rk_vec(300, -100, 200), lights[0]);
    check_no_acne("cube", 1, rk_vec(300, -100, 200), lights[0]);
}

/* --- The same picture every time ------------------------------------------------------------- */

static void check_threads_agree(const rk_scene *scene, rk_render_options options)
{
    const uint32_t threads[] = {2, 3, 7};
    test_picture one = test_render(scene, options, 1);
    for (int i = 0; i < 3; i++) {
        test_picture many = test_render(scene, options, threads[i]);
        rk_check(test_same_pixels(&one.image, &many.image),
                 "%u x %u, %u samples: %u threads drew another picture than one", options.width,
                 options.height, options.samples, threads[i]);
        rk_check(memcmp(&one.counters, &many.counters, sizeof one.counters) == 0,
                 "%u threads counted otherwise than one", threads[i]);
        rk_image_free(&many.image);
    }
    rk_image_free(&one.image);
}

static void the_picture_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    const uint32_t sizes[][2] = {{1, 1}, {17, 5}, {800, 3}, {16, 16}, {33, 48}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++)
        for (uint32_t samples = 1; samples <= 4; samples += 3) {
            rk_render_options options = size_of(sizes[i][0], sizes[i][1]);
            options.samples = samples;
            options.shadows = true;
            check_threads_agree(&scene, options);
        }
    rk_scene_free(&scene);
}

static void the_seed_changes_random_samples_and_nothing_else(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    for (uint32_t samples = 1; samples <= 4; samples += 3) {
        rk_render_options options = size_of(40, 40);
        options.samples = samples;
        test_picture first = test_render(&scene, options, 1);
        options.seed = 1;
        test_picture second = test_render(&scene, options, 1);
        rk_check(test_same_pixels(&first.image, &second.image) == (samples == 1),
                 samples == 1 ? "pixel centres are not random"
                              : "another seed gave the same samples");
        rk_image_free(&first.image);
        rk_image_free(&second.image);
    }
    rk_scene_free(&scene);
}

static void every_tile_is_a_step_of_progress(void **state)
{
    (void)state;
    rk_render_options options = size_of(33, 16);
    rk_check_equal(rk_render_tiles(&options), 3, "16 + 16 + 1 pixels across, 16 down");
    options = size_of(1, 17);
    rk_check_equal(rk_render_tiles(&options), 2, "1 across, 16 + 1 down");
}

/* --- Nothing needless ------------------------------------------------------------------------ */

static void check_nothing_was_done(const rk_scene *scene)
{
    rk_render_options options = size_of(20, 20);
    options.samples = 4;
    options.shadows = true;
    test_picture picture = test_render(scene, options, 2);
    rk_counters none = {0};
    rk_check(memcmp(&picture.counters, &none, sizeof none) == 0,
             "rays were traced although the picture is black");
    for (size_t i = 0; i < 400; i++)
        rk_check(rk_length(picture.image.pixels[i]) == 0, "pixel %zu is not black", i);
    rk_image_free(&picture.image);
}

static void without_triangles_lights_or_colour_no_ray_is_traced(void **state)
{
    (void)state;
    rk_scene empty = test_scene_make(0);
    test_scene_light(&empty, rk_vec(0, 0, -2), rk_vec(1, 1, 1));
    check_nothing_was_done(&empty);
    rk_scene_free(&empty);
    rk_scene unlit = make_facing_triangle();
    check_nothing_was_done(&unlit);
    test_scene_light(&unlit, rk_vec(0, 0, -2), rk_vec(0, 0, 0));
    check_nothing_was_done(&unlit);
    rk_scene_free(&unlit);
}

static void the_plan_is_empty_for_a_picture_that_is_black_anyway(void **state)
{
    (void)state;
    rk_scene scene = make_facing_triangle();
    rk_render_options options = size_of(20, 20);
    options.samples = 4;
    options.shadows = true;
    rk_plan plan = rk_plan_of(&scene, &options);
    rk_check(!plan.rays && !plan.pixel_samples && !plan.lights && !plan.shadow_rays,
             "no light shines, so nothing is needed");
    test_scene_light(&scene, rk_vec(0, 0, -2), rk_vec(0, 0, 1));
    plan = rk_plan_of(&scene, &options);
    rk_check(plan.rays && plan.pixel_samples && plan.lights && plan.shadow_rays,
             "a blue light shines: all options are needed");
    scene.mesh.triangle_count = 0;
    plan = rk_plan_of(&scene, &options);
    rk_check(!plan.rays && !plan.pixel_samples && plan.lights && !plan.shadow_rays,
             "a light, but nothing to shine on");
    rk_scene_free(&scene);
}

static void the_counters_match_the_options(void **state)
{
    (void)state;
    rk_scene scene = make_facing_triangle();
    test_scene_light(&scene, rk_vec(0, 0, -2), rk_vec(1, 1, 1));
    for (uint32_t samples = 1; samples <= 4; samples += 3)
        for (int shadows = 0; shadows < 2; shadows++) {
            rk_render_options options = size_of(37, 21);
            options.samples = samples;
            options.shadows = shadows;
            test_picture picture = test_render(&scene, options, 2);
            uint64_t rays = 37 * 21 * samples;
            rk_check_equal(picture.counters.primary_rays, rays, "one per pixel and sample");
            rk_check_equal(picture.counters.pixel_samples, samples > 1 ? rays : 0,
                           "the centre of a pixel is not random");
            if (shadows)
                rk_check(picture.counters.shadow_rays > 0 && picture.counters.shadow_rays < rays,
                         "shadow rays go from where something is lit: %llu",
                         (unsigned long long)picture.counters.shadow_rays);
            else
                rk_check_equal(picture.counters.shadow_rays, 0, "without the option");
            rk_image_free(&picture.image);
        }
    rk_scene_free(&scene);
}

static void black_lights_and_black_surfaces_cost_no_shadow_ray(void **state)
{
    (void)state;
    rk_scene scene = make_facing_triangle();
    test_scene_light(&scene, rk_vec(0, 0, -2), rk_vec(1, 0, 0));
    rk_render_options options = size_of(30, 30);
    options.shadows = true;
    test_picture one = test_render(&scene, options, 1);
    test_scene_light(&scene, rk_vec(1, 0, -2), rk_vec(0, 0, 0));
    test_picture two = test_render(&scene, options, 1);
    rk_check(test_same_pixels(&one.image, &two.image), "a black light adds nothing");
    rk_check_equal(two.counters.shadow_rays, one.counters.shadow_rays, "nor traces any ray");
    scene.mesh.materials[0].kd = rk_vec(0, 1, 1); /* reflects nothing of a red light */
    test_picture black = test_render(&scene, options, 1);
    rk_check_equal(black.counters.shadow_rays, 0, "there is nothing to keep in shadow");
    rk_image_free(&one.image);
    rk_image_free(&two.image);
    rk_image_free(&black.image);
    rk_scene_free(&scene);
}

/* --- Samples --------------------------------------------------------------------------------- */

static void an_exact_sphere_is_round_and_lies_before_and_behind_triangles(void **state)
{
    (void)state;
    /* A wall divides the sphere: its front half is visible, a disk on the wall. */
    rk_scene scene = test_scene_make(2);
    test_scene_quad(&scene, 0, rk_vec(-9, -9, 0.5f), rk_vec(18, 0, 0), rk_vec(0, 18, 0));
    scene.spheres[0] = (rk_sphere){rk_vec(0, 0, 0.5f), 0.5f};
    scene.sphere_materials[0] = (rk_material){.kd = rk_vec(1, 0, 0), .alpha = 1};
    scene.sphere_count = 1;
    test_scene_light(&scene, rk_vec(0, 0, -3), rk_vec(1, 1, 1));
    const uint32_t side = 101;
    test_picture picture = test_render(&scene, size_of(side, side), 2);
    rk_view view = rk_view_of(&scene.camera, side, side);
    for (uint32_t y = 0; y < side; y++)
        for (uint32_t x = 0; x < side; x++) {
            /* The line passes the centre at 3.5 sin(angle), in front of the wall if that is less
             * than the radius: the rim's tangent points lie in front of the centre's plane. */
            rk_ray ray = rk_view_ray(&view, (float)x + 0.5f, (float)y + 0.5f);
            double cosine = (double)rk_dot(ray.direction, view.forward);
            double passes = 3.5 * sqrt(1 - cosine * cosine);
            if (fabs(passes - 0.5) < 1e-3)
                continue;
            rk_vec3 pixel = *rk_image_at(&picture.image, x, y);
            rk_check((passes < 0.5) == (pixel.y == 0), "pixel (%u, %u) passes the centre at %g", x,
                     y, passes);
        }
    rk_check_equal(picture.counters.sphere_tests, side * side, "one test a ray");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void an_exact_sphere_casts_a_shadow_but_none_on_itself(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(0);
    scene.spheres[0] = (rk_sphere){rk_vec(0, 0, 0), 1};
    scene.sphere_materials[0] = (rk_material){.kd = rk_vec(1, 1, 1), .alpha = 1};
    scene.sphere_count = 1;
    test_scene_light(&scene, rk_vec(2, 3, -2), rk_vec(1, 1, 1));
    rk_render_options options = size_of(300, 300);
    test_picture open = test_render(&scene, options, 2);
    options.shadows = true;
    test_picture shadowed = test_render(&scene, options, 2);
    rk_check(shadowed.counters.shadow_rays > 10000, "hardly anything is lit");
    rk_check(test_same_pixels(&open.image, &shadowed.image), "specks of shadow on the lit side");
    rk_image_free(&shadowed.image);
    /* A second sphere between the first and the light. */
    scene.spheres[1] = (rk_sphere){rk_vec(1, 1.5f, -1), 0.25f};
    scene.sphere_materials[1] = scene.sphere_materials[0];
    scene.sphere_count = 2;
    shadowed = test_render(&scene, options, 2);
    options.shadows = false;
    rk_image_free(&open.image);
    open = test_render(&scene, options, 2);
    rk_check(!test_same_pixels(&open.image, &shadowed.image), "the second sphere casts no shadow");
    rk_image_free(&open.image);
    rk_image_free(&shadowed.image);
    rk_scene_free(&scene);
}

static void samples_converge_to_the_covered_part_of_the_pixel(void **state)
{
    (void)state;
    /* One pixel; a quad ahead whose right edge is at x = 0 covers the left half in the picture, a
     * second the lower half: a quarter, a half and three quarters are covered. The light is far
     * away, so that n.l = 1 to 10^-11. */
    const rk_vec3 corner[] = {{0, -9, 0}, {-9, -9, 0}, {0, 0, 0}};
    const rk_vec3 side_a[] = {{9, 0, 0}, {18, 0, 0}, {9, 0, 0}};
    const rk_vec3 side_b[] = {{0, 18, 0}, {0, 9, 0}, {0, 9, 0}};
    const double coverage[] = {0.5, 0.5, 0.25};
    for (int i = 0; i < 3; i++)
        for (uint32_t seed = 0; seed < 4; seed++) {
            rk_scene scene = test_scene_make(2);
            test_scene_quad(&scene, 0, corner[i], side_a[i], side_b[i]);
            scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
            test_scene_light(&scene, rk_vec(0, 0, -1e6f), rk_vec(1, 1, 1));
            rk_render_options options = size_of(1, 1);
            options.samples = 20000;
            options.seed = seed;
            test_picture picture = test_render(&scene, options, 1);
            double error = sqrt(coverage[i] * (1 - coverage[i]) / options.samples);
            rk_check_close(rk_image_at(&picture.image, 0, 0)->x, coverage[i], 4 * error,
                           "4 standard errors of so many yes-or-no samples");
            rk_image_free(&picture.image);
            rk_scene_free(&scene);
        }
}

static void each_pixel_has_samples_of_its_own(void **state)
{
    (void)state;
    /* An edge through a column of pixels: with the same samples in all, all were equal. */
    rk_scene scene = test_scene_make(2);
    test_scene_quad(&scene, 0, rk_vec(0, -9, 0), rk_vec(9, 0, 0), rk_vec(0, 18, 0));
    test_scene_light(&scene, rk_vec(0, 0, -1e6f), rk_vec(1, 1, 1));
    rk_render_options options = size_of(1, 64);
    options.sampling = RK_SAMPLER_UNIFORM; /* the others halve each pixel exactly */
    options.samples = 64;
    test_picture picture = test_render(&scene, options, 1);
    size_t others = 0;
    for (size_t y = 1; y < 64; y++)
        others += rk_image_at(&picture.image, 0, y)->x != rk_image_at(&picture.image, 0, 0)->x;
    rk_check(others > 32, "only %zu of 63 pixels differ from the first", others);
    others = 0;
    for (size_t y = 0; y < 48; y++)
        others += rk_image_at(&picture.image, 0, y)->x != rk_image_at(&picture.image, 0, y + 16)->x;
    rk_check(others > 24, "only %zu of 48 pixels differ from those one tile below", others);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* The others get 0, as shading.h says: a normalization costs more than Lambert's law. */
static void models_that_read_the_direction_to_the_viewer_are_told_it(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_accel accel;
    rk_error error;
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_MEDIAN, &scene, &error), error);
    for (int model = RK_SHADING_OFF; model <= RK_SHADING_GRADIENT; model++) {
        rk_render_options options = rk_render_options_default();
        options.shading.model = (rk_shading_model)model;
        const rk_rendering r = {.scene = &scene,
                                .accel = &accel,
                                .options = &options,
                                .plan = rk_plan_of(&scene, &options),
                                .view = rk_view_of(&scene.camera, 40, 40)};
        bool reads = model == RK_SHADING_PHONG || model == RK_SHADING_BLINN_PHONG;
        for (uint32_t i = 0; i < 40 * 40; i++) {
            rk_ray ray = rk_view_ray(&r.view, (float)(i % 40) + 0.5f, (float)(i / 40) + 0.5f);
            rk_hit hit = rk_trace_one(&accel, &ray);
            rk_path_batch paths = {.rays = {.count = 0}};
            rk_shading_point point;
            if (hit.triangle == RK_MISS)
                continue;
            rk_path_push(&paths, &ray, 0, rk_path_start(0, 0));
            rk_shading_point_at(&point, &r, &paths, 0, &hit, 0);
            /* A normalization's roundings. */
            rk_check_near(rk_dot(point.to_viewer, ray.direction), reads ? -1 : 0, 4 * 0x1p-24,
                          "model %d, pixel %u: the cosine of v with the ray", model, i);
            rk_check_near(rk_length(point.to_viewer), reads, 4 * 0x1p-24,
                          "model %d, pixel %u: v's length", model, i);
        }
    }
    rk_accel_free(&accel);
    rk_scene_free(&scene);
}

/* --- Camera rays ------------------------------------------------------------------------------ */

static void check_rays_of_tile(const rk_rendering *r, uint32_t index)
{
    static rk_path_batch paths;
    rk_counters counters = {0};
    const rk_sample_pass pass = {
        .tile = rk_tile_at(r->options, index), .samples = 1, .counters = &counters};
    rk_camera_stage(r, &pass, &paths);
    rk_check(paths.rays.count == pass.tile.width * pass.tile.height, "%u rays for %u x %u pixels",
             paths.rays.count, pass.tile.width, pass.tile.height);
    bool seen[RK_BATCH_MAX] = {false};
    for (uint32_t i = 0; i < paths.rays.count; i++) {
        const uint32_t pixel = paths.pixel[i];
        rk_check(pixel < paths.rays.count && !seen[pixel], "pixel %u: not one ray", pixel);
        seen[pixel] = true;
        const uint32_t x = pass.tile.x + pixel % pass.tile.width;
        const uint32_t y = pass.tile.y + pixel / pass.tile.width;
        const rk_ray got = rk_batch_ray(&paths.rays, i);
        const rk_ray want = rk_view_ray(&r->view, (float)x + 0.5f, (float)y + 0.5f);
        rk_check(memcmp(&got, &want, sizeof got) == 0,
                 "pixel (%u, %u), entry %u: the ray's direction is (%.9g, %.9g, %.9g), the view's "
                 "(%.9g, %.9g, %.9g)",
                 x, y, paths.pixel[i], (double)got.direction.x, (double)got.direction.y,
                 (double)got.direction.z, (double)want.direction.x, (double)want.direction.y,
                 (double)want.direction.z);
    }
}

/* Sizes for which the last tiles' rows are no multiple of the lanes computed at once. */
static void camera_rays_are_the_views_rays_through_the_centres(void **state)
{
    (void)state;
    static const uint32_t sizes[][2] = {{1, 1}, {16, 16}, {17, 3}, {31, 33}, {50, 7}, {32768, 1}};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        const rk_render_options options = size_of(sizes[i][0], sizes[i][1]);
        const rk_camera camera = rk_camera_default();
        const rk_rendering r = {.options = &options,
                                .view = rk_view_of(&camera, sizes[i][0], sizes[i][1])};
        for (uint32_t k = 0; k < rk_tile_count(&options); k++)
            check_rays_of_tile(&r, k);
    }
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_facing_triangle_shines_by_lamberts_law),
    cmocka_unit_test(colours_of_vertices_are_seen_also_through_transparency),
    cmocka_unit_test(where_a_picture_cuts_a_surface_out_there_is_none),
    cmocka_unit_test(a_single_ray_passes_where_a_picture_cuts_out),
    cmocka_unit_test(a_cut_out_makes_nothing_else_transparent),
    cmocka_unit_test(a_point_light_is_shaded_as_by_its_unit_directions_to_the_bit),
    cmocka_unit_test(several_lights_add_up),
    cmocka_unit_test(a_surface_lit_from_behind_is_black),
    cmocka_unit_test(an_occluder_shadows_the_region_that_projects_onto_it),
    cmocka_unit_test(surfaces_beyond_the_light_cast_no_shadow),
    cmocka_unit_test(convex_bodies_cast_no_shadow_on_themselves),
    cmocka_unit_test(the_picture_is_the_same_for_any_number_of_threads),
    cmocka_unit_test(the_seed_changes_random_samples_and_nothing_else),
    cmocka_unit_test(every_tile_is_a_step_of_progress),
    cmocka_unit_test(without_triangles_lights_or_colour_no_ray_is_traced),
    cmocka_unit_test(the_plan_is_empty_for_a_picture_that_is_black_anyway),
    cmocka_unit_test(the_counters_match_the_options),
    cmocka_unit_test(black_lights_and_black_surfaces_cost_no_shadow_ray),
    cmocka_unit_test(an_exact_sphere_is_round_and_lies_before_and_behind_triangles),
    cmocka_unit_test(an_exact_sphere_casts_a_shadow_but_none_on_itself),
    cmocka_unit_test(samples_converge_to_the_covered_part_of_the_pixel),
    cmocka_unit_test(each_pixel_has_samples_of_its_own),
    cmocka_unit_test(models_that_read_the_direction_to_the_viewer_are_told_it),
    cmocka_unit_test(camera_rays_are_the_views_rays_through_the_centres),
};

RK_SUITE("render", tests)
