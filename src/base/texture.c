/* Bilinear interpolation between the four nearest texel centres, with rows counted from the bottom.
 * Coordinates outside of [0, 1] are repeated or clamped first. */
#include "base/texture.h"

#include <assert.h>

/* Maps a coordinate to [0, 1], 1 included: a tiny negative number plus 1 rounds to 1. */
static float wrap_coordinate(float u, rk_texture_wrap wrap)
{
    if (wrap == RK_TEXTURE_REPEAT)
        u -= floorf(u);
    return u > 0 ? (u < 1 ? u : 1) : 0; /* NaN, also from infinity - infinity, becomes 0 */
}

/* Texels -1 and `count` are the neighbours beyond the edges. */
static size_t wrap_texel(long i, size_t count, rk_texture_wrap wrap)
{
    const long last = (long)count - 1;
    if (i < 0)
        return wrap == RK_TEXTURE_REPEAT ? (size_t)last : 0;
    if (i > last)
        return wrap == RK_TEXTURE_REPEAT ? 0 : (size_t)last;
    return (size_t)i;
}

/* x to the right and y upwards, in texels from the picture's bottom left corner. */
static rk_vec3 texel(const rk_texture *texture, long x, long y)
{
    const rk_image *image = &texture->image;
    size_t column = wrap_texel(x, image->width, texture->wrap);
    size_t row_from_bottom = wrap_texel(y, image->height, texture->wrap);
    return *rk_image_at(image, column, image->height - 1 - row_from_bottom);
}

static rk_vec3 bilinear(const rk_texture *texture, float x, float y)
{
    /* From here on, texel (i, j) has its centre at (i, j). */
    x -= 0.5f, y -= 0.5f;
    float left = floorf(x), bottom = floorf(y);
    long i = (long)left, j = (long)bottom;
    rk_vec3 below = rk_mix(texel(texture, i, j), texel(texture, i + 1, j), x - left);
    rk_vec3 above = rk_mix(texel(texture, i, j + 1), texel(texture, i + 1, j + 1), x - left);
    return rk_mix(below, above, y - bottom);
}

rk_vec3 rk_texture_at(const rk_texture *texture, rk_vec2 uv)
{
    assert(texture->image.pixels && "only a texture whose image has pixels can be looked up");
    float x = wrap_coordinate(uv.x, texture->wrap) * (float)texture->image.width;
    float y = wrap_coordinate(uv.y, texture->wrap) * (float)texture->image.height;
    if (texture->filter == RK_TEXTURE_NEAREST)
        return texel(texture, (long)floorf(x), (long)floorf(y));
    return bilinear(texture, x, y);
}

void rk_texture_free(rk_texture *texture)
{
    rk_image_free(&texture->image);
    *texture = (rk_texture){0};
}
