/* Draws the figures and measures the tables of depth of field: a scene through a lens, what the
 * lens is focused on and how its rays get there, seen from the side, and errors by the closed form.
 */
#include "render/driver.h"
#include "base/file.h"

#include <stdio.h>
#include <stdlib.h>

static const char summary[] =
    "Renders a scene through a lens (--focal-distance, --aperture, --lens-samples).\n"
    "--debug focus shows the focal surface, --debug rays the lens rays of --pixel, both from the "
    "side.\n"
    "--debug blurred marks the pixels that take lens samples.\n"
    "--convergence puts the errors of a blurred edge into a table.";

static const rk_vec3 white = {1, 1, 1}, orange = {1, 0.35f, 0}, blue = {0.1f, 0.4f, 1};

static const char *const sampling_names[] = {"uniform", "stratified", "low-discrepancy"};

typedef struct choices {
    float viewer_yaw, viewer_pitch, viewer_far; /* where the side is */
    bool convergence;
} choices;

static bool check(const rk_driver *driver, rk_error *error)
{
    if (rk_driver_debug(driver, "focus") && driver->pixel.given)
        return rk_fail(error, "--debug focus shows no pixel: --pixel goes without --debug, or with "
                              "--debug rays or blurred");
    if (driver->debug && (driver->render.lens_samples == 0 || !(driver->render.lens.aperture > 0)))
        return rk_fail(error, "--debug %s goes with a lens: --lens-samples and --aperture above 0",
                       driver->debug);
    return true;
}

static rk_view view_of(const rk_driver *driver)
{
    return rk_view_of(&driver->scene.camera, driver->render.width, driver->render.height);
}

/* --- From the side ---------------------------------------------------------------------------- */

/* The point of the focal surface that a place of the picture sees. */
static rk_vec3 focus_of(const rk_lens *lens, const rk_view *view, float x, float y)
{
    rk_ray ray = rk_view_ray(view, x, y);
    float cosine = rk_dot(ray.direction, view->forward);
    float t = lens->focal_distance / (lens->focal == RK_FOCAL_PLANE ? cosine : 1);
    return rk_madd(ray.origin, ray.direction, t);
}

/* The part of the focal surface that is in the picture, as glass, with lines for its rim and from
 * its corners to the camera. */
static void draw_focal_surface(rk_overlay *overlay, const rk_lens *lens, const rk_view *view,
                               float alpha)
{
    const uint32_t cells = lens->focal == RK_FOCAL_PLANE ? 1 : 16;
    float dx = view->width / (float)cells, dy = view->height / (float)cells;
    for (uint32_t i = 0; i < cells * cells; i++) {
        float x = (float)(i % cells) * dx, y = (float)(i / cells) * dy;
        rk_vec3 a = focus_of(lens, view, x, y), b = focus_of(lens, view, x + dx, y);
        rk_vec3 c = focus_of(lens, view, x, y + dy), d = focus_of(lens, view, x + dx, y + dy);
        rk_overlay_triangle(overlay, a, b, d, blue, alpha);
        rk_overlay_triangle(overlay, a, d, c, blue, alpha);
        if (y == 0)
            rk_overlay_line(overlay, a, b, blue, 2);
        if (x == 0)
            rk_overlay_line(overlay, a, c, blue, 2);
        if (i / cells == cells - 1)
            rk_overlay_line(overlay, c, d, blue, 2);
        if (i % cells == cells - 1)
            rk_overlay_line(overlay, b, d, blue, 2);
    }
    for (int corner = 0; corner < 4; corner++)
        rk_overlay_line(
            overlay, view->position,
            focus_of(lens, view, corner & 1 ? view->width : 0, corner & 2 ? view->height : 0),
            rk_scale(white, 0.4f), 1);
}

/* The rim of the lens. */
static void draw_lens(rk_overlay *overlay, const rk_lens *lens, const rk_view *view)
{
    enum { sides = 48 };
    rk_vec3 last = {0, 0, 0};
    for (int i = 0; i <= sides; i++) {
        float angle = 6.28318531f * (float)i / sides, radius = 0.5e-3f * lens->aperture;
        rk_vec3 point = rk_madd(rk_madd(view->position, view->right, radius * cosf(angle)),
                                view->up, radius * sinf(angle));
        if (i > 0)
            rk_overlay_line(overlay, last, point, white, 2);
        last = point;
    }
}

