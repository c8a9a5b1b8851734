/* Motion blur: objects on cubic paths, intersected by rays that have a time. The scene is in memory
 * once, whatever the number of samples. */
#ifndef RK_FEATURES_MOTION_BLUR_H
#define RK_FEATURES_MOTION_BLUR_H

#include "base/box.h"
#include "scene/bvh.h"
#include "scene/motion.h"

#include <stdint.h>

/* Returns the default path: y = -4 x^3 + 0.5 x^2 + 1.5 x. */
rk_motion rk_motion_default(void);

/* Returns an object's offset from its position at rest at the time x: (x, y(x), 0), rounded
 * once. */
rk_vec3 rk_motion_offset(const rk_motion *motion, float x);

/* Returns a ray of the scene in the frame of an object at `offset`, in which the object is at rest.
 * t is the same in both. */
rk_ray rk_motion_ray(rk_vec3 offset, const rk_ray *ray);

/* The interval of x in which the picture is taken; open <= close. */
typedef struct rk_shutter {
    float open, close;
} rk_shutter;

/* Returns the k-th of `samples` equidistant times: the middle of the k-th of as many equal parts of
 * the shutter, open + (k - 1/2) / samples (close - open). So neither end is one of the times: each
 * represents a part of the shutter. k counts from 1; below 1 or above `samples` the time lies
 * before or after the shutter, and if k is not an integer, between two of the times. */
float rk_shutter_equidistant(const rk_shutter *shutter, float k, uint32_t samples);

typedef enum rk_time_sampling {
    RK_TIME_EQUIDISTANT,     /* the same times for all pixels: copies of the object */
    RK_TIME_STRATIFIED,      /* sample i in part i of as many equal parts as there are samples */
    RK_TIME_LOW_DISCREPANCY, /* unordered; for each k the first 2^k lie one in each of 2^k parts */
    /* Drawn by the stage (features/sampling.h): */
    RK_TIME_SOBOL,  /* the same, but joint with other dimensions */
    RK_TIME_ZSOBOL, /* and with other pixels */
    RK_TIME_UNIFORM /* independent */
} rk_time_sampling;

/* Returns the time of `sample`, 0 to samples - 1, of a pixel; within the shutter. Equidistant times
 * are the same for all seeds and pixels. The others use rk_sample_1d of the seed, pixel, sample and
 * RK_DIMENSION_TIME: for a low-discrepancy time it is the fraction of the shutter, for a stratified
 * one, of any kind, the fraction of its part. */
float rk_shutter_time(const rk_shutter *shutter, rk_time_sampling sampling, uint32_t seed,
                      uint32_t pixel, uint32_t sample, uint32_t samples);

/* Returns the swept box of `rest`, a box at rest: it bounds that box at all times while the shutter
 * is open, by the exact extremes of the path. On each axis, z too, it is larger at both ends by
 * 2^-19 of the sum of the largest |corner| and the largest |offset|, which rk_motion_may_intersect
 * needs. */
rk_box rk_motion_sweep(const rk_motion *motion, const rk_shutter *shutter, const rk_box *rest);

/* May the ray enter the moving box of a swept box, at 0 <= t <= t_max? False is certain: at no time
 * while the shutter is open does rk_motion_ray's ray enter the box at rest by rk_box_enter,
 * whatever the rounding errors. */
bool rk_motion_may_intersect(const rk_box *swept, const rk_slabs *ray, float t_max);

/* The same test, but tighter: may the ray enter a leaf of the object's tree? `swept` is the root's
 * swept box. */
bool rk_motion_may_intersect_leaf(const rk_bvh *bvh, const rk_box *swept, const rk_slabs *ray,
                                  float t_max);

#endif
