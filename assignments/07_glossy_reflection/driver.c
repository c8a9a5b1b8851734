/* Draws the figures and measures the tables of glossy_reflection: rough mirrors with few and many
 * samples, the rays of one pixel, the dots in their disk, and what the ways to weigh them make of
 * directions that lead into the surface. */
#include "base/file.h"
#include "render/convergence.h"
#include "render/side_view.h"
#include "render/tile.h"

#include <stdio.h>

static const char summary[] =
    "Renders a scene whose mirrors are rough (--glossy samples in a disk of --glossy-radius).\n"
    "--debug rays shows the mirrored rays of --pixel from beside the camera.\n"
    "--debug dots shows their disk: as a whole, or what --pixel makes of it.\n"
    "--convergence puts the error of each map and sampler against time into a table.\n"
    "--policies puts the light that each way to weigh samples keeps into a table.";

typedef struct choices {
    rk_side_view viewer;
    bool convergence, policies;
    uint32_t most, reference; /* samples */
} choices;

static const char *const map_names[] = {"polar", "concentric"};
static const char *const sampler_names[] = {"uniform", "stratified", "low-discrepancy"};
static const rk_vec3 red = {1, 0.1f, 0.05f}, blue = {0.1f, 0.4f, 1}, yellow = {1, 0.85f, 0.1f},
                     grey = {0.35f, 0.35f, 0.35f};

/* --- The samples of a pixel ------------------------------------------------------------------- */

/* Finds the mirror that a camera ray meets. */
static bool look(const rk_driver *driver, const rk_ray *ray, rk_seen *seen, rk_error *error)
{
    rk_ray_batch rays = {.count = 0};
    rk_hit_batch hits;
    rk_counters counters = {0};
    rk_batch_push(&rays, ray);
    rk_accel_closest(&driver->accel, &rays, &hits, &counters);
    rk_hit hit = rk_batch_hit(&hits, 0);
    *seen = (rk_seen){.path = rk_path_start(0, 1), .to_viewer = rk_negate(ray->direction)};
    if (hit.triangle != RK_MISS)
        rk_scene_surface(&seen->surface, &driver->scene, ray, &hit);
    return (hit.triangle != RK_MISS && rk_mirrors(seen)) ||
           rk_fail(error,
                   "--debug %s: there is no mirror at the pixel %u,%u; choose one that shows a "
                   "mirror by --pixel X,Y",
                   driver->debug, driver->pixel.x, driver->pixel.y);
}

/* The i-th point of the unit disk that the renderer takes for the pixel's first ray. */
static rk_vec2 point_of(const rk_driver *driver, uint32_t i)
{
    const rk_render_options *options = &driver->render;
    const rk_sampler sampler = {options->glossy.sampling, options->seed,
                                options->samples * options->glossy.samples};
    uint32_t pixel = driver->pixel.y * options->width + driver->pixel.x;
    return rk_disk_at(options->glossy.map, rk_sample_2d(&sampler, pixel, i, RK_DIMENSION_GLOSSY));
}

/* --- Debug view: rays ------------------------------------------------------------------------- */

typedef struct drawing {
    const rk_driver *driver;
    rk_overlay overlay;
    rk_vec3 start;
    float reach; /* how far from the start the disk is drawn */
} drawing;

/* How far a ray gets; a step where there is nothing. */
static float length_of(const rk_driver *driver, rk_vec3 start, rk_vec3 direction)
{
    rk_ray ray = {start, direction, INFINITY};
    rk_ray_batch rays = {.count = 0};
    rk_hit_batch hits;
    rk_counters counters = {0};
    rk_batch_push(&rays, &ray);
    rk_accel_closest(&driver->accel, &rays, &hits, &counters);
    return hits.triangle[0] == RK_MISS ? 1 : hits.t[0];
}

static void draw_ray(drawing *d, rk_vec3 direction, rk_vec3 colour, float width)
{
    float length = length_of(d->driver, d->start, direction);
    rk_vec3 end = rk_madd(d->start, direction, length);
    rk_overlay_line(&d->overlay, d->start, end, colour, width);
    rk_overlay_point(&d->overlay, end, colour, 2 * width);
}

