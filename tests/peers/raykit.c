/* raykit, as rk_render calls it: batches of rays through each kind of tree. Declared in engine.h.
 */
#include "engine.h"

#include "accel/query/trace.h"
#include "base/table.h"
#include "driver/driver.h"

#include <malloc.h>
#include <stdlib.h>

typedef struct raykit {
    peers_engine base;
    rk_accel accels[PEERS_TREES_MAX];
} raykit;

typedef struct lane {
    bool closest;
    uint32_t batches;
    rk_ray_batch rays[PEERS_GROUP_BATCHES];
    rk_hit_batch hits[PEERS_GROUP_BATCHES];
    rk_occlusion_batch occlusion[PEERS_GROUP_BATCHES];
    rk_vec3 normals[PEERS_GROUP_RAYS];
    rk_counters counters;
} lane;

/* --- Trees ------------------------------------------------------------------------------------ */

/* Kinds count from 0 on; rk_accel_build refuses what is none. */
static uint32_t count_kinds(void)
{
    const rk_scene empty = {.name = "empty"};
    rk_accel accel;
    uint32_t kinds = 0;
    while (kinds < PEERS_TREES_MAX && rk_accel_build(&accel, (rk_accel_kind)kinds, &empty, NULL)) {
        rk_accel_free(&accel);
        kinds++;
    }
    return kinds;
}

static peers_name tree_name(const peers_engine *engine, uint32_t tree)
{
    const raykit *self = (const raykit *)engine;
    peers_name name;
    snprintf(name.text, sizeof name.text, "%s-%s", rk_accel_name(&self->accels[tree]).text,
             rk_accel_isa((rk_accel_kind)tree));
    return name;
}

static peers_name mode_name(const peers_engine *engine, peers_mode mode)
{
    return tree_name(engine, mode.tree);
}

/* What malloc has given out, of which a sanitizer's malloc tells nothing. */
static double allocated(void)
{
#if defined(__GLIBC__) && (__GLIBC__ > 2 || __GLIBC_MINOR__ >= 33)
    const struct mallinfo2 now = mallinfo2();
    return (double)now.uordblks + (double)now.hblkhd;
#else
    return 0;
#endif
}

static bool build(peers_engine *engine, uint32_t tree, uint32_t threads, double *seconds,
                  double *bytes, rk_error *error)
{
    raykit *self = (raykit *)engine;
    rk_accel_options options = rk_accel_options_default();
    options.kind = (rk_accel_kind)tree;
    options.pool = rk_pool_start(threads, error);
    if (!options.pool)
        return false;
    rk_accel_free(&self->accels[tree]);
    const double before = allocated(), start = rk_clock_wall();
    const bool ok = rk_accel_build_with(&self->accels[tree], &options, engine->scene, error);
    *seconds = rk_clock_wall() - start;
    rk_pool_stop(options.pool);
    if (!ok)
        return false;
    const double kept = allocated() - before;
    *bytes = kept > 0 ? kept : -1;
    return true;
}

/* --- Rays ------------------------------------------------------------------------------------- */

static void load(const peers_engine *engine, peers_mode mode, void *at, const rk_ray_batch *rays,
                 uint32_t batches, bool closest)
{
    (void)engine, (void)mode;
    lane *self = at;
    self->closest = closest;
    self->batches = batches;
    for (uint32_t b = 0; b < batches; b++)
        self->rays[b] = rays[b];
}

/* Embree answers with normals, so raykit must, too. */
static void find_normals(const rk_mesh *mesh, const rk_hit_batch *hits, uint32_t count,
                         rk_vec3 *normals)
{
    for (uint32_t i = 0; i < count; i++) {
        if (hits->triangle[i] == RK_MISS)
            continue;
        const uint32_t *corners = mesh->triangles[hits->triangle[i]];
        const rk_vec3 a = mesh->positions[corners[0]];
        normals[i] = rk_cross(rk_sub(mesh->positions[corners[1]], a),
                              rk_sub(mesh->positions[corners[2]], a));
    }
}

static void trace(const peers_engine *engine, peers_mode mode, void *at)
{
    const rk_accel *accel = &((const raykit *)engine)->accels[mode.tree];
    lane *self = at;
    for (uint32_t b = 0; b < self->batches; b++)
        if (self->closest) {
            rk_accel_closest(accel, &self->rays[b], &self->hits[b], &self->counters);
            find_normals(&engine->scene->mesh, &self->hits[b], self->rays[b].count,
                         self->normals + b * RK_BATCH_MAX);
        } else {
            rk_accel_occluded(accel, &self->rays[b], &self->occlusion[b], &self->counters);
        }
}

static void unload(const peers_engine *engine, peers_mode mode, const void *at, peers_hit *hits)
{
    (void)engine, (void)mode;
    const lane *self = at;
    for (uint32_t b = 0; b < self->batches; b++)
        for (uint32_t i = 0; i < self->rays[b].count; i++, hits++) {
            const rk_hit hit = rk_batch_hit(&self->hits[b], i);
            if (!self->closest)
                *hits = (peers_hit){.triangle = self->occlusion[b].occluded[i] ? 0 : RK_MISS};
            else if (hit.triangle == RK_MISS)
                *hits = (peers_hit){.triangle = RK_MISS};
            else
                *hits = (peers_hit){hit.triangle, hit.t, hit.u, hit.v,
                                    self->normals[b * RK_BATCH_MAX + i]};
        }
}

/* --- The engine ------------------------------------------------------------------------------- */

static void close_raykit(peers_engine *engine)
{
    raykit *self = (raykit *)engine;
    for (uint32_t tree = 0; self && tree < PEERS_TREES_MAX; tree++)
        rk_accel_free(&self->accels[tree]);
    free(self);
}

peers_engine *peers_raykit_open(const rk_scene *scene, rk_error *error)
{
    raykit *self = rk_allocate(1, sizeof *self, "raykit", error);
    if (!self)
        return NULL;
    self->base = (peers_engine){.name = "raykit",
                                .scene = scene,
                                .lane_bytes = sizeof(lane),
                                .tree_count = count_kinds(),
                                .tree_name = tree_name,
                                .build = build,
                                .usual = rk_driver_default("", "").split,
                                .mode_name = mode_name,
                                .load = load,
                                .trace = trace,
                                .unload = unload,
                                .close = close_raykit};
    self->base.mode_count = self->base.tree_count;
    for (uint32_t k = 0; k < self->base.mode_count; k++)
        self->base.modes[k] = (peers_mode){.tree = k};
    return &self->base;
}

const rk_accel *peers_raykit_accel(const peers_engine *engine)
{
    return &((const raykit *)engine)->accels[engine->modes[engine->usual].tree];
}
