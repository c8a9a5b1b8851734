/* Waiting for another process: first by looking, then asleep. On Linux, by its futexes. */
#define _GNU_SOURCE /* for syscall */
#include "judge/protocol.h"

#include <linux/futex.h>
#include <sched.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

enum { LOOKS = 200 };

void rk_judge_wait(const _Atomic uint32_t *word, uint32_t seen, _Atomic uint32_t *is_waiting)
{
    for (int look = 0; look < LOOKS; look++)
        if (atomic_load_explicit(word, memory_order_acquire) != seen)
            return;
    sched_yield();
    atomic_fetch_add(is_waiting, 1);
    /* It looks again itself, after is_waiting was set; the limit lets the caller look around. */
    syscall(SYS_futex, word, FUTEX_WAIT, seen, &(struct timespec){.tv_nsec = 20000000}, NULL, 0);
    atomic_fetch_sub(is_waiting, 1);
}

void rk_judge_wake(const _Atomic uint32_t *word, const _Atomic uint32_t *is_waiting)
{
    atomic_thread_fence(memory_order_seq_cst);
    if (atomic_load(is_waiting))
        syscall(SYS_futex, word, FUTEX_WAKE, INT32_MAX, NULL, NULL, 0);
}
