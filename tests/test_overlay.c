/* Debug drawings: at their projections, hidden by nearer surfaces only, and quick and harmless for
 * any input; and the single rays that drivers draw. */
#include "test_scene.h"

#include "accel/query/trace.h"
#include "accel/query/trace_one.h"
#include "driver/overlay.h"

/* A black picture of the scene, ready to draw on. */
typedef struct canvas {
    rk_scene scene;
    rk_accel accel;
    rk_pool *pool;
    rk_image image;
    rk_overlay overlay;
} canvas;

static const rk_vec3 white = {1, 1, 1};

static canvas *make_canvas(rk_scene scene, uint32_t width, uint32_t height)
{
    canvas *c = calloc(1, sizeof *c);
    rk_error error;
    c->scene = scene;
    rk_check_ok((c->pool = rk_pool_start(2, &error)) != NULL, error);
    rk_check_ok(rk_accel_build(&c->accel, RK_ACCEL_MEDIAN, &c->scene, &error), error);
    rk_check_ok(rk_image_init(&c->image, width, height, &error), error);
    rk_check_ok(rk_overlay_init(&c->overlay, &c->image, &c->scene, &c->accel, c->pool, &error),
                error);
    return c;
}

static void free_canvas(canvas *c)
{
    rk_overlay_free(&c->overlay);
    rk_image_free(&c->image);
    rk_accel_free(&c->accel);
    rk_pool_stop(c->pool);
    rk_scene_free(&c->scene);
    free(c);
}

static float red(const canvas *c, size_t x, size_t y)
{
    return rk_image_at(&c->image, x, y)->x;
}

static double sum_of_red(const canvas *c)
{
    double sum = 0;
    for (size_t i = 0; i < c->image.width * c->image.height; i++)
        sum += (double)c->image.pixels[i].x;
    return sum;
}

static size_t touched(const canvas *c)
{
    size_t count = 0;
    for (size_t i = 0; i < c->image.width * c->image.height; i++)
        count += c->image.pixels[i].x != 0;
    return count;
}

static void wipe(canvas *c)
{
    memset(c->image.pixels, 0, c->image.width * c->image.height * sizeof(rk_vec3));
}

/* The point of the plane z = 0 that appears at (x, y), in pixels from the top left corner. */
static rk_vec3 at_pixel(const canvas *c, float x, float y)
{
    float unit = 3 * c->overlay.view.pixel;
    return rk_vec(-(x - 0.5f * (float)c->image.width) * unit,
                  (0.5f * (float)c->image.height - y) * unit, 0);
}

/* --- Lines ----------------------------------------------------------------------------------- */

static void a_level_line_covers_its_row_with_its_ends(void **state)
{
    (void)state;
    canvas *c = make_canvas(test_scene_make(0), 40, 20);
    rk_overlay_line(&c->overlay, at_pixel(c, 10.5f, 7.5f), at_pixel(c, 30.5f, 7.5f), white, 1);
    for (size_t y = 0; y < 20; y++)
        for (size_t x = 0; x < 40; x++) {
            bool on = y == 7 && x >= 10 && x <= 30;
            /* Projection leaves 10^-5 of a pixel. */
            rk_check_close(red(c, x, y), on ? 1 : 0, 1e-4, "pixels 10 to 30 of row 7, whole");
        }
    free_canvas(c);
}

/* The distance from the centre of pixel (x, y) to the segment. */
static double distance_to(size_t x, size_t y, double ax, double ay, double bx, double by)
{
    double px = (double)x + 0.5 - ax, py = (double)y + 0.5 - ay, dx = bx - ax, dy = by - ay;
    double s = fmin(1, fmax(0, (px * dx + py * dy) / (dx * dx + dy * dy)));
    return hypot(px - s * dx, py - s * dy);
}

