/* The acceleration structure, built once and traced in batches (accel/query/trace.h). */
#ifndef RK_ACCEL_H
#define RK_ACCEL_H

#include "base/error.h"
#include "base/parallel.h"
#include "scene/bvh.h"
#include "scene/scene.h"
#include "scene/wide_tree.h"

typedef enum rk_accel_kind {
    RK_ACCEL_MEDIAN,    /* bvh_median */
    RK_ACCEL_SAH,       /* sah_binning, split on the longest axis */
    RK_ACCEL_SAH_3,     /* sah_binning, split on all three axes */
    RK_ACCEL_COLLAPSED, /* wide_bvh: eight children per node, made from the tree of RK_ACCEL_SAH_3
                         */
    RK_ACCEL_MORTON,    /* like the next one, built in less time, and slower to trace */
    RK_ACCEL_WIDE,      /* the fastest: eight children per node, built straight from the mesh, and
                         * traced by the widest instructions of the machine */
} rk_accel_kind;

typedef struct rk_accel {
    rk_accel_kind kind;
    uint32_t bins; /* per axis; of the three kinds that split a binary tree by them */
    rk_bvh bvh;    /* over static triangles; empty from RK_ACCEL_MORTON on */
    rk_bvh moving[RK_MOVING_MAX]; /* over each moving object at rest */
    const rk_scene *scene;        /* for its spheres, which are in no tree */
    bool has_cutouts;             /* rk_mesh_has_cutouts */
    /* From RK_ACCEL_COLLAPSED on, over the same triangles; else empty, and the kernel NULL. */
    rk_wide_bvh wide;
    rk_wide_bvh wide_moving[RK_MOVING_MAX];
    const struct rk_wide_kernel *kernel;
} rk_accel;

/* `scene` must not move while the structure is in use, and its mesh must pass rk_mesh_validate, as
 * those of rk_scene_around, rk_builtin_scene and rk_mesh_file_read do. Errors: an unknown kind;
 * moving objects that are not the mesh's last triangles, in order; from RK_ACCEL_MORTON on a
 * RAYKIT_ISA in the environment that names no instruction set of this machine. */
bool rk_accel_build(rk_accel *accel, rk_accel_kind kind, const rk_scene *scene, rk_error *error);
void rk_accel_free(rk_accel *accel);

typedef struct rk_accel_options {
    rk_accel_kind kind;
    uint32_t bins; /* per axis, 2 to RK_SAH_BINS_MAX; of the kinds that have some */
    rk_pool *pool; /* works on the tree, from RK_ACCEL_MORTON on; may be NULL */
} rk_accel_options;

/* RK_ACCEL_WIDE, the default number of bins, no pool. */
rk_accel_options rk_accel_options_default(void);

/* The same by these options. The tree does not depend on the number of threads. */
bool rk_accel_build_with(rk_accel *accel, const rk_accel_options *options, const rk_scene *scene,
                         rk_error *error);

/* The method's name in tables, with the number of bins: "median", "sah50", "sah50_3", "collapsed50"
 * or "wide". */
typedef struct rk_accel_title {
    char text[24];
} rk_accel_title;

rk_accel_title rk_accel_name(const rk_accel *accel);

/* The instruction set of the traversal, in tables: "scalar"; from RK_ACCEL_MORTON on "avx512",
 * "avx2", "sse2" or "scalar", the fastest that the machine has, or that RAYKIT_ISA in the
 * environment names. */
const char *rk_accel_isa(rk_accel_kind kind);

#endif