/* From the lens through the focus to what each ray meets, or as far again as the focus is. */
static void draw_rays(const rk_driver *driver, rk_overlay *overlay, const rk_view *view)
{
    const rk_render_options *options = &driver->render;
    const rk_sampler sampler = {options->lens_sampling, options->seed, options->lens_samples};
    float x = (float)driver->pixel.x + 0.5f, y = (float)driver->pixel.y + 0.5f;
    uint32_t pixel = driver->pixel.y * options->width + driver->pixel.x;
    rk_vec3 focus = focus_of(&options->lens, view, x, y);
    float far = 2 * rk_length(rk_sub(focus, view->position));
    for (uint32_t i = 0; i < options->lens_samples; i++) {
        rk_ray ray = rk_lens_ray(&options->lens, view, x, y,
                                 rk_sample_2d(&sampler, pixel, i, RK_DIMENSION_LENS));
        rk_ray_batch rays = {.count = 0};
        rk_hit_batch hits;
        rk_counters counters = {0};
        rk_batch_push(&rays, &ray);
        rk_accel_closest(&driver->accel, &rays, &hits, &counters);
        bool met = hits.triangle[0] != RK_MISS;
        rk_vec3 end = rk_madd(ray.origin, ray.direction, met ? hits.t[0] : far);
        rk_overlay_line(overlay, ray.origin, end, met ? orange : rk_scale(white, 0.6f), 1.5f);
        if (met)
            rk_overlay_point(overlay, end, orange, 3);
    }
    rk_overlay_point(overlay, focus, white, 5);
}

static void look_from_the_side(rk_camera *camera, const rk_view *view, const choices *c)
{
    rk_vec3 forward = rk_scale(view->forward, 0.6f * camera->distance);
    camera->look_at = rk_add(view->position, forward);
    camera->rotation.x += c->viewer_pitch;
    camera->rotation.y += c->viewer_yaw;
    camera->distance *= c->viewer_far;
}

/* The scene by a pinhole from the side of the lens, which stands where the camera was. */
static bool render_from_the_side(rk_driver *driver, const choices *c, rk_error *error)
{
    bool rays = rk_driver_debug(driver, "rays");
    rk_view view = view_of(driver);
    rk_overlay overlay;
    rk_driver_draw_pixel(driver);
    look_from_the_side(&driver->scene.camera, &view, c);
    uint32_t lens_samples = driver->render.lens_samples;
    driver->render.lens_samples = 0;
    if (!rk_driver_render(driver, error) ||
        !rk_overlay_init(&overlay, &driver->image, &driver->scene, &driver->accel, driver->pool,
                         error))
        return false;
    driver->render.lens_samples = lens_samples;
    /* Rays are to be seen through the scene as well. */
    for (size_t i = 0; rays && i < driver->image.width * driver->image.height; i++) {
        overlay.depth[i] = INFINITY;
        driver->image.pixels[i] = rk_scale(driver->image.pixels[i], 0.4f);
    }
    draw_focal_surface(&overlay, &driver->render.lens, &view, rays ? 0.1f : 0.4f);
    draw_lens(&overlay, &driver->render.lens, &view);
    if (rays)
        draw_rays(driver, &overlay, &view);
    rk_overlay_free(&overlay);
    return true;
}

/* --- Which pixels take lens samples ----------------------------------------------------------- */

