/* Lines and points are drawn in the picture's plane with smooth edges; boxes and triangles are
 * intersected by the pixels' own rays, so that they agree with the scene to the bit. */
#include "driver/overlay.h"

#include "accel/query/trace.h"
#include "base/box.h"
#include "features/watertight.h"

#include <stdlib.h>

typedef struct depth_pass {
    rk_overlay *overlay;
    const rk_accel *accel;
} depth_pass;

static size_t pixel_index(const rk_overlay *overlay, uint32_t x, uint32_t y)
{
    return (size_t)y * overlay->image->width + x;
}

static rk_ray pixel_ray(const rk_overlay *overlay, uint32_t x, uint32_t y)
{
    return rk_view_ray(&overlay->view, (float)x + 0.5f, (float)y + 0.5f);
}

static void find_row_depth(uint32_t y, uint32_t thread, void *context)
{
    (void)thread;
    depth_pass *pass = context;
    rk_counters counters = {0};
    uint32_t width = (uint32_t)pass->overlay->image->width;
    for (uint32_t x = 0; x < width;) {
        rk_ray_batch rays = {.count = 0};
        uint32_t first = x;
        for (; x < width && rays.count < RK_BATCH_MAX; x++) {
            rk_ray ray = pixel_ray(pass->overlay, x, y);
            rk_batch_push(&rays, &ray);
        }
        rk_hit_batch hits;
        rk_accel_closest(pass->accel, &rays, &hits, &counters);
        for (uint32_t i = 0; i < rays.count; i++)
            pass->overlay->depth[pixel_index(pass->overlay, first + i, y)] = hits.t[i];
    }
}

bool rk_overlay_init(rk_overlay *overlay, rk_image *image, const rk_scene *scene,
                     const rk_accel *accel, rk_pool *pool, rk_error *error)
{
    *overlay = (rk_overlay){image, rk_view_of(&scene->camera, image->width, image->height), NULL};
    overlay->depth =
        rk_allocate_unset(image->width * image->height, sizeof *overlay->depth, "overlay", error);
    if (!overlay->depth)
        return false;
    depth_pass pass = {overlay, accel};
    rk_pool_run(pool, (uint32_t)image->height, find_row_depth, &pass);
    return true;
}

void rk_overlay_free(rk_overlay *overlay)
{
    free(overlay->depth);
    *overlay = (rk_overlay){0};
}

static void blend(rk_overlay *overlay, uint32_t x, uint32_t y, rk_vec3 colour, float alpha)
{
    rk_vec3 *pixel = rk_image_at(overlay->image, x, y);
    *pixel = rk_mix(*pixel, colour, alpha);
}

/* --- In the picture's plane ------------------------------------------------------------------ */

/* A rectangle of pixels, [x0, x1) by [y0, y1). */
typedef struct pixel_range {
    uint32_t x0, y0, x1, y1;
} pixel_range;

static uint32_t clamp_to(float v, size_t limit)
{
    return v > 0 ? (v < (float)limit ? (uint32_t)v : (uint32_t)limit) : 0;
}

static pixel_range range_around(const rk_overlay *overlay, rk_vec2 lo, rk_vec2 hi, float margin)
{
    const rk_image *image = overlay->image;
    return (pixel_range){
        clamp_to(floorf(lo.x - margin), image->width),
        clamp_to(floorf(lo.y - margin), image->height),
        clamp_to(ceilf(hi.x + margin), image->width),
        clamp_to(ceilf(hi.y + margin), image->height),
    };
}

/* A pixel is hidden when the scene is nearer than the drawing by more than `thickness`. The depth
 * along the view direction becomes a distance along the pixel's ray by the angle between them. */
static bool is_hidden(const rk_overlay *overlay, uint32_t x, uint32_t y, float view_depth,
                      float thickness)
{
    rk_ray ray = pixel_ray(overlay, x, y);
    float distance = view_depth / rk_dot(ray.direction, overlay->view.forward);
    return overlay->depth[pixel_index(overlay, x, y)] < distance - thickness;
}

static float pixel_size_at(const rk_overlay *overlay, float view_depth)
{
    return view_depth * overlay->view.pixel;
}

