/* A lens gathers the light that a point sends to any part of its disk, and focuses it in one point
 * of the picture if the point is in focus. Backwards: the rays of one point of the picture start
 * anywhere on the disk, and converge on the focal surface (Cook, Porter, Carpenter, "Distributed
 * ray tracing", SIGGRAPH 1984; the lens is thin: Potmesil and Chakravarty, "A lens and aperture
 * camera model for synthetic image generation", SIGGRAPH 1981). */
#include "features/depth_of_field.h"

#include "features/glossy_reflection.h"

#include <math.h>
#include <string.h>

/* The pixels that a square reaches on one axis: `from` to before `end`. */
typedef struct span {
    uint32_t from, end;
} span;

/* Contents, in the order of the chapter. */
static float diameter_of(const rk_lens *lens);
static float focus_along(const rk_lens *lens, rk_vec3 through);
static span span_around(uint32_t at, float diameter, uint32_t size);

static float diameter_of(const rk_lens *lens)
{
    return 0.001f * lens->aperture;
}

/* --- Rays ------------------------------------------------------------------------------------- */

rk_ray rk_lens_ray(const rk_lens *lens, const rk_view *view, float x, float y, rk_vec2 xi)
{
    /* solution */
    float radius = 0.5f * diameter_of(lens);
    rk_vec2 disk = rk_disk_at(RK_DISK_CONCENTRIC, xi);
    rk_vec3 offset = rk_madd(rk_scale(view->right, radius * disk.x), view->up, radius * disk.y);
    /* From the lens point to the focus, s through - offset, divided by s: an offset of 0 then gives
     * the pinhole's direction to the bit. */
    rk_vec3 through = rk_view_through(view, x, y);
    rk_vec3 towards = rk_madd(through, offset, -1 / focus_along(lens, through));
    return (rk_ray){rk_add(view->position, offset), rk_normalize(towards), INFINITY};
    /* starter
    // First step: start at a point of the lens, and go through the focus. For now all rays go
    // through a pinhole.
    return (rk_ray){view->position, rk_view_through(view, x, y), INFINITY};
    end */
}

/* The multiple of `through`, whose depth is 1, that lies on the focal surface. */
static float focus_along(const rk_lens *lens, rk_vec3 through)
{
    /* solution */
    return lens->focal == RK_FOCAL_PLANE ? lens->focal_distance
                                         : lens->focal_distance / rk_length(through);
    /* starter
    // Second step: the plane at this depth, or the sphere of this radius.
    return 1;
    end */
}

/* --- Circles of confusion --------------------------------------------------------------------- */

float rk_lens_coc_diameter(const rk_lens *lens, const rk_view *view, const rk_ray *ray, float t)
{
    /* solution */
    float cosine = rk_dot(ray->direction, view->forward);
    bool plane = lens->focal == RK_FOCAL_PLANE;
    float d = plane ? t * cosine : t, f = lens->focal_distance;
    float angle =
        diameter_of(lens) * fabsf(1 / f - 1 / d); /* |d - f| / (d f), for infinite d or f, too */
    return angle / (plane ? view->pixel : view->pixel * cosine);
    /* starter
    // Third step: the circle's diameter on the focal surface, then in pixels.
    return -1;
    end */
}

/* The circle's centre may be anywhere in its pixel, and counts for every pixel that it may touch:
 * with radius r it reaches pixels k columns away if k - 1 < r. */
static span span_around(uint32_t at, float diameter, uint32_t size)
{
    /* solution */
    float reach = ceilf(0.5f * diameter);
    uint32_t pixels = reach < (float)size ? (uint32_t)reach : size;
    return (span){at > pixels ? at - pixels : 0, size - at > pixels ? at + pixels + 1 : size};
    /* starter
    // Fourth step: the range of pixels that a circle around `at` reaches in the picture.
    return (span){0, size};
    end */
}

/* A square is four numbers: with 1 at its first corner, -1 just after its first row and just below
 * its first column, and 1 after and below its last corner, the sum of all numbers above and to the
 * left of a pixel is 1 inside and 0 outside. So every circle costs the same, whatever its size
 * (Crow, "Summed-area tables for texture mapping", SIGGRAPH 1984, in reverse). */
void rk_lens_coc(const float *diameters, uint32_t width, uint32_t height, int32_t *coc_count)
{
    size_t stride = (size_t)width + 1;
    memset(coc_count, 0, stride * (height + 1) * sizeof *coc_count);
    /* solution */
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            float diameter = diameters[(size_t)y * width + x];
            if (diameter < RK_LENS_COC_MIN)
                continue;
            span across = span_around(x, diameter, width), down = span_around(y, diameter, height);
            coc_count[down.from * stride + across.from]++;
            coc_count[down.from * stride + across.end]--;
            coc_count[down.end * stride + across.from]--;
            coc_count[down.end * stride + across.end]++;
        }
    for (size_t y = 0; y < height; y++)
        for (size_t x = 1; x < width; x++)
            coc_count[y * stride + x] += coc_count[y * stride + x - 1];
    for (size_t y = 1; y < height; y++)
        for (size_t x = 0; x < width; x++)
            coc_count[y * stride + x] += coc_count[(y - 1) * stride + x];
    /* starter
    // Fourth step: add 1 to each pixel that a circle reaches, one pixel after the other.
    // Fifth step, at the same cost for every circle: four numbers at its square's corners, then
    // sums along rows, then along columns.
    end */
}
