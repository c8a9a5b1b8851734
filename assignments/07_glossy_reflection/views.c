/* The debug views: a pixel's reflected rays, from beside the camera, and the samples in their
 * disk. */
#include "driver.h"

#include "accel/query/trace_one.h"
#include "render/stages/glossy_reflection_stage.h"
#include "render/stages/reflection_stage.h"

static const rk_vec3 red = {1, 0.1f, 0.05f}, blue = {0.1f, 0.4f, 1}, yellow = {1, 0.85f, 0.1f},
                     grey = {0.35f, 0.35f, 0.35f};

/* --- The samples of a pixel ------------------------------------------------------------------- */

/* The pixel's rays, and the mirror that the first one hits. */
static bool record_rays(rk_driver *driver, rk_shading_point *point, rk_error *error)
{
    rk_driver_draw_pixel(driver);
    if (!rk_driver_record_pixel(driver, &driver->scene, &driver->render, error))
        return false;
    const rk_ray_record_entry *first = driver->record.rays;
    const bool is_hit = driver->record.count > 0 && first->hit.triangle != RK_MISS;
    *point = (rk_shading_point){.path = rk_path_start(0, 1)};
    if (is_hit) {
        point->to_viewer = rk_negate(first->ray.direction);
        rk_scene_surface(&point->surface, &driver->scene, &first->ray, &first->hit);
    }
    return (is_hit && rk_is_specular(point)) ||
           rk_fail(error,
                   "--debug %s: there is no mirror at the pixel %u,%u; choose one that shows a "
                   "mirror by --pixel X,Y",
                   driver->debug, driver->pixel.x, driver->pixel.y);
}

/* The i-th point of the unit disk that the renderer takes for the pixel's first ray. */
static rk_vec2 point_of(const rk_driver *driver, const rk_glossy_disk *disk, uint32_t i)
{
    const rk_render_options *options = &driver->render;
    const rk_sampler sampler = rk_render_sampler(options, options->glossy.sampling,
                                                 options->samples * options->glossy.samples);
    uint32_t pixel = driver->pixel.y * options->width + driver->pixel.x;
    rk_vec2 at =
        rk_disk_at(options->glossy.map, rk_joint_2d(&sampler, pixel, i, RK_DIMENSION_GLOSSY));
    if (options->glossy.weights == RK_GLOSSY_CLASSIC)
        return at;
    return rk_glossy_point_above(disk, rk_glossy_fraction_above(disk), at);
}

/* --- Rays ------------------------------------------------------------------------------------- */

typedef struct drawing {
    const rk_driver *driver;
    rk_overlay overlay;
    rk_vec3 start;
    float reach; /* how far from the start the disk is drawn */
} drawing;

/* The distance to the closest hit; 1 for a miss. */
static float length_of(const rk_driver *driver, rk_vec3 start, rk_vec3 direction)
{
    rk_ray ray = {start, direction, INFINITY};
    rk_hit hit = rk_trace_one(&driver->accel, &ray);
    return hit.triangle == RK_MISS ? 1 : hit.t;
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
    rk_vec3 direction;
    (void)rk_glossy_direction(disk, at, &direction);
    return rk_madd(d->start, direction, d->reach / rk_dot(direction, disk->w));
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

/* The rays that the renderer traced for the pixel's first sample. */
static void draw_reflected(drawing *d, const rk_glossy_disk *disk)
{
    const rk_ray_record *record = &d->driver->record;
    for (size_t i = 0; i < record->count; i++) {
        const rk_ray_record_entry *it = &record->rays[i];
        if (it->kind != RK_RAY_REFLECTED || it->bounce != 1 || it->sample > 0)
            continue;
        const float stretch = d->reach / rk_dot(it->ray.direction, disk->w);
        draw_ray(d, it->ray.direction, red, 1);
        rk_overlay_point(&d->overlay, rk_madd(d->start, it->ray.direction, stretch), red, 2.5f);
    }
}

/* Samples below the surface have no ray. */
static void draw_discarded(drawing *d, const rk_glossy_disk *disk)
{
    for (uint32_t i = 0; i < d->driver->render.glossy.samples; i++) {
        rk_vec3 direction;
        const rk_vec2 at = point_of(d->driver, disk, i);
        if (!rk_glossy_direction(disk, at, &direction))
            rk_overlay_point(&d->overlay, on_disk(d, disk, at), grey, 2.5f);
    }
}

bool draw_rays(rk_driver *driver, rk_error *error)
{
    const choices *c = driver->choices;
    drawing d = {.driver = driver};
    rk_shading_point point;
    if (!record_rays(driver, &point, error) ||
        !rk_side_view_render(&c->viewer, driver, &d.overlay, error))
        return false;
    rk_glossy_disk disk = rk_glossy_disk_at(&driver->render.glossy, &point);
    d.start = rk_surface_spawn(&point.surface, disk.w);
    d.reach = length_of(driver, d.start, disk.w) / 2;
    draw_reflected(&d, &disk);
    draw_discarded(&d, &disk);
    draw_rim(&d, &disk);
    rk_overlay_line(&d.overlay, driver->record.rays[0].ray.origin, d.start, rk_vec(1, 1, 1), 1.5f);
    draw_ray(&d, disk.w, blue, 3);
    rk_overlay_free(&d.overlay);
    return true;
}

/* --- Dots ------------------------------------------------------------------------------------- */

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

/* The unit disk, seen from the mirror; with --pixel, discarded samples are grey. */
bool draw_dots(rk_driver *driver, rk_error *error)
{
    const rk_image *image = &driver->image;
    float middle_x = (float)image->width / 2, middle_y = (float)image->height / 2;
    float radius = 0.46f * rk_min((float)image->width, (float)image->height);
    rk_shading_point point;
    rk_glossy_disk disk = rk_glossy_disk_of(rk_vec(0, 0, 1), 1, rk_vec(0, 0, 1));
    if (driver->pixel.given) {
        if (!record_rays(driver, &point, error))
            return false;
        disk = rk_glossy_disk_at(&driver->render.glossy, &point);
    }
    for (size_t i = 0; i < image->width * image->height; i++)
        image->pixels[i] = rk_vec(0.01f, 0.01f, 0.015f);
    put_ring(image, middle_x, middle_y, radius - 1.5f, radius + 1.5f, yellow);
    for (uint32_t i = 0; i < driver->render.glossy.samples; i++) {
        rk_vec3 direction;
        rk_vec2 at = point_of(driver, &disk, i);
        bool above = rk_glossy_direction(&disk, at, &direction);
        put_ring(image, middle_x + radius * at.x, middle_y - radius * at.y, -1, 3.5f,
                 above ? red : grey);
    }
    put_ring(image, middle_x, middle_y, -1, 5, blue);
    return true;
}