static rk_vec3 on_disk(const drawing *d, const rk_glossy_disk *disk, rk_vec2 at)
{
    float x = disk->radius * at.x, y = disk->radius * at.y;
    rk_vec3 to = rk_madd(rk_madd(disk->w, disk->u, x), disk->v, y);
    return rk_madd(d->start, to, d->reach);
}

static void draw_rim(drawing *d, const rk_glossy_disk *disk)
{
    enum { corners = 96 };
    for (int i = 0; i < corners; i++) {
        float a = 6.2831853f * (float)i / corners, b = 6.2831853f * (float)(i + 1) / corners;
        rk_overlay_line(&d->overlay, on_disk(d, disk, (rk_vec2){cosf(a), sinf(a)}),
                        on_disk(d, disk, (rk_vec2){cosf(b), sinf(b)}), yellow, 2.5f);
    }
}

static bool draw_rays(rk_driver *driver, const choices *c, rk_error *error)
{
    drawing d = {.driver = driver};
    rk_seen seen;
    rk_ray ray = rk_side_view_ray(driver);
    if (!look(driver, &ray, &seen, error) ||
        !rk_side_view_render(&c->viewer, driver, &d.overlay, error))
        return false;
    rk_glossy_disk disk = rk_glossy_disk_at(&driver->render.glossy, &seen);
    d.start = rk_surface_leave(&seen.surface, disk.w);
    d.reach = length_of(driver, d.start, disk.w) / 2;
    for (uint32_t i = 0; i < driver->render.glossy.samples; i++) {
        rk_vec3 direction;
        rk_vec2 at = point_of(driver, i);
        bool above = rk_glossy_direction(&disk, at, &direction);
        if (above)
            draw_ray(&d, direction, red, 1);
        rk_overlay_point(&d.overlay, on_disk(&d, &disk, at), above ? red : grey, 2.5f);
    }
    draw_rim(&d, &disk);
    rk_overlay_line(&d.overlay, ray.origin, d.start, rk_vec(1, 1, 1), 1.5f);
    draw_ray(&d, disk.w, blue, 3);
    rk_overlay_free(&d.overlay);
    return true;
}

/* --- Debug view: dots ------------------------------------------------------------------------- */

/* A ring from radius `inner` to `outer`, pixels, with smooth edges; a dot for a negative inner. */
static void put_ring(const rk_image *image, float x, float y, float inner, float outer,
                     rk_vec3 colour)
{
    for (size_t row = 0; row < image->height; row++)
        for (size_t column = 0; column < image->width; column++) {
            float r = hypotf((float)column + 0.5f - x, (float)row + 0.5f - y);
            float cover = rk_min(rk_min(outer - r, r - inner) + 0.5f, 1);
            rk_vec3 *pixel = rk_image_at(image, column, row);
            if (cover > 0)
                *pixel = rk_mix(*pixel, colour, cover);
        }
}

/* The unit disk, seen from the mirror; with --pixel, what its surface hides is grey. */
static bool draw_dots(rk_driver *driver, rk_error *error)
{
    const rk_image *image = &driver->image;
    float middle_x = (float)image->width / 2, middle_y = (float)image->height / 2;
    float radius = 0.46f * rk_min((float)image->width, (float)image->height);
    rk_seen seen;
    rk_glossy_disk disk = rk_glossy_disk_of(rk_vec(0, 0, 1), 1, rk_vec(0, 0, 1));
    if (driver->pixel.given) {
        rk_ray ray = rk_side_view_ray(driver);
        if (!look(driver, &ray, &seen, error))
            return false;
        disk = rk_glossy_disk_at(&driver->render.glossy, &seen);
    }
    for (size_t i = 0; i < image->width * image->height; i++)
        image->pixels[i] = rk_vec(0.01f, 0.01f, 0.015f);
    put_ring(image, middle_x, middle_y, radius - 1.5f, radius + 1.5f, yellow);
    for (uint32_t i = 0; i < driver->render.glossy.samples; i++) {
        rk_vec3 direction;
        rk_vec2 at = point_of(driver, i);
        bool above = rk_glossy_direction(&disk, at, &direction);
        put_ring(image, middle_x + radius * at.x, middle_y - radius * at.y, -1, 3.5f,
                 above ? red : grey);
    }
    put_ring(image, middle_x, middle_y, -1, 5, blue);
    return true;
}

