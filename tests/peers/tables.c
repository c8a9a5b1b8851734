#include "tables.h"

#include "base/file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char peers_build[] = "build";

bool peers_rows_put(peers_rows *rows, const peers_row *row, rk_error *error)
{
    if (rows->count == rows->capacity) {
        const size_t capacity = rows->capacity ? 2 * rows->capacity : 256;
        peers_row *items = rk_allocate(capacity, sizeof *items, "results", error);
        if (!items)
            return false;
        if (rows->count > 0)
            memcpy(items, rows->items, rows->count * sizeof *items);
        free(rows->items);
        *rows = (peers_rows){rows->count, capacity, items};
    }
    rows->items[rows->count++] = *row;
    return true;
}

void peers_rows_free(peers_rows *rows)
{
    free(rows->items);
    *rows = (peers_rows){0};
}

/* --- Choosing --------------------------------------------------------------------------------- */

static bool is_build(const peers_row *row)
{
    return strcmp(row->workload, peers_build) == 0;
}

static bool is_of(const peers_row *row, const char *engine)
{
    return strcmp(row->engine, engine) == 0;
}

static bool is_beside(const peers_row *a, const peers_row *b)
{
    return a->threads == b->threads && strcmp(a->workload, b->workload) == 0 &&
           strcmp(a->scene, b->scene) == 0;
}

static bool is_robust(const peers_row *row)
{
    return strstr(row->mode.text, "robust") != NULL;
}

const peers_row *peers_usual(const peers_rows *rows, const peers_row *row)
{
    for (size_t i = 0; i < rows->count; i++)
        if (rows->items[i].usual && is_beside(&rows->items[i], row))
            return &rows->items[i];
    return NULL;
}

const peers_row *peers_best(const peers_rows *rows, const peers_row *ours, bool robust)
{
    const peers_row *best = NULL;
    for (size_t i = 0; i < rows->count; i++) {
        const peers_row *row = &rows->items[i];
        if (!is_of(row, "embree") || !is_beside(row, ours) || (robust && !is_robust(row)))
            continue;
        if (is_build(row) && strcmp(row->mode.text, robust ? "medium-robust" : "medium") != 0)
            continue;
        if (!best || row->timing.median > best->timing.median)
            best = row;
    }
    return best;
}

double peers_speed_ratio(const peers_row *ours, const peers_row *theirs)
{
    return is_build(ours) ? theirs->timing.median / ours->timing.median
                          : ours->timing.median / theirs->timing.median;
}

/* --- Writing ---------------------------------------------------------------------------------- */

/* A file's name may hold commas and quotes. */
static void put_cell(FILE *file, const char *text)
{
    if (!strpbrk(text, ",\"\r\n")) {
        fputs(text, file);
        return;
    }
    putc('"', file);
    for (; *text; text++) {
        if (*text == '"')
            putc('"', file);
        putc(*text, file);
    }
    putc('"', file);
}

static void put_place(FILE *file, const peers_row *row)
{
    fprintf(file, "%s,", row->workload);
    put_cell(file, row->scene);
}

static void write_all(FILE *file, const peers_rows *rows)
{
    fputs("workload,scene,engine,mode,threads,value,unit,ratio_to_raykit,mismatches\n", file);
    for (size_t i = 0; i < rows->count; i++) {
        const peers_row *row = &rows->items[i];
        put_place(file, row);
        fprintf(file, ",%s,%s,%u,%.6g,%s,%.6g,%zu\n", row->engine, row->mode.text, row->threads,
                row->timing.median, row->unit,
                row->timing.median / peers_usual(rows, row)->timing.median,
                peers_mismatches(&row->differences));
    }
}

static void write_spread(FILE *file, const peers_rows *rows)
{
    fputs("workload,scene,triangles,engine,mode,threads,unit,median,min,max,rounds\n", file);
    for (size_t i = 0; i < rows->count; i++) {
        const peers_row *row = &rows->items[i];
        put_place(file, row);
        fprintf(file, ",%u,%s,%s,%u,%s,%.6g,%.6g,%.6g,%u\n", row->triangles, row->engine,
                row->mode.text, row->threads, row->unit, row->timing.median, row->timing.min,
                row->timing.max, row->timing.runs);
    }
}

