/* raykit-mpi.so: a team of base/team.h by MPI, for driver/driver_team.h, which loads it.
 *
 * The numbers come from a counter in a window of process 0, which the others increase from afar.
 * Where a network cannot do that by itself, process 0 has to look after it, so a thread of it does,
 * some thousand times a second. One lock makes all threads call MPI in turn. Source: MPI: A
 * Message-Passing Interface Standard, version 3.1, chapters 5, 11 and 12. */
#include "base/team.h"

#include <mpi.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct mpi_team {
    pthread_mutex_t lock;
    int process, processes;
    MPI_Win window;
    uint32_t *counters; /* in the window: two, which take turns */
    uint32_t exchanges;
    uint32_t next, end; /* numbers that this process has, and no thread yet */
    pthread_t attendant;
    bool has_attendant;
    atomic_bool stops;
} mpi_team;

static bool fail(rk_error *error, const char *text)
{
    snprintf(error->text, sizeof error->text, "--mpi: %s", text);
    return false;
}

/* --- Numbers ---------------------------------------------------------------------------------- */

/* Returns the present counter of process 0, and changes it. */
static uint32_t change_counter(mpi_team *t, uint32_t number, MPI_Op operation)
{
    uint32_t before = 0;
    MPI_Fetch_and_op(&number, &before, MPI_UINT32_T, 0, (MPI_Aint)(t->exchanges % 2), operation,
                     t->window);
    MPI_Win_flush(0, t->window);
    return before;
}

static uint32_t next_number(void *context, uint32_t at_once)
{
    mpi_team *t = context;
    pthread_mutex_lock(&t->lock);
    if (t->next == t->end) {
        t->next = change_counter(t, at_once, MPI_SUM);
        t->end = t->next + at_once;
    }
    const uint32_t number = t->next++;
    pthread_mutex_unlock(&t->lock);
    return number;
}

/* All have entered the exchange, so nobody takes from the old counter any more. Nobody will before
 * the next exchange, which takes process 0. */
static void begin_numbers_anew(mpi_team *t)
{
    if (t->process == 0)
        change_counter(t, 0, MPI_REPLACE);
    t->exchanges++;
    t->next = t->end = 0;
}

static const struct timespec nap = {0, 100000}; /* nanoseconds */

static void *attend(void *context)
{
    mpi_team *t = context;
    while (!t->stops) {
        int flag;
        pthread_mutex_lock(&t->lock);
        MPI_Iprobe(MPI_ANY_SOURCE, MPI_ANY_TAG, MPI_COMM_WORLD, &flag, MPI_STATUS_IGNORE);
        pthread_mutex_unlock(&t->lock);
        nanosleep(&nap, NULL);
    }
    return NULL;
}

/* --- Exchange --------------------------------------------------------------------------------- */

/* Fills in where the elements of each process go. */
static bool find_places(const mpi_team *t, const int *counts, int *places, uint32_t *total)
{
    uint64_t sum = 0;
    for (int i = 0; i < t->processes; i++) {
        places[i] = (int)sum;
        sum += (uint64_t)counts[i];
    }
    *total = (uint32_t)sum;
    return sum <= INT32_MAX;
}

static bool gather(mpi_team *t, const void *own, int count, size_t size, int *counts, int *places,
                   void **all, uint32_t *total, rk_error *error)
{
    MPI_Datatype element;
    MPI_Allgather(&count, 1, MPI_INT, counts, 1, MPI_INT, MPI_COMM_WORLD);
    if (size > INT32_MAX || !find_places(t, counts, places, total))
        return fail(error, "the picture is too large for its messages");
    *all = malloc(*total * size + 1);
    if (!*all)
        return fail(error, "no memory for the picture's tiles: close other programs");
    MPI_Type_contiguous((int)size, MPI_BYTE, &element);
    MPI_Type_commit(&element);
    MPI_Allgatherv(own, count, element, *all, counts, places, element, MPI_COMM_WORLD);
    MPI_Type_free(&element);
    return true;
}

static bool exchange(void *context, const void *own, uint32_t count, size_t size, void **all,
                     uint32_t *total, rk_error *error)
{
    mpi_team *t = context;
    int *counts = malloc(2 * (size_t)t->processes * sizeof *counts);
    if (!counts)
        return fail(error, "no memory: close other programs");
    pthread_mutex_lock(&t->lock);
    const bool ok =
        gather(t, own, (int)count, size, counts, counts + t->processes, all, total, error);
    begin_numbers_anew(t);
    pthread_mutex_unlock(&t->lock);
    free(counts);
    return ok;
}

/* --- Beginning and ending --------------------------------------------------------------------- */

static void end(void *context, bool abort)
{
    mpi_team *t = context;
    if (abort)
        MPI_Abort(MPI_COMM_WORLD, 1);
    t->stops = true;
    if (t->has_attendant)
        pthread_join(t->attendant, NULL);
    MPI_Win_unlock_all(t->window);
    MPI_Win_free(&t->window);
    MPI_Finalize();
}

static void make_window(mpi_team *t)
{
    const size_t counters = t->process == 0 ? 2 : 0;
    MPI_Win_allocate((MPI_Aint)(counters * sizeof *t->counters), sizeof *t->counters, MPI_INFO_NULL,
                     MPI_COMM_WORLD, &t->counters, &t->window);
    for (size_t i = 0; i < counters; i++)
        t->counters[i] = 0;
    MPI_Barrier(MPI_COMM_WORLD);
    MPI_Win_lock_all(MPI_MODE_NOCHECK, t->window);
}

rk_team_start rk_mpi_start;

bool rk_mpi_start(rk_team *team, rk_error *error)
{
    static mpi_team t = {.lock = PTHREAD_MUTEX_INITIALIZER}; /* MPI is there once */
    int provided = MPI_THREAD_SINGLE, length;
    char machine[MPI_MAX_PROCESSOR_NAME] = "";
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_SERIALIZED, &provided) != MPI_SUCCESS)
        return fail(error, "MPI could not be started: try mpirun -n 1 hostname");
    MPI_Comm_rank(MPI_COMM_WORLD, &t.process);
    MPI_Comm_size(MPI_COMM_WORLD, &t.processes);
    MPI_Get_processor_name(machine, &length);
    if (provided < MPI_THREAD_SERIALIZED) {
        team->process = (uint32_t)t.process;
        MPI_Finalize();
        return fail(error, "this MPI serves one thread alone, which MPI_THREAD_SERIALIZED is not");
    }
    make_window(&t);
    t.has_attendant =
        t.process == 0 && t.processes > 1 && pthread_create(&t.attendant, NULL, attend, &t) == 0;
    *team = (rk_team){.process = (uint32_t)t.process,
                      .processes = (uint32_t)t.processes,
                      .context = &t,
                      .next = next_number,
                      .exchange = exchange,
                      .end = end};
    snprintf(team->machine, sizeof team->machine, "%.255s", machine);
    return true;
}
