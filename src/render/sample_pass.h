/* A pass over a tile: one sample of each of its pixels, and the indices of its random numbers;
 * not installed. */
#ifndef RK_RENDER_SAMPLE_PASS_H
#define RK_RENDER_SAMPLE_PASS_H

#include "accel/batch.h"
#include "base/counters.h"
#include "base/sampler.h"

typedef struct rk_tile {
    uint32_t x, y, width, height; /* pixels of the picture */
} rk_tile;

typedef struct rk_wanted_sample {
    uint32_t pixel, sample; /* of the tile, row by row; index */
} rk_wanted_sample;

/* Arrays hold a value per pixel of the tile, row by row. If there are wanted samples, the pass
 * takes these: none of a pixel, or several. Then arrays, the film, and the pixels of rays are by
 * wanted sample. */
typedef struct rk_sample_pass {
    rk_tile tile;
    bool out_of_focus;        /* the pass takes the pixels out of focus, else those in focus */
    uint32_t sample, samples; /* index, and number per pixel */
    /* Those of a pass out of focus, if its rays are made four at a time; else NULL. */
    const struct rk_lens_pixels *lens;
    const struct rk_lens_group *lens_group; /* with `lens` */
    uint32_t lens_round;
    /* See render/time_passes.h. */
    uint32_t time_pass, time_passes;
    /* With plan.motion_blur: */
    bool needs_time[RK_BATCH_MAX];         /* may a ray of the sample hit a moving object? */
    uint16_t camera_objects[RK_BATCH_MAX]; /* those that its camera ray may hit, a bit each */
    bool has_time[RK_BATCH_MAX];           /* is `time` drawn in this pass? */
    float time[RK_BATCH_MAX];              /* of all rays of the pixel's sample */
    uint32_t bounce;                       /* reflections before the rays that are traced now */
    uint32_t wanted_count;                 /* 0 without plan.adaptive_sampling */
    rk_wanted_sample wanted[RK_BATCH_MAX];
    rk_counters *counters; /* the thread's */
} rk_sample_pass;

/* The pixel of the tile, and the index of its sample. */
static inline rk_wanted_sample rk_sample_at(const rk_sample_pass *pass, uint32_t pixel)
{
    return pass->wanted_count > 0 ? pass->wanted[pixel] : (rk_wanted_sample){pixel, pass->sample};
}

/* The place of a sample in its set, which is distributed as a whole. */
typedef struct rk_sample_index {
    uint32_t sample, samples;
    uint32_t dimension; /* offset */
} rk_sample_index;

/* For random numbers after the camera ray: on lights, and at rough mirrors. Further time passes are
 * a set of their own, so that the first pass equals a picture without motion. But if such a number
 * made a ray need a time, all passes keep it: another one might miss the moving object, and the
 * mean over passes would be biased. */
static inline rk_sample_index rk_sample_index_of(const rk_sample_pass *pass, uint32_t pixel)
{
    const uint32_t sample = rk_sample_at(pass, pixel).sample;
    if (pass->time_pass == 0 || !pass->camera_objects[pixel])
        return (rk_sample_index){sample, pass->samples, 0};
    return (rk_sample_index){(pass->time_pass - 1) * pass->samples + sample,
                             (pass->time_passes - 1) * pass->samples, RK_DIMENSION_FURTHER};
}

/* The pixel's index in a picture of this width, row by row: the key of its random numbers. */
static inline uint32_t rk_picture_pixel(const rk_sample_pass *pass, uint32_t picture_width,
                                        uint32_t pixel)
{
    const rk_tile *tile = &pass->tile;
    const uint32_t at = rk_sample_at(pass, pixel).pixel;
    return (tile->y + at / tile->width) * picture_width + tile->x + at % tile->width;
}

#endif
