/* A ray and a block of four triangles. Float decides where its error cannot change the answer, so
 * nearly always. It also bounds t, and which of two hits is closer is certain unless their bounds
 * overlap; so double is needed only for the t, u and v of the closest hit in the end, and for what
 * is uncertain, about which features/watertight.c decides. Included by one file for each
 * instruction set (accel/kernel/wide_trace.h); not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_HITS_H
#define RK_ACCEL_KERNEL_WIDE_HITS_H

#include "accel/batch.h"
#include "base/dvec3.h"
#include "base/simd.h"
#include "features/watertight.h"
#include "scene/wide_tree.h"

typedef enum query { CLOSEST, OCCLUSION } query;

/* The closest hit so far. Its t is between near and far. If they are equal, its t, u, v and
 * triangle are known; else `place` says which triangle it is. */
typedef struct best_hit {
    float near, far, u, v;
    uint32_t place;    /* 4 block + triangle of the block */
    uint32_t triangle; /* or RK_MISS */
} best_hit;

typedef struct work {
    uint64_t nodes, blocks;
} work;

/* --- Bounds ----------------------------------------------------------------------------------- */

/* Bounds of t are pushed apart by more than they, and t itself, are rounded. A smaller t could be
 * denormal, which is rounded by more. */
static const float below_1 = 1 - 0x1p-21f, above_1 = 1 + 0x1p-21f, least_t = 0x1p-100f;

/* Can no product of a determinant overflow? No corner is farther from an origin than `reach`, as a
 * sum of components; `longest` is the largest component of a direction. */
RK_INLINE bool is_ordinary(float reach, float longest)
{
    return reach < 0x1p40f && longest < 0x1p40f && longest > 0x1p-40f;
}

/* Of a direction, if it is not 0: the reciprocal must not overflow. */
static const float least_component = 0x1p-60f;

/* Compared with the bound of u and v. */
static const float part_of_w = 0.5f;

/* Of bounds_of, which counts what they cover. */
static const float gamma = 10.25f * 0x1p-24f, tiny = 0x1p-41f;

/* Bounds of the errors of u, v and det, which are also that of half of w, and of t: gamma edge
 * (reach + edge) longest, and gamma edge^2 (reach + edge). By roundings of 2^-24, u and v have at
 * most 8 of them, w 19, det 10 and t 9, in determinants_of and in lanes_in_block; the appendix on
 * the kernel counts them. What is more in gamma covers the roundings of the bound and of second
 * order, and underflow takes less than the parts of 2^-41 add. `reach`: from origins to corners a.
 */
RK_INLINE rk_simd4 bounds_of(float edge, rk_simd4 reach, float longest, rk_simd4 *t_bound)
{
    const float side = edge + tiny;
    rk_simd4 area = rk_simd4_all(side * gamma) * (reach + rk_simd4_all(side));
    *t_bound = area * rk_simd4_all(side);
    return area * rk_simd4_all(longest);
}

/* --- In double -------------------------------------------------------------------------------- */

RK_INLINE uint32_t next_bit(uint32_t *bits)
{
    uint32_t i = (uint32_t)__builtin_ctz(*bits);
    *bits &= *bits - 1;
    return i;
}

RK_INLINE uint32_t place_of(const rk_wide_bvh *wide, const rk_wide_block *block, uint32_t i)
{
    return (uint32_t)(block - wide->blocks) * RK_WIDE_BLOCK + i;
}

RK_INLINE rk_triangle triangle_at(const rk_wide_bvh *wide, uint32_t place)
{
    return rk_wide_triangle(&wide->blocks[place / RK_WIDE_BLOCK], place % RK_WIDE_BLOCK);
}

/* What rk_watertight_intersect computes of a hit that is certain. */
RK_INLINE rk_hit certain_hit(const rk_triangle *triangle, const rk_ray *ray)
{
    rk_dvec3 a = rk_widen(triangle->a), direction = rk_widen(ray->direction);
    rk_dvec3 s = rk_dmadd(rk_widen(ray->origin), a, -1),
             ab = rk_dmadd(rk_widen(triangle->b), a, -1);
    rk_dvec3 ac = rk_dmadd(rk_widen(triangle->c), a, -1);
    rk_dvec3 p = rk_dcross(direction, ac), q = rk_dcross(s, ab);
    double u = rk_ddot(s, p), v = rk_ddot(direction, q), w = rk_ddot(ab, p) - u - v;
    double det = u + v + w;
    return (rk_hit){(float)(rk_ddot(ac, q) / det), (float)(u / det), (float)(v / det),
                    triangle->index};
}

RK_INLINE rk_hit final_hit(const best_hit *best, const rk_wide_bvh *wide, const rk_ray *ray)
{
    if (!(best->near < best->far))
        return (rk_hit){best->far, best->u, best->v, best->triangle};
    const rk_triangle triangle = triangle_at(wide, best->place);
    return certain_hit(&triangle, ray);
}

