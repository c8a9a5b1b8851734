/* A pass over a tile: one sample of each of its pixels, and which random numbers belong to it. */
#ifndef RK_RENDER_SAMPLE_PASS_H
#define RK_RENDER_SAMPLE_PASS_H

#include "accel/batch.h"
#include "base/counters.h"
#include "base/sampler.h"

typedef struct rk_tile {
    uint32_t x, y, width, height; /* pixels of the picture */
} rk_tile;

/* A pixel is named by its place in the tile, row by row. */
typedef struct rk_sample_pass {
    rk_tile tile;
    bool out_of_focus;        /* for the pixels that are, by the lens; or for all others */
    uint32_t sample, samples; /* of each of them, and how many there will be */
    /* A sample that needs a time is taken in so many passes, each at a time of its own. */
    uint32_t time_pass, time_passes;
    /* With plan.motion_blur: */
    bool needs_time[RK_BATCH_MAX];        /* does a ray of the pixel's sample? */
    bool camera_needs_time[RK_BATCH_MAX]; /* does the camera's? */
    bool has_time[RK_BATCH_MAX];          /* was it drawn in this pass? */
    float time[RK_BATCH_MAX];             /* then it is this */
    rk_counters *counters;                /* the thread's */
} rk_sample_pass;

/* Where a sample stands among those that are spread together. */
typedef struct rk_sample_index {
    uint32_t sample, samples;
    uint32_t dimension; /* to be added */
} rk_sample_index;

/* For numbers that are drawn behind the camera: on lights, and by rough mirrors. Further time
 * passes are a set of their own, so the first is the same as without motion. But where such a
 * number decided that there are further passes, all keep it: what it hit in motion counts for no
 * more than its own fraction. */
static inline rk_sample_index rk_sample_index_of(const rk_sample_pass *pass, uint32_t pixel)
{
    if (pass->time_pass == 0 || !pass->camera_needs_time[pixel])
        return (rk_sample_index){pass->sample, pass->samples, 0};
    return (rk_sample_index){(pass->time_pass - 1) * pass->samples + pass->sample,
                             (pass->time_passes - 1) * pass->samples, RK_DIMENSION_FURTHER};
}

/* The pixel's place in a picture of this width, row by row: where random numbers start from. */
static inline uint32_t rk_picture_pixel(const rk_sample_pass *pass, uint32_t picture_width,
                                        uint32_t pixel)
{
    const rk_tile *tile = &pass->tile;
    return (tile->y + pixel / tile->width) * picture_width + tile->x + pixel % tile->width;
}

#endif
