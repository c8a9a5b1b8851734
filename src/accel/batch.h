/* Rays in batches, as structures of arrays: the form in which stages pass them on. */
#ifndef RK_ACCEL_BATCH_H
#define RK_ACCEL_BATCH_H

#include "base/ray.h"

#include <stdbool.h>

enum {
    RK_TILE_SIDE = 16, /* pixels; so close that their rays enter mostly the same boxes */
    RK_BATCH_MAX = RK_TILE_SIDE * RK_TILE_SIDE,
};

typedef struct rk_ray_batch {
    uint32_t count;
    float origin_x[RK_BATCH_MAX], origin_y[RK_BATCH_MAX], origin_z[RK_BATCH_MAX];
    float direction_x[RK_BATCH_MAX], direction_y[RK_BATCH_MAX], direction_z[RK_BATCH_MAX];
    float t_max[RK_BATCH_MAX];
} rk_ray_batch;

/* The closest hits of a batch, entry for entry. */
typedef struct rk_hit_batch {
    float t[RK_BATCH_MAX], u[RK_BATCH_MAX], v[RK_BATCH_MAX];
    uint32_t triangle[RK_BATCH_MAX]; /* or RK_MISS */
} rk_hit_batch;

/* The results of an occlusion test, entry for entry. */
typedef struct rk_occlusion_batch {
    bool occluded[RK_BATCH_MAX];
} rk_occlusion_batch;

static inline void rk_batch_push(rk_ray_batch *batch, const rk_ray *ray)
{
    uint32_t i = batch->count++;
    batch->origin_x[i] = ray->origin.x;
    batch->origin_y[i] = ray->origin.y;
    batch->origin_z[i] = ray->origin.z;
    batch->direction_x[i] = ray->direction.x;
    batch->direction_y[i] = ray->direction.y;
    batch->direction_z[i] = ray->direction.z;
    batch->t_max[i] = ray->t_max;
}

static inline rk_ray rk_batch_ray(const rk_ray_batch *batch, uint32_t i)
{
    return (rk_ray){rk_vec(batch->origin_x[i], batch->origin_y[i], batch->origin_z[i]),
                    rk_vec(batch->direction_x[i], batch->direction_y[i], batch->direction_z[i]),
                    batch->t_max[i]};
}

static inline rk_hit rk_batch_hit(const rk_hit_batch *hits, uint32_t i)
{
    return (rk_hit){hits->t[i], hits->u[i], hits->v[i], hits->triangle[i]};
}

static inline void rk_batch_put_hit(rk_hit_batch *hits, uint32_t i, const rk_hit *hit)
{
    hits->t[i] = hit->t;
    hits->u[i] = hit->u;
    hits->v[i] = hit->v;
    hits->triangle[i] = hit->triangle;
}

#endif
