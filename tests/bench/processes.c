/* How much faster is --mpi on many machines? A model of it from what is measured on one.
 *
 * The driver is process 0 of a team of one, on one thread, and notes the processor time of each
 * tile, of the work between tiles, which every process of a team does by itself, and the bytes that
 * are exchanged. From these follows for R processes of one thread each
 *
 *     T(R) = start + alone + sum over passes of P(R) + (R - 1) (B / R / bandwidth + delay)
 *
 *   start  the scene and its tree
 *   alone  the work between tiles: circles of confusion, plans of rounds, bloom
 *   P(R)   until the last process has finished: each takes the next tile, `take` later, in turn
 *   B      bytes of all tiles, which go round in R - 1 steps, as MPI_Allgatherv sends much
 *
 * It knows no machines of different speed, no other traffic, and no queue at process 0. */
#include "driver/driver_options.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { most_tiles = 1 << 20, most_passes = 64, most_processes = 64 };

typedef struct network {
    double bandwidth; /* bytes per second */
    double delay;     /* seconds, of a message */
    double take;      /* seconds, until a process has its next tile */
} network;

/* A gigabit a second, and one that costs nothing: what then is lost, is lost by tiles and by what
 * each process does by itself. */
static const network ordinary = {125e6, 100e-6, 300e-6}, perfect = {(double)INFINITY, 0, 0};

typedef struct pass {
    uint32_t first, tiles; /* in `seconds` */
    double bytes;
} pass;

typedef struct notes {
    double *seconds; /* of each tile of all passes */
    uint32_t tiles, next, pass_count;
    bool in_tile;
    double last; /* of the clock: the end of the last tile, or of an exchange */
    double alone;
    pass passes[most_passes];
} notes;

/* Of this process, in seconds. */
static double processor_time(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + (double)now.tv_nsec * 1e-9;
}

/* The time since the last note is that of a tile, or of the work between tiles. */
static double since_last(notes *n)
{
    const double now = processor_time(), seconds = now - n->last;
    n->last = now;
    return seconds;
}

/* --- A team of one ---------------------------------------------------------------------------- */

static uint32_t next_number(void *context, uint32_t at_once)
{
    (void)at_once;
    notes *n = context;
    const double seconds = since_last(n);
    if (!n->in_tile)
        n->alone += seconds;
    else if (n->tiles < most_tiles)
        n->seconds[n->tiles++] = seconds;
    n->in_tile = true;
    return n->next++;
}

/* A pass ends by a tile that there is not, which took no time, and by two exchanges: the tiles, and
 * then the counters. */
static bool exchange(void *context, const void *own, uint32_t count, size_t size, void **all,
                     uint32_t *total, rk_error *error)
{
    notes *n = context;
    n->alone += since_last(n);
    if (n->in_tile && n->pass_count < most_passes) {
        const pass *before = n->pass_count > 0 ? &n->passes[n->pass_count - 1] : NULL;
        const uint32_t first = before ? before->first + before->tiles : 0;
        n->passes[n->pass_count++] = (pass){first, n->tiles - first, (double)count * (double)size};
    }
    n->in_tile = false;
    n->next = 0;
    *total = count;
    *all = rk_allocate_unset(count, size, "tiles", error);
    if (*all)
        memcpy(*all, own, count * size);
    since_last(n);
    return *all != NULL;
}

/* --- The model -------------------------------------------------------------------------------- */

/* Seconds until the last of the processes has no more tiles. */
static double finish_of(const notes *n, const pass *p, uint32_t processes, double take)
{
    double ready[most_processes] = {0}, last = 0;
    for (uint32_t i = 0; i < p->tiles; i++) {
        uint32_t next = 0;
        for (uint32_t k = 1; k < processes; k++)
            if (ready[k] < ready[next])
                next = k;
        ready[next] += take + n->seconds[p->first + i];
        last = ready[next] > last ? ready[next] : last;
    }
    return last;
}

/* One process needs no network. */
static double picture_of(const notes *n, uint32_t processes, const network *by)
{
    const network *used = processes > 1 ? by : &perfect;
    const double r = processes;
    double sum = n->alone;
    for (uint32_t i = 0; i < n->pass_count; i++)
        sum += finish_of(n, &n->passes[i], processes, used->take) +
               (r - 1) * (n->passes[i].bytes / r / used->bandwidth + used->delay);
    return sum;
}

static void print_model(const notes *n, double start)
{
    double longest = 0, bytes = 0;
    for (uint32_t i = 0; i < n->tiles; i++)
        longest = n->seconds[i] > longest ? n->seconds[i] : longest;
    for (uint32_t i = 0; i < n->pass_count; i++)
        bytes += n->passes[i].bytes;
    const double one = picture_of(n, 1, &perfect);
    printf("start %.3f s, alone %.3f s, %u passes, %u tiles of %.3f ms on average and %.3f ms at "
           "most, %.1f MB\n",
           start, n->alone, n->pass_count, n->tiles,
           n->tiles > 0 ? 1e3 * (one - n->alone) / n->tiles : 0, 1e3 * longest, bytes / 1e6);
    printf("%9s %10s %7s %11s %16s\n", "processes", "picture s", "faster", "with start",
           "perfect network");
    for (uint32_t r = 1; r <= most_processes; r *= 2) {
        const double many = picture_of(n, r, &ordinary);
        printf("%9u %10.3f %7.2f %11.2f %16.2f\n", r, many, one / many,
               (start + one) / (start + many), one / picture_of(n, r, &perfect));
    }
}

static bool measure(rk_driver *driver, double start, rk_error *error)
{
    notes n = {.seconds = rk_allocate(most_tiles, sizeof *n.seconds, "times", error)};
    rk_team team = {.processes = 1, .context = &n, .next = next_number, .exchange = exchange};
    if (!n.seconds)
        return false;
    rk_pool_join(driver->pool, &team);
    n.last = processor_time();
    bool ok = rk_driver_render(driver, error);
    n.alone += since_last(&n);
    if (ok && (n.tiles == most_tiles || n.pass_count == most_passes))
        ok = rk_fail(error, "too many tiles: take a smaller picture, or fewer samples");
    if (ok)
        print_model(&n, start);
    free(n.seconds);
    return ok;
}

int main(int argc, char **argv)
{
    static const rk_driver_spec spec = {
        .feature = "processes",
        .summary = "Measures a picture's tiles, and says how long 1 to 64 processes would take.\n",
    };
    rk_error error = {""};
    rk_driver driver = rk_driver_default(spec.feature, spec.summary);
    rk_driver_set_defaults(&driver, &spec);
    const rk_options_result result = rk_driver_read_options(&driver, &spec, argc, argv, &error);
    driver.threads = 1;
    const bool ok = result == RK_OPTIONS_OK && rk_driver_start(&driver, &error) &&
                    rk_driver_build(&driver, &error) && measure(&driver, processor_time(), &error);
    return rk_driver_finish(&driver, ok || result == RK_OPTIONS_DONE, &error);
}
