/* What it costs to read a file, helper program included: measured in a child process, because
 * getrusage's peak is that of all ended children. */
#ifndef RK_TESTS_TEST_COST_H
#define RK_TESTS_TEST_COST_H

#include "test.h"

#include "base/error.h"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

typedef struct test_cost {
    double seconds;   /* of processor time, whatever else the machine does */
    double megabytes; /* of memory at most: the helper's, or what reading added to this process */
    bool ok;
    rk_error error;
} test_cost;

static inline double test_seconds_of(const struct rusage *use)
{
    return (double)(use->ru_utime.tv_sec + use->ru_stime.tv_sec) +
           1e-6 * (double)(use->ru_utime.tv_usec + use->ru_stime.tv_usec);
}

/* `read` reads the file and frees what it read. */
static inline test_cost test_cost_of(bool (*read_file)(const char *path, rk_error *error),
                                     const char *path)
{
    int ends[2];
    test_cost cost = {0};
    rk_check(pipe(ends) == 0, "no pipe");
    pid_t child = fork();
    rk_check(child >= 0, "no process");
    if (child == 0) {
        struct rusage before, own, helper;
        getrusage(RUSAGE_SELF, &before);
        cost.ok = read_file(path, &cost.error);
        getrusage(RUSAGE_SELF, &own);
        getrusage(RUSAGE_CHILDREN, &helper);
        long kilobytes = own.ru_maxrss - before.ru_maxrss;
        if (helper.ru_maxrss > kilobytes)
            kilobytes = helper.ru_maxrss;
        cost.seconds = test_seconds_of(&own) - test_seconds_of(&before) + test_seconds_of(&helper);
        cost.megabytes = (double)kilobytes / 1024;
        _exit(write(ends[1], &cost, sizeof cost) != sizeof cost);
    }
    rk_check(read(ends[0], &cost, sizeof cost) == sizeof cost, "%s: the reader died", path);
    close(ends[0]), close(ends[1]);
    waitpid(child, NULL, 0);
    return cost;
}

/* Sanitizers have memory of their own. */
static inline void test_check_cost(const char *path, const test_cost *cost, double megabytes,
                                   double seconds)
{
#ifndef RK_SANITIZED
    rk_check(cost->megabytes <= megabytes, "%s: took %.0f MB, at most %.0f are allowed", path,
             cost->megabytes, megabytes);
#else
    (void)megabytes;
    seconds *= 10;
#endif
    rk_check(cost->seconds <= seconds, "%s: took %.1f s of processor time, at most %g are allowed",
             path, cost->seconds, seconds);
}

#endif
