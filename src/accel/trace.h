/* Rays in batches, through the acceleration structure: the closest hits, or whether there are any.
 */
#ifndef RK_ACCEL_TRACE_H
#define RK_ACCEL_TRACE_H

#include "accel/accel.h"
#include "accel/batch.h"
#include "base/counters.h"

/* Objects that move are intersected where they rest. */
void rk_accel_closest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                      rk_counters *counters);
void rk_accel_occluded(const rk_accel *accel, const rk_ray_batch *rays, rk_occlusion_batch *answers,
                       rk_counters *counters);

/* The same in two parts: first what stands still alone, spheres included, ... */
void rk_accel_closest_still(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                            rk_counters *counters);
void rk_accel_occluded_still(const rk_accel *accel, const rk_ray_batch *rays,
                             rk_occlusion_batch *answers, rk_counters *counters);
/* (sooner where rays that follow each other start from the same point: accel/ray_group.h) */
void rk_accel_closest_still_grouped(const rk_accel *accel, const rk_ray_batch *rays,
                                    rk_hit_batch *hits, rk_counters *counters);
/* ... then objects that move, where they rest; or where they stand at the rays' times: see
 * accel/trace_moving.h. `hits` and `answers` hold the first part's. */
void rk_accel_closest_at_rest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                              rk_counters *counters);
void rk_accel_occluded_at_rest(const rk_accel *accel, const rk_ray_batch *rays,
                               rk_occlusion_batch *answers, rk_counters *counters);

#endif
