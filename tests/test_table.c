/* Tables: rows are added, replaced and quoted; files that are not our tables are left unchanged. */
#include "test.h"
#include "test_comma_locale.h"
#include "test_folder.h"
#include "test_full_disk.h"

#include "base/table.h"

#include <sys/wait.h>
#include <time.h>

static const char *const header[] = {"scene", "method", "ms"};

static bool put(const char *path, const char *scene, const char *method, const char *ms,
                rk_error *error)
{
    const char *const cells[] = {scene, method, ms};
    return rk_table_put(path, header, cells, 3, 2, error);
}

static void check_put(const char *path, const char *scene, const char *method, const char *ms)
{
    rk_error error;
    rk_check_ok(put(path, scene, method, ms, &error), error);
}

static void the_first_row_makes_the_table(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    check_put(path.text, "cube", "median", "1.5");
    test_file_check(path.text, "scene,method,ms\ncube,median,1.5\n");
}

static void further_rows_are_appended(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    check_put(path.text, "cube", "median", "1");
    check_put(path.text, "cube", "sah", "2");
    check_put(path.text, "teapot", "median", "3");
    test_file_check(path.text, "scene,method,ms\ncube,median,1\ncube,sah,2\nteapot,median,3\n");
}

static void a_row_with_the_same_key_is_replaced_in_its_place(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    test_file_put(path.text, "scene,method,ms\na,x,1\na,y,2\na,x,3\nb,x,4\n");
    check_put(path.text, "a", "x", "9");
    test_file_check(path.text, "scene,method,ms\na,x,9\na,y,2\nb,x,4\n");
}

static void without_a_key_every_row_is_appended(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    const char *const cells[] = {"a", "x", "1"};
    rk_error error;
    for (int i = 0; i < 2; i++)
        rk_check_ok(rk_table_put(path.text, header, cells, 3, 0, &error), error);
    test_file_check(path.text, "scene,method,ms\na,x,1\na,x,1\n");
}

static void cells_are_quoted_only_where_they_must_be(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    check_put(path.text, "a,b", "say \"so\"", "two\nlines");
    check_put(path.text, " plain; 'text' ", "", "r\r");
    test_file_check(path.text, "scene,method,ms\n\"a,b\",\"say \"\"so\"\"\",\"two\nlines\"\n"
                               " plain; 'text' ,,\"r\r\"\n");
}

static void quoted_cells_are_found_again(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    const char *const hard[] = {"a,b", "\"", "\"\"", "a\nb", "\r\n", "", ",", "x\"y"};
    char want[512] = "";
    for (int round = 0; round < 2; round++)
        for (int i = 0; i < 8; i++)
            check_put(path.text, hard[i], "m", round ? "new" : "old");
    strcat(want,
           "scene,method,ms\n\"a,b\",m,new\n\"\"\"\",m,new\n\"\"\"\"\"\",m,new\n\"a\nb\",m,new\n"
           "\"\r\n\",m,new\n,m,new\n\",\",m,new\n\"x\"\"y\",m,new\n");
    test_file_check(path.text, want);
}

static void each_of_many_writers_keeps_its_rows(void **state)
{
    enum { writers = 8, rows = 20 };
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    for (int writer = 0; writer < writers; writer++) {
        if (fork() != 0)
            continue;
        bool ok = true;
        for (int row = 0; row < rows; row++) {
            char scene[16], method[16];
            rk_error error;
            snprintf(scene, sizeof scene, "%d", writer);
            snprintf(method, sizeof method, "%d", row);
            ok = put(path.text, scene, method, "1", &error) && ok;
        }
        _exit(ok ? 0 : 1);
    }
    for (int writer = 0, status; writer < writers; writer++)
        rk_check(wait(&status) > 0 && status == 0, "a writer failed");
    size_t size, lines = 0;
    unsigned char *text = test_folder_read(path, &size);
    for (size_t i = 0; i < size; i++)
        lines += text[i] == '\n';
    free(text);
    rk_check_equal(lines, 1 + writers * rows, "the header, and a line for each row put");
    rk_check_equal(test_folder_count(folder), 1, "the table is all that is left");
}

