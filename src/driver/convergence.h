/* Error against samples and time: pictures of few samples, by several seeds, compared with the
 * truth.
 */
#ifndef RK_DRIVER_CONVERGENCE_H
#define RK_DRIVER_CONVERGENCE_H

#include "driver/driver.h"

/* A picture's error over all channels of all pixels, in linear light. */
typedef struct rk_picture_error {
    double rmse, max_error, bias; /* bias: the mean of got - want */
} rk_picture_error;

/* Both pictures have the same size. Channels for which `want` is NaN are not compared. */
rk_picture_error rk_picture_compare(const rk_image *got, const rk_image *want);

/* Renders by the driver's present options, but with another seed, so that its samples are
 * independent of theirs. The caller frees the image. */
bool rk_convergence_reference(rk_driver *driver, rk_image *reference, rk_error *error);

enum { RK_CONVERGENCE_SEEDS_MAX = 64 };

/* Errors of pictures of several seeds. */
typedef struct rk_seed_errors {
    double rmse;                /* over all pictures */
    double rmse_low, rmse_high; /* the least and the largest of one picture */
    double max_error, bias;     /* means of the pictures' own */
    double seconds;             /* the median */
    double rays;                /* per pixel: from the camera, to lights, reflected */
} rk_seed_errors;

/* Renders by the driver's present options with `seeds` seeds, from its own on, and compares with
 * `truth`. The driver's image is the last picture. 1 <= seeds <= RK_CONVERGENCE_SEEDS_MAX. */
bool rk_convergence_errors(rk_driver *driver, const rk_image *truth, uint32_t seeds,
                           rk_seed_errors *errors, rk_error *error);

/* A table of errors. */
typedef struct rk_convergence {
    const char *table;     /* OUT/tables/TABLE.csv */
    const rk_image *truth; /* as for rk_picture_compare */
    const char *reference; /* describes it: "4096 samples" */
    uint32_t seeds;        /* pictures per row */
} rk_convergence;

/* The row of the option --seeds, for a driver's own table: `seeds` is a uint32_t of struct `type`.
 */
#define RK_CONVERGENCE_SEEDS(type)                                                                 \
    {                                                                                              \
        "seeds", RK_FIELD(type, seeds), "N",                                                       \
            "pictures behind each error in the tables, each of another seed", 1,                   \
            RK_CONVERGENCE_SEEDS_MAX, 8                                                            \
    }

/* Puts a row with the errors of the driver's present options into the table. Returns the RMS error
 * in `rmse`, which may be NULL. */
bool rk_convergence_row_of(rk_driver *driver, const rk_convergence *study, const char *method,
                           uint32_t samples, double *rmse, rk_error *error);

#endif