static void a_slanted_line_is_where_projection_says(void **state)
{
    (void)state;
    const float ends[][4] = {
        {5.3f, 3.7f, 33.1f, 17.2f}, {33, 2, 30, 18.6f},  {30, 18, 4, 12}, {8, 3, 8, 15},
        {-20, 30, 60, -9},          {12, 5, 12.2f, 5.1f}};
    const float widths[] = {1, 1.5f, 4};
    canvas *c = make_canvas(test_scene_make(0), 40, 20);
    for (int i = 0; i < 6; i++)
        for (int w = 0; w < 3; w++) {
            const float *e = ends[i];
            wipe(c);
            rk_overlay_line(&c->overlay, at_pixel(c, e[0], e[1]), at_pixel(c, e[2], e[3]), white,
                            widths[w]);
            for (size_t y = 0; y < 20; y++)
                for (size_t x = 0; x < 40; x++) {
                    double far =
                        distance_to(x, y, (double)e[0], (double)e[1], (double)e[2], (double)e[3]);
                    double want = fmin(1, fmax(0, 0.5 * (double)widths[w] + 0.5 - far));
                    rk_check(fabs((double)red(c, x, y) - want) < 1e-4,
                             "line %d, width %g, pixel (%zu, %zu): got %g, want %g", i,
                             (double)widths[w], x, y, (double)red(c, x, y), want);
                }
        }
    free_canvas(c);
}

static void a_line_covers_its_length_times_its_width(void **state)
{
    (void)state;
    canvas *c = make_canvas(test_scene_make(0), 80, 80);
    const float widths[] = {0.25f, 0.5f, 1, 2.5f};
    for (int i = 0; i < 4; i++) {
        /* Two lines of one slope, so that their difference has no ends: 20 by 11.23 pixels. The
         * slope is no simple fraction, so that pixels lie at all distances from the line. */
        wipe(c);
        rk_overlay_line(&c->overlay, at_pixel(c, 10.2f, 20.3f), at_pixel(c, 70.2f, 53.99f), white,
                        widths[i]);
        double longer = sum_of_red(c);
        wipe(c);
        rk_overlay_line(&c->overlay, at_pixel(c, 10.2f, 20.3f), at_pixel(c, 50.2f, 42.76f), white,
                        widths[i]);
        /* A line through the centres of a grid is a sum, not an integral: good to 2 %. */
        double want = hypot(20, 11.23) * (double)widths[i];
        rk_check_close(longer - sum_of_red(c), want, 0.02 * want, "coverage sums to the area");
    }
    wipe(c);
    rk_overlay_line(&c->overlay, at_pixel(c, 10, 20), at_pixel(c, 50, 40), white, 0);
    rk_check_close(sum_of_red(c), 0, 0, "a line without width is invisible");
    free_canvas(c);
}

static void a_point_is_a_disk(void **state)
{
    (void)state;
    canvas *c = make_canvas(test_scene_make(0), 40, 40);
    rk_overlay_point(&c->overlay, at_pixel(c, 20.3f, 19.6f), white, 6);
    /* The edge falls off evenly over one pixel: a cone's frustum, pi (r^2 + 1/12). */
    rk_check_close(sum_of_red(c), 3.14159265 * (36 + 1.0 / 12), 0.5, "the area of the disk");
    rk_check_close(red(c, 20, 19), 1, 0, "full in the middle");
    rk_check_close(red(c, 20, 10), 0, 0, "nothing beyond the radius");
    free_canvas(c);
}

/* A wall at z = 0 over the left half of the picture, where x > 0. */
static canvas *make_walled_canvas(void)
{
    rk_scene scene = test_scene_make(2);
    test_scene_quad(&scene, 0, rk_vec(0, -9, 0), rk_vec(9, 0, 0), rk_vec(0, 18, 0));
    return make_canvas(scene, 40, 20);
}

