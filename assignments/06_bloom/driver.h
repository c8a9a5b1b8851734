/* Declarations that the files of this driver share. */
#ifndef RK_06_BLOOM_DRIVER_H
#define RK_06_BLOOM_DRIVER_H

#include "driver/driver_main.h"
#include "post/bloom_stage.h"

typedef struct choices {
    float light; /* factor for the colours of the scene's lights */
    bool errors, histogram, halo;
    rk_bloom_options bloom; /* as given; see prepare */
} choices;

static inline size_t pixels_of(const rk_image *image)
{
    return image->width * image->height;
}

/* Taps per pixel of the last bloom: weights times pixels, along rows and columns. */
static inline double taps_of(const rk_driver *driver)
{
    return (double)driver->counters.bloom_taps / (double)pixels_of(&driver->image);
}

/* Adds bloom to a copy of the picture, `runs` times; counts the taps of the last run. */
bool bloom_copy(rk_driver *driver, const rk_bloom_options *options, rk_image *copy, rk_timing *ms,
                rk_error *error);

/* Renders without bloom and draws driver->debug. */
bool draw_view(rk_driver *driver, rk_error *error);

/* Renders without bloom and puts the table of --errors. */
bool put_study(rk_driver *driver, rk_error *error);

/* Render without bloom and put the tables of --histogram and of --halo. */
bool put_histogram(rk_driver *driver, rk_error *error);
bool put_halo(rk_driver *driver, rk_error *error);

#endif
