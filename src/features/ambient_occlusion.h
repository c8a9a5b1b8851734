/* Ambient occlusion: light of equal radiance from all directions, except where nearby surfaces
 * occlude it. Corners, folds and the ground below objects get dark, as on an overcast day.
 *
 *   L = ka kd A(p)                                       ambient radiance
 *   A(p) = 1/pi integral of V(p, w) cos(theta) dw        ambient visibility, over the hemisphere
 *
 *   V      1 where a ray from p along w is unoccluded as far as a given distance, else 0
 *   theta  the angle between w and the normal
 *
 * A is estimated by the mean of weight times V over N directions. Their density is 1 / (2 pi),
 * with the weight 2 cos(theta), or cos(theta) / pi, with the weight 1.
 *
 * Zhukov, Iones, Kronin, "An ambient light illumination model", Rendering Techniques 1998; Landis,
 * "Production-ready global illumination", SIGGRAPH 2002 course 16; Pharr, Jakob, Humphreys,
 * "Physically Based Rendering", fourth edition, section A.5. */
#ifndef RK_FEATURES_AMBIENT_OCCLUSION_H
#define RK_FEATURES_AMBIENT_OCCLUSION_H

#include "base/sampler.h"

#include <stdbool.h>

/* Maps the sample xi to a direction. */
typedef enum rk_ambient_map {
    RK_AMBIENT_UNIFORM, /* uniform in solid angle: z = 1 - xi.x, at the angle 2 pi xi.y around it,
                          from x towards y */
    RK_AMBIENT_COSINE,  /* cosine-distributed: above rk_disk_at(RK_DISK_CONCENTRIC, xi) */
} rk_ambient_map;

typedef struct rk_ambient_occlusion_options {
    float intensity;  /* ka; 0: no ambient light */
    uint32_t samples; /* directions per shading point */
    float distance;   /* world units; surfaces farther away occlude nothing */
    rk_ambient_map map;
    rk_sampler_kind sampling;
} rk_ambient_occlusion_options;

/* Returns the direction for xi in [0, 1)^2, multiples of 2^-24 as samplers give them: unit, around
 * the z axis. z, its cosine, is above 0 by the uniform map, and at least 0 by the other. */
rk_vec3 rk_ambient_hemisphere(rk_ambient_map map, rk_vec2 xi);

/* Returns the weight of a direction with this cosine; its mean over the map's directions is 1. */
float rk_ambient_weight(rk_ambient_map map, float cosine);

/* The hemisphere of a point, around its shading normal. */
typedef struct rk_ambient_frame {
    rk_vec3 u, v, normal; /* right-handed, unit, at right angles */
    rk_vec3 face_normal;  /* unit; in the hemisphere of `normal` */
} rk_ambient_frame;

rk_ambient_frame rk_ambient_frame_of(rk_vec3 normal, rk_vec3 face_normal);

/* Rotates a direction, `local` with z at least 0, from the axes x, y, z to the frame's u, v,
 * normal. False if it points below the face or along it, where the surface itself occludes it;
 * `direction` is filled in all the same. */
bool rk_ambient_direction(const rk_ambient_frame *frame, rk_vec3 local, rk_vec3 *direction);

/* Returns L. `sum`: of weight times V over the directions, V a colour behind glass; `samples`:
 * the number of all directions, occluded ones and those into the surface included; at least 1.
 * For intensities of at most 2^40 (1e12). */
rk_vec3 rk_ambient_radiance(rk_vec3 kd, float intensity, rk_vec3 sum, uint32_t samples);

/* A in closed form, with a single occluder. Lengths are in any unit, up to the largest float: only
 * their ratio counts. To a few ulps of 1; below the disk, to a few ulps of A, however small. */

/* Below the centre of a disk that is parallel to the surface; height > 0. */
float rk_ambient_below_disk(float radius, float height);

/* Of a sphere entirely above the horizon. `distance`: to its centre, larger than the radius;
 * `cosine`: of the angle between the normal and the direction to its centre. */
float rk_ambient_below_sphere(float radius, float distance, float cosine);

/* On a floor beside an endlessly wide wall; height > 0, distance > 0. */
float rk_ambient_beside_wall(float height, float distance);

#endif
