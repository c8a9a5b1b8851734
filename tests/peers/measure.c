#include "measure.h"

#include "base/table.h"

#include <stdlib.h>
#include <string.h>

/* --- Memory of the threads -------------------------------------------------------------------- */

enum { cache_line = 64 };

bool peers_lanes_init(peers_lanes *lanes, uint32_t count, peers_engine *const *engines,
                      uint32_t engine_count, rk_error *error)
{
    *lanes = (peers_lanes){.count = count};
    for (uint32_t e = 0; e < engine_count; e++)
        if (engines[e]->lane_bytes > lanes->bytes)
            lanes->bytes = engines[e]->lane_bytes;
    lanes->bytes = (lanes->bytes + cache_line - 1) / cache_line * cache_line;
    lanes->memory = rk_allocate(count, lanes->bytes, "rays of a thread", error);
    return lanes->memory != NULL;
}

void peers_lanes_free(peers_lanes *lanes)
{
    free(lanes->memory);
    *lanes = (peers_lanes){0};
}

static void *lane_of(const peers_lanes *lanes, uint32_t thread)
{
    return lanes->memory + thread * lanes->bytes;
}

/* --- Groups of batches ------------------------------------------------------------------------ */

typedef struct group {
    size_t first; /* batch */
    uint32_t batches;
} group;

static uint32_t group_count(const peers_rays *rays)
{
    return (uint32_t)((rays->batch_count + PEERS_GROUP_BATCHES - 1) / PEERS_GROUP_BATCHES);
}

static group group_of(const peers_rays *rays, uint32_t index)
{
    const size_t first = (size_t)index * PEERS_GROUP_BATCHES, left = rays->batch_count - first;
    return (group){first, left < PEERS_GROUP_BATCHES ? (uint32_t)left : PEERS_GROUP_BATCHES};
}

static uint32_t rays_of(const peers_rays *rays, group g)
{
    return (g.batches - 1) * RK_BATCH_MAX + rays->batches[g.first + g.batches - 1].count;
}

/* --- Speed ------------------------------------------------------------------------------------ */

enum { threads_max = 64 };

/* A thread's work, on a cache line of its own; seconds by the wall clock and of processor time. */
typedef struct work {
    _Alignas(cache_line) double wall;
    double processor, rays;
} work;

typedef struct run {
    const peers_engine *engine;
    peers_mode mode;
    const peers_rays *rays;
    const peers_lanes *lanes;
    work done[threads_max];
} run;

static void time_group(uint32_t index, uint32_t thread, void *context)
{
    run *r = context;
    const group g = group_of(r->rays, index);
    void *lane = lane_of(r->lanes, thread);
    r->engine->load(r->engine, r->mode, lane, r->rays->batches + g.first, g.batches,
                    peers_wants_closest(r->rays->workload));
    const double wall = rk_clock_wall(), processor = rk_clock_thread();
    r->engine->trace(r->engine, r->mode, lane);
    r->done[thread].processor += rk_clock_thread() - processor;
    r->done[thread].wall += rk_clock_wall() - wall;
    r->done[thread].rays += rays_of(r->rays, g);
}

peers_speed peers_speed_of(const peers_engine *engine, peers_mode mode, const peers_rays *rays,
                           rk_pool *pool, const peers_lanes *lanes)
{
    const uint32_t threads = rk_pool_threads(pool);
    run r = {.engine = engine, .mode = mode, .rays = rays, .lanes = lanes};
    rk_pool_run(pool, group_count(rays), time_group, &r);
    peers_speed speed = {0};
    for (uint32_t thread = 0; thread < threads; thread++) {
        const work *done = &r.done[thread];
        if (done->rays > 0)
            speed.rate += 1e-6 * done->rays / (threads == 1 ? done->processor : done->wall);
        speed.wall += done->wall;
        speed.processor += done->processor;
    }
    return speed;
}

/* --- Answers ---------------------------------------------------------------------------------- */

static void answer_group(const peers_engine *engine, peers_mode mode, const peers_rays *rays,
                         void *lane, group g, peers_hit *answers)
{
    engine->load(engine, mode, lane, rays->batches + g.first, g.batches,
                 peers_wants_closest(rays->workload));
    engine->trace(engine, mode, lane);
    engine->unload(engine, mode, lane, answers);
}

void peers_answers(const peers_engine *engine, peers_mode mode, const peers_rays *rays,
                   const peers_lanes *lanes, peers_hit *answers)
{
    for (uint32_t index = 0; index < group_count(rays); index++)
        answer_group(engine, mode, rays, lane_of(lanes, 0), group_of(rays, index),
                     answers + (size_t)index * PEERS_GROUP_RAYS);
}

typedef struct comparison {
    const peers_engine *engine;
    peers_mode mode;
    const peers_rays *rays;
    const peers_lanes *lanes;
    const peers_hit *answers;
    peers_differences found[threads_max];
} comparison;

static void note_difference(const comparison *c, const rk_ray *ray, const peers_hit *ours,
                            const peers_hit *theirs, peers_differences *found)
{
    const rk_mesh *mesh = &c->engine->scene->mesh;
    const peers_cause cause = peers_wants_closest(c->rays->workload)
                                  ? peers_difference(mesh, ray, ours, theirs, &found->largest)
                                  : peers_occlusion_difference(mesh, ray, ours->triangle != RK_MISS,
                                                               theirs->triangle != RK_MISS);
    found->rays[cause]++;
}

static void compare_group(uint32_t index, uint32_t thread, void *context)
{
    comparison *c = context;
    const group g = group_of(c->rays, index);
    static _Thread_local peers_hit theirs[PEERS_GROUP_RAYS];
    answer_group(c->engine, c->mode, c->rays, lane_of(c->lanes, thread), g, theirs);
    for (uint32_t i = 0; i < rays_of(c->rays, g); i++) {
        const rk_ray_batch *batch = &c->rays->batches[g.first + i / RK_BATCH_MAX];
        const rk_ray ray = rk_batch_ray(batch, i % RK_BATCH_MAX);
        const peers_hit *ours = &c->answers[g.first * RK_BATCH_MAX + i];
        note_difference(c, &ray, ours, &theirs[i], &c->found[thread]);
    }
}

void peers_differences_add(peers_differences *to, const peers_differences *from)
{
    for (uint32_t cause = 0; cause < PEERS_CAUSES; cause++)
        to->rays[cause] += from->rays[cause];
    for (uint32_t k = 0; k < PEERS_VALUE_KINDS; k++)
        to->largest.of_bound[k] = fmax(to->largest.of_bound[k], from->largest.of_bound[k]);
}

peers_differences peers_compare(const peers_engine *engine, peers_mode mode, const peers_rays *rays,
                                rk_pool *pool, const peers_lanes *lanes, const peers_hit *answers)
{
    comparison c = {
        .engine = engine, .mode = mode, .rays = rays, .lanes = lanes, .answers = answers};
    rk_pool_run(pool, group_count(rays), compare_group, &c);
    for (uint32_t thread = 1; thread < rk_pool_threads(pool); thread++)
        peers_differences_add(&c.found[0], &c.found[thread]);
    return c.found[0];
}

size_t peers_mismatches(const peers_differences *differences)
{
    size_t sum = 0;
    for (uint32_t cause = PEERS_SAME + 1; cause < PEERS_CAUSES; cause++)
        sum += differences->rays[cause];
    return sum;
}
