/* Files are written whole or not at all, and nothing else is left behind, on file systems with
 * files without a name and on others. */
#define _GNU_SOURCE /* O_TMPFILE, of Linux */
#include "test.h"
#include "test_folder.h"
#include "test_full_disk.h"

#include "base/file.h"

#include <errno.h>
#include <fcntl.h>
#include <sys/wait.h>

static bool all_files_have_names;

/* Replaces the system's function, which it calls. */
int open(const char *path, int flags, ...)
{
    va_list list;
    va_start(list, flags);
    unsigned mode =
        (flags & O_CREAT) || (flags & O_TMPFILE) == O_TMPFILE ? va_arg(list, unsigned) : 0;
    va_end(list);
    if (all_files_have_names && (flags & O_TMPFILE) == O_TMPFILE) {
        errno = EOPNOTSUPP;
        return -1;
    }
    return openat(AT_FDCWD, path, flags, mode);
}

static rk_file begin(const char *path)
{
    rk_file file;
    rk_error error;
    rk_check_ok(rk_file_begin(&file, path, &error), error);
    return file;
}

static void a_committed_file_holds_what_was_written(void **state)
{
    const test_folder *folder = *state;
    rk_error error;
    test_path path = test_folder_path(folder, "new.txt");
    rk_file file = begin(path.text);
    fputs("one\ntwo\r\n", file.stream);
    rk_check_ok(rk_file_commit(&file, &error), error);
    test_file_check(path.text, "one\ntwo\r\n");
    rk_check(file.stream == NULL, "a committed file is closed");
    rk_check_equal(test_folder_count(folder), 1, "the temporary file is gone");
}

static void an_older_file_stays_until_the_commit(void **state)
{
    const test_folder *folder = *state;
    rk_error error;
    test_path path = test_folder_path(folder, "old.txt");
    test_file_put(path.text, "old");
    rk_file file = begin(path.text);
    fputs("new", file.stream);
    fflush(file.stream);
    test_file_check(path.text, "old");
    rk_check_ok(rk_file_commit(&file, &error), error);
    test_file_check(path.text, "new");
}

static void aborting_leaves_nothing_new(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "old.txt");
    test_file_put(path.text, "old");
    rk_file file = begin(path.text);
    fputs("half", file.stream);
    rk_file_abort(&file);
    test_file_check(path.text, "old");
    rk_check_equal(test_folder_count(folder), 1, "the temporary file is gone");
    rk_file_abort(&file);
    rk_file_abort(&(rk_file){0});
}

static void check_refused(const char *path, const char *part)
{
    rk_file file;
    rk_error error = {""};
    rk_check(!rk_file_begin(&file, path, &error), "%.80s was opened", path);
    rk_check(file.stream == NULL, "aborting a file that was refused is harmless");
    rk_check_error_names(error, part);
}

static void places_that_cannot_be_written_are_refused_at_once(void **state)
{
    const test_folder *folder = *state;
    check_refused(test_folder_path(folder, "missing/file.txt").text, "missing/file.txt");
    check_refused(test_folder_path(folder, "missing/file.txt").text, "choose an existing folder");
    check_refused(folder->path, "folder");
    test_file_put(test_folder_path(folder, "file").text, "");
    check_refused(test_folder_path(folder, "file/below").text, "Not a directory");
    char endless[5000];
    memset(endless, 'x', sizeof endless - 1);
    endless[sizeof endless - 1] = '\0';
    check_refused(endless, "longer");
    /* File systems allow names of at most 255 bytes. */
    char name[257];
    memset(name, 'x', sizeof name - 1);
    name[sizeof name - 1] = '\0';
    check_refused(test_folder_path(folder, name).text, "File name too long");
    rk_check_equal(test_folder_count(folder), 1, "nothing was made");
}

static void a_pipe_is_not_replaced_by_a_file(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "pipe");
    rk_check(mkfifo(path.text, 0600) == 0, "a pipe can be made");
    check_refused(path.text, "pipe");
    check_refused("/dev/null", "device");
}

static void a_full_disk_is_an_error_and_keeps_the_older_file(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "old.txt");
    test_file_put(path.text, "old");
    /* A little stays in the stream's buffer and fails at the commit; a lot fails earlier. */
    const int sizes[] = {100, 1000000};
    for (int i = 0; i < 2; i++) {
        rk_file file = begin(path.text);
        rk_error error = {""};
        fill_disk(64);
        for (int k = 0; k < sizes[i]; k++)
            putc('x', file.stream);
        bool committed = rk_file_commit(&file, &error);
        free_disk();
        rk_check(!committed, "%d bytes were written to a disk of 64", sizes[i]);
        rk_check_error_names(error, "old.txt");
        test_file_check(path.text, "old");
        rk_check_equal(test_folder_count(folder), 1, "the temporary file is gone");
    }
}

