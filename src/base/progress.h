/* A progress bar on standard error if it is a terminal; elsewhere nothing, or a line now and then.
 */
#ifndef RK_BASE_PROGRESS_H
#define RK_BASE_PROGRESS_H

#include <stdbool.h>

#ifdef __cplusplus
#include <atomic>
using std::atomic_flag;
using std::atomic_uint;
#else
#include <stdatomic.h>
#endif

typedef struct rk_progress {
    bool visible;
    bool in_lines; /* not a bar */
    const char *label;
    unsigned total;
    atomic_uint done;
    double started, drawn; /* rk_clock_wall */
    atomic_flag drawing;
} rk_progress;

/* `quiet` keeps it invisible. */
void rk_progress_start(rk_progress *progress, const char *label, unsigned total, bool quiet);

/* Where there is no terminal, as of processes of mpirun: a line with the percentage every ten
 * seconds. After rk_progress_start. */
void rk_progress_in_lines(rk_progress *progress, bool quiet);

/* Shows a label for work that has no steps to count, such as building a tree, until
 * rk_progress_end. */
void rk_progress_say(rk_progress *progress, const char *label, bool quiet);

/* Counts one more item as done; any thread may call it. Draws at most ten times a second, and not
 * within the first half second: short work needs no bar. */
void rk_progress_step(rk_progress *progress);

/* The same for several items. */
void rk_progress_steps(rk_progress *progress, unsigned steps);

/* Clears the bar. */
void rk_progress_end(rk_progress *progress);

#endif
