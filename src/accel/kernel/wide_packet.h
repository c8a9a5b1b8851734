/* Sixteen coherent rays together through the wide tree: boxes against a shaft that contains them,
 * triangles against all of them at once. Included by one file for each instruction set
 * (accel/kernel/wide_trace.h); not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_PACKET_H
#define RK_ACCEL_KERNEL_WIDE_PACKET_H

#include "accel/kernel/wide_single.h"

enum {
    packet_rays = 16,
    last_lanes = 2, /* so few hits are faster computed one by one */
};

typedef struct f16x3 {
    rk_f16 x, y, z;
} f16x3;

/* Rays whose directions have the same signs. */
typedef struct packet {
    shaft shaft;
    float start[3][packet_rays], inverse[3][packet_rays]; /* 1 / direction */
    f16x3 origin;                                         /* start, seen from the centre */
    f16x3 direction, moment;                              /* origin x direction */
    rk_vec3 center;
    float size, longest; /* at least those of any origin, and of any direction's components */
    float farthest;      /* no ray looks for hits beyond */
    uint32_t filled;     /* lanes with rays of the batch */
    uint32_t active;     /* lanes with rays that look for hits */
    uint32_t known;      /* lanes whose u, v and triangle are known; see best_hit */
    float near[packet_rays], far[packet_rays], u[packet_rays], v[packet_rays];
    uint32_t place[packet_rays], triangle[packet_rays];
    const rk_ray_batch *rays;
    uint32_t first; /* ray of the batch */
} packet;

/* Lanes that hold rays of the batch, from the `first` on. */
RK_INLINE uint32_t lanes_of(const rk_ray_batch *rays, uint32_t first)
{
    const uint32_t count = rays->count - first;
    return count < packet_rays ? (1u << count) - 1 : 0xffff;
}

RK_INLINE f16x3 f16x3_of(const float x[3][4], uint32_t i)
{
    return (f16x3){rk_f16_all(x[0][i]), rk_f16_all(x[1][i]), rk_f16_all(x[2][i])};
}

RK_INLINE f16x3 f16x3_load(const float x[3][packet_rays])
{
    return (f16x3){rk_f16_load(x[0]), rk_f16_load(x[1]), rk_f16_load(x[2])};
}

RK_INLINE void f16x3_store(float x[3][packet_rays], f16x3 a)
{
    rk_f16_store(x[0], a.x);
    rk_f16_store(x[1], a.y);
    rk_f16_store(x[2], a.z);
}

RK_INLINE rk_f16 f16x3_dot(f16x3 a, f16x3 b)
{
    return rk_f16_madd(a.x, b.x, rk_f16_madd(a.y, b.y, rk_f16_mul(a.z, b.z)));
}

RK_INLINE f16x3 f16x3_cross(f16x3 a, f16x3 b)
{
    return (f16x3){rk_f16_sub(rk_f16_mul(a.y, b.z), rk_f16_mul(a.z, b.y)),
                   rk_f16_sub(rk_f16_mul(a.z, b.x), rk_f16_mul(a.x, b.z)),
                   rk_f16_sub(rk_f16_mul(a.x, b.y), rk_f16_mul(a.y, b.x))};
}

RK_INLINE best_hit lane_best(const packet *p, uint32_t lane)
{
    return (best_hit){p->near[lane], p->far[lane],   p->u[lane],
                      p->v[lane],    p->place[lane], p->triangle[lane]};
}

RK_INLINE void set_lane_best(packet *p, uint32_t lane, const best_hit *best)
{
    p->near[lane] = best->near;
    p->far[lane] = best->far;
    p->u[lane] = best->u;
    p->v[lane] = best->v;
    p->place[lane] = best->place;
    p->triangle[lane] = best->triangle;
    p->known = (p->known & ~(1u << lane)) | (best->near < best->far ? 0u : 1u << lane);
}

/* --- Triangles -------------------------------------------------------------------------------- */

/* Of four triangles, seen from the centre, all that does not depend on the ray:
 *   u = ac . moment - direction . (ac x a)    det = -direction . normal
 *   v = direction . (ab x a) - ab . moment    t det = origin . normal - plane */
typedef struct prepared {
    float ab[3][4], ac[3][4], ab_a[3][4], ac_a[3][4], normal[3][4], plane[4], bound[4], t_bound[4];
} prepared;

