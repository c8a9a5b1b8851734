/* Shading: how much of the light that reaches a point of a surface goes on to the viewer.
 *
 *   n  the normal        l  to the light         r = 2 (n.l) n - l, where a mirror sends the light
 *   v  to the viewer     I  the light's colour   h = (l + v) / |l + v|, halfway
 *
 * With kd and ks the diffuse and the specular colour, s the shininess, and n.l > 0:
 *
 *   model          colour                        normalised
 *   Lambert        I kd n.l                      I kd / pi n.l
 *   Phong          I (kd n.l + ks lobe)          I (kd / pi + ks N lobe) n.l
 *                  lobe = (r.v)^s                N = (s + 2) / (2 pi)
 *   Blinn-Phong    likewise                      likewise
 *                  lobe = (n.h)^s                N = (s + 2) (s + 4) / (8 pi (2^(-s/2) + s))
 *
 * and 0 where n.l <= 0. A lobe is 0 where its cosine is not positive, for every s, 0 too. The other
 * two models have nothing to normalise: off, I kd, and the gradient, I gradient(n.l).
 *
 * Normalised reflection is a reflectance distribution f, so I is what physical lights give:
 * irradiance on a plane facing the light (their radiance times their solid angle). Of the light
 * from any direction kd / pi reflects the share kd, and a lobe at most the share ks: just ks when
 * it comes along n, less at an angle. Together that is up to kd + ks, whether below one or not is
 * the material's matter. Swapping l and v does not change f. */
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
    float at; /* a value of n.l, finite */
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

/* Returns the colour that light of the colour I has after the surface. n, l, v: unit;
 * shininess: finite, >= 0, not read where ks is black. Never NaN for finite colours. */
rk_vec3 rk_shade(const rk_shading *shading, rk_vec3 kd, rk_vec3 ks, float shininess, rk_vec3 n,
                 rk_vec3 l, rk_vec3 v, rk_vec3 light_colour);

/* Returns the colour at x: linear between neighbouring stops, that of the first or last stop beyond
 * them, black without stops. Stops at the same place make a step: below it the first of them
 * counts, as listed, from the place itself on the last. */
rk_vec3 rk_gradient_at(const rk_gradient *gradient, float x);

/* From blue, where n.l = -1, to orange, where it is 1: the cool and warm of technical drawings
 * (A. Gooch, B. Gooch, Shirley, Cohen, "A non-photorealistic lighting model for automatic technical
 * illustration", SIGGRAPH 1998). */
rk_gradient rk_gradient_cool_to_warm(void);

#endif
