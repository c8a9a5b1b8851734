/* raykit beside Embree: the same rays through both, in one process and by turns, with their answers
 * compared. `make bench-peers` runs it; the tables are explained in docs/tools.md. */
#include "measure.h"
#include "scenes.h"
#include "tables.h"

#include "accel/accel.h"
#include "base/options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct choices {
    rk_text_list scenes, meshes;
    uint32_t tiles, rounds;
    const char *out;
    bool quiet;
} choices;

static const char summary[] = "Measures raykit beside Embree; make bench-peers runs it.";

static const rk_option rows_of_options[] = {
    {"scene", RK_FIELD(choices, scenes), "NAME",
     "a built-in scene without exact spheres, or room, or room:N; may be repeated. Without it a "
     "teapot,\nstatues and the room"},
    {"mesh", RK_FIELD(choices, meshes), "FILE", "a mesh file besides; may be repeated"},
    {"tiles", RK_FIELD(choices, tiles), "N", "tiles of 16 x 16 rays on each side of the picture", 1,
     1024, 64},
    {"rounds", RK_FIELD(choices, rounds), "N", "measurements of each mode, by turns", 1,
     RK_RUNS_MAX, 5},
    {"quiet", RK_FIELD(choices, quiet), NULL, "print only errors"},
    {"out", RK_FIELD(choices, out), "DIR", "the folder of tables", .initial_text = "out"},
    {0},
};

static const char *const usual_scenes[] = {"teapot",        "statue:4000",   "statue:48000",
                                           "statue:203000", "statue:871000", "room"};

/* In per cent; beyond it, figures by the wall clock are off by more than their spread. */
static const double most_waiting = 2;

enum { engine_raykit, engine_embree, engine_count, threads_most = 2 };

/* What is measured at a time: both engines on one scene. */
typedef struct bench {
    const choices *chosen;
    rk_scene scene;
    peers_engine *engines[engine_count];
    rk_pool *pools[threads_most]; /* of 1 and 2 threads */
    peers_lanes lanes;
    peers_rays rays;
    peers_hit *answers; /* raykit's, ray by ray */
    peers_rows rows;
    double wall, processor; /* seconds of tracing: other programs ran in the difference */
} bench;

typedef double figures[RK_RUNS_MAX];

static peers_row row_of(const bench *b, const peers_engine *engine, const char *workload,
                        uint32_t threads)
{
    peers_row row = {.workload = workload,
                     .triangles = b->scene.mesh.triangle_count,
                     .engine = engine->name,
                     .threads = threads,
                     .bytes = -1};
    snprintf(row.scene, sizeof row.scene, "%s", b->scene.name);
    return row;
}

static void say(const bench *b, const char *workload, uint32_t threads)
{
    const peers_row wanted = row_of(b, b->engines[engine_raykit], workload, threads);
    const peers_row *ours = peers_usual(&b->rows, &wanted);
    const peers_row *best = peers_best(&b->rows, ours, false);
    const peers_row *robust = peers_best(&b->rows, ours, true);
    if (b->chosen->quiet)
        return;
    printf(
        "%-14s %-12s %u thread%s %s: raykit %s %.4g; Embree %s %.4g (raykit %.2f times as fast), "
        "robust %s %.4g (%.2f)\n",
        b->scene.name, workload, threads, threads > 1 ? "s" : "", ours->unit, ours->mode.text,
        ours->timing.median, best->mode.text, best->timing.median, peers_speed_ratio(ours, best),
        robust->mode.text, robust->timing.median, peers_speed_ratio(ours, robust));
    fflush(stdout);
}

/* --- Tracing ---------------------------------------------------------------------------------- */

typedef struct contestant {
    peers_engine *engine;
    peers_mode mode;
    bool usual;
    peers_differences differences;
    figures rates;
} contestant;

