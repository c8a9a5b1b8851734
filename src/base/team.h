/* Processes that render a picture together, each with threads of its own: on several machines, by
 * MPI (driver/driver_team.h). The renderer asks for the next tile, and gives its results away for
 * all; how, it need not know. */
#ifndef RK_BASE_TEAM_H
#define RK_BASE_TEAM_H

#include "base/error.h"

#include <stdint.h>

typedef struct rk_team {
    uint32_t process, processes; /* this one, from 0 on, of how many; 0 of 0: there is no team */
    char machine[256];           /* where this one runs */
    void *context;
    bool is_over; /* no exchange follows: the results are complete, or all know of an error */

    /* Returns a number from 0 on that no process has had since the last exchange. A process takes
     * `at_once` of them, as many as it has threads, so that these wait for others but once. Any
     * thread may call it. */
    uint32_t (*next)(void *context, uint32_t at_once);

    /* Gives all processes the elements of each, `size` bytes long, in a new block to free(), in the
     * order of the processes; `total` says how many. Waits for all of them; numbers then begin
     * anew. All call it in the same order with the same size. False with an error if memory is
     * short, or `total` would be. */
    bool (*exchange)(void *context, const void *own, uint32_t count, size_t size, void **all,
                     uint32_t *total, rk_error *error);

    /* Ends this process's part; an abort ends all processes, wherever they are. */
    void (*end)(void *context, bool abort);
} rk_team;

/* What a function that joins a team is called by, see driver/driver_team.h. */
typedef bool rk_team_start(rk_team *team, rk_error *error);

/* Returns whether `ok` is true in all processes; else the error of the first in which it is not,
 * told with its number and its machine, becomes that of all. A team of NULL is a process alone. */
bool rk_team_agree(rk_team *team, bool ok, rk_error *error);

#endif
