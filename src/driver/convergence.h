/* Error against time: pictures of few samples compared with one of many. */
#ifndef RK_DRIVER_CONVERGENCE_H
#define RK_DRIVER_CONVERGENCE_H

#include "driver/driver.h"

/* A picture's error over all channels of all pixels, in linear light. */
typedef struct rk_picture_error {
    double rmse, max_error, bias; /* bias: the mean of got - want */
} rk_picture_error;

/* Both pictures have the same size. */
rk_picture_error rk_picture_compare(const rk_image *got, const rk_image *want);

/* Renders by the driver's present options, but with another seed, so that its samples are
 * independent of theirs. The caller frees the image. */
bool rk_convergence_reference(rk_driver *driver, rk_image *reference, rk_error *error);

/* Renders by the driver's present options, compares with `reference`, described by `truth` ("4096
 * samples"), and puts a row into OUT/tables/NAME.csv. */
bool rk_convergence_row_of(rk_driver *driver, const char *name, const char *method,
                           uint32_t samples, const rk_image *reference, const char *truth,
                           rk_error *error);

#endif
