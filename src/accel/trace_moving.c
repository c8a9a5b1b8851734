#include "accel/trace_moving.h"

#include "accel/packet.h"

/* Rays on their way to one object, as the object at rest sees them. Neighbours among the rays of a
 * batch go nearly the same way, so they are traced as a packet. */
typedef struct group {
    uint32_t count;
    uint32_t index[RK_PACKET_MAX]; /* in the batch */
    rk_ray rays[RK_PACKET_MAX];
} group;

/* True once the group is full. */
static bool add_ray(group *g, const rk_accel *accel, uint32_t object, const rk_ray_batch *rays,
                    const rk_ray_times *times, uint32_t i)
{
    rk_ray ray = rk_batch_ray(rays, i);
    g->index[g->count] = i;
    g->rays[g->count++] = rk_accel_ray_at(accel, object, times->time[i], &ray);
    return g->count == RK_PACKET_MAX;
}

static void closest_of_group(group *g, const rk_bvh *bvh, rk_hit_batch *hits, rk_counters *counters)
{
    rk_hit found[RK_PACKET_MAX];
    for (uint32_t i = 0; i < g->count; i++)
        g->rays[i].t_max = hits->t[g->index[i]];
    rk_packet_closest(bvh, g->rays, g->count, found, counters);
    for (uint32_t i = 0; i < g->count; i++) {
        uint32_t index = g->index[i];
        if (found[i].t < hits->t[index] || found[i].triangle < hits->triangle[index])
            rk_batch_put_hit(hits, index, &found[i]);
    }
    g->count = 0;
}

static void occlude_group(group *g, const rk_bvh *bvh, rk_occlusion_batch *answers,
                          rk_counters *counters)
{
    bool occluded_at[RK_PACKET_MAX];
    rk_packet_occluded(bvh, g->rays, g->count, occluded_at, counters);
    for (uint32_t i = 0; i < g->count; i++)
        answers->occluded[g->index[i]] = occluded_at[i];
    g->count = 0;
}

void rk_accel_closest_moving(const rk_accel *accel, const rk_ray_batch *rays,
                             const rk_ray_times *times, rk_hit_batch *hits, rk_counters *counters)
{
    for (uint32_t k = 0; k < accel->scene->moving_count; k++) {
        const rk_bvh *bvh = &accel->moving[k];
        group g = {.count = 0};
        for (uint32_t i = 0; i < rays->count; i++)
            if ((times->objects[i] >> k & 1) && add_ray(&g, accel, k, rays, times, i))
                closest_of_group(&g, bvh, hits, counters);
        if (g.count)
            closest_of_group(&g, bvh, hits, counters);
    }
}

void rk_accel_occluded_moving(const rk_accel *accel, const rk_ray_batch *rays,
                              const rk_ray_times *times, rk_occlusion_batch *answers,
                              rk_counters *counters)
{
    for (uint32_t k = 0; k < accel->scene->moving_count; k++) {
        const rk_bvh *bvh = &accel->moving[k];
        group g = {.count = 0};
        for (uint32_t i = 0; i < rays->count; i++)
            if ((times->objects[i] >> k & 1) && !answers->occluded[i] &&
                add_ray(&g, accel, k, rays, times, i))
                occlude_group(&g, bvh, answers, counters);
        if (g.count)
            occlude_group(&g, bvh, answers, counters);
    }
}
