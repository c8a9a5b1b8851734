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

/* Consecutive samples of a tile, in an order for each of its pixels. */
enum { RK_LENS_GROUP_MAX = 32 };
typedef struct rk_lens_group {
    uint32_t first, count;
    uint32_t bits[4][RK_LENS_GROUP_MAX];            /* of each sample's numbers */
    uint8_t order[RK_LENS_GROUP_MAX][RK_BATCH_MAX]; /* the sample, counted from `first`, that each
                                                       pixel takes first, second and so on */
} rk_lens_group;

/* The samples from `first` on, in their own order. */
void rk_lens_group_start(rk_lens_group *group, const rk_lens_pixels *pixels, uint32_t first,
                         uint32_t count);

/* Orders them by their places on the lens: what all pixels take next then starts at nearby places,
 * so that neighbours' rays traverse the tree together. */
void rk_lens_group_sort(rk_lens_group *group, const rk_lens_pixels *pixels);

/* Fills the batch with the rays that the pixels take in this round, 0 to group->count - 1, and
 * `count`: to the bit those of rk_lens_ray_of_pixel. Only if r->lens_rays_agree. */
void rk_lens_rays(const rk_rendering *r, const rk_lens_pixels *pixels, const rk_lens_group *group,
                  uint32_t round, rk_ray_batch *rays);

/* Are the rays the same at many places of the picture? They are not with numbers of another kind,
 * nor with a student's functions that are still wrong: these draw their own picture. */
bool rk_lens_rays_agree(const rk_rendering *r, uint32_t samples);

#endif
