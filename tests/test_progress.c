/* Progress: visible on a terminal (a pseudo-terminal here), silent elsewhere, cleared at the
 * end. */
#include "test.h"

#include "base/parallel.h"
#include "base/progress.h"
#include "base/table.h"

#include <fcntl.h>
#include <termios.h>
#include <unistd.h>

/* Standard error, redirected for the test to read. */
typedef struct capture {
    int kept, reader;
    char text[8192];
} capture;

static capture show_on(int reader, int writer)
{
    capture screen = {.kept = dup(STDERR_FILENO), .reader = reader};
    fflush(stderr);
    dup2(writer, STDERR_FILENO);
    close(writer);
    fcntl(reader, F_SETFL, O_NONBLOCK);
    return screen;
}

static capture open_terminal(void)
{
    int terminal = posix_openpt(O_RDWR | O_NOCTTY);
    rk_check(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0,
             "a pseudo-terminal");
    int writer = open(ptsname(terminal), O_RDWR | O_NOCTTY);
    rk_check(writer >= 0, "its other end");
    return show_on(terminal, writer);
}

static capture open_pipe(void)
{
    int ends[2];
    rk_check(pipe(ends) == 0, "a pipe");
    return show_on(ends[0], ends[1]);
}

/* Appends the output since the last call; returns its length. */
static size_t read_screen(capture *screen)
{
    size_t length = strlen(screen->text), before = length;
    ssize_t got;
    while ((got = read(screen->reader, screen->text + length, sizeof screen->text - 1 - length)) >
           0)
        length += (size_t)got;
    screen->text[length] = '\0';
    return length - before;
}

static void close_screen(capture *screen)
{
    fflush(stderr);
    read_screen(screen);
    dup2(screen->kept, STDERR_FILENO);
    close(screen->kept);
    close(screen->reader);
}

/* The visible line on the screen: carriage returns go back, letters overwrite. */
static void last_line(const char *text, char line[256])
{
    memset(line, ' ', 255);
    line[255] = '\0';
    for (size_t column = 0; *text; text++)
        if (*text == '\r' || *text == '\n')
            column = 0;
        else if (column < 255)
            line[column++] = *text;
    for (size_t end = 255; end > 0 && line[end - 1] == ' '; end--)
        line[end - 1] = '\0';
}

/* Pretends that the work began, and the bar was drawn, `seconds` earlier. */
static void let_time_pass(rk_progress *progress, double seconds)
{
    progress->started -= seconds;
    progress->drawn -= progress->drawn > 0 ? seconds : 0;
}

static void a_terminal_shows_label_and_percentage(void **state)
{
    (void)state;
    capture screen = open_terminal();
    rk_progress progress;
    rk_progress_start(&progress, "rendering", 4, false);
    let_time_pass(&progress, 1);
    rk_progress_step(&progress);
    read_screen(&screen);
    char line[256];
    last_line(screen.text, line);
    rk_progress_end(&progress);
    close_screen(&screen);
    rk_check(strstr(line, "rendering") && strstr(line, "25%"), "one of four shows as: %s", line);
}

static void the_bar_grows_and_clears_itself(void **state)
{
    (void)state;
    capture screen = open_terminal();
    rk_progress progress;
    char line[256], first[256];
    rk_progress_start(&progress,
                      "a label that is longer than a line of a terminal would ever be, in "
                      "truth, so that it is truncated",
                      4, false);
    for (int i = 0; i < 4; i++) {
        let_time_pass(&progress, 1);
        rk_progress_step(&progress);
        read_screen(&screen);
        last_line(screen.text, i ? line : first);
    }
    rk_progress_end(&progress);
    read_screen(&screen);
    char cleared[256];
    last_line(screen.text, cleared);
    close_screen(&screen);
    rk_check(strstr(line, "100%"), "four of four: %s", line);
    rk_check(strlen(line) < 80, "a bar of %zu columns would wrap", strlen(line));
    size_t filled[2] = {0, 0};
    for (int i = 0; i < 256; i++)
        filled[0] += first[i] == '#', filled[1] += line[i] == '#';
    rk_check(filled[0] > 0 && filled[1] == 4 * filled[0], "%zu marks grew to %zu", filled[0],
             filled[1]);
    rk_check(cleared[0] == '\0', "left behind: %s", cleared);
    rk_check(screen.text[strlen(screen.text) - 1] == '\r', "the next line begins at the left");
    rk_check(!strchr(screen.text, '\n'), "the screen does not scroll");
}

static void short_work_shows_nothing(void **state)
{
    (void)state;
    capture screen = open_terminal();
    rk_progress progress;
    rk_progress_start(&progress, "rendering", 4, false);
    let_time_pass(&progress, 0.4);
    for (int i = 0; i < 4; i++)
        rk_progress_step(&progress);
    rk_progress_end(&progress);
    close_screen(&screen);
    rk_check(screen.text[0] == '\0', "half a second needs no bar: %s", screen.text);
}