static void a_single_empty_cell_is_a_row_too(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    const char *const one[] = {"name"}, *const empty[] = {""};
    rk_error error;
    for (int i = 0; i < 2; i++)
        rk_check_ok(rk_table_put(path.text, one, empty, 1, 1, &error), error);
    test_file_check(path.text, "name\n\"\"\n");
}

static void line_ends_of_other_systems_are_read(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    test_file_put(path.text, "scene,\"method\",ms\r\na,x,1\r\n\"b\",x,2\r\n");
    check_put(path.text, "b", "x", "3");
    test_file_check(path.text, "scene,method,ms\na,x,1\nb,x,3\n");
}

static void a_last_line_without_an_end_is_read(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    test_file_put(path.text, "scene,method,ms\na,x,");
    check_put(path.text, "b", "x", "3");
    test_file_check(path.text, "scene,method,ms\na,x,\nb,x,3\n");
    test_file_put(path.text, "scene,method,ms");
    check_put(path.text, "b", "x", "3");
    test_file_check(path.text, "scene,method,ms\nb,x,3\n");
}

static void an_empty_file_becomes_a_table(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    test_file_put(path.text, "");
    check_put(path.text, "a", "x", "1");
    test_file_check(path.text, "scene,method,ms\na,x,1\n");
}

/* --- refusals -------------------------------------------------------------------------------- */

static void check_untouched(const test_folder *folder, const char *content, const char *part)
{
    test_path path = test_folder_path(folder, "t.csv");
    test_file_put(path.text, content);
    rk_error error = {""};
    rk_check(!put(path.text, "a", "x", "1", &error), "accepted: %s", content);
    rk_check_error_names(error, path.text);
    rk_check_error_names(error, part);
    test_file_check(path.text, content);
    rk_check_equal(test_folder_count(folder), 1, "nothing is left behind");
}

static void another_header_is_refused_and_the_file_stays(void **state)
{
    check_untouched(*state, "scene,method\na,x\n", "header");
    check_untouched(*state, "scene,method,ms,more\na,x,1,2\n", "header");
    check_untouched(*state, "scene,Method,ms\na,x,1\n", "header");
    check_untouched(*state, "a picture, not a table", "header");
    check_untouched(*state, "\n", "header");
}

static void a_damaged_row_is_refused_with_its_line(void **state)
{
    check_untouched(*state, "scene,method,ms\na,x\n", "line 2");
    check_untouched(*state, "scene,method,ms\na,x,1\nb,x,1,7\n", "line 3 has 4 cells, not 3");
    check_untouched(*state, "scene,method,ms\n\"two\nlines\",x,1\r\na,\n", "line 4");
    check_untouched(*state, "scene,method,ms\na,x,1\n\n", "line 3");
}

static void a_damaged_quote_is_refused_with_its_line(void **state)
{
    check_untouched(*state, "scene,method,ms\na,x,1\nb,\"never closed,3\nc,x,1\n",
                    "line 3 has a misplaced");
    check_untouched(*state, "scene,method,ms\nb,\"closed\"early,3\n", "line 2 has a misplaced");
    check_untouched(*state, "scene,method,ms\nb,x,\"3\"early", "line 2 has a misplaced");
    check_untouched(*state, "scene,method,ms\nb,in\"side,3\n", "line 2 has a misplaced");
    check_untouched(*state, "scene,method,ms\nb,x,\"", "line 2 has a misplaced");
}

static void a_truncated_file_is_never_read_wrongly(void **state)
{
    const test_folder *folder = *state;
    const char whole[] = "scene,method,ms\r\n\"a \"\"b\"\"\",x,1\n\"c\nd\",y,2\n";
    for (size_t length = 1; length < sizeof whole; length++) {
        char part[sizeof whole];
        snprintf(part, length + 1, "%s", whole);
        test_path path = test_folder_path(folder, "t.csv");
        test_file_put(path.text, part);
        rk_error error = {""};
        if (put(path.text, "new", "x", "1", &error))
            rk_check(strncmp(part, "scene,method,ms", 15) == 0, "accepted: %s", part);
        else
            test_file_check(path.text, part);
    }
}

static void bytes_that_are_not_text_are_refused(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    FILE *stream = fopen(path.text, "wb");
    fwrite("scene,method,ms\na,x\0y,1\n", 1, 24, stream);
    fclose(stream);
    rk_error error = {""};
    rk_check(!put(path.text, "a", "x", "1", &error), "a zero byte was accepted");
    rk_check_error_names(error, "zero byte");
}

