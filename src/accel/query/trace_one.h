/* Traces a single ray, for debug views: the renderer itself traces batches. */
#ifndef RK_ACCEL_QUERY_TRACE_ONE_H
#define RK_ACCEL_QUERY_TRACE_ONE_H

#include "accel/accel.h"

/* Returns the closest hit; its triangle is RK_MISS if there is none. */
rk_hit rk_trace_one(const rk_accel *accel, const rk_ray *ray);

/* Fills in the surface at the closest hit; false if there is none. */
bool rk_trace_one_surface(rk_surface *surface, const rk_accel *accel, const rk_ray *ray);

#endif
