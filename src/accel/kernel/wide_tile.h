/* A whole batch of rays from one point, such as a camera's tile, through the wide tree: its packets
 * go together, one in each lane. Included by one file for each instruction set
 * (accel/kernel/wide_trace.h); not installed. */
#ifndef RK_ACCEL_KERNEL_WIDE_TILE_H
#define RK_ACCEL_KERNEL_WIDE_TILE_H

#include "accel/kernel/wide_shafts.h"

enum {
    tile_packets = RK_BATCH_MAX / packet_rays,
    /* So many go on by themselves: the tile's shaft is too wide for them. */
    few_packets = 4,
};

/* The packets' shafts start at one point, so that only their speeds differ. */
typedef struct tile {
    shaft shaft; /* of all rays */
    const rk_ray_batch *rays;
    f16x3 origin;                 /* the point, in all lanes */
    f16x3 near, far;              /* near_inverse and far_inverse of each packet's shaft */
    float farthest[tile_packets]; /* see packet */
    float end;                    /* the highest t_max */
    float longest;                /* component of any direction */
    uint32_t filled;              /* packets whose rays are filled in */
    packet *packet;               /* tile_packets */
} tile;

/* Of sixteen packets, lane by lane. */
typedef struct tile_ranges {
    f16x3 low, high; /* directions */
    rk_f16 t_max;    /* the highest */
} tile_ranges;

RK_INLINE f16x3 origins_of(const rk_ray_batch *rays, uint32_t at)
{
    return (f16x3){rk_f16_load(&rays->origin_x[at]), rk_f16_load(&rays->origin_y[at]),
                   rk_f16_load(&rays->origin_z[at])};
}

RK_INLINE f16x3 directions_of(const rk_ray_batch *rays, uint32_t at)
{
    return (f16x3){rk_f16_load(&rays->direction_x[at]), rk_f16_load(&rays->direction_y[at]),
                   rk_f16_load(&rays->direction_z[at])};
}

/* Do all rays start at one point, and has each a t_max of 0 or more and a direction without NaN? */
RK_INLINE bool may_be_tile(const rk_ray_batch *rays)
{
    const rk_f16 x = rk_f16_all(rays->origin_x[0]), y = rk_f16_all(rays->origin_y[0]);
    const rk_f16 z = rk_f16_all(rays->origin_z[0]), zero = rk_f16_all(0);
    rk_f16 sum = zero; /* NaN where a direction is */
    for (uint32_t i = 0; i < RK_BATCH_MAX; i += packet_rays) {
        const f16x3 o = origins_of(rays, i);
        const f16x3 d = directions_of(rays, i);
        if (0xffff !=
            (rk_f16_le(o.x, x) & rk_f16_le(x, o.x) & rk_f16_le(o.y, y) & rk_f16_le(y, o.y) &
             rk_f16_le(o.z, z) & rk_f16_le(z, o.z) & rk_f16_le(zero, rk_f16_load(&rays->t_max[i]))))
            return false;
        sum = rk_f16_add(sum, rk_f16_add(d.x, rk_f16_add(d.y, d.z)));
    }
    return rk_f16_le(sum, sum) == 0xffff;
}

RK_INLINE tile_ranges ranges_of(const rk_ray_batch *rays)
{
    tile_ranges r = {directions_of(rays, 0), directions_of(rays, 0), rk_f16_load(rays->t_max)};
    for (uint32_t i = packet_rays; i < RK_BATCH_MAX; i += packet_rays) {
        const f16x3 d = directions_of(rays, i);
        r.low =
            (f16x3){rk_f16_min(d.x, r.low.x), rk_f16_min(d.y, r.low.y), rk_f16_min(d.z, r.low.z)};
        r.high = (f16x3){rk_f16_max(d.x, r.high.x), rk_f16_max(d.y, r.high.y),
                         rk_f16_max(d.z, r.high.z)};
        r.t_max = rk_f16_max(rk_f16_load(&rays->t_max[i]), r.t_max);
    }
    return r;
}

