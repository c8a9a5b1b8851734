/* Motion blur in the renderer: moving objects, their shadows, their reflections and moving glass
 * cover pixels for a fraction of the time, in closed form; and static scenes cost nothing. */
#include "test_scene.h"

static const double pi = 3.14159265358979323846;

enum { width = 30, height = 22, times = 64 };

/* Colours without light's cosine, so that a pixel's colour is a fraction of the time. */
static rk_render_options blurred(float open, float close)
{
    rk_render_options options = rk_render_options_default();
    options.width = width;
    options.height = height;
    options.shading.model = RK_SHADING_OFF;
    options.motion.samples = times;
    options.motion.shutter = (rk_shutter){open, close};
    return options;
}

typedef struct place {
    double x, y;
} place;

/* The point of the plane at `reach` from the camera along z on which a pixel's centre projects. */
static place seen_at(size_t column, size_t row, double reach)
{
    double half = tan(25 * pi / 180);
    double across = 2 * ((double)column + 0.5) / width - 1,
           up = 1 - 2 * ((double)row + 0.5) / height;
    return (place){-across * half * width / height * reach, up * half * reach};
}

/* A square of side 2 `half` around (x, y) at depth z, of the material 0, as triangles `index` and
 * `index + 1`. */
static void put_square(rk_scene *scene, uint32_t index, double x, double y, float z, float half)
{
    test_scene_quad(scene, index, rk_vec((float)x - half, (float)y - half, z),
                    rk_vec(2 * half, 0, 0), rk_vec(0, 2 * half, 0));
}

/* A white light before everything, and one moving object: all triangles from `first` on. */
static void set_moving(rk_scene *scene, uint32_t first, rk_motion motion)
{
    scene->moving[scene->moving_count++] =
        (rk_moving){first, scene->mesh.triangle_count - first, motion};
}

static void shine(rk_scene *scene)
{
    test_scene_light(scene, rk_vec(0.4f, 0.3f, -2.5f), rk_vec(1, 1, 1));
}

static const rk_motion level = {0, 0, 0}; /* straight along x, x units at the time x */

/* The fraction of the shutter interval during which low + x <= p <= high + x. */
static double fraction_between(rk_shutter shutter, double low, double high, double p)
{
    double from = fmax((double)shutter.open, p - high), to = fmin((double)shutter.close, p - low);
    return fmax(0, to - from) / ((double)shutter.close - (double)shutter.open);
}

static void check_fraction(const test_picture *picture, size_t column, size_t row, double low,
                           double high, double tolerance, const char *hint)
{
    double got = (double)rk_image_at(&picture->image, column, row)->x;
    rk_check(got >= low - tolerance && got <= high + tolerance,
             "pixel (%zu, %zu): got %.6f, want %.6f to %.6f within %.4f: %s", column, row, got, low,
             high, tolerance, hint);
}

/* Stratified times: an object that comes and goes once leaves two of the strata in doubt. The other
 * term is for roundings of positions near an edge. */
static const double doubt = 2.0 / times + 1e-4;

/* --- The picture ------------------------------------------------------------------------------ */

static rk_scene one_square(void)
{
    rk_scene scene = test_scene_make(2);
    put_square(&scene, 0, -0.25, 0, 0, 0.5f);
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    shine(&scene);
    set_moving(&scene, 0, level);
    return scene;
}

/* The colours with and without the moving object in front. */
typedef struct shown {
    double apart, covered;
} shown;

/* The square that moves along x, from `low` to `high` at time 0 and within `half` of y = 0, covers
 * pixels for its fraction of the time. */
static void check_square(const test_picture *picture, const rk_render_options *options,
                         double reach, double low, double high, double half, shown colours)
{
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            place p = seen_at(x, y, reach);
            double fraction = fraction_between(options->motion.shutter, low, high, p.x);
            fraction = fabs(p.y) < half ? fraction : 0;
            double want = colours.apart + fraction * (colours.covered - colours.apart);
            check_fraction(picture, x, y, want, want, doubt,
                           "covered for its fraction of the time");
        }
}