/* They become orange. As in the renderer, but for mirrors and panes. */
static bool mark_blurred(rk_driver *driver, rk_error *error)
{
    uint32_t width = driver->render.width, height = driver->render.height;
    rk_overlay overlay;
    int32_t *circles =
        rk_allocate_unset(((size_t)width + 1) * (height + 1), sizeof *circles, "marks", error);
    if (!circles || !rk_overlay_init(&overlay, &driver->image, &driver->scene, &driver->accel,
                                     driver->pool, error)) {
        free(circles);
        return false;
    }
    for (size_t i = 0; i < (size_t)width * height; i++) {
        rk_ray ray =
            rk_view_ray(&overlay.view, (float)(i % width) + 0.5f, (float)(i / width) + 0.5f);
        float *depth = &overlay.depth[i]; /* becomes a circle's diameter */
        *depth =
            isinf(*depth) ? 0 : rk_lens_blur(&driver->render.lens, &overlay.view, &ray, *depth);
    }
    rk_lens_spread(overlay.depth, width, height, circles);
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++)
            if (circles[(size_t)y * (width + 1) + x] > 0) {
                rk_vec3 *pixel = rk_image_at(&driver->image, x, y);
                *pixel = rk_mix(*pixel, orange, 0.5f);
            }
    rk_overlay_free(&overlay);
    free(circles);
    return true;
}

/* --- Tables ----------------------------------------------------------------------------------- */

static bool put_rows(rk_driver *driver, rk_error *error)
{
    const rk_render_options *o = &driver->render;
    double pixels = (double)o->width * o->height;
    char metric[64] = "render_pinhole";
    if (o->lens_samples > 0)
        snprintf(metric, sizeof metric, "render_%g_%g", (double)o->lens.focal_distance,
                 (double)o->lens.aperture);
    if (!rk_driver_row(driver, metric, "ms", driver->render_ms, error))
        return false;
    if (o->lens_samples == 0)
        return true;
    snprintf(metric, sizeof metric, "blurred_%g_%g", (double)o->lens.focal_distance,
             (double)o->lens.aperture);
    double blurred = (double)driver->counters.lens_samples /
                     (o->lens_samples > o->samples ? o->lens_samples : o->samples);
    return rk_driver_row(driver, metric, "%", rk_timing_once(100 * blurred / pixels), error);
}

/* A wall that ends at x = 0, seen from 3 units; half of the picture, but for the lens. */
static bool make_edge(rk_driver *driver, rk_error *error)
{
    rk_mesh wall;
    if (!rk_mesh_init(&wall, 3, 1, 1, 0, error))
        return false;
    wall.positions[0] = rk_vec(0, -40, 0);
    wall.positions[1] = rk_vec(0, 40, 0);
    wall.positions[2] = rk_vec(40, 0, 0);
    wall.materials[0].kd = white;
    for (uint32_t k = 0; k < 3; k++)
        wall.triangles[0][k] = k;
    rk_scene_free(&driver->scene);
    driver->scene = (rk_scene){
        .name = "edge",
        .mesh = wall,
        .camera = {.distance = 3, .fov = 50},
        .light_count = 1,
        .lights = {rk_light_point(rk_vec(0, 0, -3), white)},
    };
    return true;
}

/* The part of a disk of diameter 2 left of x, a segment's area over the disk's; from -1 to 1. */
static double disk_left_of(double x)
{
    const double pi = 3.14159265358979323846;
    x = fmin(fmax(x, -1), 1);
    return 0.5 + (asin(x) + x * sqrt(1 - x * x)) / pi;
}

/* The wall's share of a pixel whose middle is `x` pixels right of the edge, with a circle of so
 * many pixels: the mean over the pixel, of 64 strips. */
static double wall_seen(double x, double diameter)
{
    const int strips = 64;
    double sum = 0;
    for (int i = 0; i < strips; i++)
        sum += 1 - disk_left_of((x - 0.5 + (i + 0.5) / strips) / (0.5 * diameter));
    return sum / strips;
}

static void measure(const rk_driver *driver, double diameter, rk_convergence_row *row)
{
    const rk_image *image = &driver->image;
    double squares = 0, sum = 0, counted = 0;
    for (size_t x = 0; x < image->width; x++) {
        double right = (double)x + 0.5 - 0.5 * (double)image->width;
        if (fabs(right) > 0.5 * diameter)
            continue;
        double want = wall_seen(right, diameter);
        for (size_t y = 0; y < image->height; y++, counted++) {
            double error = (double)rk_image_at(image, x, y)->x - want;
            squares += error * error;
            sum += error;
            row->max_error = fmax(row->max_error, fabs(error));
        }
    }
    row->rmse = sqrt(squares / counted);
    row->bias = sum / counted;
}

