/* A table is read whole, changed by one row, and written whole: tables are small, and none is left
 * half-changed. */
#include "base/table.h"

#include "base/file.h"
#include "base/plain_numbers.h"

#include <assert.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>

typedef struct table {
    char *text;   /* the file; the cells point into it, unquoted in place */
    char **cells; /* rows * columns */
    size_t rows;  /* including the header; 0 when there is no file yet */
} table;

static void table_free(table *old)
{
    free(old->text);
    free(old->cells);
}

/* --- reading --------------------------------------------------------------------------------- */

static bool read_text(table *old, FILE *stream, size_t size, const char *path, rk_error *error)
{
    old->text = rk_allocate(size + 1, 1, path, error);
    if (!old->text)
        return false;
    if (fread(old->text, 1, size, stream) != size)
        return rk_fail(error, "%s: cannot be read: %s", path,
                       ferror(stream) ? strerror(errno) : "it shrank while it was read");
    if (memchr(old->text, '\0', size))
        return rk_fail(error, "%s: contains a zero byte, so it is not a table: rename or remove it",
                       path);
    return true;
}

/* Unquotes the cell at *place in place and moves *place past it. Returns the character that
 * ended it: ',', '\n' or, at the end of the file, '\0'; or '"' for a quote that is unclosed or
 * misplaced. */
static char take_cell(char **place, size_t *line)
{
    char *from = *place, *to = *place;
    if (*from == '"') {
        from++;
        while (*from && !(from[0] == '"' && from[1] != '"')) {
            from += *from == '"';
            *line += *from == '\n';
            *to++ = *from++;
        }
        if (*from++ != '"')
            return '"';
    } else {
        while (*from && !strchr(",\"\n", *from) && !(from[0] == '\r' && from[1] == '\n'))
            *to++ = *from++;
    }
    from += from[0] == '\r' && from[1] == '\n';
    char end = *from;
    if (end != ',' && end != '\n' && end != '\0')
        return '"';
    *to = '\0';
    *place = end ? from + 1 : from;
    return end;
}

static bool same_cells(char *const *a, const char *const *b, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (strcmp(a[i], b[i]) != 0)
            return false;
    return true;
}

static size_t most_cells(const char *text)
{
    size_t separators = 0;
    for (; *text; text++)
        separators += *text == ',' || *text == '\n';
    return separators + 1;
}

static bool split(table *old, const char *const *header, size_t columns, const char *path,
                  rk_error *error)
{
    old->cells = rk_allocate(most_cells(old->text), sizeof *old->cells, path, error);
    if (!old->cells)
        return false;
    size_t line = 1, cells = 0;
    for (char *place = old->text; *place; old->rows++) {
        size_t first = cells, begin = line;
        char end;
        do {
            old->cells[cells++] = place;
            end = take_cell(&place, &line);
        } while (end == ',');
        if (end == '"')
            return rk_fail(error,
                           "%s: line %zu has a misplaced or unclosed quote: repair the "
                           "line, or remove the file",
                           path, begin);
        line += end == '\n';
        size_t count = cells - first;
        if (old->rows == 0 && !(count == columns && same_cells(old->cells, header, columns)))
            return rk_fail(error,
                           "%s: its header differs from this table's, which begins with "
                           "%s: rename or remove the file",
                           path, header[0]);
        if (count != columns)
            return rk_fail(error,
                           "%s: line %zu has %zu cells, not %zu: repair the line, or remove "
                           "the file",
                           path, begin, count, columns);
    }
    return true;
}

static bool table_read(table *old, const char *const *header, size_t columns, const char *path,
                       rk_error *error)
{
    *old = (table){0};
    struct stat status;
    if (stat(path, &status) != 0)
        return errno == ENOENT || rk_fail(error, "%s: cannot be read: %s", path, strerror(errno));
    FILE *stream = fopen(path, "rb");
    if (!stream)
        return rk_fail(error, "%s: cannot be read: %s", path, strerror(errno));
    bool ok = read_text(old, stream, (size_t)status.st_size, path, error);
    fclose(stream);
    return ok && split(old, header, columns, path, error);
}

/* --- writing --------------------------------------------------------------------------------- */

static void write_cell(FILE *stream, const char *cell, size_t columns)
{
    /* The single cell of a one-column row is quoted if empty: a blank line would not count as a
     * row. */
    if (!strpbrk(cell, ",\"\r\n") && (*cell || columns > 1)) {
        fputs(cell, stream);
        return;
    }
    putc('"', stream);
    for (; *cell; cell++) {
        if (*cell == '"')
            putc('"', stream);
        putc(*cell, stream);
    }
    putc('"', stream);
}