static void a_moving_edge_covers_a_pixel_for_its_fraction_of_the_time(void **state)
{
    (void)state;
    rk_scene scene = one_square();
    rk_render_options options = blurred(-0.5f, 1);
    for (int sampling = RK_TIME_EQUIDISTANT; sampling <= RK_TIME_LOW_DISCREPANCY; sampling++) {
        options.motion.sampling = (rk_time_sampling)sampling;
        test_picture picture = test_render(&scene, options, 2);
        check_square(&picture, &options, 3, -0.75, 0.25, 0.5, (shown){0, 1});
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

enum { corners = 256 };

static rk_scene one_disk(float radius)
{
    rk_scene scene = test_scene_make(corners);
    for (uint32_t i = 0; i < corners; i++) {
        double a = 2 * pi * i / corners, b = 2 * pi * (i + 1) / corners;
        test_scene_triangle(&scene, i, rk_vec(0, 0, 0),
                            rk_vec(radius * (float)cos(a), radius * (float)sin(a), 0),
                            rk_vec(radius * (float)cos(b), radius * (float)sin(b), 0));
    }
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    shine(&scene);
    return scene;
}

/* The fraction of the shutter interval during which a disk around (x, c x) holds the point. */
static double share_in_disk(rk_shutter shutter, double c, double radius, place p)
{
    double along = 1 + c * c, b = p.x + c * p.y, rest = p.x * p.x + p.y * p.y - radius * radius;
    double discriminant = b * b - along * rest;
    if (discriminant <= 0)
        return 0;
    double from = fmax((double)shutter.open, (b - sqrt(discriminant)) / along);
    double to = fmin((double)shutter.close, (b + sqrt(discriminant)) / along);
    return fmax(0, to - from) / ((double)shutter.close - (double)shutter.open);
}

static void a_moving_disk_covers_a_pixel_for_its_chord_of_the_path(void **state)
{
    (void)state;
    const double radius = 0.5, c = 0.75;
    rk_scene scene = one_disk((float)radius);
    set_moving(&scene, 0, (rk_motion){0, 0, (float)c});
    rk_render_options options = blurred(-1, 0.5f);
    test_picture picture = test_render(&scene, options, 2);
    size_t partly = 0;
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            place p = seen_at(x, y, 3);
            /* Between the polygon's inner and outer circle. */
            double low = share_in_disk(options.motion.shutter, c, radius * cos(pi / corners), p);
            double high = share_in_disk(options.motion.shutter, c, radius, p);
            check_fraction(&picture, x, y, low, high, doubt, "the chord over the path");
            partly += low > 0.1;
        }
    rk_check(partly > 50, "the disk should pass over many pixels, not %zu", partly);
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void objects_take_paths_of_their_own(void **state)
{
    (void)state;
    /* One rises to the left, one falls; a third is static. */
    rk_scene scene = test_scene_make(6);
    put_square(&scene, 0, 0, 0, 0, 0.125f);
    put_square(&scene, 2, -0.5, 0, 0, 0.125f);
    put_square(&scene, 4, -0.5, 0, 0, 0.125f);
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    shine(&scene);
    scene.moving_count = 2;
    scene.moving[0] = (rk_moving){2, 2, {0, 0, 1}};
    scene.moving[1] = (rk_moving){4, 2, {0, -2, 0}};
    rk_render_options options = blurred(0, 1);
    const float at[] = {0.25f, 0.5f, 0.75f};
    for (int i = 0; i < 3; i++) {
        options.motion.single_time = 0.5f + times * at[i];
        test_picture picture = test_render(&scene, options, 1);
        double x = (double)at[i];
        const place middles[] = {{0, 0}, {x - 0.5, x}, {x - 0.5, -2 * x * x}};
        for (size_t row = 0; row < height; row++)
            for (size_t column = 0; column < width; column++) {
                place p = seen_at(column, row, 3);
                bool inside = false;
                for (int k = 0; k < 3; k++)
                    inside |= fmax(fabs(p.x - middles[k].x), fabs(p.y - middles[k].y)) < 0.125;
                check_fraction(&picture, column, row, inside, inside, 0,
                               "each where its path leads");
            }
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

static void a_single_time_is_a_sharp_picture_also_outside_of_the_shutter(void **state)
{
    (void)state;
    rk_scene scene = one_square();
    rk_render_options options = blurred(0, 0.25f);
    const float ks[] = {1, 32, 64, 0, -100, 200};
    for (size_t i = 0; i < sizeof ks / sizeof *ks; i++) {
        options.motion.single_time = ks[i];
        double offset = ((double)ks[i] - 0.5) / times * 0.25;
        test_picture picture = test_render(&scene, options, 2);
        for (size_t y = 0; y < height; y++)
            for (size_t x = 0; x < width; x++) {
                place p = seen_at(x, y, 3);
                bool inside = fmax(fabs(p.x + 0.25 - offset), fabs(p.y)) < 0.5;
                check_fraction(&picture, x, y, inside, inside, 0, "it is there, or it is not");
            }
        rk_check_equal(picture.counters.time_samples, 0, "one time for all: none is drawn");
        rk_check_equal(picture.counters.primary_rays, width * height, "a ray per pixel");
        rk_image_free(&picture.image);
    }
    rk_scene_free(&scene);
}

/* --- Without a time --------------------------------------------------------------------------- */

static void check_unblurred(const rk_scene *scene, rk_render_options options)
{
    rk_render_options plain = options;
    plain.motion = rk_render_options_default().motion;
    test_picture want = test_render(scene, plain, 1), got = test_render(scene, options, 2);
    rk_check(test_same_pixels(&want.image, &got.image), "%s should be the same to the bit",
             scene->name);
    rk_check(memcmp(&want.counters, &got.counters, sizeof want.counters) == 0,
             "%s should take the same work", scene->name);
    rk_check_equal(got.counters.time_samples, 0, "no time is drawn");
    rk_image_free(&want.image);
    rk_image_free(&got.image);
}

static void a_still_scene_is_the_unblurred_picture_to_the_bit(void **state)
{
    (void)state;
    const char *const names[] = {"cornell", "cornell-light", "spheres", "panes"};
    for (int i = 0; i < 4; i++) {
        rk_scene scene = test_scene_builtin(names[i]);
        rk_render_options options = blurred(0, 1);
        options.shading.model = RK_SHADING_LAMBERT;
        options.shadows = options.reflections = options.transparency = true;
        check_unblurred(&scene, options);
        options.samples = 4;
        check_unblurred(&scene, options);
        rk_scene_free(&scene);
    }
}

static void without_time_samples_everything_is_at_rest(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("moving");
    rk_check_equal(scene.moving_count, 2, "the scene has two moving objects");
    rk_render_options options = blurred(0, 1);
    options.shading.model = RK_SHADING_LAMBERT;
    options.shadows = true;
    options.motion.samples = 0;
    test_picture got = test_render(&scene, options, 1);
    scene.moving_count = 0;
    test_picture want = test_render(&scene, options, 1);
    rk_check(test_same_pixels(&want.image, &got.image),
             "three trees at rest, or one, show the same picture");
    rk_check_equal(got.counters.time_samples, 0, "no time is drawn");
    rk_image_free(&want.image);
    rk_image_free(&got.image);
    rk_scene_free(&scene);
}

static void pixels_that_motion_cannot_change_take_no_time_samples(void **state)
{
    (void)state;
    /* A wall, and before it the square. */
    rk_scene scene = test_scene_make(4);
    test_scene_wall(&scene, 0, 1, 0);
    put_square(&scene, 2, -0.25, 0, 0, 0.5f);
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    shine(&scene);
    set_moving(&scene, 2, level);
    rk_render_options options = blurred(0, 0.5f);
    options.shading.model = RK_SHADING_LAMBERT;
    test_picture picture = test_render(&scene, options, 2);
    rk_scene still = scene;
    still.moving_count = 0;
    test_picture rest = test_render(&still, options, 2);
    uint64_t inside = 0;
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            place p = seen_at(x, y, 3);
            bool swept = p.x > -0.75 && p.x < 0.75 && fabs(p.y) < 0.5;
            inside += swept;
            rk_check(swept || memcmp(rk_image_at(&picture.image, x, y),
                                     rk_image_at(&rest.image, x, y), sizeof(rk_vec3)) == 0,
                     "pixel (%zu, %zu) shows only the wall, and should stay the same to the bit", x,
                     y);
        }
    rk_check_equal(picture.counters.time_samples, times * inside,
                   "a time each, and none elsewhere");
    rk_check_equal(picture.counters.primary_rays, width * height + (times - 1) * inside,
                   "further rays only where there is motion");
    rk_image_free(&picture.image);
    rk_image_free(&rest.image);
    rk_scene_free(&scene);
}

static void hidden_motion_takes_no_time_samples(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(4);
    test_scene_wall(&scene, 0, 1, 0);
    put_square(&scene, 2, 0, 0, 2, 0.5f);
    shine(&scene);
    set_moving(&scene, 2, level);
    rk_render_options options = blurred(0, 0.5f);
    options.shadows = true;
    test_picture picture = test_render(&scene, options, 1);
    rk_check_equal(picture.counters.time_samples, 0,
                   "behind the wall nothing moves for the camera nor for the light");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void more_samples_than_times_each_have_a_time(void **state)
{
    (void)state;
    rk_scene scene = one_square();
    rk_render_options options = blurred(-3, 3); /* swept over the whole width */
    options.samples = 100;
    options.motion.samples = 7;
    test_picture picture = test_render(&scene, options, 2);
    rk_check_equal(picture.counters.primary_rays, 100 * width * height, "as many rays as samples");
    rk_check_equal(picture.counters.pixel_samples, 100 * width * height, "each at its own place");
    rk_check(picture.counters.time_samples > 100 * width * height / 5 &&
                 picture.counters.time_samples <= 100 * width * height,
             "and, where there is motion, at its own time");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* The mean of the pixels of one row, over many seeds. */
static double mean_of_row(const rk_scene *scene, rk_render_options options, size_t row,
                          uint32_t seeds)
{
    double sum = 0;
    for (options.seed = 0; options.seed < seeds; options.seed++) {
        test_picture picture = test_render(scene, options, 2);
        for (size_t x = 0; x < width; x++)
            sum += (double)rk_image_at(&picture.image, x, row)->x;
        rk_image_free(&picture.image);
    }
    return sum / width / seeds;
}

/* A sample that hits no moving object says nothing about the rest of its pixel. Were the first
 * samples to decide for the pixel, its mean would be off by (1 - n / times) (1 - p)^n p, if a
 * fraction p of it is covered and n are the samples: here by 0.08. */
static void pixels_that_are_covered_in_part_are_right_on_average(void **state)
{
    (void)state;
    enum { samples = 4, seeds = 20 };
    double fraction = 0.2, side = 2 * tan(25 * pi / 180) * 3 / height;
    rk_scene scene = test_scene_make(2);
    /* Its upper edge is in the row above the middle; it covers the whole width all the time. */
    test_scene_quad(&scene, 0, rk_vec(-10, -10, 0), rk_vec(20, 0, 0),
                    rk_vec(0, 10 + (float)(fraction * side), 0));
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    shine(&scene);
    set_moving(&scene, 0, level);
    rk_render_options options = blurred(0, 0.25f);
    options.samples = samples;
    for (int sampling = RK_SAMPLER_UNIFORM; sampling <= RK_SAMPLER_LOW_DISCREPANCY; sampling++) {
        options.sampling = (rk_sampler_kind)sampling;
        double mean = mean_of_row(&scene, options, height / 2 - 1, seeds);
        /* Independent samples are the worst: four standard deviations of the mean. */
        double deviation = sqrt(fraction * (1 - fraction) / (samples * width * seeds));
        rk_check_close(mean, fraction, 4 * deviation, "the covered fraction of the pixels");
    }
    rk_scene_free(&scene);
}

static double squared_error(const rk_scene *scene, rk_render_options options,
                            const test_picture *truth)
{
    enum { seeds = 4 };
    double sum = 0;
    for (options.seed = 1; options.seed <= seeds; options.seed++) {
        test_picture picture = test_render(scene, options, 2);
        for (size_t i = 0; i < width * height; i++) {
            double off = (double)picture.image.pixels[i].x - (double)truth->image.pixels[i].x;
            sum += off * off / (width * height * seeds);
        }
        rk_image_free(&picture.image);
    }
    return sum;
}

/* Times are stratified and in order, so with low-discrepancy positions a sample's time and position
 * are one point of a sequence that is even in all three dimensions. Shuffled cells know nothing of
 * the time, and leave about twice the squared error; three quarters of theirs is asked for, with
 * noise of a few percent over 2,640 pixels. */
static void the_default_positions_and_the_times_are_even_together(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_quad(&scene, 0, rk_vec(-1, -0.8f, 0), rk_vec(1.4f, 0.3f, 0), rk_vec(-0.3f, 1.4f, 0));
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    shine(&scene);
    set_moving(&scene, 0, level);
    rk_render_options options = blurred(0, 0.5f);
    options.samples = options.motion.samples = 64 * times;
    test_picture truth = test_render(&scene, options, 2);
    options.samples = options.motion.samples = times;
    double by_default = squared_error(&scene, options, &truth);
    options.sampling = RK_SAMPLER_STRATIFIED;
    double by_cells = squared_error(&scene, options, &truth);
    rk_check(by_default < 0.75 * by_cells,
             "mean squared error: got %.3g, want less than 3/4 of that of stratified positions, "
             "%.3g",
             by_default, by_cells);
    rk_image_free(&truth.image);
    rk_scene_free(&scene);
}

/* --- Shadows, mirrors, glass ------------------------------------------------------------------ */

static void the_shadow_of_a_moving_object_is_blurred(void **state)
{
    (void)state;
    /* A wall at z = 1, and beside the view a square between it and the light at (6, 0, -1): its
     * shadow is twice as wide, around x = 0, and moves twice as fast. */
    rk_scene scene = test_scene_make(4);
    test_scene_wall(&scene, 0, 1, 0);
    put_square(&scene, 2, 3, -0.06, 0, 0.25f);
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    test_scene_light(&scene, rk_vec(6, 0, -1), rk_vec(1, 1, 1));
    set_moving(&scene, 2, level);
    rk_render_options options = blurred(-0.25f, 0.25f);
    options.shadows = true;
    test_picture picture = test_render(&scene, options, 2);
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            place p = seen_at(x, y, 4);
            double fraction = fraction_between(options.motion.shutter, -0.25, 0.25, p.x / 2);
            fraction = fabs(p.y + 0.12) < 0.5 ? fraction : 0;
            check_fraction(&picture, x, y, 1 - fraction, 1 - fraction, doubt,
                           "light for the rest of the time");
        }
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* White, and two units wide and high. */
static void put_large_light(rk_scene *scene, rk_vec3 corner)
{
    rk_light *light = &scene->lights[scene->light_count++];
    *light = (rk_light){.kind = RK_LIGHT_PARALLELOGRAM,
                        .position = corner,
                        .edge01 = rk_vec(2, 0, 0),
                        .edge02 = rk_vec(0, 2, 0)};
    for (int i = 0; i < 4; i++)
        light->colours[i] = rk_vec(1, 1, 1);
}

/* How far the picture's pixels are from those of `truth`. */
static double rms_error(const rk_scene *scene, rk_render_options options, const rk_image *truth)
{
    test_picture picture = test_render(scene, options, 2);
    double sum = 0;
    for (size_t i = 0; i < width * height; i++)
        sum += pow((double)picture.image.pixels[i].x - (double)truth->pixels[i].x, 2);
    rk_image_free(&picture.image);
    return sqrt(sum / (width * height));
}

/* Where the camera's ray decides that there is motion, light samples are drawn anew each time. */
static void moving_surfaces_take_light_samples_at_each_time(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, 1, 0);
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    put_large_light(&scene, rk_vec(-1, -1, -0.5f));
    rk_render_options options = blurred(0, 0.25f);
    options.shading.model = RK_SHADING_LAMBERT;
    options.light.samples = 1024;
    test_picture truth = test_render(&scene, options, 2);
    set_moving(&scene, 0, level); /* the same picture at all times */
    options.light.samples = 1;
    options.motion.samples = 1;
    double once = rms_error(&scene, options, &truth.image);
    options.motion.samples = 16;
    double often = rms_error(&scene, options, &truth.image);
    /* A quarter, were they independent; other sets are better. */
    rk_check(once > 0.01 && often < 0.4 * once,
             "16 times a light sample are wrong by %.4f, and 1 by %.4f", often, once);
    rk_image_free(&truth.image);
    rk_scene_free(&scene);
}

static void add_picture(double *sum, const rk_scene *scene, rk_render_options options)
{
    test_picture picture = test_render(scene, options, 2);
    for (size_t i = 0; i < width * height; i++)
        *sum += (double)picture.image.pixels[i].x / (width * height);
    rk_image_free(&picture.image);
}

/* A single random point of a large light decides whether a moving object may occlude it. Were the
 * others then drawn anew, shadows would be too bright, here by 0.07. */
static void shadows_of_large_lights_are_right_on_average(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(4);
    test_scene_wall(&scene, 0, 1, 0);
    put_square(&scene, 2, 3, -0.06f, 0, 0.5f);
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    put_large_light(&scene, rk_vec(5, -1, -1));
    set_moving(&scene, 2, level);
    enum { few = 8, seeds = 40 };
    rk_render_options options = blurred(-0.5f, 0.5f);
    options.shadows = true;
    options.motion.samples = few;
    options.motion.sampling = RK_TIME_EQUIDISTANT;
    options.light.early_out = 0;
    options.light.samples = 256;
    double want = 0, got = 0;
    for (options.motion.single_time = 1; options.motion.single_time <= few;
         options.motion.single_time++)
        add_picture(&want, &scene, options);
    options.motion.single_time = NAN;
    options.light.samples = 1;
    for (options.seed = 0; options.seed < seeds; options.seed++)
        add_picture(&got, &scene, options);
    /* A pixel's deviation is at most 1/2: four of the mean's. */
    rk_check_close(got / seeds, want / few, 4 * 0.5 / sqrt(1.0 * width * height * seeds),
                   "the mean of the pictures at each of the times");
    rk_scene_free(&scene);
}

static void a_mirror_reflects_moving_objects_blurred(void **state)
{
    (void)state;
    /* A mirror at z = 1, and the square behind the viewer, 4 + 5 from the camera. */
    rk_scene scene = test_scene_of(4, 2);
    test_scene_wall(&scene, 0, 1, 1);
    put_square(&scene, 2, 0, 0, -4, 1);
    scene.mesh.materials[0].kd = scene.mesh.materials[1].ks = rk_vec(1, 1, 1);
    scene.mesh.materials[1].kd = rk_vec(0, 0, 0);
    shine(&scene);
    set_moving(&scene, 2, level);
    rk_render_options options = blurred(-1, 1);
    options.reflections = true;
    test_picture picture = test_render(&scene, options, 2);
    check_square(&picture, &options, 9, -1, 1, 1, (shown){0, 1});
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void moving_glass_attenuates_the_wall_behind_it_for_its_fraction_of_the_time(void **state)
{
    (void)state;
    rk_scene scene = test_scene_of(4, 2);
    test_scene_wall(&scene, 0, 1, 0);
    put_square(&scene, 2, 0, 0, 0, 0.5f);
    scene.mesh.materials[0].kd = rk_vec(1, 1, 1);
    scene.mesh.materials[1].kd = rk_vec(0, 0, 0);
    scene.mesh.materials[1].alpha = 0.5f;
    scene.mesh.triangle_materials[2] = scene.mesh.triangle_materials[3] = 1;
    shine(&scene);
    set_moving(&scene, 2, level);
    rk_render_options options = blurred(-0.5f, 0.5f);
    options.transparency = true;
    test_picture picture = test_render(&scene, options, 2);
    check_square(&picture, &options, 3, -0.5, 0.5, 0.5, (shown){1, 0.5});
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

static void a_lens_and_motion_go_together(void **state)
{
    (void)state;
    rk_scene scene = one_square();
    rk_render_options options = blurred(-0.5f, 1);
    options.lens.focal_distance = 3; /* the square's plane: only motion blurs it */
    options.lens.aperture = 100;
    options.lens_samples = 16;
    test_picture picture = test_render(&scene, options, 2);
    /* A sample is anywhere in its pixel, in which the fraction changes by the pixel's width over
     * the path; the square's upper and lower edge may run through a pixel. */
    double side = 2 * tan(25 * pi / 180) * 3 / height, tolerance = doubt + side / 1.5;
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            place p = seen_at(x, y, 3);
            double fraction = fraction_between(options.motion.shutter, -0.75, 0.25, p.x);
            if (fabs(fabs(p.y) - 0.5) < side)
                continue;
            fraction = fabs(p.y) < 0.5 ? fraction : 0;
            check_fraction(&picture, x, y, fraction, fraction, tolerance,
                           "the fraction of the time");
        }
    rk_check(picture.counters.lens_samples > 0 && picture.counters.time_samples > 0,
             "each ray has its place on the lens and its time");
    rk_image_free(&picture.image);
    rk_scene_free(&scene);
}

/* A convex body has no shadow on itself, wherever its rays are carried. */
static void no_ray_hits_the_moving_surface_that_it_leaves(void **state)
{
    (void)state;
    const float at[] = {0.05f, 1, 30, 1000, 30000};
    for (int i = 0; i < 5; i++) {
        rk_scene scene = test_scene_builtin("sphere:1280");
        free(scene.mesh.normals); /* flat: interpolated normals are lit where faces are not */
        scene.mesh.normals = NULL;
        rk_scene_move_mesh(&scene, (rk_motion){0, 0, 0.75f});
        rk_render_options options = blurred(at[i], at[i]);
        options.shading.model = RK_SHADING_LAMBERT;
        options.width = options.height = 200;
        rk_vec3 offset = rk_motion_offset(&scene.moving[0].motion, at[i]);
        scene.camera.look_at = offset;
        scene.lights[0].position = rk_add(scene.lights[0].position, offset);
        test_picture bright = test_render(&scene, options, 2);
        options.shadows = true;
        test_picture shadowed = test_render(&scene, options, 2);
        rk_check(shadowed.counters.shadow_rays > 1000, "the sphere is in the picture");
        rk_check(test_same_pixels(&bright.image, &shadowed.image),
                 "at x = %g a convex body has a shadow on itself", (double)at[i]);
        rk_image_free(&bright.image);
        rk_image_free(&shadowed.image);
        rk_scene_free(&scene);
    }
}

/* --- How -------------------------------------------------------------------------------------- */

static void the_blur_is_the_same_for_any_number_of_threads(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("moving");
    rk_render_options options = blurred(0, 0.1f);
    options.shading.model = RK_SHADING_LAMBERT;
    options.shadows = true;
    options.width = options.height = 50;
    options.motion.samples = 5;
    for (options.samples = 1; options.samples <= 3; options.samples += 2) {
        test_picture one = test_render(&scene, options, 1), three = test_render(&scene, options, 3);
        rk_check(test_same_pixels(&one.image, &three.image), "threads must not show");
        rk_check_equal(one.counters.time_samples, three.counters.time_samples, "nor in the work");
        options.seed++;
        test_picture other = test_render(&scene, options, 1);
        rk_check(!test_same_pixels(&one.image, &other.image), "another seed, other times");
        rk_image_free(&one.image);
        rk_image_free(&three.image);
        rk_image_free(&other.image);
    }
    rk_scene_free(&scene);
}

static size_t allocations_for(const rk_scene *scene, uint32_t samples)
{
    rk_render_options options = blurred(0, 0.1f);
    options.motion.samples = samples;
    size_t before = rk_allocations;
    test_picture picture = test_render(scene, options, 1);
    rk_image_free(&picture.image);
    return rk_allocations - before;
}

static void memory_does_not_grow_with_the_samples(void **state)
{
    (void)state;
    rk_scene scene = test_scene_builtin("moving");
    size_t two = allocations_for(&scene, 2), many = allocations_for(&scene, 300);
    if (rk_allocations_are_counted)
        rk_check_equal(many, two, "one scene, and one set of trees, for any number of samples");
    rk_scene_free(&scene);
}

static void moving_objects_that_are_not_the_last_triangles_are_refused(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(6);
    rk_accel accel;
    const rk_moving wrong[][2] = {{{0, 2, {0, 0, 0}}, {4, 2, {0, 0, 0}}},
                                  {{4, 2, {0, 0, 0}}, {2, 2, {0, 0, 0}}},
                                  {{2, 2, {0, 0, 0}}, {4, 3, {0, 0, 0}}},
                                  {{2, 4, {0, 0, 0}}, {6, 0, {0, 0, 0}}}};
    for (int i = 0; i < 4; i++) {
        rk_error error = {""};
        scene.moving_count = 2;
        memcpy(scene.moving, wrong[i], sizeof wrong[i]);
        rk_check(!rk_accel_build(&accel, RK_ACCEL_MEDIAN, &scene, &error), "case %d is wrong", i);
        rk_check_error_names(error, "last triangles");
    }
    rk_scene_free(&scene);
}

static void a_shutter_that_closes_before_it_opens_is_refused(void **state)
{
    (void)state;
    rk_scene scene = one_square();
    rk_render_options options = blurred(1, 0);
    rk_accel accel;
    rk_image image;
    rk_counters counters;
    rk_error error = {""};
    rk_pool *pool = rk_pool_start(1, &error);
    rk_check_ok(pool && rk_accel_build(&accel, RK_ACCEL_MEDIAN, &scene, &error), error);
    rk_check_ok(rk_image_init(&image, width, height, &error), error);
    rk_check(!rk_render(&image, &scene, &accel, &options, pool, &counters, NULL, &error),
             "from 1 to 0 is no interval");
    rk_check_error_names(error, "shutter");
    rk_pool_stop(pool);
    rk_accel_free(&accel);
    rk_image_free(&image);
    rk_scene_free(&scene);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_moving_edge_covers_a_pixel_for_its_fraction_of_the_time),
    cmocka_unit_test(a_moving_disk_covers_a_pixel_for_its_chord_of_the_path),
    cmocka_unit_test(objects_take_paths_of_their_own),
    cmocka_unit_test(a_single_time_is_a_sharp_picture_also_outside_of_the_shutter),
    cmocka_unit_test(a_still_scene_is_the_unblurred_picture_to_the_bit),
    cmocka_unit_test(without_time_samples_everything_is_at_rest),
    cmocka_unit_test(pixels_that_motion_cannot_change_take_no_time_samples),
    cmocka_unit_test(hidden_motion_takes_no_time_samples),
    cmocka_unit_test(more_samples_than_times_each_have_a_time),
    cmocka_unit_test(pixels_that_are_covered_in_part_are_right_on_average),
    cmocka_unit_test(the_default_positions_and_the_times_are_even_together),
    cmocka_unit_test(the_shadow_of_a_moving_object_is_blurred),
    cmocka_unit_test(moving_surfaces_take_light_samples_at_each_time),
    cmocka_unit_test(shadows_of_large_lights_are_right_on_average),
    cmocka_unit_test(a_mirror_reflects_moving_objects_blurred),
    cmocka_unit_test(moving_glass_attenuates_the_wall_behind_it_for_its_fraction_of_the_time),
    cmocka_unit_test(a_lens_and_motion_go_together),
    cmocka_unit_test(no_ray_hits_the_moving_surface_that_it_leaves),
    cmocka_unit_test(the_blur_is_the_same_for_any_number_of_threads),
    cmocka_unit_test(memory_does_not_grow_with_the_samples),
    cmocka_unit_test(moving_objects_that_are_not_the_last_triangles_are_refused),
    cmocka_unit_test(a_shutter_that_closes_before_it_opens_is_refused),
};

RK_SUITE("motion_blur_stage", tests)
