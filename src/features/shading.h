/* Shading: the part of the light at a surface point that is reflected to the viewer.
 *
 *   n  the normal        l  to the light         r = 2 (n.l) n - l, the light's mirror direction
 *   v  to the viewer     I  the light's colour   h = (l + v) / |l + v|, the half vector
 *
 * With kd and ks the diffuse and the specular colour, s the shininess, and n.l > 0:
 *
 *   model          colour                        normalized
 *   Lambert        I kd n.l                      I kd / pi n.l
 *   Phong          I (kd n.l + ks lobe)          I (kd / pi + ks N lobe) n.l
 *                  lobe = (r.v)^s                N = (s + 2) / (2 pi)
 *   Blinn-Phong    likewise                      likewise
 *                  lobe = (n.h)^s                N = (s + 2) (s + 4) / (8 pi (2^(-s/2) + s))
 *
 * and 0 where n.l <= 0. A lobe is 0 where its cosine is not positive, even for s = 0. The other two
 * models have nothing to normalize: off, I kd, and the gradient, I gradient(n.l).
 *
 * A normalized model is a reflectance distribution f, and I is the irradiance of a physical light
 * on a plane facing it (radiance times solid angle). The diffuse part reflects the fraction kd of
 * the light from any direction, the lobe at most the fraction ks: exactly ks of light along n, less
 * at an angle. Together they reflect up to kd + ks; keeping that below one is up to the material.
 * Swapping l and v does not change f. */
#ifndef RK_FEATURES_SHADING_H
#define RK_FEATURES_SHADING_H

#include "base/vec3.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum rk_shading_model {
    RK_SHADING_OFF,
    RK_SHADING_LAMBERT,
    RK_SHADING_PHONG,
    RK_SHADING_BLINN_PHONG,
    RK_SHADING_GRADIENT,
} rk_shading_model;

enum { RK_GRADIENT_STOPS_MAX = 16 };

typedef struct rk_gradient_stop {
    float at; /* a value of n.l, or any other finite number */
    rk_vec3 colour;
} rk_gradient_stop;

typedef struct rk_gradient {
    uint32_t count;
    rk_gradient_stop stops[RK_GRADIENT_STOPS_MAX]; /* in any order */
} rk_gradient;

typedef struct rk_shading {
    rk_shading_model model;
    bool normalized;
    rk_gradient gradient; /* read by RK_SHADING_GRADIENT alone */
} rk_shading;

/* Returns the reflected colour of light of the colour I. n, l, v: unit; shininess:
 * finite, >= 0. Only Phong and Blinn-Phong with a ks that is not black read v and the shininess,
 * which may be anything elsewhere. Never NaN for finite colours, even where the light times a
 * colour overflows, as long as kd + N ks does not (N = 1 if not normalized). */
rk_vec3 rk_shade(const rk_shading *shading, rk_vec3 kd, rk_vec3 ks, float shininess, rk_vec3 n,
                 rk_vec3 l, rk_vec3 v, rk_vec3 light_colour);

/* Returns the colour at x, and only reads the gradient: linear between neighbouring stops, constant
 * beyond the first and the last, black without stops. Stops at the same place make a step: the
 * first in the list counts below it, the last from there on. */
rk_vec3 rk_gradient_at(const rk_gradient *gradient, float x);

/* From blue, where n.l = -1, to orange, where it is 1: the cool and warm tones of technical
 * drawings (A. Gooch, B. Gooch, Shirley, Cohen, "A non-photorealistic lighting model for automatic
 * technical illustration", SIGGRAPH 1998). */
rk_gradient rk_gradient_cool_to_warm(void);

#endif
