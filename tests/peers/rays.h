/* The rays of each workload, the same for all engines. */
#ifndef RK_TESTS_PEERS_RAYS_H
#define RK_TESTS_PEERS_RAYS_H

#include "accel/accel.h"
#include "accel/batch.h"
#include "base/names.h"

typedef enum peers_workload {
    PEERS_PRIMARY,      /* through the pixels' centres: closest hits */
    PEERS_POINT_SHADOW, /* from the primary hits to a point light: is the light occluded? */
    PEERS_AREA_SHADOW,  /* the same to random points of a light with an extent */
    PEERS_DIFFUSE,      /* from the primary hits, cosine-distributed: closest hits */
} peers_workload;

enum { PEERS_WORKLOADS = PEERS_DIFFUSE + 1 };

extern const rk_names peers_workload_names;

/* Rays in full batches; only the last may have fewer. */
typedef struct peers_rays {
    peers_workload workload;
    size_t batch_count;
    rk_ray_batch *batches;
} peers_rays;

static inline bool peers_wants_closest(peers_workload workload)
{
    return workload == PEERS_PRIMARY || workload == PEERS_DIFFUSE;
}

size_t peers_ray_count(const peers_rays *rays);

/* Makes the workload's rays for a picture of side x side pixels; `side` is a multiple of
 * RK_TILE_SIDE. Pixels go tile by tile, and within a tile in Z order, so that 4, 16 or 64
 * consecutive rays pass through a square. Rays from hits keep the order; points that face away from
 * the light have no shadow ray, as in rk_render. The same on every call. */
bool peers_rays_make(peers_rays *rays, peers_workload workload, const rk_accel *accel,
                     uint32_t side, rk_error *error);
void peers_rays_free(peers_rays *rays);

#endif
