/* Declarations for the files of this driver. */
#ifndef RK_13_SAMPLING_DRIVER_H
#define RK_13_SAMPLING_DRIVER_H

#include "driver/driver_main.h"

/* What is sampled together with the position in the pixel; the last two from its centre. */
typedef enum effect {
    EFFECT_PIXEL,
    EFFECT_LENS,
    EFFECT_LIGHT,
    EFFECT_MIRROR,
    EFFECT_PENUMBRA, /* the light alone */
    EFFECT_AMBIENT,  /* the light, and ambient light */
} effect;
extern const rk_names effect_names;

/* The points of --debug points. */
typedef enum point_kind {
    POINTS_SEQUENCE,   /* of the table's numbers */
    POINTS_DIRECTIONS, /* of rk_sobol_directions */
    POINTS_OWEN,       /* of the table, scrambled by rk_owen_scramble */
    POINTS_SAMPLES,    /* a pixel's samples of the chosen kind */
} point_kind;
extern const rk_names point_kind_names;

typedef struct choices {
    rk_sampler_kind kind; /* of all samples */
    effect effect;
    point_kind of;
    uint32_t points, x, y; /* number, and dimensions along the axes */
    bool permuted;         /* digits, in --debug order */
    float blur, gain;      /* of --debug error: standard deviation in pixels, and a factor */
    bool convergence, blurred, spectrum, pairs;
    uint32_t samples;         /* of the picture */
    uint32_t most, reference; /* samples */
    uint32_t seeds;           /* of --convergence */
} choices;

/* Sets what the effect needs, with this number of samples per pixel of this kind. */
void set_samples(rk_driver *driver, rk_sampler_kind kind, uint32_t samples);

/* Make the pictures of --debug points, --debug order and --debug error. */
bool draw_points(rk_driver *driver, rk_error *error);
bool draw_order(rk_driver *driver, rk_error *error);
bool draw_error(rk_driver *driver, rk_error *error);

/* Writes the table of --pairs. */
bool put_pairs(rk_driver *driver, rk_error *error);

/* Writes the tables of --convergence. */
bool put_convergence(rk_driver *driver, rk_error *error);

/* A Gaussian filter of this standard deviation in pixels; beyond the border there is nothing. */
bool blur_image(rk_image *image, float sigma, rk_error *error);

/* Returns the mean over pixels and channels. */
double mean_square(const rk_image *image);

/* Write the tables of --blurred and --spectrum. */
bool put_blurred(rk_driver *driver, rk_error *error);
bool put_spectrum(rk_driver *driver, rk_error *error);

#endif
