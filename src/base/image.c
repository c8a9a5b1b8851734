/* Memory of images, and the transfer function of sRGB (IEC 61966-2-1). */
#include "base/image.h"

#include <stdlib.h>

bool rk_image_init(rk_image *image, size_t width, size_t height, rk_error *error)
{
    *image = (rk_image){0};
    if (width < 1 || height < 1 || width > RK_IMAGE_SIDE_MAX || height > RK_IMAGE_SIDE_MAX)
        return rk_fail(error, "an image of %zu x %zu pixels: each side must be 1 to %d", width,
                       height, RK_IMAGE_SIDE_MAX);
    rk_vec3 *pixels = rk_allocate(width * height, sizeof *pixels, "image", error);
    if (!pixels)
        return false;
    *image = (rk_image){width, height, pixels};
    return true;
}

void rk_image_free(rk_image *image)
{
    free(image->pixels);
    *image = (rk_image){0};
}

static float clamp01(float v)
{
    return v > 0 ? (v < 1 ? v : 1) : 0;
}

float rk_srgb_encode(float linear)
{
    float v = clamp01(linear);
    return v <= 0.0031308f ? 12.92f * v : 1.055f * powf(v, 1 / 2.4f) - 0.055f;
}

float rk_srgb_decode(float stored)
{
    float v = clamp01(stored);
    return v <= 0.04045f ? v / 12.92f : powf((v + 0.055f) / 1.055f, 2.4f);
}