static void a_write_that_failed_is_an_error_even_if_the_rest_fits(void **state)
{
    const test_folder *folder = *state;
    rk_error error = {""};
    rk_file file = begin(test_folder_path(folder, "new.txt").text);
    fill_disk(64);
    for (int k = 0; k < 1000000; k++)
        putc('x', file.stream);
    free_disk();
    rk_check(!rk_file_commit(&file, &error), "a file with a hole was accepted");
    rk_check_error_names(error, "new.txt");
    rk_check_equal(test_folder_count(folder), 0, "nothing is left behind");
}

static void a_lost_folder_is_an_error(void **state)
{
    test_folder below;
    rk_error error = {""};
    snprintf(below.path, sizeof below.path, "%.400s/below", ((test_folder *)*state)->path);
    rk_check(mkdir(below.path, 0700) == 0, "a folder can be made");
    rk_file file = begin(test_folder_path(&below, "new.txt").text);
    test_folder_remove(&below);
    rk_check(!rk_file_commit(&file, &error), "there is nothing to rename");
    rk_check_error_names(error, "No such file");
}

static void a_file_may_lie_in_the_current_folder(void **state)
{
    const test_folder *folder = *state;
    rk_error error;
    char before[4096];
    rk_check(getcwd(before, sizeof before) && chdir(folder->path) == 0, "folders can be changed");
    rk_file file = begin("new.txt");
    fputs("new", file.stream);
    bool committed = rk_file_commit(&file, &error);
    rk_check(chdir(before) == 0, "and changed back");
    rk_check_ok(committed, error);
    test_file_check(test_folder_path(folder, "new.txt").text, "new");
}

static void a_file_has_the_permissions_of_any_other(void **state)
{
    const test_folder *folder = *state;
    rk_error error;
    struct stat status;
    test_path path = test_folder_path(folder, "new.txt");
    mode_t before = umask(027);
    rk_file file = begin(path.text);
    umask(before);
    rk_check_ok(rk_file_commit(&file, &error), error);
    rk_check(stat(path.text, &status) == 0, "it is there");
    rk_check_equal(status.st_mode & 0777, 0640, "all may read and write it, except by the umask");
}

/* --- a process that dies ---------------------------------------------------------------------- */

static bool has_unnamed_files(const char *folder)
{
    int file = open(folder, O_TMPFILE | O_WRONLY, 0600);
    return file >= 0 && close(file) == 0;
}

static void die_in_the_middle(const char *path)
{
    pid_t child = fork();
    if (child == 0) {
        rk_file file;
        rk_error error;
        if (rk_file_begin(&file, path, &error)) {
            for (int k = 0; k < 1000000; k++)
                putc('x', file.stream);
            fflush(file.stream);
        }
        raise(SIGKILL);
    }
    int status;
    rk_check(waitpid(child, &status, 0) == child && WIFSIGNALED(status), "a child was killed");
}

static void a_process_that_is_killed_leaves_nothing(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "old.txt");
    test_file_put(path.text, "old");
    die_in_the_middle(path.text);
    test_file_check(path.text, "old");
    rk_check_equal(test_folder_count(folder), has_unnamed_files(folder->path) ? 1 : 2,
                   "the part of a file that was written, where files must have names");
}

static void the_remains_of_a_dead_process_are_no_obstacle(void **state)
{
    const test_folder *folder = *state;
    rk_error error;
    test_path path = test_folder_path(folder, "new.txt");
    rk_file file = begin(path.text);
    if (file.unnamed)
        test_file_put(file.temporary, "of a process that had the same number");
    fputs("new", file.stream);
    rk_check_ok(rk_file_commit(&file, &error), error);
    test_file_check(path.text, "new");
    rk_check_equal(test_folder_count(folder), 1, "the temporary file is gone");
}

/* --- folders --------------------------------------------------------------------------------- */

static void a_folder_is_made_with_its_parents(void **state)
{
    const test_folder *folder = *state;
    rk_error error;
    rk_check_ok(rk_file_make_folder(test_folder_path(folder, "a/b/c").text, &error), error);
    rk_check(access(test_folder_path(folder, "a/b/c").text, W_OK | X_OK) == 0, "three new folders");
    rk_check_ok(rk_file_make_folder(test_folder_path(folder, "a/b/c").text, &error), error);
    rk_check_ok(rk_file_make_folder(test_folder_path(folder, "a//d/").text, &error), error);
    rk_check(access(test_folder_path(folder, "a/d").text, W_OK | X_OK) == 0,
             "doubled and last slashes are nothing");
    rk_check_ok(rk_file_make_folder("/", &error), error);
    rk_check_ok(rk_file_make_folder(".", &error), error);
}

static void a_file_in_place_of_a_folder_is_an_error(void **state)
{
    const test_folder *folder = *state;
    test_file_put(test_folder_path(folder, "file").text, "");
    const char *names[] = {"file", "file/below"};
    for (int i = 0; i < 2; i++) {
        rk_error error = {""};
        rk_check(!rk_file_make_folder(test_folder_path(folder, names[i]).text, &error),
                 "%s was made", names[i]);
        rk_check_error_names(error, names[i]);
        rk_check_error_names(error, "--out");
    }
}