bool rk_overlay_clip(const rk_view *view, rk_vec3 *from, rk_vec3 *to)
{
    float from_depth = rk_dot(rk_sub(*from, view->position), view->forward);
    float to_depth = rk_dot(rk_sub(*to, view->position), view->forward);
    /* A thousandth of the segment's largest depth: nearer parts would cover the whole picture, and
     * dividing by their depth would overflow. */
    float nearest = 1e-3f * rk_max(from_depth, to_depth);
    if (!(nearest > 0))
        return false;
    rk_vec3 a = *from, b = *to;
    if (from_depth < nearest)
        *from = rk_mix(a, b, (nearest - from_depth) / (to_depth - from_depth));
    if (to_depth < nearest)
        *to = rk_mix(b, a, (nearest - to_depth) / (from_depth - to_depth));
    return true;
}

/* The part of `range` in row y within `reach` of the segment from a to b. */
static pixel_range range_in_row(const rk_overlay *overlay, pixel_range range, uint32_t y, rk_vec2 a,
                                rk_vec2 b, float reach)
{
    if (a.y == b.y)
        return range;
    float middle = (float)y + 0.5f - a.y, slope = 1 / (b.y - a.y);
    float s0 = rk_min(rk_max((middle - reach) * slope, 0), 1);
    float s1 = rk_min(rk_max((middle + reach) * slope, 0), 1);
    float x0 = a.x + s0 * (b.x - a.x), x1 = a.x + s1 * (b.x - a.x);
    /* One pixel for rounding errors of far ends. */
    return range_around(overlay, (rk_vec2){rk_min(x0, x1), (float)y},
                        (rk_vec2){rk_max(x0, x1), (float)y}, reach + 1);
}

void rk_overlay_line(rk_overlay *overlay, rk_vec3 from, rk_vec3 to, rk_vec3 colour, float width)
{
    rk_vec2 a, b;
    float a_depth, b_depth;
    if (!rk_overlay_clip(&overlay->view, &from, &to) ||
        !rk_view_project(&overlay->view, from, &a, &a_depth) ||
        !rk_view_project(&overlay->view, to, &b, &b_depth))
        return;
    float dx = b.x - a.x, dy = b.y - a.y;
    float length_squared = dx * dx + dy * dy;
    /* The coverage across the line is a trapezium of area `width`, also for lines thinner than a
     * pixel. */
    float reach = 0.5f * width + 0.5f, densest = rk_min(width, 1);
    rk_vec2 lo = {rk_min(a.x, b.x), rk_min(a.y, b.y)}, hi = {rk_max(a.x, b.x), rk_max(a.y, b.y)};
    pixel_range range = range_around(overlay, lo, hi, reach);
    for (uint32_t y = range.y0; y < range.y1; y++) {
        pixel_range row = range_in_row(overlay, range, y, a, b, reach);
        for (uint32_t x = row.x0; x < row.x1; x++) {
            float px = (float)x + 0.5f - a.x, py = (float)y + 0.5f - a.y;
            float s = length_squared > 0 ? (px * dx + py * dy) / length_squared : 0;
            s = rk_min(rk_max(s, 0), 1);
            float coverage = reach - hypotf(px - s * dx, py - s * dy);
            if (!(coverage > 0))
                continue;
            /* Along a projected line, 1 / depth is linear. */
            float depth = 1 / ((1 - s) / a_depth + s / b_depth);
            if (!is_hidden(overlay, x, y, depth, width * pixel_size_at(overlay, depth)))
                blend(overlay, x, y, colour, rk_min(coverage, densest));
        }
    }
}

/* Blue and orange can be told apart by all; the dashes, in print as well. */
void rk_overlay_shadow_ray(rk_overlay *overlay, rk_vec3 from, rk_vec3 to, bool occluded)
{
    enum { dashes = 24 };
    const rk_vec3 blue = rk_vec(0.09f, 0.46f, 0.81f), orange = rk_vec(0.79f, 0.35f, 0);
    if (!occluded)
        rk_overlay_line(overlay, from, to, blue, 1.5f);
    for (int k = 0; occluded && k < dashes; k++)
        rk_overlay_line(overlay, rk_mix(from, to, (float)k / dashes),
                        rk_mix(from, to, ((float)k + 0.6f) / dashes), orange, 1.5f);
}

void rk_overlay_point(rk_overlay *overlay, rk_vec3 point, rk_vec3 colour, float radius)
{
    rk_overlay_line(overlay, point, point, colour, 2 * radius);
}

