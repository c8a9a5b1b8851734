/* The tables of --steps: time per ray, from the binary tree to packets of rays. All steps trace the
 * same rays in each round, one after the other, so that a busy moment costs all of them alike. A
 * step that finds other hits is left out. */
#include "driver.h"

#include "accel/query/trace.h"
#include "base/random.h"
#include "features/wide_bvh.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const workload_names[WORKLOADS] = {"primary", "shadow", "diffuse"};
static const char *const order_names[ORDERS] = {"16 x 1", "4 x 4"};

/* --- Steps ------------------------------------------------------------------------------------ */

typedef struct answers {
    rk_hit_batch hits;
    rk_occlusion_batch occluded;
} answers;

typedef void tracer(const rk_accel *accel, bool closest, const rk_ray_batch *rays, answers *found,
                    rk_counters *counters);

static void trace_together(const rk_accel *accel, bool closest, const rk_ray_batch *rays,
                           answers *found, rk_counters *counters)
{
    if (closest)
        rk_accel_closest(accel, rays, &found->hits, counters);
    else
        rk_accel_occluded(accel, rays, &found->occluded, counters);
}

/* Each ray is a batch of its own. */
static void trace_alone(const rk_accel *accel, bool closest, const rk_ray_batch *rays,
                        answers *found, rk_counters *counters)
{
    rk_ray_batch one;
    answers its;
    for (uint32_t i = 0; i < rays->count; i++) {
        const rk_ray ray = rk_batch_ray(rays, i);
        one.count = 0;
        rk_batch_push(&one, &ray);
        trace_together(accel, closest, &one, &its, counters);
        if (closest) {
            const rk_hit hit = rk_batch_hit(&its.hits, 0);
            rk_batch_put_hit(&found->hits, i, &hit);
        } else {
            found->occluded.occluded[i] = its.occluded.occluded[0];
        }
    }
}

/* By the readable functions, whatever tree it is. */
static void trace_readably(const rk_accel *accel, bool closest, const rk_ray_batch *rays,
                           answers *found, rk_counters *counters)
{
    for (uint32_t i = 0; i < rays->count; i++) {
        const rk_ray ray = rk_batch_ray(rays, i);
        if (closest) {
            const rk_hit hit = rk_wide_bvh_closest(&accel->wide, &ray, counters);
            rk_batch_put_hit(&found->hits, i, &hit);
        } else {
            found->occluded.occluded[i] = rk_wide_bvh_occluded(&accel->wide, &ray, counters);
        }
    }
}

enum { STEPS_MAX = 16 };

typedef struct step {
    char name[48];
    tracer *trace;
    int order;
    rk_accel accel;
    double bytes; /* per triangle */
    bool is_left_out;
    double times[WORKLOADS][RK_RUNS_MAX]; /* nanoseconds per ray */
    uint64_t visits[WORKLOADS], sum[WORKLOADS];
} step;

typedef struct step_list {
    uint32_t count, first_kernel;
    step *steps;
} step_list;

/* False if this machine cannot take the step. */
static bool add_step(step_list *list, const rk_driver *driver, const char *name, tracer *trace,
                     int order, rk_accel_kind kind, rk_error *error)
{
    step *s = &list->steps[list->count];
    *s = (step){.trace = trace, .order = order};
    snprintf(s->name, sizeof s->name, "%s", name);
    const rk_accel_options options = {kind, driver->bins, NULL};
    if (!rk_accel_build_with(&s->accel, &options, &driver->scene, error))
        return false;
    const tree_shape tree =
        s->accel.wide.node_count ? shape_of_wide(&s->accel.wide) : shape_of_binary(&s->accel.bvh);
    s->bytes = tree.bytes / driver->scene.mesh.triangle_count;
    list->count++;
    return true;
}