static uint32_t list_contestants(const bench *b, contestant *list)
{
    uint32_t count = 0;
    for (uint32_t e = 0; e < engine_count; e++)
        for (uint32_t m = 0; m < b->engines[e]->mode_count; m++, count++) {
            list[count].engine = b->engines[e];
            list[count].mode = b->engines[e]->modes[m];
            list[count].usual = e == engine_raykit && m == b->engines[e]->usual;
        }
    return count;
}

/* Every second round goes backwards, so that no mode always follows the same one. */
static bool time_workload(bench *b, contestant *list, uint32_t count, uint32_t threads,
                          rk_error *error)
{
    const char *workload = peers_workload_names.items[b->rays.workload];
    rk_pool *pool = b->pools[threads - 1];
    for (uint32_t round = 0; round < b->chosen->rounds; round++)
        for (uint32_t k = 0; k < count; k++) {
            contestant *c = &list[round % 2 ? count - 1 - k : k];
            const peers_speed speed = peers_speed_of(c->engine, c->mode, &b->rays, pool, &b->lanes);
            c->rates[round] = speed.rate;
            b->wall += speed.wall;
            b->processor += speed.processor;
        }
    for (uint32_t k = 0; k < count; k++) {
        peers_row row = row_of(b, list[k].engine, workload, threads);
        row.mode = list[k].engine->mode_name(list[k].engine, list[k].mode);
        row.usual = list[k].usual;
        row.unit = "Mrays/s";
        row.timing = rk_timing_of(list[k].rates, b->chosen->rounds);
        row.differences = list[k].differences;
        if (!peers_rows_put(&b->rows, &row, error))
            return false;
    }
    say(b, workload, threads);
    return true;
}

/* Answers are compared first, which also warms the caches. */
static bool run_contest(bench *b, contestant *list, rk_pool *every_processor, rk_error *error)
{
    const uint32_t count = list_contestants(b, list);
    for (uint32_t k = 0; k < count; k++)
        list[k].differences = peers_compare(list[k].engine, list[k].mode, &b->rays, every_processor,
                                            &b->lanes, b->answers);
    bool ok = true;
    for (uint32_t threads = 1; ok && threads <= b->lanes.count; threads++)
        ok = time_workload(b, list, count, threads, error);
    return ok;
}

/* The trees of all builds find the same hits. */
static void compare_builds(bench *b)
{
    for (size_t i = 0; i < b->rows.count; i++) {
        peers_row *row = &b->rows.items[i];
        if (strcmp(row->workload, peers_build) != 0 || strcmp(row->scene, b->scene.name) != 0)
            continue;
        for (uint32_t e = 0; e < engine_count; e++)
            for (uint32_t tree = 0; tree < b->engines[e]->tree_count; tree++)
                if (strcmp(row->engine, b->engines[e]->name) == 0 &&
                    strcmp(row->mode.text, b->engines[e]->tree_name(b->engines[e], tree).text) == 0)
                    row->differences =
                        peers_compare(b->engines[e], (peers_mode){.tree = tree}, &b->rays,
                                      b->pools[b->lanes.count - 1], &b->lanes, b->answers);
    }
}

static bool trace_workload(bench *b, peers_workload workload, contestant *list, rk_error *error)
{
    const peers_engine *raykit = b->engines[engine_raykit];
    const peers_mode usual = raykit->modes[raykit->usual];
    if (!peers_rays_make(&b->rays, workload, peers_raykit_accel(raykit),
                         b->chosen->tiles * RK_TILE_SIDE, error))
        return false;
    bool ok = peers_ray_count(&b->rays) > 0 ||
              rk_fail(error,
                      "%s: no ray of the workload %s arises: its camera sees nothing, or its "
                      "light nothing that the camera sees",
                      b->scene.name, peers_workload_names.items[workload]);
    if (ok) {
        peers_answers(raykit, usual, &b->rays, &b->lanes, b->answers);
        if (workload == PEERS_PRIMARY)
            compare_builds(b);
        ok = run_contest(b, list, b->pools[b->lanes.count - 1], error);
    }
    peers_rays_free(&b->rays);
    return ok;
}

