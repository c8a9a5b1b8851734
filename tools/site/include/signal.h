/* The signals that suites handle: faults of memory that tools/site/memory.c finds. */
#ifndef SITE_SIGNAL_H
#define SITE_SIGNAL_H

enum { SIGBUS = 7, SIGSEGV = 11 };
enum { SA_SIGINFO = 4, SA_NODEFER = 0x40000000 };

typedef struct siginfo_t {
    void *si_addr;
} siginfo_t;

struct sigaction {
    void (*sa_sigaction)(int signal, siginfo_t *info, void *context);
    int sa_flags;
};

int sigaction(int signal, const struct sigaction *now, struct sigaction *before);

#endif
