/* Lights with an extent: where on the light a sample lies and how much it weighs, the irradiance in
 * closed form, and when shadow rays may stop. */
#ifndef RK_FEATURES_PARALLELOGRAM_LIGHT_H
#define RK_FEATURES_PARALLELOGRAM_LIGHT_H

#include "scene/light.h"

#include <stdbool.h>
#include <stdint.h>

/* What distance does to light.
 * None, as in classic courses: a point of the light has its colour, however far and turned.
 * Physical: a parallelogram's colour is its radiance L, and E = integral of L cos cos' / r^2 dA; a
 * segment's is that of a thin glowing tube for each length, integral of I cos sin' / r^2 dl, with
 * sin' of the angle between tube and direction; a point's is radiant intensity, I cos / r^2. The
 * limit r = 0, a point on the light itself, gets nothing. */
typedef enum rk_light_falloff { RK_FALLOFF_NONE, RK_FALLOFF_PHYSICAL } rk_light_falloff;

/* How xi becomes a point of the light: evenly over its area, or evenly over the directions in which
 * it is seen. The latter has cos' / r^2 in its density, so without that falloff, and for lights
 * that are no parallelograms, it is the former. */
typedef enum rk_light_domain { RK_LIGHT_DOMAIN_AREA, RK_LIGHT_DOMAIN_SOLID_ANGLE } rk_light_domain;

typedef struct rk_light_sample {
    rk_vec3 position; /* a place in the scene, not a direction */
    rk_vec3 colour;   /* weighted */
} rk_light_sample;

/* Returns the sample that xi in [0, 1)^2 stands for, as the surface point `point` sees it. The
 * weights are such that the mean, over evenly distributed xi, of
 *
 *     rk_shade(..., l, ..., sample.colour), l = rk_normalize(rk_sub(sample.position, point)),
 *
 * estimates the whole light's effect at the point, if nothing is in the way; where a shadow ray
 * from the point to the position is blocked, the sample counts as 0 in that mean. Uniform,
 * stratified and low-discrepancy sampling differ only in how xi is drawn (base/sampler.h). A
 * parallelogram without area, its edges parallel or zero, is a segment or a point if there is no
 * falloff; with it, radiance from no area is no light. Finite for distances from 1e-15 to 1e15. */
rk_light_sample rk_light_sample_at(const rk_light *light, rk_light_falloff falloff,
                                   rk_light_domain domain, rk_vec3 point, rk_vec2 xi);

/* Returns the solid angle, 0 to 2 pi, under which a parallelogram is seen from the point. */
double rk_light_solid_angle(const rk_light *light, rk_vec3 point);

/* Returns the irradiance at the point, on a surface of unit normal `normal`, of the unshadowed
 * light if all of its colours are 1 and falloff is physical. What is below the surface's horizon
 * does not count. Closed form; the error is about 2^-50 of the angle under which the light is seen.
 * Lambert, "Photometria", 1760; clipped as in Baum, Rushmeier, Winget, "Improving radiosity
 * solutions through the use of analytically determined form-factors", 1989. */
float rk_light_irradiance(const rk_light *light, rk_vec3 point, rk_vec3 normal);

/* The ratio estimator: returns `unshadowed`, which the closed form gave (irradiance x the light's
 * one colour x a Lambertian surface's kd), times the share that arrives, `visible` / `all`: sums of
 * the shaded samples that no shadow ray found blocked, and of all of them. Exact where nothing or
 * everything is blocked; elsewhere its bias falls with 1 / samples. 0 where `all` is. Lights of
 * several colours (rk_light_has_one_colour) have no closed form here: use the plain mean for them,
 * and for shading other than Lambert's. Heitz, Hill, McGuire, "Combining analytic direct
 * illumination and stochastic shadows", 2018. */
rk_vec3 rk_light_ratio(rk_vec3 unshadowed, rk_vec3 visible, rk_vec3 all);

/* How many shadow rays are worth tracing before asking whether more are needed. */
enum { RK_LIGHT_EARLY_OUT = 16 };

/* May the rest go without shadow rays, after a first round in which `visible` of `round` arrived?
 * Yes if all agree: then take the rest for visible, or for blocked, as these were. Of independent
 * samples, with a share v of the light visible, all are blocked with probability (1 - v)^round, so
 * this costs at most max v (1 - v)^round = 1 / (round + 1) (round / (round + 1))^round of the
 * light on average: 0.022 for 16 samples. */
bool rk_light_early_out(uint32_t round, uint32_t visible);

#endif
