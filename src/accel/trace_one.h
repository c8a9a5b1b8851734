/* What a single ray meets, for what drivers draw and tell: the renderer itself asks in batches. */
#ifndef RK_ACCEL_TRACE_ONE_H
#define RK_ACCEL_TRACE_ONE_H

#include "accel/accel.h"

/* Returns what the ray meets first; its triangle is RK_MISS if that is nothing. */
rk_hit rk_trace_one(const rk_accel *accel, const rk_ray *ray);

/* Fills in the surface that the ray meets first; false if there is none. */
bool rk_trace_one_surface(rk_surface *surface, const rk_accel *accel, const rk_ray *ray);

#endif
