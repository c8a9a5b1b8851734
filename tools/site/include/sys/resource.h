/* Times of processes, for tests/suite.c's RAYKIT_TIMES: a page has none. */
#ifndef SITE_RESOURCE_H
#define SITE_RESOURCE_H

#include <sys/time.h>

enum { RUSAGE_SELF, RUSAGE_CHILDREN };

struct rusage {
    struct timeval ru_utime, ru_stime;
};

int getrusage(int who, struct rusage *used);

#endif
