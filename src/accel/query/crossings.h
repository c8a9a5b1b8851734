/* All crossings of a ray, not only the nearest: transparent surfaces along view rays and shadow
 * rays. */
#ifndef RK_ACCEL_QUERY_CROSSINGS_H
#define RK_ACCEL_QUERY_CROSSINGS_H

#include "accel/accel.h"
#include "accel/query/ray_times.h"
#include "base/counters.h"
#include "features/transparency.h"

/* Puts the nearest `limit` crossings at 0 < t < ray->t_max into the list, sorted, none behind an
 * opaque one (limit: 1 to RK_CROSSINGS_MAX). A material is a medium; a sphere is entered and left.
 * Where an alpha_texture cuts a surface out, nothing is crossed.
 * Each crossing counts once, also through edges and corners, by the rule in
 * features/transparency.h. A ray from rk_surface_spawn does not cross the surface that it left.
 * Moving objects are at rest. Allocates nothing; counts box, triangle and sphere tests.
 */
void rk_crossings_gather(const rk_accel *accel, const rk_ray *ray, uint32_t limit,
                         rk_crossing_list *list, rk_counters *counters);

/* Returns the transmittance of a shadow ray, the point at t = 0, the light at t = 1, by
 * rk_transparency_transmit. Stops at the first opaque crossing; RK_CROSSINGS_MAX crossings count as
 * opaque. */
rk_vec3 rk_crossings_transmit(const rk_accel *accel, const rk_ray *ray, rk_glass_model model,
                              rk_counters *counters);

/* What the parts gather. */
typedef struct rk_crossings_wanted {
    bool until_opaque; /* stop at the first opaque crossing */
    bool cutouts_only; /* surfaces are opaque, or cut out by their alpha_texture */
} rk_crossings_wanted;

/* Both in parts, for a list from rk_transparency_start. First static surfaces. */
void rk_crossings_gather_static(const rk_accel *accel, const rk_ray *ray,
                                rk_crossings_wanted wanted, rk_crossing_list *list,
                                rk_counters *counters);
/* Then moving objects at the ray's time, */
void rk_crossings_gather_moving(const rk_accel *accel, const rk_ray *ray, const rk_ray_time *when,
                                rk_crossings_wanted wanted, rk_crossing_list *list,
                                rk_counters *counters);
/* or at rest. */
void rk_crossings_gather_at_rest(const rk_accel *accel, const rk_ray *ray,
                                 rk_crossings_wanted wanted, rk_crossing_list *list,
                                 rk_counters *counters);
/* For a shadow ray, after both: is it occluded, and its transmittance. */
bool rk_crossings_are_opaque(const rk_crossing_list *list);
rk_vec3 rk_crossings_transmittance(const rk_crossing_list *list, const rk_ray *ray,
                                   rk_glass_model model);

#endif
