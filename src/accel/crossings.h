/* All surfaces that a ray crosses, not only the nearest: for transparent ones along view rays and
 * shadow rays. */
#ifndef RK_ACCEL_CROSSINGS_H
#define RK_ACCEL_CROSSINGS_H

#include "accel/accel.h"
#include "accel/ray_times.h"
#include "base/counters.h"
#include "features/transparency.h"

/* Puts the nearest `limit` crossings at 0 < t < ray->t_max into the list, sorted, none behind an
 * opaque one (limit: 1 to RK_CROSSINGS_MAX). A material is a medium; a sphere is entered and left.
 * Each crossing counts once, also through edges and corners, by the rule in
 * features/transparency.h. A ray from rk_surface_spawn does not cross the surface that it left.
 * What moves is crossed where it rests. Allocates nothing; counts box, triangle and sphere tests.
 */
void rk_crossings_gather(const rk_accel *accel, const rk_ray *ray, uint32_t limit,
                         rk_crossing_list *list, rk_counters *counters);

/* Returns the transmittance for a shadow ray, the point at t = 0, the light at t = 1: gathers and
 * folds by rk_transparency_transmit, and gives up at anything opaque. Nothing arrives through
 * RK_CROSSINGS_MAX crossings or more. */
rk_vec3 rk_crossings_transmit(const rk_accel *accel, const rk_ray *ray, rk_glass_model model,
                              rk_counters *counters);

/* Both in parts, for a list from rk_transparency_start: first what stands still alone, ... */
void rk_crossings_gather_still(const rk_accel *accel, const rk_ray *ray, bool until_opaque,
                               rk_crossing_list *list, rk_counters *counters);
/* ... then what moves, where it stands at the ray's time; */
void rk_crossings_gather_moving(const rk_accel *accel, const rk_ray *ray, const rk_ray_time *when,
                                bool until_opaque, rk_crossing_list *list, rk_counters *counters);
/* or all that moves where it rests; */
void rk_crossings_gather_at_rest(const rk_accel *accel, const rk_ray *ray, bool until_opaque,
                                 rk_crossing_list *list, rk_counters *counters);
/* and for a shadow ray, after either: does nothing arrive, and how much does? */
bool rk_crossings_are_opaque(const rk_crossing_list *list);
rk_vec3 rk_crossings_transmittance(const rk_crossing_list *list, const rk_ray *ray,
                                   rk_glass_model model);

#endif
