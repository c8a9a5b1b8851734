/* Lights: a point, a segment, or a parallelogram that emits from both sides. */
#ifndef RK_SCENE_LIGHT_H
#define RK_SCENE_LIGHT_H

#include "base/dvec3.h"

#include <stdbool.h>

typedef enum rk_light_kind {
    RK_LIGHT_POINT,
    RK_LIGHT_SEGMENT,
    RK_LIGHT_PARALLELOGRAM
} rk_light_kind;

/* The points of the light are position + x edge01 + y edge02, x and y in [0, 1]; the colour is
 * linear RGB, interpolated bilinearly between the corners. A segment has no y, a point neither x
 * nor y; members that a kind does not have are not read. */
typedef struct rk_light {
    rk_light_kind kind;
    rk_vec3 position;       /* corner 0 */
    rk_vec3 edge01, edge02; /* from corner 0 to corners 1 and 2 */
    rk_vec3 colours[4];     /* of corners 0, 1, 2, and 3, opposite to 0 */
} rk_light;

static inline rk_light rk_light_point(rk_vec3 position, rk_vec3 colour)
{
    return (rk_light){.kind = RK_LIGHT_POINT, .position = position, .colours = {colour}};
}

/* The second edge of a light that has one; 0 for a segment or a point. */
static inline rk_vec3 rk_light_edge02(const rk_light *light)
{
    const rk_vec3 none = {0, 0, 0};
    return light->kind == RK_LIGHT_PARALLELOGRAM ? light->edge02 : none;
}

/* Is any of its colours other than black? */
bool rk_light_emits(const rk_light *light);

/* Do all of its corners have the same colour? */
bool rk_light_has_one_colour(const rk_light *light);

/* Does the ray from `point` along `direction` (any length) hit the parallelogram? Fills in `at`,
 * the x and y of the place. In the light's plane there is no hit. */
bool rk_light_hit(const rk_light *light, rk_vec3 point, rk_vec3 direction, rk_vec2 *at);

/* Returns the density per solid angle, at the point, of samples uniform over the parallelogram's
 * area: r^2 / (A cos'), for the sample at `position`; infinite in the light's plane. */
double rk_light_area_density(const rk_light *light, rk_vec3 point, rk_vec3 position);

/* Returns the integral of cos sin' / r^2 dl over the part above the horizon of the segment from
 * `from` to `from` + `edge`, both relative to the surface point whose unit normal is `normal`; sin'
 * belongs to the angle between segment and direction. Never below 0; 0 for a segment of no length
 * or in line with the point. */
double rk_light_segment_irradiance(rk_dvec3 from, rk_dvec3 edge, rk_dvec3 normal);

#endif
