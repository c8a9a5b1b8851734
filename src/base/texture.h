/* A texture: a picture that is looked up at (u, v), u to the right and v upwards, [0, 1] across. */
#ifndef RK_BASE_TEXTURE_H
#define RK_BASE_TEXTURE_H

#include "base/image.h"

typedef enum rk_texture_wrap { RK_TEXTURE_CLAMP, RK_TEXTURE_REPEAT } rk_texture_wrap;
typedef enum rk_texture_filter { RK_TEXTURE_NEAREST, RK_TEXTURE_BILINEAR } rk_texture_filter;

typedef struct rk_texture {
    rk_image image; /* linear RGB; its first row is the top, v = 1 */
    rk_texture_wrap wrap;
    rk_texture_filter filter;
} rk_texture;

#endif
