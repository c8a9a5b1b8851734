/* For each object, the rays that may hit it are moved by its offset at their times, and traced
 * together through its tree. */
#include "accel/query/trace_moving.h"

#include "accel/query/tree.h"

/* The rays of a batch that may hit one object, relative to it. */
typedef struct moved_rays {
    rk_ray_batch rays;
    uint32_t index[RK_BATCH_MAX]; /* in the batch */
} moved_rays;

static void add_moved(moved_rays *moved, const rk_accel *accel, uint32_t object,
                      const rk_ray_batch *rays, const rk_ray_times *times, uint32_t i, float t_max)
{
    const rk_ray ray = rk_batch_ray(rays, i);
    rk_ray relative = rk_accel_ray_at(accel, object, times->time[i], &ray);
    relative.t_max = t_max;
    moved->index[moved->rays.count] = i;
    rk_batch_push(&moved->rays, &relative);
}

static void closest_in_object(const rk_accel *accel, uint32_t object, const rk_ray_batch *rays,
                              const rk_ray_times *times, rk_hit_batch *hits, rk_counters *counters)
{
    const rk_tree tree = rk_accel_moving_tree(accel, object);
    moved_rays moved;
    rk_hit_batch found;
    moved.rays.count = 0;
    for (uint32_t i = 0; i < rays->count; i++)
        if (times->objects[i] >> object & 1)
            add_moved(&moved, accel, object, rays, times, i, hits->t[i]);
    rk_tree_closest(&tree, &moved.rays, &found, counters);
    for (uint32_t i = 0; i < moved.rays.count; i++) {
        uint32_t index = moved.index[i];
        rk_hit hit = rk_batch_hit(&found, i);
        if (hit.t < hits->t[index] || hit.triangle < hits->triangle[index])
            rk_batch_put_hit(hits, index, &hit);
    }
}

static void occluded_by_object(const rk_accel *accel, uint32_t object, const rk_ray_batch *rays,
                               const rk_ray_times *times, rk_occlusion_batch *answers,
                               rk_counters *counters)
{
    const rk_tree tree = rk_accel_moving_tree(accel, object);
    moved_rays moved;
    rk_occlusion_batch found;
    moved.rays.count = 0;
    for (uint32_t i = 0; i < rays->count; i++)
        if ((times->objects[i] >> object & 1) && !answers->occluded[i])
            add_moved(&moved, accel, object, rays, times, i, rays->t_max[i]);
    rk_tree_occluded(&tree, &moved.rays, &found, counters);
    for (uint32_t i = 0; i < moved.rays.count; i++)
        answers->occluded[moved.index[i]] = found.occluded[i];
}

void rk_accel_closest_moving(const rk_accel *accel, const rk_ray_batch *rays,
                             const rk_ray_times *times, rk_hit_batch *hits, rk_counters *counters)
{
    for (uint32_t k = 0; k < accel->scene->moving_count; k++)
        closest_in_object(accel, k, rays, times, hits, counters);
}

void rk_accel_occluded_moving(const rk_accel *accel, const rk_ray_batch *rays,
                              const rk_ray_times *times, rk_occlusion_batch *answers,
                              rk_counters *counters)
{
    for (uint32_t k = 0; k < accel->scene->moving_count; k++)
        occluded_by_object(accel, k, rays, times, answers, counters);
}
