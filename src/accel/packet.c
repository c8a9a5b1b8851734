#include "accel/packet.h"

#include "accel/stand_in_tree.h"
#include "base/simd4.h"

/* --- Rays ------------------------------------------------------------------------------------- */

typedef struct packet {
    rk_simd4x3 origin, direction;
    rk_simd4x3 inverse_near, inverse_far; /* see rk_slabs */
    int near_x, near_y, near_z;           /* the same for all rays */
    rk_simd4 t_max;                       /* of the nearest hits so far; negative: done */
    rk_simd4 longest;                     /* of the direction's components */
    rk_ray rays[RK_PACKET_MAX];
    rk_hit hits[RK_PACKET_MAX];
} packet;

/* Lanes without a ray are copies of the first ray, and done. */
static void put_ray(packet *p, uint32_t lane, const rk_ray *ray, const rk_slabs *slabs)
{
    rk_simd4x3_put(&p->origin, lane, ray->origin);
    rk_simd4x3_put(&p->direction, lane, ray->direction);
    rk_simd4x3_put(&p->inverse_near, lane, rk_simd4_vec(slabs->inverse_near));
    rk_simd4x3_put(&p->inverse_far, lane, rk_simd4_vec(slabs->inverse_far));
    p->longest[lane] = rk_watertight_longest(ray);
    p->t_max[lane] = -1;
    p->rays[lane] = *ray;
}

/* False if the rays' directions differ in a sign: then they enter boxes at different corners. */
static bool fill(packet *p, const rk_ray *rays, uint32_t count)
{
    const rk_slabs first = rk_slabs_of(&rays[0]);
    p->near_x = -first.is_backward[0];
    p->near_y = -first.is_backward[1];
    p->near_z = -first.is_backward[2];
    for (uint32_t i = 0; i < RK_PACKET_MAX; i++)
        put_ray(p, i, &rays[0], &first);
    for (uint32_t i = 0; i < count; i++) {
        const rk_slabs slabs = rk_slabs_of(&rays[i]);
        if (rk_simd4_movemask(slabs.is_backward ^ first.is_backward))
            return false;
        put_ray(p, i, &rays[i], &slabs);
        p->t_max[i] = rays[i].t_max;
        p->hits[i] = (rk_hit){rays[i].t_max, 0, 0, RK_MISS};
    }
    return true;
}

/* --- Tests ------------------------------------------------------------------------------------ */

/* See rk_box_enter. */
static inline rk_simd4 enter_box(const packet *p, const rk_box *box)
{
    const rk_vec3 *corner = box->corner;
    const rk_vec3 near = {corner[p->near_x].x, corner[p->near_y].y, corner[p->near_z].z};
    const rk_vec3 far = {corner[1 - p->near_x].x, corner[1 - p->near_y].y, corner[1 - p->near_z].z};
    rk_simd4x3 to_near = rk_simd4x3_sub(rk_simd4x3_all(near), p->origin);
    rk_simd4x3 to_far = rk_simd4x3_sub(rk_simd4x3_all(far), p->origin);
    rk_simd4 enter =
        rk_simd4_max(to_near.x * p->inverse_near.x,
                     rk_simd4_max(to_near.y * p->inverse_near.y,
                                  rk_simd4_max(to_near.z * p->inverse_near.z, rk_simd4_all(0))));
    rk_simd4 leave =
        rk_simd4_min(to_far.x * p->inverse_far.x,
                     rk_simd4_min(to_far.y * p->inverse_far.y,
                                  rk_simd4_min(to_far.z * p->inverse_far.z, p->t_max)));
    return rk_simd4_select(enter <= leave, enter, rk_simd4_all(INFINITY));
}

/* Sets a bit for each ray that may hit the triangle; see may_hit in features/watertight.c. */
static inline uint32_t may_hit(const packet *p, const rk_triangle *triangle)
{
    rk_simd4x3 a = rk_simd4x3_all(triangle->a);
    rk_simd4x3 ab = rk_simd4x3_sub(rk_simd4x3_all(triangle->b), a);
    rk_simd4x3 ac = rk_simd4x3_sub(rk_simd4x3_all(triangle->c), a);
    rk_simd4x3 s = rk_simd4x3_sub(p->origin, a);
    return rk_watertight_may_hit(s, p->direction, p->longest, p->t_max, ab, ac);
}

/* --- Traversal -------------------------------------------------------------------------------- */

