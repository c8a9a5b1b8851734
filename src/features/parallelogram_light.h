/* Lights with an extent: the position and weight of a sample, the irradiance in closed form, and
 * when no more shadow rays are needed. */
#ifndef RK_FEATURES_PARALLELOGRAM_LIGHT_H
#define RK_FEATURES_PARALLELOGRAM_LIGHT_H

#include "scene/light.h"

#include <stdbool.h>
#include <stdint.h>

/* How light falls off with distance.
 * None, as in classic courses: each point of the light has its full colour at any distance and
 * angle. Physical: a parallelogram's colour is its radiance L, and E = integral of L cos cos' / r^2
 * dA; a segment's is the radiant intensity of a thin luminous tube per length, integral of I cos
 * sin' / r^2 dl, with sin' of the angle between tube and direction; a point's is radiant intensity,
 * I cos / r^2. At r = 0, a point on the light itself, E is 0. */
typedef enum rk_light_falloff { RK_FALLOFF_NONE, RK_FALLOFF_PHYSICAL } rk_light_falloff;

/* How xi becomes a point of the light: uniformly over its area, or over its solid angle. The
 * density of the latter contains cos' / r^2, so without physical falloff, and for lights other than
 * parallelograms, samples are over the area. */
typedef enum rk_light_domain { RK_LIGHT_DOMAIN_AREA, RK_LIGHT_DOMAIN_SOLID_ANGLE } rk_light_domain;

typedef struct rk_light_sample {
    rk_vec3 position; /* a point of the light, in the scene; not a direction */
    rk_vec3 colour;   /* weighted */
} rk_light_sample;

/* Returns the light's sample for xi in [0, 1)^2, weighted for the surface point `point`. The mean
 * over uniform xi of
 *
 *     rk_shade(..., l, ..., sample.colour), l = rk_normalize(rk_sub(sample.position, point)),
 *
 * estimates the reflected light of an unoccluded light; a sample whose shadow ray, from the point
 * to the position, is occluded counts as 0 in that mean. Uniform, stratified and low-discrepancy
 * sampling differ only in how xi is drawn (base/sampler.h). A parallelogram without area, its edges
 * parallel or zero, acts as a segment or a point without falloff, in the mix of its four colours;
 * with it, radiance from no area is no light. Finite for distances from 1e-15 to 1e15. */
rk_light_sample rk_light_sample_at(const rk_light *light, rk_light_falloff falloff,
                                   rk_light_domain domain, rk_vec3 point, rk_vec2 xi);

/* Returns the solid angle, 0 to 2 pi, that a parallelogram subtends at the point, in double
 * precision however small it is: the relative error is about 2^-50 times the distance to the
 * farthest corner over that to the parallelogram's plane. Between the ends of a needle, which is
 * narrower than its distance from the point, it is up to the square of that. 0 in this plane, on
 * the light itself, too. */
double rk_light_solid_angle(const rk_light *light, rk_vec3 point);

/* Returns the irradiance at the point, on a surface of unit normal `normal`, of the unshadowed
 * light if all of its colours are 1 and falloff is physical. Parts of the light below the surface's
 * horizon do not count. Closed form; the error is about 2^-50 of the angle that the light subtends,
 * times the farthest corner's distance over that of the nearest side. Lambert, "Photometria", 1760;
 * clipped as in Baum, Rushmeier, Winget, "Improving radiosity solutions through the use of
 * analytically determined form-factors", 1989. */
float rk_light_irradiance(const rk_light *light, rk_vec3 point, rk_vec3 normal);

/* The ratio estimator: returns `unshadowed`, from the closed form (irradiance x the light's one
 * colour x a Lambertian surface's kd), times the visible fraction, `visible` / `all`: the sums of
 * the unoccluded shaded samples, and of all of them. Exact where nothing or everything is occluded;
 * elsewhere its bias falls with 1 / samples. 0 where `all` is 0. Lights of several colours
 * (rk_light_has_one_colour) have no closed form here: use the plain mean for them, and for shading
 * other than Lambert's. Heitz, Hill, McGuire, "Combining analytic direct illumination and
 * stochastic shadows", 2018. */
rk_vec3 rk_light_ratio(rk_vec3 unshadowed, rk_vec3 visible, rk_vec3 all);

/* The shadow rays of the first round, after which rk_light_early_out decides about the rest. */
enum { RK_LIGHT_EARLY_OUT = 16 };

/* Can the remaining samples do without shadow rays, after a first round in which `visible` of
 * `round` were unoccluded? Yes if all agree: the rest then count as visible, or as occluded, too.
 * Not after a round of no rays, from which nothing is known. If the fraction v of the light is
 * visible and samples are independent, all are occluded with probability (1 - v)^round, so on
 * average at most max v (1 - v)^round = 1 / (round + 1) (round / (round + 1))^round of the light is
 * lost: 0.022 for 16 samples. */
bool rk_light_early_out(uint32_t round, uint32_t visible);

#endif