/* Pixels of row 7 from 10 to 90 in which a shadow ray is drawn. */
static size_t drawn_by_shadow_ray(canvas *c, bool occluded)
{
    size_t count = 0;
    wipe(c);
    rk_overlay_shadow_ray(&c->overlay, at_pixel(c, 10.5f, 7.5f), at_pixel(c, 90.5f, 7.5f),
                          occluded);
    for (size_t x = 10; x <= 90; x++)
        count += red(c, x, 7) > 0;
    return count;
}

static void only_occluded_shadow_rays_have_gaps(void **state)
{
    (void)state;
    canvas *c = make_canvas(test_scene_make(0), 300, 20);
    rk_check(drawn_by_shadow_ray(c, false) == 81, "an unoccluded ray is whole");
    rk_check(drawn_by_shadow_ray(c, true) < 81, "an occluded ray has gaps");
    rk_check(drawn_by_shadow_ray(c, true) > 40, "most of an occluded ray is drawn");
    free_canvas(c);
}

static void lines_are_hidden_behind_surfaces_and_visible_in_front_of_them(void **state)
{
    (void)state;
    canvas *c = make_walled_canvas();
    /* Perspective: a point at distance 3 + z that projects onto the same pixel is (3 + z) / 3 as
     * far from the axis. */
    const float depths[] = {0.5f, -0.5f, 0}; /* behind, before, on it */
    for (int i = 0; i < 3; i++) {
        wipe(c);
        float reach = (3 + depths[i]) / 3;
        rk_vec3 from = rk_scale(at_pixel(c, 2.5f, 7.5f), reach);
        rk_vec3 to = rk_scale(at_pixel(c, 37.5f, 7.5f), reach);
        from.z = to.z = depths[i];
        rk_overlay_line(&c->overlay, from, to, white, 1);
        for (size_t x = 3; x < 37; x++)
            rk_check_close(red(c, x, 7), i == 0 && x < 20 ? 0 : 1, 1e-4,
                           "hidden only behind the wall, in the left half");
    }
    free_canvas(c);
}

static void a_line_into_the_depth_is_hidden_from_where_it_enters(void **state)
{
    (void)state;
    /* Through the wall at pixel 10, half-way: from near the viewer, where a line's depth grows
     * slowly across the picture, and from farther off. */
    const float start_x[] = {4, 2}, start_z[] = {-1, -2.5f};
    for (int i = 0; i < 2; i++) {
        canvas *c = make_walled_canvas();
        rk_vec3 middle = at_pixel(c, 10, 7.5f);
        rk_vec3 from = rk_scale(at_pixel(c, start_x[i], 7.5f), (3 + start_z[i]) / 3);
        from.z = start_z[i];
        rk_overlay_line(&c->overlay, from, rk_sub(rk_scale(middle, 2), from), white, 1);
        for (size_t x = 5; x < 9; x++)
            rk_check(red(c, x, 7) > 0.9f, "line %d, pixel %zu: it is before the wall there", i, x);
        for (size_t x = 11; x < 20; x++)
            rk_check(red(c, x, 7) == 0, "line %d, pixel %zu: it is behind the wall there", i, x);
        free_canvas(c);
    }
}

static void lines_behind_the_viewer_are_clipped(void **state)
{
    (void)state;
    canvas *c = make_canvas(test_scene_make(0), 40, 20);
    rk_overlay_line(&c->overlay, rk_vec(-1, 0, -4), rk_vec(1, 0, -5), white, 1);
    rk_check_equal(touched(c), 0, "all of it is behind the viewer");
    rk_overlay_line(&c->overlay, rk_vec(-1, 0, -3), rk_vec(1, 0, -3), white, 1);
    rk_check_equal(touched(c), 0, "all of it is beside the viewer");
    /* From the middle of the picture back past the viewer's left shoulder (x > 0 is left). */
    rk_overlay_line(&c->overlay, rk_vec(0, 0, 0), rk_vec(1, 0, -6), white, 1);
    for (size_t y = 0; y < 20; y++)
        for (size_t x = 0; x < 40; x++)
            rk_check(red(c, x, y) == 0 || (x <= 20 && (y == 9 || y == 10)),
                     "pixel (%zu, %zu) is not on the line", x, y);
    rk_check(red(c, 1, 9) > 0.4f, "the part in front is drawn, up to the picture's edge");
    wipe(c);
    rk_overlay_line(&c->overlay, rk_vec(1, 0, -6), rk_vec(0, 0, 0), white, 1);
    rk_check(red(c, 1, 9) > 0.4f, "the same from the other end");
    free_canvas(c);
}