RK_INLINE void put3(float to[3][4], f4x3 x)
{
    memcpy(to[0], &x.x, sizeof x.x);
    memcpy(to[1], &x.y, sizeof x.y);
    memcpy(to[2], &x.z, sizeof x.z);
}

RK_INLINE void prepare_block(prepared *t, const packet *p, const rk_wide_block *block)
{
    f4x3 corner = f4x3_corner(block, 0), a = rk_simd4x3_sub(corner, rk_simd4x3_all(p->center));
    f4x3 ab = rk_simd4x3_sub(f4x3_corner(block, 1), corner);
    f4x3 ac = rk_simd4x3_sub(f4x3_corner(block, 2), corner), normal = f4x3_cross(ab, ac);
    rk_simd4 plane = f4x3_dot(a, normal), reach = rk_simd4x3_size(a) + rk_simd4_all(p->size);
    rk_simd4 t_bound, bound = bounds_of(block->edge, reach, p->longest, &t_bound);
    put3(t->ab, ab);
    put3(t->ac, ac);
    put3(t->ab_a, f4x3_cross(ab, a));
    put3(t->ac_a, f4x3_cross(ac, a));
    put3(t->normal, normal);
    memcpy(t->plane, &plane, sizeof plane);
    memcpy(t->bound, &bound, sizeof bound);
    memcpy(t->t_bound, &t_bound, sizeof t_bound);
}

static __attribute__((noinline)) void decide_lane(packet *p, query kind, const rk_wide_bvh *wide,
                                                  uint32_t place, uint32_t lane)
{
    const rk_ray ray = rk_batch_ray(p->rays, p->first + lane);
    best_hit best = lane_best(p, lane);
    if (kind == CLOSEST) {
        decide_exactly(&best, wide, place, &ray);
        set_lane_best(p, lane, &best);
    } else if (occludes_exactly(wide, place, &ray)) {
        p->active &= ~(1u << lane);
    }
}

/* See behind_in_double; of one triangle, a bit for each lane. */
static __attribute__((noinline)) uint32_t lanes_behind(const packet *p, const rk_wide_bvh *wide,
                                                       uint32_t place, uint32_t lanes,
                                                       uint32_t back)
{
    const rk_triangle triangle = triangle_at(wide, place);
    const rk_dvec3 a = rk_widen(triangle.a), ab = rk_dmadd(rk_widen(triangle.b), a, -1);
    const rk_dvec3 ac = rk_dmadd(rk_widen(triangle.c), a, -1), normal = rk_dcross(ab, ac);
    const double edge = (double)wide->blocks[place / RK_WIDE_BLOCK].edge;
    uint32_t behind = 0;
    for (uint32_t lane = 0; lane < packet_rays; lane += 8) {
        const uint32_t at = p->first + lane;
        if (!(lanes >> lane & 0xff))
            continue;
        rk_d8 x = rk_d8_sub(rk_d8_widen(&p->rays->origin_x[at]), rk_d8_all(a.x));
        rk_d8 y = rk_d8_sub(rk_d8_widen(&p->rays->origin_y[at]), rk_d8_all(a.y));
        rk_d8 z = rk_d8_sub(rk_d8_widen(&p->rays->origin_z[at]), rk_d8_all(a.z));
        rk_d8 t = rk_d8_add(
            rk_d8_add(rk_d8_mul(x, rk_d8_all(normal.x)), rk_d8_mul(y, rk_d8_all(normal.y))),
            rk_d8_mul(z, rk_d8_all(normal.z)));
        rk_d8 reach = rk_d8_add(rk_d8_add(rk_d8_abs(x), rk_d8_abs(y)), rk_d8_abs(z));
        rk_d8 bound =
            rk_d8_mul(rk_d8_add(reach, rk_d8_all(edge)), rk_d8_all(0x1p-48 * edge * edge));
        const uint32_t minus = rk_d8_lt(t, rk_d8_sub(rk_d8_all(0), bound));
        const uint32_t plus = rk_d8_lt(bound, t), turned = back >> lane;
        behind |= ((minus & ~turned) | (plus & turned)) << lane;
    }
    return lanes & behind;
}