/* The edge of a wall behind the focus, by all ways of sampling. */
static bool put_convergence(rk_driver *driver, rk_error *error)
{
    rk_render_options *o = &driver->render;
    o->shading.model = RK_SHADING_OFF;
    o->lens.focal_distance = 1.5f;
    char path[4096];
    snprintf(path, sizeof path, "%s/tables", driver->out);
    if (!make_edge(driver, error) || !rk_driver_build(driver, error) ||
        !rk_make_folder(path, error))
        return false;
    snprintf(path, sizeof path, "%s/tables/depth_of_field_convergence.csv", driver->out);
    /* The aperture for a circle of so many pixels, by the closed form. */
    const double diameter = 32, d = 3, f = (double)o->lens.focal_distance;
    o->lens.aperture = (float)(1e3 * diameter * (double)view_of(driver).pixel * d * f / (d - f));
    for (int kind = RK_SAMPLER_UNIFORM; kind <= RK_SAMPLER_LOW_DISCREPANCY; kind++)
        for (uint32_t samples = 1; samples <= 1024; samples *= 2) {
            o->lens_samples = samples;
            o->lens_sampling = (rk_sampler_kind)kind;
            if (!rk_driver_render(driver, error))
                return false;
            rk_convergence_row row = {.feature = driver->feature,
                                      .scene = driver->scene.name,
                                      .method = sampling_names[kind],
                                      .samples = samples,
                                      .seconds = driver->render_ms.median / 1e3,
                                      .reference = "closed form"};
            measure(driver, diameter, &row);
            if (!rk_table_put_convergence(path, &row, error))
                return false;
        }
    return true;
}

/* --- The driver ------------------------------------------------------------------------------- */

static bool save(rk_driver *driver, rk_error *error)
{
    const rk_render_options *o = &driver->render;
    char label[128] = "pinhole", pixel[32] = "";
    if (rk_driver_debug(driver, "rays"))
        snprintf(pixel, sizeof pixel, "_%u_%u", driver->pixel.x, driver->pixel.y);
    if (o->lens_samples > 0)
        snprintf(label, sizeof label, "%s%s%s_%g_%g_%u%s", driver->debug ? driver->debug : "",
                 driver->debug ? "_" : "", o->lens.focal == RK_FOCAL_PLANE ? "plane" : "sphere",
                 (double)o->lens.focal_distance, (double)o->lens.aperture, o->lens_samples, pixel);
    return rk_driver_save(driver, label, error);
}

int main(int argc, char **argv)
{
    choices c = {.viewer_yaw = 75, .viewer_pitch = -5, .viewer_far = 1.8f};
    const rk_option options[] = {
        {"viewer-yaw", RK_OPTION_FLOAT, &c.viewer_yaw, "DEG",
         "the side is the camera's, turned so far about y", -360, 360},
        {"viewer-pitch", RK_OPTION_FLOAT, &c.viewer_pitch, "DEG", "and so far about x", -360, 360},
        {"viewer-far", RK_OPTION_FLOAT, &c.viewer_far, "F", "from F times the camera's distance",
         0.01, 100},
        {"convergence", RK_OPTION_FLAG, &c.convergence, NULL,
         "put errors into DIR/tables/depth_of_field_convergence.csv instead of drawing a picture",
         0, 0},
        {0},
    };
    const char *const views[] = {"focus", "rays", "blurred", NULL};
    rk_driver driver = rk_driver_default("depth_of_field", summary);
    driver.scene_name = "scan:87130";
    driver.render.lens_samples = 15;
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool ok = check(&driver, &error);
    if (ok && c.convergence)
        return rk_driver_finish(&driver, put_convergence(&driver, &error), &error);
    bool side = rk_driver_debug(&driver, "focus") || rk_driver_debug(&driver, "rays");
    ok = ok && rk_driver_build(&driver, &error) &&
         (side ? render_from_the_side(&driver, &c, &error) : rk_driver_render(&driver, &error));
    if (ok && rk_driver_debug(&driver, "blurred"))
        ok = mark_blurred(&driver, &error);
    if (ok && driver.timing)
        ok = put_rows(&driver, &error);
    else if (ok)
        ok = save(&driver, &error);
    return rk_driver_finish(&driver, ok, &error);
}
