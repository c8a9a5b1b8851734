/* A texture: a picture that is looked up at (u, v), u to the right and v upwards, [0, 1] across.
 * Texel i of a row of n covers u from i / n to (i + 1) / n; its colour stands at its centre,
 * u = (i + .5) / n. */
#ifndef RK_BASE_TEXTURE_H
#define RK_BASE_TEXTURE_H

#include "base/image.h"

/* Outside of [0, 1] the border's colours go on, or the picture starts again. */
typedef enum rk_texture_wrap { RK_TEXTURE_CLAMP, RK_TEXTURE_REPEAT } rk_texture_wrap;

/* The colour of the texel that (u, v) is in, or a mix of the four whose centres are around it. */
typedef enum rk_texture_filter { RK_TEXTURE_NEAREST, RK_TEXTURE_BILINEAR } rk_texture_filter;

typedef struct rk_texture {
    rk_image image; /* linear RGB; its first row is the top, v = 1 */
    rk_texture_wrap wrap;
    rk_texture_filter filter;
} rk_texture;

/* Returns the colour at (u, v), which may be anything: NaN counts as 0, so does infinity where the
 * picture repeats. The image has pixels. */
rk_vec3 rk_texture_at(const rk_texture *texture, rk_vec2 uv);

/* Frees the image; a zeroed texture has none. */
void rk_texture_free(rk_texture *texture);

#endif
