/* Directions in a highlight's lobe. A sharp highlight shows a mirrored image of the light, of which
 * a sample anywhere on the light hardly ever finds the bright part; a direction drawn in the lobe
 * finds it at once. Both kinds of samples are weighted by the balance heuristic. Veach, Guibas,
 * "Optimally combining sampling techniques for Monte Carlo rendering", SIGGRAPH 1995; Pharr, Jakob,
 * Humphreys, "Physically Based Rendering", fourth edition, sections 2.2.3 and 9.3; not installed.
 */
#ifndef RK_RENDER_LOBE_H
#define RK_RENDER_LOBE_H

#include "features/shading.h"

/* The lobe of Phong or Blinn-Phong at a surface point, as seen by its viewer. */
typedef struct rk_lobe {
    rk_shading_model model;
    float shininess;
    rk_vec3 normal, to_viewer; /* unit */
    rk_vec3 u, v, axis;        /* right-handed, unit: the axis is the mirror direction of the viewer
                                  (Phong), or the normal, around which half vectors lie */
} rk_lobe;

rk_lobe rk_lobe_of(rk_shading_model model, float shininess, rk_vec3 normal, rk_vec3 to_viewer);

/* Maps xi in [0, 1)^2 to a unit direction with the lobe's density. False if it leads below the
 * surface, where no light is reflected. */
bool rk_lobe_direction(const rk_lobe *lobe, rk_vec2 xi, rk_vec3 *to_light);

/* Returns the density of that direction, per solid angle:
 *
 *   Phong        (s + 1) / (2 pi) (r.v)^s
 *   Blinn-Phong  (s + 1) / (2 pi) (n.h)^s / (4 h.v)
 *
 * and 0 below the surface. The power is the lobe of rk_shade. */
double rk_lobe_density(const rk_lobe *lobe, rk_vec3 to_light);

#endif
