/* The acceleration structure, whichever was chosen: built once, asked in batches. */
#ifndef RK_ACCEL_ACCEL_H
#define RK_ACCEL_ACCEL_H

#include "accel/batch.h"
#include "base/counters.h"
#include "features/motion_blur.h"
#include "scene/bvh.h"
#include "scene/scene.h"

typedef enum rk_accel_kind {
    RK_ACCEL_MEDIAN, /* bvh_median */
    RK_ACCEL_SAH,    /* sah_binning, borders on the longest axis */
    RK_ACCEL_SAH_3,  /* sah_binning, borders on all three axes */
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

/* "scalar": the instruction set of the traversal, in tables; what moves is met in packets, which
 * have SSE2 where the compiler may use it. */
const char *rk_accel_isa(rk_accel_kind kind);

/* All that moves is met where it rests. */
void rk_accel_closest(const rk_accel *accel, const rk_ray_batch *rays, rk_hit_batch *hits,
                      rk_counters *counters);
/* Makes entry i of `hits` from the closest hit in the tree, or a nearer sphere. */
void rk_accel_put_hit(const rk_accel *accel, const rk_ray *ray, rk_hit hit, rk_hit_batch *hits,
                      uint32_t i, rk_counters *counters);
void rk_accel_occluded(const rk_accel *accel, const rk_ray_batch *rays, rk_occlusion_batch *answers,
                       rk_counters *counters);

/* Where moving objects stand when the rays of a batch are traced. `reaches` is asked last, when all
 * that stands still has shortened the ray to t_max: may ray `index` meet the object at all? If so
 * it fills in the object's offset. A ray may be asked about all objects before it meets any. */
typedef struct rk_moments {
    bool (*reaches)(void *asker, uint32_t index, uint32_t object, const rk_slabs *ray, float t_max,
                    rk_vec3 *offset);
    void *asker;
} rk_moments;

void rk_accel_closest_at(const rk_accel *accel, const rk_ray_batch *rays, const rk_moments *when,
                         rk_hit_batch *hits, rk_counters *counters);
void rk_accel_any_at(const rk_accel *accel, const rk_ray_batch *rays, const rk_moments *when,
                     rk_occlusion_batch *answers, rk_counters *counters);

#endif
