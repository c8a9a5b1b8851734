/* The renderer with a lens: surfaces in focus are the pinhole's picture to the bit and take no lens
 * samples; a spot out of focus becomes a disk with the size and the light of the closed form. */
#include "test_scene.h"

#include "render/blurred_pixels.h"

enum { side = 64 };
static const float half_height = 0.466307658f; /* tan 25 degrees */

static rk_render_options pinhole(void)
{
    rk_render_options options = rk_render_options_default();
    options.width = options.height = side;
    options.shading.model = RK_SHADING_OFF;
    return options;
}

static rk_render_options with_lens(float focal_distance, float aperture, uint32_t lens_samples)
{
    rk_render_options options = pinhole();
    options.lens.focal_distance = focal_distance;
    options.lens.aperture = aperture;
    options.lens_samples = lens_samples;
    return options;
}

static void white_light(rk_scene *scene)
{
    test_scene_light(scene, rk_vec(0, 0, -5), rk_vec(1, 1, 1));
}

/* A white wall of half a picture's depth, and its light; the camera is 3 before z = 0. */
static rk_scene make_wall(float z)
{
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, z, 0);
    scene.mesh.materials[0].kd = rk_vec(0.5f, 0.25f, 1);
    white_light(&scene);
    return scene;
}

static void check_same_as_pinhole(const rk_scene *scene, rk_render_options options,
                                  const char *hint)
{
    test_picture lens = test_render(scene, options, 2);
    options.lens_samples = 0;
    test_picture sharp = test_render(scene, options, 2);
    rk_check_equal(lens.counters.lens_samples, 0, hint);
    rk_check_equal(lens.counters.pixel_samples, sharp.counters.pixel_samples, hint);
    rk_check(test_same_pixels(&lens.image, &sharp.image), "not the pinhole's picture: %s", hint);
    rk_image_free(&lens.image);
    rk_image_free(&sharp.image);
}

/* --- In focus --------------------------------------------------------------------------------- */

static void without_aperture_or_samples_the_picture_is_the_pinholes_to_the_bit(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell");
    rk_render_options options = with_lens(1, 0, 25);
    options.shadows = options.reflections = true;
    for (options.samples = 1; options.samples <= 4; options.samples += 3) {
        rk_plan plan = rk_plan_of(&scene, &options);
        rk_check(!plan.depth_of_field, "a lens without aperture is none");
        check_same_as_pinhole(&scene, options, "aperture 0");
        test_picture lens = test_render(&scene, options, 2);
        options.lens_samples = 0;
        options.lens.aperture = 10;
        test_picture none = test_render(&scene, options, 2);
        rk_check_equal(none.counters.primary_rays, side * side * options.samples, "no other rays");
        rk_check_equal(none.counters.lens_samples, 0, "the options have none");
        rk_check(test_same_pixels(&lens.image, &none.image), "no samples, and another picture");
        rk_image_free(&lens.image);
        rk_image_free(&none.image);
    }
    rk_scene_free(&scene);
}

static void a_wall_in_focus_takes_no_lens_samples(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0);
    rk_render_options options = with_lens(3, 50, 25);
    check_same_as_pinhole(&scene, options, "all of it is in focus");
    options.samples = 4;
    check_same_as_pinhole(&scene, options, "all of it is in focus, with four samples per pixel");
    test_picture lens = test_render(&scene, options, 1);
    rk_check_equal(lens.counters.primary_rays, side * side * (4 + 1),
                   "a ray per pixel to find circles of confusion, then the pinhole's");
    rk_image_free(&lens.image);
    rk_scene_free(&scene);
}

