/* Differences are taken in stored values, 0 to 255; one of at most 1 may be rounding, and does not
 * count. The largest becomes white in the picture of differences. */
#include "driver/picture_difference.h"

static float stored(float linear)
{
    return rintf(255 * rk_srgb_encode(linear));
}

static rk_vec3 stored_difference(rk_vec3 a, rk_vec3 b)
{
    return rk_abs3(
        rk_vec(stored(a.x) - stored(b.x), stored(a.y) - stored(b.y), stored(a.z) - stored(b.z)));
}

static rk_vec3 decoded(rk_vec3 stored)
{
    return rk_vec(rk_srgb_decode(stored.x), rk_srgb_decode(stored.y), rk_srgb_decode(stored.z));
}

static bool is_lit(const rk_image *shown, size_t x, size_t y)
{
    const rk_vec3 p = *rk_image_at(shown, x, y);
    return p.x > 0 || p.y > 0 || p.z > 0;
}

/* Before it in the order of rows: to the left, or in the row before. */
static bool has_neighbour(const rk_image *shown, size_t x, size_t y)
{
    const size_t left = x > 0 ? x - 1 : x, right = x + 1 < shown->width ? x + 1 : x;
    if (left < x && is_lit(shown, left, y))
        return true;
    for (size_t i = left; y > 0 && i <= right; i++)
        if (is_lit(shown, i, y - 1))
            return true;
    return false;
}

static bool are_single(const rk_image *shown)
{
    for (size_t y = 0; y < shown->height; y++)
        for (size_t x = 0; x < shown->width; x++)
            if (is_lit(shown, x, y) && has_neighbour(shown, x, y))
                return false;
    return true;
}

rk_picture_difference rk_picture_difference_of(const rk_image *drawn, const rk_image *wanted,
                                               rk_image *shown)
{
    rk_picture_difference found = {0};
    size_t count = wanted->width * wanted->height;
    float largest = 1;
    for (size_t i = 0; i < count; i++) {
        rk_vec3 off = stored_difference(drawn->pixels[i], wanted->pixels[i]);
        float most = rk_max(off.x, rk_max(off.y, off.z));
        shown->pixels[i] = most > 1 ? off : rk_vec(0, 0, 0);
        found.pixels += most > 1;
        if (most > largest) {
            largest = most;
            found.x = i % wanted->width;
            found.y = i / wanted->width;
        }
    }
    found.are_single = are_single(shown);
    for (size_t i = 0; i < count; i++)
        shown->pixels[i] = decoded(rk_scale(shown->pixels[i], 1 / largest));
    return found;
}
