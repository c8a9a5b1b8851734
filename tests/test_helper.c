/* Helper programs: input, output, verdict, stopping. Shell scripts replace the real ones. */
#include "test.h"
#include "test_folder.h"

#include "io/helper.h"
#include "io/helper_answer.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <sys/wait.h>
#include <time.h>

static test_folder folder;

typedef struct answer {
    bool ok;
    unsigned char *output;
    size_t size;
    rk_error error;
} answer;

/* Runs `script`, the body of a shell program, with the call's other members. */
static answer run_script(const char *script, rk_helper_call call)
{
    char text[2048];
    int length = snprintf(text, sizeof text, "#!/bin/sh\n%s\n", script);
    test_folder_write(&folder, "stand-in", text, (size_t)length, 0700);
    call.program = "stand-in";
    if (!call.output_max)
        call.output_max = 1 << 24;
    answer result = {0};
    result.ok = rk_helper_run(&call, &result.output, &result.size, &result.error);
    rk_check(result.ok || !result.output, "a failed call left a block behind");
    return result;
}

static double seconds_now(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

static void the_answer_comes_back_byte_for_byte(void **state)
{
    (void)state;
    answer got = run_script("printf 'a\\000b\\n'", (rk_helper_call){0});
    rk_check_ok(got.ok, got.error);
    rk_check_equal(got.size, 4, "a, NUL, b, newline");
    rk_check(memcmp(got.output, "a\0b\n", 4) == 0, "other bytes came back");
    rk_check(got.error.text[0] == '\0', "no note was written, but: %s", got.error.text);
    free(got.output);
}

static void an_empty_answer_is_an_answer(void **state)
{
    (void)state;
    answer got = run_script("exit 0", (rk_helper_call){0});
    rk_check_ok(got.ok, got.error);
    rk_check(got.output && got.size == 0, "got %zu bytes", got.size);
    free(got.output);
}

static void arguments_arrive_whole(void **state)
{
    (void)state;
    const char *const arguments[] = {"a b", "*", "", "c\n", NULL};
    answer got = run_script("printf '%s|' \"$@\"", (rk_helper_call){.arguments = arguments});
    rk_check_ok(got.ok, got.error);
    rk_check(got.size == 10 && memcmp(got.output, "a b|*||c\n|", 10) == 0, "got %.*s",
             (int)got.size, (char *)got.output);
    free(got.output);
}

/* Input and output each exceed any socket's buffer, and the helper writes while it still reads:
 * sending everything first and reading later would wait for ever. */
static void large_input_and_output_pass_without_deadlock(void **state)
{
    (void)state;
    size_t size = 5000000;
    unsigned char *input = malloc(size);
    assert_non_null(input);
    for (size_t i = 0; i < size; i++)
        input[i] = (unsigned char)(i * 2654435761u >> 13);
    answer got = run_script("exec cat", (rk_helper_call){.input = input, .input_size = size});
    rk_check_ok(got.ok, got.error);
    rk_check_equal(got.size, size, "cat gives back what it gets");
    rk_check(memcmp(got.output, input, size) == 0, "the bytes changed on their way");
    free(got.output);
    free(input);
}

static void *echo_much(void *unused)
{
    (void)unused;
    size_t size = 1000000;
    unsigned char *input = calloc(size, 1), *output;
    rk_helper_call call = {.program = "echo",
                           .input = input,
                           .input_size = size,
                           .output_max = size,
                           .timeout_seconds = 10};
    rk_error error;
    bool ok = input && rk_helper_run(&call, &output, &size, &error) && size == 1000000;
    if (ok)
        free(output);
    free(input);
    return ok ? &folder : NULL;
}

/* If a child inherited another's input, that would never end, and both would be silent. */
static void threads_may_call_at_the_same_time(void **state)
{
    (void)state;
    const char script[] = "#!/bin/sh\nexec cat\n";
    test_folder_write(&folder, "echo", script, sizeof script - 1, 0700);
    pthread_t threads[4];
    for (int i = 0; i < 4; i++)
        rk_check_equal(pthread_create(&threads[i], NULL, echo_much, NULL), 0,
                       "the test needs threads");
    for (int i = 0; i < 4; i++) {
        void *good;
        pthread_join(threads[i], &good);
        rk_check(good != NULL, "thread %d did not get its million bytes back", i);
    }
}

static void a_long_error_does_not_block_the_output(void **state)
{
    (void)state;
    answer got = run_script("head -c 2000000 /dev/zero | tr '\\000' 'x' >&2; echo done",
                            (rk_helper_call){0});
    rk_check_ok(got.ok, got.error);
    rk_check_equal(got.size, 5, "done and a newline");
    free(got.output);
}

static void input_that_nobody_reads_neither_kills_nor_fails(void **state)
{
    (void)state;
    size_t size = 3000000;
    unsigned char *input = calloc(size, 1);
    assert_non_null(input);
    struct sigaction before, after;
    sigaction(SIGPIPE, NULL, &before);
    answer got =
        run_script("exec <&-; echo enough", (rk_helper_call){.input = input, .input_size = size});
    sigaction(SIGPIPE, NULL, &after);
    rk_check_ok(got.ok, got.error);
    rk_check_equal(got.size, 7, "enough and a newline");
    rk_check(before.sa_handler == after.sa_handler, "the caller's SIGPIPE handler was changed");
    free(got.output);
    free(input);
}

static void a_failure_gives_its_last_line_as_the_reason(void **state)
{
    (void)state;
    answer got = run_script("echo half an answer; echo first >&2; echo 'a.obj:3: no number' >&2;"
                            "echo >&2; exit 3",
                            (rk_helper_call){.subject = "a.obj"});
    rk_check(!got.ok, "exit status 3 is a failure");
    assert_string_equal(got.error.text, "a.obj:3: no number");
}

static void a_failure_without_a_reason_names_the_status_and_the_file(void **state)
{
    (void)state;
    answer got = run_script("exit 7", (rk_helper_call){.subject = "a.obj"});
    rk_check(!got.ok, "exit status 7 is a failure");
    rk_check_error_names(got.error, "a.obj: stand-in");
    rk_check_error_names(got.error, "status 7");
}

static void a_note_beside_a_good_answer_is_handed_on(void **state)
{
    (void)state;
    answer got = run_script("echo 'a.mtl: missing' >&2; echo mesh", (rk_helper_call){0});
    rk_check_ok(got.ok, got.error);
    assert_string_equal(got.error.text, "a.mtl: missing");
    free(got.output);
}

static void death_by_a_signal_is_an_error_that_names_it(void **state)
{
    (void)state;
    answer got = run_script("echo some; kill -ABRT $$", (rk_helper_call){.subject = "a.ply"});
    rk_check(!got.ok, "a helper that aborts has failed, whatever it wrote before");
    rk_check_error_names(got.error, "a.ply: stand-in");
    rk_check_error_names(got.error, "signal 6");
}

static void an_answer_may_be_as_long_as_allowed_and_no_longer(void **state)
{
    (void)state;
    rk_helper_call call = {.output_max = 100000};
    answer got = run_script("head -c 100000 /dev/zero", call);
    rk_check_ok(got.ok, got.error);
    rk_check_equal(got.size, 100000, "exactly the limit");
    free(got.output);
    got = run_script("head -c 100001 /dev/zero", call);
    rk_check(!got.ok, "one byte more than allowed was accepted");
    rk_check_error_names(got.error, "100000 bytes");
    double begin = seconds_now();
    got = run_script("exec cat /dev/zero", call);
    rk_check(!got.ok, "an endless answer was accepted");
    rk_check(seconds_now() - begin < 10, "an endless answer was read for %.1f s",
             seconds_now() - begin);
}

static void silence_ends_after_the_timeout(void **state)
{
    (void)state;
    const char *silent[] = {"exec sleep 30", "exec >&- 2>&-; exec sleep 30"};
    for (int i = 0; i < 2; i++) {
        double begin = seconds_now();
        answer got = run_script(silent[i], (rk_helper_call){.timeout_seconds = 0.1});
        double taken = seconds_now() - begin;
        rk_check(!got.ok, "silence was accepted as an answer");
        rk_check_error_names(got.error, "took longer than 0.1 s");
        /* Far below the script's 30 s, far above the delays of a loaded machine. */
        rk_check(taken >= 0.1 && taken < 10, "stopped after %.2f s instead of 0.1", taken);
    }
}

static void work_in_progress_is_not_silence(void **state)
{
    (void)state;
    answer got = run_script("for i in 1 2 3 4; do sleep 0.1; echo $i; done",
                            (rk_helper_call){.timeout_seconds = 0.3});
    rk_check_ok(got.ok, got.error);
    rk_check_equal(got.size, 8, "four lines of two bytes, over .4 s");
    free(got.output);
}

static void a_missing_program_says_what_to_do(void **state)
{
    (void)state;
    rk_helper_call call = {
        .program = "raykit-nothing", .package = "libnothing-dev", .subject = "a.obj"};
    answer got = {0};
    rk_check(!rk_helper_run(&call, &got.output, &got.size, &got.error), "it cannot have run");
    rk_check_error_names(got.error, "a.obj: ");
    rk_check_error_names(got.error, "raykit-nothing");
    rk_check_error_names(got.error, folder.path);
    rk_check_error_names(got.error, rk_helper_folder());
    rk_check_error_names(got.error, "install libnothing-dev, then run ./configure");
}

static void a_folder_and_a_plain_file_are_no_programs(void **state)
{
    (void)state;
    test_folder_write(&folder, "raykit-plain", "text", 4, 0600);
    mkdir(test_folder_path(&folder, "raykit-folder").text, 0700);
    const char *names[] = {"raykit-plain", "raykit-folder"};
    for (int i = 0; i < 2; i++) {
        rk_helper_call call = {.program = names[i]};
        answer got = {0};
        rk_check(!rk_helper_run(&call, &got.output, &got.size, &got.error), "it cannot have run");
        rk_check_error_names(got.error, "is not in");
    }
}

static void a_program_of_another_kind_is_an_error(void **state)
{
    (void)state;
    test_folder_write(&folder, "raykit-alien", "\177ELF of no machine", 17, 0700);
    rk_helper_call call = {.program = "raykit-alien"};
    answer got = {0};
    rk_check(!rk_helper_run(&call, &got.output, &got.size, &got.error), "it cannot have run");
    rk_check_error_names(got.error, "could not be started");
}

static void the_caller_may_have_closed_its_standard_streams(void **state)
{
    (void)state;
    fflush(NULL);
    int saved_input = dup(0), saved_error = dup(2);
    close(0);
    close(2);
    answer got =
        run_script("cat; echo note >&2", (rk_helper_call){.input = "abc", .input_size = 3});
    dup2(saved_input, 0);
    dup2(saved_error, 2);
    close(saved_input);
    close(saved_error);
    rk_check_ok(got.ok, got.error);
    rk_check_equal(got.size, 3, "abc");
    assert_string_equal(got.error.text, "note");
    free(got.output);
}

static void the_helper_inherits_nothing_but_its_three_streams(void **state)
{
    (void)state;
    if (access("/proc/self/fd", R_OK) != 0)
        return;
    /* Every child inherits the descriptors that make and the terminal left open; popen's child
     * counts them. */
    FILE *list = popen("ls /proc/self/fd | wc -l", "r");
    assert_non_null(list);
    int others = 0;
    rk_check(fscanf(list, "%d", &others) == 1, "ls and wc should count");
    pclose(list);
    answer got = run_script("ls /proc/self/fd | wc -l", (rk_helper_call){0});
    rk_check_ok(got.ok, got.error);
    rk_check_equal(atoi((char *)got.output), others, "a stream of the call leaked into its helper");
    free(got.output);
}

#ifdef __linux__
/* The script keeps the pipe open as long as it lives. */
static void a_helper_ends_with_a_caller_that_is_killed(void **state)
{
    (void)state;
    test_path path = test_folder_path(&folder, "alive");
    rk_check(mkfifo(path.text, 0600) == 0, "a pipe can be made");
    int alive = open(path.text, O_RDONLY | O_NONBLOCK);
    rk_check(alive >= 0, "the pipe can be read");
    pid_t caller = fork();
    if (caller == 0) {
        char script[1000];
        snprintf(script, sizeof script, "exec 9>'%s'; echo started >&9; exec sleep 60", path.text);
        run_script(script, (rk_helper_call){0});
        _exit(0);
    }
    char text[100];
    struct pollfd polled = {alive, POLLIN, 0};
    rk_check(poll(&polled, 1, 30000) == 1 && read(alive, text, sizeof text) > 0, "it started");
    kill(caller, SIGKILL);
    waitpid(caller, NULL, 0);
    polled.revents = 0;
    /* At its end, the pipe is readable and has nothing to read. */
    rk_check(poll(&polled, 1, 10000) == 1 && read(alive, text, sizeof text) == 0,
             "the helper is still alive ten seconds after its caller's death");
    close(alive);
    unlink(path.text);
}
#endif

static void memory_is_limited_and_core_files_are_off(void **state)
{
    (void)state;
    answer got = run_script("ulimit -v; ulimit -c", (rk_helper_call){0});
    rk_check_ok(got.ok, got.error);
    char memory[32] = "", core[32] = "";
    char text[80];
    snprintf(text, sizeof text, "%.*s", (int)got.size, (char *)got.output);
    rk_check(sscanf(text, "%31s %31s", memory, core) == 2, "got %s", text);
#ifndef RK_SANITIZED
    rk_check(strcmp(memory, "unlimited") != 0, "the helper may eat the machine");
#endif
    assert_string_equal(core, "0");
    free(got.output);
}

/* --- helpers that stay --------------------------------------------------------------------- */

/* Answers each word of the input; "bye" ends it. printf writes an rk_helper_answer, little-endian.
 */
static const char patient[] =
    "echo >>starts\n"
    "while read word; do\n"
    "  [ $word = bye ] && { echo it was bye >&2; exit 3; }\n"
    "  [ $word = half ] && { printf '\\005\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0ab'; exit "
    "0; }\n"
    "  [ $word = bad ] && { printf '\\003\\0\\0\\0\\0\\0\\0\\0\\001\\0\\0\\0\\0\\0\\0\\0why'; "
    "continue; }\n"
    "  printf '\\002\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0\\0ok'\n"
    "done\n";

static bool ask(rk_helper **helper, const char *word, size_t most, rk_error *error)
{
    char text[2 * sizeof patient + sizeof folder];
    int length = snprintf(text, sizeof text, "#!/bin/sh\ncd '%s'\n%s", folder.path, patient);
    if (!*helper) /* a file that runs cannot be written */
        test_folder_write(&folder, "patient", text, (size_t)length, 0700);
    const rk_helper_call call = {.program = "patient",
                                 .subject = word,
                                 .input = word,
                                 .input_size = strlen(word),
                                 .output_max = most};
    unsigned char *output;
    size_t size;
    bool ok = rk_helper_ask(helper, &call, &output, &size, error);
    rk_check(ok || !output, "a failed call left a block behind");
    if (ok)
        rk_check(size == 2 && memcmp(output, "ok", 2) == 0, "%zu other bytes came back", size);
    free(output);
    return ok;
}

static size_t count_starts(void)
{
    size_t size = 0;
    free(test_folder_read(test_folder_path(&folder, "starts"), &size));
    return size;
}

static void a_helper_that_stays_is_started_once(void **state)
{
    (void)state;
    rk_helper *helper = NULL;
    rk_error error;
    for (int i = 0; i < 5; i++)
        rk_check(ask(&helper, "word\n", 100, &error), "%s", error.text);
    rk_check(!ask(&helper, "bad\n", 100, &error), "a reason was taken for an answer");
    rk_check(strcmp(error.text, "why") == 0, "not its reason: %s", error.text);
    rk_check(helper, "it has answered, so it stays");
    rk_check(!ask(&helper, "bad\n", 1, &error), "a reason was taken for an answer");
    rk_check(strcmp(error.text, "why") == 0, "a reason may be longer than an answer: %s",
             error.text);
    rk_check(ask(&helper, "word\n", 100, &error), "%s", error.text);
    rk_check_equal(count_starts(), 1, "for eight calls");
    rk_helper_end(&helper);
    rk_check(!helper, "it has ended");
    rk_check(waitpid(-1, NULL, WNOHANG) < 0 && errno == ECHILD, "a child is left");
    rk_helper_end(&helper);
}

static void a_helper_that_ends_too_early_is_started_again(void **state)
{
    (void)state;
    rk_helper *helper = NULL;
    rk_error error;
    const size_t before = count_starts();
    rk_check(ask(&helper, "word\n", 100, &error), "%s", error.text);
    rk_check(!ask(&helper, "bye\n", 100, &error), "it did not answer");
    rk_check_error_names(error, "it was bye");
    rk_check(!helper, "it has ended");
    rk_check(!ask(&helper, "half\n", 100, &error), "half an answer was accepted");
    rk_check_error_names(error, ": patient ended without a whole answer");
    rk_check(ask(&helper, "word\n", 100, &error), "%s", error.text);
    rk_check_equal(count_starts() - before, 3, "one start for each end, and the first");
    rk_helper_end(&helper);
    rk_check(waitpid(-1, NULL, WNOHANG) < 0 && errno == ECHILD, "a child is left");
}

static int make_folder(void **state)
{
    (void)state;
    return !test_folder_make(&folder) || setenv("RAYKIT_HELPERS", folder.path, 1) != 0;
}

static int remove_folder(void **state)
{
    (void)state;
    test_folder_remove(&folder);
    return 0;
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(the_answer_comes_back_byte_for_byte),
    cmocka_unit_test(an_empty_answer_is_an_answer),
    cmocka_unit_test(arguments_arrive_whole),
    cmocka_unit_test(large_input_and_output_pass_without_deadlock),
    cmocka_unit_test(threads_may_call_at_the_same_time),
    cmocka_unit_test(a_long_error_does_not_block_the_output),
    cmocka_unit_test(input_that_nobody_reads_neither_kills_nor_fails),
    cmocka_unit_test(a_failure_gives_its_last_line_as_the_reason),
    cmocka_unit_test(a_failure_without_a_reason_names_the_status_and_the_file),
    cmocka_unit_test(a_note_beside_a_good_answer_is_handed_on),
    cmocka_unit_test(death_by_a_signal_is_an_error_that_names_it),
    cmocka_unit_test(an_answer_may_be_as_long_as_allowed_and_no_longer),
    cmocka_unit_test(silence_ends_after_the_timeout),
    cmocka_unit_test(work_in_progress_is_not_silence),
    cmocka_unit_test(a_missing_program_says_what_to_do),
    cmocka_unit_test(a_folder_and_a_plain_file_are_no_programs),
    cmocka_unit_test(a_program_of_another_kind_is_an_error),
    cmocka_unit_test(the_caller_may_have_closed_its_standard_streams),
    cmocka_unit_test(the_helper_inherits_nothing_but_its_three_streams),
#ifdef __linux__
    cmocka_unit_test(a_helper_ends_with_a_caller_that_is_killed),
#endif
    cmocka_unit_test(memory_is_limited_and_core_files_are_off),
    cmocka_unit_test(a_helper_that_stays_is_started_once),
    cmocka_unit_test(a_helper_that_ends_too_early_is_started_again),
};

RK_SUITE_IN("helper", tests, make_folder, remove_folder)
