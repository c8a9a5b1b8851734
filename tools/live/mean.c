/* The mean of pictures that differ in their seed alone: it has less noise with each. The radiance
 * is averaged, before effects of the whole picture such as bloom (wasm-ld --wrap). The driver
 * begins each picture anew, but takes no sample twice: the random numbers of different seeds are
 * independent. */
#include "mean.h"

#include "render/feature_hooks.h"

#include <stdlib.h>
#include <string.h>

#define IMPORT(name) __attribute__((import_module("raykit"), import_name(name)))

/* How many pictures the mean has, and whether the first two differ: without noise they do not. */
IMPORT("mean") void raykit_mean(uint32_t pictures, bool differ);

static struct {
    rk_mean_part part;
    size_t pixels;
    rk_vec3 *sum;
    uint32_t pictures;
    bool differ;
} mean;

void rk_mean_set_part(rk_mean_part part)
{
    mean.part = part;
}

static bool begin(const rk_image *image, rk_error *error)
{
    free(mean.sum);
    mean.pixels = image->width * image->height;
    mean.sum = rk_allocate(mean.pixels, sizeof *mean.sum, "the mean of pictures", error);
    if (!mean.sum)
        return false;
    memcpy(mean.sum, image->pixels, mean.pixels * sizeof *mean.sum);
    mean.pictures = 1;
    mean.differ = false;
    return true;
}

static bool add(rk_image *image, rk_error *error)
{
    if (!mean.sum || mean.pixels != image->width * image->height)
        return rk_fail(error, "there is no picture of this size to add to");
    if (mean.pictures == 1)
        mean.differ = memcmp(mean.sum, image->pixels, mean.pixels * sizeof *mean.sum) != 0;
    mean.pictures++;
    for (size_t i = 0; i < mean.pixels; i++) {
        mean.sum[i] = rk_add(mean.sum[i], image->pixels[i]);
        image->pixels[i] = rk_scale(mean.sum[i], 1 / (float)mean.pictures);
    }
    return true;
}

bool __real_rk_features_post(rk_image *image, const rk_rendering *r, rk_pool *pool,
                             rk_counters *counters, rk_error *error);
bool __wrap_rk_features_post(rk_image *image, const rk_rendering *r, rk_pool *pool,
                             rk_counters *counters, rk_error *error);

/* Adaptive sampling has an end of its own: the error that was asked for. */
bool __wrap_rk_features_post(rk_image *image, const rk_rendering *r, rk_pool *pool,
                             rk_counters *counters, rk_error *error)
{
    if (mean.part != RK_MEAN_LEAVES && !r->plan.adaptive_sampling) {
        if (!(mean.part == RK_MEAN_ADDS ? add(image, error) : begin(image, error)))
            return false;
        raykit_mean(mean.pictures, mean.differ);
    }
    return __real_rk_features_post(image, r, pool, counters, error);
}