/* Of one triangle and sixteen rays; see `prepared`. */
typedef struct lane_determinants {
    rk_f16 u, v, w, det;
} lane_determinants;

RK_INLINE lane_determinants lane_determinants_of(const packet *p, const prepared *t, uint32_t i)
{
    const rk_f16 zero = rk_f16_all(0);
    lane_determinants d;
    d.u = rk_f16_sub(zero, f16x3_dot(p->direction, f16x3_of(t->ac_a, i)));
    d.v = f16x3_dot(p->direction, f16x3_of(t->ab_a, i));
    if (p->size > 0) { /* else all rays start at the centre, and their moments are 0 */
        d.u = rk_f16_add(d.u, f16x3_dot(p->moment, f16x3_of(t->ac, i)));
        d.v = rk_f16_sub(d.v, f16x3_dot(p->moment, f16x3_of(t->ab, i)));
    }
    d.det = rk_f16_sub(zero, f16x3_dot(p->direction, f16x3_of(t->normal, i)));
    d.w = rk_f16_sub(rk_f16_sub(d.det, d.u), d.v);
    return d;
}

RK_INLINE rk_f16 lane_t_of(const packet *p, const prepared *t, uint32_t i)
{
    return rk_f16_sub(f16x3_dot(p->origin, f16x3_of(t->normal, i)), rk_f16_all(t->plane[i]));
}

/* The lanes that may hit a triangle, and those that certainly pass through its front or back. */
typedef struct passes {
    uint32_t may, front, back;
    rk_f16 det; /* its size */
} passes;

RK_INLINE void hit_lanes(packet *p, query kind, const rk_wide_bvh *wide, const prepared *block,
                         uint32_t i, uint32_t place, const passes *pass)
{
    uint32_t may = pass->may & p->active;
    const uint32_t back = pass->back;
    const rk_f16 det = pass->det;
    const rk_f16 zero = rk_f16_all(0), bound = rk_f16_all(block->bound[i]);
    const rk_f16 t_bound = rk_f16_all(block->t_bound[i]), t_max = rk_f16_load(p->far);
    rk_f16 t = lane_t_of(p, block, i);
    t = rk_f16_select(back, rk_f16_sub(zero, t), t);
    rk_f16 near =
        rk_f16_mul(rk_f16_div(rk_f16_sub(t, t_bound), rk_f16_add(det, bound)), rk_f16_all(below_1));
    const uint32_t inside = may & (pass->front | back);
    may &= ~(inside & (rk_f16_lt(rk_f16_add(t, t_bound), zero) | rk_f16_lt(t_max, near)));
    const uint32_t ahead = may & inside & rk_f16_lt(rk_f16_all(least_t), near);
    if (ahead) {
        rk_f16 far = rk_f16_mul(rk_f16_div(rk_f16_add(t, t_bound), rk_f16_sub(det, bound)),
                                rk_f16_all(above_1));
        const uint32_t hits = ahead & (kind == OCCLUSION ? rk_f16_le(far, t_max)
                                                         : rk_f16_lt(far, rk_f16_load(p->near)));
        may &= ~hits;
        if (kind == OCCLUSION) {
            p->active &= ~hits;
        } else {
            rk_f16_put(p->near, near, hits);
            rk_f16_put(p->far, far, hits);
            rk_put_words(p->place, place, hits);
            p->known &= ~hits;
        }
    }
    const uint32_t close = may & inside & ~ahead;
    if (close)
        may &= ~lanes_behind(p, wide, place, close, back);
    while (may)
        decide_lane(p, kind, wide, place, next_bit(&may));
}