/* The renderer's tree by its own kernels, as far as the machine has them. */
static void add_kernels(step_list *list, const rk_driver *driver, const char *name, tracer *trace,
                        int order)
{
    static const char *const sets[] = {"scalar", "sse2", "avx2", "avx512"};
    for (int k = 0; k < 4; k++) {
        char full_name[48];
        rk_error missing;
        snprintf(full_name, sizeof full_name, "%s: %s", name, sets[k]);
        setenv("RAYKIT_ISA", sets[k], 1);
        add_step(list, driver, full_name, trace, order, RK_ACCEL_WIDE, &missing);
    }
}

static bool add_steps(step_list *list, const rk_driver *driver, rk_error *error)
{
    const char *given = getenv("RAYKIT_ISA");
    char isa[32];
    snprintf(isa, sizeof isa, "%s", given ? given : "");
    list->steps = rk_allocate_unset(STEPS_MAX, sizeof *list->steps, "steps", error);
    if (!list->steps ||
        !add_step(list, driver, "two children", trace_together, ROWS, RK_ACCEL_SAH_3, error) ||
        !add_step(list, driver, "eight children", trace_together, ROWS, RK_ACCEL_COLLAPSED,
                  error) ||
        !add_step(list, driver, "built from the mesh", trace_readably, ROWS, RK_ACCEL_WIDE, error))
        return false;
    list->first_kernel = list->count;
    add_kernels(list, driver, "one per call", trace_alone, ROWS);
    add_kernels(list, driver, "16 x 1 pixels", trace_together, ROWS);
    add_kernels(list, driver, "4 x 4 pixels", trace_together, SQUARES);
    if (given)
        setenv("RAYKIT_ISA", isa, 1);
    else
        unsetenv("RAYKIT_ISA");
    return true;
}

/* --- Measuring -------------------------------------------------------------------------------- */

/* Depends on every bit of the answers, but not on their order. */
static uint64_t sum_of(const answers *found, bool closest, uint32_t count)
{
    uint64_t sum = 0;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t bits[3] = {0, 0, 0};
        if (closest && found->hits.triangle[i] != RK_MISS) {
            memcpy(&bits[0], &found->hits.t[i], sizeof bits[0]);
            memcpy(&bits[1], &found->hits.u[i], sizeof bits[1]);
            memcpy(&bits[2], &found->hits.v[i], sizeof bits[2]);
        }
        sum += closest ? rk_hash(found->hits.triangle[i], bits[0], bits[1], bits[2])
                       : found->occluded.occluded[i];
    }
    return sum;
}

static void measure(step *s, const ray_set *set, int workload, uint32_t round)
{
    const bool closest = workload != SHADOW;
    rk_counters counters = {0};
    answers found;
    double seconds = 0;
    s->sum[workload] = 0;
    for (uint32_t b = 0; b < set->batches; b++) {
        const double start = rk_clock_thread();
        s->trace(&s->accel, closest, &set->batch[b], &found, &counters);
        seconds += rk_clock_thread() - start;
        s->sum[workload] += sum_of(&found, closest, set->batch[b].count);
    }
    s->times[workload][round] = 1e9 * seconds / (set->rays > 0 ? set->rays : 1);
    s->visits[workload] = counters.box_tests / (s->accel.wide.node_count ? RK_WIDE_CHILDREN : 2);
}

/* A unit that is still unsolved finds other hits: its times would say nothing. */
static void leave_out_others(step_list *list, const rk_driver *driver)
{
    for (uint32_t i = 1; i < list->count; i++) {
        step *s = &list->steps[i];
        s->is_left_out = memcmp(s->sum, list->steps[0].sum, sizeof s->sum) != 0;
        if (s->is_left_out)
            fprintf(stderr, "%s: \"%s\" finds other hits than the binary tree, and is left out\n",
                    driver->feature, s->name);
    }
}

/* --- Rows ------------------------------------------------------------------------------------- */

