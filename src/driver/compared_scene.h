/* The scenes that make compare has rendered by another renderer, too, and the regions of their
 * pictures in which the two are compared. */
#ifndef RK_DRIVER_COMPARED_SCENE_H
#define RK_DRIVER_COMPARED_SCENE_H

#include "base/names.h"
#include "render/plan.h"

typedef enum rk_compared_kind {
    RK_COMPARED_CORNELL, /* the Cornell box, with a parallelogram light */
    RK_COMPARED_LENS,    /* the same through a lens */
    RK_COMPARED_MOTION,  /* the same, with the tall block in motion */
    RK_COMPARED_COUNT
} rk_compared_kind;

extern const rk_names rk_compared_names;

typedef struct rk_compared_scene {
    rk_scene scene;
    rk_render_options options;
} rk_compared_scene;

/* Makes the scene with the options for its picture: side x side pixels, `samples` rays per pixel,
 * lens points and times. All shadow rays are traced. */
bool rk_compared_scene_init(rk_compared_scene *compared, rk_compared_kind kind, uint32_t side,
                            uint32_t samples, rk_error *error);
void rk_compared_scene_free(rk_compared_scene *compared);

/* A region is a surface, as a pinhole sees it, or the way of a moving object. */
typedef enum rk_compared_region {
    RK_REGION_NONE, /* nothing is there */
    RK_REGION_FLOOR,
    RK_REGION_CEILING,
    RK_REGION_BACK_WALL,
    RK_REGION_LEFT_WALL,
    RK_REGION_RIGHT_WALL,
    RK_REGION_LOW_BLOCK,
    RK_REGION_TALL_BLOCK,
    RK_REGION_MOVING,
    RK_REGION_COUNT
} rk_compared_region;

extern const rk_names rk_compared_region_names;

/* Fills in the region of each pixel, width * height of the options, by the ray through its centre.
 * A pixel that sees a moving object at any of 64 times is in RK_REGION_MOVING. */
bool rk_compared_regions(const rk_compared_scene *compared, uint8_t *regions, rk_error *error);

#endif
