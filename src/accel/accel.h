/* The acceleration structure, built once and traced in batches (accel/trace.h). */
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
    uint32_t bins;                /* per axis; of the two kinds with bins */
    rk_bvh bvh;                   /* over static triangles */
    rk_bvh moving[RK_MOVING_MAX]; /* over each moving object at rest */
    const rk_scene *scene;        /* for its spheres, which are in no tree */
} rk_accel;

/* `scene` must not move while the structure is in use, and its mesh must pass rk_mesh_validate, as
 * those of rk_scene_around, rk_builtin_scene and rk_mesh_file_read do. Errors: an unknown kind;
 * moving objects that are not the mesh's last triangles, in order. */
bool rk_accel_build(rk_accel *accel, rk_accel_kind kind, const rk_scene *scene, rk_error *error);
void rk_accel_free(rk_accel *accel);

/* The same with this number of bins, 2 to RK_SAH_BINS_MAX; ignored by RK_ACCEL_MEDIAN. */
bool rk_accel_build_binned(rk_accel *accel, rk_accel_kind kind, uint32_t bins,
                           const rk_scene *scene, rk_error *error);

/* The method's name in tables, with the number of bins: "median", "sah50" or "sah50_3". */
typedef struct rk_accel_title {
    char text[24];
} rk_accel_title;

rk_accel_title rk_accel_name(const rk_accel *accel);

/* The instruction set of the traversal, in tables: "scalar". Moving objects are traced in packets,
 * which use SSE2 if the compiler may. */
const char *rk_accel_isa(rk_accel_kind kind);

#endif