/* How many times as fast as Embree's fastest mode the workload is meant to be. */
static double goal_of(const peers_row *row)
{
    static const double goals[PEERS_WORKLOADS] = {
        [PEERS_PRIMARY] = 1.4,
        [PEERS_POINT_SHADOW] = 1.2,
        [PEERS_AREA_SHADOW] = 1.2,
        [PEERS_DIFFUSE] = 1.1,
    };
    for (uint32_t w = 0; w < PEERS_WORKLOADS; w++)
        if (strcmp(row->workload, peers_workload_names.items[w]) == 0)
            return goals[w];
    return 1.2; /* building */
}

static void put_best(FILE *file, const peers_rows *rows, const peers_row *ours)
{
    const peers_row *best = peers_best(rows, ours, false), *robust = peers_best(rows, ours, true);
    const double ratio = peers_speed_ratio(ours, best), goal = goal_of(ours);
    put_place(file, ours);
    fprintf(file, ",%u,%u,%s,%s,%.6g,%s,%.6g,%.3f,%.3g,%s,%s,%.6g,%.3f\n", ours->triangles,
            ours->threads, ours->unit, ours->mode.text, ours->timing.median, best->mode.text,
            best->timing.median, ratio, goal, ratio >= goal ? "yes" : "no", robust->mode.text,
            robust->timing.median, peers_speed_ratio(ours, robust));
}

/* A row for each workload, scene and number of threads. */
static void write_best(FILE *file, const peers_rows *rows)
{
    fputs("workload,scene,triangles,threads,unit,raykit_mode,raykit,embree_mode,embree,speed_ratio,"
          "goal,goal_reached,robust_mode,robust,robust_speed_ratio\n",
          file);
    for (uint32_t w = 0; w <= PEERS_WORKLOADS; w++) {
        const char *workload = w < PEERS_WORKLOADS ? peers_workload_names.items[w] : peers_build;
        for (size_t i = 0; i < rows->count; i++)
            if (rows->items[i].usual && strcmp(rows->items[i].workload, workload) == 0)
                put_best(file, rows, &rows->items[i]);
    }
}

static bool is_statue(const peers_row *row)
{
    return strncmp(row->scene, "statue", 6) == 0;
}

/* The same as points of curves over the number of triangles: statues differ in nothing else. */
static void write_curves(FILE *file, const peers_rows *rows)
{
    fputs("workload,scene,triangles,threads,engine,value\n", file);
    for (size_t i = 0; i < rows->count; i++) {
        const peers_row *ours = &rows->items[i];
        const char *const titles[] = {"raykit", "Embree", "Embree, robust"};
        if (!ours->usual || !is_statue(ours))
            continue;
        const peers_row *points[] = {ours, peers_best(rows, ours, false),
                                     peers_best(rows, ours, true)};
        for (int k = 0; k < 3; k++) {
            put_place(file, ours);
            fprintf(file, ",%u,%u,\"%s\",%.6g\n", ours->triangles, ours->threads, titles[k],
                    points[k]->timing.median);
        }
    }
}

static void write_memory(FILE *file, const peers_rows *rows)
{
    fputs("scene,triangles,engine,tree,bytes_per_triangle\n", file);
    for (size_t i = 0; i < rows->count; i++) {
        const peers_row *row = &rows->items[i];
        if (!is_build(row) || row->threads != 1 || row->bytes < 0)
            continue;
        put_cell(file, row->scene);
        fprintf(file, ",%u,%s,%s,%.1f\n", row->triangles, row->engine, row->mode.text,
                row->bytes / row->triangles);
    }
}

/* Rays that differ, of each mode. */
static void write_mismatches(FILE *file, const peers_rows *rows)
{
    fputs("workload,scene,engine,mode,cause,rays\n", file);
    for (size_t i = 0; i < rows->count; i++) {
        const peers_row *row = &rows->items[i];
        for (uint32_t cause = PEERS_SAME + 1; row->threads == 1 && cause < PEERS_CAUSES; cause++)
            if (row->differences.rays[cause] > 0) {
                put_place(file, row);
                fprintf(file, ",%s,%s,%s,%zu\n", row->engine, row->mode.text,
                        peers_cause_names.items[cause], row->differences.rays[cause]);
            }
    }
}