static void an_empty_scene_takes_no_lens_samples(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(0);
    white_light(&scene);
    rk_render_options options = with_lens(1, 50, 25);
    test_picture picture = test_render(&scene, options, 1);
    rk_check_equal(picture.counters.primary_rays, 0, "an empty scene needs no ray");
    rk_check_equal(picture.counters.lens_samples, 0, "an empty scene needs no lens");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* --- The blur of a bright spot ---------------------------------------------------------------- */

/* A square of `pixels` pixels a side at a depth in the middle of the picture, across the view. */
static void place_spot(rk_scene *scene, uint32_t triangle, float depth, float pixels)
{
    rk_view view = rk_view_of(&scene->camera, side, side);
    float size = pixels * depth * view.pixel;
    rk_vec3 middle = rk_madd(view.position, view.forward, depth);
    rk_vec3 corner = rk_madd(rk_madd(middle, view.right, -0.5f * size), view.up, -0.5f * size);
    test_scene_quad(scene, triangle, corner, rk_scale(view.right, size), rk_scale(view.up, size));
}

typedef struct moments {
    double sum, xx, yy, xy; /* of the light, about the middle, over the sum: in pixels */
    double reach;           /* the farthest pixel centre that got any */
} moments;

static moments moments_of(const rk_image *image)
{
    moments m = {0};
    for (size_t y = 0; y < side; y++)
        for (size_t x = 0; x < side; x++) {
            double light = (double)rk_image_at(image, x, y)->x;
            double dx = (double)x + 0.5 - side / 2, dy = (double)y + 0.5 - side / 2;
            m.sum += light;
            m.xx += light * dx * dx;
            m.yy += light * dy * dy;
            m.xy += light * dx * dy;
            m.reach = light > 0 ? fmax(m.reach, hypot(dx, dy)) : m.reach;
        }
    m.xx /= m.sum, m.yy /= m.sum, m.xy /= m.sum;
    return m;
}

/* A disk of diameter c, smeared by a square of side s and by the pixels' own: mean squares on an
 * axis are c^2 / 16, s^2 / 12 and 1 / 12. `samples` yes-or-no samples per pixel found s^2 in all.
 */
static void check_disk(const rk_image *image, double diameter, double spot, double samples)
{
    moments m = moments_of(image);
    double found = spot * spot * samples, relative = 1 / sqrt(found);
    double square = diameter * diameter / 16 + spot * spot / 12 + 1.0 / 12;
    rk_check_close(m.sum, spot * spot, 4 * relative * spot * spot,
                   "as much light as without a lens, within 4 standard errors");
    /* A disk's mean fourth power on an axis is twice the square of its mean square. */
    rk_check_close(m.xx, square, 4 * relative * square, "the spread along rows");
    rk_check_close(m.yy, square, 4 * relative * square, "the spread along columns");
    rk_check_close(m.xy, 0, 4 * relative * square, "a disk is not slanted");
    double rim = diameter / 2 + (spot + 1) / sqrt(2);
    rk_check(m.reach <= rim && m.reach > rim - 2, "light up to %.2f pixels, the rim is at %.2f",
             m.reach, rim);
}

static double circle_at(const rk_render_options *options, double depth)
{
    double f = (double)options->lens.focal_distance;
    double pixel = 2 * (double)half_height / side;
    return 0.001 * (double)options->lens.aperture * fabs(depth - f) / (depth * f * pixel);
}

/* 4 standard errors are then 3 % of a mean square; circles of 80 % of the diameter are off by 30.
 */
enum { spot_samples = 1024 };

static void check_spot(rk_vec3 rotation, float focal_distance, float depth, rk_focal_surface focal)
{
    rk_scene scene = test_scene_make(2);
    scene.camera.rotation = rotation;
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    place_spot(&scene, 0, depth, 2);
    white_light(&scene);
    rk_render_options options = with_lens(focal_distance, 400, spot_samples);
    options.lens.focal = focal;
    options.lens_sampling = RK_SAMPLER_UNIFORM;
    test_picture picture = test_render(&scene, options, 2);
    check_disk(&picture.image, circle_at(&options, (double)depth), 2, spot_samples);
    options.lens_samples = 0;
    test_picture sharp = test_render(&scene, options, 1);
    rk_check_close(moments_of(&sharp.image).sum, 4, 0, "the pinhole's spot is four pixels");
    rk_image_free(&sharp.image);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void a_spot_behind_the_focus_becomes_the_closed_forms_disk(void **state)
{
    (void)state;
    check_spot(rk_vec(0, 0, 0), 2, 5, RK_FOCAL_PLANE);
    check_spot(rk_vec(0, 0, 0), 3, 4, RK_FOCAL_PLANE);
    check_spot(rk_vec(0, 0, 0), 2, 5, RK_FOCAL_SPHERE);
}

static void a_spot_before_the_focus_becomes_the_closed_forms_disk(void **state)
{
    (void)state;
    check_spot(rk_vec(0, 0, 0), 4, 1.75f, RK_FOCAL_PLANE);
    check_spot(rk_vec(0, 0, 0), 4, 1.75f, RK_FOCAL_SPHERE);
}

static void the_lens_turns_with_the_camera(void **state)
{
    (void)state;
    check_spot(rk_vec(0, 90, 0), 2, 5, RK_FOCAL_PLANE);
    check_spot(rk_vec(70, -40, 30), 2, 5, RK_FOCAL_PLANE);
}

static void reflections_are_blurred_by_the_length_of_the_whole_path(void **state)
{
    (void)state;
    /* A mirror in focus 3 ahead, and 7 behind it, counted along the ray, a spot behind the camera:
     * 10 in all. The mirror is no larger than the blurred spot needs, a third of the picture. */
    rk_scene scene = test_scene_of(4, 2);
    test_scene_quad(&scene, 0, rk_vec(-0.5f, -0.5f, 0), rk_vec(1, 0, 0), rk_vec(0, 1, 0));
    scene.mesh.materials[0].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[0].ks = rk_vec(1, 1, 1);
    float size = 2 * 10 * 2 * half_height / side;
    test_scene_quad(&scene, 2, rk_vec(-0.5f * size, -0.5f * size, -7), rk_vec(size, 0, 0),
                    rk_vec(0, size, 0));
    scene.mesh.materials[1].kd = rk_vec(1, 1, 1);
    scene.mesh.triangle_materials[2] = scene.mesh.triangle_materials[3] = 1;
    white_light(&scene);
    rk_render_options options = with_lens(3, 400, spot_samples);
    options.lens_sampling = RK_SAMPLER_UNIFORM;
    check_same_as_pinhole(&scene, options, "the mirror itself is in focus");
    options.reflections = true;
    test_picture picture = test_render(&scene, options, 2);
    check_disk(&picture.image, circle_at(&options, 10), 2, spot_samples);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* --- Which pixels take samples ---------------------------------------------------------------- */

/* The left half of the picture is a wall in focus, the right half one that is not. */
static rk_scene make_halves(float focused, float blurred)
{
    rk_scene scene = test_scene_of(4, 2);
    float a = focused - 3, b = blurred - 3;
    test_scene_quad(&scene, 0, rk_vec(0, -9, a), rk_vec(9, 0, 0), rk_vec(0, 18, 0));
    test_scene_quad(&scene, 2, rk_vec(-9, -9, b), rk_vec(9, 0, 0), rk_vec(0, 18, 0));
    scene.mesh.triangle_materials[2] = scene.mesh.triangle_materials[3] = 1;
    scene.mesh.materials[0].kd = rk_vec(1, 0, 0);
    scene.mesh.materials[1].kd = rk_vec(0, 1, 0);
    white_light(&scene);
    return scene;
}

static void only_pixels_within_reach_of_a_blurred_half_take_lens_samples(void **state)
{
    (void)state;
    const float depths[] = {2, 6};
    for (int i = 0; i < 2; i++) {
        rk_scene scene = make_halves(3, depths[i]);
        rk_render_options options = with_lens(3, 300, 25);
        test_picture lens = test_render(&scene, options, 2);
        options.lens_samples = 0;
        test_picture sharp = test_render(&scene, options, 2);
        size_t reach = (size_t)ceil(circle_at(&options, (double)depths[i]) / 2);
        size_t columns = side / 2 + reach, mixed = 0;
        rk_check(reach >= 2 && reach < 16, "the circle reaches %zu pixels", reach);
        rk_check_equal(lens.counters.lens_samples, side * columns * 25,
                       "25 for each blurred pixel");
        rk_check_equal(
            lens.counters.primary_rays,
            (side + 2 * reach) * (side + 2 * reach) + side * (columns * 25 + (side - columns)),
            "one for the circle of confusion, also in a margin of the largest circle, 25 "
            "or one for the picture");
        for (size_t y = 0; y < side; y++)
            for (size_t x = 0; x < side / 2; x++) {
                rk_vec3 *a = rk_image_at(&lens.image, x, y), *b = rk_image_at(&sharp.image, x, y);
                if (x < side - columns)
                    rk_check(memcmp(a, b, sizeof *a) == 0, "pixel (%zu, %zu) is beyond", x, y);
                mixed += a->y > 0;
            }
        /* Nearer things spill over the half in focus, and farther ones don't. */
        rk_check(depths[i] < 3 ? mixed > side : mixed == 0,
                 "%zu pixels of the half in focus got light of the other", mixed);
        rk_image_free(&lens.image);
        rk_image_free(&sharp.image);
        rk_scene_free(&scene);
    }
}

/* --- Beside the picture ----------------------------------------------------------------------- */

/* A white wall in focus at depth 3, and a black card at depth 1 that begins `beside` pixels outside
 * of the picture, to its right for side 0, above it for 1, and so on. */
static rk_scene make_card(int card_side, float beside)
{
    rk_scene scene = test_scene_of(4, 2);
    rk_view view = rk_view_of(&scene.camera, side, side);
    const rk_vec3 outwards[] = {view.right, view.up, rk_negate(view.right), rk_negate(view.up)};
    rk_vec3 out = outwards[card_side], along = outwards[(card_side + 1) % 4];
    rk_vec3 edge =
        rk_madd(rk_add(view.position, view.forward), out, (side / 2 + beside) * view.pixel);
    test_scene_wall(&scene, 0, 0, 0);
    test_scene_quad(&scene, 2, rk_madd(edge, along, -9), rk_scale(out, 9), rk_scale(along, 18));
    scene.mesh.triangle_materials[2] = scene.mesh.triangle_materials[3] = 1;
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    scene.mesh.materials[1].kd = rk_vec(0, 0, 0);
    white_light(&scene);
    return scene;
}

/* The fraction of a disk of diameter c on one side of a line, `away` from the centre on the other
 * side, by its chords; the mean over a pixel. */
static double covered(double away, double c)
{
    enum { steps = 40, chords = 1000 };
    double sum = 0;
    for (int k = 0; k < chords; k++) {
        double at = (2 * k + 1.0) / chords - 1;
        for (int i = 0; i < steps; i++)
            sum += at > (away + (i + 0.5) / steps - 0.5) / (0.5 * c) ? 2 * sqrt(1 - at * at) : 0;
    }
    return sum * 2 / chords / steps / 3.14159265358979323846;
}

static void check_card(int card_side, double beside, rk_focal_surface focal)
{
    const uint32_t samples = 64;
    rk_scene scene = make_card(card_side, (float)beside);
    rk_render_options options = with_lens(3, 500, samples);
    options.lens.focal = focal;
    double c = circle_at(&options, 1);
    test_picture picture = test_render(&scene, options, 2);
    rk_check(0.5 * c > beside + 2 && 0.5 * c < side / 2, "the card's circle of %g reaches inside",
             c);
    for (int k = 0; k < side; k++) { /* rows or columns, counted from the card's side */
        double sum = 0, want = 1 - covered(k + 0.5 + beside, c);
        for (int i = side / 4; i < side * 3 / 4; i++) {
            size_t x = (size_t)(card_side == 0 ? side - 1 - k : card_side == 2 ? k : i);
            size_t y = (size_t)(card_side == 1 ? k : card_side == 3 ? side - 1 - k : i);
            sum += (double)rk_image_at(&picture.image, x, y)->x / (side / 2);
        }
        /* 5 standard errors of the mean of half a line's pixels. Seen from near the border, a focal
         * sphere's circle is up to a fifth larger: then only the middle of the edge is compared. */
        double tolerance = 5 * sqrt(want * (1 - want) / (samples * side / 2)) + 1e-3;
        if (focal == RK_FOCAL_PLANE)
            rk_check(fabs(sum - want) <= tolerance,
                     "side %d, line %d: got %.4f, want %.4f within %.4f: the card outside of the "
                     "picture covers part of the lens",
                     card_side, k, sum, want, tolerance);
        else
            rk_check(k > 2 || fabs(sum - want) <= 0.3 * (1 - want),
                     "focal sphere, side %d, line %d: got %.4f, want about %.4f", card_side, k, sum,
                     want);
    }
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void a_near_thing_beside_the_picture_is_blurred_into_it(void **state)
{
    (void)state;
    for (int card_side = 0; card_side < 4; card_side++) {
        check_card(card_side, 3, RK_FOCAL_PLANE);
        check_card(card_side, 0.5, RK_FOCAL_PLANE);
    }
    check_card(0, 3, RK_FOCAL_SPHERE);
}

/* A near thing that flies past a wall in focus. Equidistant times are the same for all pixels: at
 * one of them, centre rays would find it in one place only. */
static uint64_t samples_beside_flight(rk_time_sampling sampling)
{
    rk_scene scene = test_scene_of(3, 1);
    test_scene_wall(&scene, 0, 0, 0);
    test_scene_triangle(&scene, 2, rk_vec(-0.4f, -0.1f, -2), rk_vec(-0.3f, -0.1f, -2),
                        rk_vec(-0.35f, 0.1f, -2));
    white_light(&scene);
    scene.moving[scene.moving_count++] = (rk_moving){2, 1, {0, 0, 0}};
    rk_render_options options = with_lens(3, 200, 4);
    options.motion.samples = 16;
    options.motion.sampling = sampling;
    options.motion.shutter = (rk_shutter){0, 0.7f};
    test_picture picture = test_render(&scene, options, 2);
    uint64_t samples = picture.counters.lens_samples;
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
    return samples;
}

static void a_flying_thing_is_blurred_all_along_its_path_at_equidistant_times(void **state)
{
    (void)state;
    uint64_t want = samples_beside_flight(RK_TIME_STRATIFIED);
    uint64_t got = samples_beside_flight(RK_TIME_EQUIDISTANT);
    rk_check(want > 0 && got == want,
             "%llu lens samples, but %llu at stratified times: centre rays need times of their own",
             (unsigned long long)got, (unsigned long long)want);
}

/* From beside the card's edge to its end all pixels look the same; only the picture's border
 * differs. */
static void the_margin_is_no_wider_than_the_largest_circle(void **state)
{
    (void)state;
    rk_scene scene = make_card(0, 3);
    rk_render_options options = with_lens(3, 500, 1);
    options.lens_samples = 4;
    uint64_t reach = (uint64_t)ceil(circle_at(&options, 1) / 2), wide = side + 2 * reach;
    test_picture picture = test_render(&scene, options, 2);
    uint64_t blurred = picture.counters.lens_samples / 4, sharp = side * side - blurred;
    rk_check_equal(picture.counters.primary_rays, wide * wide + 4 * blurred + sharp,
                   "a ray for each pixel of the picture and of the margin");
    rk_check(blurred <= side * reach, "%llu pixels took lens samples, want %llu at most",
             (unsigned long long)blurred, (unsigned long long)(side * reach));
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* Half of its length as a margin would be a picture of its length squared. */
static void a_long_picture_has_a_margin_in_proportion_to_its_pixels(void **state)
{
    (void)state;
    rk_scene scene = make_card(0, 3);
    for (int way = 0; way < 2; way++) {
        rk_render_options options = with_lens(3, 1e6f, 1);
        options.width = way ? 600 : 1, options.height = way ? 1 : 600;
        options.lens_samples = 2;
        uint64_t pixels = 600;
        test_picture picture = test_render(&scene, options, 2);
        uint64_t blurred = picture.counters.lens_samples / 2, sharp = pixels - blurred;
        uint64_t centres = picture.counters.primary_rays - 2 * blurred - sharp;
        rk_check(
            centres > pixels && centres <= 16 * pixels,
            "%u x %u: %llu centre rays, want 16 per pixel at most, and some beside the picture",
            options.width, options.height, (unsigned long long)centres);
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void a_plane_is_flat_and_a_sphere_is_round(void **state)
{
    (void)state;
    rk_scene wall = make_wall(0);
    rk_render_options options = with_lens(3, 200, 16);
    options.lens.focal = RK_FOCAL_SPHERE;
    test_picture picture = test_render(&wall, options, 2);
    rk_check(picture.counters.lens_samples > 0, "a wall's corners are beyond the focal sphere");
    rk_check(picture.counters.lens_samples < side * side * 16, "its middle is not");
    rk_image_free(&picture.image);
    rk_scene_free(&wall);
    /* The camera in the middle of a sphere. */
    rk_scene ball = test_scene_make(0);
    ball.spheres[0] = (rk_sphere){rk_vec(0, 0, -3), 2};
    ball.sphere_materials[0] = (rk_material){.kd = rk_vec(1, 1, 1), .alpha = 1};
    ball.sphere_count = 1;
    test_scene_light(&ball, rk_vec(0, 0, -3.5f), rk_vec(1, 1, 1));
    options.lens.focal_distance = 2;
    check_same_as_pinhole(&ball, options, "all of it is on the focal sphere");
    options.lens.focal = RK_FOCAL_PLANE;
    picture = test_render(&ball, options, 2);
    rk_check(picture.counters.lens_samples > 0, "all but the middle is before the focal plane");
    rk_image_free(&picture.image);
    rk_scene_free(&ball);
}

static void transparent_surfaces_in_focus_take_samples_for_surfaces_behind_them(void **state)
{
    (void)state;
    const float behind[] = {3, 6};
    for (int i = 0; i < 2; i++) {
        rk_scene scene = test_scene_of(4, 2);
        test_scene_wall(&scene, 0, 0, 0);
        test_scene_wall(&scene, 2, behind[i] - 3, 1);
        scene.mesh.materials[0].alpha = 0.5f;
        white_light(&scene);
        rk_render_options options = with_lens(3, 200, 16);
        check_same_as_pinhole(&scene, options, "the surface is in focus, and opaque so far");
        options.transparency = true;
        test_picture picture = test_render(&scene, options, 2);
        rk_check_equal(picture.counters.lens_samples, i ? side * side * 16 : 0,
                       i ? "the wall behind it is blurred" : "the wall behind it is sharp");
        rk_image_free(&picture.image);
        rk_scene_free(&scene);
    }
}

/* Returns how many pixels are marked: those that take lens samples, as all others are the pinhole's
 * to the bit. */
static uint32_t check_marks(const rk_scene *scene, rk_render_options options, const char *hint)
{
    test_picture lens = test_render(scene, options, 2);
    const uint32_t lens_samples = options.lens_samples;
    bool blurred[side * side];
    rk_error error;
    rk_accel accel;
    rk_pool *pool = rk_pool_start(2, &error);
    rk_check_ok(pool != NULL, error);
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_WIDE, scene, &error), error);
    rk_check_ok(rk_blurred_pixels(blurred, scene, &accel, &options, pool, &error), error);
    options.lens_samples = 0;
    test_picture pinhole = test_render(scene, options, 2);
    uint32_t count = 0;
    for (int i = 0; i < side * side; i++) {
        count += blurred[i];
        rk_check(blurred[i] ||
                     memcmp(&lens.image.pixels[i], &pinhole.image.pixels[i], sizeof(rk_vec3)) == 0,
                 "%s: pixel %d, %d has no mark, and is not the pinhole's", hint, i % side,
                 i / side);
    }
    rk_check_equal(count * lens_samples, lens.counters.lens_samples, hint);
    rk_accel_free(&accel);
    rk_pool_stop(pool);
    rk_image_free(&pinhole.image);
    rk_image_free(&lens.image);
    return count;
}

/* A background out of focus is blurred as well, one that is black is not. */
static void marks_are_the_pixels_that_take_lens_samples(void **state)
{
    (void)state;
    const char *names[] = {"statue:967", "teapot:4", "panes"};
    for (int i = 0; i < 3; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        rk_render_options options = with_lens(2, 300, 3);
        options.transparency = true;
        scene.background = 0;
        const uint32_t before_black = check_marks(&scene, options, names[i]);
        scene.background = 0.25f;
        const uint32_t before_grey = check_marks(&scene, options, names[i]);
        rk_check(before_black > 0 && before_black < side * side && before_grey > before_black,
                 "%s: %u pixels are marked before black, %u before grey", names[i], before_black,
                 before_grey);
        rk_scene_free(&scene);
    }
}

static void what_the_renderer_refuses_has_no_marks(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0);
    rk_render_options options = with_lens(-1, 120, 4);
    rk_error error;
    bool none;
    rk_check(!rk_blurred_pixels(&none, &scene, NULL, &options, NULL, &error), "no focus");
    rk_check_error_names(error, "focal");
    rk_scene_free(&scene);
}

/* --- Samples ---------------------------------------------------------------------------------- */

static void the_picture_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("cornell-light");
    rk_render_options options = with_lens(2.5f, 100, 6);
    options.shadows = options.reflections = true;
    options.samples = 2;
    options.light.samples = 3; /* stratified among 2 or 6 times as many */
    test_picture one = test_render(&scene, options, 1);
    rk_check(one.counters.lens_samples > 0, "nothing is blurred");
    const uint32_t threads[] = {2, 5};
    for (int i = 0; i < 2; i++) {
        test_picture other = test_render(&scene, options, threads[i]);
        rk_check(test_same_pixels(&one.image, &other.image), "other pixels with %u threads",
                 threads[i]);
        rk_check(memcmp(&one.counters, &other.counters, sizeof one.counters) == 0,
                 "other counts with %u threads", threads[i]);
        rk_image_free(&other.image);
    }
    rk_image_free(&one.image);
    rk_scene_free(&scene);
}

static void each_pixel_has_lens_points_of_its_own(void **state)
{
    (void)state;
    /* In a blurred edge: with the same points for all, the rows of a column were equal. */
    rk_scene scene = make_halves(3, 2);
    rk_render_options options = with_lens(3, 300, 64);
    options.lens_sampling = RK_SAMPLER_UNIFORM;
    test_picture picture = test_render(&scene, options, 2);
    const rk_image *image = &picture.image;
    size_t others = 0, below = 0;
    for (size_t y = 1; y < side; y++)
        others += rk_image_at(image, side / 2, y)->y != rk_image_at(image, side / 2, 0)->y;
    for (size_t y = 0; y + 16 < side; y++)
        below += rk_image_at(image, side / 2, y)->y != rk_image_at(image, side / 2, y + 16)->y;
    rk_check(others > side / 2, "only %zu of %d pixels differ from the first", others, side - 1);
    rk_check(below > side / 2 - 8, "only %zu of %d pixels differ from those one tile below", below,
             side - 16);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void a_blurred_pixel_takes_as_many_samples_as_the_more_demanding_asks(void **state)
{
    (void)state;
    rk_scene scene = make_wall(3);
    const uint32_t requested[][3] = {{1, 7, 7}, {4, 7, 7}, {9, 7, 9}};
    for (int i = 0; i < 3; i++) {
        rk_render_options options = with_lens(3, 200, requested[i][1]);
        options.samples = requested[i][0];
        test_picture picture = test_render(&scene, options, 2);
        rk_check_equal(picture.counters.lens_samples, side * side * requested[i][2],
                       "each with a place in the pixel and one on the lens");
        /* A wall of one colour stays it; a mean of 9 has that many roundings. */
        for (size_t k = 0; k < side * side; k++)
            rk_check_close(picture.image.pixels[k].y, 0.25, 9 * 0x1p-24, "the mean of samples");
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void a_lens_without_focus_is_refused(void **state)
{
    (void)state;
    rk_scene scene = make_wall(0);
    rk_accel accel;
    rk_error error;
    rk_image image;
    rk_counters counters;
    rk_pool *pool = rk_pool_start(1, &error);
    rk_check_ok(rk_accel_build(&accel, RK_ACCEL_MEDIAN, &scene, &error), error);
    rk_check_ok(rk_image_init(&image, side, side, &error), error);
    const float wrong[][2] = {{0, 10}, {-1, 10}, {NAN, 10}, {1, -1}, {1, NAN}};
    for (int i = 0; i < 5; i++) {
        rk_render_options options = with_lens(wrong[i][0], wrong[i][1], 15);
        rk_check(!rk_render(&image, &scene, &accel, &options, pool, &counters, NULL, &error),
                 "focal distance %g, aperture %g", (double)wrong[i][0], (double)wrong[i][1]);
        rk_check_error_names(error, "lens");
    }
    rk_image_free(&image);
    rk_accel_free(&accel);
    rk_pool_stop(pool);
    rk_scene_free(&scene);
}

/* --- The order of samples --------------------------------------------------------------------- */

/* Where each sample adds one number to its pixel, samples are traced in the order of their places
 * on the lens, but added in their own. With a second light they are traced in their own order, too;
 * its light is too weak to change a sum. */
static void the_order_in_which_samples_are_traced_does_not_change_a_bit(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("teapot:4");
    for (uint32_t samples = 1; samples <= 70; samples += 23) {
        rk_render_options options = with_lens(1, 100, samples);
        options.shading.model = RK_SHADING_GRADIENT;
        options.shading.gradient = rk_gradient_cool_to_warm();
        scene.light_count = 1;
        test_picture sorted = test_render(&scene, options, 2);
        scene.lights[scene.light_count++] = rk_light_point(rk_vec(0, 5, 0), rk_vec(1e-30f, 0, 0));
        test_picture in_order = test_render(&scene, options, 2);
        rk_check(in_order.counters.lens_samples > 100, "nothing is out of focus");
        rk_check(test_same_pixels(&sorted.image, &in_order.image),
                 "with %u samples the picture depends on the order in which they are traced",
                 samples);
        rk_image_free(&sorted.image);
        rk_image_free(&in_order.image);
    }
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(without_aperture_or_samples_the_picture_is_the_pinholes_to_the_bit),
    cmocka_unit_test(a_wall_in_focus_takes_no_lens_samples),
    cmocka_unit_test(an_empty_scene_takes_no_lens_samples),
    cmocka_unit_test(a_spot_behind_the_focus_becomes_the_closed_forms_disk),
    cmocka_unit_test(a_spot_before_the_focus_becomes_the_closed_forms_disk),
    cmocka_unit_test(the_lens_turns_with_the_camera),
    cmocka_unit_test(reflections_are_blurred_by_the_length_of_the_whole_path),
    cmocka_unit_test(only_pixels_within_reach_of_a_blurred_half_take_lens_samples),
    cmocka_unit_test(a_near_thing_beside_the_picture_is_blurred_into_it),
    cmocka_unit_test(a_flying_thing_is_blurred_all_along_its_path_at_equidistant_times),
    cmocka_unit_test(the_margin_is_no_wider_than_the_largest_circle),
    cmocka_unit_test(a_long_picture_has_a_margin_in_proportion_to_its_pixels),
    cmocka_unit_test(a_plane_is_flat_and_a_sphere_is_round),
    cmocka_unit_test(transparent_surfaces_in_focus_take_samples_for_surfaces_behind_them),
    cmocka_unit_test(marks_are_the_pixels_that_take_lens_samples),
    cmocka_unit_test(what_the_renderer_refuses_has_no_marks),
    cmocka_unit_test(the_picture_is_the_same_for_any_number_of_threads),
    cmocka_unit_test(each_pixel_has_lens_points_of_its_own),
    cmocka_unit_test(a_blurred_pixel_takes_as_many_samples_as_the_more_demanding_asks),
    cmocka_unit_test(a_lens_without_focus_is_refused),
    cmocka_unit_test(the_order_in_which_samples_are_traced_does_not_change_a_bit),
};

RK_SUITE("depth_of_field_stage", tests)
