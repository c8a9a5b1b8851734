#include "accel/packet.h"

#include "accel/simd4.h"
#include "features/bvh_median.h"

/* --- Rays ------------------------------------------------------------------------------------- */

typedef struct packet {
    rk_lanes3 origin, direction;
    rk_lanes3 inverse_near, inverse_far; /* see rk_slabs */
    int near_x, near_y, near_z;          /* the same for all rays */
    rk_lanes t_max;                      /* nearest hits so far; negative: is done */
    rk_hit hits[RK_PACKET_MAX];
} packet;

/* Lanes without a ray are copies of the first, and done. */
static void put_ray(packet *p, uint32_t lane, const rk_ray *ray, const rk_slabs *slabs)
{
    rk_lanes3_put(&p->origin, lane, ray->origin);
    rk_lanes3_put(&p->direction, lane, ray->direction);
    rk_lanes3_put(&p->inverse_near, lane, slabs->inverse_near);
    rk_lanes3_put(&p->inverse_far, lane, slabs->inverse_far);
    p->t_max[lane] = -1;
}

/* False if the rays' directions differ in a sign: then they meet boxes at different corners. */
static bool fill(packet *p, const rk_ray *rays, uint32_t count)
{
    const rk_slabs first = rk_slabs_of(&rays[0]);
    p->near_x = first.near_x;
    p->near_y = first.near_y;
    p->near_z = first.near_z;
    for (uint32_t i = 0; i < RK_PACKET_MAX; i++)
        put_ray(p, i, &rays[0], &first);
    for (uint32_t i = 0; i < count; i++) {
        const rk_slabs slabs = rk_slabs_of(&rays[i]);
        if (slabs.near_x != first.near_x || slabs.near_y != first.near_y ||
            slabs.near_z != first.near_z)
            return false;
        put_ray(p, i, &rays[i], &slabs);
        p->t_max[i] = rays[i].t_max;
        p->hits[i] = (rk_hit){rays[i].t_max, 0, 0, RK_MISS};
    }
    return true;
}

/* --- Tests ------------------------------------------------------------------------------------ */

/* As rk_box_enter. */
static inline rk_lanes enter_box(const packet *p, const rk_box *box)
{
    const rk_vec3 *corner = box->corner;
    const rk_vec3 near = {corner[p->near_x].x, corner[p->near_y].y, corner[p->near_z].z};
    const rk_vec3 far = {corner[1 - p->near_x].x, corner[1 - p->near_y].y, corner[1 - p->near_z].z};
    rk_lanes3 to_near = rk_lanes3_sub(rk_lanes3_all(near), p->origin);
    rk_lanes3 to_far = rk_lanes3_sub(rk_lanes3_all(far), p->origin);
    rk_lanes enter =
        rk_lanes_max(to_near.x * p->inverse_near.x,
                     rk_lanes_max(to_near.y * p->inverse_near.y,
                                  rk_lanes_max(to_near.z * p->inverse_near.z, rk_lanes_all(0))));
    rk_lanes leave =
        rk_lanes_min(to_far.x * p->inverse_far.x,
                     rk_lanes_min(to_far.y * p->inverse_far.y,
                                  rk_lanes_min(to_far.z * p->inverse_far.z, p->t_max)));
    return rk_lanes_choose(enter <= leave, enter, rk_lanes_all(INFINITY));
}

typedef struct crossing {
    rk_lanes t, u, v;
} crossing;

/* As rk_triangle_cross: sets a bit for each ray that crosses the triangle no farther than t_max. */
static inline uint32_t cross_triangle(const packet *p, const rk_triangle *triangle, crossing *cross)
{
    const rk_lanes zero = rk_lanes_all(0), one = rk_lanes_all(1);
    rk_lanes3 edge_ab = rk_lanes3_all(triangle->edge_ab);
    rk_lanes3 edge_ac = rk_lanes3_all(triangle->edge_ac);
    rk_lanes3 across = rk_lanes3_cross(p->direction, edge_ac);
    rk_lanes det = rk_lanes3_dot(edge_ab, across);
    rk_lanes sign = rk_lanes_choose(det < zero, -one, one);
    det *= sign;
    rk_lanes3 s = rk_lanes3_scale(rk_lanes3_sub(p->origin, rk_lanes3_all(triangle->a)), sign);
    rk_lanes u_det = rk_lanes3_dot(s, across);
    rk_lane_mask inside = (u_det >= zero) & (u_det <= det);
    if (!rk_lanes_set(inside))
        return 0;
    rk_lanes3 q = rk_lanes3_cross(s, edge_ab);
    rk_lanes v_det = rk_lanes3_dot(p->direction, q);
    inside &= (v_det >= zero) & (u_det + v_det <= det);
    if (!rk_lanes_set(inside))
        return 0;
    *cross = (crossing){rk_lanes3_dot(edge_ac, q) / det, u_det / det, v_det / det};
    return rk_lanes_set(inside & (cross->t > zero) & (cross->t < rk_lanes_all(INFINITY)) &
                        (cross->t <= p->t_max));
}