/* Seen along z the near face is drawn as a square, and the far one within it. */
static const rk_box cube = {{{-0.5f, -0.5f, -0.5f}, {0.5f, 0.5f, 0.5f}}};

static void a_wireframe_has_twelve_edges(void **state)
{
    (void)state;
    canvas *c = make_canvas(test_scene_make(0), 200, 200);
    rk_overlay_wireframe(&c->overlay, &cube, white, 1);
    double pixel = (double)c->overlay.view.pixel;
    double near = 1 / 2.5 / pixel, far = 1 / 3.5 / pixel;
    double length = 4 * near + 4 * far + 4 * (near - far) / sqrt(2);
    /* Edges overlap by about a pixel at each of eight corners. */
    rk_check_close(sum_of_red(c), length, 0.03 * length, "four near edges, four far, four between");
    free_canvas(c);
}

/* Otherwise edges would cover what a small picture shows. */
static void edges_take_the_same_share_of_pictures_of_all_sizes(void **state)
{
    (void)state;
    const uint32_t sizes[][2] = {{800, 800}, {128, 128}, {512, 512}, {1600, 1600}, {512, 320}};
    double share[5];
    for (int i = 0; i < 5; i++) {
        canvas *c = make_canvas(test_scene_make(0), sizes[i][0], sizes[i][1]);
        rk_overlay_wireframe(&c->overlay, &cube, white, 8);
        /* What is seen depends on the height, as the field of view does. */
        share[i] = sum_of_red(c) / ((double)sizes[i][1] * (double)sizes[i][1]);
        free_canvas(c);
    }
    /* Coverage is a sum over pixels, not an integral: good to 1 %. */
    for (int i = 1; i < 5; i++)
        rk_check_near(share[i] / share[0], 1, 0.01, "at %u x %u pixels", sizes[i][0], sizes[i][1]);
}

static void edges_of_small_pictures_are_a_pixel_wide(void **state)
{
    (void)state;
    const float widths[] = {1, 1.5f, 3};
    canvas *c = make_canvas(test_scene_make(0), 128, 128);
    double area[3];
    for (int i = 0; i < 3; i++) {
        wipe(c);
        rk_overlay_wireframe(&c->overlay, &cube, white, widths[i]);
        area[i] = sum_of_red(c);
        rk_check_near(area[i], area[0], 0, "width %g, against 1", (double)widths[i]);
    }
    free_canvas(c);
}

/* --- Boxes ----------------------------------------------------------------------------------- */

/* alpha on black: one face gives alpha, two 1 - (1 - alpha)^2. */
enum { no_face, one_face, two_faces };
static const double glass[] = {0, 0.25, 1 - 0.75 * 0.75};

static void check_face_count(const canvas *c, size_t x, size_t y, int faces, const char *hint)
{
    rk_check_close(red(c, x, y), glass[faces], 1e-7, hint);
}

static void a_glass_box_blends_its_far_and_its_near_face(void **state)
{
    (void)state;
    canvas *c = make_canvas(test_scene_make(0), 41, 41);
    rk_box box = {{rk_vec(-0.5f, -0.5f, -0.5f), rk_vec(0.5f, 0.5f, 0.5f)}};
    rk_overlay_box(&c->overlay, &box, white, 0.25f);
    check_face_count(c, 20, 20, two_faces, "in at the front, out at the back");
    check_face_count(c, 0, 0, no_face, "beside the box");
    /* The front face spans 0.5 / 2.5 of tan: pixels up to 8.8 from the middle. */
    check_face_count(c, 28, 20, two_faces, "in at the front, out at a side");
    check_face_count(c, 29, 20, no_face, "beside the front face is beside the box");
    free_canvas(c);
}