static void the_bar_is_drawn_at_most_ten_times_a_second(void **state)
{
    (void)state;
    capture screen = open_terminal();
    rk_progress progress;
    rk_progress_start(&progress, "rendering", 1000000, false);
    let_time_pass(&progress, 1);
    double begin = rk_clock_wall();
    while (rk_clock_wall() - begin < 0.25)
        rk_progress_step(&progress);
    const double tenths = 10 * (rk_clock_wall() - begin);
    read_screen(&screen);
    close_screen(&screen);
    int draws = 0;
    for (const char *c = screen.text; *c; c++)
        draws += *c == '\r';
    /* At 0, .1 and .2 s; fewer, or later ones, on a machine that stalls. */
    rk_check(draws >= 1 && (double)draws <= 1 + tenths, "drawn %d times in %.2g s", draws,
             tenths / 10);
}

static void pipes_and_quiet_terminals_stay_silent(void **state)
{
    (void)state;
    for (int quiet = 0; quiet < 2; quiet++) {
        capture screen = quiet ? open_terminal() : open_pipe();
        rk_progress progress;
        rk_progress_start(&progress, "rendering", 4, quiet);
        for (int i = 0; i < 4; i++) {
            let_time_pass(&progress, 1);
            rk_progress_step(&progress);
        }
        rk_progress_end(&progress);
        close_screen(&screen);
        rk_check(screen.text[0] == '\0', "%s shows: %s", quiet ? "--quiet" : "a pipe", screen.text);
        rk_check_equal(progress.done, 4, "the items are counted all the same");
    }
}

static void more_steps_than_announced_end_at_the_full_bar(void **state)
{
    (void)state;
    const unsigned totals[] = {0, 1};
    for (int i = 0; i < 2; i++) {
        capture screen = open_terminal();
        rk_progress progress;
        rk_progress_start(&progress, "rendering", totals[i], false);
        for (int k = 0; k < 3; k++) {
            let_time_pass(&progress, 1);
            rk_progress_step(&progress);
        }
        read_screen(&screen);
        char line[256];
        last_line(screen.text, line);
        rk_progress_end(&progress);
        close_screen(&screen);
        rk_check(strstr(line, "100%") && !strstr(screen.text, "300%"), "3 of %u: %s", totals[i],
                 line);
    }
}

static void step_once(uint32_t index, uint32_t thread, void *context)
{
    (void)index, (void)thread;
    rk_progress_step(context);
}

static void steps_from_many_threads_all_count(void **state)
{
    (void)state;
    capture screen = open_terminal();
    rk_error error = {""};
    rk_pool *pool = rk_pool_start(4, &error);
    rk_progress progress;
    rk_progress_start(&progress, "rendering", 20000, false);
    let_time_pass(&progress, 1);
    if (pool)
        rk_pool_run(pool, 20000, step_once, &progress);
    rk_progress_end(&progress);
    rk_pool_stop(pool);
    close_screen(&screen);
    rk_check_ok(pool != NULL, error);
    rk_check_equal(progress.done, 20000, "no step is lost");
    rk_check(screen.text[0] == '\r', "the bar was drawn");
}

static void a_pipe_gets_a_line_every_ten_seconds_if_wanted(void **state)
{
    (void)state;
    capture screen = open_pipe();
    rk_progress progress;
    rk_progress_start(&progress, "rendering", 8, false);
    rk_progress_in_lines(&progress, false);
    rk_progress_steps(&progress, 2);
    let_time_pass(&progress, 11);
    rk_progress_steps(&progress, 2);
    rk_progress_step(&progress);
    let_time_pass(&progress, 11);
    rk_progress_step(&progress);
    rk_progress_end(&progress);
    rk_progress_start(&progress, "rendering", 8, true);
    rk_progress_in_lines(&progress, true);
    let_time_pass(&progress, 11);
    rk_progress_step(&progress);
    rk_progress_end(&progress);
    close_screen(&screen);
    rk_check(strcmp(screen.text, "rendering: 50%\nrendering: 75%\n") == 0, "got: %s", screen.text);
}

static const struct CMUnitTest tests[] = {
    cmocka_unit_test(a_terminal_shows_label_and_percentage),
    cmocka_unit_test(the_bar_grows_and_clears_itself),
    cmocka_unit_test(short_work_shows_nothing),
    cmocka_unit_test(the_bar_is_drawn_at_most_ten_times_a_second),
    cmocka_unit_test(pipes_and_quiet_terminals_stay_silent),
    cmocka_unit_test(more_steps_than_announced_end_at_the_full_bar),
    cmocka_unit_test(a_pipe_gets_a_line_every_ten_seconds_if_wanted),
    cmocka_unit_test(steps_from_many_threads_all_count),
};

RK_SUITE("progress", tests)