static bool trace_all(bench *b, rk_error *error)
{
    const size_t pixels = (size_t)b->chosen->tiles * b->chosen->tiles * RK_BATCH_MAX;
    const uint32_t modes =
        b->engines[engine_raykit]->mode_count + b->engines[engine_embree]->mode_count;
    contestant *list = rk_allocate(modes, sizeof *list, "modes", error);
    b->answers = rk_allocate(pixels, sizeof *b->answers, "answers", error);
    bool ok = list && b->answers;
    for (uint32_t w = 0; ok && w < PEERS_WORKLOADS; w++)
        ok = trace_workload(b, (peers_workload)w, list, error);
    free(list);
    free(b->answers);
    b->answers = NULL;
    return ok;
}

/* --- Building --------------------------------------------------------------------------------- */

static bool build_in_rounds(bench *b, uint32_t threads, figures *milliseconds, double *bytes,
                            rk_error *error)
{
    for (uint32_t round = 0; round < b->chosen->rounds; round++)
        for (uint32_t e = 0, k = 0; e < engine_count; e++)
            for (uint32_t tree = 0; tree < b->engines[e]->tree_count; tree++, k++) {
                double seconds;
                if (!b->engines[e]->build(b->engines[e], tree, threads, &seconds, &bytes[k], error))
                    return false;
                milliseconds[k][round] = 1e3 * seconds;
            }
    return true;
}

static bool put_builds(bench *b, uint32_t threads, figures *milliseconds, const double *bytes,
                       rk_error *error)
{
    for (uint32_t e = 0, k = 0; e < engine_count; e++)
        for (uint32_t tree = 0; tree < b->engines[e]->tree_count; tree++, k++) {
            const peers_engine *engine = b->engines[e];
            peers_row row = row_of(b, engine, peers_build, threads);
            row.mode = engine->tree_name(engine, tree);
            row.usual = e == engine_raykit && tree == engine->modes[engine->usual].tree;
            row.unit = "ms";
            row.timing = rk_timing_of(milliseconds[k], b->chosen->rounds);
            row.bytes = bytes[k];
            if (!peers_rows_put(&b->rows, &row, error))
                return false;
        }
    say(b, peers_build, threads);
    return true;
}

/* The trees built last, on one thread, are those that are traced. */
static bool build_all(bench *b, rk_error *error)
{
    figures *milliseconds =
        rk_allocate(engine_count * PEERS_TREES_MAX, sizeof *milliseconds, "times", error);
    double bytes[engine_count * PEERS_TREES_MAX];
    bool ok = milliseconds != NULL;
    for (uint32_t threads = b->lanes.count; ok && threads > 0; threads--)
        ok = build_in_rounds(b, threads, milliseconds, bytes, error) &&
             put_builds(b, threads, milliseconds, bytes, error);
    free(milliseconds);
    return ok;
}

/* --- Scenes ----------------------------------------------------------------------------------- */

static bool measure_scene(bench *b, rk_error *error)
{
    b->engines[engine_raykit] = peers_raykit_open(&b->scene, error);
    b->engines[engine_embree] =
        b->engines[engine_raykit] ? peers_embree_open(&b->scene, error) : NULL;
    bool ok = b->engines[engine_embree] &&
              peers_lanes_init(&b->lanes, threads_most, b->engines, engine_count, error) &&
              build_all(b, error) && trace_all(b, error);
    peers_lanes_free(&b->lanes);
    for (uint32_t e = 0; e < engine_count; e++)
        if (b->engines[e])
            b->engines[e]->close(b->engines[e]);
    b->engines[engine_raykit] = b->engines[engine_embree] = NULL;
    return ok;
}

