/* Vectors of three floats: points, directions and linear RGB colours. The whole kit is written in
 * vectors, so their names alone carry no module: rk_add, rk_dot, rk_cross. */
#ifndef RK_BASE_VEC3_H
#define RK_BASE_VEC3_H

#include <math.h>

#ifdef __cplusplus
#error "the source folder's headers are for C; make install makes those for C++ (pkg-config raykit)"
#endif

#define RK_PI 3.14159265f
#define RK_PI_DOUBLE 3.14159265358979323846

typedef struct rk_vec2 {
    float x, y;
} rk_vec2;

typedef struct rk_vec3 {
    float x, y, z;
} rk_vec3;

static inline rk_vec3 rk_vec(float x, float y, float z)
{
    return (rk_vec3){x, y, z};
}

static inline rk_vec3 rk_add(rk_vec3 a, rk_vec3 b)
{
    return rk_vec(a.x + b.x, a.y + b.y, a.z + b.z);
}

static inline rk_vec3 rk_sub(rk_vec3 a, rk_vec3 b)
{
    return rk_vec(a.x - b.x, a.y - b.y, a.z - b.z);
}

/* Componentwise: light filtered by a colour. */
static inline rk_vec3 rk_mul(rk_vec3 a, rk_vec3 b)
{
    return rk_vec(a.x * b.x, a.y * b.y, a.z * b.z);
}

static inline rk_vec3 rk_scale(rk_vec3 a, float s)
{
    return rk_vec(a.x * s, a.y * s, a.z * s);
}

/* a + s b: the point at parameter s of the ray from a along b. */
static inline rk_vec3 rk_madd(rk_vec3 a, rk_vec3 b, float s)
{
    return rk_vec(a.x + b.x * s, a.y + b.y * s, a.z + b.z * s);
}

static inline rk_vec3 rk_negate(rk_vec3 a)
{
    return rk_vec(-a.x, -a.y, -a.z);
}

static inline float rk_dot(rk_vec3 a, rk_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline rk_vec3 rk_cross(rk_vec3 a, rk_vec3 b)
{
    return rk_vec(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

static inline float rk_length(rk_vec3 a)
{
    return sqrtf(rk_dot(a, a));
}

/* Returns a / |a|; the zero vector, which has no direction, is returned unchanged. For lengths from
 * 2^-60 to 2^60 (1e-18 and 1e18): the squares of shorter and longer ones lose digits or are beyond
 * a float. From 2^65 on the result is 0, below 2^-76 it is a. */
static inline rk_vec3 rk_normalize(rk_vec3 a)
{
    float length = rk_length(a);
    return length > 0 ? rk_scale(a, 1 / length) : a;
}

/* Libm's fminf and fmaxf are function calls that also handle NaN; these are one instruction and
 * return b when a is NaN. The box test relies on that. */
static inline float rk_min(float a, float b)
{
    return a < b ? a : b;
}

static inline float rk_max(float a, float b)
{
    return a > b ? a : b;
}

static inline rk_vec3 rk_min3(rk_vec3 a, rk_vec3 b)
{
    return rk_vec(rk_min(a.x, b.x), rk_min(a.y, b.y), rk_min(a.z, b.z));
}

static inline rk_vec3 rk_max3(rk_vec3 a, rk_vec3 b)
{
    return rk_vec(rk_max(a.x, b.x), rk_max(a.y, b.y), rk_max(a.z, b.z));
}

static inline rk_vec3 rk_abs3(rk_vec3 a)
{
    return rk_vec(fabsf(a.x), fabsf(a.y), fabsf(a.z));
}

/* The component on axis 0 (x), 1 (y) or 2 (z). */
static inline float rk_axis(rk_vec3 a, int axis)
{
    return axis == 0 ? a.x : axis == 1 ? a.y : a.z;
}

static inline rk_vec3 rk_mix(rk_vec3 a, rk_vec3 b, float t)
{
    return rk_add(rk_scale(a, 1 - t), rk_scale(b, t));
}

#endif