static void places_that_cannot_hold_a_table_are_refused(void **state)
{
    const test_folder *folder = *state;
    rk_error error = {""};
    rk_check(!put(folder->path, "a", "x", "1", &error), "a folder was accepted");
    rk_check_error_names(error, folder->path);
    test_path pipe = test_folder_path(folder, "pipe");
    rk_check(mkfifo(pipe.text, 0600) == 0, "a pipe can be made");
    rk_check(!put(pipe.text, "a", "x", "1", &error), "a pipe was accepted");
    rk_check_error_names(error, "is a device or a pipe");
    test_file_put(test_folder_path(folder, "file").text, "");
    rk_check(!put(test_folder_path(folder, "file/t.csv").text, "a", "x", "1", &error),
             "a folder that is a file was accepted");
    rk_check_error_names(error, "file/t.csv");
    rk_check(!put(test_folder_path(folder, "missing/t.csv").text, "a", "x", "1", &error),
             "a missing folder was accepted");
    rk_check_error_names(error, "missing/t.csv");
}

static void a_full_disk_keeps_the_older_table(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "t.csv");
    check_put(path.text, "a", "x", "1");
    rk_error error = {""};
    fill_disk(20);
    bool ok = put(path.text, "b", "x", "1", &error);
    free_disk();
    rk_check(!ok, "a table of 30 bytes was written to a disk of 20");
    rk_check_error_names(error, "t.csv");
    test_file_check(path.text, "scene,method,ms\na,x,1\n");
    rk_check_equal(test_folder_count(folder), 1, "nothing is left behind");
}

/* --- timings --------------------------------------------------------------------------------- */

static void the_median_is_the_middle_of_the_sorted_figures(void **state)
{
    (void)state;
    double odd[] = {10, 2, 9, 100, 1};
    rk_timing timing = rk_timing_of(odd, 5);
    rk_check(timing.median == 9 && timing.min == 1 && timing.max == 100 && timing.runs == 5,
             "got median %g, min %g, max %g", timing.median, timing.min, timing.max);
    double even[] = {4, 1, 3, 10};
    timing = rk_timing_of(even, 4);
    rk_check(timing.median == 3.5 && timing.min == 1 && timing.max == 10, "got median %g",
             timing.median);
    double one[] = {7};
    timing = rk_timing_of(one, 1);
    rk_check(timing.median == 7 && timing.min == 7 && timing.max == 7, "got median %g",
             timing.median);
}

static void a_timing_row_is_replaced_when_measured_again(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "timings.csv");
    rk_timing_row row = {"bvh", "cube",  12,   "median",         "scalar",
                         2,     "build", "ms", {1.5, 1, 2.25, 3}};
    rk_error error;
    rk_check_ok(rk_table_put_timing(path.text, &row, &error), error);
    row.timing = (rk_timing){0.0001234567, 1e-5, 123456.7, 9};
    rk_check_ok(rk_table_put_timing(path.text, &row, &error), error);
    row.threads = 1;
    rk_check_ok(rk_table_put_timing(path.text, &row, &error), error);
    row.unit = "us";
    rk_check_ok(rk_table_put_timing(path.text, &row, &error), error);
    test_file_check(path.text,
                    "feature,scene,triangles,method,isa,threads,metric,unit,median,min,max,runs\n"
                    "bvh,cube,12,median,scalar,2,build,ms,0.000123457,1e-05,123457,9\n"
                    "bvh,cube,12,median,scalar,1,build,ms,0.000123457,1e-05,123457,9\n"
                    "bvh,cube,12,median,scalar,1,build,us,0.000123457,1e-05,123457,9\n");
}

