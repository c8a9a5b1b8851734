/* How another engine's answer differs from raykit's, and why. raykit decides exactly which
 * triangles a ray crosses (features/watertight.h); an engine that decides in float may decide
 * otherwise where the ray passes an edge within the rounding error. */
#ifndef RK_TESTS_PEERS_DIFFERENCE_H
#define RK_TESTS_PEERS_DIFFERENCE_H

#include "base/names.h"
#include "base/ray.h"
#include "engine.h"
#include "scene/mesh.h"

/* From PEERS_BOX on, rounding at edges and ends does not explain the difference. */
typedef enum peers_cause {
    PEERS_SAME,       /* no difference */
    PEERS_SHARED,     /* the ray crosses both triangles where they touch */
    PEERS_COINCIDENT, /* the ray crosses both triangles at the same distance, where they intersect
                       */
    PEERS_NEIGHBOUR, /* the other triangle has a common corner, and the ray misses it by rounding */
    PEERS_LEAK,      /* the engine misses a triangle at whose edge the ray passes */
    PEERS_BEYOND,    /* the engine hits a triangle that the ray misses by rounding */
    PEERS_ENDS,      /* the hit is at the ray's end, or at its origin, within rounding */
    PEERS_BOX,       /* the engine misses a triangle that it would hit: its boxes are too small */
    PEERS_VALUES,    /* the same triangle, but t, u, v or the normal differ by more than rounding */
    PEERS_UNKNOWN,   /* none of these */
} peers_cause;

enum { PEERS_CAUSES = PEERS_UNKNOWN + 1 };

extern const rk_names peers_cause_names;

/* A sentence about the cause. */
const char *peers_cause_meaning(peers_cause cause);

/* Values of a hit. */
typedef enum peers_value { PEERS_T, PEERS_WEIGHTS, PEERS_NORMAL } peers_value;

enum { PEERS_VALUE_KINDS = PEERS_NORMAL + 1 };

extern const rk_names peers_value_names;

/* The largest differences on the same triangle, as fractions of what rounding can explain: at most
 * 1, or the cause is PEERS_VALUES. */
typedef struct peers_largest {
    double of_bound[PEERS_VALUE_KINDS];
} peers_largest;

/* Compares closest hits of a ray; updates the largest differences. */
peers_cause peers_difference(const rk_mesh *mesh, const rk_ray *ray, const peers_hit *ours,
                             const peers_hit *theirs, peers_largest *largest);

/* Compares occlusion. Takes time in proportion to the mesh where the answers differ. */
peers_cause peers_occlusion_difference(const rk_mesh *mesh, const rk_ray *ray, bool ours,
                                       bool theirs);

#endif