/* Where float cannot say which of two hits is closer, or whether there is one. */
static __attribute__((noinline)) void decide_exactly(best_hit *best, const rk_wide_bvh *wide,
                                                     uint32_t place, const rk_ray *ray)
{
    const rk_triangle triangle = triangle_at(wide, place);
    const rk_hit found = rk_watertight_intersect(&triangle, ray);
    if (found.triangle == RK_MISS)
        return;
    rk_hit hit = final_hit(best, wide, ray);
    if (found.t < hit.t || (found.t == hit.t && found.triangle < hit.triangle))
        hit = found;
    *best =
        (best_hit){.near = hit.t, .far = hit.t, .u = hit.u, .v = hit.v, .triangle = hit.triangle};
}

static __attribute__((noinline)) bool occludes_exactly(const rk_wide_bvh *wide, uint32_t place,
                                                       const rk_ray *ray)
{
    const rk_triangle triangle = triangle_at(wide, place);
    return rk_triangle_occludes(&triangle, ray);
}

typedef struct d4x3 {
    rk_d4 x, y, z;
} d4x3;

RK_INLINE d4x3 d4x3_corner(const rk_wide_block *block, int k)
{
    return (d4x3){rk_d4_widen(block->corner[k][0]), rk_d4_widen(block->corner[k][1]),
                  rk_d4_widen(block->corner[k][2])};
}

RK_INLINE d4x3 d4x3_sub(d4x3 a, d4x3 b)
{
    return (d4x3){rk_d4_sub(a.x, b.x), rk_d4_sub(a.y, b.y), rk_d4_sub(a.z, b.z)};
}

/* Rays that start on a triangle are so close to its plane that float cannot tell the side. Returns
 * the triangles that are certainly behind, of those through which the ray's line passes; `back`:
 * its direction and the triangle's normal point to the same side. */
static __attribute__((noinline)) uint32_t
behind_in_double(const rk_ray *ray, const rk_wide_block *block, uint32_t back)
{
    d4x3 a = d4x3_corner(block, 0);
    d4x3 ab = d4x3_sub(d4x3_corner(block, 1), a), ac = d4x3_sub(d4x3_corner(block, 2), a);
    d4x3 s = d4x3_sub((d4x3){rk_d4_all((double)ray->origin.x), rk_d4_all((double)ray->origin.y),
                             rk_d4_all((double)ray->origin.z)},
                      a);
    rk_d4 x = rk_d4_sub(rk_d4_mul(ab.y, ac.z), rk_d4_mul(ab.z, ac.y));
    rk_d4 y = rk_d4_sub(rk_d4_mul(ab.z, ac.x), rk_d4_mul(ab.x, ac.z));
    rk_d4 z = rk_d4_sub(rk_d4_mul(ab.x, ac.y), rk_d4_mul(ab.y, ac.x));
    rk_d4 t = rk_d4_add(rk_d4_add(rk_d4_mul(s.x, x), rk_d4_mul(s.y, y)), rk_d4_mul(s.z, z));
    rk_d4 reach = rk_d4_add(rk_d4_add(rk_d4_abs(s.x), rk_d4_abs(s.y)), rk_d4_abs(s.z));
    const double edge = (double)block->edge;
    rk_d4 bound = rk_d4_mul(rk_d4_add(reach, rk_d4_all(edge)), rk_d4_all(0x1p-48 * edge * edge));
    return (rk_d4_lt(t, rk_d4_sub(rk_d4_all(0), bound)) & ~back) | (rk_d4_lt(bound, t) & back);
}

/* --- In float --------------------------------------------------------------------------------- */

typedef rk_simd4x3 f4x3;

RK_INLINE f4x3 f4x3_corner(const rk_wide_block *block, int k)
{
    return (f4x3){rk_simd4_load(block->corner[k][0]), rk_simd4_load(block->corner[k][1]),
                  rk_simd4_load(block->corner[k][2])};
}

RK_INLINE f4x3 f4x3_cross(f4x3 a, f4x3 b)
{
    return (f4x3){rk_simd4_msub(a.y, b.z, a.z * b.y), rk_simd4_msub(a.z, b.x, a.x * b.z),
                  rk_simd4_msub(a.x, b.y, a.y * b.x)};
}

RK_INLINE rk_simd4 f4x3_dot(f4x3 a, f4x3 b)
{
    return rk_simd4_madd(a.x, b.x, rk_simd4_madd(a.y, b.y, a.z * b.z));
}

/* The places of a block that do not repeat the one before. */
RK_INLINE uint32_t taken_places(const rk_wide_block *block)
{
    const uint32_t *index = block->index;
    return 1 | (uint32_t)(index[1] != index[0]) << 1 | (uint32_t)(index[2] != index[1]) << 2 |
           (uint32_t)(index[3] != index[2]) << 3;
}

#endif
