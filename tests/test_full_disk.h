/* A full disk for tests: files may not grow beyond `bytes`, as if the disk ended there. */
#ifndef RK_TESTS_TEST_FULL_DISK_H
#define RK_TESTS_TEST_FULL_DISK_H

#include "test.h"

#include <signal.h>
#include <sys/resource.h>

static struct rlimit disk_before;

static inline void fill_disk(unsigned bytes)
{
    signal(SIGXFSZ, SIG_IGN);
    rk_check(getrlimit(RLIMIT_FSIZE, &disk_before) == 0, "the limit can be read");
    struct rlimit full = {bytes, disk_before.rlim_max};
    rk_check(setrlimit(RLIMIT_FSIZE, &full) == 0, "the limit can be set");
}

static inline void free_disk(void)
{
    setrlimit(RLIMIT_FSIZE, &disk_before);
    signal(SIGXFSZ, SIG_DFL);
}

#endif
