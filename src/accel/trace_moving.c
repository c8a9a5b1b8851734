#include "accel/trace_moving.h"

#include "accel/packet.h"

/* Rays relative to one object. Neighbouring rays of a batch have nearly the same direction, so they
 * are traced as a packet. */
typedef struct packet {
    uint32_t count;
    uint32_t index[RK_PACKET_MAX]; /* in the batch */
    rk_ray rays[RK_PACKET_MAX];
} packet;

/* True if the packet is full now. */
static bool add_ray(packet *p, const rk_accel *accel, uint32_t object, const rk_ray_batch *rays,
                    const rk_ray_times *times, uint32_t i)
{
    rk_ray ray = rk_batch_ray(rays, i);
    p->index[p->count] = i;
    p->rays[p->count++] = rk_accel_ray_at(accel, object, times->time[i], &ray);
    return p->count == RK_PACKET_MAX;
}

static void closest_of_packet(packet *p, const rk_bvh *bvh, rk_hit_batch *hits,
                              rk_counters *counters)
{
    rk_hit closest[RK_PACKET_MAX];
    for (uint32_t i = 0; i < p->count; i++)
        p->rays[i].t_max = hits->t[p->index[i]];
    rk_packet_closest(bvh, p->rays, p->count, closest, counters);
    for (uint32_t i = 0; i < p->count; i++) {
        uint32_t index = p->index[i];
        if (closest[i].t < hits->t[index] || closest[i].triangle < hits->triangle[index])
            rk_batch_put_hit(hits, index, &closest[i]);
    }
    p->count = 0;
}

static void occlude_packet(packet *p, const rk_bvh *bvh, rk_occlusion_batch *answers,
                           rk_counters *counters)
{
    bool occluded[RK_PACKET_MAX];
    rk_packet_occluded(bvh, p->rays, p->count, occluded, counters);
    for (uint32_t i = 0; i < p->count; i++)
        answers->occluded[p->index[i]] = occluded[i];
    p->count = 0;
}

void rk_accel_closest_moving(const rk_accel *accel, const rk_ray_batch *rays,
                             const rk_ray_times *times, rk_hit_batch *hits, rk_counters *counters)
{
    for (uint32_t k = 0; k < accel->scene->moving_count; k++) {
        const rk_bvh *bvh = &accel->moving[k];
        packet p = {.count = 0};
        for (uint32_t i = 0; i < rays->count; i++)
            if ((times->objects[i] >> k & 1) && add_ray(&p, accel, k, rays, times, i))
                closest_of_packet(&p, bvh, hits, counters);
        if (p.count)
            closest_of_packet(&p, bvh, hits, counters);
    }
}

void rk_accel_occluded_moving(const rk_accel *accel, const rk_ray_batch *rays,
                              const rk_ray_times *times, rk_occlusion_batch *answers,
                              rk_counters *counters)
{
    for (uint32_t k = 0; k < accel->scene->moving_count; k++) {
        const rk_bvh *bvh = &accel->moving[k];
        packet p = {.count = 0};
        for (uint32_t i = 0; i < rays->count; i++)
            if ((times->objects[i] >> k & 1) && !answers->occluded[i] &&
                add_ray(&p, accel, k, rays, times, i))
                occlude_packet(&p, bvh, answers, counters);
        if (p.count)
            occlude_packet(&p, bvh, answers, counters);
    }
}