static void an_empty_or_overlong_name_is_no_folder(void **state)
{
    (void)state;
    rk_error error = {""};
    rk_check(!rk_file_make_folder("", &error), "an empty name was accepted");
    char endless[5000];
    memset(endless, '/', sizeof endless - 1);
    endless[sizeof endless - 1] = '\0';
    rk_check(!rk_file_make_folder(endless, &error), "a name of 4999 letters was accepted");
    rk_check_error_names(error, "folder name");
}

/* Without a name in the folder of the test: an absolute, a relative and a chained link. */
static void output_goes_where_links_point(void **state)
{
    const test_folder *folder = *state;
    rk_error error;
    const char *const links[][2] = {
        {"to", "near"}, {"below/to", "far"}, {"near", "chained"}, {"new", "dangling"}};
    rk_check(mkdir(test_folder_path(folder, "below").text, 0700) == 0, "a folder can be made");
    test_file_put(test_folder_path(folder, "to").text, "old");
    for (int i = 0; i < 4; i++)
        rk_check(symlink(links[i][0], test_folder_path(folder, links[i][1]).text) == 0, "a link");
    test_path absolute = test_folder_path(folder, "below/absolute");
    rk_check(symlink(test_folder_path(folder, "other").text, absolute.text) == 0, "a link");
    const char *const cases[][2] = {{"near", "to"},
                                    {"far", "below/to"},
                                    {"chained", "to"},
                                    {"dangling", "new"},
                                    {"below/absolute", "other"}};
    for (int i = 0; i < 5; i++) {
        test_path link = test_folder_path(folder, cases[i][0]);
        rk_file file = begin(link.text);
        fputs(cases[i][0], file.stream);
        rk_check_ok(rk_file_commit(&file, &error), error);
        test_file_check(test_folder_path(folder, cases[i][1]).text, cases[i][0]);
        struct stat status;
        rk_check(lstat(link.text, &status) == 0 && S_ISLNK(status.st_mode),
                 "the link %s was replaced", cases[i][0]);
    }
}

static void links_in_a_circle_are_refused(void **state)
{
    const test_folder *folder = *state;
    rk_check(symlink("b", test_folder_path(folder, "a").text) == 0, "a link");
    rk_check(symlink("a", test_folder_path(folder, "b").text) == 0, "a link");
    check_refused(test_folder_path(folder, "a").text, strerror(ELOOP));
}

/* The administrator may write everything, so as nobody. */
static void a_read_only_file_is_not_replaced(void **state)
{
    const test_folder *folder = *state;
    test_path path = test_folder_path(folder, "precious");
    test_file_put(path.text, "old");
    rk_check(chmod(path.text, 0444) == 0 && chmod(folder->path, 0777) == 0, "it is read-only");
    char before[4096];
    rk_check(getcwd(before, sizeof before) && chdir(folder->path) == 0, "the folder is entered");
    uid_t user = geteuid();
    const bool dropped = user != 0 || seteuid(65534) == 0;
    rk_file file;
    rk_error error = {""};
    bool begun = dropped && rk_file_begin(&file, "precious", &error);
    if (begun)
        rk_file_abort(&file);
    rk_check((user != 0 || seteuid(0) == 0) && chdir(before) == 0, "back again");
    rk_check(dropped, "root can become nobody");
    rk_check(!begun, "a read-only file was opened");
    rk_check_error_names(error, "precious: is read-only");
    test_file_check(path.text, "old");
}

static int only_named(void **state)
{
    all_files_have_names = true;
    return test_folder_setup(state);
}

static int named_or_not(void **state)
{
    all_files_have_names = false;
    return test_folder_teardown(state);
}

/* On this file system, and as on one without unnamed files. */
#define test_both(name)                                                                            \
    test_in_folder(name),                                                                          \
    {                                                                                              \
#name "_by_its_name", name, only_named, named_or_not, NULL                                 \
    }

static const struct CMUnitTest tests[] = {
    test_both(a_committed_file_holds_what_was_written),
    test_both(an_older_file_stays_until_the_commit),
    test_both(aborting_leaves_nothing_new),
    test_both(places_that_cannot_be_written_are_refused_at_once),
    test_both(a_pipe_is_not_replaced_by_a_file),
    test_both(a_full_disk_is_an_error_and_keeps_the_older_file),
    test_both(a_write_that_failed_is_an_error_even_if_the_rest_fits),
    test_both(a_lost_folder_is_an_error),
    test_both(a_file_may_lie_in_the_current_folder),
    test_both(a_file_has_the_permissions_of_any_other),
    test_both(a_process_that_is_killed_leaves_nothing),
    test_both(the_remains_of_a_dead_process_are_no_obstacle),
    test_both(output_goes_where_links_point),
    test_in_folder(links_in_a_circle_are_refused),
    test_in_folder(a_read_only_file_is_not_replaced),
    test_in_folder(a_folder_is_made_with_its_parents),
    test_in_folder(a_file_in_place_of_a_folder_is_an_error),
    cmocka_unit_test(an_empty_or_overlong_name_is_no_folder),
};

RK_SUITE("file", tests)
