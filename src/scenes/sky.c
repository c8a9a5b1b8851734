/* Gradients over the height above the horizon, and a disk with a soft edge for the sun. */
#include "scenes/sky.h"

static const rk_vec3 zenith = {0.1f, 0.25f, 0.65f};
static const rk_vec3 horizon = {0.7f, 0.82f, 0.95f};
static const rk_vec3 ground_far = {0.3f, 0.26f, 0.2f};
static const rk_vec3 ground_near = {0.04f, 0.05f, 0.02f};
static const rk_vec3 sun = {30, 27, 20};

/* The direction of the default light, (0, 2.4, -3.2). */
static const rk_vec3 to_sun = {0, 0.6f, -0.8f};

/* Rises from 0 at `from` to 1 at `to`, with zero slope at both ends. */
static float smooth_step(float from, float to, float x)
{
    float t = rk_max(0, rk_min((x - from) / (to - from), 1));
    return t * t * (3 - 2 * t);
}

/* Height is the sine of the angle above the horizon. The more air a ray passes, the brighter. */
static rk_vec3 air(float height)
{
    float low = 1 - rk_max(height, 0);
    return rk_mix(zenith, horizon, low * low * low * low);
}

/* The ground, too, is brighter in the distance, seen through more air. */
static rk_vec3 ground(float height)
{
    float far = 1 - rk_max(-height, 0);
    return rk_mix(ground_near, ground_far, far * far * far);
}

/* By the sine between the directions: near the sun it is exact, and the cosine, near 1, is not. */
static float sun_disk(rk_vec3 d)
{
    if (rk_dot(d, to_sun) <= 0)
        return 0;
    const float inner = 0.045f,
                outer = 0.055f; /* sines of 2.6 and 3.2 degrees: ten times the real sun */
    return 1 - smooth_step(inner, outer, rk_length(rk_cross(d, to_sun)));
}

rk_vec3 rk_sky_at(rk_vec3 direction)
{
    rk_vec3 d = rk_normalize(direction);
    rk_vec3 colour = rk_mix(ground(d.y), air(d.y), smooth_step(-0.06f, 0, d.y));
    return rk_mix(colour, sun, sun_disk(d));
}

bool rk_sky_make(rk_cubemap *map, uint32_t side, rk_error *error)
{
    if (!rk_cubemap_init(map, side, error))
        return false;
    for (int face = 0; face < RK_FACES; face++)
        for (uint32_t row = 0; row < side; row++)
            for (uint32_t column = 0; column < side; column++)
                *rk_cubemap_texel(map, (rk_cube_face)face, column, row) =
                    rk_sky_at(rk_cubemap_texel_direction(side, (rk_cube_face)face, column, row));
    return true;
}
