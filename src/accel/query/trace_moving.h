/* Traces rays against moving objects at the rays' times. The objects stay at rest; the rays are
 * moved instead; not installed. */
#ifndef RK_ACCEL_QUERY_TRACE_MOVING_H
#define RK_ACCEL_QUERY_TRACE_MOVING_H

#include "accel/accel.h"
#include "accel/query/ray_times.h"
#include "base/counters.h"
#include "features/motion_blur.h"

/* `hits` and `answers` hold the results for static surfaces (accel/query/trace.h); nearer hits and
 * further occlusions are added. */
void rk_accel_closest_moving(const rk_accel *accel, const rk_ray_batch *rays,
                             const rk_ray_times *times, rk_hit_batch *hits, rk_counters *counters);
void rk_accel_occluded_moving(const rk_accel *accel, const rk_ray_batch *rays,
                              const rk_ray_times *times, rk_occlusion_batch *answers,
                              rk_counters *counters);

/* Returns the ray relative to the object at this time, so that the object is at rest. */
static inline rk_ray rk_accel_ray_at(const rk_accel *accel, uint32_t object, float time,
                                     const rk_ray *ray)
{
    return rk_motion_ray(rk_motion_offset(&accel->scene->moving[object].motion, time), ray);
}

#endif
