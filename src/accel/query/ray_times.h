/* Ray times, and the moving objects that a ray may hit. */
#ifndef RK_ACCEL_QUERY_RAY_TIMES_H
#define RK_ACCEL_QUERY_RAY_TIMES_H

#include "accel/batch.h"
#include "scene/scene.h"

#include <assert.h>

typedef struct rk_ray_time {
    float time;       /* NaN if no bit is set */
    uint16_t objects; /* bit k: object k */
} rk_ray_time;

static_assert(RK_MOVING_MAX <= 16, "a bit for each object");

/* The same for a batch, entry for entry. */
typedef struct rk_ray_times {
    float time[RK_BATCH_MAX];
    uint16_t objects[RK_BATCH_MAX];
} rk_ray_times;

#endif
