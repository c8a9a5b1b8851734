/* The lens rays of a tile, four at a time: a sample's rays differ from pixel to pixel only by the
 * keys that scramble their numbers, and these are the same for all samples; not installed. */
#ifndef RK_RENDER_LENS_RAYS_H
#define RK_RENDER_LENS_RAYS_H

#include "accel/batch.h"
#include "render/rendering.h"

/* Of a tile, those out of focus, in the order of their rays. */
typedef struct rk_lens_pixels {
    uint32_t count;
    uint16_t pixel[RK_BATCH_MAX];           /* within the tile, row by row */
    float x[RK_BATCH_MAX], y[RK_BATCH_MAX]; /* of the corner in the picture */
    uint32_t key[4][RK_BATCH_MAX];          /* for the place within the pixel, x and y, and on the
                                               lens */
} rk_lens_pixels;

/* Appends the pixel `index` of the tile, (x, y) of the picture. */
void rk_lens_pixels_add(rk_lens_pixels *pixels, const rk_render_options *options, uint32_t index,
                        uint32_t x, uint32_t y);

/* Returns the lens ray of pixel (x, y) for one of its samples, by the features' own functions. */
rk_ray rk_lens_ray_of_pixel(const rk_rendering *r, uint32_t x, uint32_t y, uint32_t sample,
                            uint32_t samples);

/* Fills the batch with the same rays to the bit, one for each of the pixels, and `count`. Only if
 * r->lens_rays_agree. */
void rk_lens_rays(const rk_rendering *r, const rk_lens_pixels *pixels, uint32_t sample,
                  rk_ray_batch *rays);

/* Are the rays the same at many places of the picture? They are not with numbers of another kind,
 * nor with a student's functions that are still wrong: these draw their own picture. */
bool rk_lens_rays_agree(const rk_rendering *r, uint32_t samples);

#endif
