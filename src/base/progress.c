/* Threads count steps by an atomic number; the one that gets the flag draws, at most ten times a
 * second, so that none waits for the terminal. */
#include "base/progress.h"

#include "base/table.h"

#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const double first_draw = 0.5, draw_interval = 0.1; /* seconds */

/* A label of up to 32 columns, the bar and the percentage fit 80 columns: a carriage return can
 * only redraw a single line. */
enum { label_width = 32, bar_width = 32, line_width = 1 + label_width + 2 + bar_width + 2 + 5 };

void rk_progress_start(rk_progress *progress, const char *label, unsigned total, bool quiet)
{
    progress->visible = !quiet && isatty(STDERR_FILENO);
    progress->label = label;
    progress->total = total;
    atomic_init(&progress->done, 0);
    progress->started = rk_clock_wall();
    progress->drawn = 0;
    atomic_flag_clear(&progress->drawing);
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
    unsigned done = atomic_fetch_add(&progress->done, 1) + 1;
    if (!progress->visible)
        return;
    double now = rk_clock_wall();
    if (now - progress->started < first_draw || atomic_flag_test_and_set(&progress->drawing))
        return;
    if (now - progress->drawn >= draw_interval) {
        draw(progress, done);
        progress->drawn = now;
    }
    atomic_flag_clear(&progress->drawing);
}

void rk_progress_end(rk_progress *progress)
{
    if (progress->visible && progress->drawn > 0) {
        fprintf(stderr, "\r%*s\r", line_width, "");
        fflush(stderr);
    }
    progress->visible = false;
}