static bool measure_all(bench *b, rk_error *error)
{
    const rk_text_list *scenes = &b->chosen->scenes, *meshes = &b->chosen->meshes;
    for (size_t i = 0; i < scenes->count + meshes->count; i++) {
        const bool made =
            i < scenes->count
                ? peers_scene(&b->scene, scenes->items[i], error)
                : peers_mesh_scene(&b->scene, meshes->items[i - scenes->count], error);
        if (!made)
            return false;
        const bool ok = measure_scene(b, error);
        rk_scene_free(&b->scene);
        if (!ok)
            return false;
    }
    return true;
}

/* The share of the time in which the threads had to wait for other programs, in per cent. */
static double waited(const bench *b)
{
    return 100 * (1 - b->processor / b->wall);
}

static bool write_tables(const bench *b, rk_error *error)
{
    char rounds[16], rays[32], date[32], waiting[32];
    const time_t now = time(NULL);
    snprintf(rounds, sizeof rounds, "%u", b->chosen->rounds);
    snprintf(rays, sizeof rays, "%u", b->chosen->tiles * b->chosen->tiles * RK_BATCH_MAX);
    strftime(date, sizeof date, "%Y-%m-%d %H:%M UTC", gmtime(&now));
    snprintf(waiting, sizeof waiting, "%.1f", waited(b));
    const peers_name embree = peers_embree_version();
    const char *const about[] = {"Embree", embree.text, "primary rays", rays,    "rounds", rounds,
                                 "date",   date,        "waited (%)",   waiting, NULL};
    return peers_tables_write(&b->rows, b->chosen->out, about, error);
}

/* Of raykit's own trees all must agree. */
static bool check_answers(const bench *b, rk_error *error)
{
    const size_t own = peers_differing(&b->rows, "raykit", PEERS_SHARED);
    const size_t unexplained = peers_differing(&b->rows, "embree", PEERS_BOX);
    if (unexplained > 0)
        fprintf(stderr,
                "bench-peers: in %zu answers Embree differs by more than rounding explains: see "
                "%s/tables/peers_causes.csv\n",
                unexplained, b->chosen->out);
    return own == 0 ||
           rk_fail(error,
                   "raykit's own trees differ in %zu answers: %s/tables/peers_mismatches.csv says "
                   "which, and one of them is wrong",
                   own, b->chosen->out);
}

static bool work(choices *chosen, rk_error *error)
{
    bench b = {.chosen = chosen};
    bool ok = true;
    if (chosen->scenes.count == 0)
        for (size_t i = 0; i < sizeof usual_scenes / sizeof *usual_scenes; i++)
            chosen->scenes.items[chosen->scenes.count++] = usual_scenes[i];
    for (uint32_t threads = 1; ok && threads <= threads_most; threads++)
        ok = (b.pools[threads - 1] = rk_pool_start(threads, error)) != NULL;
    ok = ok && measure_all(&b, error) && write_tables(&b, error) && check_answers(&b, error);
    for (uint32_t threads = 1; threads <= threads_most; threads++)
        rk_pool_stop(b.pools[threads - 1]);
    peers_rows_free(&b.rows);
    if (ok && !chosen->quiet)
        printf("bench-peers: wrote %s/tables/peers.csv, and tables beside it\n", chosen->out);
    if (ok && waited(&b) > most_waiting)
        fprintf(
            stderr,
            "bench-peers: other programs took %.0f %% of the processors' time: builds and figures "
            "of 2 threads, which are by the wall clock, are too slow; measure on a quiet machine\n",
            waited(&b));
    return ok;
}

int main(int argc, char **argv)
{
    rk_error error = {""};
    choices chosen;
    rk_options_set_defaults(rows_of_options, &chosen);
    const rk_option_table table = {rows_of_options, &chosen};
    const rk_options_result result = rk_options_parse(argc, argv, summary, &table, 1, &error);
    if (result == RK_OPTIONS_DONE || (result == RK_OPTIONS_OK && work(&chosen, &error)))
        return 0;
    fprintf(stderr, "bench-peers: %s\n", error.text);
    return 1;
}
