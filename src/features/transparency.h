/* Transparency: a ray's crossings, in order, reduced to a colour. View rays blend the surfaces that
 * they cross; shadow rays compute the transmittance, by one of three models.
 *
 * Each crossing counts once. The caller guarantees it by this rule: a ray is treated as if it were
 * displaced infinitesimally, in the same way for all triangles, so that it never passes through an
 * edge or a corner. Of the triangles of a face around an edge or a corner it then crosses exactly
 * one, of a fold both sides or neither; surfaces that coincide are crossed one by one. So nothing
 * here compares distances to guess which crossings are the same. */
#ifndef RK_FEATURES_TRANSPARENCY_H
#define RK_FEATURES_TRANSPARENCY_H

#include "base/ray.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct rk_crossing {
    float t;            /* > 0: the point is origin + t direction */
    float u, v;         /* barycentric, as in rk_hit */
    uint32_t primitive; /* index in the mesh, beyond its end the scene's spheres */
    uint32_t medium;    /* number of the medium inside; the same for all of its surfaces */
    bool entering;      /* from outside (where a face's corners are counter-clockwise) */
    float alpha;        /* opacity, in [0, 1]; 1 is opaque */
    rk_vec3 kd;         /* colour, each component in [0, 1] */
    rk_vec3 absorption; /* of the medium, sigma: per world unit, >= 0 */
} rk_crossing;

static inline rk_hit rk_crossing_hit(const rk_crossing *crossing)
{
    return (rk_hit){crossing->t, crossing->u, crossing->v, crossing->primitive};
}

/* More than any ray of our scenes has. A shadow ray with this many crossings is occluded. */
enum { RK_CROSSINGS_MAX = 256 };

/* The nearest crossings of a ray in the order of t, at equal t in that of the primitives. None lies
 * behind an opaque one. */
typedef struct rk_crossing_list {
    uint32_t limit; /* of the count: 1 to RK_CROSSINGS_MAX */
    uint32_t count;
    rk_crossing crossings[RK_CROSSINGS_MAX];
} rk_crossing_list;

/* Starts an empty list. For a view ray through up to n transparent surfaces the limit is n + 1: the
 * last crossing kept is seen behind n others. */
static inline void rk_transparency_start(rk_crossing_list *list, uint32_t limit)
{
    list->limit = limit;
    list->count = 0;
}

/* Inserts a crossing. The order of insertion does not matter: the list ends up the same. */
void rk_transparency_insert(rk_crossing_list *list, const rk_crossing *crossing);

/* Returns the t beyond which no crossing can enter the list any more; t_max while every crossing
 * can. */
float rk_transparency_end(const rk_crossing_list *list, float t_max);

/* View rays. `weights`: one per crossing, the fraction of the pixel that has its colour, alpha_k
 * prod_{j<k} (1 - alpha_j). `transmittance`: the fraction that comes from behind them all. They sum
 * to 1. */
void rk_transparency_weights(const rk_crossing *crossings, uint32_t count, float *weights,
                             float *transmittance);

typedef enum rk_glass_model {
    RK_GLASS_MULTIPLICATIVE, /* prod kd (1 - alpha): ignores order and thickness */
    RK_GLASS_ORDERED,        /* surfaces blended over white light, seen from the point */
    RK_GLASS_BEER_LAMBERT,   /* exp(-sigma thickness) for each medium */
} rk_glass_model;

/* Shadow rays: returns the transmittance, each component in [0, 1] up to rounding, of crossings at
 * 0 < t < 1 in ascending order, with the light at t = 1. `length`: world units from the point to
 * the light, >= 0 and finite. An opaque crossing makes it 0 in every model.
 *
 * Beer-Lambert pairs the crossings of a medium, entering with leaving: if more blocks are left than
 * entered, the point is inside, if fewer, the light is. Where blocks of one medium overlap it
 * absorbs once; where different media overlap, each absorbs. kd, and alpha below 1, play no part.
 * An open sheet has no inside: it counts as the face of a block that fills the rest of the ray on
 * its inner side. A ray that enters and leaves a medium at one t is taken to graze it from
 * outside. */
rk_vec3 rk_transparency_transmit(rk_glass_model model, const rk_crossing *crossings, uint32_t count,
                                 float length);

#endif