/* First all triangles, without a branch; then those that rays may hit. */
RK_INLINE void lanes_in_block(packet *p, query kind, const rk_wide_bvh *wide,
                              const rk_wide_block *block, uint32_t lanes)
{
    prepared t;
    passes pass[RK_WIDE_BLOCK];
    uint32_t some = 0;
    prepare_block(&t, p, block);
#pragma GCC unroll 4
    for (uint32_t i = 0; i < RK_WIDE_BLOCK; i++) {
        const rk_f16 bound = rk_f16_all(t.bound[i]), minus = rk_f16_all(-t.bound[i]);
        const lane_determinants d = lane_determinants_of(p, &t, i);
        const rk_f16 half_w = rk_f16_mul(d.w, rk_f16_all(part_of_w));
        rk_f16 lowest = rk_f16_min(d.u, rk_f16_min(d.v, half_w));
        rk_f16 highest = rk_f16_max(d.u, rk_f16_max(d.v, half_w));
        pass[i].det = rk_f16_abs(d.det);
        pass[i].may = lanes & ~(rk_f16_lt(lowest, minus) & rk_f16_lt(bound, highest));
        pass[i].front = rk_f16_lt(bound, lowest);
        pass[i].back = rk_f16_lt(highest, minus);
        some |= (uint32_t)(pass[i].may != 0) << i;
    }
    for (some &= taken_places(block); some;) {
        const uint32_t i = next_bit(&some);
        hit_lanes(p, kind, wide, &t, i, place_of(wide, block, i), &pass[i]);
    }
}

/* --- Filling in ------------------------------------------------------------------------------- */

/* Lowest and highest lane of four numbers. */
typedef struct lane_ranges {
    rk_simd4 low, high;
} lane_ranges;

/* Four lanes of which the smallest is that of all sixteen, and four for the largest. */
RK_INLINE void fold(rk_f16 a, rk_simd4 *low, rk_simd4 *high)
{
    float lane[packet_rays];
    rk_f16_store(lane, a);
    *low = *high = rk_simd4_load(lane);
    for (int i = 4; i < packet_rays; i += 4) {
        rk_simd4 four = rk_simd4_load(&lane[i]);
        *low = rk_simd4_min(four, *low);
        *high = rk_simd4_max(four, *high);
    }
}

RK_INLINE lane_ranges lane_ranges_of(f16x3 a, rk_f16 fourth)
{
    rk_simd4 low[4], high[4];
    fold(a.x, &low[0], &high[0]);
    fold(a.y, &low[1], &high[1]);
    fold(a.z, &low[2], &high[2]);
    fold(fourth, &low[3], &high[3]);
    rk_simd4_transpose(low);
    rk_simd4_transpose(high);
    return (lane_ranges){
        rk_simd4_min(rk_simd4_min(low[0], low[1]), rk_simd4_min(low[2], low[3])),
        rk_simd4_max(rk_simd4_max(high[0], high[1]), rk_simd4_max(high[2], high[3]))};
}

/* How far the rays go per t on each axis, at least and at most. No ray has a hit beyond t = end.
 * Between the boxes of the rays at t = 0 and at t = end, at t, each coordinate is from
 * low + t (end_low - low) / end to high + t (end_high - high) / end. */
RK_INLINE lane_ranges speeds_between(const lane_ranges *from, const lane_ranges *to, float end)
{
    const rk_simd4 per_t = rk_simd4_all(1 / end);
    /* More than the roundings of `to`, and of the differences. */
    rk_simd4 rounding = rk_simd4_max(rk_simd4_abs(from->low), rk_simd4_abs(from->high)) +
                        rk_simd4_max(rk_simd4_abs(to->low), rk_simd4_abs(to->high));
    rounding *= rk_simd4_all(0x1p-21f);
    return (lane_ranges){(to->low - from->low - rounding) * per_t,
                         (to->high - from->high + rounding) * per_t};
}

RK_INLINE void set_shaft(shaft *s, const lane_ranges *from, const lane_ranges *speeds)
{
    const rk_simd4_mask bits = {1, 2, 4, 8};
    const rk_simd4_mask minus = ((int32_t)s->signs & bits) != 0;
    const rk_simd4 zero = rk_simd4_all(0), low = speeds->low, high = speeds->high;
    s->near_origin = rk_simd4_select(minus, from->low, from->high);
    s->far_origin = rk_simd4_select(minus, from->high, from->low);
    /* No ray goes back, so the slower side stays where it is if rounding makes it do so. */
    set_speeds(s, rk_simd4_select(minus, low, high),
               rk_simd4_select(minus, -rk_simd4_max(-high, zero), rk_simd4_max(low, zero)));
}

/* Origins, directions and t_max of sixteen rays. */
typedef struct sixteen {
    f16x3 origin, direction;
    rk_f16 t_max;
} sixteen;