/* --- Down the tree ---------------------------------------------------------------------------- */

typedef enum question { CLOSEST, ANY } question;

/* At the same t the smaller index wins, as everywhere. */
static inline void take(packet *p, question what, uint32_t lane, const rk_hit *hit)
{
    const rk_hit *best = &p->hits[lane];
    if (hit->t < best->t || hit->triangle < best->triangle) {
        p->hits[lane] = *hit;
        p->t_max[lane] = what == ANY ? -1 : hit->t;
    }
}

static inline void meet_leaf(packet *p, question what, const rk_triangle *triangles, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        crossing cross;
        uint32_t crossed = cross_triangle(p, &triangles[i], &cross);
        for (uint32_t lane = 0; crossed; lane++, crossed >>= 1)
            if (crossed & 1)
                take(p, what, lane,
                     &(rk_hit){cross.t[lane], cross.u[lane], cross.v[lane], triangles[i].index});
    }
}

/* Nodes still to be visited, and where each ray enters their boxes. */
typedef struct waiting_list {
    uint32_t size;
    const rk_bvh_node *nodes[RK_BVH_LEVELS_MAX];
    rk_lanes enter[RK_BVH_LEVELS_MAX];
} waiting_list;

static inline uint32_t entered(rk_lanes enter)
{
    return rk_lanes_set(enter < rk_lanes_all(INFINITY));
}

/* Of the two children the one to go to, NULL if no ray enters either; the other has to wait if any
 * does. */
static inline const rk_bvh_node *nearer_child(waiting_list *list, const packet *p,
                                              const rk_bvh_node *children)
{
    rk_lanes left = enter_box(p, &children[0].box), right = enter_box(p, &children[1].box);
    uint32_t in_left = entered(left), in_right = entered(right);
    if (!in_left || !in_right)
        return in_left ? &children[0] : in_right ? &children[1] : NULL;
    /* The first ray that enters any decides for all. */
    uint32_t in_any = in_left | in_right, first = in_any & (0 - in_any);
    bool right_first = (rk_lanes_set(right < left) & first) != 0;
    list->nodes[list->size] = &children[right_first ? 0 : 1];
    list->enter[list->size++] = right_first ? left : right;
    return &children[right_first ? 1 : 0];
}

static inline const rk_bvh_node *next_waiting(waiting_list *list, const packet *p)
{
    while (list->size) {
        rk_lanes enter = list->enter[--list->size];
        if (rk_lanes_set((enter <= p->t_max) & (enter < rk_lanes_all(INFINITY))))
            return list->nodes[list->size];
    }
    return NULL;
}

__attribute__((always_inline)) static inline void walk(packet *p, question what, const rk_bvh *bvh,
                                                       rk_counters *counters)
{
    waiting_list list;
    list.size = 0;
    uint64_t box_tests = 1, triangle_tests = 0;
    const rk_bvh_node *root = &bvh->nodes[0];
    const rk_bvh_node *node = entered(enter_box(p, &root->box)) ? root : NULL;
    while (node) {
        const rk_bvh_node *next = NULL;
        if (node->count == 0) {
            next = nearer_child(&list, p, &bvh->nodes[node->first]);
            box_tests += 2;
        }
        meet_leaf(p, what, &bvh->triangles[node->first], node->count);
        triangle_tests += node->count;
        node = next ? next : next_waiting(&list, p);
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
        walk(&p, CLOSEST, bvh, counters);
    for (uint32_t i = 0; i < count; i++)
        hits[i] = together ? p.hits[i] : rk_bvh_closest(bvh, &rays[i], counters);
}

void rk_packet_any(const rk_bvh *bvh, const rk_ray *rays, uint32_t count, bool *found,
                   rk_counters *counters)
{
    packet p;
    bool together = count > 1 && bvh->node_count > 0 && fill(&p, rays, count);
    if (together)
        walk(&p, ANY, bvh, counters);
    for (uint32_t i = 0; i < count; i++)
        found[i] = together ? p.hits[i].triangle != RK_MISS : rk_bvh_any(bvh, &rays[i], counters);
}
