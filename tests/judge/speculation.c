#define _GNU_SOURCE /* for MAP_ANONYMOUS */
#include "judge/speculation.h"
#include "judge/held.h"
#include "judge/kept.h"
#include "judge/published.h"
#include "judge/requests.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

static struct shared {
    _Atomic uint32_t is_wrong, fork_waits;
} * shared;

static pid_t fallback; /* the fork that waits */

void rk_judge_prepare_speculation(void)
{
    shared = mmap(NULL, sizeof *shared, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (shared == MAP_FAILED) {
        perror("no memory for a judge that speculates");
        exit(2);
    }
}

bool rk_judge_was_wrong(void)
{
    return shared->is_wrong;
}

bool rk_judge_may_speculate(const rk_judge_request *head)
{
    return !shared->is_wrong && (rk_judge_noted >> head->function & 1) != 0 &&
           rk_judge_can_hold(head) &&
           !rk_judge_lap_is_full(2 * RK_JUDGE_HELD_MAX + RK_JUDGE_KEPT_SLOTS);
}

static void wait_as_fallback(pid_t parent)
{
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent)
        _exit(2);
    while (!shared->is_wrong)
        rk_judge_wait(&shared->is_wrong, 0, &shared->fork_waits);
    rk_judge_forget_held();
}

bool rk_judge_begin_speculation(void)
{
    pid_t parent = getpid();
    fallback = fork();
    if (fallback == 0)
        wait_as_fallback(parent);
    rk_judge.predicts = rk_judge.speculates = fallback > 0;
    return rk_judge.speculates;
}

void rk_judge_end_speculation(void)
{
    static bool ends; /* also where the unit's process has ended, and no answer will come */
    if (ends)
        rk_judge_retreat();
    ends = true;
    rk_judge_settle_all();
    rk_judge_skip_published();
    ends = false;
    kill(fallback, SIGKILL);
    waitpid(fallback, NULL, 0);
    rk_judge.predicts = rk_judge.speculates = false;
}

void rk_judge_retreat(void)
{
    rk_judge_wake_readers();
    shared->is_wrong = 1;
    rk_judge_wake(&shared->is_wrong, &shared->fork_waits);
    int status = 0;
    waitpid(fallback, &status, 0);
    if (WIFSIGNALED(status)) {
        signal(WTERMSIG(status), SIG_DFL);
        raise(WTERMSIG(status));
    }
    _exit(WIFEXITED(status) ? WEXITSTATUS(status) : 2);
}
