/* The largest errors of the kit's numerical routines, found by search, beside their bounds.
 * Fails where an error exceeds its bound, and where a bound is so far above every error found that
 * it says nothing.
 *
 * Prints TAP, a line for each measure; with --out FOLDER also tables/stress.csv there, the worst
 * first. RAYKIT_STRESS=N searches N times as long (make stress). An argument is a part of the names
 * of the measures to search, --list prints all names. */
#include "measure.h"

#include "base/error.h"
#include "base/file.h"
#include "base/table.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TRIALS = 60000, MEASURES_MAX = 100 };

static const measures *const groups[] = {
    &measures_of_vectors,  &measures_of_rays,         &measures_of_surfaces, &measures_of_shading,
    &measures_of_lights,   &measures_of_samples,      &measures_of_camera,   &measures_of_motion,
    &measures_of_pictures, &measures_of_transparency,
};

typedef struct row {
    const measure *measure;
    finding finding;
    bool passed;
} row;

typedef struct rows {
    size_t count;
    row all[MEASURES_MAX];
} rows;

static void collect(rows *table, const char *part)
{
    for (size_t g = 0; g < sizeof groups / sizeof *groups; g++)
        for (size_t i = 0; i < groups[g]->count && table->count < MEASURES_MAX; i++) {
            const measure *m = &groups[g]->list[i];
            if (strstr(m->routine, part) || strstr(m->what, part))
                table->all[table->count++] = (row){.measure = m};
        }
}

static double share(const row *r)
{
    double error = fmax(r->finding.error, 0);
    return r->measure->bound > 0 ? error / r->measure->bound : error > 0 ? (double)INFINITY : 0;
}

/* --- Verdicts --------------------------------------------------------------------------------- */

static void print_inputs(FILE *file, const row *r)
{
    for (unsigned i = 0; i < measure_input_count(r->measure); i++)
        fprintf(file, "%s%a", i ? " " : "", (double)r->finding.input[i]);
}

static void judge(row *r)
{
    const measure *m = r->measure;
    double error = r->finding.error;
    bool is_found = error > (double)-INFINITY, holds = error <= m->bound;
    bool says_much = m->slack || m->bound <= SLACK_MAX * fmax(error, 0);
    r->passed = is_found && holds && says_much;
    if (!is_found)
        printf("# no input is in the measure's domain: widen it\n");
    else if (!holds)
        printf("# the error is %.4g, and its bound %.4g (%s)\n", error, m->bound, m->because);
    else if (!says_much)
        printf("# the bound, %.4g, is more than %g times the largest error found, %.4g: derive a "
               "smaller one, or give the reason\n",
               m->bound, SLACK_MAX, error);
    if (!r->passed) {
        printf("# at ");
        print_inputs(stdout, r);
        printf("\n");
    }
}

static bool search_all(rows *table, double factor)
{
    bool passed = true;
    for (size_t i = 0; i < table->count; i++) {
        row *r = &table->all[i];
        const measure *m = r->measure;
        double trials = TRIALS * factor / (m->cost ? m->cost : 1);
        r->finding = search_for_worst(m, (unsigned long)trials);
        judge(r);
        printf("%s %zu - %s: %s: %.3g, bound %.3g\n", r->passed ? "ok" : "not ok", i + 1,
               m->routine, m->what, fmax(r->finding.error, 0), m->bound);
        fflush(stdout);
        passed = passed && r->passed;
    }
    return passed;
}

/* --- The table -------------------------------------------------------------------------------- */

static int by_share(const void *a, const void *b)
{
    double of_a = share(a), of_b = share(b);
    return of_a < of_b ? 1 : of_a > of_b ? -1 : 0;
}

static bool put_row(const char *path, const row *r, rk_error *error)
{
    static const char *const header[] = {"routine",  "measure",    "observed",  "bound",
                                         "of_bound", "because",    "reference", "slack",
                                         "trials",   "worst_input"};
    char observed[32], bound[32], part[32], trials[32], inputs[32 * INPUTS_MAX] = "";
    snprintf(observed, sizeof observed, "%.4g", fmax(r->finding.error, 0));
    snprintf(bound, sizeof bound, "%.4g", r->measure->bound);
    snprintf(part, sizeof part, "%.4g", share(r));
    snprintf(trials, sizeof trials, "%lu", r->finding.tried);
    size_t used = 0;
    for (unsigned i = 0; i < measure_input_count(r->measure); i++)
        used += (size_t)snprintf(inputs + used, sizeof inputs - used, "%s%a", i ? " " : "",
                                 (double)r->finding.input[i]);
    const char *const cells[] = {r->measure->routine,
                                 r->measure->what,
                                 observed,
                                 bound,
                                 part,
                                 r->measure->because,
                                 r->measure->reference,
                                 r->measure->slack ? r->measure->slack : "",
                                 trials,
                                 inputs};
    return rk_table_put(path, header, cells, sizeof cells / sizeof *cells, 2, error);
}

/* Row by row beside the old table, and then in its place. */
static bool write_table(rows *table, const char *folder, rk_error *error)
{
    char path[4096], part[4100];
    if (snprintf(path, sizeof path, "%s/tables", folder) >= (int)sizeof path - 20)
        return rk_fail(error, "--out: the folder's name is too long");
    if (!rk_file_make_folder(path, error))
        return false;
    strcat(path, "/stress.csv");
    snprintf(part, sizeof part, "%s.new", path);
    remove(part);
    qsort(table->all, table->count, sizeof *table->all, by_share);
    bool ok = true;
    for (size_t i = 0; ok && i < table->count; i++)
        ok = put_row(part, &table->all[i], error);
    if (ok && rename(part, path) == 0)
        return true;
    remove(part);
    return ok ? rk_fail(error, "%s cannot be written", path) : false;
}

int main(int argc, char **argv)
{
    static rows table;
    const char *part = "", *out = NULL, *times = getenv("RAYKIT_STRESS");
    double factor = times ? strtod(times, NULL) : 1;
    bool list = false;
    for (int i = 1; i < argc; i++) {
        if (strcmp(argv[i], "--list") == 0)
            list = true;
        else if (strcmp(argv[i], "--out") == 0 && i + 1 < argc)
            out = argv[++i];
        else if (argv[i][0] != '-')
            part = argv[i];
        else if (strcmp(argv[i], "--quiet") != 0)
            return fprintf(stderr, "usage: %s [--list] [--out FOLDER] [PART OF A NAME]\n", argv[0]),
                   2;
    }
    if (!(factor > 0 && factor < 1e9))
        return fprintf(stderr, "RAYKIT_STRESS: %s is not a number above 0\n", times), 2;
    collect(&table, part);
    if (list) {
        for (size_t i = 0; i < table.count; i++)
            puts(table.all[i].measure->routine);
        return 0;
    }
    printf("1..%zu\n", table.count);
    bool passed = search_all(&table, factor);
    rk_error error;
    if (out && !write_table(&table, out, &error))
        return fprintf(stderr, "stress: %s\n", error.text), 2;
    return passed ? 0 : 1;
}
