/* An engine as the comparison sees it: trees, which it builds, and modes, in which it traces rays.
 * Only `build` and `trace` are measured. `load` and `unload` convert rays and hits between the
 * engine's form and one that all engines share; a renderer would keep them in the engine's. */
#ifndef RK_TESTS_PEERS_ENGINE_H
#define RK_TESTS_PEERS_ENGINE_H

#include "accel/accel.h"
#include "accel/batch.h"
#include "scene/scene.h"

#include <stdbool.h>

/* The batches that are loaded, traced and unloaded together: so many that reading the clock costs
 * nothing, so few that rays and hits stay in a processor's second-level cache. */
enum { PEERS_GROUP_BATCHES = 8, PEERS_GROUP_RAYS = PEERS_GROUP_BATCHES * RK_BATCH_MAX };

typedef struct peers_hit {
    uint32_t triangle; /* RK_MISS: none. Of an occlusion test 0, or RK_MISS if not occluded */
    float t, u, v;
    rk_vec3 normal; /* (b - a) x (c - a), not normalized */
} peers_hit;

typedef struct peers_name {
    char text[64];
} peers_name;

typedef struct peers_mode {
    uint32_t tree;
    uint32_t way; /* of tracing: 0 is one that every tree has */
} peers_mode;

enum { PEERS_TREES_MAX = 16, PEERS_MODES_MAX = 64 };

typedef struct peers_engine peers_engine;

struct peers_engine {
    const char *name;
    const rk_scene *scene;
    size_t lane_bytes; /* of a thread's own rays and hits */

    uint32_t tree_count;
    peers_name (*tree_name)(const peers_engine *engine, uint32_t tree);
    /* Builds a tree in place of the last one of this kind. `threads` is how many the engine may
     * use. Fills in the bytes that the tree keeps, or -1 if they are not known. */
    bool (*build)(peers_engine *engine, uint32_t tree, uint32_t threads, double *seconds,
                  double *bytes, rk_error *error);

    uint32_t mode_count;
    peers_mode modes[PEERS_MODES_MAX];
    uint32_t usual; /* the mode in which rk_render traces */
    peers_name (*mode_name)(const peers_engine *engine, peers_mode mode);
    void (*load)(const peers_engine *engine, peers_mode mode, void *lane, const rk_ray_batch *rays,
                 uint32_t batches, bool closest);
    void (*trace)(const peers_engine *engine, peers_mode mode, void *lane);
    void (*unload)(const peers_engine *engine, peers_mode mode, const void *lane, peers_hit *hits);

    void (*close)(peers_engine *engine);
};

/* `scene` must not move. NULL with an error. */
peers_engine *peers_raykit_open(const rk_scene *scene, rk_error *error);
peers_engine *peers_embree_open(const rk_scene *scene, rk_error *error);

/* The tree that rk_render would build, after it was built. */
const rk_accel *peers_raykit_accel(const peers_engine *engine);

/* "Embree 3.13.5" */
peers_name peers_embree_version(void);

#endif
