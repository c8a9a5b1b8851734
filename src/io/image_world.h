/* Pictures of all directions by longitude and latitude, made smaller. Common to the library (C) and
 * raykit-image (C++); not installed. */
#ifndef RK_IO_IMAGE_WORLD_H
#define RK_IO_IMAGE_WORLD_H

#include <math.h>
#include <stddef.h>

/* The largest whole number by which a world can be divided so that it keeps this many columns; 1 if
 * none are given. */
static inline size_t rk_image_world_factor(size_t width, size_t height, size_t least_width)
{
    for (size_t factor = least_width > 0 ? width / least_width : 1; factor > 1; factor--)
        if (width % factor == 0 && height % factor == 0)
            return factor;
    return 1;
}

/* How much a pixel counts, in each of `factor` rows from number `first` on of the picture's
 * `height`: by its solid angle, so that the mean radiance over all directions stays. */
static inline void rk_image_world_shares(double *shares, size_t factor, size_t first, size_t height)
{
    const double angle = acos(-1.0) / (double)height;
    const double whole = cos(angle * (double)first) - cos(angle * (double)(first + factor));
    for (size_t row = 0; row < factor; row++) {
        const double top = angle * (double)(first + row);
        shares[row] = (cos(top) - cos(top + angle)) / whole / (double)factor;
    }
}

/* Writes one row of means of squares of factor x factor pixels of RGB, in place or elsewhere. */
static inline void rk_image_world_average(float *to, const float *rows, size_t width, size_t factor,
                                          const double *shares)
{
    for (size_t x = 0; x < width / factor; x++) {
        double sum[3] = {0, 0, 0};
        for (size_t row = 0; row < factor; row++) {
            const double share = shares[row];
            const float *pixel = rows + 3 * (row * width + x * factor);
            for (size_t k = 0; k < 3 * factor; k++)
                sum[k % 3] += share * (double)pixel[k];
        }
        for (size_t c = 0; c < 3; c++)
            to[3 * x + c] = (float)sum[c];
    }
}

#endif
