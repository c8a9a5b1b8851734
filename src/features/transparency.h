/* Transparency: what a ray crosses, in order, folded into a colour. View rays blend what they
 * cross; shadow rays ask how much of the light arrives, by one of three models.
 *
 * Each crossing counts once. Whoever finds the crossings keeps this rule: a ray is treated as if
 * it were moved aside by less than any number, the same way for all triangles, so that it never
 * runs through an edge or a corner. Of the triangles of one face around an edge or a corner it then
 * crosses exactly one, of a fold both sides or none; panes that coincide are crossed each for
 * itself. So nothing here compares distances to guess which crossings are the same. */
#ifndef RK_FEATURES_TRANSPARENCY_H
#define RK_FEATURES_TRANSPARENCY_H

#include "base/ray.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct rk_crossing {
    float t;            /* > 0: the point is origin + t direction */
    float u, v;         /* barycentric, as in rk_hit */
    uint32_t primitive; /* index in the mesh, beyond its end the scene's spheres */
    uint32_t medium;    /* what is inside: crossings of one medium have the same number */
    bool entering;      /* through an outside (a face is counter-clockwise as seen from outside) */
    float alpha;        /* opacity, in [0, 1]; 1 is opaque */
    rk_vec3 kd;         /* colour, each component in [0, 1] */
    rk_vec3 absorption; /* of the medium, sigma: per world unit, >= 0 */
} rk_crossing;

static inline rk_hit rk_crossing_hit(const rk_crossing *crossing)
{
    return (rk_hit){crossing->t, crossing->u, crossing->v, crossing->primitive};
}

/* More than a scene has on one ray. A shadow ray that crosses so many is blocked. */
enum { RK_CROSSINGS_MAX = 256 };

/* The nearest crossings of a ray in the order of t, and of the primitive where t is equal. Nothing
 * stands behind an opaque one. */
typedef struct rk_crossing_list {
    uint32_t limit; /* at most so many are kept: 1 to RK_CROSSINGS_MAX */
    uint32_t count;
    rk_crossing crossings[RK_CROSSINGS_MAX];
} rk_crossing_list;

/* An empty list. For a view ray that looks through n panes the limit is n + 1: the last one kept
 * is what is seen behind n others. */
static inline void rk_transparency_start(rk_crossing_list *list, uint32_t limit)
{
    list->limit = limit;
    list->count = 0;
}

/* Puts a crossing in its place. It may come in any order: the list is in the end the same. */
void rk_transparency_insert(rk_crossing_list *list, const rk_crossing *crossing);

/* The t beyond which the list takes no crossing any more; t_max while it takes all. */
float rk_transparency_end(const rk_crossing_list *list, float t_max);

/* View rays. `weights`: one for each crossing, the share of the pixel that is its colour,
 * alpha_k prod_{j<k} (1 - alpha_j). `behind`: the share of what lies behind them all. Together 1.
 */
void rk_transparency_weights(const rk_crossing *crossings, uint32_t count, float *weights,
                             float *behind);

typedef enum rk_glass_model {
    RK_GLASS_MULTIPLICATIVE, /* prod kd (1 - alpha): blind to order and to thickness */
    RK_GLASS_ORDERED,        /* the panes blended over white light, as seen from the point */
    RK_GLASS_BEER_LAMBERT,   /* exp(-sigma thickness) for each medium */
} rk_glass_model;

/* Shadow rays: the share of the light, each component in [0, 1], that arrives through crossings at
 * 0 < t < 1 in ascending order, the light standing at t = 1. `length`: world units from the point
 * to the light. Nothing arrives through an opaque crossing, whatever the model.
 *
 * Beer-Lambert pairs the crossings of a medium, entering with leaving: where more are left than
 * were entered, the point is inside, where fewer, the light is. A medium absorbs once where blocks
 * of it overlap, and all media absorb where different ones do. kd and alpha below 1 play no part.
 * A sheet that is not closed has no inside: it is read as the face of a block that fills all the
 * rest of the way on its inner side. Where a ray both enters and leaves a medium at one t, it is
 * taken to graze it from outside. */
rk_vec3 rk_transparency_transmit(rk_glass_model model, const rk_crossing *crossings, uint32_t count,
                                 float length);

#endif
