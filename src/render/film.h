/* The radiance of a tile's pixels, summed over the samples so far; not installed. */
#ifndef RK_RENDER_FILM_H
#define RK_RENDER_FILM_H

#include "accel/batch.h"

typedef struct rk_film {
    rk_vec3 sum[RK_BATCH_MAX]; /* row by row */
} rk_film;

static inline void rk_film_add(rk_film *film, uint32_t pixel, rk_vec3 radiance)
{
    film->sum[pixel] = rk_add(film->sum[pixel], radiance);
}

#endif
