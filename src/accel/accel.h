/* The acceleration structure, whichever was chosen: built once, traced in batches (accel/trace.h).
 */
#ifndef RK_ACCEL_H
#define RK_ACCEL_H

#include "base/error.h"
#include "scene/bvh.h"
#include "scene/scene.h"

typedef enum rk_accel_kind {
    RK_ACCEL_MEDIAN, /* bvh_median */
    RK_ACCEL_SAH,    /* sah_binning, split on the longest axis */
    RK_ACCEL_SAH_3,  /* sah_binning, split on all three axes */
} rk_accel_kind;

typedef struct rk_accel {
    rk_accel_kind kind;
    uint32_t bins;                /* of the two with bins */
    rk_bvh bvh;                   /* over what stands still */
    rk_bvh moving[RK_MOVING_MAX]; /* one over each moving object, where it rests */
    const rk_scene *scene;        /* for its spheres, which no tree holds */
} rk_accel;

/* `scene` stays where it is while the structure is in use. Relies on a mesh that rk_mesh_validate
 * accepts, as it does those of rk_scene_around, rk_builtin_scene and rk_mesh_file_read. An unknown
 * kind is an error, and so is a scene whose moving objects are not its last triangles, in order. */
bool rk_accel_build(rk_accel *accel, rk_accel_kind kind, const rk_scene *scene, rk_error *error);
void rk_accel_free(rk_accel *accel);

/* The same with so many bins, 2 to RK_SAH_BINS_MAX, where the kind has any. */
bool rk_accel_build_binned(rk_accel *accel, rk_accel_kind kind, uint32_t bins,
                           const rk_scene *scene, rk_error *error);

/* "median", "sah50" or "sah50_3", with the number of bins: the method's name in tables. */
typedef struct rk_accel_title {
    char text[24];
} rk_accel_title;

rk_accel_title rk_accel_name(const rk_accel *accel);

/* "scalar": the instruction set of the traversal, in tables; objects that move are traced in
 * packets, which have SSE2 where the compiler may use it. */
const char *rk_accel_isa(rk_accel_kind kind);

#endif