static size_t rays_by_cause(const peers_rows *rows, uint32_t cause, const char *engine, bool robust)
{
    size_t sum = 0;
    for (size_t i = 0; i < rows->count; i++) {
        const peers_row *row = &rows->items[i];
        if (row->threads == 1 && is_of(row, engine) && is_robust(row) == robust)
            sum += row->differences.rays[cause];
    }
    return sum;
}

size_t peers_differing(const peers_rows *rows, const char *engine, peers_cause first)
{
    size_t sum = 0;
    for (uint32_t cause = first; cause < PEERS_CAUSES; cause++)
        sum += rays_by_cause(rows, cause, engine, false) + rays_by_cause(rows, cause, engine, true);
    return sum;
}

/* All rays of all modes, by cause. */
static void write_causes(FILE *file, const peers_rows *rows)
{
    fputs("cause,meaning,raykit,embree,robust\n", file);
    for (uint32_t cause = 0; cause < PEERS_CAUSES; cause++)
        fprintf(file, "%s,\"%s\",%zu,%zu,%zu\n", peers_cause_names.items[cause],
                peers_cause_meaning((peers_cause)cause),
                rays_by_cause(rows, cause, "raykit", false),
                rays_by_cause(rows, cause, "embree", false),
                rays_by_cause(rows, cause, "embree", true));
}

/* The largest differences between values of equal hits. */
static void write_values(FILE *file, const peers_rows *rows)
{
    peers_differences fast = {0}, robust = {0};
    for (size_t i = 0; i < rows->count; i++)
        if (is_of(&rows->items[i], "embree"))
            peers_differences_add(is_robust(&rows->items[i]) ? &robust : &fast,
                                  &rows->items[i].differences);
    fputs("value,embree,robust\n", file);
    for (uint32_t k = 0; k < PEERS_VALUE_KINDS; k++)
        fprintf(file, "%s,%.4f,%.4f\n", peers_value_names.items[k], fast.largest.of_bound[k],
                robust.largest.of_bound[k]);
}

static void write_machine(FILE *file, const char *const *about)
{
    fputs("item,value\n", file);
    for (; *about; about += 2) {
        put_cell(file, about[0]);
        putc(',', file);
        put_cell(file, about[1]);
        putc('\n', file);
    }
}

static bool have_statues(const peers_rows *rows)
{
    bool found = false;
    for (size_t i = 0; i < rows->count; i++)
        found = found || is_statue(&rows->items[i]);
    return found;
}

typedef struct table_path {
    char text[4096];
} table_path;

static table_path path_of(const char *out, const char *name)
{
    table_path path;
    snprintf(path.text, sizeof path.text, "%.3000s/tables/%s.csv", out, name);
    return path;
}

bool peers_tables_write(const peers_rows *rows, const char *out, const char *const *about,
                        rk_error *error)
{
    static const struct {
        const char *name;
        void (*write)(FILE *file, const peers_rows *rows);
    } tables[] = {
        {"peers_spread", write_spread},
        {"peers_best", write_best},
        {"peers_curves", write_curves},
        {"peers_memory", write_memory},
        {"peers_mismatches", write_mismatches},
        {"peers_causes", write_causes},
        {"peers_values", write_values},
        {"peers_machine", NULL},
        {"peers", write_all},
    };
    char folder[4096];
    snprintf(folder, sizeof folder, "%.3000s/tables", out);
    bool ok = rk_file_make_folder(folder, error);
    for (size_t i = 0; ok && i < sizeof tables / sizeof *tables; i++) {
        const table_path path = path_of(out, tables[i].name);
        rk_file file;
        if (tables[i].write == write_curves && !have_statues(rows)) {
            remove(path.text); /* the report has no curves then */
            continue;
        }
        ok = rk_file_begin(&file, path.text, error);
        if (ok && tables[i].write)
            tables[i].write(file.stream, rows);
        else if (ok)
            write_machine(file.stream, about);
        ok = ok && rk_file_commit(&file, error);
    }
    return ok;
}