/* -0 becomes 0: its reciprocal has the sign of the others. */
RK_INLINE sixteen load_sixteen(const rk_ray_batch *rays, uint32_t first)
{
    const rk_f16 zero = rk_f16_all(0);
    return (sixteen){{rk_f16_load(&rays->origin_x[first]), rk_f16_load(&rays->origin_y[first]),
                      rk_f16_load(&rays->origin_z[first])},
                     {rk_f16_add(rk_f16_load(&rays->direction_x[first]), zero),
                      rk_f16_add(rk_f16_load(&rays->direction_y[first]), zero),
                      rk_f16_add(rk_f16_load(&rays->direction_z[first]), zero)},
                     rk_f16_load(&rays->t_max[first])};
}

/* Lanes that are not `active` become copies of the first that is. */
RK_INLINE rk_f16 copied(rk_f16 a, uint32_t active)
{
    return rk_f16_select(active, a, rk_f16_all(rk_f16_lane(a, __builtin_ctz(active))));
}

RK_INLINE void copy_lanes(sixteen *lanes, uint32_t active)
{
    lanes->origin = (f16x3){copied(lanes->origin.x, active), copied(lanes->origin.y, active),
                            copied(lanes->origin.z, active)};
    lanes->direction =
        (f16x3){copied(lanes->direction.x, active), copied(lanes->direction.y, active),
                copied(lanes->direction.z, active)};
    lanes->t_max = copied(lanes->t_max, active);
}

/* Do all rays have the same origin? */
RK_INLINE bool start_together(f16x3 origin)
{
    const rk_f16 x = rk_f16_all(rk_f16_lane(origin.x, 0)), y = rk_f16_all(rk_f16_lane(origin.y, 0));
    const rk_f16 z = rk_f16_all(rk_f16_lane(origin.z, 0));
    return !(rk_f16_lt(x, origin.x) | rk_f16_lt(origin.x, x) | rk_f16_lt(y, origin.y) |
             rk_f16_lt(origin.y, y) | rk_f16_lt(z, origin.z) | rk_f16_lt(origin.z, z));
}

RK_INLINE uint32_t tiny_lanes(rk_f16 a)
{
    const rk_f16 size = rk_f16_abs(a);
    return rk_f16_lt(size, rk_f16_all(least_component)) & rk_f16_lt(rk_f16_all(0), size);
}

/* Others would spoil the bounds of all. */
RK_INLINE uint32_t ordinary_lanes(const sixteen *lanes)
{
    const f16x3 d = lanes->direction;
    return rk_f16_le(rk_f16_all(0), lanes->t_max) &
           ~(tiny_lanes(d.x) | tiny_lanes(d.y) | tiny_lanes(d.z));
}

/* All that does not depend on the shaft, once the centre is known. */
RK_INLINE void fill_lanes(packet *p, const sixteen *lanes, uint32_t active)
{
    const f16x3 o = lanes->origin, d = lanes->direction;
    const rk_f16 one = rk_f16_all(1);
    f16x3_store(p->start, o);
    f16x3_store(p->inverse,
                (f16x3){rk_f16_div(one, d.x), rk_f16_div(one, d.y), rk_f16_div(one, d.z)});
    p->origin =
        (f16x3){rk_f16_sub(o.x, rk_f16_all(p->center.x)), rk_f16_sub(o.y, rk_f16_all(p->center.y)),
                rk_f16_sub(o.z, rk_f16_all(p->center.z))};
    p->direction = d;
    p->moment = f16x3_cross(p->origin, d);
    p->filled = p->active = active;
    p->known = 0xffff;
    rk_f16_store(p->near, lanes->t_max);
    rk_f16_store(p->far, lanes->t_max);
    rk_f16_store(p->u, rk_f16_all(0));
    rk_f16_store(p->v, rk_f16_all(0));
    rk_put_words(p->triangle, RK_MISS, 0xffff);
}

/* Of ordinary lanes. False if floats might overflow. The shaft, except its signs, is left out if it
 * is not wanted. */