/* --- Error against time ----------------------------------------------------------------------- */

static bool converge(rk_driver *driver, const choices *c, rk_error *error)
{
    rk_glossy_options *glossy = &driver->render.glossy;
    char truth[32], method[64];
    rk_image want;
    snprintf(truth, sizeof truth, "%u samples", c->reference);
    glossy->samples = c->reference;
    if (!rk_convergence_reference(driver, &want, error))
        return false;
    bool ok = true;
    for (uint32_t i = 0; ok && i < 6; i++) {
        glossy->sampling = (rk_sampler_kind)(i / 2);
        glossy->map = (rk_disk_map)(i % 2);
        snprintf(method, sizeof method, "%s, %s", sampler_names[i / 2], map_names[i % 2]);
        for (glossy->samples = 1; ok && glossy->samples <= c->most; glossy->samples *= 4)
            ok = rk_convergence_row_of(driver, "glossy_reflection_convergence", method,
                                       glossy->samples, &want, truth, error);
    }
    rk_image_free(&want);
    return ok;
}

/* --- Weights ---------------------------------------------------------------------------------- */

/* A room that is brighter above: what is seen in a direction. */
static double seen_in(rk_vec3 direction)
{
    return 1 + (double)direction.z;
}

/* The mean over the disk of what is seen above the surface, black elsewhere: the middles of a grid
 * on the disk, of which those at the border are off by less than what the table shows. */
static double integral_of(const rk_glossy_disk *disk)
{
    enum { side = 2000 };
    double sum = 0, count = 0;
    for (int i = 0; i < side * side; i++) {
        rk_vec2 at = {(2 * (float)(i % side) + 1) / side - 1,
                      (2 * (float)(i / side) + 1) / side - 1};
        rk_vec3 direction;
        if (at.x * at.x + at.y * at.y > 1)
            continue;
        count++;
        if (rk_glossy_direction(disk, at, &direction))
            sum += seen_in(direction);
    }
    return sum / count;
}

/* The mean of what `pixels` pixels make of it with so many samples each. */
static double estimate_of(const rk_driver *driver, const rk_glossy_disk *disk,
                          rk_glossy_weights weights)
{
    enum { pixels = 4096 };
    const rk_glossy_options *glossy = &driver->render.glossy;
    const rk_sampler sampler = {glossy->sampling, driver->render.seed, glossy->samples};
    float share = rk_glossy_share(disk);
    double mean = 0;
    for (uint32_t pixel = 0; pixel < pixels; pixel++) {
        double sum = 0;
        uint32_t above = 0;
        for (uint32_t i = 0; i < glossy->samples; i++) {
            rk_vec2 at =
                rk_disk_at(glossy->map, rk_sample_2d(&sampler, pixel, i, RK_DIMENSION_GLOSSY));
            rk_vec3 direction;
            if (rk_glossy_direction(disk, at, &direction)) {
                sum += seen_in(direction);
                above++;
            }
        }
        mean += sum * (double)rk_glossy_weight(weights, above, glossy->samples, share) / pixels;
    }
    return mean;
}

static bool put_policies(rk_driver *driver, rk_error *error)
{
    static const char *const header[] = {"degrees", "radius",     "share above",  "black below",
                                         "classic", "above only", "renormalised", NULL};
    static const float degrees[] = {1, 2, 5, 10, 15, 20, 30};
    char path[4096];
    snprintf(path, sizeof path, "%s/tables", driver->out);
    if (!rk_make_folder(path, error))
        return false;
    snprintf(path, sizeof path, "%s/tables/glossy_reflection_policies.csv", driver->out);
    float radius = driver->render.glossy.radius >= 0 ? driver->render.glossy.radius : 0.5f;
    for (size_t i = 0; i < sizeof degrees / sizeof *degrees; i++) {
        float height = degrees[i] * 0.017453293f;
        rk_glossy_disk disk =
            rk_glossy_disk_of(rk_vec(cosf(height), 0, sinf(height)), radius, rk_vec(0, 0, 1));
        double share = (double)rk_glossy_share(&disk), black = integral_of(&disk);
        const double figures[] = {(double)degrees[i],
                                  (double)radius,
                                  share,
                                  black,
                                  estimate_of(driver, &disk, RK_GLOSSY_CLASSIC),
                                  black / share,
                                  estimate_of(driver, &disk, RK_GLOSSY_RENORMALIZED)};
        char cells[7][32];
        const char *row[7];
        for (int k = 0; k < 7; k++) {
            snprintf(cells[k], sizeof cells[k], k < 2 ? "%g" : "%.4f", figures[k]);
            row[k] = cells[k];
        }
        if (!rk_table_put(path, header, row, 7, 2, error))
            return false;
    }
    return true;
}