/* False if directions differ in a sign, or one is so close to 0 that its reciprocal overflows. */
RK_INLINE bool set_directions(tile *t, const lane_ranges *speeds)
{
    t->shaft.signs = 0;
    t->longest = 0;
    for (int k = 0; k < 3; k++) {
        const float least = speeds->low[k], most = speeds->high[k];
        if (!(least >= least_component || most <= -least_component))
            return false;
        t->shaft.signs |= (uint32_t)(most < 0) << k;
        t->longest = rk_max(t->longest, rk_max(most, -least));
    }
    return true;
}

/* False if these rays are none for a tile, or floats might overflow. Packets are not filled in yet.
 */
RK_INLINE bool start_tile(tile *t, const tree_extent *extent, const rk_ray_batch *rays)
{
    /* The last ray tells most batches of several points, without a look at all of them. */
    if (rays->count != RK_BATCH_MAX || rays->origin_x[0] != rays->origin_x[RK_BATCH_MAX - 1] ||
        !may_be_tile(rays))
        return false;
    const tile_ranges r = ranges_of(rays);
    const lane_ranges low = lane_ranges_of(r.low, r.t_max), high = lane_ranges_of(r.high, r.t_max);
    const lane_ranges speeds = {low.low, high.high};
    const rk_simd4 o = rk_simd4_of(rk_vec(rays->origin_x[0], rays->origin_y[0], rays->origin_z[0]));
    const rk_simd4 away = rk_simd4_max(o - extent->low, extent->high - o);
    const lane_ranges from = {o, o};
    if (!set_directions(t, &speeds) || !is_ordinary(away[0] + away[1] + away[2], t->longest))
        return false;
    set_shaft(&t->shaft, &from, &speeds);
    t->rays = rays;
    t->origin = (f16x3){rk_f16_all(o[0]), rk_f16_all(o[1]), rk_f16_all(o[2])};
    t->end = speeds.high[3];
    t->filled = 0;
    return true;
}

RK_INLINE void set_packets_shafts(tile *t)
{
    const rk_ray_batch *rays = t->rays;
    float near[3][tile_packets], far[3][tile_packets];
    const lane_ranges from = {t->shaft.near_origin, t->shaft.near_origin};
    for (uint32_t i = 0; i < tile_packets; i++) {
        const uint32_t at = i * packet_rays;
        packet *p = &t->packet[i];
        const lane_ranges speeds =
            lane_ranges_of(directions_of(rays, at), rk_f16_load(&rays->t_max[at]));
        p->shaft.signs = t->shaft.signs;
        set_shaft(&p->shaft, &from, &speeds);
        for (int k = 0; k < 3; k++) {
            near[k][i] = p->shaft.near_inverse[k];
            far[k][i] = p->shaft.far_inverse[k];
        }
        p->farthest = t->farthest[i] = speeds.high[3];
    }
    t->near = f16x3_load(near);
    t->far = f16x3_load(far);
}

/* A packet, ready to be traced: filled in when it is wanted first, as many never are. */
RK_INLINE packet *packet_of(tile *t, uint32_t i)
{
    packet *p = &t->packet[i];
    if (t->filled >> i & 1)
        return p;
    t->filled |= 1u << i;
    p->rays = t->rays;
    p->first = i * packet_rays;
    p->center = rk_simd4_vec(t->shaft.near_origin);
    p->size = 0;
    p->longest = t->longest;
    const sixteen lanes = load_sixteen(p->rays, p->first);
    fill_lanes(p, &lanes, 0xffff);
    return p;
}