static void write_row(FILE *stream, const char *const *cells, size_t columns)
{
    for (size_t i = 0; i < columns; i++) {
        if (i)
            putc(',', stream);
        write_cell(stream, cells[i], columns);
    }
    putc('\n', stream);
}

static bool put_row(const char *path, const char *const *header, const char *const *cells,
                    size_t columns, size_t key_columns, rk_error *error)
{
    assert(columns > 0 && key_columns <= columns &&
           "a table has columns, and its key consists of some of them");
    table old;
    rk_file file;
    if (!table_read(&old, header, columns, path, error) || !rk_file_begin(&file, path, error)) {
        table_free(&old);
        return false;
    }
    bool placed = false;
    write_row(file.stream, header, columns);
    for (size_t row = 1; row < old.rows; row++) {
        char *const *old_cells = &old.cells[row * columns];
        bool same = key_columns > 0 && same_cells(old_cells, cells, key_columns);
        if (!same)
            write_row(file.stream, (const char *const *)old_cells, columns);
        else if (!placed)
            write_row(file.stream, cells, columns);
        placed = placed || same;
    }
    if (!placed)
        write_row(file.stream, cells, columns);
    table_free(&old);
    return rk_file_commit(&file, error);
}

bool rk_table_put(const char *path, const char *const *header, const char *const *cells,
                  size_t columns, size_t key_columns, rk_error *error)
{
    rk_file_place place;
    if (!rk_file_destination(&place, path, error))
        return false;
    int lock = rk_file_lock_folder(place.text);
    bool ok = put_row(place.text, header, cells, columns, key_columns, error);
    rk_file_unlock(lock);
    return ok;
}

/* --- measurements ----------------------------------------------------------------------------- */

static int compare_figures(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

rk_timing rk_timing_of(double *figures, unsigned runs)
{
    assert(runs >= 1 && runs <= RK_RUNS_MAX && "statistics need 1 to RK_RUNS_MAX figures");
    qsort(figures, runs, sizeof *figures, compare_figures);
    double median = runs % 2 ? figures[runs / 2] : (figures[runs / 2 - 1] + figures[runs / 2]) / 2;
    return (rk_timing){median, figures[0], figures[runs - 1], runs};
}

typedef struct number {
    char text[32];
} number;

static number count_text(unsigned long count)
{
    number result;
    snprintf(result.text, sizeof result.text, "%lu", count);
    return result;
}

/* Six digits: more than any timing reproduces. */
static number figure_text(double figure)
{
    number result;
    rk_plain_numbers plain = rk_plain_numbers_begin();
    snprintf(result.text, sizeof result.text, "%.6g", figure);
    rk_plain_numbers_end(plain);
    return result;
}

bool rk_table_put_timing(const char *path, const rk_timing_row *row, rk_error *error)
{
    static const char *const header[] = {"feature", "scene",   "triangles", "method",
                                         "isa",     "threads", "metric",    "unit",
                                         "median",  "min",     "max",       "runs"};
    number triangles = count_text(row->triangles), threads = count_text(row->threads);
    number runs = count_text(row->timing.runs), median = figure_text(row->timing.median);
    number min = figure_text(row->timing.min), max = figure_text(row->timing.max);
    const char *const cells[] = {row->feature, row->scene,   triangles.text, row->method,
                                 row->isa,     threads.text, row->metric,    row->unit,
                                 median.text,  min.text,     max.text,       runs.text};
    return rk_table_put(path, header, cells, sizeof header / sizeof *header, 8, error);
}

bool rk_table_put_convergence(const char *path, const rk_convergence_row *row, rk_error *error)
{
    static const char *const header[] = {"feature", "scene", "method",   "samples",   "seconds",
                                         "rays",    "rmse",  "rmse_low", "rmse_high", "max_error",
                                         "bias",    "seeds", "reference"};
    const double figures[] = {row->seconds,   row->rays,      row->rmse, row->rmse_low,
                              row->rmse_high, row->max_error, row->bias};
    enum { FIRST = 4, FIGURES = sizeof figures / sizeof *figures };
    number samples = count_text(row->samples), seeds = count_text(row->seeds), texts[FIGURES];
    const char *cells[sizeof header / sizeof *header] = {row->feature, row->scene, row->method,
                                                         samples.text};
    for (int i = 0; i < FIGURES; i++) {
        texts[i] = figure_text(figures[i]);
        cells[FIRST + i] = texts[i].text;
    }
    cells[FIRST + FIGURES] = seeds.text;
    cells[FIRST + FIGURES + 1] = row->reference;
    return rk_table_put(path, header, cells, sizeof header / sizeof *header, FIRST, error);
}

static double seconds_on(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

double rk_clock_wall(void)
{
    return seconds_on(CLOCK_MONOTONIC);
}

double rk_clock_thread(void)
{
    return seconds_on(CLOCK_THREAD_CPUTIME_ID);
}
