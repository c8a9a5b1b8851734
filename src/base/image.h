/* An image of linear RGB floats, rows from top to bottom. */
#ifndef RK_BASE_IMAGE_H
#define RK_BASE_IMAGE_H

#include "base/error.h"
#include "base/vec3.h"

typedef struct rk_image {
    size_t width, height;
    rk_vec3 *pixels; /* width * height, row by row from the top */
} rk_image;

enum { RK_IMAGE_SIDE_MAX = 32768, RK_IMAGE_PIXELS_MAX = RK_IMAGE_SIDE_MAX * RK_IMAGE_SIDE_MAX };

/* Makes a black image of 1 to RK_IMAGE_SIDE_MAX pixels per side. */
bool rk_image_init(rk_image *image, size_t width, size_t height, rk_error *error);
void rk_image_free(rk_image *image);

static inline rk_vec3 *rk_image_at(const rk_image *image, size_t x, size_t y)
{
    return &image->pixels[y * image->width + x];
}

/* The sRGB transfer function of IEC 61966-2-1, from linear light to the stored value and back;
 * both clamp to [0, 1], and NaN becomes 0. */
float rk_srgb_encode(float linear);
float rk_srgb_decode(float stored);

#endif
