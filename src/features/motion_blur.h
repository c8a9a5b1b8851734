/* Motion blur: objects on cubic paths, met by rays that carry a time. The scene is there once, and
 * memory does not grow with the number of samples. */
#ifndef RK_FEATURES_MOTION_BLUR_H
#define RK_FEATURES_MOTION_BLUR_H

#include "base/box.h"
#include "scene/bvh.h"
#include "scene/motion.h"

#include <stdint.h>

/* The path of the classic course: y = -4 x^3 + 0.5 x^2 + 1.5 x. */
rk_motion rk_motion_default(void);

/* Returns where an object stands at the time x, from where it rests: (x, y(x), 0), rounded once. */
rk_vec3 rk_motion_offset(const rk_motion *motion, float x);

/* Returns a ray of the scene as an object that stands at `offset` sees it: in the object's own
 * frame, where it rests. t means the same in both. */
rk_ray rk_motion_ray(rk_vec3 offset, const rk_ray *ray);

/* The interval of x in which the picture is taken; open <= close. */
typedef struct rk_shutter {
    float open, close;
} rk_shutter;

/* Returns the time k of `samples` that are equally far apart: the middle of the k-th of as many
 * equal parts of the shutter, open + (k - 1/2) / samples (close - open). So neither end is one of
 * the times: each stands for a part of the shutter, and all parts are inside. k counts from 1; with
 * k below 1 or above `samples` the time lies before or after the shutter, and between two times if
 * k is no whole number. */
float rk_shutter_equidistant(const rk_shutter *shutter, float k, uint32_t samples);

typedef enum rk_time_sampling {
    RK_TIME_EQUIDISTANT,    /* the same times for all pixels: copies of the object */
    RK_TIME_STRATIFIED,     /* sample i in part i of as many equal parts as there are samples */
    RK_TIME_LOW_DISCREPANCY /* in no order; of the first 2^k, for each k, one in each of 2^k parts
                             */
} rk_time_sampling;

/* Returns the time of `sample`, 0 to samples - 1, of a pixel; within the shutter. Equidistant times
 * need no random number. Others take rk_sample_1d's of the seed, pixel, sample and
 * RK_DIMENSION_TIME: a low-discrepancy one is the share of the shutter, and one of any kind is the
 * place in the part of a stratified time. */
float rk_shutter_time(const rk_shutter *shutter, rk_time_sampling sampling, uint32_t seed,
                      uint32_t pixel, uint32_t sample, uint32_t samples);

/* Returns a box around all places where `rest`, a box at rest, comes to while the shutter is open:
 * from the exact extremes of the path. It is larger than that by 2^-19 of the numbers that made it,
 * which is for rk_motion_may_intersect. */
rk_box rk_motion_sweep(const rk_motion *motion, const rk_shutter *shutter, const rk_box *rest);

/* May the ray enter what moves in a swept box, at 0 <= t <= t_max? False is certain: then at no
 * time while the shutter is open does rk_motion_ray's ray enter the box at rest by rk_box_enter,
 * whatever the roundings. */
bool rk_motion_may_intersect(const rk_box *swept, const rk_slabs *ray, float t_max);

/* The same question, asked more closely: may it enter a leaf of the object's tree? `swept` is the
 * root's box. */
bool rk_motion_may_intersect_leaf(const rk_bvh *bvh, const rk_box *swept, const rk_slabs *ray,
                                  float t_max);

#endif
