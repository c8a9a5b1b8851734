/* All that a ray crosses, not only the nearest: for panes along view rays and shadow rays. */
#ifndef RK_ACCEL_CROSSINGS_H
#define RK_ACCEL_CROSSINGS_H

#include "accel/accel.h"
#include "features/transparency.h"

/* Puts the nearest `limit` crossings at 0 < t < ray->t_max into the list, sorted, none behind an
 * opaque one (limit: 1 to RK_CROSSINGS_MAX). A material is a medium; a sphere is entered and left.
 * Each crossing counts once, also through edges and corners, by the rule in
 * features/transparency.h. A ray from rk_surface_spawn does not cross the surface that it left.
 * What moves is met where it rests. Allocates nothing; counts box, triangle and sphere tests. */
void rk_crossings_gather(const rk_accel *accel, const rk_ray *ray, uint32_t limit,
                         rk_crossing_list *list, rk_counters *counters);

/* The same at the moment of ray `index` of a batch. */
void rk_crossings_gather_at(const rk_accel *accel, const rk_ray *ray, const rk_moments *when,
                            uint32_t index, uint32_t limit, rk_crossing_list *list,
                            rk_counters *counters);

/* The share of a light that arrives along a shadow ray, the point at t = 0, the light at t = 1:
 * gathers and folds by rk_transparency_transmit, and gives up at anything opaque. Nothing arrives
 * through RK_CROSSINGS_MAX crossings or more. */
rk_vec3 rk_crossings_transmit(const rk_accel *accel, const rk_ray *ray, rk_glass_model model,
                              rk_counters *counters);
rk_vec3 rk_crossings_transmit_at(const rk_accel *accel, const rk_ray *ray, const rk_moments *when,
                                 uint32_t index, rk_glass_model model, rk_counters *counters);

#endif