static void from_within_a_glass_box_only_its_far_face_is_visible(void **state)
{
    (void)state;
    canvas *c = make_canvas(test_scene_make(0), 21, 21);
    rk_box box = {{rk_vec(-9, -9, -9), rk_vec(9, 9, 9)}};
    rk_overlay_box(&c->overlay, &box, white, 0.25f);
    for (size_t y = 0; y < 21; y++)
        for (size_t x = 0; x < 21; x++)
            check_face_count(c, x, y, one_face, "the viewer stands within");
    free_canvas(c);
}

static void a_surface_hides_the_faces_behind_it(void **state)
{
    (void)state;
    canvas *c = make_walled_canvas();
    rk_box through = {{rk_vec(-9, -9, -0.5f), rk_vec(9, 9, 0.5f)}};
    rk_overlay_box(&c->overlay, &through, white, 0.25f);
    check_face_count(c, 5, 10, one_face, "the wall hides the far face");
    check_face_count(c, 35, 10, two_faces, "no wall there");
    wipe(c);
    rk_box behind = {{rk_vec(-9, -9, 0.5f), rk_vec(9, 9, 1)}};
    rk_overlay_box(&c->overlay, &behind, white, 0.25f);
    check_face_count(c, 5, 10, no_face, "the wall hides both");
    check_face_count(c, 35, 10, two_faces, "no wall there");
    wipe(c);
    rk_box before = {{rk_vec(-9, -9, -1), rk_vec(9, 9, -0.5f)}};
    rk_overlay_box(&c->overlay, &before, white, 0.25f);
    check_face_count(c, 5, 10, two_faces, "both are before the wall");
    free_canvas(c);
}

/* --- Triangles ------------------------------------------------------------------------------- */

static void a_triangle_covers_just_the_pixels_in_which_it_is_the_nearest(void **state)
{
    (void)state;
    const char *const names[] = {"cornell", "sphere:320", "statue:967"};
    for (int i = 0; i < 3; i++) {
        canvas *c = make_canvas(test_scene_builtin(names[i]), 70, 50);
        const rk_mesh *mesh = &c->scene.mesh;
        uint32_t *nearest = calloc(70 * 50, sizeof *nearest);
        rk_counters counters = {0};
        for (uint32_t p = 0; p < 70 * 50; p++) {
            rk_ray_batch rays = {.count = 0};
            rk_hit_batch hits;
            rk_ray ray =
                rk_view_ray(&c->overlay.view, (float)(p % 70) + 0.5f, (float)(p / 70) + 0.5f);
            rk_batch_push(&rays, &ray);
            rk_accel_closest(&c->accel, &rays, &hits, &counters);
            nearest[p] = hits.triangle[0];
        }
        size_t covered = 0;
        for (uint32_t t = 0; t < mesh->triangle_count; t++) {
            const uint32_t *k = mesh->triangles[t];
            wipe(c);
            rk_overlay_triangle(&c->overlay, mesh->positions[k[0]], mesh->positions[k[1]],
                                mesh->positions[k[2]], white, 1);
            for (uint32_t p = 0; p < 70 * 50; p++) {
                bool drawn = c->image.pixels[p].x != 0;
                covered += drawn;
                rk_check(drawn == (nearest[p] == t),
                         "%s, triangle %u, pixel (%u, %u): drawn %d, but the nearest is %u",
                         names[i], t, p % 70, p / 70, drawn, nearest[p]);
            }
        }
        rk_check(covered > 200, "only %zu pixels show the scene", covered);
        free(nearest);
        free_canvas(c);
    }
}

