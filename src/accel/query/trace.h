/* Traces batches of rays through the acceleration structure: closest hits, or occlusion. */
#ifndef RK_ACCEL_QUERY_TRACE_H
#define RK_ACCEL_QUERY_TRACE_H

#include "accel/accel.h"
#include "accel/batch.h"
#include "base/counters.h"

/* Moving objects are at rest. */
void rk_accel_closest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                      rk_counters *counters);
void rk_accel_occluded(const rk_accel *accel, const rk_ray_batch *rays, rk_occlusion_batch *answers,
                       rk_counters *counters);

/* The same in two parts. First static surfaces: triangles, then spheres. */
void rk_accel_closest_static(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                             rk_counters *counters);
void rk_accel_occluded_static(const rk_accel *accel, const rk_ray_batch *rays,
                              rk_occlusion_batch *answers, rk_counters *counters);
/* Then moving objects at rest; or at the rays' times, by accel/query/trace_moving.h. `hits` and
 * `answers` hold the results of the first part. */
void rk_accel_closest_at_rest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                              rk_counters *counters);
void rk_accel_occluded_at_rest(const rk_accel *accel, const rk_ray_batch *rays,
                               rk_occlusion_batch *answers, rk_counters *counters);

#endif