static bool put_step(const rk_driver *driver, const step_list *list, step *s, rk_error *error)
{
    static const char *const header[] = {"scene",       "step",         "primary",
                                         "shadow",      "diffuse",      "primary_gain",
                                         "shadow_gain", "diffuse_gain", "bytes_per_triangle"};
    enum { COLUMNS = sizeof header / sizeof *header };
    char path[4096], text[COLUMNS][32];
    const char *cells[COLUMNS] = {driver->scene.name, s->name};
    for (int w = 0; w < WORKLOADS; w++) {
        const double first = rk_timing_of(list->steps[0].times[w], driver->runs).median;
        const double now = rk_timing_of(s->times[w], driver->runs).median;
        snprintf(text[2 + w], sizeof text[0], "%.4g", now);
        snprintf(text[5 + w], sizeof text[0], "%.3g", now > 0 ? first / now : 0);
    }
    snprintf(text[8], sizeof text[8], "%.3g", s->bytes);
    for (int i = 2; i < COLUMNS; i++)
        cells[i] = text[i];
    if (!driver->quiet)
        printf("%-20s %6s %6s %6s ns per ray, %s bytes per triangle\n", s->name, text[2], text[3],
               text[4], text[8]);
    return rk_driver_table(driver, "wide_bvh_steps", path, error) &&
           rk_table_put(path, header, cells, COLUMNS, 2, error);
}

/* How many rays share a visit, in packets. */
static bool put_coherence(const rk_driver *driver, const step *alone, const step *packets,
                          const ray_set sets[WORKLOADS], rk_error *error)
{
    static const char *const header[] = {"scene", "rays", "packets", "alone", "together", "shared"};
    char path[4096], text[3][32];
    if (!rk_driver_table(driver, "wide_bvh_coherence", path, error))
        return false;
    bool ok = true;
    for (int w = 0; ok && w < WORKLOADS; w++) {
        if (sets[w].rays == 0 || packets->visits[w] == 0)
            continue;
        const double visits = (double)alone->visits[w], shared = (double)packets->visits[w];
        snprintf(text[0], sizeof text[0], "%.3g", visits / sets[w].rays);
        snprintf(text[1], sizeof text[1], "%.3g", shared / sets[w].rays);
        snprintf(text[2], sizeof text[2], "%.3g", visits / shared);
        const char *cells[] = {driver->scene.name,
                               workload_names[w],
                               order_names[packets->order],
                               text[0],
                               text[1],
                               text[2]};
        ok = rk_table_put(path, header, cells, 6, 3, error);
    }
    return ok;
}

static bool put_tables(step_list *list, const rk_driver *driver, const ray_set sets[WORKLOADS],
                       rk_error *error)
{
    bool ok = true;
    leave_out_others(list, driver);
    for (uint32_t i = 0; ok && i < list->count; i++)
        ok = list->steps[i].is_left_out || put_step(driver, list, &list->steps[i], error);
    const uint32_t kernels = (list->count - list->first_kernel) / 3,
                   end = list->first_kernel + kernels;
    for (uint32_t k = 1; ok && kernels && k < 3; k++)
        ok = put_coherence(driver, &list->steps[end - 1], &list->steps[end - 1 + k * kernels], sets,
                           error);
    return ok;
}

bool put_steps(rk_driver *driver, rk_error *error)
{
    const rk_scene *scene = &driver->scene;
    if (scene->moving_count || scene->sphere_count || !scene->mesh.triangle_count)
        return rk_fail(error,
                       "--steps: %s has moving objects, spheres or no triangles; choose a scene of "
                       "triangles at rest, such as statue",
                       scene->name);
    ray_set sets[ORDERS][WORKLOADS] = {{{0}}};
    step_list list = {0};
    bool ok = add_steps(&list, driver, error);
    for (int order = 0; ok && order < ORDERS; order++)
        ok = make_rays(sets[order], driver, order, &list.steps[list.count - 1].accel, error);
    for (uint32_t round = 0; ok && round < driver->runs; round++)
        for (int w = 0; w < WORKLOADS; w++)
            for (uint32_t i = 0; i < list.count; i++)
                measure(&list.steps[i], &sets[list.steps[i].order][w], w, round);
    ok = ok && put_tables(&list, driver, sets[ROWS], error);
    for (uint32_t i = 0; i < list.count; i++)
        rk_accel_free(&list.steps[i].accel);
    for (int order = 0; order < ORDERS; order++)
        free_rays(sets[order]);
    free(list.steps);
    return ok;
}