typedef enum query_kind { CLOSEST, OCCLUSION } query_kind;

static inline void intersect_leaf(packet *p, query_kind kind, const rk_triangle *triangles,
                                  uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        uint32_t may = may_hit(p, &triangles[i]);
        for (uint32_t lane = 0; may; lane++, may >>= 1)
            if ((may & 1) && p->t_max[lane] >= 0 &&
                rk_triangle_closest(&triangles[i], &p->rays[lane], &p->hits[lane]))
                p->t_max[lane] = kind == OCCLUSION ? -1 : p->hits[lane].t;
    }
}

/* The siblings that were left aside on the way down from the root, and where each ray enters them.
 */
typedef struct way_down {
    uint32_t depth;
    const rk_bvh_node *siblings[RK_BVH_LEVELS_MAX];
    rk_simd4 enter[RK_BVH_LEVELS_MAX];
} way_down;

static inline uint32_t rays_entering(rk_simd4 enter)
{
    return rk_simd4_movemask(enter < rk_simd4_all(INFINITY));
}

/* Goes down to a leaf, on the side of the first ray that enters either child. NULL where no ray
 * enters. */
__attribute__((always_inline)) static inline const rk_bvh_node *
leaf_below(way_down *way, const packet *p, const rk_bvh_node *all, const rk_bvh_node *node,
           uint64_t *box_tests)
{
    while (node && node->count == 0) {
        const rk_bvh_node *pair = &all[node->first];
        rk_simd4 enter[2] = {enter_box(p, &pair[0].box), enter_box(p, &pair[1].box)};
        uint32_t in_0 = rays_entering(enter[0]), in_1 = rays_entering(enter[1]),
                 in_any = in_0 | in_1;
        *box_tests += 2;
        uint32_t side = in_0 == 0;
        if (in_0 && in_1) {
            side = (rk_simd4_movemask(enter[1] < enter[0]) & in_any & (0 - in_any)) != 0;
            way->siblings[way->depth] = &pair[1 - side];
            way->enter[way->depth++] = side ? enter[0] : enter[1];
        }
        node = in_any ? &pair[side] : NULL;
    }
    return node;
}

/* The deepest sibling that a ray still enters before its nearest hit; NULL if there is none. */
static inline const rk_bvh_node *sibling_above(way_down *way, const packet *p)
{
    while (way->depth > 0) {
        rk_simd4 enter = way->enter[--way->depth];
        if (rays_entering(rk_simd4_select(enter <= p->t_max, enter, rk_simd4_all(INFINITY))))
            return way->siblings[way->depth];
    }
    return NULL;
}

__attribute__((always_inline)) static inline void traverse(packet *p, query_kind kind,
                                                           const rk_bvh *bvh, rk_counters *counters)
{
    way_down way;
    way.depth = 0;
    uint64_t box_tests = 1, triangle_tests = 0;
    const rk_bvh_node *node = bvh->nodes;
    if (!rays_entering(enter_box(p, &node->box)))
        node = NULL;
    for (; node; node = sibling_above(&way, p)) {
        const rk_bvh_node *leaf = leaf_below(&way, p, bvh->nodes, node, &box_tests);
        if (leaf) {
            intersect_leaf(p, kind, &bvh->triangles[leaf->first], leaf->count);
            triangle_tests += leaf->count;
        }
    }
    counters->box_tests += box_tests;
    counters->triangle_tests += triangle_tests;
}

void rk_packet_closest(const rk_bvh *bvh, const rk_ray *rays, uint32_t count, rk_hit *hits,
                       rk_counters *counters)
{
    packet p;
    bool together = count > 1 && bvh->node_count > 0 && fill(&p, rays, count);
    if (together)
        traverse(&p, CLOSEST, bvh, counters);
    for (uint32_t i = 0; i < count; i++)
        hits[i] = together ? p.hits[i] : rk_tree_closest(bvh, &rays[i], counters);
}

void rk_packet_occluded(const rk_bvh *bvh, const rk_ray *rays, uint32_t count, bool *occluded,
                        rk_counters *counters)
{
    packet p;
    bool together = count > 1 && bvh->node_count > 0 && fill(&p, rays, count);
    if (together)
        traverse(&p, OCCLUSION, bvh, counters);
    for (uint32_t i = 0; i < count; i++)
        occluded[i] =
            together ? p.hits[i].triangle != RK_MISS : rk_tree_occluded(bvh, &rays[i], counters);
}