/* The packets whose shafts enter a child; see lanes_that_enter. */
RK_INLINE uint32_t packets_that_enter(const tile *t, const rk_wide_bvh *wide, uint32_t box)
{
    const float *sides = &wide->nodes[box / RK_WIDE_CHILDREN].side[0][0][box % RK_WIDE_CHILDREN];
    const side_places *at = &sides_of_signs[t->shaft.signs];
    const f16x3 *o = &t->origin, *near = &t->near, *far = &t->far;
    rk_f16 enter = rk_f16_all(0), leave = rk_f16_load(t->farthest);
    enter = rk_f16_max(plane_hit(sides[at->near[0]], o->x, near->x), enter);
    leave = rk_f16_min(plane_hit(sides[at->far[0]], o->x, far->x), leave);
    enter = rk_f16_max(plane_hit(sides[at->near[1]], o->y, near->y), enter);
    leave = rk_f16_min(plane_hit(sides[at->far[1]], o->y, far->y), leave);
    enter = rk_f16_max(plane_hit(sides[at->near[2]], o->z, near->z), enter);
    leave = rk_f16_min(plane_hit(sides[at->far[2]], o->z, far->z), leave);
    return rk_f16_le(enter, leave);
}

/* Of all packets together, so that few rays of each fill registers with their pairs. */
RK_INLINE void visit_leaf_together(tile *t, const rk_wide_bvh *wide, uint32_t leaf, uint32_t box,
                                   uint32_t packets, pairs *q, work *done)
{
    for (uint32_t left = packets; left;) {
        packet *p = packet_of(t, next_bit(&left));
        const uint32_t lanes = lanes_that_enter(p, wide, box);
        if (!lanes)
            continue;
        visit_leaf(p, CLOSEST, wide, leaf, lanes, q);
        done->blocks += rk_wide_leaf_count(leaf);
    }
    test_pairs(q, CLOSEST, wide);
    while (packets) {
        const uint32_t i = next_bit(&packets);
        packet *p = &t->packet[i];
        p->farthest = t->farthest[i] = rk_f16_largest(rk_f16_load(p->far));
    }
}

RK_INLINE void go_on_alone(tile *t, const rk_wide_bvh *wide, uint32_t child, uint32_t packets,
                           mask_packets *flying, work *done)
{
    while (packets) {
        const uint32_t i = next_bit(&packets);
        packet *p = packet_of(t, i);
        trace_closest(p, wide, child, flying, done);
        t->farthest[i] = p->farthest;
    }
}

/* A tile that misses all of the root's children costs one node. Nothing is dropped from the stack
 * after hits: packets_that_enter leaves out packets whose hits are closer than the child. */
RK_INLINE void trace_tile(tile *t, const rk_wide_bvh *wide, mask_packets *flying, work *done)
{
    child_stack stack;
    uint32_t child;
    start_stack(&stack);
    done->nodes++;
    if (push_children(&stack, &t->shaft, wide, 0, t->end, true) == 0)
        return;
    set_packets_shafts(t);
    while ((child = pop(&stack)) != no_child) {
        const uint32_t box = stack.box[stack.size], packets = packets_that_enter(t, wide, box);
        fetch(wide, stack.child[stack.size - 1]); /* the one after it */
        if (!packets)
            continue;
        if (child & RK_WIDE_LEAF) {
            visit_leaf_together(t, wide, child, box, packets, &flying->pairs, done);
        } else if (__builtin_popcount(packets) <= few_packets) {
            go_on_alone(t, wide, child, packets, flying, done);
        } else {
            push_children(&stack, &t->shaft, wide, child, t->end, true);
            done->nodes++;
        }
    }
}

RK_INLINE void put_misses(const rk_ray_batch *rays, uint32_t first, rk_hit_batch *hits)
{
    rk_f16_store(&hits->t[first], rk_f16_load(&rays->t_max[first]));
    rk_f16_store(&hits->u[first], rk_f16_all(0));
    rk_f16_store(&hits->v[first], rk_f16_all(0));
    rk_put_words(&hits->triangle[first], RK_MISS, 0xffff);
}

#endif