static void a_convergence_row_is_replaced_when_measured_again(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "convergence.csv");
    rk_convergence_row row = {"light", "cornell", "uniform", 16,     1.5,    2, 0.25,
                              0.125,   0.375,     0.5,       -0.125, "4096", 8};
    rk_error error;
    rk_check_ok(rk_table_put_convergence(path.text, &row, &error), error);
    row.seconds = 1e-6, row.rmse = 0.01, row.bias = 0, row.reference = "closed form, 1 sample";
    rk_check_ok(rk_table_put_convergence(path.text, &row, &error), error);
    row.samples = 64;
    rk_check_ok(rk_table_put_convergence(path.text, &row, &error), error);
    row.method = "stratified";
    rk_check_ok(rk_table_put_convergence(path.text, &row, &error), error);
    test_file_check(
        path.text,
        "feature,scene,method,samples,seconds,rays,rmse,rmse_low,rmse_high,max_error,bias,"
        "seeds,reference\n"
        "light,cornell,uniform,16,1e-06,2,0.01,0.125,0.375,0.5,0,8,"
        "\"closed form, 1 sample\"\n"
        "light,cornell,uniform,64,1e-06,2,0.01,0.125,0.375,0.5,0,8,"
        "\"closed form, 1 sample\"\n"
        "light,cornell,stratified,64,1e-06,2,0.01,0.125,0.375,0.5,0,8,"
        "\"closed form, 1 sample\"\n");
}

static void figures_have_a_decimal_point_in_every_locale(void **state)
{
    const test_folder *folder = *state;
    if (!test_comma_locale_begin(folder))
        skip();
    test_path path = test_folder_path(folder, "t.csv");
    rk_error error;
    const rk_convergence_row row = {"f",   "s",   "m", 4,      1.5,           1, 0.25,
                                    0.125, 0.375, 0.5, -0.125, "closed form", 8};
    rk_check_ok(rk_table_put_convergence(path.text, &row, &error), error);
    test_file_check(
        path.text,
        "feature,scene,method,samples,seconds,rays,rmse,rmse_low,rmse_high,max_error,bias,"
        "seeds,reference\n"
        "f,s,m,4,1.5,1,0.25,0.125,0.375,0.5,-0.125,8,closed form\n");
}

static void the_clocks_run_in_seconds(void **state)
{
    (void)state;
    double wall = rk_clock_wall(), thread = rk_clock_thread();
    volatile unsigned work = 0;
    while (rk_clock_thread() - thread < 0.01)
        work = work + 1;
    double wall_passed = rk_clock_wall() - wall, thread_passed = rk_clock_thread() - thread;
    rk_check(wall_passed >= 0.0099, "10 ms of work took %g s on the wall clock", wall_passed);
    /* While the thread sleeps, only the wall clock advances. */
    wall = rk_clock_wall(), thread = rk_clock_thread();
    nanosleep(&(struct timespec){0, 20000000}, NULL);
    wall_passed = rk_clock_wall() - wall, thread_passed = rk_clock_thread() - thread;
    rk_check(wall_passed >= 0.0199 && wall_passed < 1e4, "20 ms of sleep took %g s", wall_passed);
    rk_check(thread_passed < 0.01, "20 ms of sleep took %g s of processor time", thread_passed);
}

static const struct CMUnitTest tests[] = {
    test_in_folder(the_first_row_makes_the_table),
    test_in_folder(further_rows_are_appended),
    test_in_folder(a_row_with_the_same_key_is_replaced_in_its_place),
    test_in_folder(without_a_key_every_row_is_appended),
    test_in_folder(cells_are_quoted_only_where_they_must_be),
    test_in_folder(quoted_cells_are_found_again),
    test_in_folder(each_of_many_writers_keeps_its_rows),
    test_in_folder(a_single_empty_cell_is_a_row_too),
    test_in_folder(line_ends_of_other_systems_are_read),
    test_in_folder(a_last_line_without_an_end_is_read),
    test_in_folder(an_empty_file_becomes_a_table),
    test_in_folder(another_header_is_refused_and_the_file_stays),
    test_in_folder(a_damaged_row_is_refused_with_its_line),
    test_in_folder(a_damaged_quote_is_refused_with_its_line),
    test_in_folder(a_truncated_file_is_never_read_wrongly),
    test_in_folder(bytes_that_are_not_text_are_refused),
    test_in_folder(places_that_cannot_hold_a_table_are_refused),
    test_in_folder(a_full_disk_keeps_the_older_table),
    cmocka_unit_test(the_median_is_the_middle_of_the_sorted_figures),
    test_in_folder(a_timing_row_is_replaced_when_measured_again),
    test_in_folder(a_convergence_row_is_replaced_when_measured_again),
    test_in_comma_locale(figures_have_a_decimal_point_in_every_locale),
    cmocka_unit_test(the_clocks_run_in_seconds),
};

RK_SUITE("table", tests)