static void a_triangle_is_blended_by_its_opacity(void **state)
{
    (void)state;
    canvas *c = make_walled_canvas();
    for (size_t i = 0; i < 800; i++)
        c->image.pixels[i] = rk_vec(0.5f, 1, 0);
    rk_overlay_triangle(&c->overlay, rk_vec(-9, -9, -1), rk_vec(18, -9, -1), rk_vec(-9, 18, -1),
                        rk_vec(1, 0, 0.5f), 0.25f);
    const rk_vec3 *got = rk_image_at(&c->image, 20, 10);
    rk_check_close(got->x, 0.75 * 0.5 + 0.25 * 1, 1e-7, "three parts old, one part new");
    rk_check_close(got->y, 0.75, 1e-7, "three parts old, one part new");
    rk_check_close(got->z, 0.125, 1e-7, "three parts old, one part new");
    free_canvas(c);
}

/* --- Degenerate input ------------------------------------------------------------------------ */

static void degenerate_drawings_end_and_leave_numbers(void **state)
{
    (void)state;
    canvas *c = make_walled_canvas();
    const float odd[] = {0, -3, 1e-30f, 1e30f, -3e38f, INFINITY, -INFINITY, NAN};
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 8; k++)
            for (int axis = 0; axis < 4; axis++) {
                float o = odd[i], p = odd[k];
                rk_vec3 a = rk_vec(axis == 0 || axis == 3 ? o : 0.1f, axis == 1 ? o : 0.2f,
                                   axis == 2 || axis == 3 ? o : -1);
                rk_vec3 b = rk_vec(axis == 0 ? p : 0.3f, axis == 1 || axis == 3 ? p : -0.2f,
                                   axis == 2 ? p : -1);
                rk_box box = {{a, b}};
                rk_overlay_line(&c->overlay, a, b, white, 1);
                rk_overlay_line(&c->overlay, a, b, white, p);
                rk_overlay_point(&c->overlay, a, white, 2);
                rk_overlay_wireframe(&c->overlay, &box, white, 1);
                rk_overlay_box(&c->overlay, &box, white, 0.5f);
                rk_overlay_triangle(&c->overlay, a, b, rk_vec(0, 1, -1), white, 0.5f);
            }
    for (size_t i = 0; i < 800; i++)
        rk_check(c->image.pixels[i].x >= 0 && c->image.pixels[i].x <= 1, "pixel %zu became %g", i,
                 (double)c->image.pixels[i].x);
    free_canvas(c);
}

static void shapes_with_a_nan_corner_are_not_drawn(void **state)
{
    (void)state;
    canvas *c = make_canvas(test_scene_make(0), 20, 20);
    for (int axis = 0; axis < 3; axis++) {
        rk_box box = {{rk_vec(-1, -1, -1), rk_vec(1, 1, 1)}};
        (&box.corner[0].x)[axis] = NAN;
        rk_overlay_box(&c->overlay, &box, white, 0.5f);
        rk_overlay_point(&c->overlay, box.corner[0], white, 3);
        rk_overlay_triangle(&c->overlay, box.corner[0], rk_vec(3, 0, 0), rk_vec(0, 3, 0), white, 1);
    }
    rk_box nothing = rk_box_empty();
    rk_overlay_box(&c->overlay, &nothing, white, 0.5f);
    rk_overlay_wireframe(&c->overlay, &nothing, white, 1);
    rk_check_equal(touched(c), 0, "nobody knows where it is");
    free_canvas(c);
}

static void a_point_like_line_is_a_point(void **state)
{
    (void)state;
    canvas *c = make_canvas(test_scene_make(0), 20, 20);
    rk_vec3 place = at_pixel(c, 7.5f, 4.5f);
    rk_overlay_line(&c->overlay, place, place, white, 1);
    rk_check_close(red(c, 7, 4), 1, 1e-4, "the pixel it is in");
    rk_check_close(sum_of_red(c), 1, 1e-3, "and no other");
    free_canvas(c);
}