RK_INLINE bool fill_packet(packet *p, const tree_extent *extent, sixteen lanes, uint32_t signs,
                           uint32_t active, bool with_shaft)
{
    if (active != 0xffff)
        copy_lanes(&lanes, active);
    const f16x3 o = lanes.origin, d = lanes.direction;
    const rk_f16 x = rk_f16_abs(d.x), y = rk_f16_abs(d.y), z = rk_f16_abs(d.z);
    const rk_f16 longest = rk_f16_max(x, rk_f16_max(y, z));
    /* Lowest and highest component of directions in the fourth lane. */
    lane_ranges from, speeds;
    const bool is_point = start_together(o);
    if (is_point) {
        speeds = lane_ranges_of(d, longest);
        from.low = from.high =
            rk_simd4_of(rk_vec(rk_f16_lane(o.x, 0), rk_f16_lane(o.y, 0), rk_f16_lane(o.z, 0)));
        from.low[3] = speeds.low[3];
        from.high[3] = speeds.high[3];
    } else {
        from = lane_ranges_of(o, longest);
    }
    rk_simd4 away = rk_simd4_max(from.high - extent->low, extent->high - from.low);
    rk_simd4 wide = from.high - from.low, center = rk_simd4_all(0.5f) * (from.low + from.high);
    const float reach = away[0] + away[1] + away[2];
    p->size = wide[0] + wide[1] + wide[2];
    p->longest = from.high[3];
    p->center = rk_simd4_vec(center);
    if (!is_ordinary(reach + p->size, p->longest))
        return false;
    p->farthest = rk_f16_largest(lanes.t_max);
    if (with_shaft && !is_point) {
        /* On its longest axis each ray is out of the tree by then. */
        const float out = rk_max(away[0], rk_max(away[1], away[2])) / from.low[3];
        const float end = (p->farthest < out ? p->farthest : out) * 1.0001f;
        if (!(end > 0x1p-60f && end < 0x1p60f))
            return false;
        const rk_f16 at = rk_f16_all(end);
        const lane_ranges to =
            lane_ranges_of((f16x3){rk_f16_madd(at, d.x, o.x), rk_f16_madd(at, d.y, o.y),
                                   rk_f16_madd(at, d.z, o.z)},
                           longest);
        speeds = speeds_between(&from, &to, end);
    }
    p->shaft.signs = signs;
    if (with_shaft)
        set_shaft(&p->shaft, &from, &speeds);
    fill_lanes(p, &lanes, active);
    return true;
}

/* --- Hits ------------------------------------------------------------------------------------- */

typedef struct d8x3 {
    rk_d8 x, y, z;
} d8x3;

RK_INLINE d8x3 d8x3_widen(const float *x, const float *y, const float *z)
{
    return (d8x3){rk_d8_widen(x), rk_d8_widen(y), rk_d8_widen(z)};
}

RK_INLINE d8x3 d8x3_sub(d8x3 a, d8x3 b)
{
    return (d8x3){rk_d8_sub(a.x, b.x), rk_d8_sub(a.y, b.y), rk_d8_sub(a.z, b.z)};
}

RK_INLINE d8x3 d8x3_cross(d8x3 a, d8x3 b)
{
    return (d8x3){rk_d8_sub(rk_d8_mul(a.y, b.z), rk_d8_mul(a.z, b.y)),
                  rk_d8_sub(rk_d8_mul(a.z, b.x), rk_d8_mul(a.x, b.z)),
                  rk_d8_sub(rk_d8_mul(a.x, b.y), rk_d8_mul(a.y, b.x))};
}

RK_INLINE rk_d8 d8x3_dot(d8x3 a, d8x3 b)
{
    return rk_d8_add(rk_d8_add(rk_d8_mul(a.x, b.x), rk_d8_mul(a.y, b.y)), rk_d8_mul(a.z, b.z));
}

RK_INLINE d8x3 d8x3_all(rk_vec3 a)
{
    return (d8x3){rk_d8_all((double)a.x), rk_d8_all((double)a.y), rk_d8_all((double)a.z)};
}

