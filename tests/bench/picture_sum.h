/* Sums of pictures in double precision: their mean, and how far it varies. */
#ifndef RK_TESTS_PICTURE_SUM_H
#define RK_TESTS_PICTURE_SUM_H

#include "base/image.h"

#include <stdint.h>
#include <stdlib.h>

typedef struct picture_sum {
    size_t values; /* 3 for each pixel */
    uint32_t pictures;
    double *mean;    /* of the pictures */
    double *squares; /* the sum of squared deviations from the mean */
} picture_sum;

static inline void picture_sum_free(picture_sum *sum)
{
    free(sum->mean);
    free(sum->squares);
    *sum = (picture_sum){0};
}

static inline bool picture_sum_init(picture_sum *sum, size_t pixels, rk_error *error)
{
    *sum = (picture_sum){.values = 3 * pixels};
    sum->mean = rk_allocate(sum->values, sizeof *sum->mean, "a mean picture", error);
    sum->squares = rk_allocate(sum->values, sizeof *sum->squares, "a mean picture", error);
    if (sum->mean && sum->squares)
        return true;
    picture_sum_free(sum);
    return false;
}

/* Welford's update, which does not cancel: B. P. Welford, Technometrics 4, 1962. */
static inline void picture_sum_add(picture_sum *sum, const rk_image *image)
{
    sum->pictures++;
    for (size_t i = 0; i < sum->values; i++) {
        double value = (double)rk_axis(image->pixels[i / 3], (int)(i % 3));
        double deviation = value - sum->mean[i];
        sum->mean[i] += deviation / sum->pictures;
        sum->squares[i] += deviation * (value - sum->mean[i]);
    }
}

/* The variance of the mean of one value; 0 for a single picture, which is then taken as exact. */
static inline double picture_sum_variance(const picture_sum *sum, size_t i)
{
    return sum->pictures < 2 ? 0 : sum->squares[i] / (sum->pictures - 1) / sum->pictures;
}

#endif
