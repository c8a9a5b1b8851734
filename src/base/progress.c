/* Threads count steps by an atomic number; the one that gets the flag draws, at most ten times a
 * second, so that none waits for the terminal. */
#include "base/progress.h"

#include "base/table.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const double first_draw = 0.5, draw_interval = 0.1; /* seconds */
static const double line_interval = 10;                    /* also before the first line */

/* A label of up to 32 columns, the bar and the percentage fit 80 columns: a carriage return can
 * only redraw a single line. */
enum { label_width = 32, bar_width = 32, line_width = 1 + label_width + 2 + bar_width + 2 + 5 };

void rk_progress_start(rk_progress *progress, const char *label, unsigned total, bool quiet)
{
    progress->visible = !quiet && isatty(STDERR_FILENO);
    progress->in_lines = false;
    progress->label = label;
    progress->total = total;
    atomic_init(&progress->done, 0);
    progress->started = rk_clock_wall();
    progress->drawn = 0;
    atomic_flag_clear(&progress->drawing);
}

void rk_progress_in_lines(rk_progress *progress, bool quiet)
{
    progress->in_lines = !quiet && !progress->visible;
    progress->visible = progress->visible || progress->in_lines;
}

void rk_progress_say(rk_progress *progress, const char *label, bool quiet)
{
    rk_progress_start(progress, label, 0, quiet);
    if (!progress->visible)
        return;
    fprintf(stderr, "\r%.*s ...", label_width, label);
    fflush(stderr);
    progress->drawn = rk_clock_wall();
}

static void draw(const rk_progress *progress, unsigned done)
{
    unsigned total = progress->total > done ? progress->total : done;
    double part = (double)done / total; /* done is at least 1 */
    if (progress->in_lines) {
        fprintf(stderr, "%.*s: %d%%\n", label_width, progress->label, (int)(part * 100));
        return;
    }
    int filled = (int)(part * bar_width);
    char bar[bar_width + 1];
    memset(bar, '.', bar_width);
    memset(bar, '#', (size_t)filled);
    bar[bar_width] = '\0';
    fprintf(stderr, "\r%.*s [%s] %3d%%", label_width, progress->label, bar, (int)(part * 100));
    fflush(stderr);
}

void rk_progress_step(rk_progress *progress)
{
    rk_progress_steps(progress, 1);
}

void rk_progress_steps(rk_progress *progress, unsigned steps)
{
    unsigned done = atomic_fetch_add(&progress->done, steps) + steps;
    if (!progress->visible || done == 0)
        return;
    const double now = rk_clock_wall();
    const double first = progress->in_lines ? line_interval : first_draw;
    if (now - progress->started < first || atomic_flag_test_and_set(&progress->drawing))
        return;
    if (now - progress->drawn >= (progress->in_lines ? line_interval : draw_interval)) {
        draw(progress, done);
        progress->drawn = now;
    }
    atomic_flag_clear(&progress->drawing);
}

void rk_progress_end(rk_progress *progress)
{
    if (progress->visible && !progress->in_lines && progress->drawn > 0) {
        fprintf(stderr, "\r%*s\r", line_width, "");
        fflush(stderr);
    }
    progress->visible = false;
}