/* The triangles of eight lanes; on large ones they are all the same. */
RK_INLINE void corners_of(d8x3 corner[3], const packet *p, const rk_wide_bvh *wide, uint32_t lane,
                          uint32_t wanted)
{
    const uint32_t *place = &p->place[lane], same = place[__builtin_ctz(wanted)];
    uint32_t differences = 0;
    float x[3][3][8] = {{{0}}};
    for (uint32_t i = 0; i < 8; i++)
        differences |= wanted >> i & 1 ? place[i] ^ same : 0;
    if (!differences) {
        const rk_triangle triangle = triangle_at(wide, same);
        corner[0] = d8x3_all(triangle.a);
        corner[1] = d8x3_all(triangle.b);
        corner[2] = d8x3_all(triangle.c);
        return;
    }
    for (uint32_t left = wanted; left;) {
        const uint32_t i = next_bit(&left);
        const rk_wide_block *block = &wide->blocks[place[i] / RK_WIDE_BLOCK];
        for (int k = 0; k < 3; k++)
            for (int axis = 0; axis < 3; axis++)
                x[k][axis][i] = block->corner[k][axis][place[i] % RK_WIDE_BLOCK];
    }
    for (int k = 0; k < 3; k++)
        corner[k] = d8x3_widen(x[k][0], x[k][1], x[k][2]);
}

/* certain_hit of eight lanes. */
RK_INLINE void finish_eight(packet *p, const rk_wide_bvh *wide, uint32_t lane, uint32_t wanted)
{
    const rk_ray_batch *rays = p->rays;
    const uint32_t at = p->first + lane;
    d8x3 origin = d8x3_widen(&rays->origin_x[at], &rays->origin_y[at], &rays->origin_z[at]);
    d8x3 direction =
        d8x3_widen(&rays->direction_x[at], &rays->direction_y[at], &rays->direction_z[at]);
    d8x3 corner[3];
    corners_of(corner, p, wide, lane, wanted);
    d8x3 a = corner[0], ab = d8x3_sub(corner[1], a), ac = d8x3_sub(corner[2], a);
    d8x3 s = d8x3_sub(origin, a), cross = d8x3_cross(direction, ac), q = d8x3_cross(s, ab);
    rk_d8 u = d8x3_dot(s, cross), v = d8x3_dot(direction, q);
    rk_d8 w = rk_d8_sub(rk_d8_sub(d8x3_dot(ab, cross), u), v), t = d8x3_dot(ac, q);
    rk_d8 det = rk_d8_add(rk_d8_add(u, v), w);
    rk_d8_narrow(&p->far[lane], rk_d8_div(t, det), wanted);
    rk_d8_narrow(&p->u[lane], rk_d8_div(u, det), wanted);
    rk_d8_narrow(&p->v[lane], rk_d8_div(v, det), wanted);
    for (uint32_t left = wanted; left;) {
        const uint32_t i = lane + next_bit(&left), place = p->place[i];
        p->triangle[i] = wide->blocks[place / RK_WIDE_BLOCK].index[place % RK_WIDE_BLOCK];
    }
}

RK_INLINE void put_each_hit(const packet *p, const rk_wide_bvh *wide, rk_hit_batch *hits)
{
    for (uint32_t left = p->filled; left;) {
        const uint32_t lane = next_bit(&left), at = p->first + lane;
        const rk_ray ray = rk_batch_ray(p->rays, at);
        const best_hit best = lane_best(p, lane);
        const rk_hit hit = final_hit(&best, wide, &ray);
        rk_batch_put_hit(hits, at, &hit);
    }
}

RK_INLINE void put_hits(packet *p, const rk_wide_bvh *wide, rk_hit_batch *hits)
{
    const uint32_t lanes = p->filled, wanted = lanes & ~p->known;
    if (__builtin_popcount(lanes) <= last_lanes) {
        put_each_hit(p, wide, hits);
        return;
    }
    for (uint32_t lane = 0; lane < packet_rays; lane += 8)
        if (wanted >> lane & 0xff)
            finish_eight(p, wide, lane, wanted >> lane & 0xff);
    rk_f16_put(&hits->t[p->first], rk_f16_load(p->far), lanes);
    rk_f16_put(&hits->u[p->first], rk_f16_load(p->u), lanes);
    rk_f16_put(&hits->v[p->first], rk_f16_load(p->v), lanes);
    rk_put_each(&hits->triangle[p->first], p->triangle, lanes);
}

RK_INLINE void put_answers(const packet *p, rk_occlusion_batch *answers)
{
    bool *occluded = &answers->occluded[p->first];
    uint32_t lanes = p->filled;
    if (lanes == 0xffff)
        for (uint32_t i = 0; i < packet_rays; i++)
            occluded[i] = !(p->active >> i & 1);
    else
        while (lanes) {
            const uint32_t i = next_bit(&lanes);
            occluded[i] = !(p->active >> i & 1);
        }
}

#endif
