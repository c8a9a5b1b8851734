/* The debug views: the focal surface and the lens rays, seen from the side, and the pixels that
 * take lens samples. */
#include "driver.h"

#include "render/blurred_pixels.h"

#include <stdlib.h>

static const rk_vec3 white = {1, 1, 1}, orange = {1, 0.35f, 0}, blue = {0.1f, 0.4f, 1};

/* --- From the side ---------------------------------------------------------------------------- */

/* The point of the focal surface that projects onto a point of the picture. */
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

/* The pixel's camera rays, from the lens through the focus, each to its hit or to twice the
 * distance of the focus. */
static void draw_rays(const rk_driver *driver, rk_overlay *overlay, const rk_view *view)
{
    const rk_ray_record *record = &driver->record;
    float x = (float)driver->pixel.x + 0.5f, y = (float)driver->pixel.y + 0.5f;
    rk_vec3 focus = focus_of(&driver->render.lens, view, x, y);
    float far = 2 * rk_length(rk_sub(focus, view->position));
    for (size_t i = 0; i < record->count; i++) {
        const rk_ray_record_entry *it = &record->rays[i];
        if (it->kind != RK_RAY_CAMERA)
            continue;
        bool is_hit = it->hit.triangle != RK_MISS;
        rk_vec3 end = rk_madd(it->ray.origin, it->ray.direction, is_hit ? it->hit.t : far);
        rk_overlay_line(overlay, it->ray.origin, end, is_hit ? orange : rk_scale(white, 0.6f),
                        1.5f);
        if (is_hit)
            rk_overlay_point(overlay, end, orange, 3);
    }
    rk_overlay_point(overlay, focus, white, 5);
}

/* Counts the pixel's camera rays, and records those that it has, or would have, out of focus. */
static bool record_rays(rk_driver *driver, rk_error *error)
{
    choices *c = driver->choices;
    driver->record.through_lens = false;
    if (!rk_driver_record_pixel(driver, &driver->scene, &driver->render, error))
        return false;
    c->rays = (uint32_t)rk_ray_record_count(&driver->record, RK_RAY_CAMERA, 0);
    driver->record.through_lens = true;
    return rk_driver_record_pixel(driver, &driver->scene, &driver->render, error);
}

static void look_from_the_side(rk_camera *camera, const rk_view *view, const choices *c)
{
    rk_vec3 forward = rk_scale(view->forward, 0.6f * camera->distance);
    camera->look_at = rk_add(view->position, forward);
    camera->rotation.x += c->viewer_pitch;
    camera->rotation.y += c->viewer_yaw;
    camera->distance *= c->viewer_far;
}

/* The scene through a pinhole. */
static bool render_from_the_side(rk_driver *driver, const rk_view *view, rk_overlay *overlay,
                                 rk_error *error)
{
    const uint32_t lens_samples = driver->render.lens_samples;
    look_from_the_side(&driver->scene.camera, view, driver->choices);
    driver->render.lens_samples = 0;
    const bool ok = rk_driver_render_overlay(driver, overlay, error);
    driver->render.lens_samples = lens_samples;
    return ok;
}

/* Nothing hides the rays, not even the scene. */
static void dim(const rk_driver *driver, rk_overlay *overlay)
{
    for (size_t i = 0; i < driver->image.width * driver->image.height; i++) {
        overlay->depth[i] = INFINITY;
        driver->image.pixels[i] = rk_scale(driver->image.pixels[i], 0.4f);
    }
}

/* From the side of the lens, which is where the camera was. */
bool draw_from_the_side(rk_driver *driver, rk_error *error)
{
    const bool rays = rk_driver_debug(driver, "rays");
    const rk_view view = view_of(driver);
    rk_overlay overlay;
    rk_driver_draw_pixel(driver);
    if ((rays && !record_rays(driver, error)) ||
        !render_from_the_side(driver, &view, &overlay, error))
        return false;
    if (rays)
        dim(driver, &overlay);
    draw_focal_surface(&overlay, &driver->render.lens, &view, rays ? 0.1f : 0.4f);
    draw_lens(&overlay, &driver->render.lens, &view);
    if (rays)
        draw_rays(driver, &overlay, &view);
    rk_overlay_free(&overlay);
    return true;
}

/* --- Pixels that take lens samples ------------------------------------------------------------ */

/* They become orange. */
static bool mark_blurred(rk_driver *driver, rk_error *error)
{
    const size_t pixels = (size_t)driver->image.width * driver->image.height;
    bool *blurred = rk_allocate_unset(pixels, sizeof *blurred, "marks", error);
    const bool ok = blurred && rk_blurred_pixels(blurred, &driver->scene, &driver->accel,
                                                 &driver->render, driver->pool, error);
    for (size_t i = 0; ok && i < pixels; i++)
        if (blurred[i])
            driver->image.pixels[i] = rk_mix(driver->image.pixels[i], orange, 0.5f);
    free(blurred);
    return ok;
}

bool draw_blurred(rk_driver *driver, rk_error *error)
{
    return rk_driver_render(driver, error) && mark_blurred(driver, error);
}