/* --- The driver ------------------------------------------------------------------------------- */

/* Under names of their own for each number of samples. */
static bool put_rows(rk_driver *driver, rk_error *error)
{
    double rays = (double)driver->counters.reflected_rays / (double)driver->counters.primary_rays;
    char render[32], reflected[32];
    snprintf(render, sizeof render, "render_%u", driver->render.glossy.samples);
    snprintf(reflected, sizeof reflected, "reflected_rays_%u", driver->render.glossy.samples);
    return rk_driver_row(driver, render, "ms", driver->render_ms, error) &&
           rk_driver_row(driver, reflected, "1", rk_timing_once(rays), error);
}

static bool save(rk_driver *driver, bool of_pixel, rk_error *error)
{
    const rk_glossy_options *glossy = &driver->render.glossy;
    char label[128], pixel[32] = "", radius[32] = "";
    if (driver->debug && of_pixel)
        snprintf(pixel, sizeof pixel, "_%u_%u", driver->pixel.x, driver->pixel.y);
    if (glossy->radius >= 0)
        snprintf(radius, sizeof radius, "_radius%g", (double)glossy->radius);
    snprintf(label, sizeof label, "%s%s%u_%s_%s%s%s%s", driver->debug ? driver->debug : "",
             driver->debug ? "_" : "", glossy->samples, map_names[glossy->map],
             sampler_names[glossy->sampling], radius,
             glossy->weights == RK_GLOSSY_CLASSIC ? "_classic" : "", pixel);
    return rk_driver_save(driver, label, error);
}

static bool draw(rk_driver *driver, const choices *c, rk_error *error)
{
    if (rk_driver_debug(driver, "dots"))
        return draw_dots(driver, error);
    return driver->debug ? draw_rays(driver, c, error) : rk_driver_render(driver, error);
}

int main(int argc, char **argv)
{
    choices c = {.viewer = rk_side_view_default(), .most = 256, .reference = 4096};
    const rk_option options[] = {
        RK_SIDE_VIEW_OPTIONS(c.viewer),
        {"convergence", RK_OPTION_FLAG, &c.convergence, NULL,
         "put the error and time of each map, sampler and number of samples into a table", 0, 0},
        {"policies", RK_OPTION_FLAG, &c.policies, NULL,
         "put what each way to weigh samples makes of grazing reflections into a table", 0, 0},
        {"most", RK_OPTION_UINT, &c.most, "N", "samples that --convergence goes up to", 1, 4096},
        {"reference", RK_OPTION_UINT, &c.reference, "N",
         "samples of the picture that --convergence compares with", 1, 16384},
        {0},
    };
    const char *const views[] = {"rays", "dots", NULL};
    rk_driver driver = rk_driver_default("glossy_reflection", summary);
    driver.split = RK_ACCEL_SAH_3;
    driver.drawn_x = 36; /* the mirror of the Cornell box */
    driver.drawn_y = 56;
    driver.render.reflections = true;
    driver.render.glossy.samples = 64;
    driver.render.glossy.radius = 0.1f; /* the box' own mirror is too shiny to see it */
    int status;
    if (!rk_driver_start(&driver, argc, argv, options, views, &status))
        return status;
    rk_error error = {""};
    bool of_pixel = rk_driver_debug(&driver, "rays") || driver.pixel.given;
    bool ok = rk_driver_build(&driver, &error);
    if (ok && (c.convergence || c.policies)) {
        ok = c.convergence ? converge(&driver, &c, &error) : put_policies(&driver, &error);
        return rk_driver_finish(&driver, ok, &error);
    }
    ok = ok && draw(&driver, &c, &error);
    if (ok)
        ok = driver.timing ? put_rows(&driver, &error) : save(&driver, of_pixel, &error);
    return rk_driver_finish(&driver, ok, &error);
}
