/* Axis-aligned boxes and their intersection with a ray (slab test: Kay and Kajiya 1986; robust
 * bounds: Ize, "Robust BVH ray traversal", JCGT 2013). */
#ifndef RK_BASE_BOX_H
#define RK_BASE_BOX_H

#include "base/ray.h"
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
    rk_vec3 inverse_near, inverse_far; /* 1 / direction, a little smaller and a little larger */
    int near_x, near_y, near_z;        /* the corner on the near side of each axis */
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
    return (rk_slabs){
        .origin = ray->origin,
        .inverse_near = near,
        .inverse_far = rk_scale(inverse, 1 + 2 * gamma_3),
        .near_x = signbit(d.x) ? 1 : 0,
        .near_y = signbit(d.y) ? 1 : 0,
        .near_z = signbit(d.z) ? 1 : 0,
    };
}

/* Returns the t at which a ray that enters the box leaves it, at most t_max. */
static inline float rk_box_leave(const rk_box *box, const rk_slabs *ray, float t_max)
{
    float far_x = (box->corner[1 - ray->near_x].x - ray->origin.x) * ray->inverse_far.x;
    float far_y = (box->corner[1 - ray->near_y].y - ray->origin.y) * ray->inverse_far.y;
    float far_z = (box->corner[1 - ray->near_z].z - ray->origin.z) * ray->inverse_far.z;
    return rk_min(far_x, rk_min(far_y, rk_min(far_z, t_max)));
}

/* Returns the t at which the ray enters the box (0 if it starts inside), or infinity if it misses
 * the box or enters beyond t_max. A ray in the plane of a face gives 0 * infinity = NaN, which
 * rk_min and rk_max ignore: that face does not bound the ray. */
static inline float rk_box_enter(const rk_box *box, const rk_slabs *ray, float t_max)
{
    float near_x = (box->corner[ray->near_x].x - ray->origin.x) * ray->inverse_near.x;
    float near_y = (box->corner[ray->near_y].y - ray->origin.y) * ray->inverse_near.y;
    float near_z = (box->corner[ray->near_z].z - ray->origin.z) * ray->inverse_near.z;
    float enter = rk_max(near_x, rk_max(near_y, rk_max(near_z, 0)));
    return enter <= rk_box_leave(box, ray, t_max) ? enter : INFINITY;
}

#endif
