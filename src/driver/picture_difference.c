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
    for (size_t i = 0; i < count; i++)
        shown->pixels[i] = decoded(rk_scale(shown->pixels[i], 1 / largest));
    return found;
}
