/* Axis-aligned boxes and their intersection with a ray (slab test: Kay and Kajiya 1986; robust
 * bounds: Ize, "Robust BVH ray traversal", JCGT 2013). */
#ifndef RK_BASE_BOX_H
#define RK_BASE_BOX_H

#include "base/ray.h"
#include "base/simd4.h"
#include "base/vec3.h"

#include <float.h>
#include <stdbool.h>

typedef struct rk_box {
    rk_vec3 corner[2]; /* corner[0] the lowest, corner[1] the highest coordinates */
} rk_box;

/* The empty box: merged with any box, it gives that box. */
static inline rk_box rk_box_empty(void)
{
    return (rk_box){
        {rk_vec(INFINITY, INFINITY, INFINITY), rk_vec(-INFINITY, -INFINITY, -INFINITY)}};
}

static inline rk_box rk_box_add(rk_box box, rk_vec3 point)
{
    return (rk_box){{rk_min3(point, box.corner[0]), rk_max3(point, box.corner[1])}};
}

static inline rk_box rk_box_merge(rk_box a, rk_box b)
{
    return (rk_box){{rk_min3(a.corner[0], b.corner[0]), rk_max3(a.corner[1], b.corner[1])}};
}

static inline rk_vec3 rk_box_extent(rk_box box)
{
    return rk_sub(box.corner[1], box.corner[0]);
}

/* Surface area; 0 for an empty box. In double, because a huge box overflows a float and a tiny one
 * underflows. */
static inline double rk_box_area(rk_box box)
{
    double x = (double)box.corner[1].x - (double)box.corner[0].x;
    double y = (double)box.corner[1].y - (double)box.corner[0].y;
    double z = (double)box.corner[1].z - (double)box.corner[0].z;
    return x >= 0 ? 2 * (x * y + y * z + z * x) : 0;
}

/* The axis of the largest extent; of equal ones, x before y before z. In double, because several
 * extents may overflow a float, and would all be infinite. */
static inline int rk_box_longest_axis(rk_box box)
{
    double x = (double)box.corner[1].x - (double)box.corner[0].x;
    double y = (double)box.corner[1].y - (double)box.corner[0].y;
    double z = (double)box.corner[1].z - (double)box.corner[0].z;
    int axis = y > x ? 1 : 0;
    return z > (axis ? y : x) ? 2 : axis;
}

/* A ray prepared for the slab test, once for all boxes. The reciprocals are pushed apart by 2
 * gamma_3 (|gamma_3| <= 3 eps / (1 - 3 eps), Higham 2002), so that rounding never loses a box that
 * the exact ray touches. This holds for direction components up to 2^126 (reciprocals of larger
 * ones are denormal), and while the distances to the box and t itself do not overflow. */
typedef struct rk_slabs {
    rk_vec3 origin;
    rk_simd4 origin4;                   /* x, y, z and, like the next ones, z again */
    rk_simd4 inverse_near, inverse_far; /* 1 / direction, a little smaller and a little larger */
    rk_simd4_mask is_backward;          /* on these axes the box's highest side is the near one */
} rk_slabs;

/* The near bound of 1 / d. Below 2^-128 the reciprocal of a denormal overflows, and infinity would
 * put boxes out of reach that a t below FLT_MAX does reach; only a component of 0 never reaches
 * them. */
static inline float rk_slabs_inverse_near(float d, float inverse_near)
{
    return d != 0 && fabsf(inverse_near) > FLT_MAX ? copysignf(FLT_MAX, d) : inverse_near;
}

static inline rk_slabs rk_slabs_of(const rk_ray *ray)
{
    const float gamma_3 = 3 * 0x1p-24f / (1 - 3 * 0x1p-24f);
    rk_vec3 d = ray->direction;
    rk_vec3 inverse = rk_vec(1 / d.x, 1 / d.y, 1 / d.z);
    rk_vec3 near = rk_scale(inverse, 1 - 2 * gamma_3);
    rk_vec3 size = rk_abs3(d);
    if (rk_min(size.x, rk_min(size.y, size.z)) < FLT_MIN)
        near = rk_vec(rk_slabs_inverse_near(d.x, near.x), rk_slabs_inverse_near(d.y, near.y),
                      rk_slabs_inverse_near(d.z, near.z));
    return (rk_slabs){.origin = ray->origin,
                      .origin4 = rk_simd4_of(ray->origin),
                      .inverse_near = rk_simd4_of(near),
                      .inverse_far = rk_simd4_of(rk_scale(inverse, 1 + 2 * gamma_3)),
                      .is_backward = (rk_simd4_mask)rk_simd4_of(d) >> 31};
}

/* The corners on the near and on the far side of the box. */
typedef struct rk_box_sides {
    rk_simd4 near, far;
} rk_box_sides;

static inline rk_box_sides rk_box_sides_of(const rk_box *box, const rk_slabs *ray)
{
    rk_simd4 low = rk_simd4_first3(&box->corner[0].x), high = rk_simd4_last3(&box->corner[0].z);
    rk_simd4_mask swap = ((rk_simd4_mask)low ^ (rk_simd4_mask)high) & ray->is_backward;
    return (rk_box_sides){(rk_simd4)((rk_simd4_mask)low ^ swap),
                          (rk_simd4)((rk_simd4_mask)high ^ swap)};
}

/* Returns the t at which the ray enters a box with these sides (0 if it starts inside), or infinity
 * if it misses the box or enters beyond t_max. A ray in the plane of a face gives 0 * infinity =
 * NaN, which minimum and maximum ignore: that face does not bound the ray. */
static inline float rk_box_sides_enter(rk_box_sides sides, const rk_slabs *ray, float t_max)
{
    rk_simd4 near = (sides.near - ray->origin4) * ray->inverse_near;
    rk_simd4 far = (sides.far - ray->origin4) * ray->inverse_far;
    float enter = rk_simd4_largest(rk_simd4_max(near, rk_simd4_all(0)));
    float leave = rk_simd4_smallest(rk_simd4_min(far, rk_simd4_all(t_max)));
    return enter <= leave ? enter : INFINITY;
}

/* The same of a box. */
static inline float rk_box_enter(const rk_box *box, const rk_slabs *ray, float t_max)
{
    return rk_box_sides_enter(rk_box_sides_of(box, ray), ray, t_max);
}

/* Returns the t at which a ray that enters the box leaves it, at most t_max. */
static inline float rk_box_leave(const rk_box *box, const rk_slabs *ray, float t_max)
{
    rk_simd4 far = (rk_box_sides_of(box, ray).far - ray->origin4) * ray->inverse_far;
    return rk_simd4_smallest(rk_simd4_min(far, rk_simd4_all(t_max)));
}

#endif
