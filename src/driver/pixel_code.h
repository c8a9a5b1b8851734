/* Where the C of each step of an explained pixel is, for readers of --pixel --pixel-code and for
 * pages that show it. */
#ifndef RK_DRIVER_PIXEL_CODE_H
#define RK_DRIVER_PIXEL_CODE_H

#include <stdio.h>

typedef enum rk_pixel_code {
    RK_CODE_CAMERA_RAY,
    RK_CODE_BINARY_TREE,
    RK_CODE_WIDE_TREE,
    RK_CODE_TRANSPARENCY,
    RK_CODE_SURFACE,
    RK_CODE_SPHERE,
    RK_CODE_COSINE,
    RK_CODE_SPAWN,
    RK_CODE_BINARY_OCCLUSION,
    RK_CODE_WIDE_OCCLUSION,
    RK_CODE_TRANSMIT,
    RK_CODE_LIGHT_SAMPLE,
    RK_CODE_OFF,
    RK_CODE_GRADIENT,
    RK_CODE_FACES_AWAY,
    RK_CODE_LAMBERT,
    RK_CODE_HIGHLIGHT,
    RK_CODE_AMBIENT,
    RK_CODE_REFLECT,
    RK_CODE_DISK,
    RK_CODE_ENVIRONMENT,
    RK_CODE_STORED,
    RK_CODE_ROOT,
    RK_CODE_FIRST_CHILD,
    RK_CODE_SECOND_CHILD,
    RK_CODE_LEAF,
    RK_CODE_COUNT
} rk_pixel_code;

/* Prints a line "# FILE, FUNCTION: CODE", where CODE is in one line of that function. */
void rk_print_pixel_code(FILE *out, rk_pixel_code code);

#endif
