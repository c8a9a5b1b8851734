/* A process alone takes tiles from its pool's counter. In a team its threads take them from the
 * counter of all, and when that has run out, the processes exchange the tiles that they have
 * rendered. */
#include "render/tile_run.h"

#include "render/tiles.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

typedef struct tile_job {
    const rk_tile_run *run;
    rk_task *task;
    void *context;
    rk_team *team; /* NULL: alone */
    uint32_t tiles, threads;
    uint32_t *taken; /* by this process, one after the other */
    atomic_uint taken_count;
    atomic_uint begun; /* tiles of all processes, as far as this one knows */
} tile_job;

/* --- Tiles as messages ------------------------------------------------------------------------ */

/* The tile's number, and then its pixels, row by row, with room for those of a whole tile. */
static size_t message_size(const tile_job *job)
{
    return sizeof(uint32_t) + RK_BATCH_MAX * job->run->pixel_size;
}

static void copy_tile(const tile_job *job, uint32_t index, char *message, bool is_to_message)
{
    const rk_tile tile = rk_tile_at(job->run->options, index);
    const size_t size = job->run->pixel_size, row = tile.width * size;
    for (uint32_t y = 0; y < tile.height; y++, message += row) {
        const size_t first = (size_t)(tile.y + y) * job->run->options->width + tile.x;
        char *pixels = (char *)job->run->pixels + first * size;
        memcpy(is_to_message ? message : pixels, is_to_message ? pixels : message, row);
    }
}

static void write_tile(const tile_job *job, uint32_t index, char *message)
{
    memcpy(message, &index, sizeof index);
    copy_tile(job, index, message + sizeof index, true);
}

static void read_tile(const tile_job *job, char *message)
{
    uint32_t index;
    memcpy(&index, message, sizeof index);
    copy_tile(job, index, message + sizeof index, false);
}

static bool exchange_tiles(const tile_job *job, rk_error *error)
{
    const size_t size = message_size(job);
    char *own = rk_allocate(job->taken_count, size, "tiles", error), *all = NULL;
    uint32_t total = 0;
    for (uint32_t i = 0; own && i < job->taken_count; i++)
        write_tile(job, job->taken[i], own + i * size);
    const bool ok = own && job->team->exchange(job->team->context, own, job->taken_count, size,
                                               (void **)&all, &total, error);
    for (uint32_t i = 0; ok && i < total; i++)
        read_tile(job, all + i * size);
    free(all);
    free(own);
    return ok;
}

/* --- Counters --------------------------------------------------------------------------------- */

/* Returns the sum over the threads, and begins anew. */
static rk_counters take_counters(const tile_job *job)
{
    rk_counters sum = {0};
    for (uint32_t i = 0; i < job->threads; i++) {
        rk_counters_add(&sum, &job->run->counters[i]);
        job->run->counters[i] = (rk_counters){0};
    }
    return sum;
}

/* Adds the work of all processes to what each had counted before. */
static bool exchange_counters(const tile_job *job, const rk_counters *before, rk_error *error)
{
    const rk_counters own = take_counters(job);
    rk_counters *all = NULL;
    uint32_t total = 0;
    if (!job->team->exchange(job->team->context, &own, 1, sizeof own, (void **)&all, &total, error))
        return false;
    job->run->counters[0] = *before;
    for (uint32_t i = 0; i < total; i++)
        rk_counters_add(&job->run->counters[0], &all[i]);
    free(all);
    return true;
}

/* --- Running ---------------------------------------------------------------------------------- */

/* Tiles are begun in their order, so `end` of them are by now. */
static void show_progress(tile_job *job, uint32_t end)
{
    uint32_t before = atomic_load(&job->begun);
    while (before < end && !atomic_compare_exchange_weak(&job->begun, &before, end))
        ;
    if (job->run->progress && before < end)
        rk_progress_steps(job->run->progress, end - before);
}

static void run_tile(uint32_t index, uint32_t thread, void *context)
{
    const tile_job *job = context;
    job->task(index, thread, job->context);
    if (job->run->progress)
        rk_progress_step(job->run->progress);
}

static void take_tiles(uint32_t item, uint32_t thread, void *context)
{
    (void)item;
    tile_job *job = context;
    for (;;) {
        const uint32_t index = job->team->next(job->team->context, job->threads);
        if (index >= job->tiles)
            return;
        job->taken[atomic_fetch_add(&job->taken_count, 1)] = index;
        job->task(index, thread, job->context);
        show_progress(job, index + 1);
    }
}

static bool run_with_team(tile_job *job, rk_pool *pool, rk_error *error)
{
    const rk_counters before = take_counters(job);
    job->taken = rk_allocate_unset(job->tiles, sizeof *job->taken, "tiles", error);
    bool ok = job->taken != NULL;
    if (ok) {
        rk_pool_run(pool, job->threads, take_tiles, job);
        show_progress(job, job->tiles);
        ok = exchange_tiles(job, error) && exchange_counters(job, &before, error);
    }
    free(job->taken);
    return ok;
}

bool rk_tile_run_all(const rk_tile_run *run, rk_pool *pool, rk_task *task, void *context,
                     rk_error *error)
{
    tile_job job = {.run = run,
                    .task = task,
                    .context = context,
                    .team = rk_pool_team(pool),
                    .tiles = rk_tile_count(run->options),
                    .threads = rk_pool_threads(pool)};
    if (job.team)
        return run_with_team(&job, pool, error);
    rk_pool_run(pool, job.tiles, run_tile, &job);
    return true;
}
