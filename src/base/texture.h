/* A texture: a picture, looked up at (u, v) in [0, 1]^2, u to the right and v upwards. Texel i of a
 * row of n covers u from i / n to (i + 1) / n; its centre, where its colour is exact, is at u = (i
 * + .5) / n. */
#ifndef RK_BASE_TEXTURE_H
#define RK_BASE_TEXTURE_H

#include "base/image.h"

/* Outside [0, 1] the edge's colours continue, or the picture repeats. */
typedef enum rk_texture_wrap { RK_TEXTURE_CLAMP, RK_TEXTURE_REPEAT } rk_texture_wrap;

/* The colour of the texel that contains (u, v), or a mix of the four with the nearest centres. */
typedef enum rk_texture_filter { RK_TEXTURE_NEAREST, RK_TEXTURE_BILINEAR } rk_texture_filter;

typedef struct rk_texture {
    rk_image image; /* linear RGB; its first row is the top, v = 1 */
    rk_texture_wrap wrap;
    rk_texture_filter filter;
} rk_texture;

/* Returns the colour at (u, v), which may have any values: NaN counts as 0, and so does infinity
 * where the picture repeats. The image must have pixels. */
rk_vec3 rk_texture_at(const rk_texture *texture, rk_vec2 uv);

/* Frees the image; a zeroed texture has none. */
void rk_texture_free(rk_texture *texture);

#endif
