/* Rays into random directions above a surface test how much of the hemisphere is unoccluded.
 * Directions are computed around the z axis, where the maps are simple, and then rotated to the
 * normal; density and weight of a map together account for the cosine. The map by the disk below
 * the hemisphere: Malley, "A shading method for computer generated images", Master's thesis, Utah
 * 1988; the closed forms are view factors: Howell, "A catalog of radiation heat transfer
 * configuration factors", 1982. */
#include "features/ambient_occlusion.h"

#include "features/glossy_reflection.h"

/* Contents, in the order of the chapter. */
static rk_vec3 uniform(rk_vec2 xi);
static rk_vec3 cosine_distributed(rk_vec2 xi);

/* --- Directions around the z axis ------------------------------------------------------------- */

rk_vec3 rk_ambient_hemisphere(rk_ambient_map map, rk_vec2 xi)
{
    return map == RK_AMBIENT_UNIFORM ? uniform(xi) : cosine_distributed(xi);
}

/* A sphere's zones of equal height have equal areas (Archimedes), so z is uniform. */
static rk_vec3 uniform(rk_vec2 xi)
{
    /* solution */
    float z = 1 - xi.x; /* never 0, because xi.x is never 1 */
    float radius = sqrtf(xi.x * (1 + z)), phi = 2 * RK_PI * xi.y;
    return rk_vec(radius * cosf(phi), radius * sinf(phi), z);
    /* starter
    // First step: the height z from xi.x, the angle from xi.y, and the radius for a unit vector.
    return rk_vec(0, 0, 0);
    end */
}

/* A patch of the hemisphere projects onto the disk with cos(theta) of its area, so uniform points
 * of the disk are cosine-distributed on the hemisphere. */
static rk_vec3 cosine_distributed(rk_vec2 xi)
{
    /* solution */
    rk_vec2 disk = rk_disk_at(RK_DISK_CONCENTRIC, xi);
    float z_squared = 1 - disk.x * disk.x - disk.y * disk.y;
    return rk_vec(disk.x, disk.y, sqrtf(rk_max(z_squared, 0)));
    /* starter
    // Second step: a point of the disk (rk_disk_at), lifted to the hemisphere.
    return rk_vec(0, 0, 0);
    end */
}

float rk_ambient_weight(rk_ambient_map map, float cosine)
{
    /* solution */
    return map == RK_AMBIENT_UNIFORM ? 2 * cosine : 1;
    /* starter
    // Second step: cos(theta) / pi, divided by the map's density.
    return 0;
    end */
}

/* --- Around the normal ------------------------------------------------------------------------ */

rk_ambient_frame rk_ambient_frame_of(rk_vec3 normal, rk_vec3 face_normal)
{
    rk_ambient_frame frame = {.normal = normal, .face_normal = face_normal};
    rk_basis_of(normal, &frame.u, &frame.v);
    return frame;
}

bool rk_ambient_direction(const rk_ambient_frame *frame, rk_vec3 local, rk_vec3 *direction)
{
    /* solution */
    rk_vec3 along = rk_madd(rk_scale(frame->u, local.x), frame->v, local.y);
    *direction = rk_madd(along, frame->normal, local.z);
    return rk_dot(*direction, frame->face_normal) > 0;
    /* starter
    // Third step: x u + y v + z n; then, is it above the face?
    *direction = rk_vec(0, 0, 0);
    return false;
    end */
}

/* --- Radiance --------------------------------------------------------------------------------- */

rk_vec3 rk_ambient_radiance(rk_vec3 kd, float intensity, rk_vec3 sum, uint32_t samples)
{
    /* solution */
    rk_vec3 visibility = rk_scale(sum, 1 / (float)samples);
    return rk_mul(rk_scale(kd, intensity), visibility);
    /* starter
    // Fourth step: ka kd A, where A is the mean over all samples.
    return rk_vec(0, 0, 0);
    end */
}

/* --- Closed forms ----------------------------------------------------------------------------- */

float rk_ambient_below_disk(float radius, float height)
{
    /* solution */
    double tangent = (double)radius / (double)height; /* of the angle to the rim */
    return (float)(1 / (1 + tangent * tangent));      /* a float's square might overflow */
    /* starter
    // Fifth step: 1 - sin^2 of the angle between the normal and the direction to the rim.
    return -1;
    end */
}

float rk_ambient_below_sphere(float radius, float distance, float cosine)
{
    /* solution */
    float sine = radius / distance; /* of half the angle that the sphere covers */
    return 1 - cosine * sine * sine;
    /* starter
    // Fifth step: overhead, as a disk with its outline; elsewhere, times the cosine.
    return -1;
    end */
}

float rk_ambient_beside_wall(float height, float distance)
{
    /* solution */
    float tangent = height / distance; /* of the angle to the edge, above the floor */
    return (1 + 1 / sqrtf(1 + tangent * tangent)) / 2;
    /* starter
    // Fifth step: half of the hemisphere, and the part of the other half above the wall.
    return -1;
    end */
}
