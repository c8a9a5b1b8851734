/* Paths in batches: rays, and the contribution of each to its pixel; not installed. */
#ifndef RK_RENDER_PATH_BATCH_H
#define RK_RENDER_PATH_BATCH_H

#include "accel/batch.h"
#include "render/plan.h"

typedef struct rk_path {
    rk_vec3 throughput; /* fraction of the radiance along the ray that reaches the pixel */
    /* The index among the pixel's samples, or, once a rough mirror has split the path, among
     * glossy.samples times as many. */
    uint32_t sample : 25;
    uint32_t split : 1;
    uint32_t bounces_left : 6; /* further surfaces that the path may reach */
} rk_path;

_Static_assert(RK_SAMPLES_MAX <= 1 << 25 && RK_MAX_DEPTH < 1 << 6, "both fit their bits");

static inline rk_path rk_path_of(rk_vec3 throughput, uint32_t sample, bool split,
                                 uint32_t bounces_left)
{
    return (rk_path){throughput, sample & ((1 << 25) - 1), split, bounces_left & ((1 << 6) - 1)};
}

static inline bool rk_path_is_from_camera(const rk_path *path, uint32_t max_depth)
{
    return path->bounces_left == max_depth;
}

/* The path of a camera ray. */
static inline rk_path rk_path_start(uint32_t sample, uint32_t bounces_left)
{
    return rk_path_of(rk_vec(1, 1, 1), sample, false, bounces_left);
}

typedef struct rk_path_batch {
    rk_ray_batch rays;
    uint16_t pixel[RK_BATCH_MAX]; /* within the tile, row by row */
    rk_path path[RK_BATCH_MAX];
} rk_path_batch;

/* For a ray whose path is in the batch already. */
static inline void rk_path_push_ray(rk_path_batch *paths, const rk_ray *ray, uint32_t pixel)
{
    paths->pixel[paths->rays.count] = (uint16_t)pixel;
    rk_batch_push(&paths->rays, ray);
}

static inline void rk_path_push(rk_path_batch *paths, const rk_ray *ray, uint32_t pixel,
                                rk_path path)
{
    paths->path[paths->rays.count] = path;
    rk_path_push_ray(paths, ray, pixel);
}

#endif