static void colours_cycle_and_differ(void **state)
{
    (void)state;
    for (uint32_t n = 0; n < 20; n++) {
        rk_vec3 colour = rk_overlay_colour(n), next = rk_overlay_colour(n + 1);
        rk_check(rk_length(rk_sub(colour, next)) > 0.2f, "colours %u and %u are alike", n, n + 1);
        rk_check(rk_length(colour) > 0.2f, "colour %u is too dark on black", n);
    }
    rk_overlay_colour(UINT32_MAX);
}

/* --- Single rays ----------------------------------------------------------------------------- */

static void a_single_ray_hits_the_nearer_of_two_walls(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(4);
    test_scene_wall(&scene, 0, 5, 0);
    test_scene_wall(&scene, 2, 2, 0);
    canvas *c = make_canvas(scene, 1, 1);
    const rk_ray ray = {rk_vec(0.25f, 0.5f, 0), rk_vec(0, 0, 1), INFINITY};
    rk_surface surface;
    rk_check(rk_trace_one_surface(&surface, &c->accel, &ray), "the ray hits no wall");
    /* Some roundings of the walls' coordinates, which are up to 10. */
    rk_check_close(surface.point.z, 2, 1e-5, "the nearer wall's depth; the other's is 5");
    free_canvas(c);
}

static void a_single_ray_ends_at_its_t_max(void **state)
{
    (void)state;
    rk_scene scene = test_scene_make(2);
    test_scene_wall(&scene, 0, 5, 0);
    canvas *c = make_canvas(scene, 1, 1);
    const rk_ray before = {rk_vec(0, 0, 0), rk_vec(0, 0, 4), 1};
    const rk_ray through = {rk_vec(0, 0, 0), rk_vec(0, 0, 6), 1};
    rk_surface surface;
    rk_check(rk_trace_one(&c->accel, &through).triangle != RK_MISS, "a wall is between 0 and 6");
    rk_check(rk_trace_one(&c->accel, &before).triangle == RK_MISS, "no wall is between 0 and 4");
    rk_check(!rk_trace_one_surface(&surface, &c->accel, &before), "so there is no surface");
    free_canvas(c);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_level_line_covers_its_row_with_its_ends),
    cmocka_unit_test(a_slanted_line_is_where_projection_says),
    cmocka_unit_test(a_line_covers_its_length_times_its_width),
    cmocka_unit_test(a_point_is_a_disk),
    cmocka_unit_test(only_occluded_shadow_rays_have_gaps),
    cmocka_unit_test(lines_are_hidden_behind_surfaces_and_visible_in_front_of_them),
    cmocka_unit_test(a_line_into_the_depth_is_hidden_from_where_it_enters),
    cmocka_unit_test(lines_behind_the_viewer_are_clipped),
    cmocka_unit_test(a_wireframe_has_twelve_edges),
    cmocka_unit_test(edges_take_the_same_share_of_pictures_of_all_sizes),
    cmocka_unit_test(edges_of_small_pictures_are_a_pixel_wide),
    cmocka_unit_test(a_glass_box_blends_its_far_and_its_near_face),
    cmocka_unit_test(from_within_a_glass_box_only_its_far_face_is_visible),
    cmocka_unit_test(a_surface_hides_the_faces_behind_it),
    cmocka_unit_test(a_triangle_covers_just_the_pixels_in_which_it_is_the_nearest),
    cmocka_unit_test(a_triangle_is_blended_by_its_opacity),
    cmocka_unit_test(degenerate_drawings_end_and_leave_numbers),
    cmocka_unit_test(shapes_with_a_nan_corner_are_not_drawn),
    cmocka_unit_test(a_point_like_line_is_a_point),
    cmocka_unit_test(colours_cycle_and_differ),
    cmocka_unit_test(a_single_ray_hits_the_nearer_of_two_walls),
    cmocka_unit_test(a_single_ray_ends_at_its_t_max),
};

RK_SUITE("overlay", tests)