/* Corner i of a box: bits 0, 1 and 2 choose the high side on x, y and z. */
static rk_vec3 box_corner(const rk_box *box, int i)
{
    return rk_vec(box->corner[i & 1].x, box->corner[i >> 1 & 1].y, box->corner[i >> 2 & 1].z);
}

void rk_overlay_wireframe(rk_overlay *overlay, const rk_box *box, rk_vec3 colour, float width)
{
    enum { usual_height = 800 };
    float scaled = width * (float)overlay->image->height / usual_height;
    float pixels = rk_max(scaled, rk_min(width, 1)); /* thinner edges would fade */
    for (int i = 0; i < 8; i++)
        for (int axis = 1; axis < 8; axis <<= 1)
            if (!(i & axis))
                rk_overlay_line(overlay, box_corner(box, i), box_corner(box, i | axis), colour,
                                pixels);
}

/* --- By the pixels' rays --------------------------------------------------------------------- */

/* The pixels around projected points; the whole picture if one is behind the viewer. */
static pixel_range range_of(const rk_overlay *overlay, const rk_vec3 *points, int count)
{
    rk_vec2 lo = {INFINITY, INFINITY}, hi = {-INFINITY, -INFINITY};
    for (int i = 0; i < count; i++) {
        rk_vec2 pixel;
        float depth;
        if (!rk_view_project(&overlay->view, points[i], &pixel, &depth))
            return (pixel_range){0, 0, (uint32_t)overlay->image->width,
                                 (uint32_t)overlay->image->height};
        lo = (rk_vec2){rk_min(pixel.x, lo.x), rk_min(pixel.y, lo.y)};
        hi = (rk_vec2){rk_max(pixel.x, hi.x), rk_max(pixel.y, hi.y)};
    }
    return range_around(overlay, lo, hi, 1);
}

/* An empty box, or one with NaN for a corner, is not drawn. */
void rk_overlay_box(rk_overlay *overlay, const rk_box *box, rk_vec3 colour, float alpha)
{
    rk_vec3 extent = rk_box_extent(*box);
    if (!(extent.x >= 0 && extent.y >= 0 && extent.z >= 0))
        return;
    rk_vec3 corners[8];
    for (int i = 0; i < 8; i++)
        corners[i] = box_corner(box, i);
    pixel_range range = range_of(overlay, corners, 8);
    for (uint32_t y = range.y0; y < range.y1; y++)
        for (uint32_t x = range.x0; x < range.x1; x++) {
            rk_ray ray = pixel_ray(overlay, x, y);
            rk_slabs slabs = rk_slabs_of(&ray);
            float depth = overlay->depth[pixel_index(overlay, x, y)];
            float enter = rk_box_enter(box, &slabs, depth);
            if (enter == INFINITY)
                continue;
            if (rk_box_leave(box, &slabs, INFINITY) <= depth)
                blend(overlay, x, y, colour, alpha);
            if (enter > 0)
                blend(overlay, x, y, colour, alpha);
        }
}

void rk_overlay_triangle(rk_overlay *overlay, rk_vec3 a, rk_vec3 b, rk_vec3 c, rk_vec3 colour,
                         float alpha)
{
    const rk_vec3 corners[3] = {a, b, c};
    pixel_range range = range_of(overlay, corners, 3);
    const rk_triangle triangle = {a, b, c, 0};
    for (uint32_t y = range.y0; y < range.y1; y++)
        for (uint32_t x = range.x0; x < range.x1; x++) {
            rk_ray ray = pixel_ray(overlay, x, y);
            ray.t_max = overlay->depth[pixel_index(overlay, x, y)];
            if (rk_triangle_occludes(&triangle, &ray))
                blend(overlay, x, y, colour, alpha);
        }
}

rk_vec3 rk_overlay_colour(uint32_t n)
{
    /* The hues of Okabe and Ito's palette, which the colour-blind can tell apart, linear. */
    static const rk_vec3 palette[] = {
        {0.79f, 0.35f, 0.00f}, {0.09f, 0.46f, 0.81f}, {0.00f, 0.34f, 0.17f}, {0.87f, 0.77f, 0.05f},
        {0.00f, 0.17f, 0.45f}, {0.67f, 0.11f, 0.00f}, {0.60f, 0.19f, 0.39f},
    };
    return palette[n % (sizeof palette / sizeof *palette)];
}
